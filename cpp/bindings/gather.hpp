// Gathers as tuples of NumPy arrays.
#pragma once

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <stdexcept>

#include "arrays.hpp"
#include "fastlines/query/gather/hit_summer.hpp"

namespace fastlines {

/// The blur, the number of channels, σ and λ of each, g of the phase function, whether ends are left out, the values of
/// primitives, and optical depths (n_rays, n_depths, channels).
using GatherArrays = std::tuple<std::string, int, std::array<float, kMaxChannels>, std::array<float, kMaxChannels>,
                                std::optional<float>, bool, std::optional<Input<float>>, std::optional<Input<float>>>;

inline Blur blur_of(const std::string& name) {
  if (name == "none") return Blur::none;
  if (name == "box") return Blur::box;
  if (name == "epanechnikov") return Blur::epanechnikov;
  throw std::invalid_argument("blur is " + name + "; expected none, box or epanechnikov");
}

inline GatherRule rule_of(const GatherArrays& arrays) {
  const auto& [blur, n_channels, sigma, line_sigma, phase, inner, values, depths] = arrays;
  GatherRule rule{blur_of(blur), n_channels, sigma, line_sigma, phase, inner, {}, {}};
  if (values) rule.values = rows<float>(*values);
  if (depths) {
    rule.depths = rows<float>(*depths);
    rule.n_depths = int(depths->shape(1));
    rule.n_depth_channels = int(depths->shape(2));
  }
  return rule;
}

/// The sums of all rays (n_rays, n_channels), those of squares, and the number of hits that counted.
using GatherTuple = std::tuple<Output<double>, std::optional<Output<double>>, Output<std::int64_t>>;

/// Allocates the arrays of a GatherTuple.
class GatherOutput {
 public:
  GatherOutput(std::size_t n_rays, int n_channels, bool with_squares)
      : n_channels_(n_channels),
        sum_(make_array<double>(n_rays, std::size_t(n_channels))),
        count_(make_array<std::int64_t>(n_rays)) {
    if (with_squares) squares_ = make_array<double>(n_rays, std::size_t(n_channels));
  }

  GatherSums sums() { return {sum_.data(), squares_ ? squares_->data() : nullptr, count_.data(), n_channels_}; }
  GatherTuple tuple() const { return {sum_, squares_, count_}; }

 private:
  int n_channels_;
  Output<double> sum_;
  std::optional<Output<double>> squares_;
  Output<std::int64_t> count_;
};

}  // namespace fastlines
