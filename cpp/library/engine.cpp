// The engine of one instruction set: builds trees, and restores them from files.
#include "engine.hpp"

#include <cmath>
#include <cstring>

#include "fastlines/tree/usable.hpp"
#include "method_settings.hpp"
#include "settings_json.hpp"
#include "tree_of.hpp"

namespace fl::detail {
namespace {

using fastlines::RoundCones;
using fastlines::Segments;

/// Beyond this, squares of coordinates would overflow in the builder.
constexpr float kCoordinateLimit = 1e30f;

bool is_valid(const Vec3& v) {
  return std::fabs(v.x) <= kCoordinateLimit && std::fabs(v.y) <= kCoordinateLimit && std::fabs(v.z) <= kCoordinateLimit;
}
bool is_valid(float radius) { return radius >= 0 && radius <= kCoordinateLimit; }

/// Copies lines into the core's form. Throws InputError for the first one that cannot be used.
template <class To, class From>
std::vector<To> checked_copy(std::span<const From> lines) {
  if (!lines.data() && !lines.empty())
    throw InputError("the array of lines is null; expected a pointer to " + std::to_string(lines.size()) + " lines");
  if (lines.size() > kMaxRefs)
    throw InputError(std::to_string(lines.size()) + " lines are more than a tree can index; build several trees");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto fail = [&](const char* what) { throw InputError("line " + std::to_string(i) + " has " + what); };
    if (!is_valid(lines[i].p) || !is_valid(lines[i].q)) fail("a coordinate that is not a number from −1e30 to 1e30");
    if constexpr (std::is_same_v<From, RoundCone>)
      if (!is_valid(lines[i].radius_p) || !is_valid(lines[i].radius_q))
        fail("a radius that is not a number from 0 to 1e30");
  }
  const auto from = view_as<To>(lines);
  return {from.begin(), from.end()};
}

/// The axes of lines, which trees are over.
std::vector<fastlines::Segment> axes_of(std::span<const fastlines::RoundCone> cones) {
  std::vector<fastlines::Segment> axes;
  axes.reserve(cones.size());
  for (const auto& cone : cones) axes.push_back(cone.axis);
  return axes;
}
std::span<const fastlines::Segment> axes_of(std::span<const fastlines::Segment> segments) { return segments; }

template <class P, class Line>
TreePointer build(std::span<const Line> lines, const BuildOptions& options) {
  using Item = typename P::Item;
  fastlines::Settings settings = method_settings(options, lines.size());
  std::vector<Item> items = checked_copy<Item>(lines);
  settings.n_threads = n_threads_of(options.n_threads);
  TreeOrigin origin{method_name(options.method), settings.cost.c_trav,
                    settings.cost.c_prim,        settings.boxes == fastlines::BoxRule::cut,
                    json_of(settings),           {}};
  TreePointer built;
  watch(options.progress, [&](fastlines::Progress& progress) {
    fastlines::Tree tree;
    {
      const auto axes = axes_of(std::span<const Item>(items));
      const Segments prims{axes};
      fastlines::Builder<Segments> builder(prims, settings, progress);
      tree = builder.build();
      origin.limits_hit = json_of(builder.limits_hit());
    }
    built =
        std::make_shared<TreeOf<P>>(std::move(items), std::move(tree), std::move(origin), settings.n_threads, progress);
  });
  return built;
}

template <class Row>
fastlines::LargeVector<Row> rows_of(std::span<const std::uint32_t> words) {
  fastlines::LargeVector<Row> rows(words.size() * 4 / sizeof(Row));
  if (!rows.empty()) std::memcpy(static_cast<void*>(rows.data()), words.data(), rows.size() * sizeof(Row));
  return rows;
}

template <class P, class Line>
TreePointer restore(std::span<const Line> lines, const TreeArrays& arrays, const TreeOrigin& origin) {
  using Item = typename P::Item;
  std::vector<Item> items = checked_copy<Item>(lines);
  fastlines::Tree tree{rows_of<fastlines::Node>(arrays.nodes), rows_of<fastlines::Reference>(arrays.refs)};
  fastlines::Progress progress;
  {
    const auto axes = axes_of(std::span<const Item>(items));
    const auto rule = origin.is_cut ? fastlines::BoxRule::cut : fastlines::BoxRule::tight;
    if (const auto found = fastlines::check_usable(Segments{axes}, tree.nodes, tree.refs, rule, progress))
      throw InputError("node " + std::to_string(found->node) + " violates " + found->axiom + ": " + found->detail);
  }
  return std::make_shared<TreeOf<P>>(std::move(items), std::move(tree), origin, n_threads_of(0), progress);
}

TreePointer build_segments(std::span<const Segment> segments, const BuildOptions& options) {
  return build<Segments>(segments, options);
}
TreePointer build_cones(std::span<const RoundCone> cones, const BuildOptions& options) {
  return build<RoundCones>(cones, options);
}
TreePointer restore_tree(const TreeArrays& arrays, const TreeOrigin& origin) {
  return arrays.has_radius ? restore<RoundCones>(arrays.cones, arrays, origin)
                           : restore<Segments>(arrays.segments, arrays, origin);
}

constexpr Engine kEngine{fastlines::kSimd, build_segments, build_cones, restore_tree};

}  // namespace
}  // namespace fl::detail

/// The only symbol that the objects of an instruction set export.
extern "C" const fl::detail::Engine* FASTLINES_ENGINE() { return &fl::detail::kEngine; }
