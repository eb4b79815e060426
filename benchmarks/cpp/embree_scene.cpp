// Builds Embree scenes.
#include "embree_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace fastlines::peers {
namespace {

constexpr std::size_t kMaxPieces = 65535;

float length_of(const SegmentEnds& segment) {
  float sum = 0.0f;
  for (int k = 0; k < 3; ++k) sum += (segment.q[k] - segment.p[k]) * (segment.q[k] - segment.p[k]);
  return std::sqrt(sum);
}

float point(const SegmentEnds& segment, int k, float s) {
  return s == 1.0f ? segment.q[k] : segment.p[k] + s * (segment.q[k] - segment.p[k]);
}

/// The box of the capsule of a piece, enlarged by slightly more than the rounding error.
void bounds_of_piece(const BoundsArguments* args) {
  const auto& scene = *static_cast<const Scene*>(args->user);
  const Piece& piece = scene.pieces()[args->prim];
  const float radius = scene.settings().radius * 1.00001f;
  const float s0 = float(piece.owner.k) / piece.owner.m, s1 = float(piece.owner.k + 1) / piece.owner.m;
  for (int k = 0; k < 3; ++k) {
    const float a = piece.p[k] + s0 * piece.e[k], b = piece.p[k] + s1 * piece.e[k];
    const float grow = radius + std::ldexp(std::max(std::abs(a), std::abs(b)) + std::abs(piece.e[k]), -20);
    args->bounds->lo[k] = std::min(a, b) - grow;
    args->bounds->hi[k] = std::max(a, b) + grow;
  }
}

bool count_bytes(void* user, std::ptrdiff_t bytes, bool) {
  static_cast<std::atomic<std::ptrdiff_t>*>(user)->fetch_add(bytes);
  return true;
}

void keep_error(void* user, int, const char* text) {
  auto& error = *static_cast<std::string*>(user);
  if (error.empty()) error = text;
}

GeometryType type_of(Kind kind) {
  switch (kind) {
    case Kind::user:
      return GeometryType::user;
    case Kind::flat:
      return GeometryType::flat_linear_curve;
    case Kind::round:
      return GeometryType::round_linear_curve;
    case Kind::bezier:
      return GeometryType::round_bezier_curve;
    case Kind::sphere:
      return GeometryType::sphere_point;
    default:
      return GeometryType::triangle;
  }
}

}  // namespace

Scene::Scene(const SceneInput& input, const SceneSettings& settings, const Callbacks& callbacks)
    : radius(settings.radius), settings_(settings) {
  const Api& rtc = api();
  try {
    device_ = rtc.NewDevice(settings.device.c_str());
    if (!device_) throw std::runtime_error("Embree gives no device for \"" + settings.device + "\"");
    rtc.SetDeviceErrorFunction(device_, keep_error, &error_);
    rtc.SetDeviceMemoryMonitorFunction(device_, count_bytes, &allocated_);
    scene_ = rtc.NewScene(device_);
    rtc.SetSceneBuildQuality(scene_, settings.quality);
    if (settings.compact) rtc.SetSceneFlags(scene_, kCompact);

    const Geometry geometry = rtc.NewGeometry(device_, type_of(settings.kind));
    rtc.SetGeometryBuildQuality(geometry, settings.quality);
    add(geometry, input, callbacks);
    if (settings.kind != Kind::user) rtc.SetGeometryEnableFilterFunctionFromArguments(geometry, true);
    rtc.CommitGeometry(geometry);
    rtc.AttachGeometry(scene_, geometry);
    rtc.ReleaseGeometry(geometry);
    rtc.CommitScene(scene_);
    std::vector<std::uint16_t>().swap(n_cuts_);
    if (!error_.empty()) throw std::runtime_error("Embree: " + error_);
  } catch (...) {
    release();
    throw;
  }
}

Scene::~Scene() { release(); }

void Scene::release() {
  if (scene_) api().ReleaseScene(scene_);
  if (device_) api().ReleaseDevice(device_);
  scene_ = nullptr;
  device_ = nullptr;
}

std::size_t Scene::bytes() const {
  return std::size_t(allocated_.load()) + pieces_.size() * sizeof(Piece) + owners_.size() * sizeof(Owner);
}

bool Scene::is_native(int width) const {
  return width == 1 || api().GetDeviceProperty(device_, width == 8 ? kNative8 : kNative16) != 0;
}

void Scene::add(Geometry geometry, const SceneInput& input, const Callbacks& callbacks) {
  if (is_of_segments(settings_.kind)) cut(input.segments);
  switch (settings_.kind) {
    case Kind::user:
      return add_user(geometry, callbacks);
    case Kind::flat:
    case Kind::round:
      return add_curves(geometry, input.segments, input.radii);
    case Kind::ribbon:
      return add_ribbons(geometry, input.segments);
    case Kind::bezier:
      return add_cubics(geometry, input.vertices);
    case Kind::sphere:
      return add_spheres(geometry, input.vertices);
    case Kind::triangle:
      return add_triangles(geometry, input.vertices, input.index);
  }
}

