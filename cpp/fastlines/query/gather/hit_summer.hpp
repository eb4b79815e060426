// Sums the contributions of the hits of a ray, in an order that does not matter (exact_sum.hpp).
#pragma once

#include <vector>

#include "../../memory/large_vector.hpp"
#include "../../rays/hit.hpp"
#include "contribution.hpp"
#include "exact_sum.hpp"

namespace fastlines {

/// The sums of rays as arrays: `n_channels` sums, and sums of squares unless that is null, and one count for each.
struct GatherSums {
  double *sum, *squares;
  std::int64_t* count;
  int n_channels;

  GatherSums of_ray(std::size_t i) const {
    const std::size_t first = i * std::size_t(n_channels);
    return {sum + first, squares ? squares + first : nullptr, count + i, n_channels};
  }
};

/// Sums the hits of one ray after the other; one per thread.
class HitSummer {
 public:
  explicit HitSummer(const GatherRule& rule) : rule_(rule) {}

  /// Write the sums of a ray.
  void sum(const GatherRay& ray, const GatherLines& lines, const GatherHits& hits, const GatherSums& to) {
    const std::size_t padded = (hits.n + kLanes - 1) / kLanes * kLanes;
    const auto n_channels = std::size_t(rule_.n_channels);
    if (contributions_.size() < padded * n_channels) contributions_.resize(2 * padded * n_channels);
    FloatLanes largest[kMaxChannels];
    std::fill_n(largest, n_channels, 0.0f);
    IntLanes counts = 0;
    for (std::size_t first = 0; first < hits.n; first += kLanes) {
      const auto n = int(std::min<std::size_t>(kLanes, hits.n - first));
      prefetch(lines, hits, first + kPrefetchedAhead);
      const Contributions of_hits(rule_, ray, lines, hits, first, n);
      counts = counts - of_hits.counts();
      for (std::size_t c = 0; c < n_channels; ++c) {
        const FloatLanes found = of_hits[int(c)];
        largest[c] = max(largest[c], abs(found));
        found.store(contributions_.data() + c * padded + first);
      }
    }
    *to.count = 0;
    for (int i = 0; i < kLanes; ++i) *to.count += counts[i];
    for (std::size_t c = 0; c < n_channels; ++c) {
      double most = 0.0;
      for (int i = 0; i < kLanes; ++i) most = std::max(most, double(largest[c][i]));
      const float* const of_channel = contributions_.data() + c * padded;
      to.sum[c] = total(of_channel, padded, most, std::uint64_t(*to.count), [](double x) { return x; });
      if (to.squares)
        to.squares[c] =
            total(of_channel, padded, most * most, std::uint64_t(*to.count), [](double x) { return x * x; });
    }
  }

  /// The same of hits in a row.
  void sum(const GatherRay& ray, const GatherLines& lines, std::span<const Hit> hits, const GatherSums& to) {
    const std::size_t n = hits.size();
    for (auto* column : {&t_, &u_, &distance_}) column->resize(n);
    prim_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      t_[k] = hits[k].t;
      u_[k] = hits[k].u;
      distance_[k] = hits[k].distance;
      prim_[k] = std::uint32_t(hits[k].prim);
    }
    sum(ray, lines, {t_.data(), u_.data(), distance_.data(), prim_.data(), prim_.data(), n}, to);
  }

 private:
  /// How many hits ahead lines and values are prefetched.
  static constexpr std::size_t kPrefetchedAhead = 2 * kLanes;

  /// Prefetch the lines and the values of 16 hits.
  void prefetch(const GatherLines& lines, const GatherHits& hits, std::size_t first) const {
    const float* const values = rule_.values.empty() ? nullptr : rule_.values.data();
    for (std::size_t k = first; k < std::min(hits.n, first + kLanes); ++k) {
      __builtin_prefetch(lines.rows + hits.line[k] * lines.n_numbers);
      if (values) __builtin_prefetch(values + hits.prim[k] * std::size_t(rule_.n_channels));
    }
  }

  /// The sum of function(x) of n numbers, which are 0 where a hit does not count.
  template <class Function>
  static double total(const float* numbers, std::size_t n, double largest, std::uint64_t n_counted,
                      const Function& function) {
    ExactSum sum(largest, n_counted);
    for (std::size_t first = 0; first < n; first += kLanes) {
      double x[kLanes];
      for (int i = 0; i < kLanes; ++i) x[i] = function(double(numbers[first + std::size_t(i)]));
      sum.add(x);
    }
    return sum.total();
  }

  const GatherRule& rule_;
  LargeVector<float> contributions_;  // a column for each channel
  std::vector<float> t_, u_, distance_;
  std::vector<std::uint32_t> prim_;
};

}  // namespace fastlines
