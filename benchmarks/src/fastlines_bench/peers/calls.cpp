// Loops that ask the library for one ray per call, through its C++ and its C interface (peers/calls.py compiles them).
#include <fastlines/fastlines.h>
#include <cstring>
#include <fastlines/fastlines.hpp>
#include <thread>

namespace {

struct Batch {
  std::size_t n;
  const float *origins, *directions;
  float t_min, t_max, radius;
  unsigned n_threads;

  fl::Ray ray(std::size_t i) const {
    const float *o = origins + 3 * i, *d = directions + 3 * i;
    return {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, t_min, t_max};
  }
  fl_ray c_ray(std::size_t i) const {
    fl_ray ray{};
    std::memcpy(ray.origin, origins + 3 * i, sizeof ray.origin);
    std::memcpy(ray.direction, directions + 3 * i, sizeof ray.direction);
    ray.t_min = t_min;
    ray.t_max = t_max;
    return ray;
  }
};

/// Calls work(begin, end) for a range of the rays on each thread.
template <class Work>
void for_ranges(const Batch& rays, Work&& work) {
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < rays.n_threads; ++i)
    others.emplace_back(work, rays.n * i / rays.n_threads, rays.n * (i + 1) / rays.n_threads);
  work(0, rays.n / rays.n_threads);
  for (std::thread& thread : others) thread.join();
}

/// The hits of some rays, one after the other.
struct List {
  std::vector<std::int64_t> counts;
  std::vector<float> t;
  std::vector<std::int64_t> prim;

  template <class Hit>
  void add(const Hit* hits, std::size_t n) {
    for (std::size_t i = 0; i < n; ++i) {
      t.push_back(hits[i].t);
      prim.push_back(hits[i].prim);
    }
    counts.push_back(std::int64_t(n));
  }
};

/// Those of all rays: a list for each thread.
struct Lists {
  const Batch& rays;
  std::vector<List> of_threads{rays.n_threads};

  /// The list of the thread whose range begins here.
  List& of(std::size_t begin) {
    std::size_t i = 0;
    while (rays.n * i / rays.n_threads != begin) ++i;
    return of_threads[i];
  }
};

struct Trees {
  fl::Tree tree;
  fl_tree* c_tree = nullptr;

  explicit Trees(const char* path) : tree(fl::load(path)) {
    if (fl_load(path, &c_tree) != FL_OK) throw std::runtime_error(fl_error_message());
  }
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
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const fl::Hit hit = trees->tree.first_hit(rays->ray(i), rays->radius);
      t[i] = hit.t;
      prim[i] = hit.prim;
    }
  });
}
FASTLINES_API void calls_first_c(const Trees* trees, const Batch* rays, float* t, std::int64_t* prim) {
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const fl_ray ray = rays->c_ray(i);
      fl_hit hit;
      fl_first_hit(trees->c_tree, &ray, rays->radius, FL_CLOSEST, &hit);
      t[i] = hit.t;
      prim[i] = hit.prim;
    }
  });
}

FASTLINES_API void calls_any_cpp(const Trees* trees, const Batch* rays, bool* found) {
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) found[i] = trees->tree.any_hit(rays->ray(i), rays->radius);
  });
}
FASTLINES_API void calls_any_c(const Trees* trees, const Batch* rays, bool* found) {
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const fl_ray ray = rays->c_ray(i);
      int hits;
      fl_any_hit(trees->c_tree, &ray, rays->radius, FL_CLOSEST, &hits);
      found[i] = hits;
    }
  });
}

FASTLINES_API Lists* calls_all_cpp(const Trees* trees, const Batch* rays) {
  auto* const lists = new Lists{*rays};
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    List& list = lists->of(begin);
    std::vector<fl::Hit> hits;
    for (std::size_t i = begin; i < end; ++i) {
      trees->tree.all_hits(rays->ray(i), rays->radius, hits);
      list.add(hits.data(), hits.size());
    }
  });
  return lists;
}
FASTLINES_API Lists* calls_all_c(const Trees* trees, const Batch* rays) {
  auto* const lists = new Lists{*rays};
  for_ranges(*rays, [=](std::size_t begin, std::size_t end) {
    List& list = lists->of(begin);
    std::vector<fl_hit> hits(64);
    for (std::size_t i = begin; i < end; ++i) {
      const fl_ray ray = rays->c_ray(i);
      std::size_t n = 0;
      fl_all_hits(trees->c_tree, &ray, rays->radius, FL_CLOSEST, hits.data(), hits.size(), &n);
      if (n > hits.size()) {
        hits.resize(2 * n);
        fl_all_hits(trees->c_tree, &ray, rays->radius, FL_CLOSEST, hits.data(), hits.size(), &n);
      }
      list.add(hits.data(), n);
    }
  });
  return lists;
}
FASTLINES_API std::size_t calls_hits(const Lists* lists) {
  std::size_t n = 0;
  for (const List& list : lists->of_threads) n += list.t.size();
  return n;
}
FASTLINES_API void calls_copy(Lists* lists, std::int64_t* counts, float* t, std::int64_t* prim) {
  for (const List& list : lists->of_threads) {
    counts = std::copy(list.counts.begin(), list.counts.end(), counts);
    t = std::copy(list.t.begin(), list.t.end(), t);
    prim = std::copy(list.prim.begin(), list.prim.end(), prim);
  }
  delete lists;
}
}
