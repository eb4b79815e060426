// The example of the thesis (§5.4.3): one segment and one ray; a BVH and a KD tree both report the hit.
//
//     g++ -std=c++20 examples/first_hit.cpp $(python -m fastlines --cflags --libs) -o first_hit && ./first_hit
#include <cstdio>
#include <fastlines/fastlines.hpp>

using namespace fl;

int main() {
  const float lines[] = {-1, -1, -1, 1, 1, 1};
  const Ray ray({0, 0, -5}, {0, 0, 1});
  const float d = 0.5f;
  Intersection hit;

  BVH bvh(BVH::CL);
  bvh.Build(lines, 1);
  const bool in_bvh = bvh.Intersect(ray, &hit, d);
  if (in_bvh) std::printf("BVH: segment %d at t = %g\n", hit.id, hit.t);

  KD kd(KD::CL);
  kd.Build(lines, 1);
  std::vector<Intersection> hits;
  const bool in_kd = kd.IntersectAll(ray, &hits, d);
  for (const Intersection& each : hits) std::printf("KD tree: segment %d at t = %g\n", each.id, each.t);

  return in_bvh && in_kd ? 0 : 1;
}
