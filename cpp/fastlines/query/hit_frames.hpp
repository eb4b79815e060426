// The frames of hits on axes: points, outward normals, tangents and radii, computed in float64, eight hits at a time.
//
// Where the ray enters the surface, t is computed again (`enter`). Where a bound of the ray cuts the surface off, and
// at a closest approach, the point is that of t. The normal is the direction from the point of the axis at s, the
// centre of the ball that the ray touches there, or at u. Where that is the point itself, it is opposite to the ray.
#pragma once

#include <limits>

#include "../parallel/parallel_for.hpp"
#include "../rays/ray_batch.hpp"
#include "cubic_curves.hpp"
#include "round_cone_entry.hpp"

namespace fastlines {

/// The axes of hits: straight ones, or curves with the straight pieces that stand for them.
struct Axes {
  std::span<const float> rows;  ///< both ends of each straight axis and, in rows of 8, the radius at both
  std::size_t columns = 8;
  const CubicCurves* curves = nullptr;

  std::size_t size() const { return curves ? curves->control.size() : rows.size() / columns; }
  const float* row(std::int64_t i) const { return rows.data() + columns * std::size_t(i); }
  void prefetch(std::int64_t prim) const {
    if (!curves) return __builtin_prefetch(row(prim));
    __builtin_prefetch(&curves->first[std::size_t(prim)]);
    __builtin_prefetch(&curves->control[std::size_t(prim)]);
  }
};

/// Hits as columns: u and t of primitives, of which −1 is a miss, and the row of the ray of each hit.
struct HitPlaces {
  std::span<const std::int64_t> prim;
  std::span<const double> u, t;
  std::span<const std::int64_t> ray;  ///< empty if hit i is that of ray i
  bool at_surface = false;

  std::size_t size() const { return prim.size(); }
  std::size_t ray_of(std::size_t i) const { return ray.empty() ? i : std::size_t(ray[i]); }

  /// Whether all hits name axes and rays that exist.
  bool are_of(std::size_t n_axes, std::size_t n_rays) const {
    const auto below = [](std::span<const std::int64_t> numbers, std::int64_t from, std::size_t end) {
      bool good = true;
      for (const std::int64_t i : numbers) good &= (i >= from) & (i < std::int64_t(end));
      return good;
    };
    return below(prim, -1, n_axes) && below(ray, 0, n_rays) && (!ray.empty() || size() <= n_rays);
  }
};

/// Where the frames of hits are written, one row a hit. What is null is not computed. Misses are NaN.
template <class Scalar>
struct FrameColumns {
  using Vector = std::array<Scalar, 3>;
  Vector *points = nullptr, *normals = nullptr, *tangents = nullptr;
  Vector* to_eye = nullptr;      ///< against the ray
  Scalar* radius = nullptr;      ///< of the axis at u and of the ray together; of the axis alone without rays
  std::span<const double> lift;  ///< how far points are moved along the normals: for each hit, or for all, or empty
  double no_tangent = std::numeric_limits<double>::quiet_NaN();  ///< of an axis of length zero
};

/// Vectors of which each can be read as four floats.
class VectorRows {
 public:
  explicit VectorRows(std::span<const Vec3> vectors) : vectors_(vectors) {
    if (!vectors.empty()) std::copy_n(vectors.back().data(), 3, last_);
  }
  const float* operator[](std::size_t i) const { return i + 1 < vectors_.size() ? vectors_[i].data() : last_; }

 private:
  std::span<const Vec3> vectors_;
  float last_[4] = {};
};

/// What frames of hits are computed from. Without rays, there are no points and no normals.
struct HitSource {
  Axes axes;
  const RayBatch* rays;
  VectorRows origins, directions;

  HitSource(const Axes& given, const RayBatch* rays_of_hits)
      : axes(given),
        rays(rays_of_hits),
        origins(rays ? rays->origins : std::span<const Vec3>{}),
        directions(rays ? rays->directions : std::span<const Vec3>{}) {}
};

/// Eight hits, with NaN in the lanes of misses.
class FramesX8 {
 public:
  /// Loads the hits from row `begin` on, of which there are eight.
  FramesX8(const HitSource& from, const HitPlaces& places, std::size_t begin)
      : curves_(from.axes.curves),
        misses_(is_negative(places.prim.data() + begin)),
        u_(DoubleX8::load(places.u.data() + begin)) {
    for (int lane = 0; lane < kLanes; ++lane) prim_[lane] = std::max<std::int64_t>(places.prim[begin + lane], 0);
    if (from.rays || !curves_) load_straight(from.axes);
    if (from.rays) load_rays(from, places, begin);
  }

  const Vector3<DoubleX8>& points() const { return points_; }
  const Vector3<DoubleX8>& directions() const { return directions_; }
  const DoubleX8& ray_radius() const { return ray_radius_; }

