// Fuzzes the checks that loading a tree runs in Python, over every kind of primitive. The file has the arrays as the
// checks get them: `data` are rows of segments, round cones or shapes, and `layout/…` the blocks of a layout.
//
// A tree that is accepted answers as brute force does, by its boxes, by its planes if it is a KD tree, and by a layout
// that is made of it. A layout that is accepted crashes no query, and its first hits are hits.
#include <cstring>
#include <optional>

#include "accepted.hpp"
#include "brute_answers.hpp"
#include "engine/layout_queries.hpp"
#include "engine/point_queries.hpp"
#include "engine/trees.hpp"
#include "expect.hpp"
#include "fastlines/layout/check_layout.hpp"
#include "fastlines/query/binary_traversal.hpp"
#include "fastlines/query/plane_traversal.hpp"
#include "fastlines/rays/ray_check.hpp"
#include "fastlines/tree/usable.hpp"
#include "library/container.hpp"
#include "probes.hpp"

namespace fastlines::fuzz {
namespace {

using fl::detail::Container;
using fl::detail::Section;

constexpr std::size_t kRays = 8, kPoints = 3;
constexpr At kAts[] = {At::closest, At::surface, At::entry};

/// The rows of a section with rows of this shape; nothing if it has another one. They are copied, so they are aligned.
template <class Row>
std::optional<std::vector<Row>> rows(const Container& file, const char* name, const char* dtype, const char* row) {
  const Section* const section = file.find(name);
  if (!section || section->dtype != dtype || section->shape.find(row) != section->shape.find(',')) return {};
  std::vector<Row> to(section->bytes.size() / sizeof(Row));
  if (!to.empty()) std::memcpy(static_cast<void*>(to.data()), section->bytes.data(), to.size() * sizeof(Row));
  return to;
}

/// What Python requires of primitives before it makes a tree over them.
bool is_valid(const Segment& segment) {
  const float* const numbers = &segment.p[0];
  return std::all_of(numbers, numbers + 6, [](float number) { return std::fabs(number) <= 1e30f; });
}
bool is_valid(const RoundCone& cone) {
  return is_valid(cone.axis) && cone.radius0 >= 0.0f && cone.radius0 <= 1e30f && cone.radius1 >= 0.0f &&
         cone.radius1 <= 1e30f;
}
bool is_valid(const Shape& shape) {
  if (shape.kind_number == float(Shape::round_cone)) return is_valid(shape.as<RoundCone>());
  for (const float number : shape.numbers)
    if (!(std::fabs(number) <= 1e30f)) return false;
  if (shape.kind_number == float(Shape::triangle)) return true;
  const Box& box = shape.as<Box>();
  return shape.kind_number == float(Shape::box) && !box.is_empty();
}

/// A search of one ray at a time, and brute force.
template <class Search>
void compare_search(const Search& search, const RayQuery& query, const std::vector<std::vector<Hit>>& expected) {
  std::vector<Hit> found;
  typename Search::Scratch scratch;
  const auto ray = prepare(query, search.frame);
  for (std::size_t i = 0; i < std::size(kAts); ++i) {
    HitVectorOfRay<Hit> list(ray, kAts[i], Keep::all, found);
    search_ray(search, ray, scratch, list);
    list.finish();
    if (has_exit(kAts[i]))
      for (Hit& hit : found) hit.t_out = exit_of(search, ray, hit.prim);
    expect(same_hits(found, expected[i]), "all hits by a search of the tree", query);
  }
}

/// A file's tree and layout over primitives of one kind. `T` are those that trees are over: for round cones, their
/// axes.
template <RayPrimitive P, Primitives T>
class Stored {
 public:
  Stored(const Container& file, const P& prims, const T& tree_prims, std::uint64_t seed)
      : file_(file), prims_(prims), tree_prims_(tree_prims), seed_(seed) {}

  /// Returns whether the tree is accepted.
  bool compare() {
    const auto nodes = rows<Node>(file_, "nodes", "U32", ", 9]");
    const auto refs = rows<Reference>(file_, "refs", "U32", ", 3]");
    if (!nodes || !refs) return false;
    const BoxRule rule = file_.text("boxes") == "cut" ? BoxRule::cut : BoxRule::tight;
    if (check_usable(tree_prims_, *nodes, *refs, rule)) return false;
    box_ = (*nodes)[0].box;
    if (max_radius_of(prims_) > max_radius()) return false;  // queries refuse such lines
    draw();
    Progress progress;
    compare_tree(*nodes, *refs, rule);
    const WideBvh wide = collapse(*nodes, *refs, prims_, {.radius_hint = 0.001}, 1, progress);
    // What is laid out passes its own check.
    const std::span all(wide.nodes.data(), wide.nodes.size());
    expect(!check_layout<P>(all, {wide.leaves.data(), wide.leaves.size()}, {wide.refs.data(), wide.refs.size()}, prims_,
                            progress),
           "the layout of a tree is refused");
    compare_layout(view_of(wide, prims_), wide.leaves.size(), true);
    compare_stored_layout(wide.mean_extent);
    return true;
  }

