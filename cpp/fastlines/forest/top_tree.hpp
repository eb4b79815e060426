// The top tree of a forest: a wide tree over the boxes of its tiles. It finds the tiles that a ray, a point or a box
// may have to do with. It is conservative, and decides no answer.
//
// Rays are not prepared for it. With p = o − centre, and u the unit of the frame (1/scale), a ray enters and leaves the
// box of a tile, grown by the largest radius there and by
//
//     G = reach·(1 + 2⁻¹⁶) + 2⁻¹⁶·(4·u + |p_x| + |p_y| + |p_z|) + 2·overhang·u,
//
// in units of the caller. The reach is ρ, and with a spread κ at most ρ + κ·(|p| + h), where h is half the diagonal of
// the frame. The exact test of the prepared ray finds hits up to ρ + 2⁻²⁰·(3·u + |o'| + ρ) +
// overhang·u from an axis, and t is off by no more than the tie tolerance, about 2⁻²⁰·(4·u + |p| + ρ) + overhang·u as a
// length (rays/ray.hpp). So 2⁻¹⁶ covers these, and the roundings here, each at most 2⁻²⁴ of a term. No hit in the tile
// has a smaller t than that where the ray enters.
//
// Distances from points are less a margin of 2⁻¹⁸·(4 + |p|∞) in the frame, several times the eps of a point
// (query/proximity/point_query.hpp).
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <vector>

#include "../rays/frame_of.hpp"
#include "../rays/ray_batch.hpp"
#include "../simd/float_x16.hpp"

namespace fastlines {

/// The box around the axes of a tile's primitives, and the largest of their radii.
struct TileBox {
  Box box;
  float max_radius;
};

/// A ray on its way through the boxes of tiles, relative to the centre of the frame. t is in units of the caller's ray.
struct RoutedRay {
  float inverse[3];               ///< 1/d, up to the sign of d
  float to_first[3], to_last[3];  ///< what is subtracted from the planes where the ray enters and leaves
  bool back[3];                   ///< whether d is negative
  float t_min, t_max;
};

class TopTree {
 public:
  TopTree(std::span<const TileBox> tiles, const Box& frame_box) : tiles_(tiles.begin(), tiles.end()) {
    float max_radius = 0.0f;
    for (const TileBox& tile : tiles) max_radius = std::max(max_radius, tile.max_radius);
    frame_ = frame_of(frame_box, max_radius);
    if (!frame_box.is_empty())
      half_diagonal_ = float(std::hypot(frame_box.side(0), frame_box.side(1), frame_box.side(2)));
    const float unit = 1.0f / frame_.scale;
    margin_ =
        (kRelative * 4.0f + 2.0f * frame_.overhang) * unit + kRelative * max_radius + std::numeric_limits<float>::min();
    std::vector<std::uint32_t> order(tiles.size());
    std::iota(order.begin(), order.end(), 0u);
    nodes_.emplace_back();
    fill_node(0, order);
  }

  std::size_t n_tiles() const { return tiles_.size(); }
  const Frame& frame() const { return frame_; }

  /// A ray, ready for `for_each_on_ray`.
  RoutedRay routed(const RayQuery& ray) const {
    RoutedRay routed;
    Vec3 p;
    float far = 0.0f, longest = 0.0f;
    for (int k = 0; k < 3; ++k) {
      p[k] = ray.origin[k] - frame_.centre[k];
      far += std::fabs(p[k]);
      longest = std::max(longest, std::fabs(ray.direction[k]));
    }
    float reach = ray.radius;
    // Not √(p·p), which floats cannot hold where the scene is tiny.
    if (ray.spread > 0.0f) reach += ray.spread * (float(std::hypot(p[0], p[1], p[2])) + half_diagonal_);
    const float grow = reach + kRelative * (reach + far) + margin_;
    // A component that moves the ray by less than the margin counts as this much.
    const float least = std::max(longest * 1e-12f, std::numeric_limits<float>::min());
    for (int k = 0; k < 3; ++k) {
      const float d = ray.direction[k];
      routed.back[k] = d < 0.0f;
      routed.inverse[k] = (routed.back[k] ? -1.0f : 1.0f) / std::max(std::fabs(d), least);
      routed.to_first[k] = p[k] + (routed.back[k] ? -grow : grow);
      routed.to_last[k] = p[k] + (routed.back[k] ? grow : -grow);
    }
    routed.t_min = ray.t_min;
    routed.t_max = ray.t_max;
    // What floats hold badly is routed everywhere.
    if (!(longest > 1e-20f && longest < 1e20f && grow < 1e20f)) {
      for (int k = 0; k < 3; ++k) {
        routed.inverse[k] = 1.0f;
        routed.back[k] = false;
        routed.to_first[k] = kInfinity;
        routed.to_last[k] = -kInfinity;
      }
    }
    return routed;
  }

