// Culls millions of pairs of a ray and a piece. No piece within the radius of a ray's line, in double precision or by
// the exact test, may be culled. Its box must survive too, as a child of a node and of the root, and must be entered
// before the hit. Rays pass pieces at just the radius, on all sides and also along them; pieces are long, short, or
// points. Few pieces that are farther away survive.
#include <cmath>
#include <random>

#include "check.hpp"
#include "fastlines/kernels/intersect/root_cull.hpp"
#include "fastlines/primitives/segment_test.hpp"

namespace {

using namespace fastlines;

std::mt19937 random_bits(20);

double uniform(double from, double to) { return std::uniform_real_distribution<double>(from, to)(random_bits); }

Vec3 direction() {
  const double z = uniform(-1.0, 1.0), angle = uniform(0.0, 6.283185307), flat = std::sqrt(1.0 - z * z);
  Vec3 d{float(flat * std::cos(angle)), float(flat * std::sin(angle)), float(z)};
  if (random_bits() % 4 == 0) d[random_bits() % 3] = 0.0f;
  return d[0] == 0.0f && d[1] == 0.0f && d[2] == 0.0f ? Vec3{1.0f, 0.0f, 0.0f} : d;
}

/// 16 pieces in the frame, their leaf, and a node with their boxes, as layout/block_encoder.hpp makes them.
struct Pieces {
  Vec3 a[kSimdWidth], c[kSimdWidth];
  WideLeaf leaf{};
  WideNode node{};

  Pieces() {
    const double size = std::pow(10.0, uniform(-5.0, -0.5)), length = std::pow(10.0, uniform(-4.0, 0.0));
    const Vec3 corner{float(uniform(-1.0, 0.6)), float(uniform(-1.0, 0.6)), float(uniform(-1.0, 0.6))};
    float side = 0x1p-20f;
    for (int k = 0; k < 3; ++k) {
      float lo = 2.0f, hi = -2.0f;
      for (int i = 0; i < kSimdWidth; ++i) {
        a[i][k] = corner[k] + float(size * uniform(0.0, 1.0));
        c[i][k] = i % 8 == 7 ? a[i][k] : a[i][k] + float(size * length * uniform(-1.0, 1.0));
        lo = std::min({lo, a[i][k], c[i][k]});
        hi = std::max({hi, a[i][k], c[i][k]});
      }
      leaf.org[k] = lo;
      side = std::max(side, hi - lo);
    }
    leaf.scale = side * float((1 + 1e-6) / 255);
    leaf.inv_scale = 1.0f / leaf.scale;
    leaf.n_refs = kSimdWidth;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < kSimdWidth; ++i) {
        leaf.ends[end_byte(0, k, i)] = std::uint8_t((a[i][k] - leaf.org[k]) * leaf.inv_scale + 0.5f);
        leaf.ends[end_byte(1, k, i)] = std::uint8_t((c[i][k] - leaf.org[k]) * leaf.inv_scale + 0.5f);
      }
    node.scale = side * float(1.0004 / 254);
    node.n_inner = node.n_children = kSimdWidth;
    for (int k = 0; k < 3; ++k) {
      node.org[k] = leaf.org[k] - 2e-4f * side;
      for (int i = 0; i < kSimdWidth; ++i) {
        const auto quanta = [&](float x) { return (x - node.org[k]) / node.scale; };
        const float low = quanta(std::min(a[i][k], c[i][k])), high = quanta(std::max(a[i][k], c[i][k]));
        node.planes[k * kSimdWidth + i] = std::uint8_t(std::max(low - 0.02f, 0.0f));
        node.planes[(k + 3) * kSimdWidth + i] = std::uint8_t(std::min(std::ceil(high + 0.02f), 255.0f));
      }
    }
  }
};

/// The distance of a piece from the ray's line.
double distance(const Ray& ray, const Vec3& a, const Vec3& c) {
  double p[3], e[3], length2 = 0.0, pr = 0.0, er = 0.0, ee = 0.0, pe = 0.0;
  for (int k = 0; k < 3; ++k) length2 += double(ray.r[k]) * ray.r[k];
  for (int k = 0; k < 3; ++k) {
    p[k] = double(a[k]) - ray.o[k];
    e[k] = double(c[k]) - a[k];
    pr += p[k] * ray.r[k] / length2;
    er += e[k] * ray.r[k] / length2;
  }
  for (int k = 0; k < 3; ++k) {
    p[k] -= pr * ray.r[k];
    e[k] -= er * ray.r[k];
    ee += e[k] * e[k];
    pe += p[k] * e[k];
  }
  const double s = ee > 0.0 ? std::min(std::max(-pe / ee, 0.0), 1.0) : 0.0;
  double d2 = 0.0;
  for (int k = 0; k < 3; ++k) d2 += (p[k] + s * e[k]) * (p[k] + s * e[k]);
  return std::sqrt(d2);
}

/// The children of a node that a ray hits, as a mask, and the t at which it enters each.
struct NodeHits {
  std::uint32_t children;
  float enter[kSimdWidth];
};

