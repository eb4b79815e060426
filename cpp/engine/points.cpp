// Compiles the queries of points.
#include "point_queries.hpp"

namespace fastlines {

template struct PointsQuery<PointSearch<Segments>>;
template struct PointsQuery<PointSearch<RoundCones>>;
template struct PointsQuery<PointSearch<Shapes>>;

}  // namespace fastlines
