// The Python module fastlines._core: the C++ core, with no judgement of its own. All checks of arguments and all
// defaults are in Python.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "build.hpp"
#include "fastlines/build/reinsertion.hpp"
#include "fastlines/parallel/parallel_for.hpp"
#include "fastlines/primitives/boxes.hpp"
#include "fastlines/primitives/triangles.hpp"
#include "fastlines/query/binary_traversal.hpp"
#include "fastlines/query/brute_force.hpp"
#include "fastlines/query/for_each_ray.hpp"
#include "fastlines/query/plane_traversal.hpp"
#include "fastlines/tree/cost.hpp"
#include "fastlines/tree/validate.hpp"
#include "rays.hpp"
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

/// The widest instruction set of this machine that there is a module for.
const char* best_simd() {
#if defined(__x86_64__) || defined(__i386__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
                    __builtin_cpu_supports("bmi2");
  if (avx2 && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") &&
      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vbmi") &&
      __builtin_cpu_supports("avx512vnni"))
    return "avx512";
  if (avx2) return "avx2";
  if (__builtin_cpu_supports("sse4.2")) return "sse42";
  return "portable";
#elif defined(__aarch64__)
  return "neon";
#else
  return "portable";
#endif
}

/// Trees over segments are built by the engine modules.
nb::tuple build(const std::string& kind, Input<float> data, const SettingsArgs& settings, nb::object progress) {
  if (kind == "triangles") return build_tree(Triangles{rows<Triangle>(data)}, settings, progress);
  if (kind == "boxes") return build_tree(Boxes{rows<Box>(data)}, settings, progress);
  throw std::invalid_argument("the core builds no trees over " + kind);
}

/// The tree after moves of its subtrees, and how many of them were too deep.
nb::tuple reinsert(Input<std::uint32_t> nodes, Input<std::uint32_t> refs, int rounds, std::size_t max_depth,
                   double radius_hint, unsigned n_threads, nb::object progress) {
  Tree tree;
  std::size_t n_too_deep = 0;
  watch(
      [&](Progress& watched) {
        Reinsertion reinsertion(rows<Node>(nodes), rows<Reference>(refs), {rounds, max_depth, radius_hint, n_threads},
                                watched);
        tree = reinsertion();
        n_too_deep = reinsertion.n_too_deep();
      },
      progress);
  return nb::make_tuple(adopt<std::uint32_t>(std::move(tree.nodes)), adopt<std::uint32_t>(std::move(tree.refs)),
                        n_too_deep);
}

/// Node, axiom and detail of what a tree breaks.
using Broken = std::optional<std::tuple<std::size_t, std::string, std::string>>;

Broken broken(const std::optional<Violation>& found) {
  if (!found) return {};
  return std::make_tuple(found->node, found->axiom, found->detail);
}

/// A check of so many nodes and references is worth a look at Ctrl-C.
constexpr std::size_t kLongCheck = 1'000'000;

/// What a search relies on.
Broken check(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
             bool cut) {
  std::optional<Violation> found;
  const auto all_nodes = rows<Node>(nodes);
  const auto all_refs = rows<Reference>(refs);
  watch_if(all_nodes.size() + all_refs.size() > kLongCheck, nb::none(), [&](const Progress& watched) {
    with_primitives(kind, data, [&](const auto& prims) {
      found = check_usable(prims, all_nodes, all_refs, box_rule(cut), watched);
    });
  });
  return broken(found);
}

/// All axioms.
Broken validate_tree(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                     bool cut, bool pieces) {
  std::optional<Violation> found;
  watch(
      [&](const Progress& watched) {
        if (pieces)
          found =
              validate_pieces({rows<Segment>(data)}, rows<Node>(nodes), rows<Reference>(refs), box_rule(cut), watched);
        else
          with_primitives(kind, data, [&](const auto& prims) {
            found = validate(prims, rows<Node>(nodes), rows<Reference>(refs), box_rule(cut), watched);
          });
      },
      nb::none());
  return broken(found);
}

double cost(Input<std::uint32_t> nodes, double c_trav, double c_prim) {
  const WithoutGil without_gil;
  return cost_of(rows<Node>(nodes), c_trav, c_prim);
}

/// A KD tree as its planes, the primitive of each reference, and its depth.
nb::tuple planes(Input<std::uint32_t> nodes, Input<std::uint32_t> refs) {
  PlaneTree tree;
  watch([&](Progress& watched) { tree = PlaneTreeWriter(rows<Node>(nodes), rows<Reference>(refs))(watched); },
        nb::none());
  return nb::make_tuple(adopt<std::uint32_t>(std::move(tree.nodes)), adopt<std::uint32_t>(std::move(tree.prims)),
                        tree.depth);
}

std::size_t n_rays(const RayArrays& rays) { return batch_of(rays).size(); }

