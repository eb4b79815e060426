// The files that were accepted: their number, and some of them, which mutations start from.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <vector>

namespace fastlines::fuzz {

class Accepted {
 public:
  using File = std::vector<std::uint8_t>;

  ~Accepted() { std::fprintf(stderr, "accepted: %llu\n", static_cast<unsigned long long>(n_)); }

  /// Counts a file, and keeps it in the place of one that a number chooses.
  void add(std::span<const std::uint8_t> file, std::uint64_t number) {
    constexpr std::size_t most_kept = 256;
    ++n_;
    if (kept_.size() < most_kept) kept_.emplace_back();
    (n_ <= most_kept ? kept_.back() : kept_[number % most_kept]).assign(file.begin(), file.end());
  }

  std::uint64_t count() const { return n_; }
  const std::vector<File>& kept() const { return kept_; }

 private:
  std::uint64_t n_ = 0;
  std::vector<File> kept_;
};

inline Accepted accepted;

}  // namespace fastlines::fuzz
