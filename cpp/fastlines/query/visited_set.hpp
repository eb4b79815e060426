// A hash set of the primitives that a ray or a bundle has tested, cleared in constant time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fastlines {

/// Open addressing with linear probing. A slot is empty unless it has the current epoch.
class VisitedSet {
 public:
  void clear() {
    size_ = 0;
    if (++epoch_ == 0) {
      slots_.assign(slots_.size(), {});
      epoch_ = 1;
    }
  }

  /// Make room for `more` primitives. At most a quarter of the slots is full, so that probing rarely continues and its
  /// end is predicted.
  void reserve(std::size_t more) {
    while (4 * (size_ + more) > slots_.size()) grow();
  }

  /// Insert a primitive; `reserve` has made room. Returns false if the set contains it already.
  [[gnu::always_inline]] bool insert(std::uint32_t prim) {
    Slot* const slots = slots_.data();
    const std::size_t mask = slots_.size() - 1;
    const Slot slot{prim, epoch_};
    std::size_t i = (prim * 0x9e37'79b9u >> 8) & mask;
    while (slots[i].epoch == slot.epoch && slots[i].prim != prim) i = (i + 1) & mask;
    const bool is_new = slots[i].epoch != slot.epoch;
    slots[i] = slot;
    size_ += is_new;
    return is_new;
  }

 private:
  struct Slot {
    std::uint32_t prim = 0, epoch = 0;
  };

  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(512, 2 * slots_.size()));
    old.swap(slots_);
    size_ = 0;
    for (const Slot& slot : old)
      if (slot.epoch == epoch_) insert(slot.prim);
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
  std::uint32_t epoch_ = 1;
};

}  // namespace fastlines
