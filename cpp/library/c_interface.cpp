// The C interface: trees, rays and hits.
#include "c_rays.hpp"
#include "thread_hits.hpp"

struct fl_hit_lists {
  fl::HitLists lists;
};

using namespace fl::detail;

namespace {

thread_local std::string message;

}  // namespace

fl_status fl::detail::fail(fl_status status, const char* what) {
  try {
    message = what;
  } catch (const std::bad_alloc&) {
    message.clear();
  }
  return status;
}

namespace {

fl::Vec3 vector_of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }
fl::Ray ray_of(const fl_ray& given) {
  fl::Ray ray(vector_of(given.origin), vector_of(given.direction), given.t_min, given.t_max);
  ray.spread = given.spread;
  ray.ignore = {given.ignore, given.n_ignore};
  ray.ignore_strands = {given.ignore_strands, given.n_ignore_strands};
  return ray;
}
fl::Rank rank_of(fl_rank rank) {
  if (rank != FL_BY_T && rank != FL_BY_DISTANCE)
    throw fl::InputError("unknown fl_rank; expected FL_BY_T or FL_BY_DISTANCE");
  return rank == FL_BY_DISTANCE ? fl::Rank::distance : fl::Rank::t;
}
fl::At at_of(fl_at at) {
  if (at < FL_CLOSEST || at > FL_ENTRY)
    throw fl::InputError("unknown fl_at; expected FL_CLOSEST, FL_SURFACE or FL_ENTRY");
  return fl::At(at);
}
fl_hit hit_of(const fl::Hit& hit) { return {hit.t, hit.u, hit.distance, hit.t_out, hit.prim}; }

fl::Hit hit_of(const fl_hit& hit) { return {hit.t, hit.prim, hit.u, hit.distance, hit.t_out}; }

fl::BuildOptions options_of(const fl_options* given, std::size_t n_lines) {
  fl::BuildOptions options;
  if (!given) return options;
  if (given->method < FL_BEST || given->method > FL_BEAMS)
    throw fl::InputError("unknown fl_method; expected FL_BEST to FL_BEAMS");
  options.method = fl::Method(given->method);
  if (given->has_effort) options.effort = given->effort;
  options.n_threads = given->n_threads;
  if (given->strands) options.strands = {given->strands, n_lines};
  if (given->progress)
    options.progress = [progress = given->progress, data = given->user_data](double done) {
      return progress(done, data) != 0;
    };
  return options;
}

/// Copies a name, and cuts off what does not fit.
template <std::size_t n>
void copy_name(const std::string& from, char (&to)[n]) {
  to[from.copy(to, n - 1)] = 0;
}

template <class Line>
fl_status build(const float* lines, std::size_t n, const fl_options* options, fl_tree** tree) {
  return guarded([&] {
    require(tree, "tree");
    *tree = nullptr;
    if (n > 0) require(lines, "the array of lines");
    *tree = new fl_tree{fl::build(std::span(reinterpret_cast<const Line*>(lines), n), options_of(options, n))};
  });
}

template <class Line>
fl_status refit(const fl_tree* tree, const float* lines, std::size_t n, unsigned n_threads, fl_tree** refitted) {
  return guarded([&] {
    require(tree, "tree");
    require(refitted, "refitted");
    *refitted = nullptr;
    if (n > 0) require(lines, "the array of lines");
    *refitted = new fl_tree{tree->tree.refit(std::span(reinterpret_cast<const Line*>(lines), n), n_threads)};
  });
}

}  // namespace

const char* fl_version(void) { return fl::version(); }
const char* fl_error_message(void) { return message.c_str(); }

const char* fl_simd(void) {
  const char* name = "";
  guarded([&] { name = fl::simd(); });
  return name;
}
fl_status fl_set_simd(const char* name) {
  return guarded([&] { fl::set_simd(name); });
}

fl_status fl_build(const float* segments, size_t n, const fl_options* options, fl_tree** tree) {
  return build<fl::Segment>(segments, n, options, tree);
}
fl_status fl_build_round_cones(const float* cones, size_t n, const fl_options* options, fl_tree** tree) {
  return build<fl::RoundCone>(cones, n, options, tree);
}

fl_status fl_refit(const fl_tree* tree, const float* segments, size_t n, unsigned n_threads, fl_tree** refitted) {
  return refit<fl::Segment>(tree, segments, n, n_threads, refitted);
}
fl_status fl_refit_round_cones(const fl_tree* tree, const float* cones, size_t n, unsigned n_threads,
                               fl_tree** refitted) {
  return refit<fl::RoundCone>(tree, cones, n, n_threads, refitted);
}

fl_status fl_load(const char* path, fl_tree** tree) {
  return guarded([&] {
    require(path, "path");
    require(tree, "tree");
    *tree = nullptr;
    *tree = new fl_tree{fl::load(path)};
  });
}
fl_status fl_save(const fl_tree* tree, const char* path) {
  return guarded([&] {
    require(tree, "tree");
    require(path, "path");
    tree->tree.save(path);
  });
}

fl_status fl_get_facts(const fl_tree* tree, fl_facts* facts) {
  return guarded([&] {
    require(tree, "tree");
    require(facts, "facts");
    const fl::TreeFacts of = tree->tree.facts();
    *facts = {of.n_prims,
              of.n_nodes,
              of.n_refs,
              of.n_bytes,
              of.cost,
              {of.low.x, of.low.y, of.low.z},
              {of.high.x, of.high.y, of.high.z},
              {},
              {}};
    copy_name(of.method, facts->method);
    copy_name(of.simd, facts->simd);
  });
}

