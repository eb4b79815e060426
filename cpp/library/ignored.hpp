// What queries leave out.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "fastlines/api/tree.hpp"
#include "fastlines/query/proximity/seen.hpp"

namespace fl::detail {

/// What a query leaves out: lines, and lines of some strands.
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

  /// What one point sees. It refers to the numbers here.
  fastlines::Seen seen_by_one() const {
    return {.ignored = {{lines_.data(), lines_.size(), {}}, {strands_.data(), strands_.size(), strand_of_line_}}};
  }

  /// The same for each line: 1 if it is left out. It is empty if none is.
  std::vector<std::uint8_t> hidden(std::size_t n_lines) const {
    if (lines_.empty() && strands_.empty()) return {};
    std::vector<std::uint8_t> hidden(n_lines);
    for (std::size_t line = 0; line < n_lines; ++line) hidden[line] = drops(std::uint32_t(line));
    return hidden;
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

}  // namespace fl::detail
