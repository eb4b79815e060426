// A group of up to 64 prepared rays as a structure of arrays, so that a packet is one vector of each array.
#pragma once

#include <cstring>

#include "../../rays/ray_batch.hpp"
#include "../../simd/transpose.hpp"
#include "../cost/step_counters.hpp"

namespace fastlines {

/// Rays in a group.
inline constexpr int kGroupSize = 64;

/// `end` rounded up to a multiple of the SIMD width.
constexpr int round_up_to_width(int end) { return (end + kSimdWidth - 1) / kSimdWidth * kSimdWidth; }

/// The members are those of `Ray`, as columns with one entry per lane.
struct alignas(64) RayGroup {
  float o[3][kGroupSize], u[3][kGroupSize], v[3][kGroupSize], r[3][kGroupSize];
  float t_min[kGroupSize], t_max[kGroupSize], limit[kGroupSize], radius2[kGroupSize];
  float tie_tolerance[kGroupSize];
  float cull_radius[kGroupSize];  ///< radius + eps, in the frame
  float t_min_ray[kGroupSize], t_max_ray[kGroupSize];
  double t0[kGroupSize], inv_length[kGroupSize];
  double inv_scale;
  int n = 0;  ///< lanes from n to the end of the packet repeat the last ray
  std::uint32_t id[kGroupSize];
  /// Per packet: whether it consists of four runs of four rays that are adjacent in the batch.
  bool contiguous_fours[kGroupSize / kSimdWidth];

  /// Prepare the rays with these ids, 1 to 64 of them.
  void fill(const RayBatch& rays, const Frame& frame, int n_rays, const std::uint32_t* ids) {
    n = n_rays;
    count_step(&StepCounters::rays, std::uint64_t(n));
    inv_scale = 1.0 / frame.scale;
    std::copy_n(ids, n, id);
    const int padded = round_up_to_width(n);
    for (int i = n; i < padded; ++i) id[i] = id[n - 1];
    float origin[3][kGroupSize], direction[3][kGroupSize], start[kGroupSize], stop[kGroupSize], radius[kGroupSize];
    for (int i = 0; i < padded; i += kSimdWidth) {
      bool fours = true;
      for (const std::uint32_t* four = id + i; four < id + i + kSimdWidth; four += 4)
        fours &= (four[1] == four[0] + 1) & (four[2] == four[0] + 2) & (four[3] == four[0] + 3);
      contiguous_fours[i / kSimdWidth] = fours;
      load_points(rays.origins, i, origin);
      load_points(rays.directions, i, direction);
    }
    broadcast_or_gather(rays.t_min, padded, start);
    broadcast_or_gather(rays.t_max, padded, stop);
    broadcast_or_gather(rays.radius, padded, radius);
    // Compute roots and divisions in a loop of their own, where many overlap: nearly everything else depends on them.
    double lengths[kGroupSize], inv_lengths[kGroupSize];
    for (int i = 0; i < padded; ++i) {
      lengths[i] = length_of({direction[0][i], direction[1][i], direction[2][i]});
      inv_lengths[i] = 1.0 / lengths[i];
    }
    const Frame frame_copy = frame;  // so that no store can alias it
    for (int i = 0; i < padded; ++i)
      store(i, prepare({{origin[0][i], origin[1][i], origin[2][i]},
                        {direction[0][i], direction[1][i], direction[2][i]},
                        start[i],
                        stop[i],
                        radius[i]},
                       lengths[i], inv_lengths[i], frame_copy));
    fill_limits(rays);
  }

  /// Convert the limits of the rays to the frame; reads their tie tolerances.
  void fill_limits(const RayBatch& rays) {
    const int padded = round_up_to_width(n);
    if (!rays.has_limit()) {
      std::copy_n(t_max, padded, limit);
      return;
    }
    float given[kGroupSize];
    broadcast_or_gather(rays.limit, padded, given);
    for (int i = 0; i < padded; ++i)
      limit[i] = max_t_of(given[i], t_max[i], tie_tolerance[i], t0[i], inv_scale, inv_length[i]);
  }

  /// Load a point or a direction of each ray of the packet at `first`.
  [[gnu::always_inline]] void load_points(std::span<const Vec3> points, int first, float (&to)[3][kGroupSize]) const {
    if (contiguous_fours[first / kSimdWidth]) {
      const float* fours[4];
      for (int i = 0; i < 4; ++i) fours[i] = points[id[first + 4 * i]].data();
      FloatX16 xyz[3];
      transpose_points(fours, xyz);
      for (int k = 0; k < 3; ++k) xyz[k].store(to[k] + first);
      return;
    }
    for (int i = first; i < first + kSimdWidth; ++i)
      for (int k = 0; k < 3; ++k) to[k][i] = points[id[i]][k];
  }

  /// Load one value per ray; `values` may hold one for all.
  void broadcast_or_gather(std::span<const float> values, int n_lanes, float* to) const {
    if (values.size() == 1)
      std::fill_n(to, n_lanes, values[0]);
    else
      for (int i = 0; i < n_lanes; ++i) to[i] = values[id[i]];
  }

  /// Write a ray to lane i.
  [[gnu::always_inline]] void store(int i, const Ray& ray) {
    for (int k = 0; k < 3; ++k) {
      o[k][i] = ray.o[k];
      u[k][i] = ray.u[k];
      v[k][i] = ray.v[k];
      r[k][i] = ray.r[k];
    }
    t_min[i] = ray.t_min;
    t_max[i] = ray.t_max;
    radius2[i] = ray.radius2;
    cull_radius[i] = ray.radius + ray.eps;
    tie_tolerance[i] = ray.tie_tolerance;
    t_min_ray[i] = ray.t_min_ray;
    t_max_ray[i] = ray.t_max_ray;
    t0[i] = ray.t0;
    inv_length[i] = ray.inv_length;
  }

  /// Copy a packet of another group: ids, tie tolerances, and what the exact test reads. `with_t_ray` also copies what
  /// `t_ray` reads.
  template <bool with_t_ray>
  void copy(int to, const RayGroup& from, int first) {
    const auto copy_packet = [=](const auto& source, auto& target) {
      // memcpy is inlined; std::copy, which allows overlap, would be a call.
      std::memcpy(target + to, source + first, kSimdWidth * sizeof *target);
    };
    for (int k = 0; k < 3; ++k) {
      copy_packet(from.o[k], o[k]);
      copy_packet(from.u[k], u[k]);
      copy_packet(from.v[k], v[k]);
      copy_packet(from.r[k], r[k]);
    }
    copy_packet(from.t_min, t_min);
    copy_packet(from.t_max, t_max);
    copy_packet(from.limit, limit);
    copy_packet(from.radius2, radius2);
    copy_packet(from.tie_tolerance, tie_tolerance);
    copy_packet(from.id, id);
    contiguous_fours[to / kSimdWidth] = from.contiguous_fours[first / kSimdWidth];
    if (!with_t_ray) return;
    copy_packet(from.t_min_ray, t_min_ray);
    copy_packet(from.t_max_ray, t_max_ray);
    copy_packet(from.t0, t0);
    copy_packet(from.inv_length, inv_length);
    inv_scale = from.inv_scale;
  }

  /// t in units of the caller's ray, for the ray in lane i.
  float t_ray(int i, float t) const {
    return to_ray_t(t, t_min[i], t_max[i], t_min_ray[i], t_max_ray[i], t0[i], inv_scale, inv_length[i]);
  }
};

}  // namespace fastlines
