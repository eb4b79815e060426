// Rays and points for a scene: through what it holds, along it, beside it and past it.
#pragma once

#include <cmath>
#include <vector>

#include "fastlines/math/box.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/rays/ray.hpp"
#include "tests/random.hpp"

namespace fastlines::fuzz {

/// The axes, or the edges, of what a scene holds.
inline void add_edges(const Segment& segment, std::vector<Segment>& to) { to.push_back(segment); }
inline void add_edges(const RoundCone& cone, std::vector<Segment>& to) { to.push_back(cone.axis); }
inline void add_edges(const Shape& shape, std::vector<Segment>& to) {
  if (shape.kind() == Shape::triangle) {
    const auto& corners = reinterpret_cast<const Vec3(&)[3]>(shape.numbers);
    for (int k = 0; k < 3; ++k) to.push_back({corners[k], corners[(k + 1) % 3]});
  } else {
    to.push_back(shape.as<Segment>());  // the axis of a round cone, the diagonal of a box
  }
}

/// Draws rays and points; the same ones for the same seed.
class Probes {
 public:
  Probes(std::uint64_t seed, std::vector<Segment> edges, const Box& box) : random_{seed}, edges_(std::move(edges)) {
    if (edges_.empty()) edges_.push_back({box.lo, box.hi});
    size_ = float(box.side(box.longest_axis()));
    for (int k = 0; k < 3 && !(size_ > 0.0f); ++k) size_ = std::fabs(box.lo[k]);
    if (!(size_ > 0.0f)) size_ = 1.0f;
  }

  std::size_t below(std::size_t n) { return random_.below(n); }

  /// A ray, which may be invalid: its direction may have no length, or t_min may be beyond t_max.
  RayQuery ray() {
    RayQuery ray{place(), random_.direction() * size_, 0.0f, kInfinity, radius()};
    switch (random_.below(8)) {
      case 0:  // from outside
        ray.origin = ray.origin - ray.direction * 3.0f;
        break;
      case 1:
      case 2:
      case 3: {  // along an axis of coordinates, and so along the sides of boxes
        const std::size_t axis = random_.below(3);
        ray.direction = {0, 0, 0};
        ray.direction[int(axis)] = random_.below(2) ? size_ : -size_;
        if (random_.below(2)) ray.origin = ray.origin - ray.direction * 2.0f;
        break;
      }
      case 4:  // through two places
        ray.direction = place() - ray.origin;
        ray.origin = ray.origin - ray.direction;
        break;
      case 5: {  // along an edge
        const Segment& edge = edges_[random_.below(edges_.size())];
        ray.direction = edge.q - edge.p;
        break;
      }
      case 6:  // past everything
        ray.origin = ray.origin + random_.direction() * (4.0f * size_);
        break;
      default:  // from a place in the scene
        break;
    }
    if (random_.below(4) == 0) ray.t_min = random_.uniform(-2.0f, 2.0f);
    if (random_.below(4) == 0) ray.t_max = random_.uniform(-1.0f, 4.0f);
    return ray;
  }

  /// A point on an edge, near to one, or far away.
  Vec3 point() {
    const float away[] = {0.0f, 1e-6f, 1e-3f, 0.1f, 10.0f};
    return place() + random_.direction() * (size_ * away[random_.below(5)]);
  }

  float radius() {
    const float sizes[] = {0.0f, 0.0f, 1e-7f, 1e-6f, 1e-4f, 0.01f, 0.3f, 3.0f};
    return size_ * sizes[random_.below(8)];
  }

 private:
  /// A point on an edge, often an end of it.
  Vec3 place() {
    const Segment& edge = edges_[random_.below(edges_.size())];
    const float s[] = {0.0f, 1.0f, 0.0f, 1.0f, 0.5f, random_.uniform()};
    return edge.point(s[random_.below(6)]);
  }

  test::Random random_;
  std::vector<Segment> edges_;
  float size_;
};

/// A seed that depends on all bytes (FNV-1a).
template <class Byte>
std::uint64_t seed_of(std::span<const Byte> bytes) {
  std::uint64_t hash = 0xcbf2'9ce4'8422'2325;
  for (const Byte byte : bytes) hash = (hash ^ std::uint64_t(byte)) * 0x100'0000'01b3;
  return hash;
}

}  // namespace fastlines::fuzz
