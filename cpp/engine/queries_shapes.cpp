// Compiles the kernels for shapes.
#include "layout_queries.hpp"

template struct fastlines::LayoutQueries<fastlines::Shapes>;
