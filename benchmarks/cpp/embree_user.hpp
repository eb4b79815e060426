// User geometry for Embree: a segment of a given radius, hit as fastlines defines it (docs/answers.md).
#pragma once

#include "embree_api.hpp"
#include "gather.hpp"

namespace fastlines::peers {

/// The owner of a piece: the segment `prim`, of which the piece is the part [k/m, (k+1)/m).
struct Owner {
  std::uint32_t prim;
  std::uint16_t k, m;

  bool is_first() const { return k == 0; }
  bool is_last() const { return k + 1 == m; }
};

/// A piece of user geometry, half a cache line. It holds the whole segment (start and end − start), because every piece
/// tests the whole segment and so gets the same t. `owner` decides which piece reports a hit, and bounds its box.
struct Piece {
  float p[3], e[3];
  Owner owner;
};
static_assert(sizeof(Piece) == 32);

struct PeerHit {
  std::uint32_t ray, prim;
  float t;
};

/// A growing array of hits. Not a std::vector: a template instantiated in the callbacks would be compiled with their
/// flags, and the linker could choose its AVX-512 code for every caller.
struct HitBuffer {
  PeerHit *begin = nullptr, *at = nullptr, *end = nullptr;

  HitBuffer();
  HitBuffer(HitBuffer&& other) noexcept;
  ~HitBuffer();
  void grow();  // doubles the size
};

/// The widest packet of rays.
inline constexpr int kMaxWidth = 16;

/// What the rays of a batch share, and the buffer for their hits. Embree passes it to the callbacks.
struct Batch : QueryContext {
  const Piece* pieces = nullptr;       // user geometry
  const Owner* owners = nullptr;       // linear curves and ribbons
  unsigned halvings = 0;               // of cubic curves
  float radius2 = 0.0f;                // a hit is at most this far away, squared
  float loose2 = 0.0f, slack2 = 0.0f;  // early exit: (p·n)² > loose2·n² + slack2·|e|² is no hit
  float t_max = 0.0f;                  // of the query; tfar falls with hits
  bool bounded = false;                // t_max is finite
  HitBuffer* hits = nullptr;           // for all hits, in no order
  Gather gather{};                     // for sums over all hits, with the power of each beam
  const float* powers = nullptr;
  float (*sums)[kMaxWidth] = nullptr;  // of the packet that is traced, for each colour
};

/// One callback per kind of query, for packets of 1, 4, 8 and 16 rays.
struct Callbacks {
  Callback first, any, all, gather;
};

// The same source, compiled for each instruction set.
namespace avx512 {
Callbacks callbacks();
Callback gather_callback();
}  // namespace avx512
namespace avx2 {
Callbacks callbacks();
Callback gather_callback();
}  // namespace avx2
namespace portable {
Callbacks callbacks();
Callback gather_callback();
}  // namespace portable

}  // namespace fastlines::peers
