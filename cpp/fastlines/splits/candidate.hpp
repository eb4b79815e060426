// A candidate: one way to divide a node, with what its cost needs to know.
//
// A split set (the thesis's SPLITS) is anything that shows its candidates for a node to a visitor:
//
//     set.visit(prims, refs, box, rule, [](const Candidate&) { … });
//
// It counts; it moves nothing. `partition` carries a candidate out.
#pragma once

#include <algorithm>
#include <cassert>
#include <span>
#include <vector>

#include "../primitives/segments.hpp"
#include "../references/cut.hpp"
#include "../simd/bounds.hpp"

namespace fastlines {

/// How a child's box is made: tight around what lies in it (BVH), or cut out of its parent's (KD tree).
enum class BoxRule { tight, cut };

/// How the children of candidates are measured, where they are compared.
struct Measure {
  double margin = 0.0;    ///< boxes are grown by this much
  std::size_t lanes = 1;  ///< a power of two: references are tested so many at once

  double area(const Box& box) const { return box.area(margin); }

  /// How many tests so many references count as: half of them full lanes.
  double tests(std::size_t n_refs) const {
    return 0.5 * (double(n_refs) + double((n_refs + lanes - 1) & ~(lanes - 1)));
  }
};

struct Candidate {
  enum class Kind { objects, centres, plane } kind;
  int axis;
  float plane;         // of a plane: references that straddle it are cut
  std::size_t n_left;  // of objects: that many go left, in the order of their centres
  std::size_t n_right;
  Box left, right;

  /// What its children cost as leaves, times the area of their parent.
  double sah(const Measure& measure) const {
    return measure.area(left) * measure.tests(n_left) + measure.area(right) * measure.tests(n_right);
  }
};

using Refs = std::span<const BuildRef>;

/// Of a box that goes whole to one side of a plane: left if this is less.
inline float centre_of(const Box& box, int axis) { return 0.5f * box.lo[axis] + 0.5f * box.hi[axis]; }

inline Box hull(Refs refs) {
  Bounds all;
  for (const BuildRef& ref : refs) all.grow(Bounds(ref.box));
  return all.box();
}

/// The order of object splits: by centre; ties by primitive and piece, so that it is total.
struct ByCentre {
  int axis;
  bool operator()(const BuildRef& a, const BuildRef& b) const {
    const double ca = a.centre(axis), cb = b.centre(axis);
    if (ca != cb) return ca < cb;
    if (a.ref.prim != b.ref.prim) return a.ref.prim < b.ref.prim;
    return a.ref.s0 < b.ref.s0;
  }
};

/// Move the references of a node to its two children. `to_left` may be where they are: they only move towards its
/// beginning.
template <Primitives P>
void partition(const P& prims, Refs refs, const Candidate& split, Buffer<BuildRef>& to_left,
               Buffer<BuildRef>& to_right) {
  if (split.kind == Candidate::Kind::objects) {
    std::vector<BuildRef> sorted(refs.begin(), refs.end());
    std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(split.n_left), sorted.end(), ByCentre{split.axis});
    to_left.assign(Refs(sorted).first(split.n_left));
    to_right.assign(Refs(sorted).subspan(split.n_left));
    return;
  }
  // Each is written to both sides, and counts where it belongs: which side that is can not be foreseen.
  BuildRef* const left = to_left.begin() == refs.data() ? to_left.data() : to_left.make_room(split.n_left + 1);
  BuildRef* const right = to_right.make_room(split.n_right + 1);
  std::size_t n_left = 0, n_right = 0;
  const auto put = [&](const BuildRef& ref, unsigned on_left, unsigned on_right) {
    assert(n_left <= split.n_left && n_right <= split.n_right);
    left[n_left] = ref;
    right[n_right] = ref;
    n_left += on_left;
    n_right += on_right;
  };
  if (split.kind == Candidate::Kind::centres) {
    for (const BuildRef& ref : refs) {
      const unsigned on_left = centre_of(ref.box, split.axis) < split.plane;
      put(ref, on_left, on_left ^ 1);
    }
  } else {
    struct Straddler {
      std::uint32_t left, right;  // where it was put
    };
    constexpr std::size_t kMostKept = 1 << 16;
    thread_local Buffer<Straddler> straddlers;
    Straddler* const places = straddlers.make_room(split.n_left + split.n_right - refs.size() + 1);
    std::size_t n_both = 0;
    for (const BuildRef& ref : refs) {
      const auto side = unsigned(side_of(ref.box, split.axis, split.plane));
      places[n_both] = {std::uint32_t(n_left), std::uint32_t(n_right)};
      n_both += side & side >> 1;
      put(ref, side & 1, side >> 1);
    }
    for (std::size_t i = 0; i < n_both; ++i) {
      if (i + 8 < n_both) fetch(prims, left[places[i + 8].left].ref.prim);
      const auto [on_left, on_right] = places[i];
      cut(prims, split.axis, split.plane, left[on_left], right[on_right]);
    }
    if (straddlers.capacity() > kMostKept) straddlers = {};
  }
  to_left.keep(n_left);
  to_right.keep(n_right);
}

/// One plane, counted the plain way: by looking at every reference.
template <Primitives P>
Candidate evaluate_plane(const P& prims, Refs refs, const Box& box, BoxRule rule, int axis, float plane) {
  const auto [low, high] = halves(box, axis, plane);
  Candidate split{Candidate::Kind::plane, axis, plane, 0, 0, low, high};
  if (rule == BoxRule::tight) split.left = split.right = Box::empty();
  const auto add_left = [&](const Box& part) {
    ++split.n_left;
    if (rule == BoxRule::tight) split.left.grow(part);
  };
  const auto add_right = [&](const Box& part) {
    ++split.n_right;
    if (rule == BoxRule::tight) split.right.grow(part);
  };
  for (const BuildRef& ref : refs) switch (side_of(ref.box, axis, plane)) {
      case Side::left:
        add_left(ref.box);
        break;
      case Side::right:
        add_right(ref.box);
        break;
      case Side::both: {
        BuildRef l = ref, r = ref;
        cut(prims, axis, plane, l, r);
        add_left(l.box);
        add_right(r.box);
      }
    }
  return split;
}

/// A tight child without references would leave the other as its parent was: no split. A cut one is empty space.
inline bool divides(const Candidate& split, BoxRule rule) {
  return rule == BoxRule::cut || (split.n_left > 0 && split.n_right > 0);
}

}  // namespace fastlines
