// The callback of user geometry that adds up what beams give to the rays of a packet. Compiled once for each
// instruction set, with fused multiply-adds. A traversal goes on behind every crossing, because the callback reports no
// hit.
#include "beam_crossing.hpp"
#include "embree_user.hpp"

#ifndef PEER_ISA
#define PEER_ISA portable
#endif

namespace fastlines::peers {
namespace {

/// Adds a piece of a beam to W rays, from lane `from` of a packet of n.
template <int W>
void add(const CallbackArguments& args, unsigned n, unsigned from) {
  using F = typename Lanes<W>::F;
  using I = typename Lanes<W>::I;
  auto& batch = static_cast<Batch&>(*args.context);
  const Piece& piece = batch.pieces[args.prim];
  const auto field = [&](unsigned k) { return load<F>(args.rays + k * n + from); };
  const F zero{};
  F delta[3], r[3], e[3], weight;
  for (unsigned k = 0; k < 3; ++k) {
    delta[k] = piece.p[k] - field(kOrigin + k);
    r[k] = field(kDirection + k);
    e[k] = zero + piece.e[k];
  }
  // Only the piece that owns the u of a crossing adds it.
  const Owner owner = piece.owner;
  const F u0 = zero + float(owner.k) / owner.m, u1 = zero + (owner.is_last() ? kLast : float(owner.k + 1) / owner.m);
  const I valid = crossing(load<I>(args.valid + from), delta, r, e, u0, u1, batch.gather, weight);
  if (bits(valid) == 0) return;
  weight = blend(valid, weight, zero);
  const float* power = batch.powers + kColours * owner.prim;
  for (int c = 0; c < kColours; ++c) {
    float* at = batch.sums[c] + from;
    const F sum = load<F>(at) + power[c] * weight;
    std::memcpy(at, &sum, sizeof sum);
  }
}

void callback(const CallbackArguments* args) {
#ifdef __AVX512F__
  if (args->n == 16) return add<16>(*args, 16, 0);
#endif
  switch (args->n) {
    case 1:
      return add<1>(*args, 1, 0);
    case 4:
      return add<4>(*args, 4, 0);
    default:
      for (unsigned from = 0; from < args->n; from += 8) add<8>(*args, args->n, from);
  }
}

}  // namespace

namespace PEER_ISA {
Callback gather_callback() { return callback; }
}  // namespace PEER_ISA

}  // namespace fastlines::peers
