// Checks of a tree (what queries rely on, and the axioms of the theory) and of a layout, and the cost of a tree.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "core.hpp"
#include "fastlines/layout/check_layout.hpp"
#include "fastlines/tree/cost.hpp"
#include "fastlines/tree/validate.hpp"
#include "layout.hpp"
#include "primitives.hpp"
#include "settings.hpp"
#include "tree.hpp"

namespace nb = nanobind;
using namespace nb::literals;

namespace fastlines {
namespace {

/// The first violation, if there is one: node, axiom and detail.
using ViolationTuple = std::optional<std::tuple<std::size_t, std::string, std::string>>;

ViolationTuple tuple_of(const std::optional<Violation>& found) {
  if (!found) return {};
  return std::make_tuple(found->node, found->axiom, found->detail);
}

/// Checks what queries rely on.
ViolationTuple check(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes, Input<std::uint32_t> refs,
                     const std::string& boxes) {
  std::optional<Violation> found;
  const auto all_nodes = rows<Node>(nodes);
  const auto all_refs = rows<Reference>(refs);
  const BoxRule rule = box_rule(boxes);
  watch_if(all_nodes.size() + all_refs.size() > kLongPass, nb::none(), [&](const Progress& watched) {
    with_primitives(kind, data,
                    [&](const auto& prims) { found = check_usable(prims, all_nodes, all_refs, rule, watched); });
  });
  return tuple_of(found);
}

/// Checks all axioms; with `pieces`, those of a tree over pieces of lines, as presplit, reinsertion and refits make.
ViolationTuple validate_tree(const std::string& kind, Input<float> data, Input<std::uint32_t> nodes,
                             Input<std::uint32_t> refs, const std::string& boxes, bool pieces) {
  std::optional<Violation> found;
  const BoxRule rule = box_rule(boxes);
  watch(
      [&](const Progress& watched) {
        with_primitives(kind, data, [&]<class P>(const P& prims) {
          const auto all_nodes = rows<Node>(nodes);
          const auto all_refs = rows<Reference>(refs);
          if constexpr (Straight<P>) {
            if (pieces) {
              found = validate_pieces(prims, all_nodes, all_refs, rule, watched);
              return;
            }
          }
          found = validate(prims, all_nodes, all_refs, rule, watched);
        });
      },
      nb::none());
  return tuple_of(found);
}

/// What is wrong with a layout, if anything is.
std::optional<std::string> check_wide(const LayoutView& layout) {
  std::optional<std::string> found;
  watch_if(layout.nodes.size() + layout.refs.size() > kLongPass, nb::none(), [&](const Progress& watched) {
    std::visit(
        [&](const auto& prims) { found = check_layout(layout.nodes, layout.leaves, layout.refs, prims, watched); },
        layout.prims);
  });
  return found;
}

double cost(Input<std::uint32_t> nodes, double c_trav, double c_prim) {
  const WithoutGil without_gil;
  return cost_of(rows<Node>(nodes), c_trav, c_prim);
}

}  // namespace

void bind_checks(nb::module_& m) {
  m.attr("MAX_DEPTH") = kMaxDepth;
  m.def("check", &check, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(), "boxes"_a);
  m.def("validate", &validate_tree, "kind"_a, "data"_a.noconvert(), "nodes"_a.noconvert(), "refs"_a.noconvert(),
        "boxes"_a, "pieces"_a);
  m.def("check_layout", &check_wide, "layout"_a);
  m.def("cost", &cost, "nodes"_a.noconvert(), "c_trav"_a, "c_prim"_a);
}

}  // namespace fastlines
