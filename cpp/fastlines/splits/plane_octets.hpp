// The planes of a regular grid over the node's box, eight at a time, one a lane: what `PlaneGrid` shows, for straight
// pieces, in less time.
//
// Each lane keeps how many pieces lie on either side of its plane and the bounds of their parts there; in small nodes
// also those of the whole pieces, each on the side of its centre. Counts are exact; where a piece crosses a plane is
// computed in float32, so bounds may be off by some roundings, and whoever carries a split out takes the bounds of what
// comes of it. Nothing branches: a piece costs the same wherever it lies.
#pragma once

#include <array>
#include <cmath>

#include "../primitives/segments.hpp"
#include "candidate.hpp"

// Vectors go in and out of inline functions only. GCC comes to templates last, so there is no place to take this back.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace fastlines {

/// Curves that are straight from p to q.
template <class P>
concept Straight = Curves<P> && requires(const P& prims, std::uint32_t prim) {
  { prims.curve(prim) } -> std::convertible_to<Segment>;
};

class PlaneOctets {
 public:
  int n_planes = 16;
  std::size_t max_whole = 0;   ///< nodes of at most so many references are also split into whole ones; tight boxes only
  std::size_t only_whole = 0;  ///< and those of at most so many only so, where that divides them

  /// Show of each axis the split with the least SAH, for boxes grown by a margin; or all.
  template <Straight P, class Visitor>
  void visit(const P& prims, Refs refs, const Box& box, BoxRule rule, double margin, bool all,
             Visitor&& visitor) const {
    thread_local std::vector<Halves> halves;
    thread_local std::vector<Parts> parts;
    thread_local std::vector<Wholes> wholes;
    if (rule == BoxRule::cut) {
      place(box, halves);
      for (const BuildRef& ref : refs)
        for_each_axis(halves, [&](Halves& octet, int axis) { octet.count(ref.box.lo[axis], ref.box.hi[axis]); });
      show(std::span<const Halves>(halves), box, margin, all, visitor);
      return;
    }
    if (refs.size() <= max_whole) {
      place(box, wholes);
      for (const BuildRef& ref : refs)
        for_each_axis(wholes, [&](Wholes& octet, int axis) { octet.add(ref.box, axis); });
      const bool shown = show(std::span<const Wholes>(wholes), box, margin, all, visitor);
      if (shown && refs.size() <= only_whole) return;
    }
    place(box, parts);
    for (const BuildRef& ref : refs) {
      const Segment& segment = prims.curve(ref.ref.prim);
      Run runs[3];
      for (int axis = 0; axis < 3; ++axis) runs[axis] = Run(segment, ref.box, axis);
      for_each_axis(parts, [&](Parts& octet, int axis) { octet.add(runs[axis]); });
    }
    show(std::span<const Parts>(parts), box, margin, all, visitor);
  }

 private:
  static constexpr float kInf = std::numeric_limits<float>::infinity();

  using Octet = float __attribute__((vector_size(32)));
  using IntOctet = std::int32_t __attribute__((vector_size(32)));

  [[gnu::always_inline]] static Octet all_lanes(float x) { return Octet{} + x; }
  [[gnu::always_inline]] static Octet min(Octet x, Octet y) { return x < y ? x : y; }
  [[gnu::always_inline]] static Octet max(Octet x, Octet y) { return x > y ? x : y; }

  /// The axis itself last.
  static constexpr int turned(int axis, int j) { return j == 2 ? axis : (axis + 1 + j) % 3; }

  /// A piece as it runs up an axis: its extent along it, and in the two others from where to where and how steeply. Its
  /// ends are corners of its box.
  struct Run {
    float lo, hi, from[2], to[2], slope[2];

    Run() = default;
    [[gnu::always_inline]] Run(const Segment& segment, const Box& box, int axis) : lo(box.lo[axis]), hi(box.hi[axis]) {
      const float way = segment.q[axis] - segment.p[axis], per_way = 1.0f / way;
      for (int j = 0; j < 2; ++j) {
        const int k = turned(axis, j);
        const float beside = segment.q[k] - segment.p[k], steep = beside * per_way;
        const bool up = (beside >= 0.0f) == (way >= 0.0f);
        slope[j] = std::fabs(steep) < kInf ? steep : 0.0f;  // where it runs straight across
        from[j] = up ? box.lo[k] : box.hi[k];
        to[j] = up ? box.hi[k] : box.lo[k];
      }
    }
  };

