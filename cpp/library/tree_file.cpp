// The file: 8 bytes with the length of the header, the header as JSON, then the bytes of all sections without gaps.
#include "tree_file.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "json.hpp"
#include "metadata.hpp"

namespace fl::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "tree files are little-endian");

constexpr const char* kFormat = "fastlines tree 2";
constexpr std::size_t kAlignment = 64, kMaxHeader = 1 << 20;

using Bytes = std::span<const std::byte>;

/// The checksum CRC-32 as zlib computes it, eight bytes at a time.
std::uint32_t checksum_of(Bytes bytes) {
  using Tables = std::array<std::array<std::uint32_t, 256>, 8>;
  static const Tables tables = [] {
    Tables made;
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t crc = i;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb8'8320 : 0);
      made[0][i] = crc;
    }
    for (int k = 1; k < 8; ++k)
      for (std::uint32_t i = 0; i < 256; ++i) made[k][i] = made[k - 1][i] >> 8 ^ made[0][made[k - 1][i] & 255];
    return made;
  }();
  std::uint32_t crc = 0xffff'ffff;
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    std::uint32_t words[2];
    std::memcpy(words, bytes.data(), sizeof words);
    words[0] ^= crc;
    crc = 0;
    for (int k = 0; k < 8; ++k) crc ^= tables[7 - k][words[k / 4] >> 8 * (k % 4) & 255];
  }
  for (const std::byte byte : bytes) crc = crc >> 8 ^ tables[0][(crc ^ std::uint32_t(byte)) & 255];
  return ~crc;
}

struct Section {
  std::string name, dtype, shape;
  Bytes bytes;
};

std::size_t item_size(const std::string& dtype) {
  for (const auto& [names, size] :
       {std::pair{"BOOL U8 I8", 1}, {"U16 I16 F16", 2}, {"U32 I32 F32", 4}, {"U64 I64 F64", 8}})
    if (std::string(" ").append(names).append(" ").find(" " + dtype + " ") != std::string::npos)
      return std::size_t(size);
  throw std::runtime_error("its header has an unknown type " + dtype);
}

std::string shape_of(std::initializer_list<std::size_t> sides) {
  std::string text = "[";
  for (const std::size_t side : sides) text += (text.size() > 1 ? ", " : "") + std::to_string(side);
  return text + "]";
}

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

/// The file that a path names, past symbolic links, whether it exists or not; nothing but a file may be replaced.
std::filesystem::path target_of(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int most_links = 40;  // as many as Linux follows
  std::error_code error;
  fs::path target = path;
  for (int i = 0; fs::is_symlink(fs::symlink_status(target, error)); ++i) {
    if (i == most_links) throw FileError(path + " is a loop of symbolic links; expected the path of a file to write");
    target = target.parent_path() / fs::read_symlink(target, error);
  }
  const fs::file_status status = fs::status(target, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw FileError(path + " is not a regular file; expected the path of a file to write");
  return target;
}

void write_file(const std::string& path, const std::vector<Bytes>& parts) {
  namespace fs = std::filesystem;
  constexpr std::size_t most_characters = 50;  // of its name, as file systems limit the length of names
  if (path.empty()) throw FileError("the path is empty; expected the path of a file to write");
  const fs::path target = target_of(path);
  const std::string name = target.filename().string().substr(0, most_characters);
  const fs::path partial = target.parent_path() / (name + "." + std::to_string(std::random_device{}()) + ".partial");
  std::ofstream file(partial, std::ios::binary);
  if (!file)
    throw FileError(path + " cannot be written; expected a path in a folder that exists and can be written to");
  // Keep the mode, before there is anything to read.
  std::error_code error;
  const fs::file_status before = fs::status(target, error);
  error.clear();
  if (fs::exists(before)) fs::permissions(partial, before.permissions() & fs::perms(0777), error);
  if (!error)
    for (const Bytes part : parts) file.write(reinterpret_cast<const char*>(part.data()), std::streamsize(part.size()));
  file.close();
  if (file && !error) fs::rename(partial, target, error);
  if (!file || error) {
    std::error_code ignored;
    fs::remove(partial, ignored);
    throw FileError(path + " cannot be written: " + (error ? error.message() : "the disk may be full"));
  }
}

/// What was read of a file; the sections point into `bytes`.
struct ReadFile {
  std::vector<std::byte> bytes;
  std::vector<Section> sections;
  std::vector<std::pair<std::string, std::string>> metadata;

  const Section* find(const std::string& name) const {
    for (const Section& section : sections)
      if (section.name == name) return &section;
    return nullptr;
  }
  std::string text(const std::string& name) const {
    for (const auto& [key, value] : metadata)
      if (key == name) return value;
    return {};
  }
};

std::vector<std::byte> bytes_in(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  std::ifstream file(path, std::ios::binary);
  if (error || !file) throw FileError(path + " cannot be read; expected the path of a tree file (.flt)");
  std::vector<std::byte> bytes(size);
  file.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size));
  if (!file) throw FileError(path + " cannot be read to its end");
  return bytes;
}

