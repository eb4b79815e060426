// What hits add to the sum of their ray, 16 at a time (gather_rule.hpp). All is float32, in the order in which it is
// written here, but for the directions and lengths of lines and the places in tables of optical depths. These are
// computed in float64 and rounded once.
#pragma once

#include <algorithm>
#include <cmath>

#include "../../simd/functions.hpp"
#include "gather_rule.hpp"

namespace fastlines {

/// The lines of 16 hits: unit directions, zero for those of length zero, and radii at both ends.
struct LineLanes {
  Vec3Lanes direction;
  FloatLanes length, radius0 = 0.0f, radius1 = 0.0f;

  LineLanes(const GatherLines& lines, const std::uint32_t (&row)[kLanes]) {
    double x[kLanes], y[kLanes], z[kLanes], lengths[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const float* const ends = lines.rows + row[i] * lines.n_numbers;
      x[i] = double(ends[3]) - double(ends[0]);
      y[i] = double(ends[4]) - double(ends[1]);
      z[i] = double(ends[5]) - double(ends[2]);
    }
    for (int i = 0; i < kLanes; ++i) lengths[i] = std::sqrt(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    float unit[3][kLanes], rounded[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const double inverse = lengths[i] > 0.0 ? 1.0 / lengths[i] : 0.0;
      unit[0][i] = float(x[i] * inverse);
      unit[1][i] = float(y[i] * inverse);
      unit[2][i] = float(z[i] * inverse);
      rounded[i] = float(lengths[i]);
    }
    direction = {FloatLanes::load(unit[0]), FloatLanes::load(unit[1]), FloatLanes::load(unit[2])};
    length = FloatLanes::load(rounded);
    if (lines.n_numbers < 8) return;
    float radii[2][kLanes];
    for (int i = 0; i < kLanes; ++i)
      for (int end = 0; end < 2; ++end) radii[end][i] = lines.rows[row[i] * lines.n_numbers + 6 + std::size_t(end)];
    radius0 = FloatLanes::load(radii[0]);
    radius1 = FloatLanes::load(radii[1]);
  }
};

/// The contributions of 16 hits of one ray.
class Contributions {
 public:
  /// The first n of 16 hits, from hit `first` on.
  Contributions(const GatherRule& rule, const GatherRay& ray, const GatherLines& lines, const GatherHits& hits,
                std::size_t first, int n)
      : rule_(rule), ray_(ray) {
    std::uint32_t row[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const std::size_t at = first + std::size_t(std::min(i, n - 1));
      row[i] = hits.line[at];
      prim_[i] = hits.prim[at];
    }
    t_ = load_lanes(hits.t + first, n);
    u_ = load_lanes(hits.u + first, n);
    const LineLanes line(lines, row);
    depth_ = t_ * ray.length;
    along_ = u_ * line.length;
    weight_ = 1.0f;
    counts_ = first_lanes(n);
    if (rule.inner)
      counts_ = counts_ & (t_ != ray.t_min) & (t_ != ray.t_max) &
                (((u_ > 0.0f) & (u_ < 1.0f)) | (line.length == FloatLanes(0.0f)));
    if (rule.blur != Blur::none) blur(line, load_lanes(hits.distance + first, n));
    if (rule.phase) weight_ *= phase_function(dot(Vec3Lanes::of(ray_.direction), line.direction));
    if (ray.depths) find_steps();
  }

  /// Which hits count: −1, else 0.
  const IntLanes& counts() const { return counts_; }

  /// What they add to a channel; 0 for those that do not count.
  FloatLanes operator[](int channel) const {
    // The weight may be large, so it comes last: a product that overflows and is then multiplied by 0 would be NaN.
    FloatLanes found = rule_.values.empty() ? FloatLanes(1.0f) : values(channel);
    if (absorbs(channel)) found = found * exp(-absorbed(channel));
    return select(counts_, found * weight_, FloatLanes(0.0f));
  }