  /// Eight planes across an axis, and how many references lie on either side of each.
  struct Halves {
    static constexpr auto kKind = Candidate::Kind::plane;
    Octet plane;
    IntOctet n_left, n_right;

    explicit Halves(const Octet& planes) : plane(planes), n_left{}, n_right{} {}

    /// As `side_of` has it.
    [[gnu::always_inline]] void count(float lo, float hi) {
      n_left -= left_of(lo, hi);
      n_right -= right_of(hi);
    }
    [[gnu::always_inline]] IntOctet left_of(float lo, float hi) const { return (plane > lo) | (plane >= hi); }
    [[gnu::always_inline]] IntOctet right_of(float hi) const { return plane < hi; }

    std::pair<Box, Box> boxes(const Box& box, int axis, int lane) const { return halves(box, axis, plane[lane]); }
  };

  /// Beside the counts the bounds, in the order of `turned`.
  struct Bounded : Halves {
    Octet left_lo[3], left_hi[3], right_lo[3], right_hi[3];

    explicit Bounded(const Octet& planes) : Halves(planes) {
      for (int j = 0; j < 3; ++j) {
        left_lo[j] = right_lo[j] = all_lanes(kInf);
        left_hi[j] = right_hi[j] = all_lanes(-kInf);
      }
    }

    std::pair<Box, Box> boxes(const Box&, int axis, int lane) const {
      Box left, right;
      for (int j = 0; j < 3; ++j) {
        const int k = turned(axis, j);
        left.lo[k] = left_lo[j][lane];
        left.hi[k] = left_hi[j][lane];
        right.lo[k] = right_lo[j][lane];
        right.hi[k] = right_hi[j][lane];
      }
      return {left, right};
    }
  };

  /// The parts of pieces that the planes cut.
  struct Parts : Bounded {
    using Bounded::Bounded;

    [[gnu::always_inline]] void add(const Run& run) {
      const Octet high = all_lanes(kInf), low = all_lanes(-kInf);
      this->count(run.lo, run.hi);
      const IntOctet on_left = this->left_of(run.lo, run.hi), on_right = this->right_of(run.hi);
      const Octet at = min(max(this->plane, all_lanes(run.lo)), all_lanes(run.hi)), way = at - run.lo;
      const auto grow = [&](int j, const Octet& from, const Octet& there, const Octet& to) {
        this->left_lo[j] = min(this->left_lo[j], on_left ? min(from, there) : high);
        this->left_hi[j] = max(this->left_hi[j], on_left ? max(from, there) : low);
        this->right_lo[j] = min(this->right_lo[j], on_right ? min(to, there) : high);
        this->right_hi[j] = max(this->right_hi[j], on_right ? max(to, there) : low);
      };
      for (int j = 0; j < 2; ++j) {
        const Octet from = all_lanes(run.from[j]), to = all_lanes(run.to[j]);
        const Octet there = min(max(from + way * run.slope[j], min(from, to)), max(from, to));
        grow(j, from, on_right ? there : to, to);
      }
      grow(2, all_lanes(run.lo), at, all_lanes(run.hi));
    }
  };

  /// Whole references, each on the side of its centre.
  struct Wholes : Bounded {
    static constexpr auto kKind = Candidate::Kind::centres;
    using Bounded::Bounded;

    [[gnu::always_inline]] void add(const Box& box, int axis) {
      const Octet high = all_lanes(kInf), low = all_lanes(-kInf);
      const IntOctet on_left = this->plane > centre_of(box, axis);
      this->n_left -= on_left;
      this->n_right += on_left + 1;
      for (int j = 0; j < 3; ++j) {
        const Octet lo = all_lanes(box.lo[turned(axis, j)]), hi = all_lanes(box.hi[turned(axis, j)]);
        this->left_lo[j] = min(this->left_lo[j], on_left ? lo : high);
        this->left_hi[j] = max(this->left_hi[j], on_left ? hi : low);
        this->right_lo[j] = min(this->right_lo[j], on_left ? high : lo);
        this->right_hi[j] = max(this->right_hi[j], on_left ? low : hi);
      }
    }
  };

