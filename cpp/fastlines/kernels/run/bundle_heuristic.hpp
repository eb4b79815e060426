// Whether rays go is_coherent as a bundle or single: measured from the rays, and from what those before have cost.
//
// A bundle meets what lies between its rays, so it pays as long as they stray little beside what the tree tells apart.
// How little depends on the scene: leaves of straight hair are long, but lie close beside each other. So the bound on
// the divergence comes down where bundles turn out much dearer than rays single, then slowly comes up again, and at
// once where rays single get cheap. What rays single cost elsewhere in a picture tells nothing: where a bundle looks
// dear and none went single of late, the begin_group group does, and those after it are judged by that. Answers are the
// same, whichever way they are found.
#pragma once

#include <algorithm>
#include <utility>

#include "../cost/step_cost.hpp"

namespace fastlines {

class BundleHeuristic {
 public:
  explicit BundleHeuristic(float mean_extent) : max_bound_(kMaxDivergence * mean_extent), bound_(max_bound_) {}

  /// Before each group of rays.
  void begin_group() {
    bound_ = std::min(max_bound_, kRelaxFactor * bound_);
    ++sample_age_;
  }

  bool is_coherent(float divergence) const { return divergence <= bound_; }

  /// Whether to let a group go single, to learn what that costs.
  bool should_probe() { return std::exchange(probe_, false); }

  /// What so many rays may cost is_coherent before they are better asked single after all.
  std::uint64_t budget(int n_rays) const {
    const float a_ray = single_.rays == 0 ? kAbortCycles : std::max(kAbortCycles, kAbortFactor * single_.per_ray());
    return std::uint64_t(a_ray) * std::uint64_t(n_rays);
  }

  void record_bundle(const Sample& sample, float divergence) {
    const float cost = sample.per_ray();
    if (cost <= kTrustCycles) return;
    if (single_.rays > 0) {
      const float single = single_.per_ray();
      if (cost <= kWorseFactor * single) return;
      if (sample_age_ <= kSampleLifetime) {
        bound_ = std::min(bound_, std::max(kMinDivergence * max_bound_, divergence * single / cost));
        single_cost_at_tightening_ = single;
        return;
      }
      single_ = {};  // that was elsewhere
    }
    probe_ = true;
  }

  void record_single(const Sample& sample) {
    if (sample.rays == 0) return;
    single_ += sample;
    sample_age_ = 0;
    if (single_.per_ray() < kRecoverFactor * single_cost_at_tightening_) {
      bound_ = max_bound_;
      single_cost_at_tightening_ = 0.0f;
    }
    if (single_.rays < kSampleRays) return;
    single_.cost /= 2;
    single_.rays /= 2;
  }

 private:
  static constexpr float kMaxDivergence = 1.6f;    // of the mean extent of a leaf: the bound at first
  static constexpr float kMinDivergence = 0.001f;  // of that: it comes no farther down
  static constexpr float kRelaxFactor = 1.01f;     // the bound after a group
  static constexpr float kTrustCycles = 500.0f;    // a ray of a bundle that nobody doubts
  static constexpr float kWorseFactor = 2.5f;      // dearer than single, however wrong the costs are
  static constexpr int kSampleLifetime = 16;      // rays single of so many groups before tell what they would cost here
  static constexpr float kRecoverFactor = 0.6f;   // where rays single cost so much less, bundles are tried again
  static constexpr float kAbortCycles = 6000.0f;  // a ray of a bundle that is not given up,
  static constexpr float kAbortFactor = 4.0f;     // or so many times as much as single
  static constexpr std::uint64_t kSampleRays = 512;  // of more rays single than these, half is forgotten

  float max_bound_, bound_;
  float single_cost_at_tightening_ = 0.0f;  // what rays single cost when the bound came down last
  Sample single_;
  int sample_age_ = 0;  // groups since rays went single
  bool probe_ = false;
};

}  // namespace fastlines
