// What the metadata of a tree file say of coordinates.
#pragma once

#include <array>
#include <optional>

#include "fastlines/api/ray.hpp"
#include "json.hpp"

namespace fl::detail {

/// The offset in the metadata of the lines, which Python has subtracted from their coordinates.
inline Vec3d offset_in(const std::string& metadata) {
  if (metadata.find("\"offset\"") == std::string::npos) return {};
  const Json all = Json::parse(metadata);
  const Json* const offset = all.find("offset");
  if (!offset || offset->kind == Json::Kind::null) return {};
  const std::vector<Json>& sides = offset->as_array();
  if (sides.size() != 3) throw std::runtime_error("the offset of its lines is not three numbers");
  return {sides[0].as_number(), sides[1].as_number(), sides[2].as_number()};
}

/// The box whose frame queries compute in, from the metadata of a tree.
inline std::optional<std::array<float, 6>> frame_in(const std::string& metadata) {
  if (metadata.empty()) return {};
  std::array<float, 6> frame;
  const Json parsed = Json::parse(metadata);
  const std::vector<Json>& corners = parsed.as_array();
  if (corners.size() != 2) throw std::runtime_error("its frame is not two corners");
  for (std::size_t i = 0; i < 6; ++i) {
    const std::vector<Json>& corner = corners[i / 3].as_array();
    if (corner.size() != 3) throw std::runtime_error("a corner of its frame is not three numbers");
    frame[i] = float(corner[i % 3].as_number());
  }
  return frame;
}

}  // namespace fl::detail