  /// Octets over all three axes. Lanes without a plane strictly inside the box have one at −∞, with nothing on its
  /// left.
  template <class Octets>
  void place(const Box& box, std::vector<Octets>& octets) const {
    octets.clear();
    for (int axis = 0; axis < 3; ++axis) {
      const float lo = box.lo[axis], hi = box.hi[axis], step = float(box.side(axis) / (n_planes + 1));
      Octet number = {1, 2, 3, 4, 5, 6, 7, 8};
      for (int first = 0; first < n_planes; first += 8, number += 8.0f) {
        const Octet planes = lo + number * step;
        const IntOctet inside = (planes > lo) & (planes < hi) & (number <= float(n_planes));
        octets.emplace_back(inside ? planes : all_lanes(-kInf));
      }
    }
  }

  template <class Octets, class Use>
  [[gnu::always_inline]] static void for_each_axis(std::vector<Octets>& octets, Use&& use) {
    const std::size_t n = octets.size() / 3;
    for (std::size_t i = 0; i < n; ++i) use(octets[i], 0);
    for (std::size_t i = n; i < 2 * n; ++i) use(octets[i], 1);
    for (std::size_t i = 2 * n; i < 3 * n; ++i) use(octets[i], 2);
  }

  /// Returns whether there was anything to show.
  template <class Octets, class Visitor>
  static bool show(std::span<const Octets> octets, const Box& box, double margin, bool all, Visitor&& visitor) {
    const std::size_t n = octets.size() / 3;
    bool shown = false;
    // In parts of the longest side, so that no area is more or less than a float can say.
    const float scale = float(std::min(1.0 / box.side(box.longest_axis()), 1e38));
    for (int axis = 0; axis < 3; ++axis) {
      const auto of_axis = octets.subspan(std::size_t(axis) * n, n);
      const auto show_one = [&](const Octets& octet, int lane) {
        shown = true;
        const auto [left, right] = octet.boxes(box, axis, lane);
        visitor(Candidate{Octets::kKind, axis, octet.plane[lane], std::size_t(octet.n_left[lane]),
                          std::size_t(octet.n_right[lane]), left, right});
      };
      float least = kInf;
      std::size_t where = 0;
      for (std::size_t i = 0; i < n; ++i) {
        const Octet weighed = weigh(of_axis[i], box, axis, float(2 * margin) * scale, scale);
        for (int lane = 0; lane < 8; ++lane) {
          if (!(weighed[lane] < (all ? kInf : least))) continue;
          if (all) show_one(of_axis[i], lane);
          least = weighed[lane];
          where = i * 8 + std::size_t(lane);
        }
      }
      if (!all && least < kInf) show_one(of_axis[where / 8], int(where % 8));
    }
    return shown;
  }

  /// n_left·SA(left) + n_right·SA(right), halved; ∞ where a plane divides nothing.
  [[gnu::always_inline]] static Octet weigh(const Bounded& octet, const Box&, int, float grown, float scale) {
    const auto half_area = [=](const Octet(&lo)[3], const Octet(&hi)[3]) __attribute__((always_inline)) {
      const Octet x = (hi[0] - lo[0]) * scale + grown, y = (hi[1] - lo[1]) * scale + grown,
                  z = (hi[2] - lo[2]) * scale + grown;
      return x * y + x * z + y * z;
    };
    const Octet weighed = half_area(octet.left_lo, octet.left_hi) * __builtin_convertvector(octet.n_left, Octet) +
                          half_area(octet.right_lo, octet.right_hi) * __builtin_convertvector(octet.n_right, Octet);
    return (octet.n_left > 0) & (octet.n_right > 0) ? weighed : all_lanes(kInf);
  }

  /// A half without references is empty space.
  [[gnu::always_inline]] static Octet weigh(const Halves& octet, const Box& box, int axis, float grown, float scale) {
    const float x = float(box.side(turned(axis, 0))) * scale + grown,
                y = float(box.side(turned(axis, 1))) * scale + grown;
    const auto half_area = [&](const Octet& z) __attribute__((always_inline)) { return x * y + (x + y) * (z + grown); };
    const Octet weighed =
        half_area((octet.plane - box.lo[axis]) * scale) * __builtin_convertvector(octet.n_left, Octet) +
        half_area((box.hi[axis] - octet.plane) * scale) * __builtin_convertvector(octet.n_right, Octet);
    return octet.plane > box.lo[axis] ? weighed : all_lanes(kInf);
  }
};

}  // namespace fastlines
