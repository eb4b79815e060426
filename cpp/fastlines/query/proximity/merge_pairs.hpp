// Merges sorted lists of pairs, as the parts of a whole have them: a pair is in one list alone.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "pair_list.hpp"

namespace fastlines {

/// A list of pairs, sorted by (i, j).
struct PairRun {
  std::span<const std::int64_t> i, j;
  std::span<const float> s, t, distance;
  std::size_t size() const { return i.size(); }
};

/// Merges lists in sections of the first primitives, which threads take.
class PairMerge {
 public:
  explicit PairMerge(std::span<const PairRun> runs) : runs_(runs) {
    for (const PairRun& run : runs) n_pairs_ += run.size();
    find_bounds();
  }

  PairColumns merged(unsigned n_threads, Progress& progress) const {
    PairColumns to;
    to.resize(n_pairs_);
    // Find where each section begins in the answer.
    std::vector<std::size_t> begins(bounds_.size() + 2);
    for (std::size_t section = 0; section <= bounds_.size(); ++section) {
      begins[section + 1] = begins[section];
      for (const PairRun& run : runs_) begins[section + 1] += end_of(run, section) - begin_of(run, section);
    }
    parallel_for(
        bounds_.size() + 1, n_threads, progress, [] { return std::vector<Head>(); },
        [&](std::vector<Head>& heads, std::size_t section) { merge(section, begins[section], heads, to); });
    return to;
  }

 private:
  static constexpr std::size_t kFewestPairs = 1 << 12, kMostSections = 1 << 10, kSamples = 16;  // of a section

  /// The next pair of a run in a section.
  struct Head {
    std::int64_t i, j;
    const PairRun* run;
    std::size_t at, end;
    /// The heap of the standard library has the greatest on top.
    bool operator<(const Head& other) const { return i != other.i ? other.i < i : other.j < j; }
  };

  /// Divide the first primitives into sections of about as many pairs, by a sample.
  void find_bounds() {
    const std::size_t n_sections = std::min(n_pairs_ / kFewestPairs, kMostSections);
    if (n_sections < 2) return;
    std::vector<std::int64_t> sample;
    const std::size_t step = n_pairs_ / (n_sections * kSamples) + 1;
    for (const PairRun& run : runs_)
      for (std::size_t at = step / 2; at < run.size(); at += step) sample.push_back(run.i[at]);
    std::sort(sample.begin(), sample.end());
    for (std::size_t at = kSamples; at < sample.size(); at += kSamples)
      if (bounds_.empty() || bounds_.back() != sample[at]) bounds_.push_back(sample[at]);
  }

  std::size_t begin_of(const PairRun& run, std::size_t section) const {
    return section == 0 ? 0 : end_of(run, section - 1);
  }
  std::size_t end_of(const PairRun& run, std::size_t section) const {
    if (section == bounds_.size()) return run.size();
    return std::size_t(std::lower_bound(run.i.begin(), run.i.end(), bounds_[section]) - run.i.begin());
  }

  void merge(std::size_t section, std::size_t to_at, std::vector<Head>& heads, PairColumns& to) const {
    heads.clear();
    for (const PairRun& run : runs_) {
      const std::size_t at = begin_of(run, section), end = end_of(run, section);
      if (at < end) heads.push_back({run.i[at], run.j[at], &run, at, end});
    }
    std::make_heap(heads.begin(), heads.end());
    for (; !heads.empty(); ++to_at) {
      std::pop_heap(heads.begin(), heads.end());
      Head& head = heads.back();
      const PairRun& run = *head.run;
      to.i[to_at] = head.i;
      to.j[to_at] = head.j;
      to.s[to_at] = run.s[head.at];
      to.t[to_at] = run.t[head.at];
      to.distance[to_at] = run.distance[head.at];
      if (++head.at == head.end) {
        heads.pop_back();
      } else {
        head.i = run.i[head.at];
        head.j = run.j[head.at];
        std::push_heap(heads.begin(), heads.end());
      }
    }
  }

  std::span<const PairRun> runs_;
  std::size_t n_pairs_ = 0;
  std::vector<std::int64_t> bounds_;  // the first primitive of each section but the first
};

}  // namespace fastlines
