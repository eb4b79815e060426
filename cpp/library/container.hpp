// The container of tree files, which is that of safetensors: 8 bytes with the length of the header, the header as JSON,
// then the bytes of all sections without gaps. src/fastlines/support/container.py explains it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace fl::detail {

using Bytes = std::span<const std::byte>;
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// An array, by its name.
struct Section {
  std::string name, dtype, shape;  ///< as in the header; numbers of the shape are apart by ", "
  Bytes bytes;
};

/// The size of a number of this type. Throws std::runtime_error for an unknown one.
std::size_t item_size(const std::string& dtype);

/// A shape as headers have it.
std::string shape_of(std::initializer_list<std::size_t> sides);

/// The content of a file.
struct Container {
  Metadata metadata;
  std::vector<Section> sections;

  /// The section with this name, or nullptr.
  const Section* find(const std::string& name) const;
  /// The metadata with this name, or an empty text.
  std::string text(const std::string& name) const;
};

/// Split a file into its sections, which point into it; the last one has its checksums. Throws std::runtime_error where
/// it contradicts its header.
Container split(Bytes file);

/// Verify the checksums of a file that was split, and remove their section. Throws std::runtime_error.
void verify(Bytes file, Container& content);

/// The parts of a file in their order: its header, and what follows.
class ContainerFile {
 public:
  /// Lays out sections, which must stay valid, and computes their checksums. Throws std::length_error if the header is
  /// too long to be read.
  explicit ContainerFile(const Container& content);

  std::vector<Bytes> parts() const;

 private:
  std::string header_;
  std::vector<Bytes> sections_;
  std::vector<std::uint32_t> checksums_;
};

}  // namespace fl::detail
