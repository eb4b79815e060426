// Whether rays go together as a bundle or alone: measured from the rays, and from what those before have cost.
//
// A bundle meets what lies between its rays, so it pays as long as they stray little beside what the tree tells apart.
// How little depends on the scene: leaves of straight hair are long, but lie close beside each other. So the bound on
// the spread comes down where bundles turn out dearer than rays alone, and then slowly comes up again. Answers are the
// same, whichever way they are found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace fastlines {

/// What steps take beside each other, in cycles, waiting and packing included: rounded from `bench steps` and from what
/// whole queries take. Only so good that ways which differ by a half are told apart.
struct StepCost {
  static constexpr std::uint64_t kNode = 65, kLeaf = 55, kSegment = 40, kLine = 18, kPack = 70, kTest = 50;
  static constexpr std::uint64_t kRayAlone = 200, kRayTogether = 50;
};

/// Some rays, and what they have cost.
struct Work {
  std::uint64_t cost = 0, rays = 0;

  void operator+=(const Work& other) {
    cost += other.cost;
    rays += other.rays;
  }
  float per_ray() const { return float(cost) / float(rays); }
};

class Choice {
 public:
  explicit Choice(float mean_extent) : widest_(kSpread * mean_extent), bound_(widest_) {}

  /// Before each group of rays.
  void next() { bound_ = std::min(widest_, kForget * bound_); }

  bool together(float spread) const { return spread <= bound_; }

  /// Whether to let a group go alone, to learn what that costs.
  bool curious() { return std::exchange(curious_, false); }

  void note_together(const Work& work, float spread) {
    const float cost = work.per_ray();
    if (cost <= kCheap) return;
    if (alone_.rays == 0)
      curious_ = true;
    else if (const float alone = alone_.per_ray(); cost > alone)
      bound_ = std::min(bound_, spread * alone / cost);
  }

  void note_alone(const Work& work) {
    alone_ += work;
    if (alone_.rays < kRecent) return;
    alone_.cost /= 2;
    alone_.rays /= 2;
  }

 private:
  static constexpr float kSpread = 1.6f;    // of the mean extent of a leaf: the bound at first
  static constexpr float kForget = 1.005f;  // the bound after a group
  static constexpr float kCheap = 600.0f;   // rays alone cost no less
  static constexpr std::uint64_t kRecent = 512;

  float widest_, bound_;
  Work alone_;
  bool curious_ = false;
};

}  // namespace fastlines