/// Chooses the number of pieces of each segment and stores the owner of each piece.
void Scene::cut(std::span<const SegmentEnds> segments) {
  constexpr float inf = std::numeric_limits<float>::infinity();
  box_ = {{inf, inf, inf}, 0, {-inf, -inf, -inf}, 0};
  std::size_t n_pieces = 0;
  n_cuts_.resize(segments.size());
  for (std::size_t i = 0; i < segments.size(); ++i) {
    std::size_t n = 1;
    if (settings_.piece_length > 0)
      n = std::size_t(
          std::clamp(std::ceil(double(length_of(segments[i])) / settings_.piece_length), 1.0, double(kMaxPieces)));
    n_cuts_[i] = std::uint16_t(n);
    n_pieces += n;
    for (int k = 0; k < 3; ++k) {
      box_.lo[k] = std::min({box_.lo[k], segments[i].p[k], segments[i].q[k]});
      box_.hi[k] = std::max({box_.hi[k], segments[i].p[k], segments[i].q[k]});
    }
  }
  if (n_pieces > std::numeric_limits<std::uint32_t>::max() / 4) throw std::runtime_error("too many pieces for Embree");
  n_pieces_ = n_pieces;
  const bool user = settings_.kind == Kind::user;
  user ? pieces_.reserve(n_pieces) : owners_.reserve(n_pieces);
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::uint32_t j = 0; j < n_cuts_[i]; ++j) {
      const Owner owner{std::uint32_t(i), std::uint16_t(j), n_cuts_[i]};
      if (!user) {
        owners_.push_back(owner);
        continue;
      }
      Piece piece;
      for (int k = 0; k < 3; ++k) {
        piece.p[k] = segments[i].p[k];
        piece.e[k] = segments[i].q[k] - segments[i].p[k];
      }
      piece.owner = owner;
      pieces_.push_back(piece);
    }
}

void Scene::add_user(Geometry geometry, const Callbacks& callbacks) {
  const Api& rtc = api();
  rtc.SetGeometryUserPrimitiveCount(geometry, unsigned(pieces_.size()));
  rtc.SetGeometryUserData(geometry, this);
  rtc.SetGeometryBoundsFunction(geometry, bounds_of_piece, nullptr);
  rtc.SetGeometryIntersectFunction(geometry, callbacks.first);
  rtc.SetGeometryOccludedFunction(geometry, callbacks.any);
}

/// Consecutive pieces of a segment share the point between them.
void Scene::add_curves(Geometry geometry, std::span<const SegmentEnds> segments, std::span<const float> radii) {
  const Api& rtc = api();
  const std::size_t n_points = owners_.size() + segments.size();
  auto* points = static_cast<float*>(
      rtc.SetNewGeometryBuffer(geometry, BufferType::vertex, 0, Format::float4, 4 * sizeof(float), n_points));
  auto* index = static_cast<std::uint32_t*>(
      rtc.SetNewGeometryBuffer(geometry, BufferType::index, 0, Format::uint1, sizeof(std::uint32_t), owners_.size()));
  if (!points || !index) throw std::runtime_error("Embree: " + error_);
  std::uint32_t at = 0;
  for (std::size_t i = 0; i < segments.size(); ++i)
    for (std::uint32_t j = 0; j <= n_cuts_[i]; ++j, ++at) {
      const float s = float(j) / n_cuts_[i];
      for (int k = 0; k < 3; ++k) *points++ = point(segments[i], k, s);
      *points++ = settings_.radius + (radii.empty() ? 0.0f : (1 - s) * radii[2 * i] + s * radii[2 * i + 1]);
      if (j < n_cuts_[i]) *index++ = at;
    }
}

/// A ribbon extends by the radius to both sides of its segment, perpendicular to the segment and to the direction from
/// the eye. Consecutive pieces of a segment share the two points between them.
void Scene::add_ribbons(Geometry geometry, std::span<const SegmentEnds> segments) {
  const Api& rtc = api();
  const std::size_t n_points = 2 * (owners_.size() + segments.size());
  auto* points = static_cast<float*>(
      rtc.SetNewGeometryBuffer(geometry, BufferType::vertex, 0, Format::float3, 3 * sizeof(float), n_points));
  auto* index = static_cast<std::uint32_t*>(rtc.SetNewGeometryBuffer(geometry, BufferType::index, 0, Format::uint3,
                                                                     3 * sizeof(std::uint32_t), 2 * owners_.size()));
  if (!points || !index) throw std::runtime_error("Embree: " + error_);
  std::uint32_t at = 0;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const SegmentEnds& segment = segments[i];
    for (std::uint32_t j = 0; j <= n_cuts_[i]; ++j, at += 2) {
      float x[3], e[3], view[3], across[3], length2 = 0.0f;
      for (int k = 0; k < 3; ++k) {
        x[k] = point(segment, k, float(j) / n_cuts_[i]);
        e[k] = segment.q[k] - segment.p[k];
        view[k] = x[k] - settings_.eye[k];
      }
      for (int k = 0; k < 3; ++k) {
        across[k] = e[(k + 1) % 3] * view[(k + 2) % 3] - e[(k + 2) % 3] * view[(k + 1) % 3];
        length2 += across[k] * across[k];
      }
      const float scale = length2 > 0.0f ? settings_.radius / std::sqrt(length2) : 0.0f;
      for (int k = 0; k < 3; ++k) *points++ = x[k] - scale * across[k];
      for (int k = 0; k < 3; ++k) *points++ = x[k] + scale * across[k];
      if (j == n_cuts_[i]) continue;
      for (const std::uint32_t corner : {0u, 1u, 2u, 1u, 3u, 2u}) *index++ = at + corner;
    }
  }
}

}  // namespace fastlines::peers
