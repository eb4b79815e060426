// Buffers the sorted hits of some rays until a `HitAssembler` copies them into the final arrays.
#pragma once

#include <cstring>
#include <memory>
#include <vector>

#include "../memory/arena.hpp"
#include "../rays/hit.hpp"
#include "../simd/float_x16.hpp"

namespace fastlines {

/// Sorted hits of some rays: one run per ray. Runs are stored in blocks, as columns.
struct HitBuffer {
  struct RayRun {
    std::uint32_t ray, n_hits;
  };
  /// The hits of some runs, one column after the other in memory, in the order in which kernels write them: u, prim, t,
  /// distance, and t_out, which may be missing.
  struct Block {
    std::uint32_t n_hits, n_runs;
    std::shared_ptr<std::byte> data;

    ListColumns columns() const {
      auto* const first = reinterpret_cast<float*>(data.get());
      const std::size_t n = n_hits;
      return {first + 2 * n, reinterpret_cast<std::uint32_t*>(first + n), first, first + 3 * n, first + 4 * n};
    }
  };
  std::vector<RayRun> runs;
  std::vector<Block> blocks;
  Arena arena;

  /// Begin a block of n_hits, and return where to write them. A column may be written past its end, by up to 16 hits,
  /// as long as the next column is not written yet.
  ListColumns begin(std::uint32_t n_hits) {
    blocks.push_back({n_hits, 0, arena.begin((5 * std::size_t(n_hits) + kSimdWidth) * sizeof(float))});
    return blocks.back().columns();
  }

  /// Assign the next n_hits of the block to a ray.
  void add(std::uint32_t ray, std::uint32_t n_hits) {
    runs.push_back({ray, n_hits});
    ++blocks.back().n_runs;
  }

  /// End the block, whose hits are all written; it keeps its first n_columns.
  void end(std::uint32_t n_columns) { arena.end(n_columns * std::size_t(blocks.back().n_hits) * sizeof(float)); }

  /// Add a block with the hits of one ray, in their order.
  void add(std::uint32_t ray, const std::vector<Hit>& of_ray) {
    if (of_ray.empty()) return;
    const ListColumns to = begin(std::uint32_t(of_ray.size()));
    for (std::size_t i = 0; i < of_ray.size(); ++i) to.set(i, of_ray[i]);
    add(ray, std::uint32_t(of_ray.size()));
    end(5);
  }

  void clear() {
    runs.clear();
    blocks.clear();
  }
};

}  // namespace fastlines
