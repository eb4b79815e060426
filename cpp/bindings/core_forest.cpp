// Rays on their way from tile to tile of a forest, and the merge of what tiles find.
#include <nanobind/stl/optional.h>

#include "core.hpp"
#include "fastlines/forest/list_merge.hpp"
#include "rays.hpp"
#include "watch.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

using Ids = std::optional<Input<std::int64_t>>;
using Flags = Input<std::uint8_t>;

/// Rays of a batch by their numbers.
struct RayColumns {
  RayArrays arrays;
  RayBatch rays = batch_of(arrays);

  std::size_t size() const { return rays.size(); }

  using Gathered = std::tuple<Output<float>, Output<float>, Output<float>, Output<float>, Output<float>, Output<float>>;

  /// Their columns but the limit: origins, directions, radius, t_min, t_max, spread.
  Gathered gather(std::span<const std::uint32_t> of, unsigned n_threads) const {
    const auto copy = [&](const auto& from, auto* to) {
      parallel_for_rays(of.size(), n_threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t j = begin; j < end; ++j) to[j] = from[of[j]];
      });
    };
    const auto points = [&](std::span<const Vec3> from) {
      auto to = make_array<float>(of.size(), 3);
      copy(from, reinterpret_cast<Vec3*>(to.data()));
      return to;
    };
    const auto scalars = [&](std::span<const float> from) {
      if (from.size() == 1) {
        auto one = make_array<float>(1);
        *one.data() = from[0];
        return one;
      }
      auto to = make_array<float>(of.size());
      copy(from, to.data());
      return to;
    };
    return {points(rays.origins), points(rays.directions), scalars(rays.radius),
            scalars(rays.t_min),  scalars(rays.t_max),     scalars(rays.spread)};
  }

  template <class Work>
  static void parallel_for_rays(std::size_t n, unsigned n_threads, Work&& work) {
    Progress unwatched;
    parallel_for_chunks(
        n, 1 << 14, n > 1 << 15 ? n_threads : 1, unwatched, [] { return 0; },
        [&](int, std::size_t begin, std::size_t end) { work(begin, end); });
  }
};

/// Columns of rays, and their limits.
using Taken = decltype(std::tuple_cat(std::declval<RayColumns::Gathered>(), std::declval<std::tuple<Output<float>>>()));

/// Answers as arrays of NumPy, read only.
using FoundHits =
    std::tuple<Input<float>, Input<std::int64_t>, Input<float>, Input<float>, std::optional<Input<float>>>;
using FoundLists = std::tuple<Input<std::int64_t>, FoundHits>;

/// The hits that a tile has found. They are only read.
HitColumns columns_of(const FoundHits& found) {
  const auto& [t, prim, u, distance, t_out] = found;
  const auto column = []<class Scalar>(const Input<Scalar>& array) { return const_cast<Scalar*>(array.data()); };
  return {column(t), column(prim), column(u), column(distance), t_out ? column(*t_out) : nullptr};
}

GlobalIds ids_of(const Ids& ids) { return {ids ? rows<std::int64_t>(*ids) : std::span<const std::int64_t>()}; }

/// Rays that walk from tile to tile.
class Walk {
 public:
  Walk(RayArrays rays, RayRoutes& routes, unsigned n_threads)
      : rays_{std::move(rays)}, walk_([&] {
          const WithoutGil without_gil;
          return TileWalk(std::move(routes), rays_.rays, n_threads);
        }()) {}

  std::int64_t next_tile(Flags is_open) const { return walk_.next_tile(rows<std::uint8_t>(is_open)); }
  std::size_t n_waiting() const { return walk_.n_waiting(); }

 protected:
  /// The rays that wait for a tile, as columns, with their limits: limit_of(ray).
  template <class LimitOf>
  Taken take(std::size_t tile, LimitOf&& limit_of) {
    taken_ = walk_.take(tile);
    auto limits = make_array<float>(taken_.size());
    for (std::size_t j = 0; j < taken_.size(); ++j) limits.data()[j] = limit_of(taken_[j]);
    return std::tuple_cat(rays_.gather(taken_, walk_.n_threads()), std::tuple(limits));
  }