  Vector3<DoubleX8> normals() const {
    const Vector3<DoubleX8> away = points_ - (start_ + s_ * edge_);
    return unit(blend(is_zero(away), -directions_, away));
  }
  Vector3<DoubleX8> tangents() const {
    return blend(misses_, no_vector(), unit(curves_ ? direction_of_curves() : edge_));
  }
  DoubleX8 radius() const { return blend(misses_, kNan, curves_ ? radius_of_curves() : mix(u_, radius0_, radius1_)); }

 private:
  static constexpr int kLanes = DoubleX8::kLanes;
  static constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

  static Vector3<DoubleX8> no_vector() { return {kNan, kNan, kNan}; }
  static Vector3<DoubleX8> vector_of(const DoubleX8 (&columns)[4]) { return {columns[0], columns[1], columns[2]}; }

  void load_straight(const Axes& axes) {
    const DoubleX8 zero = 0.0;
    std::int64_t straight[kLanes];
    std::copy_n(prim_, kLanes, straight);
    s_ = u_;
    if (curves_) find_pieces(straight);
    // Rows of 8 are start, end and both radii; rows of 6 have no radii.
    const bool is_thick = axes.columns == 8;
    const float *first[kLanes], *last[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      first[lane] = axes.row(straight[lane]);
      last[lane] = first[lane] + (is_thick ? 4 : 2);
    }
    DoubleX8 a[4], b[4];
    load_columns(first, a);
    load_columns(last, b);
    start_ = vector_of(a);
    edge_ = Vector3<DoubleX8>{a[3], is_thick ? b[0] : b[2], is_thick ? b[1] : b[3]} - start_;
    radius0_ = is_thick ? b[2] : zero;
    radius1_ = is_thick ? b[3] : zero;
  }

  /// Replaces u on the curves by s on their pieces.
  void find_pieces(std::int64_t (&pieces)[kLanes]) {
    double u[kLanes], begin[kLanes], end[kLanes];
    u_.store(u);
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::size_t piece = curves_->piece_of(prim_[lane], u[lane]);
      pieces[lane] = std::int64_t(piece);
      begin[lane] = curves_->begin[piece];
      end[lane] = curves_->end[piece];
    }
    s_ = (u_ - DoubleX8::load(begin)) / (DoubleX8::load(end) - DoubleX8::load(begin));
  }

  Vector3<DoubleX8> direction_of_curves() const {
    DoubleX8 columns[3][4];
    for (int k = 0; k < 3; ++k) {
      const float* rows[kLanes];
      for (int lane = 0; lane < kLanes; ++lane)
        rows[lane] = curves_->control[std::size_t(prim_[lane])][0].data() + 4 * k;
      load_columns(rows, columns[k]);
    }
    const auto number = [&](int k) { return columns[k / 4][k % 4]; };
    const auto point = [&](int k) -> Vector3<DoubleX8> {
      return {number(3 * k), number(3 * k + 1), number(3 * k + 2)};
    };
    return direction_at({point(0), point(1), point(2), point(3)}, u_);
  }

  DoubleX8 radius_of_curves() const {
    if (curves_->radii.empty()) return 0.0;
    const float* rows[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) rows[lane] = curves_->radii[std::size_t(prim_[lane])].data();
    DoubleX8 radii[4];
    load_columns(rows, radii);
    return at_least(0.0, cubic_at(radii, u_));
  }

  void load_rays(const HitSource& from, const HitPlaces& places, std::size_t begin) {
    const float *origins[kLanes], *directions[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      const std::size_t ray = places.ray_of(begin + std::size_t(lane));
      origins[lane] = from.origins[ray];
      directions[lane] = from.directions[ray];
    }
    const auto scalars = [&](std::span<const float> values) -> DoubleX8 {
      if (values.size() == 1) return double(values[0]);
      double each[kLanes];
      for (int lane = 0; lane < kLanes; ++lane) each[lane] = values[places.ray_of(begin + std::size_t(lane))];
      return DoubleX8::load(each);
    };
    DoubleX8 columns[4];
    load_columns(origins, columns);
    origins_ = vector_of(columns);
    load_columns(directions, columns);
    directions_ = vector_of(columns);
    ray_radius_ = scalars(from.rays->radius);
    t_ = DoubleX8::load(places.t.data() + begin);
    if (places.at_surface) find_entry((t_ != scalars(from.rays->t_min)) & (t_ != scalars(from.rays->t_max)));
    points_ = blend(misses_, no_vector(), origins_ + t_ * directions_);
  }

