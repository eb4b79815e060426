// The memory of open nodes that holds no references any more, for those of nodes below.
#pragma once

#include <span>
#include <vector>

#include "../references/build_ref.hpp"

namespace fastlines {

/// Areas of free memory. They are lent and given back in the order of a stack, as the nodes are built.
class FreeRoom {
 public:
  /// The end of an area, lent; empty if no area is large enough.
  struct Part {
    std::span<BuildRef> part;
    std::size_t area = 0;
  };

  Part take(std::size_t n) {
    for (std::size_t i = 0; i < areas_.size(); ++i)
      if (std::span<BuildRef>& area = areas_[i]; area.size() >= n) {
        const Part taken{area.last(n), i};
        area = area.first(area.size() - n);
        return taken;
      }
    return {};
  }

  /// Gives back the part that was taken last.
  void give_back(const Part& taken) {
    if (taken.part.empty()) return;
    std::span<BuildRef>& area = areas_[taken.area];
    area = {area.data(), area.size() + taken.part.size()};
  }

  /// Adds an area for as long as this lives, for the build of a node of n_refs references. Pages that this hardly needs
  /// are returned to the system.
  class More {
   public:
    More(FreeRoom& room, std::span<BuildRef> area, std::size_t n_refs) : room_(room) {
      // The right child has about half of the references, and takes the end of the area.
      const std::size_t n_kept = n_refs / 2 + n_refs / 8;
      if (area.size() > n_kept) PagePool::discard(area.data(), area.data() + (area.size() - n_kept));
      room.areas_.push_back(area);
    }
    ~More() { room_.areas_.pop_back(); }
    More(const More&) = delete;
    More& operator=(const More&) = delete;

   private:
    FreeRoom& room_;
  };

 private:
  std::vector<std::span<BuildRef>> areas_;
};

}  // namespace fastlines
