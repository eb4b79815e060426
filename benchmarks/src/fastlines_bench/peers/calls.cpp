// Loops that ask the library for one ray per call, through its C++ and its C interface (peers/calls.py compiles them).
#include <fastlines/fastlines.h>
#include <cstring>
#include <fastlines/fastlines.hpp>

namespace {

struct Batch {
  std::size_t n;
  const float *origins, *directions;
  float t_min, t_max, radius;

  fl::Ray ray(std::size_t i) const {
    const float *o = origins + 3 * i, *d = directions + 3 * i;
    return {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, t_min, t_max};
  }
  fl_ray c_ray(std::size_t i) const {
    fl_ray ray;
    std::memcpy(ray.origin, origins + 3 * i, sizeof ray.origin);
    std::memcpy(ray.direction, directions + 3 * i, sizeof ray.direction);
    ray.t_min = t_min;
    ray.t_max = t_max;
    return ray;
  }
};

/// The hits of all rays, one after the other.
struct Lists {
  std::vector<std::int64_t> ends;
  std::vector<float> t;
  std::vector<std::int64_t> prim;

  template <class Hit>
  void add(const Hit* hits, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      t.push_back(hits[i].t);
      prim.push_back(hits[i].prim);
    }
    ends.push_back(std::int64_t(t.size()));
  }
};

struct Trees {
  fl::Tree tree;
  fl_tree* c_tree = nullptr;

  explicit Trees(const char* path) : tree(fl::load(path)) { fl_load(path, &c_tree); }
  ~Trees() { fl_free_tree(c_tree); }
};

}  // namespace

extern "C" {

FASTLINES_API Trees* calls_load(const char* path) {
  try {
    return new Trees(path);
  } catch (const std::exception&) {
    return nullptr;
  }
}
FASTLINES_API void calls_free(Trees* trees) { delete trees; }

FASTLINES_API void calls_first_cpp(const Trees* trees, const Batch* rays, float* t, std::int64_t* prim) {
  for (std::size_t i = 0; i < rays->n; ++i) {
    const fl::Hit hit = trees->tree.first_hit(rays->ray(i), rays->radius);
    t[i] = hit.t;
    prim[i] = hit.prim;
  }
}
FASTLINES_API void calls_first_c(const Trees* trees, const Batch* rays, float* t, std::int64_t* prim) {
  for (std::size_t i = 0; i < rays->n; ++i) {
    const fl_ray ray = rays->c_ray(i);
    fl_hit hit;
    fl_first_hit(trees->c_tree, &ray, rays->radius, FL_CLOSEST, &hit);
    t[i] = hit.t;
    prim[i] = hit.prim;
  }
}

FASTLINES_API void calls_any_cpp(const Trees* trees, const Batch* rays, bool* found) {
  for (std::size_t i = 0; i < rays->n; ++i) found[i] = trees->tree.any_hit(rays->ray(i), rays->radius);
}
FASTLINES_API void calls_any_c(const Trees* trees, const Batch* rays, bool* found) {
  for (std::size_t i = 0; i < rays->n; ++i) {
    const fl_ray ray = rays->c_ray(i);
    int hits;
    fl_any_hit(trees->c_tree, &ray, rays->radius, &hits);
    found[i] = hits;
  }
}

FASTLINES_API Lists* calls_all_cpp(const Trees* trees, const Batch* rays) {
  auto* const lists = new Lists;
  std::vector<fl::Hit> hits;
  for (std::size_t i = 0; i < rays->n; ++i) {
    trees->tree.all_hits(rays->ray(i), rays->radius, hits);
    lists->add(hits.data(), hits.size());
  }
  return lists;
}
FASTLINES_API Lists* calls_all_c(const Trees* trees, const Batch* rays) {
  auto* const lists = new Lists;
  std::vector<fl_hit> hits(64);
  for (std::size_t i = 0; i < rays->n; ++i) {
    const fl_ray ray = rays->c_ray(i);
    std::size_t n = 0;
    fl_all_hits(trees->c_tree, &ray, rays->radius, FL_CLOSEST, hits.data(), hits.size(), &n);
    if (n > hits.size()) {
      hits.resize(2 * n);
      fl_all_hits(trees->c_tree, &ray, rays->radius, FL_CLOSEST, hits.data(), hits.size(), &n);
    }
    lists->add(hits.data(), n);
  }
  return lists;
}
FASTLINES_API std::size_t calls_hits(const Lists* lists) { return lists->t.size(); }
FASTLINES_API void calls_copy(Lists* lists, std::int64_t* ends, float* t, std::int64_t* prim) {
  std::copy(lists->ends.begin(), lists->ends.end(), ends);
  std::copy(lists->t.begin(), lists->t.end(), t);
  std::copy(lists->prim.begin(), lists->prim.end(), prim);
  delete lists;
}
}
