// The two ways to search: through a tree as it was built, and through every segment. Both show what they find to a
// sink, and both decide by the same exact test.
#pragma once

#include "../tree/tree.hpp"
#include "sinks.hpp"

namespace fastlines {

template <class Sink>
void test_segment(const Ray& ray, const Segment& segment, const Frame& frame, const Reference& ref, Sink& sink) {
  const Approach<float> approach = closest_approach(ray, see(ray, segment, frame));
  if (approach.hit) sink.add({ray, segment, frame, approach, ref});
}

/// A box test that errs on the side of a visit: the box is grown by the radius and by what rounding can do.
class Slabs {
 public:
  Slabs(const Ray& ray, const Frame& frame) : frame_(frame), t_min_(ray.t_min) {
    const float grow = ray.radius + ray.eps;
    for (int k = 0; k < 3; ++k) {
      const float r = std::copysign(std::max(std::abs(ray.r[k]), 1e-18f), ray.r[k]);
      inverse_[k] = 1.0f / r;
      backwards_[k] = r < 0.0f;
      near_[k] = ray.o[k] + (backwards_[k] ? -grow : grow);
      far_[k] = ray.o[k] + (backwards_[k] ? grow : -grow);
    }
  }

  /// The part of the ray, up to the limit, that is in the grown box; empty if t_enter > t_leave.
  struct Span {
    float t_enter, t_leave;
  };

  Span clip(const Box& box, float limit) const {
    Span span{t_min_, limit};
    for (int k = 0; k < 3; ++k) {
      const float lo = in_frame(frame_, k, box.lo[k]), hi = in_frame(frame_, k, box.hi[k]);
      span.t_enter = std::max(span.t_enter, enter_beyond(k, backwards_[k] ? hi : lo));
      span.t_leave = std::min(span.t_leave, leave_before(k, backwards_[k] ? lo : hi));
    }
    return span;
  }

  /// The t at which the ray enters the box; ∞ if it misses it, or enters beyond the limit.
  float enter(const Box& box, float limit) const {
    const Span span = clip(box, limit);
    return span.t_enter <= span.t_leave ? span.t_enter : std::numeric_limits<float>::infinity();
  }

  /// The t at which the ray enters what lies beyond a plane of the frame, and leaves what lies before it, both grown.
  float enter_beyond(int axis, float plane) const { return (plane - near_[axis]) * inverse_[axis]; }
  float leave_before(int axis, float plane) const { return (plane - far_[axis]) * inverse_[axis]; }

  bool is_backwards(int axis) const { return backwards_[axis]; }

  /// A coordinate of a box in the frame, rounded as the test of a box rounds it.
  static float in_frame(const Frame& frame, int axis, float x) { return (x - frame.centre[axis]) * frame.scale; }

 private:
  Frame frame_;
  float t_min_;
  Vec3 inverse_, near_, far_;
  bool backwards_[3];
};

/// Depth first, the nearer child first; a subtree that begins beyond the sink's limit is left out.
struct TreeSearch {
  /// Memory that a thread reuses from ray to ray.
  struct Scratch {
    struct Entry {
      std::uint32_t node;
      float enter;
    };
    std::vector<Entry> stack;
  };

  std::span<const Node> nodes;
  std::span<const Reference> refs;
  std::span<const Segment> segments;
  Frame frame;

  template <class Sink>
  void operator()(const Ray& ray, Sink& sink, Scratch& scratch) const {
    constexpr float miss = std::numeric_limits<float>::infinity();
    const Slabs slabs(ray, frame);
    auto& stack = scratch.stack;
    stack.clear();
    stack.push_back({0, slabs.enter(nodes[0].box, sink.limit)});
    while (!stack.empty()) {
      auto [index, enter] = stack.back();
      stack.pop_back();
      if (!(enter <= sink.limit)) continue;

      // Go down to a leaf, leaving the farther children for later.
      while (enter != miss && !nodes[index].is_leaf()) {
        std::uint32_t near = index + 1, far = nodes[index].right;
        float enter_near = slabs.enter(nodes[near].box, sink.limit),
              enter_far = slabs.enter(nodes[far].box, sink.limit);
        if (enter_far < enter_near) {
          std::swap(near, far);
          std::swap(enter_near, enter_far);
        }
        if (enter_far != miss) stack.push_back({far, enter_far});
        index = near;
        enter = enter_near;
      }
      if (enter == miss) continue;

      const Node& leaf = nodes[index];
      for (const Reference& ref : refs.subspan(leaf.first_ref, leaf.n_refs)) {
        test_segment(ray, segments[ref.prim], frame, ref, sink);
        if (sink.done()) return;
      }
    }
  }
};

/// Every segment, in order: what the trees are compared with.
struct BruteForce {
  struct Scratch {};

  std::span<const Segment> segments;
  Frame frame;

  template <class Sink>
  void operator()(const Ray& ray, Sink& sink, Scratch&) const {
    for (std::size_t prim = 0; prim < segments.size(); ++prim) {
      test_segment(ray, segments[prim], frame, Reference{std::uint32_t(prim)}, sink);
      if (sink.done()) return;
    }
  }
};

}  // namespace fastlines
