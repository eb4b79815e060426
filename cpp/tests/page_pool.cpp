// A released block of the page pool is reused for the next allocation of its size, for many sizes. Vectors keep their
// elements while their pages move. Free room is lent and given back as on a stack.
#include "fastlines/memory/page_pool.hpp"

#include "check.hpp"
#include "fastlines/build/free_room.hpp"
#include "fastlines/memory/large_vector.hpp"

using fastlines::BuildRef;
using fastlines::FreeRoom;
using fastlines::LargeVector;
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

/// Appends vectors of more and of less than the pieces that are moved at a time.
void move_vectors() {
  LargeVector<std::uint64_t> all;
  for (const std::size_t n : {0, 1, 1000, 3'000'000, 1'500'001}) {
    LargeVector<std::uint64_t> more(n);
    for (std::size_t i = 0; i < n; ++i) more[i] = all.size() + i;
    reserve_more(all, n);
    append_moved(all, std::move(more));
    check(more.capacity() == 0, "the moved vector is freed");
  }
  check(all.size() == 4'501'002, "all elements are there");
  bool same = true;
  for (std::size_t i = 0; i < all.size(); ++i) same = same && all[i] == i;
  check(same, "elements keep their values and order");
}

void lend_room() {
  std::vector<BuildRef> memory(100), other(10);
  FreeRoom room;
  check(room.take(1).part.empty(), "no room");
  {
    const FreeRoom::More more(room, memory, 20);
    const auto first = room.take(60);
    check(first.part.data() == memory.data() + 40, "the end of an area is lent");
    {
      const FreeRoom::More again(room, other, 20);
      check(room.take(41).part.empty(), "no area is large enough");
      const auto second = room.take(10), third = room.take(31);
      check(second.part.data() == memory.data() + 30 && third.part.empty(), "the first area that is large enough");
      const auto last = room.take(30);
      check(last.part.data() == memory.data(), "the rest of an area");
      check(room.take(5).part.data() == other.data() + 5, "then the next area");
      room.give_back(last);
      room.give_back(second);
    }
    room.give_back(first);
    check(room.take(100).part.data() == memory.data(), "all was given back");
  }
  check(room.take(1).part.empty(), "the area is gone");
}

}  // namespace

int main() {
  return fastlines::test::run([] {
    // Larger sizes come first, because a kept block that fits better would be reused instead.
    for (std::size_t power = std::size_t(1) << 26; power >= std::size_t(1) << 16; power /= 2)
      for (const std::size_t n_bytes : {power + power / 2, power + power / 8, power + 1, power, power - 1})
        if (n_bytes >= std::size_t(1) << 16) try_size(n_bytes);
    move_vectors();
    lend_room();
  });
}
