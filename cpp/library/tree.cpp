// fl::Tree, and the interface of the thesis over it.
#include <algorithm>

#include "engine.hpp"
#include "fastlines/api/acc_tree.hpp"
#include "thread_hits.hpp"
#include "tree_file.hpp"

namespace fl {

// Here, and not in the header, so that all instruction sets share one type of each.
InputError::~InputError() = default;
FileError::~FileError() = default;
Cancelled::~Cancelled() = default;
detail::TreeImpl::~TreeImpl() = default;

Tree::Tree() {
  static const Tree none = build(std::span<const Segment>());
  impl_ = none.impl_;
}
Tree::Tree(std::shared_ptr<const detail::TreeImpl> impl) : impl_(std::move(impl)) {}

Hit Tree::first_hit(const Ray& ray, float radius, At at) const { return impl_->first_hit(ray, radius, at); }
bool Tree::any_hit(const Ray& ray, float radius) const { return impl_->any_hit(ray, radius); }
std::size_t Tree::count_hits(const Ray& ray, float radius) const { return impl_->count_hits(ray, radius); }
void Tree::all_hits(const Ray& ray, float radius, std::vector<Hit>& to, At at) const {
  impl_->all_hits(ray, radius, at, to);
}
void Tree::next_hits(const Ray& ray, float radius, std::size_t k, std::vector<Hit>& to, At at) const {
  impl_->next_hits(ray, radius, k, at, to);
}
std::vector<Hit> Tree::all_hits(const Ray& ray, float radius, At at) const {
  std::vector<Hit> hits;
  all_hits(ray, radius, hits, at);
  return hits;
}
std::vector<Hit> Tree::next_hits(const Ray& ray, float radius, std::size_t k, At at) const {
  std::vector<Hit> hits;
  next_hits(ray, radius, k, hits, at);
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
  return impl_->list_hits(rays, radius, {}, options);
}
HitLists Tree::next_hits(const Rays& rays, const PerRay& radius, std::size_t k, const QueryOptions& options) const {
  return impl_->list_hits(rays, radius, k, options);
}

void Tree::all_hits(const Rays& rays, const PerRay& radius, const Sink& sink, const QueryOptions& options) const {
  constexpr std::size_t n_at_once = 1 << 16;  // rays
  if (!sink) throw InputError("the sink is empty; expected a function");
  impl_->check(rays, radius, options);
  const std::size_t n = rays.size();
  for (std::size_t first = 0; first < n; first += n_at_once) {
    const std::size_t n_part = std::min(n_at_once, n - first);
    const auto part_of = [=](const PerRay& of) {
      return of.values().size() == n ? PerRay(of.values().subspan(first, n_part)) : of;
    };
    const Rays part{rays.origins.subspan(first, n_part), rays.directions.subspan(first, n_part), part_of(rays.t_min),
                    part_of(rays.t_max)};
    QueryOptions of_part = options;
    if (options.progress)
      of_part.progress = [&](double done) {
        return options.progress((double(first) + done * double(n_part)) / double(n));
      };
    const HitLists lists = all_hits(part, part_of(radius), of_part);
    for (std::size_t i = 0; i < n_part; ++i) sink(first + i, lists[i]);
  }
}

TreeFacts Tree::facts() const { return impl_->facts(); }
std::size_t Tree::size() const { return impl_->size(); }
void Tree::save(const std::string& path) const { detail::write_tree(*impl_, path); }

Tree build(std::span<const Segment> segments, const BuildOptions& options) {
  return Tree(detail::current_engine().build_segments(segments, options));
}
Tree build(std::span<const RoundCone> cones, const BuildOptions& options) {
  return Tree(detail::current_engine().build_cones(cones, options));
}
Tree load(const std::string& path) { return Tree(detail::read_tree(path)); }

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
