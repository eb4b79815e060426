// Fuzzes the reader of the library. Whatever a file holds, it is refused with a reason, or its tree answers as brute
// force over the same lines does, one ray or point at a time and in batches. Saving the tree again gives a file that
// is read as the same tree, and lines that are refitted to their own places give the same answers.
#include "library/tree_file.hpp"

#include <algorithm>
#include <cstring>
#include <optional>

#include "accepted.hpp"
#include "brute_answers.hpp"
#include "expect.hpp"
#include "fastlines/query/proximity/all_pairs.hpp"
#include "probes.hpp"

namespace fastlines::fuzz {
namespace {

using fl::detail::Bytes;
using fl::detail::TreeImpl;
using fl::detail::TreePointer;

/// How many queries a file is given.
constexpr std::size_t kRays = 8, kPoints = 3;

fl::Vec3 vector_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// A tree of a file, and brute force over its lines.
template <AxisPrimitive P>
class Compared {
 public:
  Compared(const TreeImpl& tree, std::span<const typename P::Item> items, const Box& frame_box, std::uint64_t seed)
      : tree_(tree), prims_(items), brute_(prims_, frame_box), probes_(seed, edges_of(items), frame_box) {}

  void compare() {
    compare_rays();
    for (std::size_t i = 0; i < kPoints; ++i) compare_point();
    if (probes_.below(4) == 0) compare_pairs();
    if (probes_.below(8) == 0) compare_refit();
  }

 private:
  static std::vector<Segment> edges_of(std::span<const typename P::Item> items) {
    std::vector<Segment> edges;
    for (const auto& item : items) add_edges(item, edges);
    return edges;
  }

  void compare_rays() {
    const auto at = At(probes_.below(3));
    std::vector<RayQuery> queries;
    std::vector<std::vector<fl::Hit>> expected;
    for (std::size_t i = 0; i < kRays; ++i) {
      const RayQuery query = probes_.ray();
      std::vector<fl::Hit> hits;
      if (!compare_ray(query, at, hits)) continue;
      queries.push_back(query);
      expected.push_back(std::move(hits));
    }
    if (!queries.empty()) compare_batch(queries, at, expected);
  }

  static fl::Ray ray_of(const RayQuery& query) {
    return {vector_of(query.origin), vector_of(query.direction), query.t_min, query.t_max};
  }

  /// Compares the answers to one ray. Returns whether it is valid.
  bool compare_ray(const RayQuery& query, At core_at, std::vector<fl::Hit>& expected) const {
    const fl::Ray ray = ray_of(query);
    const auto at = fl::At(int(core_at));
    std::vector<fl::Hit> found;
    try {
      tree_.all_hits(ray, query.radius, at, found);
    } catch (const fl::InputError&) {
      return false;
    }
    brute_.all_hits(query, core_at, expected);
    expect(same_hits(found, expected), "all hits of a ray", query);
    expect(same_hit(tree_.first_hit(ray, query.radius, at), expected.empty() ? fl::Hit() : expected[0]),
           "the first hit of a ray", query);
    expect(tree_.count_hits(ray, query.radius, at) == expected.size(), "the number of hits of a ray", query);
    expect(tree_.any_hit(ray, query.radius, at) == !expected.empty(), "whether a ray hits anything", query);
    return true;
  }

  void compare_batch(const std::vector<RayQuery>& queries, At core_at,
                     const std::vector<std::vector<fl::Hit>>& expected) {
    std::vector<fl::Vec3> origins, directions;
    std::vector<float> radius, t_min, t_max;
    for (const RayQuery& query : queries) {
      origins.push_back(vector_of(query.origin));
      directions.push_back(vector_of(query.direction));
      radius.push_back(query.radius);
      t_min.push_back(query.t_min);
      t_max.push_back(query.t_max);
    }
    const fl::Rays rays{origins, directions, std::span<const float>(t_min), std::span<const float>(t_max)};
    const fl::QueryOptions options{.at = fl::At(int(core_at)),
                                   .kernel = fl::QueryOptions::Kernel(probes_.below(4)),
                                   .n_threads = 1,
                                   .progress = {}};
    const std::span<const float> radii = radius;
    const fl::Hits first = tree_.first_hits(rays, radii, options);
    const fl::HitLists all = *tree_.list_hits(rays, radii, {}, options, ~std::size_t(0));
    for (std::size_t i = 0; i < queries.size(); ++i) {
      expect(same_hit(first[i], expected[i].empty() ? fl::Hit() : expected[i][0]), "a first hit of a batch",
             queries[i]);
      expect(same_hits(all[i], expected[i]), "all hits of a batch", queries[i]);
    }
  }

