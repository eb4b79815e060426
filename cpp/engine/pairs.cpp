// Compiles the search for pairs, for primitives of all kinds.
#include "pair_queries.hpp"

#include "fastlines/query/proximity/all_pairs.hpp"

namespace fastlines {

PairColumns find_pairs(const PairQuery& query, const PairTree& first, const PairTree& second, unsigned n_threads,
                       Progress& progress) {
  PairList list(query);
  const Stage stage{0.0, 0.9};
  if (query.surface)
    PairSearch<true>{query, first, second}.find(list, n_threads, progress, stage);
  else
    PairSearch<false>{query, first, second}.find(list, n_threads, progress, stage);
  return list.sorted(n_threads, progress, {0.9, 1.0});
}

PairColumns test_all_pairs(const PairQuery& query, unsigned n_threads, Progress& progress) {
  return all_pairs<FloatX16>(query, n_threads, progress);
}

}  // namespace fastlines
