// Compiles the kernels for segments.
#include "layout_kernels.hpp"

template struct fastlines::LayoutQueries<fastlines::Segments>;
