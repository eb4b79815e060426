// Views of the rays of a group as the exact test reads them (primitives/ray_view.hpp): one ray, a packet of 16, or any
// 16 by index.
#pragma once

#include <algorithm>

#include "../../primitives/ray_view.hpp"
#include "ray_group.hpp"

namespace fastlines {

/// The ray in one lane.
struct LaneView {
  struct Vector {
    const float (*at)[kGroupSize];
    int lane;
    float operator[](int k) const { return at[k][lane]; }
  };
  Vector o, u, v, r;
  float t_min, t_max, radius2;

  LaneView(const RayGroup& lanes, int i)
      : o{lanes.o, i},
        u{lanes.u, i},
        v{lanes.v, i},
        r{lanes.r, i},
        t_min(lanes.t_min[i]),
        t_max(lanes.t_max[i]),
        radius2(lanes.radius2[i]) {}
};

/// The packet at `first`. Values are loaded when they are read.
struct PacketView {
  struct Scalar {
    const float* at;
    operator FloatX16() const { return FloatX16::load(at); }
  };
  struct Vector {
    const float (*at)[kGroupSize];
    int first;
    FloatX16 operator[](int k) const { return FloatX16::load(at[k] + first); }
  };
  Vector o, u, v, r;
  Scalar t_min, t_max, radius2;

  PacketView(const RayGroup& lanes, int first)
      : o{lanes.o, first},
        u{lanes.u, first},
        v{lanes.v, first},
        r{lanes.r, first},
        t_min{lanes.t_min + first},
        t_max{lanes.t_max + first},
        radius2{lanes.radius2 + first} {}
};
static_assert(RayView<Ray, float> && RayView<LaneView, float> && RayView<PacketView, FloatX16>);

/// 16 of N rays by index, repeats allowed; N is 16 or kGroupSize. F is FloatX16, as a template parameter: a table of
/// more than 16 floats is then instantiated only where the instruction set can permute it.
template <class F, int N = kSimdWidth>
struct PermutedRays {
  struct Scalar {
    const float* table;
    const std::uint32_t* index;
    operator F() const { return F::template permute<N>(table, index); }
  };
  struct Vector {
    const float* table[3];
    const std::uint32_t* index;
    F operator[](int k) const { return F::template permute<N>(table[k], index); }
  };
  Vector o, u, v, r;
  Scalar t_min, t_max, radius2, tie_tolerance;

  /// The rays in lanes first + index[i], index[i] < N.
  PermutedRays(const RayGroup& rays, int first, const std::uint32_t* index)
      : o(of(rays.o, first, index)),
        u(of(rays.u, first, index)),
        v(of(rays.v, first, index)),
        r(of(rays.r, first, index)),
        t_min{rays.t_min + first, index},
        t_max{rays.t_max + first, index},
        radius2{rays.radius2 + first, index},
        tie_tolerance{rays.tie_tolerance + first, index} {}

 private:
  static Vector of(const float (&from)[3][kGroupSize], int first, const std::uint32_t* index) {
    return {{from[0] + first, from[1] + first, from[2] + first}, index};
  }
};

/// What the exact test reads of a ray, and its tie tolerance. The order is o and t_min, u and t_max, v and radius², r
/// and tie_tolerance: groups of four floats for a 16×4 transpose.
struct alignas(64) RayRecord {
  float values[16];
};

/// 16 rays by index, repeats allowed, transposed from their records.
template <class F>
struct TransposedRays {
  F o[3], t_min, u[3], t_max, v[3], radius2, r[3], tie_tolerance;

  [[gnu::always_inline]] TransposedRays(const RayRecord* records, const std::uint32_t* index) {
    const float* rows[kSimdWidth];
    for (int i = 0; i < kSimdWidth; ++i) rows[i] = records[index[i]].values;
    F fours[4][4];
    for (int i = 0; i < 4; ++i) transpose_rows(rows, 4 * i, fours[i]);
    std::copy_n(fours[0], 3, o);
    std::copy_n(fours[1], 3, u);
    std::copy_n(fours[2], 3, v);
    std::copy_n(fours[3], 3, r);
    t_min = fours[0][3];
    t_max = fours[1][3];
    radius2 = fours[2][3];
    tie_tolerance = fours[3][3];
  }
};
static_assert(RayView<PermutedRays<FloatX16>, FloatX16> && RayView<TransposedRays<FloatX16>, FloatX16>);

}  // namespace fastlines