  /// Take over the answers to the rays that were taken: update(j, ray) returns the limit of the ray.
  template <class Update>
  void advance(Update&& update) {
    const WithoutGil without_gil;
    walk_.advance(taken_, update);
  }

  std::size_t n_rays() const { return rays_.size(); }

 private:
  RayColumns rays_;
  TileWalk walk_;
  TileWalk::Rows taken_;
};

class FirstHitWalk : public Walk {
 public:
  FirstHitWalk(RayArrays rays, RayRoutes& routes, bool with_t_out, unsigned n_threads)
      : Walk(std::move(rays), routes, n_threads), hits_(n_rays(), with_t_out), first_(hits_.columns()) {
    for (std::size_t i = 0; i < n_rays(); ++i) first_.set(i, Hit{});
  }

  Taken take(std::size_t tile) {
    return Walk::take(tile, [this](std::uint32_t ray) { return first_.t[ray]; });
  }
  void give(FoundHits found, Ids ids) {
    const HitColumns of_tile = columns_of(found);
    const GlobalIds global = ids_of(ids);
    advance([&](std::size_t j, std::uint32_t ray) { return keep_first(first_, ray, of_tile, j, global); });
  }
  HitTuple hits() const { return hits_.tuple(); }

 private:
  HitArrays hits_;
  HitColumns first_;
};

class AnyHitWalk : public Walk {
 public:
  AnyHitWalk(RayArrays rays, RayRoutes& routes, unsigned n_threads)
      : Walk(std::move(rays), routes, n_threads), found_(make_array<bool>(n_rays())) {
    std::fill_n(found_.data(), n_rays(), false);
  }

  Taken take(std::size_t tile) {
    return Walk::take(tile, [](std::uint32_t) { return kInfinity; });
  }
  void give(Input<bool> found) {
    advance([&](std::size_t j, std::uint32_t ray) {
      found_.data()[ray] = found.data()[j];
      return found.data()[j] ? -kInfinity : kInfinity;
    });
  }
  Output<bool> found() const { return found_; }

 private:
  Output<bool> found_;
};

class NextHitWalk : public Walk {
 public:
  NextHitWalk(RayArrays rays, RayRoutes& routes, std::size_t k, bool with_t_out, unsigned n_threads)
      : Walk(std::move(rays), routes, n_threads), with_t_out_(with_t_out), next_([&] {
          const WithoutGil without_gil;
          return NextHits(n_rays(), k);
        }()) {}

  Taken take(std::size_t tile) {
    return Walk::take(tile, [this](std::uint32_t ray) { return next_.limit(ray); });
  }
  void give(FoundLists found, Ids ids) {
    const auto& [offsets, hits] = found;
    const HitColumns of_tile = columns_of(hits);
    const GlobalIds global = ids_of(ids);
    const std::int64_t* const begin = offsets.data();
    advance([&](std::size_t j, std::uint32_t ray) {
      return next_.add(ray, of_tile, std::size_t(begin[j]), std::size_t(begin[j + 1]), global);
    });
  }
  ListTuple lists() const {
    LargeVector<std::int64_t> offsets(n_rays() + 1);
    for (std::size_t i = 0; i < n_rays(); ++i) offsets[i + 1] = offsets[i] + std::int64_t(next_.of(i).size());
    HitArrays hits(std::size_t(offsets.back()), with_t_out_);
    {
      const WithoutGil without_gil;
      const HitColumns to = hits.columns();
      for (std::size_t i = 0; i < n_rays(); ++i)
        for (std::size_t j = 0; j < next_.of(i).size(); ++j) to.set(std::size_t(offsets[i]) + j, next_.of(i)[j]);
    }
    return {adopt<std::int64_t>(std::move(offsets)), hits.tuple()};
  }

 private:
  bool with_t_out_;
  NextHits next_;
};

/// Rays that visit all tiles on their routes: hits are counted, or their lists merged.
class Visit {
 public:
  Visit(RayArrays rays, RayRoutes& routes, unsigned n_threads)
      : rays_{std::move(rays)},
        n_threads_(n_threads),
        visits_([&] {
          const WithoutGil without_gil;
          return TileRays(std::move(routes), rays_.rays);
        }()),
        lists_(visits_.n_tiles()) {}

