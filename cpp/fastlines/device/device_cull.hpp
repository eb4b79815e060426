// Culls the children of a node and the pieces of a leaf, for one ray.
//
// Both tests are those of kernels/intersect, lane by lane, with float axes. Their bounds are the same, so nothing is
// lost: each rounding may differ from that of any instruction set, and the slack covers all of them.
#pragma once

#include "../layout/leaf_bytes.hpp"
#include "../layout/wide_blocks.hpp"
#include "../math/vec.hpp"
#include "../rays/ray.hpp"
#include "thread.hpp"

#if !defined(FASTLINES_NODE_ROWS)
/// How a thread reads the planes of a node: 0 = four children at a time, and only as many as there are; 1 = all 16, in
/// rows of 16 bytes. Which is faster is not measured yet.
#define FASTLINES_NODE_ROWS 0
#endif

namespace fastlines {

/// Byte i, 0 to 3, of a word as a float; the machine is little-endian.
inline float byte_of(std::uint32_t word, int i) { return float(word >> 8 * i & 0xff); }

/// A row of the planes of a node: a byte for each of its children.
struct alignas(16) PlaneRow {
  std::uint32_t words[kSimdWidth / 4];
};

/// A ray prepared for culling (`CullRayOf` and `ProjectedRayOf` in kernels/intersect).
struct DeviceCullRay {
  const Ray& ray;
  float cull_radius;
  float inverse[3], near[3], far[3];  // t of a near plane: q·(scale·inverse) + (org·inverse + near)
  int near_row[3], far_row[3];        // rows of planes
  float offset_u, offset_v;           // minus the projections of the ray's origin

  explicit DeviceCullRay(const Ray& ray_) : ray(ray_), cull_radius(ray_.radius + ray_.eps) {
    for (int k = 0; k < 3; ++k) {
      const bool back = ray.r[k] < 0.0f;
      inverse[k] = (back ? -1.0f : 1.0f) / max(abs(ray.r[k]), 1e-18f);
      const float grow = back ? 0.0f - cull_radius : cull_radius;
      near[k] = (0.0f - (ray.o[k] + grow)) * inverse[k];
      far[k] = (grow - ray.o[k]) * inverse[k];
      near_row[k] = back ? k + 3 : k;
      far_row[k] = back ? k : k + 3;
    }
    offset_u = 0.0f - along(ray.u, ray.o[0], ray.o[1], ray.o[2], 0.0f);
    offset_v = 0.0f - along(ray.v, ray.o[0], ray.o[1], ray.o[2], 0.0f);
  }

  /// start + the projection of a point onto an axis.
  static float along(const Vec3& axis, float x, float y, float z, float start) {
    return fma(z, axis[2], fma(y, axis[1], fma(x, axis[0], start)));
  }
};

/// The grid of a block of boxes along a ray: of a node, or of a leaf of boxes.
struct DeviceBoxCull {
  const DeviceCullRay& ray;
  float step[3], to_near[3], to_far[3];

  template <class Block>
  DeviceBoxCull(const DeviceCullRay& ray_, const Block& block) : ray(ray_) {
    for (int k = 0; k < 3; ++k) {
      step[k] = ray.inverse[k] * block.scale;
      to_near[k] = fma(ray.inverse[k], block.org[k], ray.near[k]);
      to_far[k] = fma(ray.inverse[k], block.org[k], ray.far[k]);
    }
  }

  /// Whether the ray may hit a box, grown by the culling radius, before `limit`, and where it enters: t in the frame.
  /// near(k) and far(k) are the box's planes on axis k, in quanta, in the order in which the ray meets them.
  template <class Near, class Far>
  bool clip(const Near& near, const Far& far, float limit, float& enter) const {
    float leave = limit;
    enter = ray.ray.t_min;
    for (int k = 0; k < 3; ++k) {
      enter = max(fma(near(k), step[k], to_near[k]), enter);
      leave = min(fma(far(k), step[k], to_far[k]), leave);
    }
    return enter <= leave;
  }
};

/// Calls visit(i, enter) for each of the first n boxes of a block that the ray, with its culling radius, may hit before
/// `limit`; in their order. `enter` is where it enters the box: t in the frame.
template <class Block, class Visit>
[[gnu::always_inline]] inline void cull_boxes(const DeviceCullRay& ray, const Block& block, const std::uint8_t* planes,
                                              int n, float limit, const Visit& visit) {
  const DeviceBoxCull cull(ray, block);
  // Where the ray enters a box, given by four bytes of each plane, and whether it hits it.
  const auto clip = [&](const auto& near_words, const auto& far_words, int i, float& enter) {
    return cull.clip([&](int k) { return byte_of(near_words(k), i); }, [&](int k) { return byte_of(far_words(k), i); },
                     limit, enter);
  };
  const auto* const rows = reinterpret_cast<const PlaneRow*>(planes);
  if constexpr (FASTLINES_NODE_ROWS) {
    PlaneRow near_rows[3], far_rows[3];
    for (int k = 0; k < 3; ++k) {
      near_rows[k] = rows[ray.near_row[k]];
      far_rows[k] = rows[ray.far_row[k]];
    }
    float enters[kSimdWidth];
    std::uint32_t hit = 0;
    FASTLINES_UNROLL
    for (int child = 0; child < kSimdWidth; ++child) {
      const bool is_hit = clip([&](int k) { return near_rows[k].words[child / 4]; },
                               [&](int k) { return far_rows[k].words[child / 4]; }, child % 4, enters[child]);
      hit |= std::uint32_t(is_hit) << child;
    }
    for (hit &= (1u << n) - 1; hit; hit &= hit - 1) {
      const int child = lowest_bit(hit);
      visit(child, enters[child]);
    }
  } else {
    // For architectures from sm_100 on, the assembler would unroll this loop: into far larger kernels, and slowly.
    FASTLINES_NO_UNROLL
    for (int first = 0; first < n; first += 4) {
      std::uint32_t near_words[3], far_words[3];
      for (int k = 0; k < 3; ++k) {
        near_words[k] = rows[ray.near_row[k]].words[first / 4];
        far_words[k] = rows[ray.far_row[k]].words[first / 4];
      }
      for (int i = 0; i < 4; ++i) {
        float enter;
        const bool is_hit = clip([&](int k) { return near_words[k]; }, [&](int k) { return far_words[k]; }, i, enter);
        if (is_hit && first + i < n) visit(first + i, enter);
      }
    }
  }
}

/// Calls visit(child, enter) for each child of a node whose box the ray may hit before `limit` (`cull_boxes`).
template <class Visit>
[[gnu::always_inline]] inline void cull_children(const DeviceCullRay& ray, const WideNode& node, float limit,
                                                 const Visit& visit) {
  cull_boxes(ray, node, node.planes, node.n_children, limit, visit);
}

/// A leaf of axes in the projection along a ray.
template <bool has_radius>
struct DeviceAxisCull {
  const Vec3 &axis_u, &axis_v;
  float u, v, cull_radius2;