NodeHits hits_of(const CullRay& ray, const WideNode& node, float limit) {
  NodeHits hits;
  FloatX16 enter;
  hits.children = cull_node(ray, node, limit, enter);
  enter.store(hits.enter);
  return hits;
}

/// The same for a packet that starts at lane `first`, with the node as the root.
void root_hits_of(const RayGroup& rays, int first, const WideNode& node, NodeHits* to) {
  WideBvhView<Segments> tree{};
  tree.nodes = &node;
  RootCull::Hits hits;
  RootCull(tree).cull<true>(cull_packet(rays, first), FloatX16::load(rays.t_max + first), hits);
  for (int i = 0; i < kSimdWidth; ++i) {
    to[i].children = std::uint32_t(hits.children[i]);
    for (int child = 0; child < kSimdWidth; ++child) to[i].enter[child] = hits.enter[child][i];
  }
}

void cull() {
  const Frame frame = frame_of(Box{{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}});  // scale 1, centre 0
  std::uint64_t n_near = 0, n_kept = 0, n_lost = 0;
  for (int leaf = 0; leaf < 4000; ++leaf) {
    const Pieces pieces;
    std::vector<Vec3> origins, directions;
    std::vector<float> radii;
    std::uint32_t ids[kGroupSize];
    for (int i = 0; i < kGroupSize; ++i) {
      const int of = int(random_bits() % kSimdWidth);
      const Vec3 at = pieces.a[of] + (pieces.c[of] - pieces.a[of]) * float(uniform(0.0, 1.0));
      Vec3 d = direction();
      if (i % 4 == 0)
        d = (pieces.c[of] - pieces.a[of]) * (1.0f / pieces.leaf.scale) + d * float(std::pow(10.0, uniform(-6, 0)));
      if (!(dot(d, d) > 1e-12f)) d = direction();
      // The ray passes that point at the radius or a little nearer, and starts anywhere on its line. Some radii are so
      // large that their squares in quanta overflow a float.
      const double radius = std::min(1e17, pieces.leaf.scale * std::pow(10.0, uniform(-3.0, i % 8 == 0 ? 27.0 : 3.5)));
      Vec3 side = direction();
      side = side - d * (dot(side, d) / dot(d, d));
      side = side * (1.0f / std::sqrt(dot(side, side) + 1e-30f));
      side = side * float(radius * (1.0 - std::pow(10.0, uniform(-7.0, -1.0))));
      origins.push_back(at + side + d * float(uniform(-3.0, 3.0) / std::sqrt(dot(d, d))));
      directions.push_back(d);
      radii.push_back(float(radius));
      ids[i] = std::uint32_t(i);
    }
    const float t_min = -1e30f, t_max = 1e30f;
    RayGroup rays;
    const RayBatch batch{origins, directions, radii, {&t_min, 1}, {&t_max, 1}};
    rays.fill(batch, frame, kGroupSize, ids);
    CullRay culled[kGroupSize];
    NodeHits root_hits[kGroupSize];
    for (int i = 0; i < kGroupSize; i += kSimdWidth) {
      cull_rays(rays, i, culled + i);
      root_hits_of(rays, i, pieces.node, root_hits + i);
    }
    for (int i = 0; i < kGroupSize; ++i) {
      // Cull the leaf with the ray prepared in a packet, and alone.
      const Ray ray = prepare(batch[std::size_t(i)], frame);
      const CullRay alone = cull_ray(ray.o, ray.r, ray.u, ray.v, ray.radius + ray.eps, ray.t_min);
      const auto keep = [&](const CullRay& cull) {
        return cull_leaf(cull.projected, pieces.leaf, leaf_offset(pieces.leaf, cull.projected));
      };
      const std::uint32_t kept[2] = {keep(culled[i]), keep(alone)};
      n_kept += std::uint64_t(std::popcount(kept[0]));
      const NodeHits node_hits = hits_of(culled[i], pieces.node, ray.t_max);
      for (int j = 0; j < kSimdWidth; ++j) {
        const Vec3 e = pieces.c[j] - pieces.a[j];
        const ClosestApproach<float> approach = closest_approach(
            ray,
            to_ray_frame<float>(ray, std::array{pieces.a[j][0], pieces.a[j][1], pieces.a[j][2], e[0], e[1], e[2]}));
        if (!approach.hit && !(distance(ray, pieces.a[j], pieces.c[j]) <= double(ray.radius))) continue;
        ++n_near;
        n_lost += (~kept[0] | ~kept[1]) >> j & 1;
        for (const NodeHits& hits : {node_hits, root_hits[i]}) {
          n_lost += ~hits.children >> j & 1;
          n_lost += approach.hit && !(hits.enter[j] <= approach.t + ray.tie_tolerance);
        }
      }
    }
  }
  test::check(n_lost == 0, "nothing within the radius is culled");
  test::check(200'000 < n_near && n_near <= n_kept, "many pieces are within the radius");
  test::check(n_kept < 2 * n_near, "few other pieces survive");
}

}  // namespace

int main() { return test::run(cull); }
