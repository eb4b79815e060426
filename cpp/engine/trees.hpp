// Builds over segments and layouts, compiled once for each instruction set.
#pragma once

#include "fastlines/build/builder.hpp"
#include "fastlines/layout/collapse.hpp"
#include "fastlines/primitives/shapes.hpp"

namespace fastlines {

extern template class Builder<Segments>;

#define FASTLINES_COLLAPSE(P)                                                                                 \
  template WideBvh collapse(std::span<const Node>, std::span<const Reference>, const P&, const CollapseCost&, \
                            unsigned, Progress&)
extern FASTLINES_COLLAPSE(Segments);
extern FASTLINES_COLLAPSE(RoundCones);
extern FASTLINES_COLLAPSE(Shapes);

}  // namespace fastlines
