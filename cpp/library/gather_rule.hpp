// Checks of what is to be summed over the hits of rays.
#pragma once

#include <cmath>
#include <string>

#include "fastlines/api/gather.hpp"
#include "fastlines/api/tree.hpp"
#include "fastlines/query/gather/hit_summer.hpp"
#include "fastlines/rays/ray_batch.hpp"

namespace fl::detail {

inline void require_numbers(const char* name, std::span<const float> numbers, std::size_t n, const char* expected,
                            float least) {
  if (numbers.size() != n || (n > 0 && !numbers.data()))
    throw InputError(std::string(name) + " are " + std::to_string(numbers.size()) + " numbers, or a null array; " +
                     "expected " + std::to_string(n) + ", " + expected);
  for (std::size_t i = 0; i < n; ++i)
    if (!(std::isfinite(numbers[i]) && numbers[i] >= least))
      throw InputError(std::string(name) + "[" + std::to_string(i) + "] is NaN, infinite or too small; expected " +
                       "finite numbers" + (least == 0.0f ? " from 0 up" : ""));
}

/// The optical depths of rays, as the core reads them.
inline void set_depths(fastlines::GatherRule& rule, const GatherOptions& what, const fastlines::RayBatch& rays) {
  constexpr float largest = std::numeric_limits<float>::max();
  const std::size_t n = rays.size() * what.n_depths, per_step = n == 0 ? 1 : what.optical_depth.size() / n;
  if (what.n_depths < 2)
    throw InputError("optical_depth has n_depths = " + std::to_string(what.n_depths) + "; expected 2 steps or more");
  if (per_step != 1 && per_step != what.n_channels)
    throw InputError("optical_depth has " + std::to_string(what.optical_depth.size()) + " numbers; expected " +
                     "n_depths for each ray, or n_depths · n_channels");
  require_numbers("optical_depth", what.optical_depth, n * per_step, "for the steps of all rays", 0.0f);
  for (const auto values : {rays.t_min, rays.t_max})
    for (const float t : values)
      if (!(std::abs(t) <= largest))
        throw InputError("optical_depth has equal steps from t_min to t_max; expected finite t_min and t_max");
  rule.depths = what.optical_depth;
  rule.n_depths = int(what.n_depths);
  rule.n_depth_channels = int(per_step);
}

/// What is to be summed, as the core reads it.
inline fastlines::GatherRule rule_of(const GatherOptions& what, const QueryOptions& options,
                                     const fastlines::RayBatch& rays, std::size_t n_lines, float max_radius) {
  if (options.at != At::closest) throw InputError("gather sums over hits at At::closest; leave out at");
  if (what.blur < Blur::none || what.blur > Blur::epanechnikov)
    throw InputError("unknown blur; expected one of fl::Blur");
  if (what.n_channels < 1 || what.n_channels > std::size_t(fastlines::kMaxChannels))
    throw InputError("n_channels is " + std::to_string(what.n_channels) + "; expected 1 to 8");
  const std::span sigma(what.sigma), line_sigma(what.line_sigma);
  require_numbers("sigma", sigma, sigma.size(), "one for each channel", 0.0f);
  require_numbers("line_sigma", line_sigma, sigma.size(), "one for each channel", 0.0f);
  if (what.phase && !(std::abs(*what.phase) < 1.0f))
    throw InputError("phase is " + std::to_string(*what.phase) + "; expected a number between -1 and 1");
  fastlines::GatherRule rule{
      fastlines::Blur(what.blur), int(what.n_channels), what.sigma, what.line_sigma, what.phase, what.inner, {}, {}};
  if (!what.values.empty())
    require_numbers("values", what.values, n_lines * what.n_channels, "n_channels for each line",
                    std::numeric_limits<float>::lowest());
  rule.values = what.values;
  if (rays.size() > 0 && what.optical_depth.empty() != (what.n_depths == 0))
    throw InputError("optical_depth has " + std::to_string(what.optical_depth.size()) + " numbers, and n_depths is " +
                     std::to_string(what.n_depths) + "; set both, or neither");
  if (!what.optical_depth.empty()) {
    for (const float each : sigma)
      if (each != 0.0f) throw InputError("optical_depth stands for sigma; set one of them");
    set_depths(rule, what, rays);
  }
  if (what.blur != Blur::none && max_radius == 0.0f)
    for (std::size_t i = 0; i < rays.size(); ++i)
      if (rays[i].radius == 0.0f && rays[i].spread == 0.0f)
        throw InputError(
            "the radius of a ray is 0, which leaves a blur no width; expected a radius above 0, or "
            "Blur::none");
  return rule;
}

/// Make room for the sums of all rays.
inline fastlines::GatherSums make_room(Gathered& to, std::size_t n_rays, const GatherOptions& what) {
  to.n_channels = what.n_channels;
  to.sum.resize(n_rays * what.n_channels);
  if (what.squares) to.squares.resize(n_rays * what.n_channels);
  to.count.resize(n_rays);
  return {to.sum.data(), what.squares ? to.squares.data() : nullptr, to.count.data(), int(what.n_channels)};
}

}  // namespace fl::detail
