// Sixteen of up to 64 rays, each as often as it is wanted, in lanes: what an exact test of sixteen pieces, each against
// a ray of its own, reads of them.
//
// Either each number is looked up in the vectors that hold it for all rays, or each ray has a row of its numbers, and
// sixteen rows are turned. AVX-512 looks up among 64 rays with two instructions and a choice; where a vector holds
// less, rows are no dearer.
#pragma once

#include <algorithm>

#include "lanes.hpp"

namespace fastlines {

/// Sixteen of N rays, 16 or all, each as often as it is wanted: those with these indices. F is Float16: named, so that
/// more than sixteen are looked up only where the instruction set can.
template <class F, int N = kWidth>
struct ChosenRays {
  struct Number {
    const float* table;
    const std::uint32_t* index;
    operator F() const { return F::template look_up<N>(table, index); }
  };
  struct Vector {
    const float* table[3];
    const std::uint32_t* index;
    F operator[](int k) const { return F::template look_up<N>(table[k], index); }
  };
  Vector o, u, v, r;
  Number t_min, t_max, radius2, margin;

  /// Of lanes [first, first + N).
  ChosenRays(const RayLanes& rays, int first, const std::uint32_t* index)
      : o(of(rays.o, first, index)),
        u(of(rays.u, first, index)),
        v(of(rays.v, first, index)),
        r(of(rays.r, first, index)),
        t_min{rays.t_min + first, index},
        t_max{rays.t_max + first, index},
        radius2{rays.radius2 + first, index},
        margin{rays.margin + first, index} {}

 private:
  static Vector of(const float (&from)[3][kLanes], int first, const std::uint32_t* index) {
    return {{from[0] + first, from[1] + first, from[2] + first}, index};
  }
};

/// What the exact test reads of a ray, and its margin, in fours, as it is turned: o and t_min, u and t_max, v and
/// radius², r and margin.
struct alignas(64) RayRow {
  float numbers[16];
};

/// Sixteen rays with these indices, from their rows.
template <class F>
struct TurnedRays {
  F o[3], t_min, u[3], t_max, v[3], radius2, r[3], margin;

  [[gnu::always_inline]] TurnedRays(const RayRow* of, const std::uint32_t* index) {
    const float* rows[kWidth];
    for (int i = 0; i < kWidth; ++i) rows[i] = of[index[i]].numbers;
    F fours[4][4];
    for (int i = 0; i < 4; ++i) turn_rows(rows, 4 * i, fours[i]);
    std::copy_n(fours[0], 3, o);
    std::copy_n(fours[1], 3, u);
    std::copy_n(fours[2], 3, v);
    std::copy_n(fours[3], 3, r);
    t_min = fours[0][3];
    t_max = fours[1][3];
    radius2 = fours[2][3];
    margin = fours[3][3];
  }
};

/// What sixteen rays are picked from.
class Picks {
 public:
  /// Make ready for the sixteen rays in lanes from `first` on.
  void take(const RayLanes& rays, int first) {
    if constexpr (kInRows) {
      const float* const columns[] = {rays.o[0], rays.o[1], rays.o[2], rays.t_min,    //
                                      rays.u[0], rays.u[1], rays.u[2], rays.t_max,    //
                                      rays.v[0], rays.v[1], rays.v[2], rays.radius2,  //
                                      rays.r[0], rays.r[1], rays.r[2], rays.margin};
      turn_columns<16>([&](int k) { return columns[k] + first; }, rows_ + first);
    }
  }

  /// Those with these indices of lanes [first, first + n), n as for ChosenRays, as is F.
  template <class F, int n>
  [[gnu::always_inline]] auto pick(const RayLanes& rays, int first, const std::uint32_t* index) const {
    if constexpr (kInRows)
      return TurnedRays<F>(rows_ + first, index);
    else
      return ChosenRays<F, n>(rays, first, index);
  }

 private:
  static constexpr bool kInRows = Float16::kLooksUp < kLanes;
  RayRow rows_[kInRows ? kLanes : 1];
};

}  // namespace fastlines
