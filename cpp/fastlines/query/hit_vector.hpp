// The hits of one ray in a vector: the room for a list that grows.
#pragma once

#include <algorithm>
#include <vector>

#include "ray_collectors.hpp"

namespace fastlines {

/// A store of `HitListOfRay`. `AnyHit` is `Hit`, or a struct of the same members in the same order.
template <class AnyHit>
struct HitVector {
  std::vector<AnyHit>& hits;

  Hit operator[](std::uint64_t i) const {
    const AnyHit& hit = hits[i];
    return {hit.t, hit.prim, hit.u, hit.distance};
  }
  void set(std::uint64_t i, const Hit& hit) const {
    if (i == hits.size()) hits.emplace_back();
    hits[i] = {hit.t, hit.prim, hit.u, hit.distance};
  }
};

/// Lists what is chosen at run time in a vector, which is cleared.
template <class AnyHit>
class HitVectorOfRay : public HitListOfRay<ChosenList, HitVector<AnyHit>> {
 public:
  /// Keeps up to k hits.
  HitVectorOfRay(const Ray& ray, At at, Keep keep, std::vector<AnyHit>& to, std::uint64_t k = ~0ull)
      : HitListOfRay<ChosenList, HitVector<AnyHit>>(ray, {{at}, keep}, {to}, k), hits_(to) {
    to.clear();
  }

  /// Sort the hits: as that of a list does, but faster.
  void finish() {
    std::sort(hits_.begin(), hits_.end(),
              [keep = this->keep](const AnyHit& a, const AnyHit& b) { return fastlines::comes_first(keep, a, b); });
  }

 private:
  std::vector<AnyHit>& hits_;
};

}  // namespace fastlines
