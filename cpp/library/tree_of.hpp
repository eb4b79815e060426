// A tree over one kind of line, compiled for one instruction set.
#pragma once

#include "engine.hpp"
#include "engine/layout_queries.hpp"
#include "engine/trees.hpp"
#include "fastlines/kernels/run/one_ray.hpp"
#include "fastlines/tree/cost.hpp"
#include "ray_limits.hpp"
#include "watch.hpp"

namespace fl::detail {

/// The same array as another type of the same floats in the same order.
template <class To, class From>
std::span<const To> view_as(std::span<const From> items) {
  static_assert(sizeof(To) == sizeof(From) && alignof(To) == alignof(From));
  return {reinterpret_cast<const To*>(items.data()), items.size()};
}

inline fastlines::Vec3 core_vector(const Vec3& v) { return {v.x, v.y, v.z}; }
inline Vec3 vector_of(const fastlines::Vec3& v) { return {v[0], v[1], v[2]}; }
inline fastlines::At core_at(At at) { return at == At::surface ? fastlines::At::surface : fastlines::At::closest; }
inline fastlines::Kernel core_kernel(QueryOptions::Kernel kernel) {
  using enum fastlines::Kernel;
  constexpr fastlines::Kernel kernels[] = {automatic, single, wave, bundle};
  return kernels[int(kernel)];
}
inline Hit hit_of(const fastlines::Hit& hit) { return {hit.t, hit.prim, hit.u, hit.distance, hit.t_out}; }

/// P is fastlines::Segments or fastlines::RoundCones.
template <fastlines::AxisPrimitive P>
class TreeOf final : public TreeImpl {
 public:
  using Item = typename P::Item;
  using Kernel = QueryOptions::Kernel;

  TreeOf(std::vector<Item> items, fastlines::Tree tree, TreeOrigin origin, unsigned n_threads,
         fastlines::Progress& progress)
      : items_(std::move(items)),
        prims_(std::span<const Item>(items_)),
        tree_(std::move(tree)),
        origin_(std::move(origin)),
        wide_(fastlines::collapse<P>(tree_.nodes, tree_.refs, prims_, {.radius_hint = 0.001}, n_threads, progress)),
        view_(fastlines::view_of(wide_, prims_)),
        limits_(tree_.nodes[0].box) {}

  // One ray.

  Hit first_hit(const Ray& ray, float radius, At at) const override {
    return hit_of(fastlines::OneRay<P>(view_, checked(ray, radius)).first_hit(core_at(at)));
  }
  bool any_hit(const Ray& ray, float radius) const override {
    return fastlines::OneRay<P>(view_, checked(ray, radius)).any_hit();
  }
  std::size_t count_hits(const Ray& ray, float radius) const override {
    return fastlines::OneRay<P>(view_, checked(ray, radius)).count_hits();
  }
  void all_hits(const Ray& ray, float radius, At at, std::vector<Hit>& to) const override {
    fastlines::OneRay<P>(view_, checked(ray, radius)).all_hits(core_at(at), to);
  }
  void next_hits(const Ray& ray, float radius, std::size_t k, At at, std::vector<Hit>& to) const override {
    fastlines::OneRay<P>(view_, checked(ray, radius)).next_hits(k, core_at(at), to);
  }

  // Batches.

  void check(const Rays& rays, const PerRay& radius, const QueryOptions& options) const override {
    checked(rays, radius, options);
  }
  Hits first_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options) const override {
    const Batch batch = checked(rays, radius, options);
    const auto to = std::make_shared<HitArrays>(rays.size(), options.at);
    run(batch, options, [&](const auto& queries) { queries.find_first(core_at(options.at), to->columns()); });
    return to->hits(to);
  }
  std::vector<std::uint8_t> any_hits(const Rays& rays, const PerRay& radius,
                                     const QueryOptions& options) const override {
    static_assert(sizeof(bool) == 1);
    const Batch batch = checked(rays, radius, options);
    std::vector<std::uint8_t> found(rays.size());
    run(batch, options, [&](const auto& queries) { queries.find_any(reinterpret_cast<bool*>(found.data())); });
    return found;
  }
  std::vector<std::int64_t> count_hits(const Rays& rays, const PerRay& radius,
                                       const QueryOptions& options) const override {
    const Batch batch = checked(rays, radius, options);
    std::vector<std::int64_t> counts(rays.size());
    run(batch, options, [&](const auto& queries) { queries.count(counts.data()); });
    return counts;
  }
  HitLists list_hits(const Rays& rays, const PerRay& radius, std::optional<std::size_t> k,
                     const QueryOptions& options) const override {
    const Batch batch = checked(rays, radius, options);
    fastlines::HitAssembler lists(rays.size(), options.at == At::surface);
    run(batch, options,
        [&](const auto& queries) { queries.list(core_at(options.at), k, /*by_distance=*/false, lists); });
    const auto offsets = std::make_shared<fastlines::LargeVector<std::int64_t>>(lists.offsets());
    const auto hits = std::make_shared<HitArrays>(std::move(lists), std::size_t(offsets->back()));
    return {*offsets, hits->hits(hits), offsets};
  }

