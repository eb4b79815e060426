// Queries on the binary tree, by its boxes or its planes, and by brute force; and crossings, from what any query finds.
#include <nanobind/stl/optional.h>

#include <variant>

#include "core.hpp"
#include "fastlines/query/binary_traversal.hpp"
#include "fastlines/query/brute_force.hpp"
#include "fastlines/query/crossings.hpp"
#include "fastlines/query/for_each_ray.hpp"
#include "fastlines/query/plane_traversal.hpp"
#include "fastlines/query/proximity/brute_force_points.hpp"
#include "layout.hpp"
#include "points.hpp"
#include "primitives.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// A search of a binary tree, or by brute force, as Python keeps it. It keeps the arrays alive that the search reads.
class BinaryView {
 public:
  static BinaryView of_boxes(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes,
                             Input<std::uint32_t> refs, const Corners& frame_corners) {
    const Box frame_box = box_of(frame_corners);
    const auto search = [&]<class P>(const P& prims) -> Search {
      return BinaryTraversal<P>{rows<Node>(nodes), rows<Reference>(refs), prims,
                                frame_of(frame_box, max_radius_of(prims))};
    };
    return {std::visit(search, ray_primitives<QueryPrimitives>(kind, data)), data, {nodes, refs}};
  }

  static BinaryView of_planes(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes,
                              Input<std::uint32_t> refs, std::uint32_t depth, const Corners& corners,
                              const Corners& frame_corners) {
    const Box box = box_of(corners), frame_box = box_of(frame_corners);
    const auto search = [&]<class P>(const P& prims) -> Search {
      const Frame frame = frame_of(frame_box, max_radius_of(prims));
      return PlaneTraversal<P>{rows<PlaneNode>(nodes), rows<std::uint32_t>(refs), depth, prims, box, frame};
    };
    return {std::visit(search, ray_primitives<QueryPrimitives>(kind, data)), data, {nodes, refs}};
  }

  /// Brute force: tests every primitive. The frame is that of all primitives, of which `data` may hide some.
  static BinaryView of_primitives(const std::string& kind, Input<float> data, Input<float> all) {
    const auto search = [&]<class P>(const P& prims) -> Search {
      const Box box = bounds_of_all(primitives_in<P>(all));
      return BruteForce<P>{prims, frame_of(box.is_empty() ? Box{{0, 0, 0}, {0, 0, 0}} : box, max_radius_of(prims))};
    };
    return {std::visit(search, ray_primitives<QueryPrimitives>(kind, data)), data, {}};
  }

  /// Calls run(search, progress).
  template <class Run>
  void with_search(std::size_t n_rays, const nb::object& progress, Run&& run) const {
    std::visit(
        [&]<class S>(const S& search) {
          const bool is_long = S::kTestsAll || may_be_long(n_rays, search.prims.size());
          watch_if(is_long, progress, [&](Progress& watched) {
            watched.per_step = 1.0 / (double(n_rays) * double(search.prims.size()));
            run(search, watched);
          });
        },
        search_);
  }

  /// Calls use(prims, frame).
  template <class Use>
  void with_prims(Use&& use) const {
    std::visit([&](const auto& search) { use(search.prims, search.frame); }, search_);
  }

 private:
  /// The variant of the three searches for each kind of QueryPrimitives.
  template <class>
  struct Searches;
  template <class... P>
  struct Searches<std::variant<P...>> {
    using Any = std::variant<BinaryTraversal<P>..., PlaneTraversal<P>..., BruteForce<P>...>;
  };
  using Search = Searches<QueryPrimitives>::Any;

  BinaryView(Search search, Input<float> data, std::vector<Input<std::uint32_t>> tree)
      : search_(std::move(search)), data_(std::move(data)), tree_(std::move(tree)) {}

  Search search_;
  Input<float> data_;
  std::vector<Input<std::uint32_t>> tree_;  // nodes and references
};

std::size_t n_rays(const RayArrays& rays) { return batch_of(rays).size(); }

HitTuple first(const BinaryView& tree, RayArrays rays, const std::string& at_name, unsigned n_threads,
               nb::object progress) {
  const At at = at_of(at_name);
  HitArrays hits(n_rays(rays), has_exit(at));
  tree.with_search(n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    first_hits(search, batch_of(rays), at, n_threads, watched,
               [&](std::size_t i, const Hit& hit) { hits.columns().set(i, hit); });
  });
  return hits.tuple();
}

Output<bool> any_of(const BinaryView& tree, RayArrays rays, const std::string& at_name, unsigned n_threads,
                    nb::object progress) {
  const At at = at_of(at_name);
  auto found = make_array<bool>(n_rays(rays));
  tree.with_search(n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    any_hits(search, batch_of(rays), at, n_threads, watched, {found.data(), n_rays(rays)});
  });
  return found;
}

