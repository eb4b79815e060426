// Trees over segments, refits, and queries on the wide layout, for Python: the same source compiled for each
// instruction set.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include "build.hpp"
#include "engine.hpp"
#include "fastlines/build/refit.hpp"
#include "fastlines/kernels/run/run_batch.hpp"
#include "fastlines/layout/collapse.hpp"
#include "fastlines/rays/ray_check.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

nb::tuple build(Input<float> segments, const SettingsArgs& settings, nb::object progress) {
  return build_tree(Segments{rows<Segment>(segments)}, settings, progress);
}

/// A layout of a tree: nodes, leaves, references, the mean extent of a leaf.
nb::tuple widen(Input<float> segments, Input<std::uint32_t> nodes, Input<std::uint32_t> refs, double radius_hint,
                unsigned n_threads, nb::object progress) {
  WideBvh wide;
  watch(
      [&](Progress& watched) {
        wide = collapse(rows<Node>(nodes), rows<Reference>(refs), Segments{rows<Segment>(segments)},
                        {.radius_hint = radius_hint}, n_threads, watched);
      },
      progress);
  return nb::make_tuple(adopt<std::uint8_t>(std::move(wide.nodes)), adopt<std::uint8_t>(std::move(wide.leaves)),
                        adopt<std::uint32_t>(std::move(wide.refs)), wide.mean_extent);
}

/// A layout as Python has it: segments, nodes, leaves, references; the box of the scene; the mean extent of a leaf.
using LayoutArrays = std::tuple<Input<float>, Input<std::uint8_t>, Input<std::uint8_t>, Input<std::uint32_t>,
                                std::array<float, 6>, float>;

WideBvhView<Segments> view_of(const LayoutArrays& layout) {
  const auto& [segments, nodes, leaves, refs, corners, mean_extent] = layout;
  const Box box{{corners[0], corners[1], corners[2]}, {corners[3], corners[4], corners[5]}};
  const Frame frame = frame_of(box);
  return {.frame = frame,
          .box = {frame(box.lo), frame(box.hi)},
          .mean_extent = mean_extent,
          .nodes = rows<WideNode>(nodes).data(),
          .leaves = rows<WideLeaf>(leaves).data(),
          .refs = rows<WideRef>(refs).data(),
          .items = rows<Segment>(segments).data()};
}

/// What all questions have in common.
struct Question {
  WideBvhView<Segments> tree;
  RayBatch rays;
  Kernel kernel;
  unsigned n_threads;
  nb::object progress;
  bool is_long;  // enough for Ctrl-C

  Question(const LayoutArrays& layout, const RayArrays& rays_, int kernel_, unsigned n_threads_, nb::object progress_)
      : tree(view_of(layout)),
        rays(batch_of(rays_)),
        kernel(Kernel(kernel_)),
        n_threads(n_threads_),
        progress(std::move(progress_)),
        is_long(may_be_long(rays.size(), rows<WideRef>(std::get<3>(layout)).size())) {}

  /// Run a job whose answers go straight to their places.
  template <class Query>
  void run(const Query& job) const {
    watch_if(is_long, progress, [&](Progress& watched) { run_batch(tree, rays, kernel, job, n_threads, watched); });
  }

  template <At at, class Query>
  nb::tuple list(const Query& job) const {
    std::optional<HitAssembler> lists;
    watch_if(is_long, progress, [&](Progress& watched) {
      run_lists(tree, rays, kernel, job, n_threads, watched, lists.emplace(rays.size(), at == At::surface));
    });
    return arrays_of(*lists);
  }
};

nb::tuple first(LayoutArrays layout, RayArrays rays, bool surface, int kernel, unsigned n_threads,
                nb::object progress) {
  const Question question(layout, rays, kernel, n_threads, progress);
  HitArrays hits(question.rays.size(), surface);
  if (surface)
    question.run(FirstHitQuery<Segments, At::surface>{question.tree, hits.columns()});
  else
    question.run(FirstHitQuery<Segments, At::closest>{question.tree, hits.columns()});
  return hits.tuple();
}

Output<bool> any_of(LayoutArrays layout, RayArrays rays, int kernel, unsigned n_threads, nb::object progress) {
  const Question question(layout, rays, kernel, n_threads, progress);
  auto found = make_array<bool>(question.rays.size());
  question.run(AnyHitQuery{found.data()});
  return found;
}

