// Blocks of memory that were released serve the next ones of the same size, whatever it is. The program prints how many
// sizes were tried, and how many of them were not served: none.
#include <cstdio>

#include "fastlines/memory/page_pool.hpp"

int main() {
  using fastlines::PagePool;
  int n_tried = 0, n_missed = 0;
  const auto try_size = [&](std::size_t n_bytes) {
    void* const first = PagePool::allocate(n_bytes);
    PagePool::release(first);
    void* const again = PagePool::allocate(n_bytes);
    ++n_tried;
    n_missed += again != first;
    PagePool::release(again);
  };
  // The larger come first: a block that fits better is taken from those that are kept, if there is one.
  for (std::size_t power = std::size_t(1) << 26; power >= std::size_t(1) << 16; power /= 2)
    for (const std::size_t n_bytes : {power + power / 2, power + power / 8, power + 1, power, power - 1})
      if (n_bytes >= std::size_t(1) << 16) try_size(n_bytes);
  std::printf("%d sizes, %d missed\n", n_tried, n_missed);
  return n_missed;
}
