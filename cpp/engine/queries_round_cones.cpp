// Compiles the kernels for round cones.
#include "layout_queries.hpp"

template struct fastlines::LayoutQueries<fastlines::RoundCones>;
