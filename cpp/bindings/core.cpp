// The Python module fastlines._core: the C++ core, with no judgement of its own. All checks of arguments and all
// defaults are in Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "fastlines/build/builder.hpp"
#include "fastlines/primitives/boxes.hpp"
#include "fastlines/primitives/triangles.hpp"
#include "fastlines/query/batch.hpp"
#include "fastlines/tree/validate.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// Call use(prims) with the set of primitives of this kind.
template <class Use>
void with_primitives(const std::string& kind, const Input<float>& data, Use&& use) {
  if (kind == "segments") return use(Segments{rows<Segment>(data)});
  if (kind == "triangles") return use(Triangles{rows<Triangle>(data)});
  if (kind == "boxes") return use(Boxes{rows<Box>(data)});
  throw std::invalid_argument("unknown kind of primitive: " + kind);
}

SplitSet split_set(const std::string& name, int n_planes) {
  if (name == "object_sweep") return ObjectSweep{};
  if (name == "plane_grid") return PlaneGrid{n_planes};
  if (name == "plane_events") return PlaneEvents{};
  if (name == "median") return Median{};
  if (name == "middle") return Middle{};
  throw std::invalid_argument("unknown split set: " + name);
}

BoxRule box_rule(bool cut) { return cut ? BoxRule::cut : BoxRule::tight; }

nb::tuple build(const std::string& kind, Input<float> data,
                const std::vector<std::tuple<std::string, int, std::size_t>>& splits, bool cut,
                const std::vector<int>& lookahead, double c_trav, double c_prim, std::size_t max_depth,
                std::size_t max_leaf_refs, std::size_t max_refs, std::size_t leaf_refs, double leaf_size,
                int bad_levels, bool prune, double radius_hint, nb::object progress) {
  Settings settings;
  settings.splits.clear();
  for (const auto& [name, n_planes, limit] : splits) settings.splits.push_back({split_set(name, n_planes), limit});
  settings.boxes = box_rule(cut);
  settings.lookahead = lookahead;
  settings.cost = {c_trav, c_prim};
  settings.limits = {max_depth, max_leaf_refs, max_refs, leaf_refs, leaf_size};
  settings.bad_levels = bad_levels;
  settings.prune = prune;
  settings.radius_hint = radius_hint;

  Tree tree;
  LimitsHit hit;
  watch(
      [&](Progress& watched) {
        with_primitives(kind, data, [&](const auto& prims) {
          Builder builder(prims, settings, watched);
          tree = builder.build();
          hit = builder.limits_hit();
        });
      },
      progress);
  return nb::make_tuple(copy_rows<std::uint32_t>(tree.nodes), copy_rows<std::uint32_t>(tree.refs),
                        nb::make_tuple(hit.depth, hit.refs, hit.leaf_refs));
}

std::optional<std::tuple<std::size_t, std::string, std::string>> check(const std::string& kind, Input<float> data,
                                                                       Input<std::uint32_t> nodes,
                                                                       Input<std::uint32_t> refs, bool cut) {
  std::optional<Violation> found;
  watch(
      [&](Progress&) {
        with_primitives(kind, data, [&](const auto& prims) {
          found = validate(prims, rows<Node>(nodes), rows<Reference>(refs), box_rule(cut));
        });
      },
      nb::none());
  if (!found) return {};
  return std::make_tuple(found->node, found->axiom, found->detail);
}

/// Rays as Python hands them over.
RayBatch batch(const Input<float>& origins, const Input<float>& directions, const Input<float>& radius,
               const Input<float>& t_min, const Input<float>& t_max) {
  return {rows<Vec3>(origins), rows<Vec3>(directions), rows<float>(radius), rows<float>(t_min), rows<float>(t_max)};
}

/// Hits as one array a property.
struct HitColumns {
  Output<float> t, u, distance, t_out;
  Output<std::int64_t> prim;

  explicit HitColumns(std::size_t n)
      : t(make_array<float>(n)),
        u(make_array<float>(n)),
        distance(make_array<float>(n)),
        t_out(make_array<float>(n)),
        prim(make_array<std::int64_t>(n)) {}

  void set(std::size_t i, const Hit& hit) {
    t.data()[i] = hit.t;
    u.data()[i] = hit.u;
    distance.data()[i] = hit.distance;
    t_out.data()[i] = hit.t_out;
    prim.data()[i] = hit.prim;
  }
};

