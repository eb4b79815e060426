// Crossings: where a ray passes once through a primitive that is cut into pieces, as a curve is into round cones.
//
// Pieces of one primitive whose intervals from entry to exit overlap are one crossing. A ray with a spread has no such
// intervals; there, a run of neighbouring pieces is a crossing. The closest approach of a crossing is that of its piece
// with the least D − R, the distance of the ray from the axis less the reach; then of the lower t, then the lower
// piece. So it depends neither on the radius of the query nor on how finely the primitive is cut.
//
// With `At::entry`, a crossing counts if the ray enters each of its pieces: it then starts outside of all of them.
//
// Pieces are rows of the primitives that searches find. The pieces of one primitive follow each other.
#pragma once

#include <concepts>

#include "../primitives/shapes.hpp"
#include "../simd/transpose.hpp"
#include "for_each_ray.hpp"

namespace fastlines {

/// The pieces from `first` up to `end`.
struct PieceRange {
  std::int64_t first, end;
  std::int64_t size() const { return end - first; }
};

/// The primitives that pieces belong to.
struct PieceOwners {
  std::span<const std::int64_t> of_piece;  ///< the primitive of each piece; empty if each piece is one

  bool is_same(std::int64_t piece, std::int64_t other) const {
    return of_piece.empty() ? piece == other : of_piece[std::size_t(piece)] == of_piece[std::size_t(other)];
  }
  /// All pieces of the primitive that a piece belongs to.
  PieceRange pieces_beside(std::int64_t piece) const {
    PieceRange all{piece, piece + 1};
    if (of_piece.empty()) return all;
    while (all.first > 0 && is_same(piece, all.first - 1)) --all.first;
    while (all.end < std::int64_t(of_piece.size()) && is_same(piece, all.end)) ++all.end;
    return all;
  }
};

/// Pieces that each ray hits, and the primitives that they belong to.
struct PieceLists {
  std::span<const std::int64_t> offsets;  ///< the pieces of ray i are those from offsets[i] up to offsets[i + 1]
  std::span<const std::int64_t> pieces;
  PieceOwners owners;
  bool is_complete;  ///< whether all pieces that a ray hits are listed, or some of each primitive

  std::span<const std::int64_t> of_ray(std::size_t i) const {
    return pieces.subspan(std::size_t(offsets[i]), std::size_t(offsets[i + 1] - offsets[i]));
  }
};

/// The radius that a primitive has of its own at s, in units of the scene.
template <class Item>
double own_radius(const Item& item, double s) {
  if constexpr (requires { item.radius1; })
    return item.radius0 + s * (double(item.radius1) - item.radius0);
  else if constexpr (std::same_as<Item, Shape>)
    return item.kind() == Shape::round_cone ? own_radius(item.template as<RoundCone>(), s) : 0.0;
  else
    return 0.0;
}

/// Finds the crossings of rays; one per thread.
template <RayPrimitive P>
class CrossingFinder {
 public:
  CrossingFinder(const typename P::Item* items, const Frame& frame, PieceOwners owners, At at)
      : items_(items), frame_(frame), owners_(owners), at_(at) {}

  /// Replace `to` by the crossings of a ray, as hits of one of their pieces: at the surface the first, else that of the
  /// closest approach. Unless the listed pieces are complete, all pieces of their primitives are tested.
  void find(const RayQuery& query, std::span<const std::int64_t> listed, bool is_complete, std::vector<Hit>& to) {
    to.clear();
    if (listed.empty()) return;
    const auto ray = prepare_for<P>(query, frame_);
    choose_pieces(ray, listed, is_complete);
    hits_.clear();
    test(query, ray, pieces_.size(), [&](std::size_t i) { return pieces_[i]; });
    // Join the hits of each primitive.
    for (auto begin = hits_.begin(), next = begin; begin != hits_.end(); begin = next) {
      while (next != hits_.end() && owners_.is_same(begin->closest.prim, next->closest.prim)) ++next;
      list_crossings(std::span(begin, next), to);
    }
  }

  /// The same with the one primitive that these are the pieces of.
  void find_of_one(const RayQuery& query, PieceRange pieces, std::vector<Hit>& to) {
    to.clear();
    const auto ray = prepare_for<P>(query, frame_);
    hits_.clear();
    if (pieces.size() <= kFew) {
      test(query, ray, std::size_t(pieces.size()), [&](std::size_t i) { return pieces.first + std::int64_t(i); });
    } else {
      pieces_.clear();
      append_near(ray, pieces);
      test(query, ray, pieces_.size(), [&](std::size_t i) { return pieces_[i]; });
    }
    list_crossings(hits_, to);
  }

