// What the points of a query see: all primitives, but those that are hidden from all points, or left out for one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace fastlines {

/// Rows of primitives that a query leaves out, and the owners of the others. All spans may be empty.
struct Seen {
  /// Numbers that each point leaves out, n of them, where a row has the number of_row[row], or its own.
  struct Ignored {
    const std::int64_t* numbers = nullptr;
    std::size_t n = 0;
    std::span<const std::int64_t> of_row = {};

    bool contains(std::size_t point, std::uint32_t row) const {
      const std::int64_t number = of_row.empty() ? row : of_row[row];
      for (std::size_t i = 0; i < n; ++i)
        if (numbers[point * n + i] == number) return number >= 0;
      return false;
    }
  };

  std::span<const std::uint8_t> hidden = {};  ///< 1 for each row that no point sees
  std::span<const std::int64_t> owner = {};   ///< the primitive of each row, rising; without it each row is one
  Ignored ignored[2] = {};

  bool sees(std::size_t point, std::uint32_t row) const {
    if (!hidden.empty() && hidden[row]) return false;
    for (const Ignored& each : ignored)
      if (each.n > 0 && each.contains(point, row)) return false;
    return true;
  }

  /// Whether all points see all rows.
  bool sees_all() const { return hidden.empty() && ignored[0].n == 0 && ignored[1].n == 0; }

  bool has_owners() const { return !owner.empty(); }
  std::int64_t owner_of(std::uint32_t row) const { return owner.empty() ? row : owner[row]; }
};

}  // namespace fastlines