/// Call run(search, progress) with a search through the tree, or through every segment where there is none. Small
/// batches run on the calling thread: nobody waits long enough to press Ctrl-C.
template <class Run>
void with_search(const Input<float>& data, const std::optional<Input<std::uint32_t>>& nodes,
                 const Input<std::uint32_t>& refs, std::size_t n_rays, const nb::object& progress, Run&& run) {
  const auto segments = rows<Segment>(data);
  if (nodes) {
    const auto all_nodes = rows<Node>(*nodes);
    const TreeSearch search{all_nodes, rows<Reference>(refs), segments, frame_of(all_nodes[0].box)};
    if (n_rays > kChunk || n_rays * segments.size() > 10'000'000)
      return watch([&](Progress& watched) { run(search, watched); }, progress);
    nb::gil_scoped_release release;
    Progress unwatched;
    return run(search, unwatched);
  }
  const Box box = bounds_of_all(Segments{segments});
  const BruteForce search{segments, frame_of(box.is_empty() ? Box{{0, 0, 0}, {0, 0, 0}} : box)};
  watch([&](Progress& watched) { run(search, watched); }, progress);
}

using OptionalNodes = std::optional<Input<std::uint32_t>>;

nb::tuple first_hit(Input<float> data, OptionalNodes nodes, Input<std::uint32_t> refs, Input<float> origins,
                    Input<float> directions, Input<float> radius, Input<float> t_min, Input<float> t_max, bool surface,
                    unsigned n_threads, nb::object progress) {
  const RayBatch rays = batch(origins, directions, radius, t_min, t_max);
  HitColumns hits(rays.size());
  with_search(data, nodes, refs, rays.size(), progress, [&](const auto& search, Progress& watched) {
    first_hits(search, rays, surface ? At::surface : At::closest, n_threads, watched,
               [&](std::size_t i, const Hit& hit) { hits.set(i, hit); });
  });
  return nb::make_tuple(hits.t, hits.prim, hits.u, hits.distance, hits.t_out);
}

Output<bool> any_hit(Input<float> data, OptionalNodes nodes, Input<std::uint32_t> refs, Input<float> origins,
                     Input<float> directions, Input<float> radius, Input<float> t_min, Input<float> t_max, bool,
                     unsigned n_threads, nb::object progress) {
  const RayBatch rays = batch(origins, directions, radius, t_min, t_max);
  auto found = make_array<bool>(rays.size());
  with_search(data, nodes, refs, rays.size(), progress, [&](const auto& search, Progress& watched) {
    any_hits(search, rays, n_threads, watched, {found.data(), rays.size()});
  });
  return found;
}

Output<std::int64_t> count(Input<float> data, OptionalNodes nodes, Input<std::uint32_t> refs, Input<float> origins,
                           Input<float> directions, Input<float> radius, Input<float> t_min, Input<float> t_max, bool,
                           unsigned n_threads, nb::object progress) {
  const RayBatch rays = batch(origins, directions, radius, t_min, t_max);
  auto counts = make_array<std::int64_t>(rays.size());
  with_search(data, nodes, refs, rays.size(), progress, [&](const auto& search, Progress& watched) {
    count_hits(search, rays, n_threads, watched, {counts.data(), rays.size()});
  });
  return counts;
}

nb::tuple all_hit(Input<float> data, OptionalNodes nodes, Input<std::uint32_t> refs, Input<float> origins,
                  Input<float> directions, Input<float> radius, Input<float> t_min, Input<float> t_max, bool surface,
                  unsigned n_threads, nb::object progress) {
  const RayBatch rays = batch(origins, directions, radius, t_min, t_max);
  AllHits all;
  with_search(data, nodes, refs, rays.size(), progress, [&](const auto& search, Progress& watched) {
    all = all_hits(search, rays, surface ? At::surface : At::closest, n_threads, watched);
  });
  HitColumns hits(std::size_t(all.offsets.back()));
  std::size_t i = 0;
  for (std::vector<Hit>& chunk : all.chunks) {
    for (const Hit& hit : chunk) hits.set(i++, hit);
    chunk = {};
  }
  return nb::make_tuple(copy_column(all.offsets), hits.t, hits.prim, hits.u, hits.distance, hits.t_out);
}

}  // namespace
}  // namespace fastlines

NB_MODULE(_core, m) {
  using namespace fastlines;
  m.doc() = "The C++ core of fastlines. Use the functions of the package; they check what they are given.";
  m.def("build", &build, "kind"_a, "data"_a.noconvert(), "splits"_a, "cut"_a, "lookahead"_a, "c_trav"_a, "c_prim"_a,
        "max_depth"_a, "max_leaf_refs"_a, "max_refs"_a, "leaf_refs"_a, "leaf_size"_a, "bad_levels"_a, "prune"_a,
        "radius_hint"_a, "progress"_a.none());
  m.def("validate", &check, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "cut"_a);
  const auto query = [&](const char* name, auto function) {
    m.def(name, function, "data"_a.noconvert(), "nodes"_a.noconvert().none(), "refs"_a.noconvert(),
          "origins"_a.noconvert(), "directions"_a.noconvert(), "radius"_a.noconvert(), "t_min"_a.noconvert(),
          "t_max"_a.noconvert(), "surface"_a, "n_threads"_a, "progress"_a.none());
  };
  query("first_hit", &first_hit);
  query("any_hit", &any_hit);
  query("count_hits", &count);
  query("all_hits", &all_hit);
}
