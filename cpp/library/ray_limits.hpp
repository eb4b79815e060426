// Checks of rays, and what is wrong with those that are not valid.
#pragma once

#include <cmath>
#include <string>

#include "fastlines/api/tree.hpp"
#include "fastlines/rays/ray_check.hpp"

namespace fl::detail {

/// What rays may be, for the box of a scene.
struct RayLimits {
  float max_radius;  ///< beyond it, squares would overflow
  float farthest;    ///< the largest coordinate of the scene
  double size;       ///< the longest side of the scene and its largest coordinate together

  /// For the box of the lines' axes. Throws InputError if the largest radius of the lines is too large for it.
  RayLimits(const fastlines::Box& box, float radius_of_lines) {
    constexpr float sizes = 1e12f, largest = std::numeric_limits<float>::max();
    double side = 0.0, far = 0.0;
    if (!box.is_empty())
      for (int k = 0; k < 3; ++k) {
        side = std::max(side, double(box.hi[k]) - box.lo[k]);
        far = std::max({far, std::fabs(double(box.lo[k])), std::fabs(double(box.hi[k]))});
      }
    max_radius = float(std::min(double(sizes) * (side > 0.0 ? side : 1.0), double(largest)));
    farthest = float(far);
    size = side + far;
    if (radius_of_lines > max_radius)
      throw InputError("the largest radius of the lines, " + std::to_string(radius_of_lines) + ", is more than 1e12 " +
                       "times the size of their axes together; leave such lines out");
  }

  /// Whether a ray is certainly valid: a quick check, which most rays pass.
  bool surely_allow(const fastlines::RayQuery& ray) const {
    constexpr float large = 1e30f, small = 1e-7f;
    const auto &o = ray.origin, &d = ray.direction;
    const auto largest = [](const fastlines::Vec3& v) {
      return fastlines::max(fastlines::max(std::fabs(v[0]), std::fabs(v[1])), std::fabs(v[2]));
    };
    // A sum with NaN or infinity is neither small nor large.
    const float sum = std::fabs(o[0]) + std::fabs(o[1]) + std::fabs(o[2]) + std::fabs(d[0]) + std::fabs(d[1]) +
                      std::fabs(d[2]) + farthest;
    return (sum <= large) & (largest(d) >= small) & (ray.radius >= 0.0f) & (ray.radius <= max_radius) &
           (ray.radius <= large) & (ray.t_min <= ray.t_max) & (ray.t_min <= large);
  }

  /// Whether a ray is valid, as in a batch of one.
  bool allow(const fastlines::RayQuery& ray) const {
    const fastlines::RayBatch batch{{&ray.origin, 1}, {&ray.direction, 1}, {&ray.radius, 1},
                                    {&ray.t_min, 1},  {&ray.t_max, 1},     {&ray.spread, 1}};
    return fastlines::check_rays(batch, max_radius, farthest, 1).valid;
  }

  /// What is wrong with a ray; empty if nothing is.
  std::string fault(const fastlines::RayQuery& ray) const {
    const auto is_finite = [](const fastlines::Vec3& v) {
      return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
    };
    if (allow(ray)) return {};
    if (!is_finite(ray.origin)) return "an origin that is not finite";
    if (!is_finite(ray.direction)) return "a direction that is not finite";
    if (ray.direction == fastlines::Vec3{0, 0, 0}) return "a direction of length zero";
    if (!(ray.radius >= 0.0f && ray.radius <= max_radius))
      return "a radius of " + std::to_string(ray.radius) + ", which is not a number from 0 to " +
             std::to_string(max_radius);
    if (!(ray.t_min <= ray.t_max) || std::isinf(ray.t_min))
      return "bounds that are not numbers with t_min <= t_max, t_min below infinity";
    if (!(ray.spread >= 0.0f && ray.spread <= fastlines::kMaxSpread))
      return "a spread of " + std::to_string(ray.spread) + ", which is not a number from 0 to 1e12";
    if (const fastlines::RayQuery narrow{ray.origin, ray.direction, ray.t_min, ray.t_max, ray.radius}; allow(narrow))
      return "a spread of " + std::to_string(ray.spread) + ", with which its radius grows beyond " +
             std::to_string(max_radius) + " in the scene";
    return "a direction so short that t in the scene is more than float can hold";
  }

  /// Throws InputError for a ray that is not valid.
  void check(const fastlines::RayQuery& ray) const {
    if (!surely_allow(ray)) [[unlikely]]
      check_exactly(ray);
  }

  [[gnu::noinline]] void check_exactly(const fastlines::RayQuery& ray) const {
    if (!allow(ray)) throw InputError("the ray has " + fault(ray));
  }

  /// Throws InputError for the first ray of a batch that is not valid.
  void check(const fastlines::RayBatch& rays, unsigned n_threads) const {
    const std::size_t n = rays.size();
    if (rays.directions.size() != n)
      throw InputError(std::to_string(n) + " origins and " + std::to_string(rays.directions.size()) +
                       " directions; expected as many");
    const auto is_null = [](const auto& values) { return !values.data() && !values.empty(); };
    if (is_null(rays.origins) || is_null(rays.directions))
      throw InputError("the origins or the directions of the rays are null; expected pointers to " + std::to_string(n) +
                       " vectors each");
    if (n > 0xffff'ffff) throw InputError("more than 2^32 − 1 rays; trace them in several calls");
    const auto fits = [n, is_null](std::span<const float> values, const char* name) {
      if (is_null(values)) throw InputError(std::string(name) + " is null; expected a pointer to its numbers");
      if (values.size() != 1 && values.size() != n)
        throw InputError(std::string(name) + " has " + std::to_string(values.size()) +
                         " numbers; expected one, or one for each of " + std::to_string(n) + " rays");
    };
    fits(rays.radius, "radius");
    fits(rays.t_min, "t_min");
    fits(rays.t_max, "t_max");
    fits(rays.spread, "spread");
    // The check of all rays together may reject valid ones.
    if (fastlines::check_rays(rays, max_radius, farthest, n_threads).valid) return;
    for (std::size_t i = 0; i < n; ++i)
      if (const std::string what = fault(rays[i]); !what.empty())
        throw InputError("ray " + std::to_string(i) + " has " + what);
  }
};

}  // namespace fl::detail
