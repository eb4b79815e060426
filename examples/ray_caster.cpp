// A picture of hair from batches of rays: how many hairs the ray of each pixel hits, as a grey image (PGM).
//
//     g++ -std=c++20 -O2 examples/ray_caster.cpp $(python -m fastlines --cflags --libs) -o ray_caster
//     ./ray_caster hair.pgm
#include <cmath>
#include <cstdio>
#include <fastlines/fastlines.hpp>
#include <random>

namespace {

/// Strands that hang from a hemisphere.
std::vector<fl::RoundCone> make_hair(int n_strands, int n_points) {
  std::mt19937 random(1);
  const auto uniform = [&] { return float(random()) * 0x1p-32f; };
  std::vector<fl::RoundCone> hair;
  for (int strand = 0; strand < n_strands; ++strand) {
    const float angle = 6.2831853f * uniform(), height = uniform(), side = std::sqrt(1 - height * height);
    fl::Vec3 at{side * std::cos(angle), height, side * std::sin(angle)}, along{at.x, at.y, at.z};
    for (int i = 0; i < n_points; ++i) {
      const fl::Vec3 next{at.x + 0.08f * along.x, at.y + 0.08f * along.y, at.z + 0.08f * along.z};
      const auto radius = [&](int point) { return 0.004f * (1 - float(point) / float(n_points)); };
      hair.push_back({at, next, radius(i), radius(i + 1)});
      along = {along.x + 0.2f * (uniform() - 0.5f), along.y - 0.15f, along.z + 0.2f * (uniform() - 0.5f)};
      at = next;
    }
  }
  return hair;
}

}  // namespace

int main(int n_args, char** args) {
  constexpr int size = 512;
  const fl::Tree tree = fl::build(make_hair(4000, 16));

  std::vector<fl::Vec3> origins(size * size, fl::Vec3{0, 0, 5}), directions;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) directions.push_back({float(x) / size - 0.5f, 0.5f - float(y) / size, -1});
  const std::vector<std::int64_t> counts = tree.count_hits(fl::Rays{origins, directions}, /*radius=*/0);

  std::FILE* const file = std::fopen(n_args > 1 ? args[1] : "hair.pgm", "wb");
  if (!file) return std::perror("the picture cannot be written"), 1;
  std::fprintf(file, "P5 %d %d 255\n", size, size);
  std::int64_t n_hits = 0;
  for (const std::int64_t count : counts) {
    std::fputc(int(255 * (1 - std::exp(-0.25 * double(count)))), file);
    n_hits += count;
  }
  std::fclose(file);
  std::printf("%zu lines, %d rays, %lld hits\n", tree.size(), size * size, static_cast<long long>(n_hits));
}
