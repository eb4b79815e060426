// Prefetches nodes, leaves and references.
#pragma once

#include "../../layout/wide_bvh.hpp"

namespace fastlines {

/// Prefetch a block of 128 bytes, two cache lines.
template <class Block>
void prefetch(const Block* block) {
  __builtin_prefetch(block);
  __builtin_prefetch(reinterpret_cast<const char*>(block) + 64);
}

/// Prefetch the references of a leaf. Two cache lines hold most of them.
template <RayPrimitive P>
void prefetch_refs(const WideBvhView<P>& tree, const WideLeaf& leaf) {
  const auto* const refs = reinterpret_cast<const char*>(tree.refs + leaf.first_ref);
  for (int line = 0; line < 2; ++line) __builtin_prefetch(refs + 64 * line);
}

}  // namespace fastlines
