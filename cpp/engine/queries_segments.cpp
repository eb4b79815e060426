// Compiles the kernels for segments.
#include "layout_queries.hpp"

template struct fastlines::LayoutQueries<fastlines::Segments>;