  /// Computes t and s again where the ray enters the surface.
  void find_entry(const DoubleX8::Mask& enters) {
    const DoubleX8 radius0 = radius0_ + ray_radius_;
    const RoundConeInDouble<DoubleX8> cones{start_, edge_, radius0, (radius1_ + ray_radius_) - radius0};
    const auto [t, s] = enter(cones, origins_, directions_);
    const DoubleX8::Mask use = enters & (t - t == DoubleX8(0.0));  // where t is finite
    t_ = blend(use, t, t_);
    s_ = blend(use, s, s_);
  }

  const CubicCurves* const curves_;
  const DoubleX8::Mask misses_;
  const DoubleX8 u_;
  std::int64_t prim_[kLanes];
  Vector3<DoubleX8> start_, edge_, origins_, directions_, points_;
  DoubleX8 radius0_, radius1_, s_, t_, ray_radius_;
};

/// Writes the frames of n misses.
template <class Scalar>
void store_misses(const FrameColumns<Scalar>& to, std::size_t row, int n) {
  constexpr Scalar nan = std::numeric_limits<Scalar>::quiet_NaN();
  for (auto* const vectors : {to.points, to.normals, to.tangents, to.to_eye})
    if (vectors) std::fill_n(vectors[row].data(), 3 * n, nan);
  if (to.radius) std::fill_n(to.radius + row, n, nan);
}

/// Writes the frames of hits from row `begin` on, of which there are eight, to n rows of columns from `row` on.
template <class Scalar>
void store_frames_x8(const HitSource& from, const HitPlaces& places, std::size_t begin, const FrameColumns<Scalar>& to,
                     std::size_t row, int n) {
  const std::int64_t* const prims = places.prim.data() + begin;
  // There may be no axis to read.
  if (std::all_of(prims, prims + DoubleX8::kLanes, [](std::int64_t prim) { return prim < 0; }))
    return store_misses(to, row, n);
  const FramesX8 frames(from, places, begin);
  const auto store = [&](const Vector3<DoubleX8>& vectors, typename FrameColumns<Scalar>::Vector* rows) {
    double columns[3][DoubleX8::kLanes];
    std::memcpy(columns, &vectors, sizeof columns);
    for (int lane = 0; lane < n; ++lane)
      for (int k = 0; k < 3; ++k) rows[row + std::size_t(lane)][k] = Scalar(columns[k][lane]);
  };
  Vector3<DoubleX8> points = frames.points();
  if (to.normals || !to.lift.empty()) {
    const Vector3<DoubleX8> normals = frames.normals();
    if (to.normals) store(normals, to.normals);
    if (!to.lift.empty()) {
      double lift[DoubleX8::kLanes] = {};
      for (int lane = 0; lane < n; ++lane) lift[lane] = to.lift[to.lift.size() == 1 ? 0 : row + std::size_t(lane)];
      points = points + DoubleX8::load(lift) * normals;
    }
  }
  if (to.points) store(points, to.points);
  if (to.tangents) {
    const Vector3<DoubleX8> tangents = frames.tangents();
    const DoubleX8 none = to.no_tangent;
    store(blend(tangents.x == tangents.x, tangents, {none, none, none}), to.tangents);
  }
  if (to.to_eye) store(-frames.directions(), to.to_eye);
  if (to.radius) {
    double radius[DoubleX8::kLanes];
    (from.rays ? frames.radius() + frames.ray_radius() : frames.radius()).store(radius);
    for (int lane = 0; lane < n; ++lane) to.radius[row + std::size_t(lane)] = Scalar(radius[lane]);
  }
}

/// Writes the frames of all hits. Without rays, only tangents and radii.
template <class Scalar>
void store_frames(const HitSource& from, const HitPlaces& places, const FrameColumns<Scalar>& to, unsigned n_threads,
                  Progress& progress) {
  constexpr std::size_t chunk_size = 1 << 12, lanes = DoubleX8::kLanes, ahead = 32;  // hits
  const auto store_last = [&](std::size_t begin) {
    std::int64_t prim[lanes], ray[lanes];
    double u[lanes], t[lanes];
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const std::size_t i = std::min(begin + lane, places.size() - 1);
      prim[lane] = places.prim[i];
      ray[lane] = std::int64_t(places.ray_of(i));
      u[lane] = places.u[i];
      t[lane] = from.rays ? places.t[i] : 0.0;
    }
    store_frames_x8(from, {prim, u, t, ray, places.at_surface}, 0, to, begin, int(places.size() - begin));
  };
  parallel_for_chunks(
      places.size(), chunk_size, n_threads, progress, [] { return 0; },
      [&](int, std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; i += lanes) {
          if (i + lanes > places.size()) return store_last(i);
          for (std::size_t k = i + ahead; k < std::min(i + ahead + lanes, places.size()); ++k)
            from.axes.prefetch(std::max<std::int64_t>(places.prim[k], 0));
          store_frames_x8(from, places, i, to, i, int(lanes));
        }
      });
}

}  // namespace fastlines
