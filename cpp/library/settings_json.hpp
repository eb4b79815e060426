// The settings of a tree as its file keeps them: JSON, with the names that Python's `Settings` has. Settings at their
// defaults are left out.
#pragma once

#include <locale>
#include <sstream>
#include <string>

#include "fastlines/build/settings.hpp"

namespace fl::detail {

inline std::string json_of(const fastlines::SplitSet& set) {
  std::ostringstream text;
  text.imbue(std::locale::classic());  // a program may have set another one
  if (const auto* planes = std::get_if<fastlines::BinnedPlanes>(&set))
    text << R"({"name": "binned_planes", "n_planes": )" << planes->n_planes << R"(, "uncut_refs": )"
         << planes->uncut_refs << R"(, "uncut_only_refs": )" << planes->uncut_only_refs << R"(, "max_overlap": )"
         << planes->max_overlap << R"(, "sample": )" << planes->sample << R"(, "gap_refs": )" << planes->gap_refs
         << R"(, "gap": )" << planes->gap << R"(, "uncut_only_side": )" << planes->uncut_only_side << "}";
  else if (const auto* grid = std::get_if<fastlines::PlaneGrid>(&set))
    text << R"({"name": "plane_grid", "n_planes": )" << grid->n_planes << "}";
  else if (std::holds_alternative<fastlines::ObjectSweep>(set))
    text << R"({"name": "object_sweep"})";
  else
    throw std::logic_error("no named tree has this split set");
  return text.str();
}

inline std::string json_of(const fastlines::Settings& settings) {
  std::ostringstream text;
  text.imbue(std::locale::classic());  // a program may have set another one
  text << R"({"splits": [)" << json_of(settings.splits.at(0).set) << R"(], "boxes": )"
       << (settings.boxes == fastlines::BoxRule::cut ? R"("cut")" : R"("tight")") << R"(, "lookahead": [)";
  for (std::size_t i = 0; i < settings.lookahead.size(); ++i) text << (i ? ", " : "") << settings.lookahead[i];
  text << R"(], "cost": {"c_trav": )" << settings.cost.c_trav << R"(, "c_prim": )" << settings.cost.c_prim
       << R"(}, "limits": {)";
  if (settings.limits.max_leaf_refs != std::size_t(-1))
    text << R"("max_leaf_refs": )" << settings.limits.max_leaf_refs << ", ";
  text << R"("leaf_refs": )" << settings.limits.leaf_refs << R"(}, "bad_levels": )" << settings.bad_levels
       << R"(, "prune": )" << (settings.prune ? "true" : "false") << R"(, "radius_hint": )" << settings.radius_hint
       << R"(, "min_spread": )" << settings.min_spread << R"(, "lanes": )" << settings.lanes << "}";
  return text.str();
}

inline std::string json_of(const fastlines::LimitsHit& hit) {
  std::string text = "{";
  const auto add = [&](const char* name, std::size_t n) {
    if (n) text += (text.size() > 1 ? ", \"" : "\"") + std::string(name) + "\": " + std::to_string(n);
  };
  add("max_depth", hit.depth);
  add("max_refs", hit.refs);
  add("max_leaf_refs", hit.leaf_refs);
  return text + "}";
}

}  // namespace fl::detail
