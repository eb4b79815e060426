// The example of the thesis (§5.4.3): one segment and one ray; a BVH and a KD tree both report the hit.
//
//     g++ -std=c++20 -O2 -ffp-contract=off -I cpp examples/first_hit.cpp -o first_hit && ./first_hit
#include <cstdio>

#include "fastlines/fastlines.hpp"

using namespace fastlines;

int main() {
  const Segment segment{{-1, -1, -1}, {1, 1, 1}};
  const Segments segments{{&segment, 1}};
  const RayQuery query{{0, 0, -5}, {0, 0, 1}, /*t_min=*/0, /*t_max=*/1e30f, /*radius=*/0.5f};

  Settings bvh;
  Settings kd;
  kd.boxes = BoxRule::cut;
  kd.splits = {{PlaneEvents{}}};
  kd.cost.c_trav = 0.6;

  bool all_hit = true;
  for (const Settings& settings : {bvh, kd}) {
    Progress progress;
    const Tree tree = Builder(segments, settings, progress).build();

    const BinaryTraversal search{tree.nodes, tree.refs, segments, frame_of(tree.nodes[0].box)};
    const Ray ray = prepare(query, search.frame);
    FirstSink sink(At::closest, ray);
    decltype(search)::Scratch scratch;
    search(ray, sink, scratch);

    std::printf("%s: segment %d at t = %g\n", settings.boxes == BoxRule::cut ? "KD tree" : "BVH", int(sink.best.prim),
                sink.best.t);
    all_hit &= sink.best.prim == 0;
  }
  return all_hit ? 0 : 1;
}
