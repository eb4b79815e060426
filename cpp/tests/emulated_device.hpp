// Runs the kernels of device/kernels.hpp on the host, one thread after the other: the same text as on a GPU, in the
// same order of launches as src/fastlines/cuda/backend.py.
#pragma once

#include <vector>

#include "fastlines/device/kernels.hpp"
#include "fastlines/layout/wide_bvh.hpp"
#include "fastlines/rays/ray_batch.hpp"

namespace fastlines::test {

/// The records of a layout and of rays.
template <class P>
DeviceScene scene_of(const WideBvhView<P>& view) {
  return {view.nodes, view.leaves, view.refs, reinterpret_cast<const float*>(view.items), view.frame};
}

inline DeviceRays device_rays_of(const RayBatch& rays, const std::vector<std::uint32_t>& order) {
  const auto step = [](std::span<const float> values) { return values.size() == 1 ? 0u : 1u; };
  return {rays.origins.data()->data(),
          rays.directions.data()->data(),
          rays.radius.data(),
          rays.t_min.data(),
          rays.t_max.data(),
          rays.spread.data(),
          order.empty() ? nullptr : order.data(),
          rays.size(),
          3,
          3,
          step(rays.radius),
          step(rays.t_min),
          step(rays.t_max),
          step(rays.spread)};
}

/// The entries that the stack of a ray needs, at most.
inline std::size_t stack_room(std::span<const WideNode> nodes) {
  std::vector<std::pair<std::uint32_t, std::size_t>> open{{0, 0}};  // a node, and the entries below it
  std::size_t room = 1;
  while (!open.empty()) {
    const auto [index, below] = open.back();
    open.pop_back();
    const WideNode& node = nodes[index];
    room = std::max(room, below + node.n_inner);
    for (std::uint32_t i = 0; i < node.n_inner; ++i) open.emplace_back(node.first_inner + i, below + node.n_inner - 1);
  }
  return room;
}

/// Replace numbers by the sums of all up to each.
inline void scan(std::vector<std::int64_t>& numbers, std::size_t first = 0) {
  const std::size_t n = numbers.size() - first, n_runs = (n + kScanRun - 1) / kScanRun;
  std::int64_t* const begin = numbers.data() + first;
  std::vector<std::int64_t> sums(n_runs);
  if (n_runs > 1) {
    emulate_threads(n_runs, sum_runs, begin, n, sums.data());
    scan(sums);
  }
  emulate_threads(n_runs, scan_runs, begin, n, sums.data());
}

/// Hits as columns that own their memory; lists of hits also have offsets.
struct OwnedHits {
  std::vector<std::int64_t> offsets, prim;
  std::vector<float> t, u, distance, t_out;

  DeviceHits columns(std::size_t n) {
    prim.assign(n, -7);
    for (auto* column : {&t, &u, &distance, &t_out}) column->assign(n, -7.0f);
    return {t.data(), prim.data(), u.data(), distance.data(), t_out.data()};
  }
};

/// Runs a kernel for n rays, and some more threads.
template <class Kernel, class... Arguments>
void emulate_rays(std::uint64_t n, const Kernel& kernel, const Arguments&... arguments) {
  emulate_threads(kGroup * (n + 5), kernel, arguments...);
}

/// Answers queries by the kernels of a kind of primitive.
template <class P>
struct EmulatedDevice {
  DeviceScene scene;
  DeviceRays rays;
  bool has_repeats;  ///< whether a primitive is in several leaves, without pieces that own hits

  template <class Where>
  OwnedHits first(Where where) const {
    OwnedHits hits;
    emulate_rays(rays.n, first_hit_of_thread<P, Where>, scene, rays, where, hits.columns(rays.n));
    return hits;
  }

  std::vector<char> any(At at) const {
    std::vector<char> found(rays.n, 7);
    const auto kernel = at == At::entry ? any_hit_of_thread<P, At::entry> : any_hit_of_thread<P, At::closest>;
    emulate_rays(rays.n, kernel, scene, rays, reinterpret_cast<bool*>(found.data()));
    return found;
  }

  std::vector<std::int64_t> count(At at) const {
    std::vector<std::int64_t> counts(rays.n, -7);
    if (has_repeats) {
      const std::vector<std::int64_t> offsets = offsets_of_found(at, ~0ull);
      std::vector<std::uint32_t> prims(std::size_t(offsets.back()));
      emulate_rays(rays.n, count_prims_of_thread<P>, scene, rays, at, offsets.data(), prims.data(), counts.data());
    } else {
      emulate_rays(rays.n, counting_kernel(at), scene, rays, ~0ull, counts.data());
    }
    return counts;
  }

  /// All hits, or the k best.
  template <Keep keep, class Where>
  OwnedHits list(Where where, std::uint64_t k = ~0ull) const {
    OwnedHits lists, kept;
    lists.offsets = offsets_of_found(where.at, k);
    kept.offsets.assign(rays.n + 1, 0);
    const DeviceHits columns = lists.columns(std::size_t(lists.offsets.back()));
    const DeviceLists found{lists.offsets.data(), columns, has_repeats ? kept.offsets.data() + 1 : nullptr};
    emulate_rays(rays.n, list_hits_of_thread<P, keep, Where>, scene, rays, where, found);
    if (!has_repeats) return lists;
    scan(kept.offsets, 1);
    const DeviceLists to{kept.offsets.data(), kept.columns(std::size_t(kept.offsets.back())), nullptr};
    emulate_threads(rays.n + 5, move_lists, &found, rays.n, &to);
    return kept;
  }

 private:
  static auto counting_kernel(At at) {
    return at == At::entry ? count_hits_of_thread<P, At::entry> : count_hits_of_thread<P, At::closest>;
  }

  /// Where the lists of all that rays find begin, up to k of each.
  std::vector<std::int64_t> offsets_of_found(At at, std::uint64_t k) const {
    std::vector<std::int64_t> offsets(rays.n + 1, 0);
    emulate_rays(rays.n, counting_kernel(at), scene, rays, k, offsets.data() + 1);
    scan(offsets, 1);
    return offsets;
  }
};

}  // namespace fastlines::test
