// Sets of visited primitives have the keys of std::set, also when they are cleared more often than there are epochs.
#include "fastlines/query/visited_set.hpp"

#include <set>

#include "check.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// Insert a few keys, or so many that the set grows, and clear it, again and again.
template <class Key, class Epoch>
void check_keys(Random& random, int n_rounds) {
  VisitedSetOf<Key, Epoch> visited;
  for (int round = 0; round < n_rounds; ++round) {
    visited.clear();
    std::set<Key> expected;
    const std::size_t n = random.below(round % 16 == 0 ? 1000 : 20);
    for (std::size_t i = 0; i < n; ++i) {
      const Key key = Key(random() >> (random.below(2) ? 62 : 40));
      visited.reserve(1);
      check(visited.insert(key) == expected.insert(key).second, "a key is new if it was not inserted since the clear");
    }
  }
}

/// Insert a key after so many clears, each of which is a new epoch.
void check_epochs(int n_clears) {
  VisitedSetOf<std::uint32_t, std::uint8_t> visited;
  visited.reserve(1);
  for (int i = 0; i < n_clears; ++i) visited.clear();
  check(visited.insert(0) && !visited.insert(0), "a key is new in every epoch");
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    check_keys<std::uint32_t, std::uint32_t>(random, 100);
    check_keys<std::uint64_t, std::uint32_t>(random, 100);
    check_keys<std::uint32_t, std::uint8_t>(random, 2000);
    for (int n_clears = 0; n_clears < 1000; ++n_clears) check_epochs(n_clears);
  });
}
