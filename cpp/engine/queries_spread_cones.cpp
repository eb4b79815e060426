// Compiles the kernels for rays with a spread.
#include "layout_queries.hpp"

template struct fastlines::LayoutQueries<fastlines::SpreadCones>;