  void compare_point() {
    const auto [x, y, z] = tree_.origin().offset;
    const Vec3 near = probes_.point();
    const fl::Point point(fl::Vec3d{near[0] + x, near[1] + y, near[2] + z});
    const double less_offset[] = {point.position.x - x, point.position.y - y, point.position.z - z};
    const auto to = probes_.below(2) ? fl::To::surface : fl::To::axis;
    const bool surface = to == fl::To::surface && max_radius_of(prims_) > 0;
    const float radius = probes_.radius();
    std::vector<fl::NearLine> found;
    fl::NearLine nearest;
    try {
      tree_.near_queries().within(point, radius, to, found);
      nearest = tree_.near_queries().nearest(point, fl::infinity, to);
    } catch (const fl::InputError&) {
      return;
    }
    std::vector<Neighbour> expected;
    brute_.within(less_offset, radius, surface, expected);
    bool equal = found.size() == expected.size();
    for (std::size_t i = 0; equal && i < found.size(); ++i) equal = same_line(found[i], expected[i]);
    expect(equal, "the lines within a radius of a point");
    brute_.within(less_offset, kInfinity, surface, expected);
    expect(expected.empty() ? !nearest : same_line(nearest, expected[0]), "the line nearest to a point");
  }

  bool same_line(const fl::NearLine& a, const Neighbour& b) const {
    return a.prim == std::int64_t(b.row) && a.u == b.s &&
           a.distance == float(double(b.distance) * (1.0 / double(brute_.frame().scale)));
  }

  void compare_pairs() {
    const float radius = probes_.radius();
    const fl::PairOptions options{.skip_neighbours = 0, .n_threads = 1, .progress = {}};
    fl::Pairs found;
    try {
      found = tree_.near_queries().pairs(radius, nullptr, {}, options);
    } catch (const fl::InputError&) {
      return;
    }
    Progress progress;
    const PairQuery query{axes_of(prims_), axes_of(prims_),           true, brute_.frame(),
                          radius,          max_radius_of(prims_) > 0, {}};
    const PairColumns expected = all_pairs<float>(query, 1, progress);
    bool equal = found.size() == expected.i.size();
    for (std::size_t k = 0; equal && k < found.size(); ++k)
      equal = found.i[k] == expected.i[k] && found.j[k] == expected.j[k] && found.s[k] == expected.s[k] &&
              found.t[k] == expected.t[k] && found.distance[k] == expected.distance[k];
    expect(equal, "the pairs within a radius");
  }

  void compare_refit() {
    const auto& arrays = tree_.arrays();
    const TreePointer moved = P::kHasRadius ? tree_.refit(arrays.cones, 1) : tree_.refit(arrays.segments, 1);
    std::vector<fl::Hit> expected;
    for (std::size_t i = 0; i < kRays / 2; ++i) {
      const RayQuery query = probes_.ray();
      try {
        const fl::Hit hit = moved->first_hit(ray_of(query), query.radius, fl::At::closest);
        brute_.all_hits(query, At::closest, expected);
        expect(same_hit(hit, expected.empty() ? fl::Hit() : expected[0]), "the first hit after a refit", query);
      } catch (const fl::InputError&) {
      }
    }
  }

  const TreeImpl& tree_;
  const P prims_;
  BruteAnswers<P> brute_;
  Probes probes_;
};

std::vector<std::byte> saved(const TreeImpl& tree) {
  std::vector<std::byte> bytes;
  fl::detail::write_tree(tree, [&](const std::vector<Bytes>& parts) {
    for (const Bytes part : parts) bytes.insert(bytes.end(), part.begin(), part.end());
  });
  return bytes;
}

/// A tree that is saved is read again, and saved as the same bytes.
void compare_saved(const TreeImpl& tree) {
  const std::vector<std::byte> once = saved(tree);
  const TreePointer again = fl::detail::read_tree(once, fl::detail::current_engine());
  expect(saved(*again) == once, "a tree that is saved twice");
}

/// The box whose frame queries compute in.
Box frame_box_of(const TreeImpl& tree) {
  if (const auto& frame = tree.origin().frame) {
    const auto& [x0, y0, z0, x1, y1, z1] = *frame;
    return {{x0, y0, z0}, {x1, y1, z1}};
  }
  Box box;
  std::memcpy(&box, tree.arrays().nodes.data(), sizeof box);
  return box;
}

void compare(const TreeImpl& tree, std::uint64_t seed) {
  const fl::detail::TreeArrays arrays = tree.arrays();
  if (seed % 16 == 0) compare_saved(tree);
  const Box box = frame_box_of(tree);
  const auto items = []<class Item>(const Item*, const auto& of) {
    return std::span(reinterpret_cast<const Item*>(of.data()), of.size());
  };
  if (arrays.has_radius)
    Compared<RoundCones>(tree, items(static_cast<RoundCone*>(nullptr), arrays.cones), box, seed).compare();
  else
    Compared<Segments>(tree, items(static_cast<Segment*>(nullptr), arrays.segments), box, seed).compare();
}

}  // namespace
}  // namespace fastlines::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fastlines::fuzz;
  const std::span bytes(data, size);
  TreePointer tree;
  try {
    tree = fl::detail::read_tree(std::as_bytes(bytes), fl::detail::current_engine());
  } catch (const std::runtime_error&) {
    return 0;
  } catch (const fl::InputError&) {
    return 0;
  }
  const std::uint64_t seed = seed_of(bytes);
  accepted.add(bytes, seed);
  compare(*tree, seed);
  return 0;
}
