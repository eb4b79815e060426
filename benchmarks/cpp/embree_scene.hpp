// Segments as an Embree scene: as user geometry, as Embree's linear curves, or as ribbons of two triangles. Segments
// stay whole or are cut into pieces.
#pragma once

#include <atomic>
#include <span>
#include <string>
#include <vector>

#include "embree_user.hpp"

namespace fastlines::peers {

enum class Kind { user, flat, round, ribbon };

struct SegmentEnds {
  float p[3], q[3];
};

struct SceneSettings {
  Kind kind = Kind::user;
  float radius = 0.0f;
  float piece_length = 0.0f;  // segments are cut into equal pieces of at most this length; 0 = not cut
  Quality quality = Quality::high;
  std::string device;        // the configuration of rtcNewDevice, such as "threads=1"
  float eye[3] = {0, 0, 0};  // ribbons face it
};

/// An Embree device with one scene of one geometry. It must not be copied or moved, because Embree holds pointers into
/// it.
class Scene {
 public:
  /// `radii` are empty, or two for each segment, which are added to the radius of the settings: for curves only.
  Scene(std::span<const SegmentEnds> segments, std::span<const float> radii, const SceneSettings& settings,
        const Callbacks& callbacks);
  ~Scene();
  Scene(const Scene&) = delete;

  const SceneSettings& settings() const { return settings_; }
  /// How near a ray must come to hit: initially the radius that the scene was built for. With user geometry, it may be
  /// lowered.
  float radius = 0.0f;
  SceneHandle handle() const { return scene_; }
  const std::vector<Piece>& pieces() const { return pieces_; }
  const std::vector<Owner>& owners() const { return owners_; }
  std::size_t n_pieces() const { return pieces_.size() + owners_.size(); }
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
  void release();

  SceneSettings settings_;
  std::atomic<std::ptrdiff_t> allocated_{0};
  std::string error_;
  Device device_ = nullptr;
  SceneHandle scene_ = nullptr;
  std::vector<std::uint16_t> n_cuts_;  // during the build: the number of pieces of each segment
  std::vector<Piece> pieces_;          // of user geometry
  std::vector<Owner> owners_;          // of all other kinds
  Bounds box_{};
};

}  // namespace fastlines::peers
