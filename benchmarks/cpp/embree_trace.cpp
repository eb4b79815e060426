// Traces batches of rays through an Embree scene.
#include "embree_trace.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>
#include <utility>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace fastlines::peers {
namespace {

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr std::size_t kChunk = 4096;  // a multiple of every width

/// Flushes denormals to zero for its lifetime, as Embree recommends.
class FlushDenormals {
#if defined(__SSE__)
 public:
  FlushDenormals() { _mm_setcsr(before_ | 0x8040); }
  ~FlushDenormals() { _mm_setcsr(before_); }

 private:
  unsigned before_ = _mm_getcsr();
#endif
};

/// Calls work(thread, begin, end) for all chunks of the rays, on n_threads threads including the calling one.
template <class Work>
void parallel_for(std::size_t n_rays, unsigned n_threads, Work&& work) {
  std::atomic<std::size_t> next{0};
  const auto run = [&](unsigned thread) {
    const FlushDenormals flush;
    for (std::size_t begin; (begin = next.fetch_add(kChunk)) < n_rays;)
      work(thread, begin, std::min(begin + kChunk, n_rays));
  };
  std::vector<std::jthread> others;
  for (unsigned i = 1; i < n_threads; ++i) others.emplace_back(run, i);
  run(0);
}

bool is_user(const Scene& scene) { return scene.settings().kind == Kind::user; }

/// What the callbacks need for a batch.
Batch batch_of(const Scene& scene, const Rays& rays) {
  Batch batch;
  batch.pieces = scene.pieces().data();
  batch.owners = scene.owners().data();
  batch.halvings = scene.settings().halvings;
  batch.t_max = rays.t_max;
  batch.bounded = rays.t_max < kInf;
  if (!is_user(scene)) return batch;
  batch.radius2 = scene.radius * scene.radius;
  // The distance of two lines has an error of about 2⁻²¹ of the distance from the origins to the segments. The slack is
  // 2⁻¹⁸ of it.
  float far2 = 0.0f;
  for (const Ray3& o : rays.origins) {
    const float origin[3] = {o.x, o.y, o.z};
    float sum = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float reach = std::max(std::abs(scene.box().lo[k] - origin[k]), std::abs(scene.box().hi[k] - origin[k]));
      sum += reach * reach;
    }
    far2 = std::max(far2, sum);
  }
  batch.loose2 = 1.001f * batch.radius2;
  batch.slack2 = std::ldexp(far2, -36);
  return batch;
}

template <int W>
void set_ray(RayHits<W>& packet, int lane, const Rays& rays, std::size_t i) {
  packet.ox[lane] = rays.origins[i].x, packet.oy[lane] = rays.origins[i].y, packet.oz[lane] = rays.origins[i].z;
  packet.dx[lane] = rays.directions[i].x, packet.dy[lane] = rays.directions[i].y;
  packet.dz[lane] = rays.directions[i].z;
  packet.tnear[lane] = rays.t_min, packet.tfar[lane] = rays.t_max, packet.time[lane] = 0.0f;
  packet.mask[lane] = ~0u, packet.flags[lane] = 0, packet.id[lane] = std::uint32_t(i);
  packet.geom[lane] = packet.instance[lane] = packet.instance_prim[lane] = kInvalid;
}

template <int W>
void intersect(const Scene& scene, const int* valid, RayHits<W>& packet, QueryArguments& args) {
  if constexpr (W == 1) return api().Intersect1(scene.handle(), &packet, &args);
  if constexpr (W == 8) return api().Intersect8(valid, scene.handle(), &packet, &args);
  if constexpr (W == 16) return api().Intersect16(valid, scene.handle(), &packet, &args);
}

template <int W>
void occluded(const Scene& scene, const int* valid, RayHits<W>& packet, QueryArguments& args) {
  if constexpr (W == 1) return api().Occluded1(scene.handle(), &packet, &args);
  if constexpr (W == 8) return api().Occluded8(valid, scene.handle(), &packet, &args);
  if constexpr (W == 16) return api().Occluded16(valid, scene.handle(), &packet, &args);
}