Output<std::int64_t> count(LayoutArrays layout, RayArrays rays, int kernel, unsigned n_threads, nb::object progress) {
  const Question question(layout, rays, kernel, n_threads, progress);
  auto counts = make_array<std::int64_t>(question.rays.size());
  question.run(CountHitsQuery{counts.data()});
  return counts;
}

nb::tuple list(LayoutArrays layout, RayArrays rays, bool surface, std::optional<std::size_t> k, int kernel,
               unsigned n_threads, nb::object progress) {
  const Question question(layout, rays, kernel, n_threads, progress);
  const auto list_at = [&]<At at>() {
    return k ? question.list<at>(KNearestQuery<Segments, at>(question.tree, *k))
             : question.list<at>(AllHitsQuery<Segments, at>(question.tree));
  };
  return surface ? list_at.template operator()<At::surface>() : list_at.template operator()<At::closest>();
}

/// Work on so many references that somebody may want to press Ctrl-C.
constexpr std::size_t kLongRefit = 1'000'000;

/// The nodes of a tree over segments that have moved.
Output<std::uint32_t> refit_tree(Input<float> segments, Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                                 unsigned n_threads, nb::object progress) {
  const auto from = rows<Node>(nodes);
  auto to = make_array<std::uint32_t>(from.size(), sizeof(Node) / sizeof(std::uint32_t));
  Refit refit(from, rows<Reference>(refs), Segments{rows<Segment>(segments)}, reinterpret_cast<Node*>(to.data()));
  watch_if(rows<Reference>(refs).size() > kLongRefit, progress, [&](Progress& watched) { refit(n_threads, watched); });
  return to;
}

/// The nodes and leaves of a layout over segments that have moved, and the mean extent of its leaves.
nb::tuple refit_layout(LayoutArrays layout, unsigned n_threads, nb::object progress) {
  const auto& [segments, node_blocks, leaf_blocks, ref_rows, corners, mean_extent] = layout;
  const auto nodes = rows<WideNode>(node_blocks);
  const auto leaves = rows<WideLeaf>(leaf_blocks);
  const auto refs = rows<WideRef>(ref_rows);
  auto to_nodes = make_array<std::uint8_t>(nodes.size(), sizeof(WideNode));
  auto to_leaves = make_array<std::uint8_t>(leaves.size(), sizeof(WideLeaf));
  float extent = 0.0f;
  watch_if(refs.size() > kLongRefit, progress, [&](Progress& watched) {
    extent = BlockEncoder(view_of(layout).frame, nodes, leaves, refs, Segments{rows<Segment>(segments)},
                          reinterpret_cast<WideNode*>(to_nodes.data()),
                          reinterpret_cast<WideLeaf*>(to_leaves.data()))(n_threads, watched);
  });
  return nb::make_tuple(to_nodes, to_leaves, extent);
}

/// A quick look: `false` means that Python has to look closer.
bool are_rays(RayArrays rays, float largest_radius, float farthest, unsigned n_threads) {
  const WithoutGil without_gil;
  return rays_are_valid(batch_of(rays), largest_radius, farthest, n_threads);
}

}  // namespace

void define_engine(nb::module_& m) {
  m.doc() = "Trees over segments and queries on them, for one instruction set. Use the functions of the package.";
  m.attr("simd") = kSimd;
  m.def("build", &build, "segments"_a.noconvert(), "settings"_a, "progress"_a.none());
  m.def("widen", &widen, "segments"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "radius_hint"_a,
        "n_threads"_a, "progress"_a.none());
  m.def("are_rays", &are_rays, "rays"_a, "largest_radius"_a, "farthest"_a, "n_threads"_a);
  m.def("first_hit", &first, "layout"_a, "rays"_a, "surface"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("any_hit", &any_of, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("count_hits", &count, "layout"_a, "rays"_a, "kernel"_a, "n_threads"_a, "progress"_a.none());
  m.def("list_hits", &list, "layout"_a, "rays"_a, "surface"_a, "k"_a.none(), "kernel"_a, "n_threads"_a,
        "progress"_a.none());
  m.def("refit_tree", &refit_tree, "segments"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "n_threads"_a,
        "progress"_a.none());
  m.def("refit_layout", &refit_layout, "layout"_a, "n_threads"_a, "progress"_a.none());
}

}  // namespace fastlines
