// The queries of a tree about points and pairs, for one kind of line and one instruction set.
#pragma once

#include <limits>
#include <new>

#include "engine.hpp"
#include "engine/pair_queries.hpp"
#include "engine/point_queries.hpp"
#include "fastlines/kernels/proximity/one_point.hpp"
#include "fastlines/rays/ray_batch.hpp"
#include "ignored.hpp"
#include "point_limits.hpp"
#include "watch.hpp"

namespace fl::detail {

struct PairSide {
  fastlines::AxisSet axes;
  fastlines::PairTree tree;
  fastlines::Box box;  ///< of the axes
  PointLimits limits;
  Vec3d offset;
};

inline bool is_to_surface(To to, const PairSide& side) {
  if (to != To::surface && to != To::axis) throw InputError("unknown fl::To; expected To::surface or To::axis");
  return to == To::surface && side.axes.has_radius;
}

/// P is fastlines::Segments or fastlines::RoundCones.
template <fastlines::AxisPrimitive P>
class NearQueriesOf final : public NearQueries {
 public:
  NearQueriesOf(const P& prims, const fastlines::WideBvh& wide, const fastlines::WideBvhView<P>& view,
                const fastlines::Box& box, const TreeOrigin& origin)
      : view_(view),
        n_leaves_(wide.leaves.size()),
        n_lines_(prims.size()),
        origin_(origin),
        side_{fastlines::axes_of(prims),
              {view.frame,
               {wide.nodes.data(), wide.nodes.size()},
               {wide.leaves.data(), n_leaves_},
               {wide.refs.data(), wide.refs.size()}},
              box,
              PointLimits(box, fastlines::max_radius_of(prims)),
              origin.offset} {
    // Surfaces do not count where all radii are 0.
    side_.axes.has_radius = fastlines::max_radius_of(prims) > 0.0f;
  }

  // One point.

  NearLine nearest(const Point& point, float max_distance, To to) const override {
    require(side_.limits.fault_of_max_distance(max_distance));
    NearLine found;
    ask(point, max_distance, to, [&](const auto& one) { found = near_line(one.nearest()); });
    return found;
  }
  void k_nearest(const Point& point, std::size_t k, float max_distance, To to,
                 std::vector<NearLine>& lines) const override {
    require(side_.limits.fault_of_max_distance(max_distance));
    list(point, max_distance, to, lines,
         [&](const auto& one, auto& found) { one.k_nearest(std::min(k, n_lines_), found); });
  }
  void within(const Point& point, float radius, To to, std::vector<NearLine>& lines) const override {
    require(side_.limits.fault_of_radius(radius));
    list(point, radius, to, lines, [](const auto& one, auto& found) { one.within(found); });
  }
  std::size_t count_within(const Point& point, float radius, To to) const override {
    require(side_.limits.fault_of_radius(radius));
    std::size_t n = 0;
    ask(point, radius, to, [&](const auto& one) { n = one.count_within(); });
    return n;
  }

  // Batches.

  NearLines k_nearest(const Points& points, std::size_t k, const PerPoint& max_distance,
                      const PointOptions& options) const override {
    if (k > 0 && points.size() > std::numeric_limits<std::size_t>::max() / sizeof(Vec3d) / k) throw std::bad_alloc();
    const auto to = std::make_shared<fastlines::PointLists>();
    run(points, max_distance, "max_distance", options, [&](const auto& query) {
      const std::size_t n = points.size() * k;
      for (auto* column : {&to->distance, &to->s}) column->reset(n), column->set_size(n);
      to->row.reset(n);
      to->row.set_size(n);
      if (n > 0) query.find_nearest(k, {to->distance.data(), to->row.data(), to->s.data()});
    });
    return lines_of(to);
  }
  NearLists within(const Points& points, const PerPoint& radius, const PointOptions& options) const override {
    const auto to = std::make_shared<fastlines::PointLists>();
    run(points, radius, "radius", options, [&](const auto& query) { *to = query.list(); });
    return {to->offsets, lines_of(to), to};
  }
  std::vector<std::int64_t> count_within(const Points& points, const PerPoint& radius,
                                         const PointOptions& options) const override {
    std::vector<std::int64_t> counts(points.size());
    run(points, radius, "radius", options, [&](const auto& query) { query.count(counts.data()); });
    return counts;
  }

