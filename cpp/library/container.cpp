// Splits files and lays them out.
#include "container.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>

#include "json.hpp"

namespace fl::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "tree files are little-endian");

constexpr std::size_t kAlignment = 64, kMaxHeader = 1 << 20;
constexpr const char *kMetadata = "__metadata__", *kChecksums = "crc32";

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

/// The length of the header of a file. Throws std::runtime_error.
std::size_t header_length(Bytes file) {
  std::uint64_t length = 0;
  if (file.size() >= 8) std::memcpy(&length, file.data(), 8);
  if (file.size() < 8 || length > std::min(kMaxHeader, file.size() - 8) || (8 + length) % kAlignment)
    throw std::runtime_error("it does not begin like one");
  return std::size_t(length);
}

}  // namespace

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

const Section* Container::find(const std::string& name) const {
  for (const Section& section : sections)
    if (section.name == name) return &section;
  return nullptr;
}

std::string Container::text(const std::string& name) const {
  for (const auto& [key, value] : metadata)
    if (key == name) return value;
  return {};
}

Container split(Bytes file) {
  const std::size_t length = header_length(file);
  const Json header = Json::parse({reinterpret_cast<const char*>(file.data()) + 8, length});
  const Bytes body = file.subspan(8 + length);
  Container content;
  for (const auto& [name, value] : header.at(kMetadata).members) content.metadata.emplace_back(name, value.as_string());
  std::size_t position = 0;
  for (const auto& [name, value] : header.members) {
    if (name == kMetadata) continue;
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
    content.sections.push_back({name, dtype, sides + "]", body.subspan(position, end - position)});
    position = end;
  }
  if (position != body.size()) throw std::runtime_error("it has more bytes than its header promises");
  return content;
}

void verify(Bytes file, Container& content) {
  const Section* const sums = content.find(kChecksums);
  if (!sums) throw std::runtime_error("it has no checksums");
  if (sums != &content.sections.back() || sums->bytes.size() != 4 * content.sections.size())
    throw std::runtime_error("its checksums are not one for the header and each section before");
  for (std::size_t i = 0; i < content.sections.size(); ++i) {
    const Bytes part = i == 0 ? file.first(8 + header_length(file)) : content.sections[i - 1].bytes;
    std::uint32_t expected;
    std::memcpy(&expected, sums->bytes.data() + 4 * i, 4);
    if (checksum_of(part) != expected)
      throw std::runtime_error("it has changed since it was written: the checksum of its " +
                               (i == 0 ? "header" : content.sections[i - 1].name) + " differs");
  }
  content.sections.pop_back();
}

ContainerFile::ContainerFile(const Container& content) : checksums_(content.sections.size() + 1) {
  header_ += '{';
  header_ += json_string(kMetadata) + ": {";
  for (const auto& [name, text] : content.metadata)
    header_ += (header_.back() == '{' ? "" : ", ") + json_string(name) + ": " + json_string(text);
  header_ += "}";
  std::size_t position = 0;
  const auto describe = [&](const Section& section) {
    const std::size_t end = position + section.bytes.size();
    header_ += ", " + json_string(section.name) + ": {\"dtype\": " + json_string(section.dtype) +
               ", \"shape\": " + section.shape + ", \"data_offsets\": " + shape_of({position, end}) + "}";
    position = end;
  };
  for (const Section& section : content.sections) describe(section);
  describe({kChecksums, "U8", shape_of({checksums_.size(), 4}), std::as_bytes(std::span(checksums_))});
  header_ += "}";
  header_.append((kAlignment - (8 + header_.size()) % kAlignment) % kAlignment, ' ');
  if (header_.size() > kMaxHeader) throw std::length_error("the names of its sections are too long; shorten them");
  const std::uint64_t length = header_.size();
  header_.insert(0, reinterpret_cast<const char*>(&length), 8);

  for (const Section& section : content.sections) sections_.push_back(section.bytes);
  checksums_[0] = checksum_of(std::as_bytes(std::span(header_)));
  for (std::size_t i = 0; i < sections_.size(); ++i) checksums_[i + 1] = checksum_of(sections_[i]);
}

std::vector<Bytes> ContainerFile::parts() const {
  std::vector<Bytes> parts{std::as_bytes(std::span(header_))};
  parts.insert(parts.end(), sections_.begin(), sections_.end());
  parts.push_back(std::as_bytes(std::span(checksums_)));
  return parts;
}

}  // namespace fl::detail
