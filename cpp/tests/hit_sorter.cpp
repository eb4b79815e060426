// Sorts the hits of 16 rays: few and many, spread evenly over the rays or not. Every hit is listed once, with its ray.
// No hit follows one whose t is larger by more than the resolution of the sort. At equal t, hits are in order of the
// low four bits of their prim.
#include "fastlines/kernels/collect/hit_sorter.hpp"

#include <random>

#include "check.hpp"

using namespace fastlines;

namespace {

constexpr std::uint32_t kNoHit = ~0u;

void sort_hits() {
  std::mt19937 random(1);
  HitSorter order;
  std::size_t n_hits = 0, n_wrong = 0;
  for (int round = 0; round < 2000; ++round) {
    const std::uint32_t n = 1 + random() % (round % 50 == 0 ? 20'000 : round % 5 == 0 ? 3000 : 200);
    const std::uint32_t n_lanes = 1 + random() % kSimdWidth, n_steps = round % 3 == 0 ? 4 : 1 << 20;
    std::vector<std::uint32_t> lane(n), prim(n), n_of(kSimdWidth), n_listed(n);
    std::vector<float> t(n);
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t n_here = round % 2 == 0 ? n_lanes : 1 + random() % n_lanes;
      lane[j] = random() % n_here;
      t[j] = float(random() % n_steps) / float(n_steps) - 0.5f;
      prim[j] = random();
      ++n_of[lane[j]];
    }
    order.sort(lane.data(), t.data(), prim.data(), n);
    const float resolution = n <= 64 ? 0x1p-16f : 0x1p-14f;
    std::uint32_t begin = 0;
    for (int i = 0; i < kSimdWidth; begin += n_of[i++]) {
      n_wrong += order.begin(i) != begin;
      float latest = -1.0f;
      std::uint32_t before = kNoHit;
      for (std::uint32_t k = begin; k < begin + n_of[i]; ++k) {
        const std::uint32_t j = order[k];
        if (j >= n || n_listed[j]++ > 0 || lane[j] != std::uint32_t(i)) {
          ++n_wrong;
          continue;
        }
        n_wrong += t[j] < latest - resolution;
        n_wrong += before != kNoHit && t[j] == t[before] && prim[j] % 16 < prim[before] % 16;
        latest = std::max(latest, t[j]);
        before = j;
      }
    }
    n_wrong += order.begin(kSimdWidth) != n;
    n_hits += n;
  }
  test::check(n_hits > 1'000'000, "many hits are sorted");
  test::check(n_wrong == 0, "all hits are in order");
}

}  // namespace

int main() { return test::run(sort_hits); }
