// A hash set of the primitives that a ray or a bundle has tested, or of pairs of a ray and a primitive, cleared in
// constant time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

namespace fastlines {

/// Open addressing with linear probing. A slot is empty unless it has the current epoch. Keys are unsigned integers.
/// When the epochs of this type are used up, all slots are cleared.
template <class Key, class Epoch = std::uint32_t>
class VisitedSetOf {
 public:
  void clear() {
    size_ = 0;
    if (++epoch_ == 0) {
      slots_.assign(slots_.size(), {});
      epoch_ = 1;
    }
  }

  /// Make room for `more` keys. At most a quarter of the slots is full, so that probing rarely continues and its
  /// end is predicted.
  void reserve(std::size_t more) {
    while (4 * (size_ + more) > slots_.size()) grow();
  }

  /// Insert a key; `reserve` has made room. Returns false if the set contains it already.
  [[gnu::always_inline]] bool insert(Key key) {
    Slot* const slots = slots_.data();
    const std::size_t mask = slots_.size() - 1;
    const Slot slot{key, epoch_};
    std::size_t i = hash(key) & mask;
    while (slots[i].epoch == slot.epoch && slots[i].key != key) i = (i + 1) & mask;
    const bool is_new = slots[i].epoch != slot.epoch;
    slots[i] = slot;
    size_ += is_new;
    return is_new;
  }

 private:
  struct Slot {
    Key key = 0;
    Epoch epoch = 0;
  };

  [[gnu::always_inline]] static std::size_t hash(Key key) {
    if constexpr (sizeof(Key) == 4)
      return key * 0x9e37'79b9u >> 8;
    else
      return std::size_t(key * 0x9e37'79b9'7f4a'7c15u >> 24);
  }

  void grow() {
    std::vector<Slot> old(std::max<std::size_t>(512, 2 * slots_.size()));
    old.swap(slots_);
    size_ = 0;
    for (const Slot& slot : old)
      if (slot.epoch == epoch_) insert(slot.key);
  }

  std::vector<Slot> slots_;
  std::size_t size_ = 0;
  Epoch epoch_ = 1;
};
using VisitedSet = VisitedSetOf<std::uint32_t>;

}  // namespace fastlines
