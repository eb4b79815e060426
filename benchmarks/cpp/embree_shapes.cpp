// Embree's cubic curves, spheres and triangles: the buffers of shapes that are not made of segments.
#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "embree_scene.hpp"

namespace fastlines::peers {
namespace {

/// x, y, z and radius.
using Point4 = std::array<float, 4>;

/// The control points of a cubic Bezier curve.
using Cubic = std::array<Point4, 4>;

Point4 middle(const Point4& a, const Point4& b) {
  Point4 found;
  for (int k = 0; k < 4; ++k) found[k] = 0.5f * (a[k] + b[k]);
  return found;
}

/// Writes the points of 2^halvings parts, which share the point between them, and returns the end. The last point is
/// left to the caller. This is de Casteljau's algorithm.
Point4* write_parts(const Cubic& cubic, unsigned halvings, Point4* to) {
  if (halvings == 0) return std::copy(cubic.begin(), cubic.end() - 1, to);
  const Point4 a = middle(cubic[0], cubic[1]), b = middle(cubic[1], cubic[2]), c = middle(cubic[2], cubic[3]);
  const Point4 ab = middle(a, b), bc = middle(b, c), abc = middle(ab, bc);
  to = write_parts({cubic[0], a, ab, abc}, halvings - 1, to);
  return write_parts({abc, bc, c, cubic[3]}, halvings - 1, to);
}

/// A new buffer of Embree, of n values.
template <class Value>
Value* new_buffer(Geometry geometry, BufferType type, Format format, std::size_t n) {
  void* buffer = api().SetNewGeometryBuffer(geometry, type, 0, format, sizeof(Value), n);
  if (!buffer) throw std::runtime_error("Embree gives no buffer");
  return static_cast<Value*>(buffer);
}

}  // namespace

void Scene::add_cubics(Geometry geometry, std::span<const float> vertices) {
  const std::size_t n_curves = vertices.size() / 16, n_parts = std::size_t(1) << settings_.halvings;
  const std::size_t n_points = 3 * n_parts + 1;
  n_pieces_ = n_curves * n_parts;
  if (n_curves * n_points > std::numeric_limits<std::uint32_t>::max())
    throw std::runtime_error("too many curves for Embree");
  auto* points = new_buffer<Point4>(geometry, BufferType::vertex, Format::float4, n_curves * n_points);
  auto* index = new_buffer<std::uint32_t>(geometry, BufferType::index, Format::uint1, n_pieces_);
  for (std::size_t i = 0; i < n_curves; ++i) {
    Cubic cubic;
    std::memcpy(&cubic, vertices.data() + 16 * i, sizeof cubic);
    points = write_parts(cubic, settings_.halvings, points);
    *points++ = cubic[3];
    for (std::size_t j = 0; j < n_parts; ++j) *index++ = std::uint32_t(i * n_points + 3 * j);
  }
}

void Scene::add_spheres(Geometry geometry, std::span<const float> vertices) {
  n_pieces_ = vertices.size() / 4;
  auto* points = new_buffer<Point4>(geometry, BufferType::vertex, Format::float4, n_pieces_);
  std::memcpy(points, vertices.data(), vertices.size_bytes());
}

void Scene::add_triangles(Geometry geometry, std::span<const float> vertices, std::span<const std::uint32_t> index) {
  using Corner = std::array<float, 3>;
  using Triangle = std::array<std::uint32_t, 3>;
  n_pieces_ = index.size() / 3;
  auto* corners = new_buffer<Corner>(geometry, BufferType::vertex, Format::float3, vertices.size() / 3);
  auto* triangles = new_buffer<Triangle>(geometry, BufferType::index, Format::uint3, n_pieces_);
  std::memcpy(corners, vertices.data(), vertices.size_bytes());
  std::memcpy(triangles, index.data(), index.size_bytes());
}

}  // namespace fastlines::peers
