// Rays on their way from tile to tile. A ray waits for the next tile of its route until that is queried; the answer may
// lower the ray's limit, and the route ends where the ray enters the next tile beyond it.
#pragma once

#include <numeric>

#include "../kernels/rays/ray_tiling.hpp"
#include "ray_routes.hpp"

namespace fastlines {

/// The rays of a batch in an order in which neighbours are coherent: tiles of a picture, or as they come.
inline std::vector<std::uint32_t> coherent_order(const RayBatch& rays) {
  std::vector<std::uint32_t> order(rays.size());
  const RayTiling tiling(rays);
  std::uint32_t* to = order.data();
  std::uint32_t ids[kGroupSize];
  for (std::size_t i = 0; i < tiling.n_groups(); ++i) {
    const int n = tiling.group(i, ids);
    to = std::copy_n(ids, n, to);
  }
  return order;
}

class TileWalk {
 public:
  using Rows = std::vector<std::uint32_t>;

  /// All rays wait for the first tiles of their routes.
  TileWalk(RayRoutes routes, const RayBatch& rays, unsigned n_threads)
      : n_threads_(n_threads),
        routes_(std::move(routes)),
        at_(routes_.offsets.begin(), routes_.offsets.end() - 1),
        waiting_(routes_.n_tiles) {
    advance(coherent_order(rays), [](std::size_t, std::uint32_t) { return kInfinity; });
  }

  std::size_t n_waiting(std::size_t tile) const { return waiting_[tile].size(); }

  /// How many rays wait for any tile.
  std::size_t n_waiting() const {
    std::size_t n = 0;
    for (const Rows& rays : waiting_) n += rays.size();
    return n;
  }

  /// The tile to query next, or −1 if no ray waits: the one for which most rays wait. One that is open comes before one
  /// that is not, unless far fewer rays wait for it.
  std::int64_t next_tile(std::span<const std::uint8_t> is_open) const {
    constexpr std::size_t worth_opening = 4;  // how many times as many rays wait
    std::int64_t best = -1;
    std::size_t most = 0;
    for (std::size_t tile = 0; tile < waiting_.size(); ++tile)
      if (const std::size_t weight = n_waiting(tile) * (is_open[tile] ? worth_opening : 1); weight > most) {
        most = weight;
        best = std::int64_t(tile);
      }
    return best;
  }

  /// The rays that wait for a tile, which wait no longer.
  Rows take(std::size_t tile) { return std::exchange(waiting_[tile], {}); }

  /// Move rays on: update(j, ray) takes over the answer to rays[j], and returns the limit of the ray, in its own units.
  template <class Update>
  void advance(const Rows& rays, Update&& update) {
    // Each thread has queues of its own, which are joined in the order of the rays.
    constexpr std::size_t min_chunk = 1 << 13;  // rays
    const std::size_t chunk = std::max(min_chunk, rays.size() / n_threads_ + 1);
    std::vector<std::vector<Rows>> queues((rays.size() + chunk - 1) / chunk);
    Progress unwatched;
    parallel_for_chunks(
        rays.size(), chunk, n_threads_, unwatched, [] { return 0; },
        [&](int, std::size_t begin, std::size_t end) {
          std::vector<Rows>& to = queues[begin / chunk];
          to.resize(waiting_.size());
          for (std::size_t j = begin; j < end; ++j) {
            const std::uint32_t ray = rays[j];
            const float limit = update(j, ray);
            std::int64_t& next = at_[ray];
            if (next == routes_.offsets[ray + 1]) continue;
            const RouteStep& step = routes_.steps[std::size_t(next)];
            if (!(step.enter <= limit)) continue;
            ++next;
            to[step.tile].push_back(ray);
          }
        });
    for (const std::vector<Rows>& queue : queues)
      for (std::size_t tile = 0; tile < waiting_.size(); ++tile)
        waiting_[tile].insert(waiting_[tile].end(), queue[tile].begin(), queue[tile].end());
  }

  unsigned n_threads() const { return n_threads_; }

 private:
  unsigned n_threads_;
  RayRoutes routes_;
  LargeVector<std::int64_t> at_;  // the next step of each ray
  std::vector<Rows> waiting_;     // by tile
};

}  // namespace fastlines
