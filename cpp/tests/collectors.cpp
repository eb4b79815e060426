// Collectors get the same hits in any order: 16 rays at a time, one by one, or of one ray alone. They keep what sorting
// all hits by (t in units of the caller's ray, prim) gives.
#include <algorithm>
#include <memory>
#include <tuple>
#include <vector>

#include "check.hpp"
#include "fastlines/kernels/collect/all_hits.hpp"
#include "fastlines/kernels/collect/any_hit.hpp"
#include "fastlines/kernels/collect/count_hits.hpp"
#include "fastlines/kernels/collect/first_hit.hpp"
#include "fastlines/kernels/collect/k_nearest.hpp"
#include "fastlines/query/hit_vector.hpp"
#include "random.hpp"

using namespace fastlines;
using test::check, test::Random;

namespace {

/// What a kernel passes to a collector: a segment, and the closest approaches of 16 rays to it.
struct PacketHits {
  int first;
  std::uint32_t hit, prim;
  alignas(64) float t[kSimdWidth], s[kSimdWidth], dist2[kSimdWidth];

  ClosestApproach<FloatX16> approach() const {
    const FloatX16 zero = 0.0f, is_hit = blend(hit, 1.0f, zero);
    return {FloatX16::load(s), FloatX16::load(t), FloatX16::load(dist2), zero < is_hit};
  }
};

struct Hit {
  float t_ray, t;
  std::uint32_t prim;
  bool operator<(const Hit& other) const { return t_ray != other.t_ray ? t_ray < other.t_ray : prim < other.prim; }
  bool operator==(const Hit& other) const { return t_ray == other.t_ray && t == other.t && prim == other.prim; }
};

std::uint32_t bits_of(float x) { return std::bit_cast<std::uint32_t>(x); }

struct Scene {
  std::vector<Vec3> origins, directions;
  float radius = 0.1f, t_min = 0.0f, t_max = 10.0f;
  std::unique_ptr<RayGroup> rays = std::make_unique<RayGroup>();
  Frame frame = frame_of(Box{{-1, -1, -1}, {1, 1, 1}});
  std::vector<PacketHits> packets;
  std::vector<Hit> hits[kGroupSize];  // the expected hits of each ray, sorted

  Scene(Random& random, int n_segments) {
    std::uint32_t ids[kGroupSize];
    for (int i = 0; i < kGroupSize; ++i) {
      origins.push_back(random.direction() - Vec3{0, 0, 3});  // far enough that all hits lie after t_min
      directions.push_back({0.0f, 0.0f, 1.0f + random.uniform()});
      ids[i] = std::uint32_t(i);
    }
    rays->fill({origins, directions, {&radius, 1}, {&t_min, 1}, {&t_max, 1}}, frame, kGroupSize, ids);
    // Few values of t, so that many hits tie. Some differ by one ulp, which is lost in units of the caller's ray.
    const std::size_t n_steps = 1 + random.below(40);
    for (int prim = 0; prim < n_segments; ++prim)
      for (int first = 0; first < kGroupSize; first += kSimdWidth) {
        PacketHits packet{first, std::uint32_t(random() & random() & 0xffff), std::uint32_t(prim), {}, {}, {}};
        for (int i = 0; i < kSimdWidth; ++i) {
          packet.t[i] = 0.1f + 0.01f * float(random.below(n_steps));
          if (random.below(4) == 0) packet.t[i] = std::nextafter(packet.t[i], 1.0f);
          packet.s[i] = random.uniform();
          packet.dist2[i] = random.uniform(0.0f, 0.01f);
          if (packet.hit >> i & 1)
            hits[first + i].push_back({rays->t_ray(first + i, packet.t[i]), packet.t[i], packet.prim});
        }
        if (packet.hit) packets.push_back(packet);
      }
    for (std::size_t i = packets.size(); i > 1; --i) std::swap(packets[i - 1], packets[random.below(i)]);
    for (auto& of_ray : hits) std::sort(of_ray.begin(), of_ray.end());
  }

