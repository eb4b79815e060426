// Pairs of near primitives, on wide layouts and by brute force. The kernel has a source file of its own.
#pragma once

#include "fastlines/kernels/proximity/pair_search.hpp"

namespace fastlines {

/// The pairs of a query, sorted.
PairColumns find_pairs(const PairQuery& query, const PairTree& first, const PairTree& second, unsigned n_threads,
                       Progress& progress);

/// The same by brute force, 16 pairs at a time.
PairColumns test_all_pairs(const PairQuery& query, unsigned n_threads, Progress& progress);

}  // namespace fastlines
