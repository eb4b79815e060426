// A released block of the page pool is reused for the next allocation of its size, for many sizes.
#include "fastlines/memory/page_pool.hpp"

#include "check.hpp"

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
    // Larger sizes come first, because a kept block that fits better would be reused instead.
    for (std::size_t power = std::size_t(1) << 26; power >= std::size_t(1) << 16; power /= 2)
      for (const std::size_t n_bytes : {power + power / 2, power + power / 8, power + 1, power, power - 1})
        if (n_bytes >= std::size_t(1) << 16) try_size(n_bytes);
  });
}