Output<std::int64_t> count(const BinaryView& tree, RayArrays rays, const std::string& at_name, unsigned n_threads,
                           nb::object progress) {
  const At at = at_of(at_name);
  auto counts = make_array<std::int64_t>(n_rays(rays));
  tree.with_search(n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    count_hits(search, batch_of(rays), at, n_threads, watched, {counts.data(), n_rays(rays)});
  });
  return counts;
}

/// All hits of each ray, or its first k by t if k is given, or the k nearest to it with `by_distance`.
ListTuple list(const BinaryView& tree, RayArrays rays, const std::string& at_name, std::optional<std::size_t> k,
               bool by_distance, unsigned n_threads, nb::object progress) {
  std::optional<HitAssembler> lists;
  const At at = at_of(at_name);
  const Keep keep = !k ? Keep::all : by_distance ? Keep::nearest : Keep::first;
  tree.with_search(n_rays(rays), progress, [&](const auto& search, Progress& watched) {
    lists.emplace(n_rays(rays), has_exit(at));
    list_hits(search, batch_of(rays), n_threads, watched, *lists, at, keep, k.value_or(~0ull));
  });
  return arrays_of(*lists);
}

void use_prims(const BinaryView& tree, auto&& use) { tree.with_prims(use); }
void use_prims(const LayoutView& layout, auto&& use) {
  std::visit([&](const auto& prims) { use(prims, layout.frame); }, layout.prims);
}

/// Calls use(search) with brute force for points.
void with_points(const BinaryView& tree, auto&& use) {
  tree.with_prims([&]<class P>(const P& prims, const Frame& frame) {
    if constexpr (ProximityPrimitive<P>)
      use(BruteForcePoints<P>{prims, frame});
    else
      throw std::invalid_argument(std::string("queries about points do not know ") + P::kKind);
  });
}

/// The crossings of rays with the primitives that these pieces belong to, as lists of hits of pieces. `owner` has the
/// primitive of each piece; without it each is one. Unless `is_complete`, a ray may hit more pieces of the same.
template <class View>
ListTuple crossings(const View& view, RayArrays rays, Input<std::int64_t> offsets, Input<std::int64_t> pieces,
                    std::optional<Input<std::int64_t>> owner, bool is_complete, const std::string& at_name,
                    std::optional<std::size_t> k, bool by_distance, unsigned n_threads, nb::object progress) {
  const At at = at_of(at_name);
  const auto owners = owner ? rows<std::int64_t>(*owner) : std::span<const std::int64_t>();
  const PieceLists lists{rows<std::int64_t>(offsets), rows<std::int64_t>(pieces), {owners}, is_complete};
  const RayBatch batch = batch_of(rays);
  const Keep keep = by_distance ? Keep::nearest : Keep::first;
  const bool is_long = may_be_long(batch.size(), lists.pieces.size());
  HitAssembler to(batch.size(), has_exit(at));
  use_prims(view, [&](const auto& prims, const Frame& frame) {
    watch_if(is_long, progress, [&](Progress& watched) {
      list_crossings(prims, frame, batch, lists, is_long ? n_threads : 1, watched, to, at, keep, k.value_or(~0ull));
    });
  });
  return arrays_of(to);
}

template <class View>
void bind_crossings(nb::module_& m) {
  m.def("crossings", &crossings<View>, "view"_a, "rays"_a, "offsets"_a, "pieces"_a, "owner"_a.none(), "is_complete"_a,
        "at"_a, "k"_a.none(), "by_distance"_a, "n_threads"_a, "progress"_a.none());
}

}  // namespace

void bind_binary_queries(nb::module_& m) {
  nb::class_<BinaryView>(m, "BinaryView")
      .def_static("of_boxes", &BinaryView::of_boxes, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(),
                  "refs"_a.noconvert(), "frame_corners"_a)
      .def_static("of_planes", &BinaryView::of_planes, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(),
                  "refs"_a.noconvert(), "depth"_a, "corners"_a, "frame_corners"_a)
      .def_static("of_primitives", &BinaryView::of_primitives, "kind"_a, "data"_a.noconvert(), "all"_a.noconvert());
  m.def("first_hit", &first, "tree"_a, "rays"_a, "at"_a, "n_threads"_a, "progress"_a.none());
  m.def("any_hit", &any_of, "tree"_a, "rays"_a, "at"_a, "n_threads"_a, "progress"_a.none());
  m.def("count_hits", &count, "tree"_a, "rays"_a, "at"_a, "n_threads"_a, "progress"_a.none());
  m.def("list_hits", &list, "tree"_a, "rays"_a, "at"_a, "k"_a.none(), "by_distance"_a, "n_threads"_a,
        "progress"_a.none());
  bind_points<BinaryView>(m);
  bind_crossings<BinaryView>(m);
  bind_crossings<LayoutView>(m);
}

}  // namespace fastlines
