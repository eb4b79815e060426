// Whether rays go together as a bundle or alone: measured from the rays, and from what those before have cost.
//
// A bundle meets what lies between its rays, so it pays as long as they stray little beside what the tree tells apart.
// How little depends on the scene: leaves of straight hair are long, but lie close beside each other. So the bound on
// the spread comes down where bundles turn out much dearer than rays alone, then slowly comes up again, and at once
// where rays alone get cheap. What rays alone cost elsewhere in a picture tells nothing: where a bundle looks dear and
// none went alone of late, the next group does, and those after it are judged by that. Answers are the same, whichever
// way they are found.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

namespace fastlines {

/// What steps take in a bundle, and alone in a wave or a stream, in cycles: with their share of all that is in no step,
/// so that they sum to what first hits take. Lists take up to twice as much, both ways. Only so good that ways which
/// differ by a half are told apart.
struct TogetherCost {
  static constexpr std::uint64_t kRay = 60, kNode = 80, kLeaf = 65, kSegment = 45, kLine = 12, kPack = 90;
};
struct AloneCost {
  static constexpr std::uint64_t kRay = 190, kRoot = 35, kNode = 65, kLeaf = 45, kTest = 50, kPack = 225;
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
  void next() {
    bound_ = std::min(widest_, kForget * bound_);
    ++age_;
  }

  bool together(float spread) const { return spread <= bound_; }

  /// Whether to let a group go alone, to learn what that costs.
  bool curious() { return std::exchange(curious_, false); }

  /// What so many rays may cost together before they are better asked alone after all.
  std::uint64_t most(int n_rays) const {
    const float a_ray = alone_.rays == 0 ? kMost : std::max(kMost, kGiveUp * alone_.per_ray());
    return std::uint64_t(a_ray) * std::uint64_t(n_rays);
  }

  void note_together(const Work& work, float spread) {
    const float cost = work.per_ray();
    if (cost <= kCheap) return;
    if (alone_.rays > 0) {
      const float alone = alone_.per_ray();
      if (cost <= kSurely * alone) return;
      if (age_ <= kHere) {
        bound_ = std::min(bound_, std::max(kNarrowest * widest_, spread * alone / cost));
        then_ = alone;
        return;
      }
      alone_ = {};  // that was elsewhere
    }
    curious_ = true;
  }

  void note_alone(const Work& work) {
    if (work.rays == 0) return;
    alone_ += work;
    age_ = 0;
    if (alone_.per_ray() < kElsewhere * then_) {
      bound_ = widest_;
      then_ = 0.0f;
    }
    if (alone_.rays < kRecent) return;
    alone_.cost /= 2;
    alone_.rays /= 2;
  }

 private:
  static constexpr float kSpread = 1.6f;         // of the mean extent of a leaf: the bound at first
  static constexpr float kNarrowest = 0.001f;    // of that: it comes no farther down
  static constexpr float kForget = 1.01f;        // the bound after a group
  static constexpr float kCheap = 500.0f;        // a ray of a bundle that nobody doubts
  static constexpr float kSurely = 2.5f;         // dearer than alone, however wrong the costs are
  static constexpr int kHere = 16;               // rays alone of so many groups before tell what they would cost here
  static constexpr float kElsewhere = 0.6f;      // where rays alone cost so much less, bundles are tried again
  static constexpr float kMost = 6000.0f;        // a ray of a bundle that is not given up,
  static constexpr float kGiveUp = 4.0f;         // or so many times as much as alone
  static constexpr std::uint64_t kRecent = 512;  // of more rays alone than these, half is forgotten

  float widest_, bound_;
  float then_ = 0.0f;  // what rays alone cost when the bound came down last
  Work alone_;
  int age_ = 0;  // groups since rays went alone
  bool curious_ = false;
};

}  // namespace fastlines