  template <class Collector>
  void add_packets(Collector& collector) const {
    collector.begin(*rays, 0, kGroupSize);
    for (const PacketHits& packet : packets)
      collector.add_packet(*rays, packet.first, packet.hit, packet.approach(), packet.prim);
  }

  /// Adds the same hits, one at a time.
  template <class Collector>
  void add_each(Collector& collector) const {
    collector.begin(*rays, 0, kGroupSize);
    for (const PacketHits& packet : packets)
      for (int i = 0; i < kSimdWidth; ++i)
        if (packet.hit >> i & 1)
          collector.add_hit(*rays, packet.first + i, {packet.s[i], packet.t[i], packet.dist2[i], true},
                            Reference{packet.prim});
  }

  /// The ray in a lane.
  Ray ray(int lane) const {
    return prepare({origins[std::size_t(lane)], directions[std::size_t(lane)], t_min, t_max, radius}, frame);
  }

  /// Adds the hits of one ray to a collector of one.
  template <RayCollector C>
  void add_to(C& collector, int lane) const {
    for (const PacketHits& packet : packets)
      if (const int i = lane - packet.first; i >= 0 && i < kSimdWidth && (packet.hit >> i & 1))
        collector.add({packet.s[i], packet.t[i], packet.dist2[i], true}, Reference{packet.prim});
  }
};

template <class Collect>
void check_first(const Scene& scene, Collect collect) {
  const auto collector = std::make_unique<FirstHitCollector<FixedAt<At::closest>>>();
  collect(*collector);
  collector->tighten_limits(*scene.rays, 0, kGroupSize);
  for (int i = 0; i < kGroupSize; ++i) {
    const bool found = bits_of(collector->prim[i]) != kNoPrim;
    check(found != scene.hits[i].empty(), "a first hit where there is a hit");
    if (!found || scene.hits[i].empty()) continue;
    const Hit& first = scene.hits[i].front();
    check(collector->t[i] == first.t && bits_of(collector->prim[i]) == first.prim, "the first hit");
    check(collector->limit[i] >= first.t && collector->limit[i] <= first.t + 2 * scene.rays->tie_tolerance[i],
          "the limit is behind the first hit, and not far");
  }
}

template <class Collect>
void check_k_nearest(const Scene& scene, std::size_t k, Collect collect) {
  KNearestCollector<FixedAt<At::closest>> collector(k);
  collect(collector);
  for (int i = 0; i < kGroupSize; ++i) {
    const KNearest& nearest = collector.hits[i];
    std::vector<Hit> got;
    for (std::uint32_t j = 0; j < nearest.n; ++j) got.push_back({nearest.t_ray[j], nearest.t[j], nearest.prim[j]});
    std::sort(got.begin(), got.end());
    std::vector<Hit> expected = scene.hits[i];
    expected.resize(std::min(k, expected.size()));
    check(got == expected, "the k nearest hits");
  }
}

void check_all(const Scene& scene) {
  const auto any = std::make_unique<AnyHitCollector<FixedAt<At::closest>>>();
  const auto count = std::make_unique<CountHitsCollector>();
  const auto all = std::make_unique<AllHitsCollector>(At::closest);
  scene.add_packets(*any);
  scene.add_packets(*count);
  scene.add_packets(*all);
  std::vector<Hit> got[kGroupSize];
  for (int i = 0; i < kGroupSize; i += kSimdWidth) {
    const auto& of = all->hits[i / kSimdWidth];
    for (std::size_t j = 0; j < of.n; ++j) {
      const int ray = i + int(of.lane[j]);
      got[ray].push_back({scene.rays->t_ray(ray, of.t[j]), of.t[j], of.prim[j]});
    }
  }
  for (int i = 0; i < kGroupSize; ++i) {
    std::sort(got[i].begin(), got[i].end());
    check(got[i] == scene.hits[i], "all hits, each once");
    check(count->n_hits[i] == std::int64_t(scene.hits[i].size()), "the number of hits");
    check(any->found[i] == !scene.hits[i].empty(), "whether there is a hit");
    check(!any->found[i] || any->limit[i] == kNoMoreHits, "a ray that has a hit needs no more");
  }
}

void check_list(const Scene& scene, int lane, Keep keep, std::size_t k) {
  const Ray ray = scene.ray(lane);
  std::vector<fastlines::Hit> expected, got;
  for (const PacketHits& packet : scene.packets)
    if (const int i = lane - packet.first; i >= 0 && i < kSimdWidth && (packet.hit >> i & 1))
      expected.push_back({ray.t_ray(packet.t[i]), packet.prim, packet.s[i], ray.distance(packet.dist2[i])});
  std::sort(expected.begin(), expected.end(), [&](const fastlines::Hit& a, const fastlines::Hit& b) {
    return std::tuple(keep == Keep::nearest ? a.distance : 0.0f, a.t, a.prim) <
           std::tuple(keep == Keep::nearest ? b.distance : 0.0f, b.t, b.prim);
  });
  expected.resize(std::min(k, expected.size()));
  const auto check_with = [&](auto&& list, const char* what) {
    scene.add_to(list, lane);
    list.finish();
    bool equal = got.size() == expected.size() && list.size() == got.size();
    for (std::size_t i = 0; equal && i < got.size(); ++i)
      equal = got[i].t == expected[i].t && got[i].prim == expected[i].prim && got[i].u == expected[i].u &&
              got[i].distance == expected[i].distance;
    check(equal, what);
    got.clear();
  };
  check_with(HitVectorOfRay<fastlines::Hit>(ray, At::closest, keep, got, k), "the list of a ray");
  using InPlace = HitListOfRay<ChosenList, HitVector<fastlines::Hit>>;
  check_with(InPlace(ray, {{At::closest}, keep}, {got}, k), "the list of a ray, sorted in place");
}

/// The collectors of one ray.
void check_one_ray(const Scene& scene, int lane) {
  const Ray ray = scene.ray(lane);
  const std::vector<Hit>& hits = scene.hits[lane];
  FirstHitOfRay<ChosenAt> first(ray, {At::closest});
  AnyHitOfRay any(ray);
  HitCountOfRay count(ray), two(ray, 2), none(ray, 0);
  scene.add_to(first, lane);
  scene.add_to(any, lane);
  for (HitCountOfRay<>* each : {&count, &two, &none}) scene.add_to(*each, lane);
  check(first.found() == !hits.empty(), "a ray has a first hit if it has a hit");
  if (first.found()) check(first.hit().t == hits[0].t_ray && first.prim == hits[0].prim, "the first hit of a ray");
  check(any.found == !hits.empty(), "whether a ray has a hit");
  check(count.n == hits.size() && two.n == std::min<std::size_t>(2, hits.size()) && none.n == 0, "the hits of a ray");
  check((two.limit == kNoMoreHits) == (hits.size() >= 2), "a ray that is counted up to 2 needs no more hits");
  check_list(scene, lane, Keep::all, ~std::size_t(0));
  for (const std::size_t k : {0, 1, 3, 20}) {
    check_list(scene, lane, Keep::first, k);
    check_list(scene, lane, Keep::nearest, k);
  }
}

}  // namespace

int main() {
  return test::run([] {
    Random random{1};
    for (int round = 0; round < 150; ++round) {
      const Scene scene(random, int(random.below(round % 5 == 0 ? 300 : 30)));
      const auto by_packets = [&](auto& collector) { scene.add_packets(collector); };
      const auto one_by_one = [&](auto& collector) { scene.add_each(collector); };
      check_first(scene, by_packets);
      check_first(scene, one_by_one);
      for (const std::size_t k : {0, 1, 3, 16, 20}) {
        check_k_nearest(scene, k, by_packets);
        check_k_nearest(scene, k, one_by_one);
      }
      check_all(scene);
      for (int lane = 0; lane < kGroupSize; lane += 7) check_one_ray(scene, lane);
    }
  });
}