  TreeFacts facts() const override {
    const fastlines::Box& box = tree_.nodes[0].box;
    const std::size_t n_bytes = std::span(items_).size_bytes() + std::span(tree_.nodes).size_bytes() +
                                std::span(tree_.refs).size_bytes() + wide_.nodes.size() * sizeof(fastlines::WideNode) +
                                wide_.leaves.size() * sizeof(fastlines::WideLeaf) +
                                wide_.refs.size() * sizeof(fastlines::WideRef);
    return {.n_prims = items_.size(),
            .n_nodes = tree_.nodes.size(),
            .n_refs = tree_.refs.size(),
            .cost = fastlines::cost_of(tree_.nodes, origin_.c_trav, origin_.c_prim),
            .n_bytes = n_bytes,
            .method = origin_.method,
            .low = vector_of(box.lo),
            .high = vector_of(box.hi),
            .simd = fastlines::kSimd};
  }

  std::size_t size() const override { return items_.size(); }
  const TreeOrigin& origin() const override { return origin_; }
  TreeArrays arrays() const override {
    const auto words = []<class Row>(const fastlines::LargeVector<Row>& rows) {
      return std::span(reinterpret_cast<const std::uint32_t*>(rows.data()), rows.size() * sizeof(Row) / 4);
    };
    TreeArrays arrays;
    arrays.nodes = words(tree_.nodes);
    arrays.refs = words(tree_.refs);
    arrays.has_radius = P::kHasRadius;
    if constexpr (P::kHasRadius)
      arrays.cones = view_as<RoundCone>(std::span(items_));
    else
      arrays.segments = view_as<Segment>(std::span(items_));
    return arrays;
  }

 private:
  /// Hits as arrays of the library's own.
  struct HitArrays {
    fastlines::Buffer<float> t, u, distance, t_out;
    fastlines::Buffer<std::int64_t> prim;

    HitArrays(std::size_t n, At at) {
      for (auto* column : {&t, &u, &distance}) column->reset(n);
      prim.reset(n);
      if (at == At::surface) t_out.reset(n);
      set_size(n, at == At::surface);
    }
    HitArrays(fastlines::HitAssembler&& lists, std::size_t n)
        : t(std::move(lists.t)),
          u(std::move(lists.u)),
          distance(std::move(lists.distance)),
          t_out(std::move(lists.t_out)),
          prim(std::move(lists.prim)) {
      set_size(n, lists.with_t_out());
    }

    fastlines::HitColumns columns() {
      return {t.data(), prim.data(), u.data(), distance.data(), t_out.size() ? t_out.data() : nullptr};
    }
    Hits hits(std::shared_ptr<const void> owner) const { return {t, prim, u, distance, t_out, std::move(owner)}; }

   private:
    void set_size(std::size_t n, bool with_t_out) {
      for (auto* column : {&t, &u, &distance}) column->set_size(n);
      prim.set_size(n);
      t_out.set_size(with_t_out ? n : 0);
    }
  };

  /// The ray as the core has it. Throws InputError if it is not valid.
  fastlines::RayQuery checked(const Ray& ray, float radius) const {
    const fastlines::RayQuery query{core_vector(ray.origin), core_vector(ray.direction), ray.t_min, ray.t_max, radius};
    limits_.check(query);
    return query;
  }

  /// A batch as the core has it, and how many threads trace it.
  struct Batch {
    fastlines::RayBatch rays;
    unsigned n_threads;
  };

  /// Throws InputError if the batch cannot be used. Short batches take one thread.
  Batch checked(const Rays& rays, const PerRay& radius, const QueryOptions& options) const {
    const fastlines::RayBatch batch{view_as<fastlines::Vec3>(rays.origins), view_as<fastlines::Vec3>(rays.directions),
                                    radius.values(), rays.t_min.values(), rays.t_max.values()};
    if (options.kernel < Kernel::automatic || options.kernel > Kernel::bundle)
      throw InputError("unknown kernel; expected one of fl::QueryOptions::Kernel");
    const bool is_long = fastlines::may_be_long(batch.size(), wide_.refs.size());
    const unsigned n_threads = is_long ? n_threads_of(options.n_threads) : 1;
    limits_.check(batch, n_threads);
    return {batch, n_threads};
  }

  /// Calls run_queries(queries) with the queries of a batch.
  template <class Run>
  void run(const Batch& batch, const QueryOptions& options, Run&& run_queries) const {
    watch(options.progress, [&](fastlines::Progress& progress) {
      run_queries(
          fastlines::LayoutQueries<P>{view_, batch.rays, core_kernel(options.kernel), batch.n_threads, progress});
    });
  }

  const std::vector<Item> items_;
  const P prims_;
  const fastlines::Tree tree_;
  const TreeOrigin origin_;
  const fastlines::WideBvh wide_;
  const fastlines::WideBvhView<P> view_;
  const RayLimits limits_;
};

}  // namespace fl::detail