  /// Call visit(tile, enter) for each tile that the ray may have hits in, in no order; no hit there has a smaller t
  /// than `enter`.
  template <class Visit>
  void for_each_on_ray(const RoutedRay& ray, Visit&& visit) const {
    std::uint32_t stack[kMaxStack] = {0};
    for (int n_stack = 1; n_stack > 0;) {
      const Node& node = nodes_[stack[--n_stack]];
      FloatX16 enter = ray.t_min, leave = ray.t_max;
      for (int k = 0; k < 3; ++k) {
        const FloatX16 first = FloatX16::load(ray.back[k] ? node.high[k] : node.low[k]);
        const FloatX16 last = FloatX16::load(ray.back[k] ? node.low[k] : node.high[k]);
        enter = max(enter, (first - FloatX16(ray.to_first[k])) * FloatX16(ray.inverse[k]));
        leave = min(leave, (last - FloatX16(ray.to_last[k])) * FloatX16(ray.inverse[k]));
      }
      float at[kSimdWidth];
      enter.store(at);
      for (std::uint32_t hit = (enter <= leave).bits() & node.lanes(); hit; hit &= hit - 1) {
        const int i = std::countr_zero(hit);
        if (node.is_tile(i))
          visit(node.child[i], at[i]);
        else
          stack[n_stack++] = node.child[i];
      }
    }
  }

  /// Call visit(tile, distance) for each tile whose distance from a box is at most `limit()`, in no order; the limit
  /// may fall. Distances are lower bounds, in units of the scene; with `surface` those from surfaces, which are
  /// negative inside.
  template <class Limit, class Visit>
  void for_each_near(const double (&low)[3], const double (&high)[3], bool surface, Limit&& limit,
                     Visit&& visit) const {
    // The frame's float coordinates of a tile are rounded; so is what the exact test computes.
    double at[2][3], farthest = 0.0;
    for (int k = 0; k < 3; ++k) {
      at[0][k] = (low[k] - double(frame_.centre[k])) * frame_.scale;
      at[1][k] = (high[k] - double(frame_.centre[k])) * frame_.scale;
      farthest = std::max({farthest, std::fabs(at[0][k]), std::fabs(at[1][k])});
    }
    const double margin = 0x1p-18 * (4.0 + farthest) + frame_.overhang, unit = 1.0 / frame_.scale;
    struct Entry {
      std::uint32_t node;
      double distance;
    };
    std::vector<Entry> stack(1, {0, -double(kInfinity)});
    while (!stack.empty()) {
      const Entry entry = stack.back();
      stack.pop_back();
      if (!(entry.distance <= limit())) continue;
      const Node& node = nodes_[entry.node];
      Entry inner[kSimdWidth];
      int n_inner = 0;
      for (int i = 0; i < node.n; ++i) {
        double dist2 = 0.0;
        for (int k = 0; k < 3; ++k) {
          const double beyond = std::max({node.axis_low[k][i] - at[1][k], at[0][k] - node.axis_high[k][i], 0.0});
          dist2 += beyond * beyond;
        }
        const double distance = (std::sqrt(dist2) - margin - (surface ? node.radius[i] : 0.0f)) * unit;
        if (!(distance <= limit())) continue;
        if (node.is_tile(i))
          visit(node.child[i], distance);
        else
          inner[n_inner++] = {node.child[i], distance};
      }
      // The nearest is on top.
      std::sort(inner, inner + n_inner, [](const Entry& a, const Entry& b) { return a.distance > b.distance; });
      stack.insert(stack.end(), inner, inner + n_inner);
    }
  }