 private:
  void draw() {
    std::vector<Segment> edges;
    for (std::uint32_t prim = 0; prim < prims_.size(); ++prim) add_edges(prims_.item(prim), edges);
    probes_.emplace(seed_, std::move(edges), box_);
    const BruteAnswers<P> brute(prims_, scene());
    for (std::size_t i = 0; i < kRays; ++i) {
      const RayQuery ray = probes_->ray();
      if (!check_rays({{&ray.origin, 1}, {&ray.direction, 1}, {&ray.radius, 1}, {&ray.t_min, 1}, {&ray.t_max, 1}},
                      max_radius(), farthest(), 1)
               .valid)
        continue;
      rays_.push_back(ray);
      std::vector<std::vector<Hit>>& of_ray = expected_.emplace_back();
      for (const At at : kAts) brute.all_hits(ray, at, of_ray.emplace_back());
    }
  }

  /// The box of all primitives, whatever the root says.
  Box scene() const { return prims_.size() > 0 ? bounds_of_all(tree_prims_) : box_; }

  float max_radius() const {
    const double side = box_.side(box_.longest_axis());
    return float(std::min(1e12 * (side > 0.0 ? side : 1.0), double(std::numeric_limits<float>::max())));
  }
  float farthest() const {
    float far = 0.0f;
    for (int k = 0; k < 3; ++k) far = std::max({far, std::fabs(box_.lo[k]), std::fabs(box_.hi[k])});
    return far;
  }

  void compare_tree(std::span<const Node> nodes, std::span<const Reference> refs, BoxRule rule) const {
    const Frame frame = frame_of(box_, max_radius_of(prims_));
    const BinaryTraversal<P> by_boxes{nodes, refs, prims_, frame};
    for (std::size_t i = 0; i < rays_.size(); ++i) compare_search(by_boxes, rays_[i], expected_[i]);
    if (rule != BoxRule::cut) return;
    Progress progress;
    const PlaneTree planes = PlaneTreeWriter(nodes, refs, frame_of(box_))(progress);
    const PlaneTraversal<P> by_planes{planes.nodes, planes.prims, planes.depth, prims_, box_, frame};
    for (std::size_t i = 0; i < rays_.size(); ++i) compare_search(by_planes, rays_[i], expected_[i]);
  }

  /// Queries a layout. If it is exact, its answers are those of brute force; else its first hits are some of them.
  void compare_layout(const WideBvhView<P>& view, std::size_t n_leaves, bool is_exact) {
    compare_points(view, n_leaves, is_exact);
    if (rays_.empty()) return;
    std::vector<Vec3> origins, directions;
    std::vector<float> radius, t_min, t_max;
    for (const RayQuery& ray : rays_) {
      origins.push_back(ray.origin);
      directions.push_back(ray.direction);
      radius.push_back(ray.radius);
      t_min.push_back(ray.t_min);
      t_max.push_back(ray.t_max);
    }
    const RayBatch batch{origins, directions, radius, t_min, t_max};
    Progress progress;
    constexpr Kernel kernels[] = {Kernel::automatic, Kernel::single, Kernel::wave, Kernel::bundle};
    const LayoutQueries<P> queries{view, batch, kernels[probes_->below(std::size(kernels))], 1, progress};
    const std::size_t i_at = probes_->below(std::size(kAts));
    const At at = kAts[i_at];
    std::vector<Hit> first(rays_.size());
    std::vector<float> t(rays_.size()), u(t), distance(t), t_out(t);
    std::vector<std::int64_t> prim(t.size()), counts(t.size());
    queries.find_first(at, {t.data(), prim.data(), u.data(), distance.data(), has_exit(at) ? t_out.data() : nullptr});
    queries.count(at, counts.data());
    HitAssembler lists(rays_.size(), has_exit(at));
    queries.list(at, {}, false, lists);
    for (std::size_t i = 0; i < rays_.size(); ++i) {
      const std::vector<Hit>& hits = expected_[i][i_at];
      const auto is_this = [&](const Hit& hit) {
        return hit.t == t[i] && hit.prim == prim[i] && hit.u == u[i] && hit.distance == distance[i] &&
               (!has_exit(at) || hit.t_out == t_out[i]);
      };
      if (prim[i] >= 0) expect(std::ranges::any_of(hits, is_this), "a first hit is not a hit", rays_[i]);
      if (!is_exact) continue;
      expect(hits.empty() ? prim[i] < 0 : is_this(hits[0]), "the first hit on a layout", rays_[i]);
      expect(counts[i] == std::int64_t(hits.size()), "the number of hits on a layout", rays_[i]);
    }
    const auto offsets = lists.offsets();
    for (std::size_t i = 0; is_exact && i < rays_.size(); ++i) {
      const std::vector<Hit>& hits = expected_[i][i_at];
      bool equal = std::size_t(offsets[i + 1] - offsets[i]) == hits.size();
      for (std::size_t k = 0; equal && k < hits.size(); ++k) {
        const std::size_t j = std::size_t(offsets[i]) + k;
        equal = lists.t[j] == hits[k].t && lists.prim[j] == hits[k].prim && lists.u[j] == hits[k].u &&
                lists.distance[j] == hits[k].distance && (!has_exit(at) || lists.t_out[j] == hits[k].t_out);
      }
      expect(equal, "all hits on a layout", rays_[i]);
    }
  }

