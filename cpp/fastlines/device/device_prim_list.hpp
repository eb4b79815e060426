// The primitives that one ray hits, in the memory of the device: to count each once, where a ray may find one in
// several leaves.
#pragma once

#include "../query/ray_collectors.hpp"

namespace fastlines {

/// Lists the ids of all primitives that a ray hits. A count has told how much room they need.
class PrimListOfRay : public ChosenAt {
 public:
  static constexpr bool kShrinksLimit = false, kDropsFarther = false;
  float limit;

  PrimListOfRay(const Ray& ray, At at_, std::uint32_t* prims) : ChosenAt{at_}, limit(ray.t_max), prims_(prims) {}

  void add(const ClosestApproach<float>&, const Reference& ref) { prims_[n_++] = ref.prim; }

  /// Count the primitives.
  std::uint64_t count() {
    sort_list(*this, n_);
    std::uint64_t n = 0;
    for (std::uint64_t i = 0; i < n_; ++i) n += i == 0 || prims_[i] != prims_[i - 1];
    return n;
  }

  bool comes_first(std::uint64_t i, std::uint64_t j) const { return prims_[i] < prims_[j]; }

  void swap(std::uint64_t i, std::uint64_t j) {
    const std::uint32_t prim = prims_[i];
    prims_[i] = prims_[j];
    prims_[j] = prim;
  }

 private:
  std::uint32_t* prims_;
  std::uint64_t n_ = 0;
};

}  // namespace fastlines