 private:
  /// Up to 16 children: boxes grown by radii, relative to the centre of the frame, for rays; boxes and radii in the
  /// frame, for points. `tiles` is a mask of the children that are tiles.
  struct alignas(64) Node {
    float low[3][kSimdWidth], high[3][kSimdWidth];
    float axis_low[3][kSimdWidth], axis_high[3][kSimdWidth], radius[kSimdWidth];
    std::uint32_t child[kSimdWidth], tiles = 0;
    int n = 0;

    std::uint32_t lanes() const { return (1u << n) - 1; }
    bool is_tile(int i) const { return tiles >> i & 1; }

    void add(const Frame& frame, const TileBox& of, std::uint32_t child_) {
      radius[n] = of.max_radius * frame.scale;
      const Vec3 lo = frame(of.box.lo), hi = frame(of.box.hi);
      for (int k = 0; k < 3; ++k) {
        axis_low[k][n] = lo[k];
        axis_high[k][n] = hi[k];
        low[k][n] = of.box.lo[k] - frame.centre[k] - of.max_radius;
        high[k][n] = of.box.hi[k] - frame.centre[k] + of.max_radius;
      }
      child[n++] = child_;
    }
  };

  /// Children of a node hold about as many tiles each, so 2³² tiles take nine levels, each with 15 nodes that wait.
  static constexpr int kMaxStack = 160;

  /// Divide these tiles, in place, into up to 16 children of about as many each.
  void fill_node(std::size_t index, std::span<std::uint32_t> tiles) {
    for (Node& node = nodes_[index]; auto* planes : {&node.low, &node.high, &node.axis_low, &node.axis_high})
      for (auto& axis : *planes) std::fill(axis, axis + kSimdWidth, 0.0f);
    std::vector<std::span<std::uint32_t>> parts;
    if (!tiles.empty()) parts.push_back(tiles);
    while (parts.size() < kSimdWidth) {
      const auto largest =
          std::max_element(parts.begin(), parts.end(), [](auto& a, auto& b) { return a.size() < b.size(); });
      if (largest == parts.end() || largest->size() < 2) break;
      const std::span<std::uint32_t> whole = *largest;
      halve(whole);
      *largest = whole.first(whole.size() / 2);
      parts.push_back(whole.subspan(whole.size() / 2));
    }
    for (const std::span<std::uint32_t> part : parts) {
      TileBox of{Box::empty(), 0.0f};
      for (const std::uint32_t tile : part) {
        of.box.grow(tiles_[tile].box);
        of.max_radius = std::max(of.max_radius, tiles_[tile].max_radius);
      }
      if (part.size() == 1) {
        nodes_[index].tiles |= 1u << nodes_[index].n;
        nodes_[index].add(frame_, of, part[0]);
      } else {
        const std::size_t child = nodes_.size();
        nodes_[index].add(frame_, of, std::uint32_t(child));
        nodes_.emplace_back();
        fill_node(child, part);
      }
    }
  }

  /// Halve tiles at the median of their centres, along the axis on which these are farthest apart.
  void halve(std::span<std::uint32_t> tiles) const {
    const auto centre = [&](std::uint32_t tile, int k) {
      return 0.5 * (double(tiles_[tile].box.lo[k]) + double(tiles_[tile].box.hi[k]));
    };
    int axis = 0;
    double widest = -1.0;
    for (int k = 0; k < 3; ++k) {
      double low = kInfinity, high = -kInfinity;
      for (const std::uint32_t tile : tiles) {
        low = std::min(low, centre(tile, k));
        high = std::max(high, centre(tile, k));
      }
      if (high - low > widest) {
        widest = high - low;
        axis = k;
      }
    }
    std::nth_element(tiles.begin(), tiles.begin() + std::ptrdiff_t(tiles.size() / 2), tiles.end(),
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double of_a = centre(a, axis), of_b = centre(b, axis);
                       return of_a != of_b ? of_a < of_b : a < b;
                     });
  }

  static constexpr float kRelative = 0x1p-16f;
  std::vector<TileBox> tiles_;
  Frame frame_;
  float half_diagonal_ = 0.0f;  // of the frame, or more
  float margin_ = 0.0f;         // of all rays
  std::vector<Node> nodes_;
};

}  // namespace fastlines