 private:
  /// A piece that the ray hits, in units of the caller's ray and of the scene.
  struct PieceHit {
    Hit closest;
    double gap;  // D − R, up to a constant of the primitive
    float t_in, u_in, t_out;
    bool enters;  // whether the ray comes in from outside
  };

  /// The most pieces of a primitive that are tested without asking first whether the ray may hit them.
  static constexpr std::int64_t kFew = 4 * kSimdWidth;

  /// Choose the pieces to test, rising: those listed, or all that the ray may hit of their primitives.
  void choose_pieces(const RayOf<P>& ray, std::span<const std::int64_t> listed, bool is_complete) {
    pieces_.assign(listed.begin(), listed.end());
    std::sort(pieces_.begin(), pieces_.end());
    if (is_complete) return;
    std::swap(pieces_, listed_);
    pieces_.clear();
    std::int64_t end = 0;
    for (const std::int64_t piece : listed_) {
      if (piece < end) continue;
      const PieceRange all = owners_.pieces_beside(piece);
      append_near(ray, all);
      end = all.end;
    }
  }

  /// Append the pieces of one primitive that the ray may hit.
  void append_near(const RayOf<P>& ray, const PieceRange& all) {
    for (std::int64_t piece = all.first; piece < all.end; ++piece)
      if (may_hit(ray, items_[piece])) pieces_.push_back(piece);
  }

  /// Whether the line of a ray comes within reach of the ball around a piece; `slack` covers all rounding.
  bool may_hit(const RayOf<P>& ray, const typename P::Item& item) const {
    if constexpr (AxisPrimitive<P> || MixedPrimitive<P>) {
      if constexpr (MixedPrimitive<P>)
        if (!P::has_axis(item)) return true;
      const Segment& axis = P::axis(item);
      const Vec3 from = frame_(axis.p) - ray.o, half = (axis.q - axis.p) * (0.5f * frame_.scale), c = from + half;
      const Vec3 across{c[1] * ray.r[2] - c[2] * ray.r[1], c[2] * ray.r[0] - c[0] * ray.r[2],
                        c[0] * ray.r[1] - c[1] * ray.r[0]};
      const float slack = 1e-5f * (1.0f + std::abs(c[0]) + std::abs(c[1]) + std::abs(c[2]));
      const float reach = ray.radius + ray.eps + P::radius(item) * frame_.scale + std::sqrt(dot(half, half)) + slack;
      return dot(across, across) <= 1.0001f * reach * reach;
    } else {
      return true;
    }
  }

  /// Test pieces, rising, 16 at a time, and list those that the ray hits.
  template <class PieceAt>
  void test(const RayQuery& query, const RayOf<P>& ray, std::size_t n_pieces, const PieceAt& piece_at) {
    constexpr int n_floats = sizeof(typename P::Item) / sizeof(float);
    for (std::size_t j = 0; j < n_pieces; j += kSimdWidth) {
      const std::size_t n = std::min<std::size_t>(n_pieces - j, kSimdWidth);
      const float* rows[kSimdWidth];
      for (std::size_t lane = 0; lane < kSimdWidth; ++lane)
        rows[lane] = reinterpret_cast<const float*>(items_ + piece_at(j + std::min(lane, n - 1)));
      FloatX16 floats[n_floats];
      transpose_rows(rows, floats);
      const auto fields = P::fields(floats, frame_);
      const auto test = P::template test<FloatX16>(ray, fields);
      const std::uint32_t bits = test.closest.hit.bits() & lane_mask(n);
      if (!bits) continue;
      float t[kSimdWidth], s[kSimdWidth], dist2[kSimdWidth], t_in[kSimdWidth], u_in[kSimdWidth], t_out[kSimdWidth];
      std::uint32_t entering = 0;
      test.closest.t.store(t);
      test.closest.s.store(s);
      test.closest.dist2.store(dist2);
      if constexpr (!kHasSpread<P>) {
        const auto in = test.entry();
        in.t.store(t_in);
        in.s.store(u_in);
        entering = test.enters(in).bits();
        test.exit().store(t_out);
      }
      for (std::size_t lane = 0; lane < n; ++lane) {
        if (!(bits >> lane & 1)) continue;
        PieceHit hit{{ray.t_ray(t[lane]), piece_at(j + lane), s[lane], ray.distance(dist2[lane])}, 0.0, 0, 0, 0, true};
        hit.gap = gap(query, hit.closest);
        if constexpr (!kHasSpread<P>) {
          hit.t_in = ray.t_ray(t_in[lane]);
          hit.u_in = u_in[lane];
          hit.t_out = ray.t_ray(t_out[lane]);
          hit.enters = entering >> lane & 1;
        }
        hits_.push_back(hit);
      }
    }
  }