/// What is searched: nodes and references; of a KD tree its planes, primitives, depth and box; or every segment.
using Boxed = std::tuple<Input<std::uint32_t>, Input<std::uint32_t>>;
using Planes = std::tuple<Input<std::uint32_t>, Input<std::uint32_t>, std::uint32_t, std::array<float, 6>>;
using Searched = std::optional<std::variant<Boxed, Planes>>;

/// Call run(search, progress) with a search through the tree, or through every segment where there is none.
template <class Run>
void with_search(const Input<float>& data, const Searched& tree, std::size_t n, const nb::object& progress, Run&& run) {
  const Segments segments{rows<Segment>(data)};
  const auto run_with = [&](const auto& search) {
    watch_if(may_be_long(n, segments.size()), progress, [&](Progress& watched) { run(search, watched); });
  };
  if (!tree) {
    const Box box = bounds_of_all(segments);
    const BruteForce search{segments, frame_of(box.is_empty() ? Box{{0, 0, 0}, {0, 0, 0}} : box)};
    watch([&](Progress& watched) { run(search, watched); }, progress);
  } else if (const auto* boxed = std::get_if<Boxed>(&*tree)) {
    const auto nodes = rows<Node>(std::get<0>(*boxed));
    run_with(BinaryTraversal{nodes, rows<Reference>(std::get<1>(*boxed)), segments, frame_of(nodes[0].box)});
  } else {
    const auto& [nodes, prims, depth, corners] = std::get<Planes>(*tree);
    const Box box{{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
    run_with(PlaneTraversal{rows<PlaneNode>(nodes), rows<std::uint32_t>(prims), depth, segments, box, frame_of(box)});
  }
}

nb::tuple first_hit(Input<float> data, Searched tree, RayArrays rays, bool surface, unsigned n_threads,
                    nb::object progress) {
  HitArrays hits(n_rays(rays), surface);
  with_search(data, tree, n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    first_hits(search, batch_of(rays), surface ? At::surface : At::closest, n_threads, watched,
               [&](std::size_t i, const Hit& hit) { hits.columns().set(i, hit); });
  });
  return hits.tuple();
}

Output<bool> any_hit(Input<float> data, Searched tree, RayArrays rays, bool, unsigned n_threads, nb::object progress) {
  auto found = make_array<bool>(n_rays(rays));
  with_search(data, tree, n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    any_hits(search, batch_of(rays), n_threads, watched, {found.data(), n_rays(rays)});
  });
  return found;
}

Output<std::int64_t> count(Input<float> data, Searched tree, RayArrays rays, bool, unsigned n_threads,
                           nb::object progress) {
  auto counts = make_array<std::int64_t>(n_rays(rays));
  with_search(data, tree, n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    count_hits(search, batch_of(rays), n_threads, watched, {counts.data(), n_rays(rays)});
  });
  return counts;
}

/// All hits, or with k those that are nearest.
nb::tuple list(Input<float> data, Searched tree, RayArrays rays, bool surface, std::optional<std::size_t> k,
               unsigned n_threads, nb::object progress) {
  std::optional<HitAssembler> lists;
  const At at = surface ? At::surface : At::closest;
  with_search(data, tree, n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    lists.emplace(n_rays(rays), surface);
    const auto run = [&](auto&& make) { list_hits(search, batch_of(rays), n_threads, watched, *lists, make); };
    if (k)
      run([&](const Ray& ray) { return KNearestSink(at, ray, *k); });
    else
      run([&](const Ray& ray) { return AllSink(at, ray); });
  });
  return arrays_of(*lists);
}

}  // namespace
}  // namespace fastlines

NB_MODULE(_core, m) {
  using namespace fastlines;
  m.doc() = "The C++ core of fastlines. Use the functions of the package; they check what they are given.";
  m.def("build", &build, "kind"_a, "data"_a.noconvert(), "settings"_a, "progress"_a.none());
  m.def("reinsert", &reinsert, "nodes"_a.noconvert(), "refs"_a.noconvert(), "rounds"_a, "max_depth"_a, "radius_hint"_a,
        "n_threads"_a, "progress"_a.none());
  m.def("check", &check, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "cut"_a);
  m.def("validate", &validate_tree, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(),
        "cut"_a, "pieces"_a);
  m.attr("MAX_DEPTH") = kMaxDepth;
  m.def("cost", &cost, "nodes"_a.noconvert(), "c_trav"_a, "c_prim"_a);
  m.def("best_simd", &best_simd);
  m.def("planes", &planes, "nodes"_a.noconvert(), "refs"_a.noconvert());
  m.def("first_hit", &first_hit, "data"_a.noconvert(), "tree"_a.none(), "rays"_a, "surface"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("any_hit", &any_hit, "data"_a.noconvert(), "tree"_a.none(), "rays"_a, "surface"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("count_hits", &count, "data"_a.noconvert(), "tree"_a.none(), "rays"_a, "surface"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("list_hits", &list, "data"_a.noconvert(), "tree"_a.none(), "rays"_a, "surface"_a, "k"_a.none(), "n_threads"_a,
        "progress"_a.none());
}
