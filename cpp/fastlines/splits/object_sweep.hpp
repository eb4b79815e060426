// All n − 1 splits of the uncut references, sorted by box centre, on each axis: the classic SAH of a BVH (thesis §1.5).
#pragma once

#include "candidate.hpp"

namespace fastlines {

struct ObjectSweep {
  static constexpr bool kTightOnly = true;

  /// The visitor is a template parameter: it is called so often that an indirect call would count.
  template <Primitives P, class Visitor>
  void visit(const P&, Refs refs, const Box&, BoxRule, const Visitor& visitor) const {
    const std::size_t n = refs.size();
    if (n < 2) return;
    Order order(n);
    std::vector<Box> from(n);  // from[i] bounds the references from i on
    for (int axis = 0; axis < 3; ++axis) {
      sort(refs, axis, order);
      // Sweep from the right for the boxes of the right children, then from the left.
      Box box = Box::empty();
      for (std::size_t i = n; i-- > 0;) {
        box.grow(refs[order[i].second].box);
        from[i] = box;
      }
      box = Box::empty();
      for (std::size_t n_left = 1; n_left < n; ++n_left) {
        box.grow(refs[order[n_left - 1].second].box);
        visitor(Candidate{Candidate::Kind::objects, axis, 0.0f, n_left, n - n_left, box, from[n_left]});
      }
    }
  }

 private:
  using Order = std::vector<std::pair<double, std::uint32_t>>;  // twice the centre, and index of the reference

  static void sort(Refs refs, int axis, Order& order) {
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = {refs[i].twice_centre(axis), std::uint32_t(i)};
    std::sort(order.begin(), order.end(), [&](const auto& a, const auto& b) {
      return a.first != b.first ? a.first < b.first : ByCentre{axis}(refs[a.second], refs[b.second]);
    });
  }
};

}  // namespace fastlines