  DeviceAxisCull(const DeviceCullRay& ray, const WideLeaf& leaf) : axis_u(ray.ray.u), axis_v(ray.ray.v) {
    // If it is twice as large as the leaf, all pieces that can be within it pass: also where squares overflow.
    constexpr float pass_all = 512.0f, huge = 1e30f, farthest = 1e15f;
    const auto start = [&](const Vec3& axis, float offset) {
      const float at = DeviceCullRay::along(axis, leaf.org[0], leaf.org[1], leaf.org[2], offset) * leaf.inv_scale;
      return min(max(at, -farthest), farthest);
    };
    u = start(axis_u, ray.offset_u);
    v = start(axis_v, ray.offset_v);
    float cull_radius = fma(ray.cull_radius, leaf.inv_scale, 0.89f);
    if constexpr (has_radius) cull_radius += leaf.radius;
    cull_radius2 = max(cull_radius * cull_radius, fma(cull_radius, huge, -huge * pass_all));
  }

  /// Whether a piece from a to c, in quanta, may come within the culling radius of the ray's line.
  bool may_hit(float ax, float ay, float az, float cx, float cy, float cz) const {
    constexpr float rounding = 0.5f, tiny = 1e-30f;
    const float au = DeviceCullRay::along(axis_u, ax, ay, az, u), av = DeviceCullRay::along(axis_v, ax, ay, az, v);
    const float cu = DeviceCullRay::along(axis_u, cx, cy, cz, u), cv = DeviceCullRay::along(axis_v, cx, cy, cz, v);
    const float back_u = au - cu, wv = cv - av;  // w = c − a with u negated, so that the cross product is a sum
    const float cross = fma(au, wv, av * back_u), ww = fma(back_u, back_u, wv * wv);
    const float a_near = fma(-au, au, fma(-av, av, cull_radius2)), c_near = fma(-cu, cu, fma(-cv, cv, cull_radius2));
    // The line fails if the piece is a point: then the ends decide.
    const float line = fma(-cross, cross, fma(ww, cull_radius2, -tiny));
    // The foot of the perpendicular is between the ends.
    const float inside = (ww + rounding) - abs(a_near - c_near);
    return !((line < 0.0f || inside < 0.0f) && a_near < 0.0f && c_near < 0.0f);
  }
};

/// A mask of the pieces of a leaf of axes that may come within the culling radius of the ray's line.
template <bool has_radius>
[[gnu::always_inline]] inline std::uint32_t cull_axes(const DeviceCullRay& ray, const WideLeaf& leaf) {
  const DeviceAxisCull<has_radius> cull(ray, leaf);
  const auto* const words = reinterpret_cast<const std::uint32_t*>(leaf.ends);
  std::uint32_t near = 0;
  for (int pair = 0; 2 * pair < leaf.n_refs; ++pair) {
    // A word has the bytes of two pieces.
    const std::uint32_t as = words[end_byte(0, 0, 0) / 4 + pair], zs = words[end_byte(0, 2, 0) / 4 + pair],
                        cs = words[end_byte(1, 0, 0) / 4 + pair];
    for (int i = 0; i < 2; ++i) {
      const bool may_hit = cull.may_hit(byte_of(as, 2 * i), byte_of(as, 2 * i + 1), byte_of(zs, 2 * i),
                                        byte_of(cs, 2 * i), byte_of(cs, 2 * i + 1), byte_of(zs, 2 * i + 1));
      near |= std::uint32_t(may_hit) << (2 * pair + i);
    }
  }
  return near & ((1u << leaf.n_refs) - 1);
}

/// A mask of the pieces of a leaf that may come within the culling radius of the ray, or of its line.
template <class P>
[[gnu::always_inline]] inline std::uint32_t cull_pieces(const DeviceCullRay& ray, const WideLeaf& leaf) {
  if constexpr (P::kHasBoxes)
    if (leaf.shape == LeafShape::boxes) {
      std::uint32_t near = 0;
      cull_boxes(ray, leaf, leaf.ends, leaf.n_refs, kInfinity, [&](int i, float) { near |= 1u << i; });
      return near;
    }
  return cull_axes<P::kHasRadius>(ray, leaf);
}

}  // namespace fastlines