/// Split a file into its sections, and verify its checksums. Throws std::runtime_error.
ReadFile parse(std::vector<std::byte> bytes) {
  ReadFile file{std::move(bytes), {}, {}};
  const Bytes all = file.bytes;
  std::uint64_t length = 0;
  if (all.size() >= 8) std::memcpy(&length, all.data(), 8);
  if (all.size() < 8 || length > std::min(kMaxHeader, all.size() - 8) || (8 + length) % kAlignment)
    throw std::runtime_error("it does not begin like one");
  const Json header = Json::parse({reinterpret_cast<const char*>(all.data()) + 8, std::size_t(length)});
  const Bytes body = all.subspan(8 + std::size_t(length));
  for (const auto& [name, value] : header.at("__metadata__").members)
    file.metadata.emplace_back(name, value.as_string());
  std::size_t position = 0;
  for (const auto& [name, value] : header.members) {
    if (name == "__metadata__") continue;
    const std::string& dtype = value.at("dtype").as_string();
    const std::vector<Json>&shape = value.at("shape").as_array(), &offsets = value.at("data_offsets").as_array();
    double n_items = 1;
    std::string sides = "[";
    for (const Json& side : shape) {
      n_items *= double(side.as_size());
      sides += (sides.size() > 1 ? ", " : "") + std::to_string(side.as_size());
    }
    if (offsets.size() != 2 || offsets[0].as_size() != position || offsets[1].as_size() < position ||
        double(offsets[1].as_size() - position) != n_items * double(item_size(dtype)) ||
        position % item_size(dtype) != 0)
      throw std::runtime_error("the section \"" + name + "\" does not have the size of its array");
    const std::size_t end = offsets[1].as_size();
    if (end > body.size()) throw std::runtime_error("its header promises more bytes than it has");
    file.sections.push_back({name, dtype, sides + "]", body.subspan(position, end - position)});
    position = end;
  }
  if (position != body.size()) throw std::runtime_error("it has more bytes than its header promises");

  const std::string format = file.text("format");
  const Section* const sums = file.find("crc32");
  if (format != kFormat) throw std::runtime_error("its format is \"" + format + "\", expected \"" + kFormat + "\"");
  if (!sums) throw std::runtime_error("it has no checksums");
  if (sums != &file.sections.back() || sums->bytes.size() != 4 * file.sections.size())
    throw std::runtime_error("its checksums are not one for the header and each section before");
  for (std::size_t i = 0; i < file.sections.size(); ++i) {
    const Bytes part = i == 0 ? all.first(8 + std::size_t(length)) : file.sections[i - 1].bytes;
    std::uint32_t expected;
    std::memcpy(&expected, sums->bytes.data() + 4 * i, 4);
    if (checksum_of(part) != expected)
      throw std::runtime_error("it has changed since it was written: the checksum of its " +
                               (i == 0 ? "header" : file.sections[i - 1].name) + " differs");
  }
  file.sections.pop_back();
  return file;
}

