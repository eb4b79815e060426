// Compiles the kernels for round cones.
#include "layout_kernels.hpp"

template struct fastlines::LayoutQueries<fastlines::RoundCones>;