  // Pairs.

  const PairSide& pair_side() const override { return side_; }

  Pairs pairs(float radius, const NearQueries* other, std::span<const StrandPlace> places,
              const PairOptions& options) const override {
    using Place = fastlines::StrandNeighbours::Place;
    static_assert(sizeof(StrandPlace) == sizeof(Place));
    constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
    const PairSide& second = other ? other->pair_side() : side_;
    check_pairs(radius, other, options);
    const auto to = std::make_shared<fastlines::PairColumns>();
    const bool surface = is_to_surface(options.to, side_) || is_to_surface(options.to, second);
    if (side_.axes.n_rows == 0 || second.axes.n_rows == 0) return {};
    fastlines::Box box = side_.box;
    box.grow(second.box);
    fastlines::PairQuery query{side_.axes, second.axes, !other, fastlines::frame_of(box), radius, surface};
    if (!other && (options.skip_neighbours > 0 || options.skip_strand)) {
      const std::span<const Place> of_line(reinterpret_cast<const Place*>(places.data()), places.size());
      const auto reach = std::int32_t(std::min<std::size_t>(options.skip_neighbours, most));
      query.neighbours = {of_line, of_line, options.skip_strand ? most : reach};
    }
    watch(options.progress, [&](fastlines::Progress& progress) {
      *to = fastlines::find_pairs(query, side_.tree, second.tree, n_threads_of(options.n_threads), progress);
    });
    const auto column = []<class T>(const fastlines::Buffer<T>& of) {
      return std::span<const T>(of.data(), of.size());
    };
    return {column(to->i), column(to->j), column(to->s), column(to->t), column(to->distance), to};
  }

 private:
  static void require(const std::string& fault) {
    if (!fault.empty()) throw InputError("the point has " + fault);
  }

  Vec3d less_offset(const Vec3d& point) const {
    return {point.x - side_.offset.x, point.y - side_.offset.y, point.z - side_.offset.z};
  }

  NearLine near_line(const fastlines::Neighbour& found) const {
    if (found.row == fastlines::kNoPrim) return {};
    return {float(double(found.distance) * (1.0 / double(view_.frame.scale))), std::int64_t(found.row), found.s};
  }

  /// Calls use(one) with the queries of a point, if there are lines.
  template <class Use>
  void ask(const Point& point, float radius, To to, Use&& use) const {
    const Vec3d at = less_offset(point.position);
    require(side_.limits.fault(at));
    const double coordinates[3] = {at.x, at.y, at.z};
    const bool surface = is_to_surface(to, side_);
    const fastlines::PointQuery query = fastlines::prepare_point(coordinates, radius, surface, view_.frame);
    if (point.ignore.empty() && point.ignore_strands.empty()) {
      if (n_lines_ > 0) use(fastlines::OnePoint<P>(view_, query));
    } else {
      const Ignored ignored(point.ignore, point.ignore_strands, n_lines_, origin_.strands);
      if (n_lines_ > 0) use(fastlines::OnePoint<P>(view_, query, ignored.seen_by_one()));
    }
  }

  /// Writes what find(one, neighbours) finds.
  template <class Find>
  void list(const Point& point, float radius, To to, std::vector<NearLine>& lines, Find&& find) const {
    // A thread keeps its list from call to call, unless it is large.
    constexpr std::size_t most_kept = (std::size_t(1) << 20) / sizeof(fastlines::Neighbour);
    auto& found = fastlines::thread_scratch<std::vector<fastlines::Neighbour>>();
    found.clear();
    ask(point, radius, to, [&](const auto& one) { find(one, found); });
    lines.clear();
    for (const fastlines::Neighbour& each : found) lines.push_back(near_line(each));
    if (found.capacity() > most_kept) std::vector<fastlines::Neighbour>().swap(found);
  }

