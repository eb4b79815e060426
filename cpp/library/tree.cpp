// fl::Tree, and the interface of the thesis over it.
#include <algorithm>

#include "engine.hpp"
#include "fastlines/api/acc_tree.hpp"
#include "place.hpp"
#include "thread_hits.hpp"
#include "tree_file.hpp"

namespace fl {

// Here, and not in the header, so that all instruction sets share one type of each.
InputError::~InputError() = default;
FileError::~FileError() = default;
Cancelled::~Cancelled() = default;
detail::TreeImpl::~TreeImpl() = default;
detail::NearQueries::~NearQueries() = default;

void detail::TreeOrigin::be_tight() {
  if (!is_cut) return;
  const std::string cut = R"("boxes": "cut")";
  if (const std::size_t at = settings.find(cut); at != std::string::npos)
    settings.replace(at, cut.size(), R"("boxes": "tight")");
  is_cut = false;
  method = "custom";
}

namespace {

/// As many hits as there are.
constexpr std::size_t kNoLimit = ~std::size_t(0);

/// How many hits a sink lets be in memory at a time.
struct SinkTuning {
  std::size_t max_hits = 1 << 21;    ///< of 20 or 24 bytes each
  std::size_t max_rays = 1 << 16;    ///< that are traced at a time
  std::size_t first_rays = 1 << 12;  ///< that are traced at first, before anything is known about their hits
};

/// The rays from `first` on, `n` of them.
Rays part_of(const Rays& rays, std::size_t first, std::size_t n) {
  Rays part = rays;
  part.origins = rays.origins.subspan(first, n);
  part.directions = rays.directions.subspan(first, n);
  for (PerRay Rays::* each : {&Rays::t_min, &Rays::t_max, &Rays::spread})
    if (const auto values = (rays.*each).values(); values.size() == rays.size()) part.*each = values.subspan(first, n);
  return part;
}

}  // namespace

Tree::Tree() {
  static const Tree none = build(std::span<const Segment>());
  impl_ = none.impl_;
}
Tree::Tree(std::shared_ptr<const detail::TreeImpl> impl) : impl_(std::move(impl)) {}

Hit Tree::first_hit(const Ray& ray, float radius, At at) const { return impl_->first_hit(ray, radius, at); }
bool Tree::any_hit(const Ray& ray, float radius, At at) const { return impl_->any_hit(ray, radius, at); }
std::size_t Tree::count_hits(const Ray& ray, float radius, At at) const { return impl_->count_hits(ray, radius, at); }
void Tree::all_hits(const Ray& ray, float radius, std::vector<Hit>& to, At at) const {
  impl_->all_hits(ray, radius, at, to);
}
void Tree::next_hits(const Ray& ray, float radius, std::size_t k, std::vector<Hit>& to, At at, Rank rank) const {
  impl_->next_hits(ray, radius, k, at, rank, to);
}
std::vector<Hit> Tree::all_hits(const Ray& ray, float radius, At at) const {
  std::vector<Hit> hits;
  all_hits(ray, radius, hits, at);
  return hits;
}
std::vector<Hit> Tree::next_hits(const Ray& ray, float radius, std::size_t k, At at, Rank rank) const {
  std::vector<Hit> hits;
  next_hits(ray, radius, k, hits, at, rank);
  return hits;
}

Hits Tree::first_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options) const {
  return impl_->first_hits(rays, radius, options);
}
std::vector<std::uint8_t> Tree::any_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options) const {
  return impl_->any_hits(rays, radius, options);
}
std::vector<std::int64_t> Tree::count_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options) const {
  return impl_->count_hits(rays, radius, options);
}
HitLists Tree::all_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options) const {
  return *impl_->list_hits(rays, radius, {}, options, kNoLimit);
}
HitLists Tree::next_hits(const Rays& rays, const PerRay& radius, std::size_t k, const QueryOptions& options) const {
  return *impl_->list_hits(rays, radius, k, options, kNoLimit);
}

Gathered Tree::gather(const Rays& rays, const PerRay& radius, const GatherOptions& what,
                      const QueryOptions& options) const {
  Gathered sums;
  impl_->gather(rays, radius, what, options, sums);
  return sums;
}

void Tree::all_hits(const Rays& rays, const PerRay& radius, const Sink& sink, const QueryOptions& options) const {
  constexpr SinkTuning tuning;
  if (!sink) throw InputError("the sink is empty; expected a function");
  impl_->check(rays, radius, options);
  const std::size_t n = rays.size();
  std::size_t n_at_once = tuning.first_rays;
  double reported = 0;
  for (std::size_t first = 0; first < n;) {
    const std::size_t n_part = std::min(n_at_once, n - first);
    const PerRay radius_of_part = radius.values().size() == n ? PerRay(radius.values().subspan(first, n_part)) : radius;
    QueryOptions of_part = options;
    if (options.progress)
      of_part.progress = [&](double done) {
        reported = std::max(reported, (double(first) + done * double(n_part)) / double(n));
        return options.progress(reported);
      };
    const auto lists = impl_->list_hits(part_of(rays, first, n_part), radius_of_part, {}, of_part,
                                        n_part > 1 ? tuning.max_hits : kNoLimit);
    if (!lists) {
      n_at_once = (n_part + 3) / 4;
      continue;
    }
    for (std::size_t i = 0; i < n_part; ++i) sink(first + i, (*lists)[i]);
    first += n_part;
    // Trace more rays at a time while they have few hits.
    if (lists->hits.size() < tuning.max_hits / 8) n_at_once = std::min(4 * n_at_once, tuning.max_rays);
  }
}

