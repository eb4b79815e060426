// Asking for memory before it is needed.
#pragma once

#include "../layout/wide.hpp"

namespace fastlines {

/// A block of 128 bytes: two lines of a cache.
template <class Block>
void fetch(const Block* block) {
  __builtin_prefetch(block);
  __builtin_prefetch(reinterpret_cast<const char*>(block) + 64);
}

/// The references of a leaf: three lines hold nearly all.
inline void fetch_refs(const WideView& tree, const WideLeaf& leaf) {
  constexpr int kPerLine = 64 / sizeof(Reference);
  for (int i = 0; i < 3; ++i) __builtin_prefetch(tree.refs + leaf.first_ref + i * kPerLine);
}

}  // namespace fastlines