  static NearLines lines_of(const std::shared_ptr<fastlines::PointLists>& lists) {
    const auto& [offsets, distance, s, row] = *lists;
    return {{distance.data(), distance.size()}, {row.data(), row.size()}, {s.data(), s.size()}, lists};
  }

  /// Calls use(query) with the queries of a batch. Throws InputError if it cannot be used.
  template <class Use>
  void run(const Points& points, const PerPoint& radius, const char* name, const PointOptions& options,
           Use&& use) const {
    check(points, radius.values(), name);
    static_assert(sizeof(Vec3d) == 3 * sizeof(double));
    const bool surface = is_to_surface(options.to, side_);
    const Ignored ignored(points.ignore, points.ignore_strands, n_lines_, origin_.strands);
    const std::vector<std::uint8_t> hidden = ignored.hidden(n_lines_);
    const fastlines::Seen seen{.hidden = hidden};
    std::vector<Vec3d> moved;
    std::span<const Vec3d> positions = points.positions;
    if (const auto [x, y, z] = side_.offset; x != 0 || y != 0 || z != 0) {
      for (const Vec3d& point : positions) moved.push_back(less_offset(point));
      positions = moved;
    }
    const fastlines::PointBatch batch{
        {reinterpret_cast<const double*>(positions.data()), 3 * positions.size()}, radius.values(), surface};
    const fastlines::PointSearch<P> search(view_, n_leaves_);
    const bool is_long = fastlines::may_be_long(points.size(), n_leaves_);
    watch(options.progress, [&](fastlines::Progress& progress) {
      progress.per_step = 1.0 / (double(points.size() + 1) * double(n_leaves_ + 1));
      use(fastlines::PointsQuery<fastlines::PointSearch<P>>{search, batch, seen,
                                                            is_long ? n_threads_of(options.n_threads) : 1, progress});
    });
  }

  void check(const Points& points, std::span<const float> radius, const char* name) const {
    const std::size_t n = points.size();
    const auto is_null = [](const auto& values) { return !values.data() && !values.empty(); };
    if (is_null(points.positions))
      throw InputError("the positions of the points are null; expected a pointer to " + std::to_string(n) + " vectors");
    if (is_null(radius)) throw InputError(std::string(name) + " is null; expected a pointer to its numbers");
    if (radius.size() != 1 && radius.size() != n)
      throw InputError(std::string(name) + " has " + std::to_string(radius.size()) +
                       " numbers; expected one, or one for each of " + std::to_string(n) + " points");
    const bool is_radius = std::string_view(name) == "radius";
    for (std::size_t i = 0; i < n; ++i) {
      std::string fault = side_.limits.fault(less_offset(points.positions[i]));
      const float of_point = radius[radius.size() == 1 ? 0 : i];
      if (fault.empty())
        fault = is_radius ? side_.limits.fault_of_radius(of_point) : side_.limits.fault_of_max_distance(of_point);
      if (!fault.empty()) throw InputError("point " + std::to_string(i) + " has " + fault);
    }
  }

  void check_pairs(float radius, const NearQueries* other, const PairOptions& options) const {
    const PairSide& second = other ? other->pair_side() : side_;
    const bool is_larger = second.limits.largest() > side_.limits.largest();
    const std::string fault = (is_larger ? second : side_).limits.fault_of_radius(radius);
    if (!fault.empty()) throw InputError("the pairs have " + fault);
    if (!other) return;
    if (options.skip_strand)
      throw InputError("skip_strand leaves out pairs of one strand, and those of two trees never are; leave it out");
    const auto [x, y, z] = side_.offset;
    if ((x != second.offset.x || y != second.offset.y || z != second.offset.z) && n_lines_ > 0 &&
        second.axes.n_rows > 0)
      throw InputError("the trees have different offsets; save the lines of both with the same one");
  }

  const fastlines::WideBvhView<P>& view_;
  const std::size_t n_leaves_, n_lines_;
  const TreeOrigin& origin_;
  PairSide side_;
};

}  // namespace fl::detail
