// The list of hits that a thread keeps for calls that copy it.
#pragma once

#include <vector>

#include "fastlines/api/ray.hpp"
#include "fastlines/memory/thread_scratch.hpp"

namespace fl::detail {

inline std::vector<Hit>& thread_hits() { return fastlines::thread_scratch<std::vector<Hit>>(); }

/// Frees a list of over a megabyte, which the thread would keep to its end.
inline void release_large(std::vector<Hit>& hits) {
  if (hits.capacity() > (std::size_t(1) << 20) / sizeof(Hit)) std::vector<Hit>().swap(hits);
}

}  // namespace fl::detail
