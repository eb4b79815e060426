// Paths of light through a cloud of fibres, as an integrator of a renderer traces them: one ray at a time, from many
// threads, each ray depending on the hit before it.
//
//     g++ -std=c++20 -O2 examples/integrator.cpp $(python -m fastlines --cflags --libs) -o integrator && ./integrator
#include <cmath>
#include <cstdio>
#include <fastlines/fastlines.hpp>
#include <random>
#include <thread>

namespace {

using Random = std::mt19937;

float uniform(Random& random) { return float(random() >> 8) * 0x1p-24f; }

fl::Vec3 unit_vector(Random& random) {
  const float z = 2 * uniform(random) - 1, angle = 6.2831853f * uniform(random), side = std::sqrt(1 - z * z);
  return {side * std::cos(angle), side * std::sin(angle), z};
}

fl::Vec3 point_at(const fl::Ray& ray, float t) {
  const auto& [o, d] = std::pair(ray.origin, ray.direction);
  return {o.x + t * d.x, o.y + t * d.y, o.z + t * d.z};
}

/// The light that a path brings from a white sky: each fibre that scatters it absorbs a tenth.
float trace(const fl::Tree& tree, fl::Ray ray, Random& random) {
  constexpr float radius = 0.002f, albedo = 0.9f;
  float light = 1;
  for (int bounce = 0; bounce < 64; ++bounce) {
    const fl::Hit hit = tree.first_hit(ray, radius);
    if (!hit) return light;
    light *= albedo;
    // Start at a t_min at which the next ray has left this fibre, in most directions.
    ray = fl::Ray(point_at(ray, hit.t), unit_vector(random), 2 * radius);
  }
  return 0;
}

}  // namespace

int main() {
  Random random(1);
  std::vector<fl::Segment> fibres;
  for (int i = 0; i < 20'000; ++i) {
    const fl::Vec3 p{uniform(random), uniform(random), uniform(random)}, along = unit_vector(random);
    fibres.push_back({p, {p.x + 0.1f * along.x, p.y + 0.1f * along.y, p.z + 0.1f * along.z}});
  }
  const fl::Tree tree = fl::build(fibres);

  // Each thread has its own random numbers and its own sum.
  constexpr int n_threads = 8, n_paths = 4000;
  double sums[n_threads] = {};
  std::vector<std::thread> threads;
  for (int i = 0; i < n_threads; ++i)
    threads.emplace_back([&tree, i, &sum = sums[i]] {
      Random own(std::uint32_t(i + 2));
      for (int path = 0; path < n_paths; ++path) {
        const fl::Ray ray({uniform(own), uniform(own), -1}, {0, 0, 1});
        sum += trace(tree, ray, own);
      }
    });
  for (std::thread& thread : threads) thread.join();
  double sum = 0;
  for (const double of_thread : sums) sum += of_thread;
  std::printf("%d threads, %d paths each: the cloud lets %.3f of the light pass\n", n_threads, n_paths,
              sum / (n_threads * n_paths));
}
