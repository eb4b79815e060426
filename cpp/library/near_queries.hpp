// The queries of a tree about points and pairs, which each instruction set compiles.
#pragma once

#include <memory>

#include "fastlines/api/tree.hpp"
#include "strand_places.hpp"

namespace fl::detail {

/// What a query for pairs reads of a tree; only engines know what it is, and all of them the same.
struct PairSide;

/// Queries throw InputError for what they cannot use.
class NearQueries {
 public:
  virtual ~NearQueries();

  virtual NearLine nearest(const Point& point, float max_distance, To to) const = 0;
  virtual void k_nearest(const Point& point, std::size_t k, float max_distance, To to,
                         std::vector<NearLine>& lines) const = 0;
  virtual void within(const Point& point, float radius, To to, std::vector<NearLine>& lines) const = 0;
  virtual std::size_t count_within(const Point& point, float radius, To to) const = 0;

  virtual NearLines k_nearest(const Points& points, std::size_t k, const PerPoint& max_distance,
                              const PointOptions& options) const = 0;
  virtual NearLists within(const Points& points, const PerPoint& radius, const PointOptions& options) const = 0;
  virtual std::vector<std::int64_t> count_within(const Points& points, const PerPoint& radius,
                                                 const PointOptions& options) const = 0;

  virtual const PairSide& pair_side() const = 0;
  /// The pairs with another tree; nullptr stands for this one. `places` are those of this tree along its strands.
  virtual Pairs pairs(float radius, const NearQueries* other, std::span<const StrandPlace> places,
                      const PairOptions& options) const = 0;
};

}  // namespace fl::detail
