// Compiles the kernels for shapes.
#include "layout_kernels.hpp"

template struct fastlines::LayoutQueries<fastlines::Shapes>;
