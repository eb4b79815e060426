// User geometry for Embree: a segment of a given radius, hit as fastlines defines it (docs/answers.md).
#pragma once

#include "embree_api.hpp"

namespace fastlines::peers {

/// Which piece of which segment: the k-th of m, [k/m, (k+1)/m) of it.
struct Owner {
  std::uint32_t prim;
  std::uint16_t k, m;

  bool is_first() const { return k == 0; }
  bool is_last() const { return k + 1 == m; }
};

/// What user geometry keeps for a piece: half a cache line. All pieces of a segment test the whole segment, so that
/// each gives the same t; the piece decides which of them reports it, and how large the box is.
struct Piece {
  float p[3], e[3];
  Owner owner;
};
static_assert(sizeof(Piece) == 32);

struct PeerHit {
  std::uint32_t ray, prim;
  float t;
};

/// A growing array of hits. Not a std::vector: what callbacks call must not be compiled with them, or the linker could
/// give code for AVX-512 to everybody.
struct HitBuffer {
  PeerHit *begin = nullptr, *at = nullptr, *end = nullptr;

  HitBuffer();
  HitBuffer(HitBuffer&& other) noexcept;
  ~HitBuffer();
  void grow();  // to twice the size
};

/// What a batch of rays shares, and where its hits go. Embree hands it back to callbacks.
struct Batch : QueryContext {
  const Piece* pieces = nullptr;       // user geometry
  const Owner* owners = nullptr;       // what Embree tests itself
  float radius2 = 0.0f;                // of a hit
  float loose2 = 0.0f, slack2 = 0.0f;  // of the early way out: (p·n)² > loose2·n² + slack2·|e|² is no hit
  float t_max = 0.0f;                  // as asked
  bool bounded = false;                // t_max is finite
  HitBuffer* hits = nullptr;           // all hits, in no order
};

/// One callback a kind of query, for packets of 1, 4, 8 and 16 rays.
struct Callbacks {
  Callback first, any, all;
};

// The same source, compiled for each instruction set.
namespace avx512 {
Callbacks callbacks();
}
namespace avx2 {
Callbacks callbacks();
}
namespace portable {
Callbacks callbacks();
}

}  // namespace fastlines::peers