  /// How many rays visit a tile.
  std::size_t n_rays_of(std::size_t tile) const { return visits_.of_tile(tile).size(); }
  RayColumns::Gathered take(std::size_t tile) const { return rays_.gather(visits_.of_tile(tile), n_threads_); }

  void add_counts(std::size_t tile, Input<std::int64_t> found, nb::ndarray<std::int64_t, nb::c_contig> counts) const {
    const auto& rays = visits_.of_tile(tile);
    for (std::size_t j = 0; j < rays.size(); ++j) counts.data()[rays[j]] += found.data()[j];
  }

  /// Adds the lists of a tile, whose hits have the numbers of the forest: lists must not keep a tile open.
  void add_lists(std::size_t tile, FoundLists found) {
    const auto& [offsets, hits] = found;
    lists_[tile] = {{offsets.data(), offsets.size()}, columns_of(hits)};
    arrays_.push_back(std::move(found));
  }

  /// The merged lists: all hits, or the best k.
  ListTuple merge(bool with_t_out, std::optional<std::uint64_t> k, bool by_distance, nb::object progress) const {
    const ListMerge merge(visits_, lists_, by_distance ? Keep::nearest : Keep::first, k.value_or(~0ull));
    LargeVector<std::int64_t> offsets;
    {
      const WithoutGil without_gil;
      offsets = merge.offsets(n_threads_);
    }
    HitArrays hits(std::size_t(offsets.back()), with_t_out);
    watch_if(may_be_long(rays_.size(), lists_.size()), progress,
             [&](Progress& watched) { merge.write(offsets, hits.columns(), n_threads_, watched); });
    return {adopt<std::int64_t>(std::move(offsets)), hits.tuple()};
  }

 private:
  RayColumns rays_;
  unsigned n_threads_;
  TileRays visits_;
  std::vector<TileLists> lists_;
  std::vector<FoundLists> arrays_;  // what the lists point into
};

}  // namespace

void bind_forest(nb::module_& m) {
  nb::class_<Walk>(m, "Walk").def("next_tile", &Walk::next_tile, "is_open"_a).def("n_waiting", &Walk::n_waiting);
  nb::class_<FirstHitWalk, Walk>(m, "FirstHitWalk")
      .def(nb::init<RayArrays, RayRoutes&, bool, unsigned>(), "rays"_a, "routes"_a, "with_t_out"_a, "n_threads"_a)
      .def("take", &FirstHitWalk::take, "tile"_a)
      .def("give", &FirstHitWalk::give, "found"_a, "ids"_a.none())
      .def("hits", &FirstHitWalk::hits);
  nb::class_<AnyHitWalk, Walk>(m, "AnyHitWalk")
      .def(nb::init<RayArrays, RayRoutes&, unsigned>(), "rays"_a, "routes"_a, "n_threads"_a)
      .def("take", &AnyHitWalk::take, "tile"_a)
      .def("give", &AnyHitWalk::give, "found"_a)
      .def("found", &AnyHitWalk::found);
  nb::class_<NextHitWalk, Walk>(m, "NextHitWalk")
      .def(nb::init<RayArrays, RayRoutes&, std::size_t, bool, unsigned>(), "rays"_a, "routes"_a, "k"_a, "with_t_out"_a,
           "n_threads"_a)
      .def("take", &NextHitWalk::take, "tile"_a)
      .def("give", &NextHitWalk::give, "found"_a, "ids"_a.none())
      .def("lists", &NextHitWalk::lists);
  nb::class_<Visit>(m, "Visit")
      .def(nb::init<RayArrays, RayRoutes&, unsigned>(), "rays"_a, "routes"_a, "n_threads"_a)
      .def("n_rays_of", &Visit::n_rays_of, "tile"_a)
      .def("take", &Visit::take, "tile"_a)
      .def("add_counts", &Visit::add_counts, "tile"_a, "found"_a, "counts"_a)
      .def("add_lists", &Visit::add_lists, "tile"_a, "found"_a)
      .def("merge", &Visit::merge, "with_t_out"_a, "k"_a.none(), "by_distance"_a, "progress"_a.none());
}

}  // namespace fastlines
