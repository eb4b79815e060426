// Compiles the queries of points.
#include "point_queries.hpp"

namespace fastlines {

template struct PointsQuery<PointSearch<Segments>>;
template struct PointsQuery<PointSearch<RoundCones>>;
template struct PointsQuery<PointSearch<Shapes>>;

template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, NearestOfPoint&);
template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, KNearestOfPoint&);
template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, WithinOfPoint&);
template void traverse_near(const WideBvhView<Segments>&, const PointQuery&, CountOfPoint&);
template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, NearestOfPoint&);
template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, KNearestOfPoint&);
template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, WithinOfPoint&);
template void traverse_near(const WideBvhView<RoundCones>&, const PointQuery&, CountOfPoint&);

}  // namespace fastlines