fl_line_arrays fl_get_lines(const fl_tree* tree) {
  if (!tree) return {};
  const std::span<const fl::Segment> segments = tree->tree.segments();
  const std::span<const fl::RoundCone> cones = tree->tree.round_cones();
  const std::span<const std::int64_t> strands = tree->tree.strands();
  const auto* const lines =
      segments.empty() ? reinterpret_cast<const float*>(cones.data()) : reinterpret_cast<const float*>(segments.data());
  const auto [x, y, z] = tree->tree.offset();
  return {tree->tree.size(), !cones.empty(), lines, strands.empty() ? nullptr : strands.data(), {x, y, z}};
}

fl_status fl_get_place(const fl_tree* tree, const fl_ray* ray, float radius, const fl_hit* hit, fl_place* place) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(hit, "hit");
    require(place, "place");
    const auto [point, normal, tangent, outside] = tree->tree.place(ray_of(*ray), radius, hit_of(*hit));
    *place = {{point.x, point.y, point.z},
              {normal.x, normal.y, normal.z},
              {tangent.x, tangent.y, tangent.z},
              {outside.x, outside.y, outside.z}};
  });
}

void fl_free_tree(fl_tree* tree) { delete tree; }

fl_status fl_first_hit(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hit) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(hit, "hit");
    *hit = hit_of(tree->tree.first_hit(ray_of(*ray), radius, at_of(at)));
  });
}

fl_status fl_any_hit(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, int* found) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(found, "found");
    *found = tree->tree.any_hit(ray_of(*ray), radius, at_of(at));
  });
}

fl_status fl_count_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(n, "n");
    *n = tree->tree.count_hits(ray_of(*ray), radius, at_of(at));
  });
}

fl_status fl_all_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, fl_hit* hits, size_t room,
                      size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(n, "n");
    if (room > 0) require(hits, "hits");
    std::vector<fl::Hit>& found = fl::detail::thread_hits();
    tree->tree.all_hits(ray_of(*ray), radius, found, at_of(at));
    *n = found.size();
    for (std::size_t i = 0; i < found.size() && i < room; ++i) hits[i] = hit_of(found[i]);
    fl::detail::release_large(found);
  });
}

fl_status fl_next_hits(const fl_tree* tree, const fl_ray* ray, float radius, fl_at at, size_t k, fl_rank rank,
                       fl_hit* hits, size_t* n) {
  return guarded([&] {
    require(tree, "tree");
    require(ray, "ray");
    require(n, "n");
    if (k > 0) require(hits, "hits");
    std::vector<fl::Hit>& found = fl::detail::thread_hits();
    tree->tree.next_hits(ray_of(*ray), radius, k, found, at_of(at), rank_of(rank));
    *n = found.size();
    for (std::size_t i = 0; i < found.size(); ++i) hits[i] = hit_of(found[i]);
    fl::detail::release_large(found);
  });
}

fl_status fl_first_hits(const fl_tree* tree, const fl_rays* rays, fl_at at, float* t, int64_t* prim, float* u,
                        float* distance, float* t_out) {
  return guarded([&] {
    require(tree, "tree");
    const RayBatch batch(rays, at_of(at));
    const fl::Hits hits = tree->tree.first_hit(batch.rays, batch.radius, batch.options);
    copy_if(hits.t, t);
    copy_if(hits.prim, prim);
    copy_if(hits.u, u);
    copy_if(hits.distance, distance);
    if (at == FL_CLOSEST && t_out)
      std::fill_n(t_out, hits.size(), fl::infinity);
    else
      copy_if(hits.t_out, t_out);
  });
}

fl_status fl_any_hits(const fl_tree* tree, const fl_rays* rays, fl_at at, uint8_t* found) {
  return guarded([&] {
    require(tree, "tree");
    const RayBatch batch(rays, at_of(at));
    if (batch.rays.size() > 0) require(found, "found");
    copy_if<std::uint8_t>(tree->tree.any_hit(batch.rays, batch.radius, batch.options), found);
  });
}

fl_status fl_counts(const fl_tree* tree, const fl_rays* rays, fl_at at, int64_t* n) {
  return guarded([&] {
    require(tree, "tree");
    const RayBatch batch(rays, at_of(at));
    if (batch.rays.size() > 0) require(n, "n");
    copy_if<std::int64_t>(tree->tree.count_hits(batch.rays, batch.radius, batch.options), n);
  });
}

fl_status fl_list_hits(const fl_tree* tree, const fl_rays* rays, size_t k, fl_at at, fl_rank rank,
                       fl_hit_lists** lists) {
  return guarded([&] {
    require(tree, "tree");
    require(lists, "lists");
    *lists = nullptr;
    const RayBatch batch(rays, at_of(at), rank_of(rank));
    *lists = new fl_hit_lists{k == SIZE_MAX ? tree->tree.all_hits(batch.rays, batch.radius, batch.options)
                                            : tree->tree.next_hits(batch.rays, batch.radius, k, batch.options)};
  });
}

fl_list_arrays fl_get_lists(const fl_hit_lists* lists) {
  if (!lists) return {};
  const auto& [offsets, hits, owner] = lists->lists;
  return {lists->lists.n_rays(), hits.size(),   offsets.data(),       hits.t.data(),
          hits.prim.data(),      hits.u.data(), hits.distance.data(), hits.t_out.empty() ? nullptr : hits.t_out.data()};
}

void fl_free_lists(fl_hit_lists* lists) { delete lists; }
