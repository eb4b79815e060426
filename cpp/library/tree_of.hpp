// A tree over one kind of line, compiled for one instruction set.
#pragma once

#include <mutex>

#include "core_values.hpp"
#include "engine.hpp"
#include "engine/layout_queries.hpp"
#include "engine/trees.hpp"
#include "fastlines/kernels/intersect/scene_cull.hpp"
#include "fastlines/kernels/run/one_ray.hpp"
#include "fastlines/query/gather/gather_rays.hpp"
#include "fastlines/tree/cost.hpp"
#include "frame_box.hpp"
#include "gather_rule.hpp"
#include "hit_arrays.hpp"
#include "line_input.hpp"
#include "moved_tree.hpp"
#include "near_queries_of.hpp"
#include "ray_limits.hpp"
#include "special_rays.hpp"
#include "watch.hpp"

namespace fl::detail {

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
        frame_box_(frame_box_of(origin_, tree_)),
        wide_(fastlines::collapse<P>(tree_.nodes, tree_.refs, prims_, {.radius_hint = 0.001}, n_threads, progress,
                                     frame_box_)),
        view_(fastlines::view_of(wide_, prims_)),
        scene_(view_),
        limits_(frame_box_, fastlines::max_radius_of(prims_)),
        near_(prims_, wide_, view_, frame_box_, origin_) {}

  // One ray. A special one is a batch of one.

  Hit first_hit(const Ray& ray, float radius, At at) const override {
    if (is_special(ray)) [[unlikely]]
      return first_special(ray, radius, at);
    const fastlines::RayQuery query = checked(ray, radius);
    return scene_.surely_misses(query) ? Hit() : hit_of(fastlines::OneRay<P>(view_, query).first_hit(core_at(at)));
  }
  bool any_hit(const Ray& ray, float radius, At at) const override {
    if (is_special(ray)) [[unlikely]]
      return first_special(ray, radius, at).prim >= 0;
    const fastlines::RayQuery query = checked(ray, radius);
    return !scene_.surely_misses(query) && fastlines::OneRay<P>(view_, query).any_hit(core_at(at));
  }
  std::size_t count_hits(const Ray& ray, float radius, At at) const override {
    if (is_special(ray)) [[unlikely]]
      return count_special(ray, radius, at);
    const fastlines::RayQuery query = checked(ray, radius);
    return scene_.surely_misses(query) ? 0 : fastlines::OneRay<P>(view_, query).count_hits(core_at(at));
  }
  void all_hits(const Ray& ray, float radius, At at, std::vector<Hit>& to) const override {
    if (is_special(ray)) [[unlikely]]
      return list_special(ray, radius, {}, options_of(at), to);
    const fastlines::RayQuery query = checked(ray, radius);
    if (scene_.surely_misses(query)) return to.clear();
    fastlines::OneRay<P>(view_, query).all_hits(core_at(at), to);
  }
  void next_hits(const Ray& ray, float radius, std::size_t k, At at, Rank rank, std::vector<Hit>& to) const override {
    if (is_special(ray)) [[unlikely]]
      return list_special(ray, radius, k, options_of(at, rank), to);
    const fastlines::RayQuery query = checked(ray, radius);
    if (scene_.surely_misses(query)) return to.clear();
    fastlines::OneRay<P>(view_, query).next_hits(k, core_at(at), core_keep(rank), to);
  }

  // Batches.

