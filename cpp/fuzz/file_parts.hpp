// The file of a tree, taken apart, so that its parts can be changed and put together again, with right checksums.
#pragma once

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "library/container.hpp"
#include "library/json.hpp"

namespace fastlines::fuzz {

using fl::detail::Bytes;

/// A section that owns its bytes.
struct FilePart {
  std::string name, dtype, shape;
  std::vector<std::byte> bytes;

  /// The size of a row in bytes; 0 if its shape has none.
  std::size_t row_size() const {
    const std::size_t rest = shape.find(',');
    std::size_t size = fl::detail::item_size(dtype);
    if (rest == std::string::npos) return size;
    for (const fl::detail::Json& side : fl::detail::Json::parse("[" + shape.substr(rest + 1)).items)
      size *= side.as_size();
    return size;
  }

  /// Let the shape have as many rows as there are.
  void count_rows() {
    const std::size_t size = std::max<std::size_t>(row_size(), 1), end = std::min(shape.find(','), shape.find(']'));
    bytes.resize(bytes.size() / size * size);
    if (end != std::string::npos && shape[0] == '[') shape.replace(1, end - 1, std::to_string(bytes.size() / size));
  }

  /// The bytes as rows of another type. They are whole rows, and aligned.
  template <class Row>
  std::span<Row> rows() {
    return {reinterpret_cast<Row*>(bytes.data()), bytes.size() / sizeof(Row)};
  }

  template <class Row>
  void assign(std::span<const Row> rows) {
    const Bytes from = std::as_bytes(rows);
    bytes.assign(from.begin(), from.end());
    count_rows();
  }
};

struct FileParts {
  fl::detail::Metadata metadata;
  std::vector<FilePart> parts;

  /// The parts of a file, or nothing if it contradicts its header. Its checksums are left out.
  static std::optional<FileParts> of(Bytes file) {
    try {
      FileParts apart;
      fl::detail::Container content = fl::detail::split(file);
      apart.metadata = std::move(content.metadata);
      for (const auto& [name, dtype, shape, bytes] : content.sections)
        if (name != "crc32") apart.parts.push_back({name, dtype, shape, {bytes.begin(), bytes.end()}});
      return apart;
    } catch (const std::runtime_error&) {
      return {};
    }
  }

  FilePart* find(std::string_view name) {
    const auto found = std::ranges::find(parts, name, &FilePart::name);
    return found == parts.end() ? nullptr : &*found;
  }

  std::string* text(std::string_view name) {
    const auto found = std::ranges::find(metadata, name, [](const auto& each) -> const auto& { return each.first; });
    return found == metadata.end() ? nullptr : &found->second;
  }

  /// The file of these parts.
  std::vector<std::byte> together() const {
    fl::detail::Container content{metadata, {}};
    for (const FilePart& part : parts) content.sections.push_back({part.name, part.dtype, part.shape, part.bytes});
    const fl::detail::ContainerFile laid_out(content);
    std::vector<std::byte> file;
    for (const Bytes part : laid_out.parts()) file.insert(file.end(), part.begin(), part.end());
    return file;
  }
};

}  // namespace fastlines::fuzz
