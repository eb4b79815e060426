// Compiles the kernels for rays with a spread.
#include "layout_kernels.hpp"

template struct fastlines::LayoutQueries<fastlines::SpreadCones>;
