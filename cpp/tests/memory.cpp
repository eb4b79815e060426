// Blocks of memory that were released serve the next ones of the same size, whatever it is.
#include "check.hpp"
#include "fastlines/memory/page_pool.hpp"

using fastlines::PagePool;
using fastlines::test::check;

namespace {

void try_size(std::size_t n_bytes) {
  void* const first = PagePool::allocate(n_bytes);
  PagePool::release(first);
  void* const again = PagePool::allocate(n_bytes);
  check(again == first, "a released block serves the next one of its size");
  PagePool::release(again);
}

}  // namespace

int main() {
  return fastlines::test::run([] {
    // The larger come first: a block that fits better is taken from those that are kept, if there is one.
    for (std::size_t power = std::size_t(1) << 26; power >= std::size_t(1) << 16; power /= 2)
      for (const std::size_t n_bytes : {power + power / 2, power + power / 8, power + 1, power, power - 1})
        if (n_bytes >= std::size_t(1) << 16) try_size(n_bytes);
  });
}
