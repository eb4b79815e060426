// Small scenes and rays for the tests. They are the same on every machine, because they are computed from integers by
// operations that round identically everywhere.
#pragma once

#include <string>
#include <vector>

#include "fastlines/core.hpp"
#include "random.hpp"

namespace fastlines::test {

using Lines = std::vector<Segment>;

struct Scene {
  std::string name;
  Lines lines;
};

inline Lines long_lines(int n) {
  Random random{1};
  Lines lines;
  while (int(lines.size()) < n) lines.push_back({random.in_cube(), random.in_cube()});
  return lines;
}

inline Lines hair(int n_strands) {
  Random random{2};
  Lines lines;
  for (int strand = 0; strand < n_strands; ++strand) {
    Vec3 at = random.in_cube(), along = random.direction() * 0.1f;
    for (int i = 0; i < 12; ++i) {
      const Vec3 next = at + along;
      lines.push_back({at, next});
      along = along + random.direction() * 0.04f;
      at = next;
    }
  }
  return lines;
}

inline Lines through_one_point(int n) {
  Random random{3};
  Lines lines;
  while (int(lines.size()) < n) {
    const Vec3 p = random.in_cube();
    lines.push_back({p, Vec3{1, 1, 1} - p});
  }
  return lines;
}

inline Lines points(int n) {
  Random random{4};
  Lines lines;
  while (int(lines.size()) < n) {
    const Vec3 p = random.in_cube();
    lines.push_back({p, lines.size() % 8 == 0 ? p + Vec3{0, 0, 0.1f} : p});
  }
  return lines;
}

/// A few lines repeated, some of them reversed.
inline Lines duplicates(int n) {
  const Lines few = long_lines(12);
  Lines lines;
  while (int(lines.size()) < n) {
    const Segment& line = few[lines.size() % few.size()];
    lines.push_back(lines.size() % 5 == 0 ? Segment{line.q, line.p} : line);
  }
  return lines;
}

/// Lines along x and y in the plane z = 0.5.
inline Lines grid(int n) {
  Lines lines;
  for (int i = 0; i < n; ++i) {
    const float at = float(i) / float(n - 1);
    lines.push_back({{at, 0, 0.5f}, {at, 1, 0.5f}});
    lines.push_back({{0, at, 0.5f}, {1, at, 0.5f}});
  }
  return lines;
}

inline Lines moved(Lines lines, float scale, float shift) {
  for (Segment& line : lines)
    for (Vec3* end : {&line.p, &line.q}) *end = *end * scale + Vec3{shift, shift, shift};
  return lines;
}

inline std::vector<Scene> scenes() {
  return {{"long lines", long_lines(120)},
          {"hair", hair(16)},
          {"through one point", through_one_point(80)},
          {"points", points(120)},
          {"duplicates", duplicates(60)},
          {"grid", grid(30)},
          {"many points", points(1500)},
          {"much hair", hair(150)},
          {"one line", long_lines(1)},
          {"tiny", moved(long_lines(60), 1e-6f, 0)},
          {"far away", moved(hair(8), 1, 1e4f)}};
}

/// A batch of rays that owns its data.
struct Rays {
  std::string name;
  std::vector<Vec3> origins, directions;
  std::vector<float> radius, t_min{0.0f}, t_max{kInfinity}, spread{0.0f};

  RayBatch batch() const { return {origins, directions, radius, t_min, t_max, spread}; }
};

/// The rays of a picture, row by row. `eye` is relative to the centre of the box; eye, width and radius are in units of
/// `size`.
inline Rays picture(const std::string& name, const Vec3& eye, float width, const Box& box, float size, float radius) {
  constexpr int kWidth = 19, kHeight = 9;  // not multiples of the size of a tile
  Rays rays{
      .name = name + ", radius " + std::to_string(radius), .origins = {}, .directions = {}, .radius = {radius * size}};
  const Vec3 centre = (box.lo + box.hi) * 0.5f, origin = centre + eye * size;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const Vec3 pixel{(float(x) - 9.0f) / 18.0f, (float(y) - 4.0f) / 18.0f, 0.01f};
      rays.origins.push_back(origin);
      rays.directions.push_back(centre + pixel * (width * size) - origin);
    }
  return rays;
}

/// Incoherent rays, each with its own radius, t_min and t_max: from outside, from inside, along an axis, and through an
/// end of each of two lines.
inline Rays scattered(const Lines& lines, const Box& box, float size) {
  Random random{5};
  Rays rays{.name = "scattered", .origins = {}, .directions = {}, .radius = {}, .t_min = {}, .t_max = {}};
  const Vec3 centre = (box.lo + box.hi) * 0.5f;
  for (int i = 0; i < 140; ++i) {
    Vec3 o = centre + random.direction() * size, d = random.direction() * size;
    const Segment &line = lines[random.below(lines.size())], &other = lines[random.below(lines.size())];
    if (i % 4 == 0) o = o - d * 5.0f;
    if (i % 4 == 2) {
      d = {0, 0, 0};
      d[i / 4 % 3] = i % 8 < 4 ? size : -size;
      o = line.p - d;
    }
    if (i % 4 == 3 && other.q != line.p) {
      d = other.q - line.p;
      o = line.p - d;
    }
    const float radii[] = {0.0f, 1e-4f, 0.003f, 0.02f, 0.1f, 2.0f};
    rays.origins.push_back(o);
    rays.directions.push_back(d);
    rays.radius.push_back(radii[random.below(6)] * size);
    rays.t_min.push_back(random.below(3) == 0 ? random.uniform() : 0.0f);
    rays.t_max.push_back(random.below(3) == 0 ? 1.0f + random.uniform() : 1e6f);
  }
  return rays;
}

}  // namespace fastlines::test
