// Which primitives a bundle has met: a small hash set that is empty again at once.
#pragma once

#include <cstdint>
#include <vector>

namespace fastlines {

class SeenSet {
 public:
  void clear() {
    size_ = 0;
    if (++epoch_ == 0) {
      slots_.assign(slots_.size(), {});
      epoch_ = 1;
    }
  }

  /// Put a primitive in; false if it was there.
  bool insert(std::uint32_t prim) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    if (!put(prim)) return false;
    ++size_;
    return true;
  }

 private:
  struct Slot {
    std::uint32_t prim = 0, epoch = 0;
  };

  bool put(std::uint32_t prim) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = (prim * 0x9e37'79b9u >> 8) & mask;
    for (; slots_[i].epoch == epoch_; i = (i + 1) & mask)
      if (slots_[i].prim == prim) return false;
    slots_[i] = {prim, epoch_};
    return true;
  }

  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(256, 2 * slots_.size()));
    old.swap(slots_);
    for (const Slot& slot : old)
      if (slot.epoch == epoch_) put(slot.prim);
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
  std::uint32_t epoch_ = 1;
};

}  // namespace fastlines
