// Decides whether rays are traced as a bundle or as incoherent rays, from their divergence and from measured costs.
//
// A bundle visits everything that lies between its rays. So it pays as long as its divergence is small compared with
// what the tree separates. How small depends on the scene: leaves of straight hair are long but lie side by side.
//
//  - The bound on the divergence falls where bundles cost much more than incoherent rays. It then recovers slowly, or
//    at once where incoherent rays become cheap.
//  - A cost that was measured elsewhere in a picture does not apply here. If a bundle looks expensive and no recent
//    group was traced as incoherent rays, the next group is: this probe measures the cost to compare bundles with.
//
// The choice never changes an answer.
#pragma once

#include <algorithm>
#include <utility>

#include "../cost/step_cost.hpp"

namespace fastlines {

/// Bounds on costs are in the cycles of `BundleStepCost` and `SingleStepCost`.
struct BundleHeuristicTuning {
  /// The bound on the divergence at the start, as a multiple of the mean extent of a leaf.
  static constexpr float kMaxDivergence = 1.6f;
  /// The least bound, as a fraction of the bound at the start.
  static constexpr float kMinDivergence = 0.001f;
  /// The bound grows by this factor with each group.
  static constexpr float kRelaxFactor = 1.01f;
  /// Cycles per ray: a bundle that costs no more is never compared with incoherent rays.
  static constexpr float kTrustCycles = 500.0f;
  /// A bundle is certainly worse than incoherent rays if it costs over this many times as much: costs are inaccurate.
  static constexpr float kWorseFactor = 2.5f;
  /// Groups for which a measured cost of incoherent rays stays valid: later groups lie elsewhere.
  static constexpr int kSampleLifetime = 16;
  /// The bound returns to its start if incoherent rays cost less than this fraction of what they cost when it fell.
  static constexpr float kRecoverFactor = 0.6f;
  /// Cycles per ray: a bundle that costs no more is never aborted.
  static constexpr float kAbortCycles = 6000.0f;
  /// A bundle is aborted only if it costs over this many times as much per ray as incoherent rays.
  static constexpr float kAbortFactor = 4.0f;
  /// Rays: once the sample of incoherent rays has this many, its weight is halved, so that it follows the scene.
  static constexpr std::uint64_t kSampleRays = 512;
};

class BundleHeuristic {
  using Tuning = BundleHeuristicTuning;

 public:
  /// `mean_extent`: of the leaves, in the frame.
  explicit BundleHeuristic(float mean_extent) : max_bound_(Tuning::kMaxDivergence * mean_extent), bound_(max_bound_) {}

  /// Call before each group of rays.
  void begin_group() {
    bound_ = std::min(max_bound_, Tuning::kRelaxFactor * bound_);
    ++sample_age_;
  }

  /// Whether rays of this divergence, in the frame, are traced as a bundle.
  bool is_coherent(float divergence) const { return divergence <= bound_; }

  /// Whether to trace the next group as incoherent rays, to measure their cost. Clears the request.
  bool should_probe() { return std::exchange(probe_, false); }

  /// The most cycles that a bundle of `n_rays` may cost; beyond that, tracing them as incoherent rays is better.
  std::uint64_t budget(int n_rays) const {
    const float measured = incoherent_.rays == 0 ? 0.0f : Tuning::kAbortFactor * incoherent_.per_ray();
    return std::uint64_t(std::max(Tuning::kAbortCycles, measured)) * std::uint64_t(n_rays);
  }

  /// Lower the bound, or request a probe, if a bundle was expensive.
  void record_bundle(const Sample& sample, float divergence) {
    const float cost = sample.per_ray();
    if (cost <= Tuning::kTrustCycles) return;
    if (incoherent_.rays > 0) {
      const float incoherent = incoherent_.per_ray();
      if (cost <= Tuning::kWorseFactor * incoherent) return;
      if (sample_age_ <= Tuning::kSampleLifetime) {
        bound_ = std::min(bound_, std::max(Tuning::kMinDivergence * max_bound_, divergence * incoherent / cost));
        cost_at_tightening_ = incoherent;
        return;
      }
      incoherent_ = {};  // measured elsewhere
    }
    probe_ = true;
  }

  /// Add the cost of incoherent rays to the sample.
  void record_incoherent(const Sample& sample) {
    if (sample.rays == 0) return;
    incoherent_ += sample;
    sample_age_ = 0;
    if (incoherent_.per_ray() < Tuning::kRecoverFactor * cost_at_tightening_) {
      bound_ = max_bound_;
      cost_at_tightening_ = 0.0f;
    }
    if (incoherent_.rays < Tuning::kSampleRays) return;
    incoherent_.cost /= 2;
    incoherent_.rays /= 2;
  }

 private:
  float max_bound_, bound_;          // on the divergence, in the frame
  float cost_at_tightening_ = 0.0f;  // per incoherent ray, when the bound last fell; 0 after a recovery
  Sample incoherent_;
  int sample_age_ = 0;  // groups since incoherent rays were last traced
  bool probe_ = false;
};

}  // namespace fastlines
