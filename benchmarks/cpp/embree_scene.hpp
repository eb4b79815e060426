// Segments as an Embree scene: as user geometry, as Embree's linear curves, or as ribbons of two triangles. Segments
// stay whole or are cut into pieces. Or other shapes: Embree's cubic curves, spheres and triangles.
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "embree_user.hpp"

namespace fastlines::peers {

enum class Kind { user, flat, round, ribbon, bezier, sphere, triangle };

/// Whether a kind of geometry is made of segments.
constexpr bool is_of_segments(Kind kind) { return kind <= Kind::ribbon; }

struct SegmentEnds {
  float p[3], q[3];
};

/// What a scene is made of: segments, or vertices.
struct SceneInput {
  std::span<const SegmentEnds> segments;
  std::span<const float> radii;          // none, or two a segment, added to that of the settings: linear curves only
  std::span<const float> vertices;       // x, y, z and radius, four points a cubic curve, one a sphere; x, y, z of
  std::span<const std::uint32_t> index;  // triangles, which take three
};

struct SceneSettings {
  Kind kind = Kind::user;
  float radius = 0.0f;
  float piece_length = 0.0f;  // segments are cut into equal pieces of at most this length; 0 = not cut
  unsigned halvings = 0;      // cubic curves are cut into 2^halvings parts
  Quality quality = Quality::high;
  bool compact = false;      // RTC_SCENE_FLAG_COMPACT
  std::string device;        // the configuration of rtcNewDevice, such as "threads=1"
  float eye[3] = {0, 0, 0};  // ribbons face it
};

/// An Embree device with one scene of one geometry. It must not be copied or moved, because Embree holds pointers into
/// it.
class Scene {
 public:
  Scene(const SceneInput& input, const SceneSettings& settings, const Callbacks& callbacks);
  ~Scene();
  Scene(const Scene&) = delete;

  const SceneSettings& settings() const { return settings_; }
  /// How near a ray must come to hit: initially the radius that the scene was built for. With user geometry, it may be
  /// lowered.
  float radius = 0.0f;
  SceneHandle handle() const { return scene_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<Owner>& owners() const { return owners_; }
  /// The number of primitives that Embree is given; ribbons count once.
  std::size_t n_pieces() const { return n_pieces_; }
  /// The primitive of the input to which Embree's belongs.
  std::uint32_t prim_of(std::uint32_t found) const;
  /// The memory that Embree reports to have allocated, plus that of the pieces or owners.
  std::size_t bytes() const;
  /// Whether Embree traces packets of this width natively.
  bool is_native(int width) const;
  /// The box of the segments, which bounds their distance from the origins of rays.
  const Bounds& box() const { return box_; }

 private:
  void cut(std::span<const SegmentEnds> segments);
  void add_user(Geometry geometry, const Callbacks& callbacks);
  void add_curves(Geometry geometry, std::span<const SegmentEnds> segments, std::span<const float> radii);
  void add_ribbons(Geometry geometry, std::span<const SegmentEnds> segments);
  void add_cubics(Geometry geometry, std::span<const float> vertices);
  void add_spheres(Geometry geometry, std::span<const float> vertices);
  void add_triangles(Geometry geometry, std::span<const float> vertices, std::span<const std::uint32_t> index);
  void add(Geometry geometry, const SceneInput& input, const Callbacks& callbacks);
  void release();

  SceneSettings settings_;
  std::atomic<std::ptrdiff_t> allocated_{0};
  std::string error_;
  Device device_ = nullptr;
  SceneHandle scene_ = nullptr;
  std::vector<std::uint16_t> n_cuts_;  // during the build: the number of pieces of each segment
  std::vector<Piece> pieces_;          // of user geometry
  std::vector<Owner> owners_;          // of linear curves and ribbons
  std::size_t n_pieces_ = 0;
  Bounds box_{};
};

inline std::uint32_t Scene::prim_of(std::uint32_t found) const {
  switch (settings_.kind) {
    case Kind::flat:
    case Kind::round:
      return owners_[found].prim;
    case Kind::ribbon:
      return owners_[found / 2].prim;
    case Kind::bezier:
      return found >> settings_.halvings;
    default:
      return found;  // callbacks of user geometry report the segment
  }
}

}  // namespace fastlines::peers
