// The queries of points on a wide layout. They are compiled in a source file of their own, points.cpp.
#pragma once

#include "fastlines/kernels/proximity/one_point.hpp"
#include "fastlines/primitives/shapes.hpp"
#include "fastlines/query/proximity/for_each_point.hpp"

namespace fastlines {

extern template struct PointsQuery<PointSearch<Segments>>;
extern template struct PointsQuery<PointSearch<RoundCones>>;
extern template struct PointsQuery<PointSearch<Shapes>>;

// One point.
extern template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, NearestOfPoint&);
extern template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, KNearestOfPoint&);
extern template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, WithinOfPoint&);
extern template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, CountOfPoint&);
extern template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, NearestOfPoint&);
extern template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, KNearestOfPoint&);
extern template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, WithinOfPoint&);
extern template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, CountOfPoint&);

}  // namespace fastlines