  /// D − R at a closest approach, up to a constant of the primitive, so that radii that are equal cancel exactly.
  double gap(const RayQuery& query, const Hit& closest) {
    const auto& item = items_[closest.prim];
    if (hits_.empty() || !owners_.is_same(hits_.back().closest.prim, closest.prim)) reference_ = own_radius(item, 0.0);
    double found = double(closest.distance) - (own_radius(item, closest.u) - reference_);
    if constexpr (kHasSpread<P>) found -= double(query.spread) * depth(query, P::axis(item), closest.u);
    return found;
  }

  /// How far along the ray the point of an axis is from the ray's origin.
  static double depth(const RayQuery& query, const Segment& axis, double s) {
    double along = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double from = axis.p[k], at = from + s * (axis.q[k] - from);
      along += (at - query.origin[k]) * query.direction[k];
    }
    return along / length_of(query.direction);
  }

  /// Join the hits of one primitive into crossings, and append these.
  void list_crossings(std::span<PieceHit> hits, std::vector<Hit>& to) const {
    if constexpr (!kHasSpread<P>)
      std::sort(hits.begin(), hits.end(), [](const PieceHit& a, const PieceHit& b) {
        return precedes(a.t_in, a.closest.prim, b.t_in, b.closest.prim);
      });
    for (std::size_t first = 0, end = 0; first < hits.size(); first = end) {
      const PieceHit* nearest = &hits[first];
      float t_out = nearest->t_out;
      bool enters = nearest->enters;
      for (end = first + 1; end < hits.size() && continues(hits[end], hits[end - 1], t_out); ++end) {
        t_out = std::max(t_out, hits[end].t_out);
        if (is_nearer(hits[end], *nearest)) nearest = &hits[end];
        enters &= hits[end].enters;
      }
      if (at_ == At::entry && !enters) continue;
      Hit hit = nearest->closest;
      if (has_exit(at_)) {
        hit.t = hits[first].t_in;
        hit.prim = hits[first].closest.prim;
        hit.u = hits[first].u_in;
      }
      hit.t_out = t_out;
      to.push_back(hit);
    }
  }

  /// Whether a hit belongs to the crossing of the hit before it, which ends at t_out.
  static bool continues(const PieceHit& hit, const PieceHit& before, float t_out) {
    if constexpr (kHasSpread<P>)
      return hit.closest.prim == before.closest.prim + 1;
    else
      return hit.t_in <= t_out;
  }

  static bool is_nearer(const PieceHit& a, const PieceHit& b) {
    if (a.gap != b.gap) return a.gap < b.gap;
    return precedes(a.closest.t, a.closest.prim, b.closest.t, b.closest.prim);
  }

  const typename P::Item* items_;
  Frame frame_;
  PieceOwners owners_;
  At at_;
  double reference_ = 0.0;  // a radius of the primitive at hand
  std::vector<std::int64_t> listed_, pieces_;
  std::vector<PieceHit> hits_;
};

/// Assemble the crossings of all rays: all of each by t, its first k by t, or the k nearest to it by distance.
template <RayPrimitive P>
void list_crossings(const P& prims, const Frame& frame, const RayBatch& rays, const PieceLists& lists,
                    unsigned n_threads, Progress& progress, HitAssembler& to, At at, Keep keep, std::uint64_t k) {
  struct Worker {
    CrossingFinder<P> finder;
    std::vector<Hit> hits;
    HitBuffer lists;
  };
  const std::size_t n_chunks = (rays.size() + kRaysPerChunk - 1) / kRaysPerChunk;
  parallel_for(
      n_chunks, n_threads, progress, [&] { return Worker{{prims.items(), frame, lists.owners, at}, {}, {}}; },
      [&](Worker& worker, std::size_t i_chunk) {
        const std::size_t chunk = HitAssembler::sample_first(i_chunk, n_chunks);
        const std::size_t end = std::min(rays.size(), (chunk + 1) * kRaysPerChunk);
        for (std::size_t i = chunk * kRaysPerChunk; i < end; ++i) {
          progress.check();
          worker.finder.find(rays[i], lists.of_ray(i), lists.is_complete, worker.hits);
          std::sort(worker.hits.begin(), worker.hits.end(),
                    [keep](const Hit& a, const Hit& b) { return comes_first(keep, a, b); });
          if (worker.hits.size() > k) worker.hits.resize(k);
          worker.lists.add(std::uint32_t(i), worker.hits);
        }
        to.add(chunk, n_chunks, end, worker.lists);
      });
}

}  // namespace fastlines
