// Asking for memory before it is needed.
#pragma once

#include "../../layout/wide_bvh.hpp"

namespace fastlines {

/// A block of 128 bytes: two lines of a cache.
template <class Block>
void prefetch(const Block* block) {
  __builtin_prefetch(block);
  __builtin_prefetch(reinterpret_cast<const char*>(block) + 64);
}

/// The references of a leaf: two lines hold most.
template <RayPrimitive P>
void prefetch_refs(const WideBvhView<P>& tree, const WideLeaf& leaf) {
  const auto* const refs = reinterpret_cast<const char*>(tree.refs + leaf.first_ref);
  for (int line = 0; line < 2; ++line) __builtin_prefetch(refs + 64 * line);
}

}  // namespace fastlines