/// Traces the rays of a chunk in packets; then calls then(packet, lane, i) for each ray.
template <int W, bool kOccluded, class Then>
void trace(const Scene& scene, const Rays& rays, QueryArguments& args, std::size_t begin, std::size_t end,
           Then&& then) {
  RayHits<W> packet;
  alignas(64) int valid[W];
  for (std::size_t first = begin; first < end; first += W) {
    const int n = int(std::min<std::size_t>(W, end - first));
    for (int lane = 0; lane < W; ++lane) {
      valid[lane] = lane < n ? -1 : 0;
      set_ray(packet, lane, rays, first + std::min(lane, n - 1));
    }
    if constexpr (kOccluded)
      occluded(scene, valid, packet, args);
    else
      intersect(scene, valid, packet, args);
    for (int lane = 0; lane < n; ++lane) then(packet, lane, first + lane);
  }
}

/// Traces the rays of a chunk past all hits.
template <int W, class Then>
void trace_all(const Scene& scene, const Rays& rays, QueryArguments& args, std::size_t begin, std::size_t end,
               Then&& then) {
  // In Embree 4.4, packets of coherent rays call an occlusion callback that rejects its hit more than once for the
  // same primitive and ray; rtcIntersect does not. For incoherent rays, occlusion is faster.
  if (args.flags & kCoherent)
    trace<W, false>(scene, rays, args, begin, end, then);
  else
    trace<W, true>(scene, rays, args, begin, end, then);
}

/// Calls use(width) with the width as a compile-time constant.
template <class Use>
void with_width(int width, Use&& use) {
  if (width == 1) return use(std::integral_constant<int, 1>{});
  if (width == 8) return use(std::integral_constant<int, 8>{});
  return use(std::integral_constant<int, 16>{});
}

/// Whether a filter sees the points where a ray enters a surface and where it leaves.
constexpr bool is_round(Kind kind) { return kind == Kind::round || kind == Kind::bezier || kind == Kind::sphere; }

/// Stores each hit once per segment and rejects all of them, so that the traversal continues. A cubic curve is stored
/// as often as the ray enters it.
template <Kind kKind>
void collect(const FilterArguments* args) {
  const auto& batch = static_cast<const Batch&>(*args->context);
  const unsigned n = args->n;
  const auto* ids = reinterpret_cast<const std::uint32_t*>(args->rays + kId * n);
  const auto* prims = reinterpret_cast<const std::uint32_t*>(args->hits + kPrim * n);
  for (unsigned i = 0; i < n; ++i) {
    if (args->valid[i] != -1) continue;
    args->valid[i] = 0;
    std::uint32_t prim = prims[i];
    if constexpr (is_of_segments(kKind)) {
      const Owner owner = batch.owners[kKind == Kind::ribbon ? prim / 2 : prim];
      const float u = args->hits[kU * n + i];
      // A hit at an end of a piece counts only at the ends of the segment, so that no hit is stored for two pieces.
      if (kKind != Kind::ribbon && ((u <= 0.0f && !owner.is_first()) || (u >= 1.0f && !owner.is_last()))) continue;
      prim = owner.prim;
    }
    if constexpr (kKind == Kind::bezier) prim >>= batch.halvings;
    if constexpr (is_round(kKind)) {
      // Keep the point where the ray enters, not the one where it leaves.
      float facing = 0.0f;
      for (unsigned k = 0; k < 3; ++k)
        facing += args->hits[(kNormal + k) * n + i] * args->rays[(kDirection + k) * n + i];
      if (facing >= 0.0f) continue;
    }
    HitBuffer& hits = *batch.hits;
    if (hits.at == hits.end) hits.grow();
    *hits.at++ = {ids[i], prim, args->rays[kFar * n + i]};
  }
}

Filter collector(Kind kind) {
  switch (kind) {
    case Kind::flat:
      return collect<Kind::flat>;
    case Kind::round:
      return collect<Kind::round>;
    case Kind::ribbon:
      return collect<Kind::ribbon>;
    case Kind::bezier:
      return collect<Kind::bezier>;
    case Kind::sphere:
      return collect<Kind::sphere>;
    default:
      return collect<Kind::triangle>;
  }
}

}  // namespace

