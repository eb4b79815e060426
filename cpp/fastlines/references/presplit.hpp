// Presplit, or early split clipping (Ernst, Greiner 2007, "Early split clipping for bounding volume hierarchies";
// thesis §2.2). Before the build, curves are cut at the midpoint of the longest side of their boxes, until no box is
// larger than a bound. The largest box is cut first, so that a bound on the number of references is useful too.
#pragma once

#include <algorithm>

#include "../parallel/task_group.hpp"
#include "cut.hpp"

namespace fastlines {

/// Which boxes are cut; by default none.
struct Presplit {
  /// Cut boxes larger than this, as a fraction of the surface area of the scene's box.
  double area = kInfinity;
  /// Stop cutting at this many references.
  std::size_t max_refs = std::size_t(-1);
};

/// One reference to each whole primitive.
template <Primitives P>
Buffer<BuildRef> whole_references(const P& prims, TaskGroup& tasks) {
  Buffer<BuildRef> refs;
  BuildRef* const data = refs.reset(prims.size());
  constexpr std::size_t per_task = 1 << 14;  // primitives
  tasks.for_ranges(0, prims.size(), per_task, [&prims, data](std::size_t first, std::size_t end) {
    for (std::size_t prim = first; prim < end; ++prim)
      data[prim] = {{std::uint32_t(prim)}, prims.bounds(std::uint32_t(prim))};
  });
  refs.set_size(prims.size());
  return refs;
}

/// The references that a build starts with: whole primitives, or the pieces of a presplit. Increments `n_refused` if
/// max_refs ends the presplit while a box is larger than the bound, unless the bound is 0.
template <Primitives P>
Buffer<BuildRef> first_references(const P& prims, const Presplit& presplit, TaskGroup& tasks, Progress& progress,
                                  std::size_t& n_refused) {
  Buffer<BuildRef> refs = whole_references(prims, tasks);
  if constexpr (Curves<P>) {
    if (presplit.area == kInfinity) return refs;
    const double bound = presplit.area * bounds_of_all(prims).area();

    // Keep a heap of the boxes above the bound: the largest area first, then the lowest index.
    using Entry = std::pair<double, std::uint32_t>;  // area, index
    const auto comes_later = [](const Entry& a, const Entry& b) {
      return a.first != b.first ? a.first < b.first : a.second > b.second;
    };
    std::vector<Entry> large;
    const auto push_if_large = [&](std::size_t i) {
      const double area = refs[i].box.area();
      if (area > bound) large.push_back({area, std::uint32_t(i)});
      return area > bound;
    };
    for (std::size_t i = 0; i < refs.size(); ++i) push_if_large(i);
    std::make_heap(large.begin(), large.end(), comes_later);
    // Cut the largest box in two.
    for (std::size_t n_done = 0; !large.empty(); ++n_done) {
      if (n_done % 1024 == 0) progress.check();
      if (refs.size() >= presplit.max_refs) {
        n_refused += bound > 0.0;
        break;
      }
      std::pop_heap(large.begin(), large.end(), comes_later);
      const std::size_t i = large.back().second;
      large.pop_back();
      const int axis = refs[i].box.longest_axis();
      const float plane = float(0.5 * (double(refs[i].box.lo[axis]) + double(refs[i].box.hi[axis])));
      if (side_of(refs[i].box, axis, plane) != Side::both) continue;  // too thin for floats to divide
      BuildRef rest = refs[i];
      cut(prims, axis, plane, refs[i], rest);
      const std::size_t n = refs.size();
      if (n == refs.capacity()) refs.grow(2 * n, n);
      refs[n] = rest;
      refs.set_size(n + 1);
      for (const std::size_t part : {i, refs.size() - 1})
        if (push_if_large(part)) std::push_heap(large.begin(), large.end(), comes_later);
    }
  }
  return refs;
}

}  // namespace fastlines