  void compare_points(const WideBvhView<P>& view, std::size_t n_leaves, bool is_exact) {
    if (prims_.size() == 0) return;
    const BruteAnswers<P> brute(prims_, scene());
    const PointSearch<P> search(view, n_leaves);
    for (std::size_t i = 0; i < kPoints; ++i) {
      const Vec3 near = probes_->point();
      const double point[] = {near[0], near[1], near[2]};
      const float radius = probes_->radius();
      if (!(std::fabs(near[0]) + std::fabs(near[1]) + std::fabs(near[2]) < 1e12f * max_radius())) continue;
      const bool surface = probes_->below(2) && max_radius_of(prims_) > 0;
      const PointBatch batch{point, {&radius, 1}, surface};
      Progress progress;
      const Seen seen;
      const PointLists found = PointsQuery<PointSearch<P>>{search, batch, seen, 1, progress}.list();
      if (!is_exact) continue;
      std::vector<Neighbour> expected;
      brute.within(point, radius, surface, expected);
      bool equal = found.row.size() == expected.size();
      for (std::size_t k = 0; equal && k < expected.size(); ++k)
        equal = found.row.data()[k] == std::int64_t(expected[k].row) && found.s.data()[k] == expected[k].s;
      expect(equal, "what is within a radius of a point on a layout");
    }
  }

  void compare_stored_layout(float mean_extent) {
    const auto nodes = rows<WideNode>(file_, "layout/nodes", "U8", ", 128]");
    const auto leaves = rows<WideLeaf>(file_, "layout/leaves", "U8", ", 128]");
    const auto refs = rows<WideRef>(file_, "layout/refs", "U32", ", 2]");
    if (!nodes || !leaves || !refs) return;
    Progress progress;
    if (check_layout<P>(*nodes, *leaves, *refs, prims_, progress)) return;
    const Frame frame = frame_of(box_);
    const Box in_frame{frame(box_.lo), frame(box_.hi)};
    const auto view = view_of(frame, in_frame, mean_extent, nodes->data(), leaves->data(), refs->data(), prims_);
    compare_layout(view, leaves->size(), false);
  }

  const Container& file_;
  const P& prims_;
  const T& tree_prims_;
  const std::uint64_t seed_;
  Box box_;
  std::optional<Probes> probes_;
  std::vector<RayQuery> rays_;
  std::vector<std::vector<std::vector<Hit>>> expected_;  // of each ray, for each of kAts
};

/// Returns whether the tree is over this kind of primitive, and accepted.
template <RayPrimitive P>
bool compare(const Container& file, const char* row, std::uint64_t seed) {
  const auto items = rows<typename P::Item>(file, "data", "F32", row);
  if (!items || !std::ranges::all_of(*items, [](const auto& item) { return is_valid(item); })) return false;
  const P prims{std::span(*items)};
  if constexpr (AxisPrimitive<P>) {
    std::vector<Segment> axes;
    for (const auto& item : *items) add_edges(item, axes);
    const Segments tree_prims{axes};
    return Stored<P, Segments>(file, prims, tree_prims, seed).compare();
  } else {
    return Stored<P, P>(file, prims, prims, seed).compare();
  }
}

}  // namespace
}  // namespace fastlines::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fastlines;
  using namespace fastlines::fuzz;
  const std::span bytes(data, size);
  Container file;
  try {
    file = fl::detail::split(std::as_bytes(bytes));
    fl::detail::verify(std::as_bytes(bytes), file);
  } catch (const std::runtime_error&) {
    return 0;
  }
  const std::uint64_t seed = seed_of(bytes);
  if (compare<Segments>(file, ", 6]", seed) || compare<RoundCones>(file, ", 8]", seed) ||
      compare<Shapes>(file, ", 10]", seed))
    accepted.add(bytes, seed);
  return 0;
}