 private:
  static IntLanes first_lanes(int n) {
    static constexpr std::int32_t numbers[kLanes] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
    return IntLanes::load(numbers) < IntLanes(n);
  }

  /// Weigh with K / sin θ.
  void blur(const LineLanes& line, const FloatLanes& distance) {
    const Vec3Lanes across = cross(Vec3Lanes::of(ray_.direction), line.direction);
    const FloatLanes sine = sqrt(dot(across, across));
    const FloatLanes own_radius = line.radius0 + u_ * (line.radius1 - line.radius0);
    const FloatLanes reach = own_radius + ray_.radius + ray_.spread * depth_;
    const FloatLanes width = reach * sine;
    counts_ = counts_ & (sine >= kLeastSine) & (width >= kLeastWidth);
    if (rule_.blur == Blur::box) {
      weight_ = 0.5f / width;
    } else {
      const FloatLanes ratio = distance / reach;
      weight_ = 0.75f * max(1.0f - ratio * ratio, 0.0f) / width;
    }
  }

  /// Henyey and Greenstein's function of light along the lines that leaves against the ray. The argument is the cosine
  /// between the ray and the lines.
  FloatLanes phase_function(const FloatLanes& cosine) const {
    const double g = *rule_.phase;
    const auto scale = float((1.0 - g * g) / (4.0 * 3.14159265358979323846));
    const auto least = float((1.0 - std::abs(g)) * (1.0 - std::abs(g)));
    const FloatLanes base = max(float(1.0 + g * g) + float(2.0 * g) * cosine, least);
    return scale / (base * sqrt(base));
  }

  FloatLanes values(int channel) const {
    float found[kLanes];
    const auto n = std::size_t(rule_.n_channels);
    for (int i = 0; i < kLanes; ++i) found[i] = rule_.values[prim_[i] * n + std::size_t(channel)];
    return FloatLanes::load(found);
  }

  bool absorbs(int channel) const {
    const auto c = std::size_t(channel);
    return rule_.sigma[c] != 0.0f || rule_.line_sigma[c] != 0.0f || ray_.depths;
  }

  /// The optical depth along the ray and along the line.
  FloatLanes absorbed(int channel) const {
    const auto c = std::size_t(channel);
    const FloatLanes on_ray = ray_.depths ? depth_in_table(channel) : rule_.sigma[c] * depth_;
    return on_ray + rule_.line_sigma[c] * along_;
  }

  /// Find the step of the table of optical depths before each hit, and how far it is from there to the next one.
  void find_steps() {
    // float32 overflows where t_min and t_max are far apart, and where they are nearly equal.
    const double t_min = ray_.t_min, length = double(ray_.t_max) - t_min, last = rule_.n_depths - 1;
    const double per_t = length > 0.0 ? last / length : 0.0;
    float beyond[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const double place = std::min(std::max(0.0, (double(t_[i]) - t_min) * per_t), last);  // 0 if it is NaN
      step_[i] = std::min(int(place), rule_.n_depths - 2);
      beyond[i] = float(place - step_[i]);
    }
    beyond_step_ = FloatLanes::load(beyond);
  }

  FloatLanes depth_in_table(int channel) const {
    const auto n = std::size_t(rule_.n_depth_channels);
    float before[kLanes], after[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const float* const at = ray_.depths + std::size_t(step_[i]) * n + (n > 1 ? channel : 0);
      before[i] = at[0];
      after[i] = at[n];
    }
    const FloatLanes low = FloatLanes::load(before);
    return low + beyond_step_ * (FloatLanes::load(after) - low);
  }

  const GatherRule& rule_;
  const GatherRay& ray_;
  std::uint32_t prim_[kLanes];
  FloatLanes t_, u_, depth_, along_, weight_;
  IntLanes counts_;
  // In the table of optical depths, if there is one.
  int step_[kLanes];
  FloatLanes beyond_step_;
};

}  // namespace fastlines