NearLine Tree::nearest(const Point& point, float max_distance, To to) const {
  return impl_->near_queries().nearest(point, max_distance, to);
}
void Tree::k_nearest(const Point& point, std::size_t k, std::vector<NearLine>& lines, float max_distance, To to) const {
  impl_->near_queries().k_nearest(point, k, max_distance, to, lines);
}
void Tree::within(const Point& point, float radius, std::vector<NearLine>& lines, To to) const {
  impl_->near_queries().within(point, radius, to, lines);
}
std::size_t Tree::count_within(const Point& point, float radius, To to) const {
  return impl_->near_queries().count_within(point, radius, to);
}
std::vector<NearLine> Tree::k_nearest(const Point& point, std::size_t k, float max_distance, To to) const {
  std::vector<NearLine> lines;
  k_nearest(point, k, lines, max_distance, to);
  return lines;
}
std::vector<NearLine> Tree::within(const Point& point, float radius, To to) const {
  std::vector<NearLine> lines;
  within(point, radius, lines, to);
  return lines;
}

NearLines Tree::nearest(const Points& points, const PerPoint& max_distance, const PointOptions& options) const {
  return impl_->near_queries().k_nearest(points, 1, max_distance, options);
}
NearLines Tree::k_nearest(const Points& points, std::size_t k, const PerPoint& max_distance,
                          const PointOptions& options) const {
  return impl_->near_queries().k_nearest(points, k, max_distance, options);
}
NearLists Tree::within(const Points& points, const PerPoint& radius, const PointOptions& options) const {
  return impl_->near_queries().within(points, radius, options);
}
std::vector<std::int64_t> Tree::count_within(const Points& points, const PerPoint& radius,
                                             const PointOptions& options) const {
  return impl_->near_queries().count_within(points, radius, options);
}

Pairs Tree::pairs(float radius, const PairOptions& options) const {
  const std::vector<detail::StrandPlace> places = detail::strand_places(strands(), segments(), round_cones());
  return impl_->near_queries().pairs(radius, nullptr, places, options);
}
Pairs Tree::pairs(float radius, const Tree& other, const PairOptions& options) const {
  return impl_->near_queries().pairs(radius, &other.impl_->near_queries(), {}, options);
}

std::size_t Tree::size() const { return impl_->size(); }
std::span<const Segment> Tree::segments() const { return impl_->arrays().segments; }
std::span<const RoundCone> Tree::round_cones() const { return impl_->arrays().cones; }
RoundCone Tree::line(std::int64_t prim) const {
  if (prim < 0 || std::size_t(prim) >= size())
    throw InputError("there is no line " + std::to_string(prim) + "; expected an index below " +
                     std::to_string(size()));
  const detail::TreeArrays arrays = impl_->arrays();
  if (arrays.has_radius) return arrays.cones[std::size_t(prim)];
  const Segment& segment = arrays.segments[std::size_t(prim)];
  return {segment.p, segment.q};
}
std::span<const std::int64_t> Tree::strands() const { return impl_->origin().strands; }
Vec3d Tree::offset() const { return impl_->origin().offset; }
Place Tree::place(const Ray& ray, float radius, const Hit& hit) const {
  return hit ? detail::place_of(line(hit.prim), ray, radius, hit, impl_->scene_size()) : detail::place_of_miss();
}
Vec3d Tree::place(const Point& point, const NearLine& found, To to) const {
  if (!found) return detail::place_of_miss().point;
  const auto [x, y, z] = offset();
  const Vec3d at{point.position.x - x, point.position.y - y, point.position.z - z};
  const bool surface = to == To::surface && !round_cones().empty();
  const Vec3d place = detail::place_near(line(found.prim), at, found.u, surface);
  return {place.x + x, place.y + y, place.z + z};
}
TreeFacts Tree::facts() const { return impl_->facts(); }
void Tree::save(const std::string& path) const { detail::save_tree(*impl_, path); }

Tree Tree::refit(std::span<const Segment> segments, unsigned n_threads) const {
  return Tree(impl_->refit(segments, n_threads));
}
Tree Tree::refit(std::span<const RoundCone> cones, unsigned n_threads) const {
  return Tree(impl_->refit(cones, n_threads));
}

Tree build(std::span<const Segment> segments, const BuildOptions& options) {
  return Tree(detail::current_engine().build_segments(segments, options));
}
Tree build(std::span<const RoundCone> cones, const BuildOptions& options) {
  return Tree(detail::current_engine().build_cones(cones, options));
}
Tree load(const std::string& path) { return Tree(detail::load_tree(path)); }

void AccTree::Build(const float* lines, int n) {
  if (n < 0) throw InputError("Build: " + std::to_string(n) + " lines; expected 0 or more");
  BuildOptions options;
  options.method = method_;
  tree_ = build(std::span(reinterpret_cast<const Segment*>(lines), std::size_t(n)), options);
}

bool AccTree::Intersect(const Ray& ray, Intersection* hit, float d) const {
  const Hit found = tree_.first_hit(ray, d);
  if (found && hit) *hit = {found.t, int(found.prim)};
  return bool(found);
}

bool AccTree::IntersectAll(const Ray& ray, std::vector<Intersection>* hits, float d) const {
  if (!hits) return tree_.any_hit(ray, d);
  std::vector<Hit>& found = detail::thread_hits();
  tree_.all_hits(ray, d, found);
  hits->clear();
  for (const Hit& hit : found) hits->push_back({hit.t, int(hit.prim)});
  detail::release_large(found);
  return !hits->empty();
}

}  // namespace fl
