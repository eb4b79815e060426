// The queries of points on a wide layout. They are compiled in a source file of their own, points.cpp.
#pragma once

#include "fastlines/kernels/proximity/point_search.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/query/proximity/for_each_point.hpp"

namespace fastlines {

extern template struct PointsQuery<PointSearch<Segments>>;
extern template struct PointsQuery<PointSearch<RoundCones>>;
extern template struct PointsQuery<PointSearch<Shapes>>;

}  // namespace fastlines
