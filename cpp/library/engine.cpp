// The engine of one instruction set: builds trees, and restores them from files.
#include "engine.hpp"

#include <cstring>

#include "fastlines/tree/usable.hpp"
#include "method_settings.hpp"
#include "settings_json.hpp"
#include "tree_of.hpp"

namespace fl::detail {
namespace {

using fastlines::RoundCones;
using fastlines::Segments;

template <class P, class Line>
TreePointer build(std::span<const Line> lines, const BuildOptions& options) {
  using Item = typename P::Item;
  fastlines::Settings settings = method_settings(options, lines.size());
  std::vector<Item> items = checked_copy<Item>(lines);
  settings.n_threads = n_threads_of(options.n_threads);
  if (!options.strands.empty() && (options.strands.size() != items.size() || !options.strands.data()))
    throw InputError(std::to_string(options.strands.size()) + " strands, or a null array of them; expected one for " +
                     "each of " + std::to_string(items.size()) + " lines");
  TreeOrigin origin{method_name(options.method), settings.cost.c_trav,
                    settings.cost.c_prim,        settings.boxes == fastlines::BoxRule::cut,
                    json_of(settings),           {},
                    strands_of(options.strands)};
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
