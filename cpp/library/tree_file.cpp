// What a tree file keeps, and the checks of a file that is read.
#include "tree_file.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <limits>

#include "json.hpp"
#include "metadata.hpp"
#include "whole_file.hpp"

namespace fl::detail {
namespace {

constexpr const char* kFormat = "fastlines tree 2";

template <class T>
Bytes bytes_of(std::span<const T> values) {
  return std::as_bytes(values);
}

/// The columns of round cones, which files keep apart.
struct ConeColumns {
  std::vector<Segment> segments;
  std::vector<float> radius;

  explicit ConeColumns(std::span<const RoundCone> cones) {
    for (const RoundCone& cone : cones) {
      segments.push_back({cone.p, cone.q});
      radius.insert(radius.end(), {cone.radius_p, cone.radius_q});
    }
  }
};

/// The numbers of a section with rows of this shape. They are aligned, as sections begin at multiples of their items.
template <class T>
std::span<const T> rows(const Container& file, const std::string& name, const std::string& dtype,
                        const std::string& row) {
  const Section* const section = file.find(name);
  if (!section || section->dtype != dtype || section->shape.find(row) != section->shape.find_first_of(",]"))
    throw std::runtime_error("the section \"" + name + "\" is missing or has another shape or type");
  return {reinterpret_cast<const T*>(section->bytes.data()), section->bytes.size() / sizeof(T)};
}

/// A cost from the header: with others, the costs of trees could not be compared.
double checked_cost(const char* name, const Json& cost, double least, double most) {
  if (!(least <= cost.as_number() && cost.number <= most)) {
    char text[128];
    std::snprintf(text, sizeof text, "its header has %s = %g; expected a number from %g to %g", name, cost.number,
                  least, most);
    throw std::runtime_error(text);
  }
  return cost.number;
}

TreePointer restore(const Container& file, const Engine& engine) {
  if (const std::string kind = file.text("kind"); !kind.empty())
    throw std::runtime_error("it is over " + kind + "; this library reads trees over Lines, and Python reads others");
  TreeArrays arrays;
  arrays.nodes = rows<std::uint32_t>(file, "nodes", "U32", ", 9]");
  arrays.refs = rows<std::uint32_t>(file, "refs", "U32", ", 3]");
  arrays.segments = rows<Segment>(file, "segments", "F32", ", 2, 3]");
  const std::size_t n = arrays.segments.size();
  std::vector<RoundCone> cones;
  arrays.has_radius = file.find("radius") != nullptr;
  if (arrays.has_radius) {
    const bool two = file.find("radius")->shape.find(',') != std::string::npos;
    const auto radius = rows<float>(file, "radius", "F32", two ? ", 2]" : "]");
    if (radius.size() != (two ? 2 * n : n)) throw std::runtime_error("its radii are not one, or two, for each line");
    for (std::size_t i = 0; i < n; ++i)
      cones.push_back(
          {arrays.segments[i].p, arrays.segments[i].q, radius[two ? 2 * i : i], radius[two ? 2 * i + 1 : i]});
    arrays.cones = cones;
  }
  const auto strands = rows<std::int64_t>(file, "strands", "I64", "]");
  if (strands.size() != n) throw std::runtime_error("its strands are not one for each line");
  auto rest = std::make_shared<FileRest>();
  const std::initializer_list<std::string_view> used{"nodes", "refs", "segments", "radius", "strands"};
  // A layout is made anew, and not saved again.
  for (const Section& section : file.sections)
    if (std::ranges::find(used, section.name) == used.end() && !section.name.starts_with("layout/"))
      rest->sections.push_back(
          {section.name, section.dtype, section.shape, {section.bytes.begin(), section.bytes.end()}});
  for (const auto& [name, text] : file.metadata)
    if (name != "format" && name != "method" && name != "settings" && name != "limits_hit" && name != "built_cost" &&
        name != "layout")
      rest->metadata.emplace_back(name, text);
  std::optional<double> built_cost;
  if (const std::string text = file.text("built_cost"); !text.empty())
    built_cost = checked_cost("built_cost", Json::parse(text), 0.0, std::numeric_limits<double>::max());
  const Json settings = Json::parse(file.text("settings")), &cost = settings.at("cost");
  if (Json::parse(file.text("limits_hit")).kind != Json::Kind::object)
    throw std::runtime_error("its header does not say which limits were hit");
  const std::string& boxes = settings.at("boxes").as_string();
  if (boxes != "cut" && boxes != "tight") throw std::runtime_error("its boxes are neither cut nor tight");
  const TreeOrigin origin{.method = file.text("method"),
                          .c_trav = checked_cost("c_trav", cost.at("c_trav"), 1e-100, 1e100),
                          .c_prim = checked_cost("c_prim", cost.at("c_prim"), 1e-100, 1e100),
                          .is_cut = boxes == "cut",
                          .settings = file.text("settings"),
                          .limits_hit = file.text("limits_hit"),
                          .strands = strands_of(strands),
                          .offset = offset_in(file.text("metadata")),
                          .built_cost = built_cost,
                          .rest = std::move(rest),
                          .frame = frame_in(file.text("frame"))};
  return engine.restore(arrays, origin);
}

}  // namespace

void write_tree(const TreeImpl& tree, const std::function<void(const std::vector<Bytes>&)>& write) {
  const TreeOrigin& origin = tree.origin();
  const TreeArrays arrays = tree.arrays();
  const std::size_t n = tree.size();
  const ConeColumns columns(arrays.cones);
  std::vector<std::int64_t> strands = origin.strands;
  strands.resize(n, -1);
  std::vector<Section> given;
  if (origin.rest)
    for (const auto& [name, dtype, shape, bytes] : origin.rest->sections) given.push_back({name, dtype, shape, bytes});
  given.push_back({"strands", "I64", shape_of({n}), bytes_of(std::span<const std::int64_t>(strands))});
  given.push_back({"nodes", "U32", shape_of({arrays.nodes.size() / 9, 9}), bytes_of(arrays.nodes)});
  given.push_back({"refs", "U32", shape_of({arrays.refs.size() / 3, 3}), bytes_of(arrays.refs)});
  const std::span<const Segment> segments = arrays.has_radius ? std::span(columns.segments) : arrays.segments;
  given.push_back({"segments", "F32", shape_of({n, 2, 3}), bytes_of(segments)});
  if (arrays.has_radius) given.push_back({"radius", "F32", shape_of({n, 2}), bytes_of(std::span(columns.radius))});
  Container content;
  // Write larger numbers first, so that each section is aligned for its type.
  for (const std::size_t size : {8, 4, 2, 1})
    std::ranges::copy_if(given, std::back_inserter(content.sections),
                         [&](const Section& section) { return item_size(section.dtype) == size; });

  content.metadata = {
      {"format", kFormat}, {"method", origin.method}, {"settings", origin.settings}, {"limits_hit", origin.limits_hit}};
  if (origin.built_cost) content.metadata.emplace_back("built_cost", json_number(*origin.built_cost));
  if (origin.rest)
    content.metadata.insert(content.metadata.end(), origin.rest->metadata.begin(), origin.rest->metadata.end());
  write(ContainerFile(content).parts());
}

TreePointer read_tree(Bytes file, const Engine& engine) {
  Container content = split(file);
  if (const std::string format = content.text("format"); format != kFormat)
    throw std::runtime_error("its format is \"" + format + "\", expected \"" + kFormat + "\"");
  verify(file, content);
  return restore(content, engine);
}

void save_tree(const TreeImpl& tree, const std::string& path) {
  try {
    write_tree(tree, [&](const std::vector<Bytes>& parts) { write_file(path, parts); });
  } catch (const std::length_error& error) {
    throw FileError(path + ": " + error.what());
  }
}

TreePointer load_tree(const std::string& path) {
  const Engine& engine = current_engine();
  const std::vector<std::byte> file = read_file(path);
  try {
    return read_tree(file, engine);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw FileError(path + " is not a usable tree file: " + error.what() + "; build and save the tree again");
  }
}

}  // namespace fl::detail
