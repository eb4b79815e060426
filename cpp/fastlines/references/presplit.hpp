// Presplit, or early split clipping (Ernst, Greiner 2007, "Early split clipping for bounding volume hierarchies";
// thesis §2.2): curves are cut before the build, in the middle of the longest side of their boxes, until no box is
// larger than a bound. The largest box comes first, so a number of references is a bound too.
#pragma once

#include <algorithm>

#include "../parallel/task_group.hpp"
#include "cut.hpp"

namespace fastlines {

/// Where cutting ends; by default before it begins.
struct Presplit {
  double area = std::numeric_limits<double>::infinity();  ///< no box is larger, in parts of the area of the scene's box
  std::size_t max_refs = std::size_t(-1);                 ///< there are no more pieces
};

/// One reference to each whole primitive.
template <Primitives P>
Buffer<BuildRef> whole_references(const P& prims, TaskGroup& tasks) {
  Buffer<BuildRef> refs;
  BuildRef* const data = refs.make_room(prims.size());
  tasks.in_parts(0, prims.size(), 1 << 14, [&prims, data](std::size_t first, std::size_t end) {
    for (std::size_t prim = first; prim < end; ++prim)
      data[prim] = {{std::uint32_t(prim)}, prims.bounds(std::uint32_t(prim))};
  });
  refs.keep(prims.size());
  return refs;
}

/// What a build begins with. Where max_refs ends the cutting before an area that was asked for, n_refused grows.
template <Primitives P>
Buffer<BuildRef> first_references(const P& prims, const Presplit& presplit, TaskGroup& tasks, Progress& progress,
                                  std::size_t& n_refused) {
  Buffer<BuildRef> whole = whole_references(prims, tasks);
  if constexpr (Curves<P>) {
    if (presplit.area == std::numeric_limits<double>::infinity()) return whole;
    const double bound = presplit.area * bounds_of_all(prims).area();
    std::vector<BuildRef> refs(whole.begin(), whole.end());

    // The largest first; of the same size, the first.
    using Entry = std::pair<double, std::uint32_t>;
    const auto before = [](const Entry& a, const Entry& b) {
      return a.first != b.first ? a.first < b.first : a.second > b.second;
    };
    std::vector<Entry> large;
    const auto list = [&](std::size_t i) {
      const double area = refs[i].box.area();
      if (area > bound) large.push_back({area, std::uint32_t(i)});
      return area > bound;
    };
    for (std::size_t i = 0; i < refs.size(); ++i) list(i);
    std::make_heap(large.begin(), large.end(), before);
    for (std::size_t n_done = 0; !large.empty(); ++n_done) {
      if (n_done % 1024 == 0) progress.check();
      if (refs.size() >= presplit.max_refs) {
        n_refused += bound > 0.0;
        break;
      }
      std::pop_heap(large.begin(), large.end(), before);
      const std::size_t i = large.back().second;
      large.pop_back();
      const int axis = refs[i].box.longest_axis();
      const float plane = float(0.5 * (double(refs[i].box.lo[axis]) + double(refs[i].box.hi[axis])));
      if (side_of(refs[i].box, axis, plane) != Side::both) continue;  // too thin for floats to divide
      BuildRef rest = refs[i];
      cut(prims, axis, plane, refs[i], rest);
      refs.push_back(rest);
      for (const std::size_t part : {i, refs.size() - 1})
        if (list(part)) std::push_heap(large.begin(), large.end(), before);
    }
    whole.assign(refs);
  }
  return whole;
}

}  // namespace fastlines
