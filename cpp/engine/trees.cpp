// Compiles builds and layouts.
#include "trees.hpp"

namespace fastlines {

template class Builder<Segments>;
FASTLINES_COLLAPSE(Segments);
FASTLINES_COLLAPSE(RoundCones);
FASTLINES_COLLAPSE(Shapes);

}  // namespace fastlines
