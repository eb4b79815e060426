// A piecewise linear function, the same as numpy.interp, whose pieces are found through a table.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace fastlines {

class Interpolation {
 public:
  /// Values at places that rise from 0 to 1; there are at least two.
  Interpolation(std::span<const double> places, std::span<const double> values)
      : places_(places), values_(values), first_(2 * places.size() + 1) {
    std::size_t piece = 0;
    for (std::size_t cell = 0; cell < first_.size(); ++cell) {
      while (piece + 2 < places.size() && places[piece + 1] <= double(cell) / double(first_.size() - 1)) ++piece;
      first_[cell] = std::uint32_t(piece);
    }
  }

  double operator()(double x) const {
    if (!(x > places_.front())) return values_.front();
    if (x >= places_.back()) return values_.back();
    std::size_t piece = first_[std::size_t(x * double(first_.size() - 1))];
    while (places_[piece + 1] <= x) ++piece;
    const double slope = (values_[piece + 1] - values_[piece]) / (places_[piece + 1] - places_[piece]);
    return slope * (x - places_[piece]) + values_[piece];
  }

 private:
  std::span<const double> places_, values_;
  std::vector<std::uint32_t> first_;  // the piece in which each cell of equal steps begins
};

}  // namespace fastlines