/// The numbers of a section with rows of this shape. They are aligned, as sections begin at multiples of their items.
template <class T>
std::span<const T> rows(const ReadFile& file, const std::string& name, const std::string& dtype,
                        const std::string& row) {
  const Section* const section = file.find(name);
  if (!section || section->dtype != dtype || section->shape.find(row) != section->shape.find_first_of(",]"))
    throw std::runtime_error("the section \"" + name + "\" is missing or has another shape or type");
  return {reinterpret_cast<const T*>(section->bytes.data()), section->bytes.size() / sizeof(T)};
}

TreePointer restore(const ReadFile& file, const Engine& engine) {
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
  if (const std::string text = file.text("built_cost"); !text.empty()) built_cost = Json::parse(text).as_number();
  const Json settings = Json::parse(file.text("settings")), &cost = settings.at("cost");
  const TreeOrigin origin{.method = file.text("method"),
                          .c_trav = cost.at("c_trav").as_number(),
                          .c_prim = cost.at("c_prim").as_number(),
                          .is_cut = settings.at("boxes").as_string() == "cut",
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

void write_tree(const TreeImpl& tree, const std::string& path) {
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
  // Write larger numbers first, so that each section is aligned for its type.
  std::vector<Section> sections;
  for (const std::size_t size : {8, 4, 2, 1})
    std::ranges::copy_if(given, std::back_inserter(sections),
                         [&](const Section& section) { return item_size(section.dtype) == size; });

  std::string header =
      "{\"__metadata__\": {\"format\": " + json_string(kFormat) + ", \"method\": " + json_string(origin.method) +
      ", \"settings\": " + json_string(origin.settings) + ", \"limits_hit\": " + json_string(origin.limits_hit);
  if (origin.built_cost) header += ", \"built_cost\": " + json_string(json_number(*origin.built_cost));
  if (origin.rest)
    for (const auto& [name, text] : origin.rest->metadata)
      header += ", " + json_string(name) + ": " + json_string(text);
  header += "}";
  std::size_t position = 0;
  const auto describe = [&](const Section& section) {
    const std::size_t end = position + section.bytes.size();
    header += ", " + json_string(section.name) + ": {\"dtype\": " + json_string(section.dtype) +
              ", \"shape\": " + section.shape + ", \"data_offsets\": " + shape_of({position, end}) + "}";
    position = end;
  };
  for (const Section& section : sections) describe(section);
  std::vector<std::uint32_t> sums(sections.size() + 1);
  describe({"crc32", "U8", shape_of({sums.size(), 4}), bytes_of(std::span<const std::uint32_t>(sums))});
  header += "}";
  header.append((kAlignment - (8 + header.size()) % kAlignment) % kAlignment, ' ');
  if (header.size() > kMaxHeader) throw FileError(path + ": the names of its sections are too long; shorten them");
  const std::uint64_t length = header.size();
  header.insert(0, reinterpret_cast<const char*>(&length), 8);

  std::vector<Bytes> parts{bytes_of(std::span<const char>(header))};
  for (const Section& section : sections) parts.push_back(section.bytes);
  for (std::size_t i = 0; i < parts.size(); ++i) sums[i] = checksum_of(parts[i]);
  parts.push_back(bytes_of(std::span<const std::uint32_t>(sums)));
  write_file(path, parts);
}

TreePointer read_tree(const std::string& path) {
  const Engine& engine = current_engine();
  std::vector<std::byte> bytes = bytes_in(path);
  try {
    return restore(parse(std::move(bytes)), engine);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw FileError(path + " is not a usable tree file: " + error.what() + "; build and save the tree again");
  }
}

}  // namespace fl::detail