  void check(const Rays& rays, const PerRay& radius, const QueryOptions& options) const override {
    checked(rays, radius, options);
    if (is_special(rays)) ignored_of(rays);
  }
  Hits first_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options) const override {
    const Batch batch = checked(rays, radius, options);
    const auto to = std::make_shared<HitArrays>(rays.size(), options.at);
    if (is_special(rays))
      run_special(rays, options, [&](const auto& search, fastlines::Progress& progress) {
        fastlines::first_hits(
            search, batch.rays, core_at(options.at), batch.n_threads, progress,
            [columns = to->columns()](std::size_t i, const fastlines::Hit& hit) { columns.set(i, hit); });
      });
    else
      run(batch, options, [&](const auto& queries) { queries.find_first(core_at(options.at), to->columns()); });
    return to->hits(to);
  }
  std::vector<std::uint8_t> any_hits(const Rays& rays, const PerRay& radius,
                                     const QueryOptions& options) const override {
    static_assert(sizeof(bool) == 1);
    const Batch batch = checked(rays, radius, options);
    std::vector<std::uint8_t> found(rays.size());
    bool* const to = reinterpret_cast<bool*>(found.data());
    if (is_special(rays))
      run_special(rays, options, [&](const auto& search, fastlines::Progress& progress) {
        fastlines::any_hits(search, batch.rays, core_at(options.at), batch.n_threads, progress, {to, found.size()});
      });
    else
      run(batch, options, [&](const auto& queries) { queries.find_any(core_at(options.at), to); });
    return found;
  }
  std::vector<std::int64_t> count_hits(const Rays& rays, const PerRay& radius,
                                       const QueryOptions& options) const override {
    const Batch batch = checked(rays, radius, options);
    std::vector<std::int64_t> counts(rays.size());
    if (is_special(rays))
      run_special(rays, options, [&](const auto& search, fastlines::Progress& progress) {
        fastlines::count_hits(search, batch.rays, core_at(options.at), batch.n_threads, progress, counts);
      });
    else
      run(batch, options, [&](const auto& queries) { queries.count(core_at(options.at), counts.data()); });
    return counts;
  }
  std::optional<HitLists> list_hits(const Rays& rays, const PerRay& radius, std::optional<std::size_t> k,
                                    const QueryOptions& options, std::size_t max_hits) const override {
    const Batch batch = checked(rays, radius, options, k.has_value());
    fastlines::HitAssembler lists(rays.size(), options.at != At::closest, max_hits);
    const fastlines::Keep keep = k ? core_keep(options.rank) : fastlines::Keep::all;
    // An engine catches its own exceptions: its types are not those of the others.
    try {
      if (is_special(rays))
        run_special(rays, options, [&](const auto& search, fastlines::Progress& progress) {
          fastlines::list_hits(search, batch.rays, batch.n_threads, progress, lists, core_at(options.at), keep,
                               k.value_or(~std::size_t(0)));
        });
      else
        run(batch, options, [&](const auto& queries) {
          queries.list(core_at(options.at), k, keep == fastlines::Keep::nearest, lists);
        });
    } catch (const fastlines::TooManyHits&) {
      return {};
    }
    const auto offsets = std::make_shared<fastlines::LargeVector<std::int64_t>>(lists.offsets());
    const auto hits = std::make_shared<HitArrays>(std::move(lists), std::size_t(offsets->back()));
    return HitLists{*offsets, hits->hits(hits), offsets};
  }

  void gather(const Rays& rays, const PerRay& radius, const GatherOptions& what, const QueryOptions& options,
              Gathered& to) const override {
    const Batch batch = checked(rays, radius, options);
    const fastlines::GatherRule rule = rule_of(what, options, batch.rays, items_.size(), prims_.max_radius());
    const fastlines::GatherSums sums = make_room(to, rays.size(), what);
    if (!is_special(rays)) return run(batch, options, [&](const auto& queries) { queries.gather(rule, sums); });
    const fastlines::GatherLines lines{reinterpret_cast<const float*>(items_.data()), sizeof(Item) / sizeof(float)};
    run_special(rays, options, [&](const auto& search, fastlines::Progress& progress) {
      fastlines::gather_rays(search, batch.rays, rule, lines, batch.n_threads, progress, sums);
    });
  }

  const NearQueries& near_queries() const override { return near_; }

  // Lines that have moved.

  TreePointer refit(std::span<const Segment> lines, unsigned n_threads) const override {
    return refit_to(lines, n_threads);
  }
  TreePointer refit(std::span<const RoundCone> lines, unsigned n_threads) const override {
    return refit_to(lines, n_threads);
  }

  double scene_size() const override { return limits_.size; }
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
  /// A batch as the core has it, and how many threads trace it.
  struct Batch {
    fastlines::RayBatch rays;
    unsigned n_threads;
  };

  static bool is_special(const auto& rays) {
    return has_spread(rays.spread) || !rays.ignore.empty() || !rays.ignore_strands.empty();
  }
  static bool has_spread(float spread) { return spread != 0.0f; }
  static bool has_spread(const PerRay& spread) {
    return std::ranges::any_of(spread.values(), [](float each) { return each != 0.0f; });
  }

  static Rays batch_of(const Ray& ray) {
    return {{&ray.origin, 1}, {&ray.direction, 1}, ray.t_min, ray.t_max, ray.spread, ray.ignore, ray.ignore_strands};
  }
  static QueryOptions options_of(At at, Rank rank = Rank::t) {
    QueryOptions options;
    options.at = at;
    options.rank = rank;
    return options;
  }

  [[gnu::noinline]] Hit first_special(const Ray& ray, float radius, At at) const {
    return first_hits(batch_of(ray), radius, options_of(at))[0];
  }
  [[gnu::noinline]] std::size_t count_special(const Ray& ray, float radius, At at) const {
    return std::size_t(count_hits(batch_of(ray), radius, options_of(at))[0]);
  }
  [[gnu::noinline]] void list_special(const Ray& ray, float radius, std::optional<std::size_t> k,
                                      const QueryOptions& options, std::vector<Hit>& to) const {
    const auto lists = list_hits(batch_of(ray), radius, k, options, ~std::size_t(0));
    to.clear();
    for (std::size_t i = 0; i < lists->hits.size(); ++i) to.push_back(lists->hits[i]);
  }

  Ignored ignored_of(const Rays& rays) const {
    return {rays.ignore, rays.ignore_strands, items_.size(), origin_.strands};
  }

  /// The least share of a batch's work that one step is.
  double share_of_step(std::size_t n_rays) const { return 1.0 / (double(n_rays) * double(wide_.leaves.size())); }

  /// Calls run_search(search, progress) with a search for special rays.
  template <class RunSearch>
  void run_special(const Rays& rays, const QueryOptions& options, RunSearch&& run_search) const {
    const Ignored ignored = ignored_of(rays);
    watch(options.progress, [&](fastlines::Progress& progress) {
      progress.per_step = share_of_step(rays.size());
      if (!has_spread(rays.spread)) return run_search(LayoutSearch<P>{view_, prims_, ignored}, progress);
      const fastlines::SpreadCones prims(spread_items());
      run_search(LayoutSearch<fastlines::SpreadCones>{fastlines::view_of(wide_, prims), prims, ignored}, progress);
    });
  }

  /// The lines as round cones, as rays with a spread test them. Those of segments are made by the first query.
  std::span<const fastlines::RoundCone> spread_items() const {
    if constexpr (P::kHasRadius) {
      return items_;
    } else {
      std::call_once(spread_items_once_, [this] {
        spread_items_.reserve(items_.size());
        for (const Item& segment : items_) spread_items_.push_back({segment, 0.0f, 0.0f});
      });
      return spread_items_;
    }
  }

  template <class Line>
  TreePointer refit_to(std::span<const Line> lines, unsigned n_threads) const {
    if constexpr (sizeof(Line) != sizeof(Item)) {
      throw InputError(
          "lines of the other kind were given to refit; expected segments for a tree over segments, and "
          "round cones for one over round cones");
    } else {
      std::vector<Item> items = checked_copy<Item>(lines);
      if (items.size() != items_.size())
        throw InputError(std::to_string(items.size()) + " lines were given for a tree over " +
                         std::to_string(items_.size()) + "; expected as many");
      const unsigned threads = n_threads_of(n_threads);
      fastlines::Progress progress;
      TreeOrigin origin = origin_;
      fastlines::Tree tree = moved_tree(tree_, items_, items, origin, threads, progress);
      return std::make_shared<TreeOf<P>>(std::move(items), std::move(tree), std::move(origin), threads, progress);
    }
  }

  /// The ray as the core has it. Throws InputError if it is not valid.
  fastlines::RayQuery checked(const Ray& ray, float radius) const {
    const fastlines::RayQuery query{core_vector(ray.origin), core_vector(ray.direction), ray.t_min, ray.t_max, radius};
    limits_.check(query);
    return query;
  }

  /// Throws InputError if the batch cannot be used. Short batches take one thread.
  Batch checked(const Rays& rays, const PerRay& radius, const QueryOptions& options, bool has_rank = false) const {
    const fastlines::RayBatch batch{view_as<fastlines::Vec3>(rays.origins),
                                    view_as<fastlines::Vec3>(rays.directions),
                                    radius.values(),
                                    rays.t_min.values(),
                                    rays.t_max.values(),
                                    rays.spread.values()};
    if (options.kernel < Kernel::automatic || options.kernel > Kernel::bundle)
      throw InputError("unknown kernel; expected one of fl::QueryOptions::Kernel");
    const bool is_long = fastlines::may_be_long(batch.size(), wide_.refs.size());
    const unsigned n_threads = is_long ? n_threads_of(options.n_threads) : 1;
    if (options.rank != Rank::t && !(has_rank && options.rank == Rank::distance))
      throw InputError("Rank::distance is for next_hits; leave it out, or use that query");
    limits_.check(batch, n_threads);
    if (options.at != At::closest && has_spread(rays.spread))
      throw InputError(std::string(options.at == At::entry ? "At::entry" : "At::surface") +
                       " has no meaning with a spread: a line then has no one surface; leave out either");
    return {batch, n_threads};
  }

  /// Calls run_queries(queries) with the queries of a batch.
  template <class Run>
  void run(const Batch& batch, const QueryOptions& options, Run&& run_queries) const {
    watch(options.progress, [&](fastlines::Progress& progress) {
      progress.per_step = share_of_step(batch.rays.size());
      run_queries(
          fastlines::LayoutQueries<P>{view_, batch.rays, core_kernel(options.kernel), batch.n_threads, progress});
    });
  }

  const std::vector<Item> items_;
  const P prims_;
  const fastlines::Tree tree_;
  const TreeOrigin origin_;
  const fastlines::Box frame_box_;
  const fastlines::WideBvh wide_;
  const fastlines::WideBvhView<P> view_;
  const fastlines::SceneCull scene_;
  const RayLimits limits_;
  const NearQueriesOf<P> near_;
  mutable std::once_flag spread_items_once_;
  mutable std::vector<fastlines::RoundCone> spread_items_;
};

}  // namespace fl::detail
