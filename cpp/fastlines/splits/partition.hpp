// Applies a candidate: moves the references of a node to its two children.
#pragma once

#include <cassert>

#include "candidate.hpp"

namespace fastlines {

/// Move the references of a node to its two children. `to_left` may be the buffer that holds them: references only move
/// towards its beginning.
template <Primitives P>
void partition(const P& prims, Refs refs, const Candidate& split, Buffer<BuildRef>& to_left,
               Buffer<BuildRef>& to_right) {
  if (split.kind == Candidate::Kind::objects) {
    if (to_left.begin() != refs.data()) to_left.assign(refs);
    BuildRef* const all = to_left.data();
    std::nth_element(all, all + split.n_left, all + refs.size(), ByCentre{split.axis});
    to_right.assign(Refs(all, refs.size()).subspan(split.n_left));
    to_left.set_size(split.n_left);
    return;
  }
  // Write each reference to both sides, and advance only its own side. The side is unpredictable, so not a branch.
  BuildRef* const left = to_left.begin() == refs.data() ? to_left.data() : to_left.reset(split.n_left + 1);
  BuildRef* const right = to_right.reset(split.n_right + 1);
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
      std::uint32_t left, right;  // the indices of its parts in the children
    };
    constexpr std::size_t kMaxKept = 1 << 16;     // straddlers that a thread keeps memory for
    constexpr std::size_t kPrefetchDistance = 8;  // straddlers
    thread_local Buffer<Straddler> straddlers;
    Straddler* const listed = straddlers.reset(split.n_left + split.n_right - refs.size() + 1);
    // Copy the straddlers to both sides, and list them.
    std::size_t n_both = 0;
    for (const BuildRef& ref : refs) {
      const auto side = unsigned(side_of(ref.box, split.axis, split.plane));
      listed[n_both] = {std::uint32_t(n_left), std::uint32_t(n_right)};
      n_both += side & side >> 1;
      put(ref, side & 1, side >> 1);
    }
    // Cut the straddlers.
    for (std::size_t i = 0; i < n_both; ++i) {
      if (i + kPrefetchDistance < n_both) prefetch(prims, left[listed[i + kPrefetchDistance].left].ref.prim);
      const auto [on_left, on_right] = listed[i];
      cut(prims, split.axis, split.plane, left[on_left], right[on_right]);
    }
    if (straddlers.capacity() > kMaxKept) straddlers = {};
  }
  to_left.set_size(n_left);
  to_right.set_size(n_right);
}

}  // namespace fastlines
