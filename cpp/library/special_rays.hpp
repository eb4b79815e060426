// Rays with a spread, and rays that leave out some lines. They are traced one at a time: the collectors of one ray get
// what the traversal of the layout reports, without what is left out.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "fastlines/api/tree.hpp"
#include "fastlines/kernels/run/traverse.hpp"
#include "fastlines/query/for_each_ray.hpp"

namespace fl::detail {

/// What rays leave out: lines, and lines of some strands.
class Ignored {
 public:
  /// Throws InputError for a number that names nothing; −1 is none.
  Ignored(std::span<const std::int64_t> lines, std::span<const std::int64_t> strands, std::size_t n_lines,
          std::span<const std::int64_t> strand_of_line)
      : lines_(checked(lines, n_lines, "ignore", "lines")), strand_of_line_(strand_of_line) {
    if (strands.empty()) return;
    const auto largest = std::ranges::max_element(strand_of_line);
    const std::size_t n_strands =
        largest == strand_of_line.end() ? 0 : std::size_t(std::max<std::int64_t>(*largest, -1) + 1);
    strands_ = checked(strands, n_strands, "ignore_strands", "strands");
  }

  bool drops(std::uint32_t line) const {
    return std::ranges::binary_search(lines_, std::int64_t(line)) ||
           (!strands_.empty() && std::ranges::binary_search(strands_, strand_of_line_[line]));
  }

 private:
  /// The numbers in order, without those that are none.
  static std::vector<std::int64_t> checked(std::span<const std::int64_t> given, std::size_t n, const char* name,
                                           const char* what) {
    if (!given.data() && !given.empty())
      throw InputError(std::string(name) + " is null; expected a pointer to its numbers");
    std::vector<std::int64_t> numbers;
    for (const std::int64_t number : given) {
      if (number < -1 || number >= std::int64_t(n))
        throw InputError(std::string(name) + " names " + std::to_string(number) + "; there are " + std::to_string(n) +
                         " " + what + ", which count from 0, and -1 is none");
      if (number >= 0) numbers.push_back(number);
    }
    std::ranges::sort(numbers);
    return numbers;
  }

  std::vector<std::int64_t> lines_, strands_;
  std::span<const std::int64_t> strand_of_line_;
};

/// A search of the layout for one ray, as `for_each_ray` takes it. Reports what is not left out.
template <fastlines::AxisPrimitive P>
struct LayoutSearch {
  const fastlines::WideBvhView<P>& tree;
  const P& prims;
  const Ignored& ignored;
  const fastlines::Frame& frame = tree.frame;
  struct Scratch {
    fastlines::Checkpoint* checkpoint = nullptr;
  };

  void operator()(const fastlines::RayOf<P>& ray, fastlines::RayCollectorRef& to, Scratch& scratch) const {
    Kept kept{to.at, to.limit, to, ignored};
    fastlines::traverse(tree, ray, kept, scratch.checkpoint);
  }

 private:
  /// Passes on the hits that are kept.
  struct Kept {
    static constexpr bool kShrinksLimit = true, kDropsFarther = false;
    const fastlines::At at;
    const float& limit;
    const fastlines::RayCollectorRef& to;
    const Ignored& ignored;

    void add(const fastlines::ClosestApproach<float>& approach, const fastlines::Reference& ref) const {
      if (!ignored.drops(ref.prim)) to.add(approach, ref);
    }
  };
};

}  // namespace fl::detail