HitBuffer::HitBuffer() = default;
HitBuffer::HitBuffer(HitBuffer&& other) noexcept
    : begin(std::exchange(other.begin, nullptr)),
      at(std::exchange(other.at, nullptr)),
      end(std::exchange(other.end, nullptr)) {}
HitBuffer::~HitBuffer() { std::free(begin); }

void HitBuffer::grow() {
  const auto n = std::size_t(end - begin), wanted = std::max<std::size_t>(2 * n, 4096);
  auto* moved = static_cast<PeerHit*>(std::realloc(begin, wanted * sizeof(PeerHit)));
  if (!moved) std::abort();  // a callback of Embree must not throw
  begin = moved;
  at = moved + n;
  end = moved + wanted;
}

void first_hits(const Scene& scene, const Rays& rays, const TraceOptions& options, float* t, std::int32_t* prim) {
  const Batch shared = batch_of(scene, rays);
  parallel_for(rays.origins.size(), options.n_threads, [&](unsigned, std::size_t begin, std::size_t end) {
    Batch batch = shared;
    QueryArguments args;
    args.flags = options.coherent ? kCoherent : 0;
    args.context = &batch;
    with_width(options.width, [&](auto width) {
      trace<width(), false>(scene, rays, args, begin, end, [&](const auto& packet, int lane, std::size_t i) {
        const bool hit = packet.geom[lane] != kInvalid;
        t[i] = hit ? packet.tfar[lane] : kInf;
        prim[i] = hit ? std::int32_t(scene.prim_of(packet.prim[lane])) : -1;
      });
    });
  });
}

void any_hits(const Scene& scene, const Rays& rays, const TraceOptions& options, bool* found) {
  const Batch shared = batch_of(scene, rays);
  parallel_for(rays.origins.size(), options.n_threads, [&](unsigned, std::size_t begin, std::size_t end) {
    Batch batch = shared;
    QueryArguments args;
    args.flags = options.coherent ? kCoherent : 0;
    args.context = &batch;
    with_width(options.width, [&](auto width) {
      trace<width(), true>(scene, rays, args, begin, end,
                           [&](const auto& packet, int lane, std::size_t i) { found[i] = packet.tfar[lane] == -kInf; });
    });
  });
}

std::vector<HitBuffer> all_hits(const Scene& scene, const Rays& rays, const TraceOptions& options,
                                const Callbacks& callbacks) {
  const Batch shared = batch_of(scene, rays);
  std::vector<HitBuffer> hits(std::max(1u, options.n_threads));
  parallel_for(rays.origins.size(), options.n_threads, [&](unsigned thread, std::size_t begin, std::size_t end) {
    Batch batch = shared;
    batch.hits = &hits[thread];
    QueryArguments args;
    args.flags = options.coherent ? kCoherent : 0;
    args.context = &batch;
    if (is_user(scene)) {
      args.callback = callbacks.all;
    } else {
      args.flags |= kInvokeFilter;
      args.filter = collector(scene.settings().kind);
    }
    with_width(options.width, [&](auto width) {
      trace_all<width()>(scene, rays, args, begin, end, [](const auto&, int, std::size_t) {});
    });
  });
  return hits;
}

void gathers(const Scene& scene, const Rays& rays, const TraceOptions& options, const Gather& gather,
             const float* powers, const Callbacks& callbacks, float* sums) {
  const Batch shared = batch_of(scene, rays);
  parallel_for(rays.origins.size(), options.n_threads, [&](unsigned, std::size_t begin, std::size_t end) {
    alignas(64) float of_packet[kColours][kMaxWidth] = {};
    Batch batch = shared;
    batch.gather = gather;
    batch.powers = powers;
    batch.sums = of_packet;
    QueryArguments args;
    args.flags = options.coherent ? kCoherent : 0;
    args.context = &batch;
    args.callback = callbacks.gather;
    with_width(options.width, [&](auto width) {
      trace_all<width()>(scene, rays, args, begin, end, [&](const auto&, int lane, std::size_t i) {
        for (int c = 0; c < kColours; ++c) sums[kColours * i + c] = std::exchange(of_packet[c][lane], 0.0f);
      });
    });
  });
}

}  // namespace fastlines::peers
