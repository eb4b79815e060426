// The same gather by a uniform grid and by brute force, in C++ (peers/beam_loops.py compiles it). Beams are tested 16
// at a time.
#include <atomic>
#include <thread>
#include <utility>

#include "beam_crossing.hpp"
#include "beam_grid.hpp"

namespace {

using fastlines::peers::kColours;

constexpr int kLanes = 16;
using F = Lanes<kLanes>::F;
using I = Lanes<kLanes>::I;

/// Up to 16 beams, one in each lane.
struct Packet {
  alignas(64) float p[3][kLanes] = {}, e[3][kLanes] = {};
  std::uint32_t prim[kLanes] = {};
  int n = 0;

  void push(const Beam& beam, std::uint32_t its_prim) {
    for (int k = 0; k < 3; ++k) p[k][n] = beam.p[k], e[k][n] = beam.e[k];
    prim[n++] = its_prim;
  }
};

/// A ray, and the sums of what packets add to it.
struct Ray {
  float o[3], r[3];
  F wide_o[3], wide_r[3];
  double sums[kColours] = {};

  Ray(const float* origin, const float* direction) {
    for (int k = 0; k < 3; ++k) {
      o[k] = origin[k], r[k] = direction[k];
      wide_o[k] = F{} + o[k], wide_r[k] = F{} + r[k];
    }
  }

  void add(const Packet& packet, const Gather& gather, const float* powers) {
    const F zero{};
    F delta[3], e[3], weight;
    for (int k = 0; k < 3; ++k) delta[k] = load<F>(packet.p[k]) - wide_o[k], e[k] = load<F>(packet.e[k]);
    I valid;
    for (int i = 0; i < kLanes; ++i) valid[i] = -(i < packet.n);
    valid = crossing(valid, delta, wide_r, e, zero, zero + kLast, gather, weight);
    for (unsigned left = bits(valid); left; left &= left - 1) {
      const int i = __builtin_ctz(left);
      const float* power = powers + kColours * std::size_t(packet.prim[i]);
      for (int c = 0; c < kColours; ++c) sums[c] += double(power[c] * weight[i]);
    }
  }

  void write(float* to) const {
    for (int c = 0; c < kColours; ++c) to[c] = float(sums[c]);
  }
};

/// Calls work(begin, end) for all chunks of the rays, on each thread by a function of its own, which make() returns.
template <class Make>
void parallel_for(std::size_t n_rays, unsigned n_threads, Make&& make) {
  constexpr std::size_t chunk = 1024;
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    auto work = make();
    for (std::size_t begin; (begin = next.fetch_add(chunk)) < n_rays;) work(begin, std::min(begin + chunk, n_rays));
  };
  std::vector<std::jthread> others;
  for (unsigned i = 1; i < n_threads; ++i) others.emplace_back(run);
  run();
}

std::vector<Beam> beams_of(const float* segments, std::size_t n) {
  std::vector<Beam> beams(n);
  for (std::size_t i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) {
      beams[i].p[k] = segments[6 * i + k];
      beams[i].e[k] = segments[6 * i + 3 + k] - segments[6 * i + k];
    }
  return beams;
}

}  // namespace

extern "C" {

Grid* grid_build(const float* segments, std::size_t n, float radius, int resolution) {
  return new Grid(beams_of(segments, n), radius, resolution);
}

void grid_free(Grid* grid) { delete grid; }

std::size_t grid_bytes(const Grid* grid) { return grid->bytes(); }

void grid_gather(const Grid* grid, const float* origins, const float* directions, std::size_t n_rays,
                 const Gather* gather, const float* powers, unsigned n_threads, float* sums) {
  const std::vector<Beam>& beams = grid->beams();
  parallel_for(n_rays, n_threads, [&] {
    // The mailbox of a beam holds the last ray that has met it, counted from 1.
    return [&, mailbox = std::vector<std::uint32_t>(beams.size(), 0)](std::size_t begin, std::size_t end) mutable {
      for (std::size_t i = begin; i < end; ++i) {
        Ray ray(origins + 3 * i, directions + 3 * i);
        Packet packet;
        const auto letter = std::uint32_t(i + 1);
        grid->walk(ray.o, ray.r, gather->t_min, gather->t_max,
                   [&](const std::uint32_t* ref, const std::uint32_t* last) {
                     for (; ref != last; ++ref) {
                       if (std::exchange(mailbox[*ref], letter) == letter) continue;
                       packet.push(beams[*ref], *ref);
                       if (packet.n < kLanes) continue;
                       ray.add(packet, *gather, powers);
                       packet.n = 0;
                     }
                   });
        ray.add(packet, *gather, powers);
        ray.write(sums + kColours * i);
      }
    };
  });
}

void brute_gather(const float* segments, std::size_t n, const float* origins, const float* directions,
                  std::size_t n_rays, const Gather* gather, const float* powers, unsigned n_threads, float* sums) {
  const std::vector<Beam> beams = beams_of(segments, n);
  std::vector<Packet> packets((n + kLanes - 1) / kLanes);
  for (std::size_t i = 0; i < n; ++i) packets[i / kLanes].push(beams[i], std::uint32_t(i));
  parallel_for(n_rays, n_threads, [&] {
    return [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Ray ray(origins + 3 * i, directions + 3 * i);
        for (const Packet& packet : packets) ray.add(packet, *gather, powers);
        ray.write(sums + kColours * i);
      }
    };
  });
}

}  // extern "C"
