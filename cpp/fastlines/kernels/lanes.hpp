// Prepared rays in lanes: 64 of them, each number an array, so that sixteen rays are one vector of it.
#pragma once

#include <cstring>

#include "../query/batch.hpp"
#include "../simd/rows.hpp"
#include "tally.hpp"

namespace fastlines {

inline constexpr int kLanes = 64;

/// The end of the sixteen lanes in which `end` lies, or of those before it where it is one.
constexpr int past_sixteen(int end) { return (end + kWidth - 1) / kWidth * kWidth; }

struct alignas(64) RayLanes {
  float o[3][kLanes], u[3][kLanes], v[3][kLanes], r[3][kLanes];
  float t_min[kLanes], t_max[kLanes], radius2[kLanes];
  float margin[kLanes];
  float reach[kLanes];  // radius + eps
  float t_min_given[kLanes], t_max_given[kLanes];
  double t0[kLanes], per_length[kLanes];
  double per_scale;
  int n = 0;  // lanes past it repeat the last ray
  std::uint32_t id[kLanes];
  bool in_fours[kLanes / kWidth];  // whether the rays of a sixteen stand side by side in the batch, four at a time

  /// Prepare the rays with these numbers, 1 to 64.
  void fill(const RayBatch& rays, const Frame& frame, int n_rays, const std::uint32_t* ids) {
    n = n_rays;
    tally(&Steps::rays, std::uint64_t(n));
    per_scale = 1.0 / frame.scale;
    std::copy_n(ids, n, id);
    const int padded = past_sixteen(n);
    for (int i = n; i < padded; ++i) id[i] = id[n - 1];
    float from[3][kLanes], along[3][kLanes], start[kLanes], stop[kLanes], near[kLanes];
    for (int i = 0; i < padded; i += kWidth) {
      bool fours = true;
      for (const std::uint32_t* four = id + i; four < id + i + kWidth; four += 4)
        fours &= (four[1] == four[0] + 1) & (four[2] == four[0] + 2) & (four[3] == four[0] + 3);
      in_fours[i / kWidth] = fours;
      turn(rays.origins, i, from);
      turn(rays.directions, i, along);
    }
    spread(rays.t_min, padded, start);
    spread(rays.t_max, padded, stop);
    spread(rays.radius, padded, near);
    // Roots and divisions by themselves, so that many are under way at once: nearly all else waits for them.
    double lengths[kLanes], per_lengths[kLanes];
    for (int i = 0; i < padded; ++i) {
      lengths[i] = length_of({along[0][i], along[1][i], along[2][i]});
      per_lengths[i] = 1.0 / lengths[i];
    }
    const Frame here = frame;  // a copy, so that nothing written can alias it
    for (int i = 0; i < padded; ++i)
      put(i, prepare({{from[0][i], from[1][i], from[2][i]},
                      {along[0][i], along[1][i], along[2][i]},
                      start[i],
                      stop[i],
                      near[i]},
                     lengths[i], per_lengths[i], here));
  }

  /// Of sixteen rays, a point or direction each.
  [[gnu::always_inline]] void turn(std::span<const Vec3> points, int first, float (&to)[3][kLanes]) const {
    if (in_fours[first / kWidth]) {
      const float* fours[4];
      for (int i = 0; i < 4; ++i) fours[i] = points[id[first + 4 * i]].data();
      Float16 xyz[3];
      turn_points(fours, xyz);
      for (int k = 0; k < 3; ++k) xyz[k].store(to[k] + first);
      return;
    }
    for (int i = first; i < first + kWidth; ++i)
      for (int k = 0; k < 3; ++k) to[k][i] = points[id[i]][k];
  }

  /// What each ray has of something that all may share.
  void spread(std::span<const float> values, int n_lanes, float* to) const {
    if (values.size() == 1)
      std::fill_n(to, n_lanes, values[0]);
    else
      for (int i = 0; i < n_lanes; ++i) to[i] = values[id[i]];
  }

  [[gnu::always_inline]] void put(int i, const Ray& ray) {
    for (int k = 0; k < 3; ++k) {
      o[k][i] = ray.o[k];
      u[k][i] = ray.u[k];
      v[k][i] = ray.v[k];
      r[k][i] = ray.r[k];
    }
    t_min[i] = ray.t_min;
    t_max[i] = ray.t_max;
    radius2[i] = ray.radius2;
    reach[i] = ray.radius + ray.eps;
    margin[i] = ray.margin;
    t_min_given[i] = ray.t_min_given;
    t_max_given[i] = ray.t_max_given;
    t0[i] = ray.t0;
    per_length[i] = ray.per_length;
  }

  /// Take over sixteen rays of others: what the exact test reads, margins and numbers, and, if it will be asked
  /// where they hit, the rest: how the caller counts t.
  template <bool with_rest>
  void copy(int to, const RayLanes& from, int first) {
    const auto sixteen = [=](const auto& theirs, auto& mine) {
      std::memcpy(mine + to, theirs + first, kWidth * sizeof *mine);  // in place; to copy what may overlap is a call
    };
    for (int k = 0; k < 3; ++k) {
      sixteen(from.o[k], o[k]);
      sixteen(from.u[k], u[k]);
      sixteen(from.v[k], v[k]);
      sixteen(from.r[k], r[k]);
    }
    sixteen(from.t_min, t_min);
    sixteen(from.t_max, t_max);
    sixteen(from.radius2, radius2);
    sixteen(from.margin, margin);
    sixteen(from.id, id);
    in_fours[to / kWidth] = from.in_fours[first / kWidth];
    if (!with_rest) return;
    sixteen(from.t_min_given, t_min_given);
    sixteen(from.t_max_given, t_max_given);
    sixteen(from.t0, t0);
    sixteen(from.per_length, per_length);
    per_scale = from.per_scale;
  }

  /// t as the caller counts it.
  float t_given(int i, float t) const {
    return given(t, t_min[i], t_max[i], t_min_given[i], t_max_given[i], t0[i], per_scale, per_length[i]);
  }
};

/// One ray as the exact test sees it.
struct RayInLane {
  struct Vector {
    const float (*at)[kLanes];
    int lane;
    float operator[](int k) const { return at[k][lane]; }
  };
  Vector o, u, v, r;
  float t_min, t_max, radius2;

  RayInLane(const RayLanes& lanes, int i)
      : o{lanes.o, i},
        u{lanes.u, i},
        v{lanes.v, i},
        r{lanes.r, i},
        t_min(lanes.t_min[i]),
        t_max(lanes.t_max[i]),
        radius2(lanes.radius2[i]) {}
};

/// Sixteen rays as the exact test sees them: what it reads is loaded when it reads it.
struct Rays16 {
  struct Number {
    const float* at;
    operator Float16() const { return Float16::load(at); }
  };
  struct Vector {
    const float (*at)[kLanes];
    int first;
    Float16 operator[](int k) const { return Float16::load(at[k] + first); }
  };
  Vector o, u, v, r;
  Number t_min, t_max, radius2;

  Rays16(const RayLanes& lanes, int first)
      : o{lanes.o, first},
        u{lanes.u, first},
        v{lanes.v, first},
        r{lanes.r, first},
        t_min{lanes.t_min + first},
        t_max{lanes.t_max + first},
        radius2{lanes.radius2 + first} {}
};

}  // namespace fastlines
