// Trees over lines, and their queries by rays and points: build once, then query with any radius.
//
// All functions throw fl::InputError for input that they cannot use, and std::bad_alloc. A tree does not change, so any
// number of threads may query it at the same time.
#pragma once

#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "export.h"
#include "gather.hpp"
#include "point.hpp"
#include "ray.hpp"

namespace fl {

/// Thrown for input that cannot be used. The message says what was given, what was expected, and what to do.
struct FASTLINES_API InputError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
  ~InputError() override;
};

/// Thrown for a file that cannot be read or written.
struct FASTLINES_API FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
  ~FileError() override;
};

/// Thrown by a call whose progress callback returned false.
struct FASTLINES_API Cancelled : std::runtime_error {
  using std::runtime_error::runtime_error;
  ~Cancelled() override;
};

/// The named trees. All but `best` and `beams` are those of the thesis.
enum class Method {
  best,    ///< The tree for the fastest queries.
  bvh_cl,  ///< A BVH over whole lines.
  bvh_ss,  ///< A BVH over lines that are cut by a grid of planes.
  bvh_d2,  ///< As `bvh_ss`, but where a leaf looks best, it looks two levels ahead.
  kd_cl,   ///< A KD tree over a grid of planes.
  kd_d2,   ///< As `kd_cl`, but where a leaf looks best, it looks two levels ahead.
  beams,   ///< The least time of a build and one query, over dense long lines such as photon beams.
};

/// A callback for long calls. It gets the fraction that is done, and returns whether to go on. It runs on the thread
/// that called, every 50 ms. If it returns false before the work is done, the call throws `Cancelled`.
using Progress = std::function<bool(double)>;

/// Options of `build`.
struct BuildOptions {
  Method method = Method::best;  ///< Which tree to build.
  /// From 0, the fastest build, to 1, the best tree. Only `Method::best` has it. By default, it is 0.5, or 0 from
  /// 262,144 lines on.
  std::optional<float> effort = std::nullopt;
  unsigned n_threads = 0;       ///< The number of threads; 0 means one for each core. The tree does not depend on it.
  Progress progress = nullptr;  ///< It is called while the tree is built.
  /// The strand (hair, streamline, polyline) that each line is part of, −1 for none. The tree copies them. By default,
  /// no line has one.
  std::span<const std::int64_t> strands = std::span<const std::int64_t>();
};

/// How a batch of rays is traced. The kernel and the number of threads do not change the answers.
struct QueryOptions {
  /// A way to trace rays: one at a time, many incoherent ones together, or coherent ones as one beam.
  enum class Kernel {
    automatic,  ///< The kernel that is likely to be the fastest, for each group of rays.
    single,     ///< One ray at a time.
    wave,       ///< Incoherent rays.
    bundle,     ///< Coherent rays.
  };

  At at = At::closest;                ///< The place on the ray that t of a hit means, and which rays hit.
  Rank rank = Rank::t;                ///< What `next_hits` ranks hits by. No other query has it.
  Kernel kernel = Kernel::automatic;  ///< How rays are traced.
  unsigned n_threads = 0;             ///< The number of threads; 0 means one for each core. Short batches take one.
  Progress progress = nullptr;        ///< It is called during the query.
};

/// How a batch of points is answered. The number of threads does not change the answers.
struct PointOptions {
  To to = To::surface;          ///< What distances are to.
  unsigned n_threads = 0;       ///< The number of threads; 0 means one for each core. Short batches take one.
  Progress progress = nullptr;  ///< It is called during the query.
};

/// Which pairs are found, and how.
struct PairOptions {
  To to = To::surface;  ///< What distances are between. Surfaces count if the lines of either tree have a radius.
  /// Pairs of one strand are left out if their positions along it differ by at most this. A position counts the lines
  /// of a strand in the order of their indices. In a closed strand, the last line is next to the first one. Pairs of
  /// two trees are all found.
  std::size_t skip_neighbours = 1;
  bool skip_strand = false;     ///< Whether all pairs of one strand are left out. It is for one tree.
  unsigned n_threads = 0;       ///< The number of threads; 0 means one for each core.
  Progress progress = nullptr;  ///< It is called during the query.
};

/// Properties of a tree.
struct TreeFacts {
  std::size_t n_prims;  ///< The number of lines.
  std::size_t n_nodes;  ///< The number of nodes.
  std::size_t n_refs;   ///< The number of references: lines, or pieces of them, in all leaves.
  double cost;          ///< The expected cost of a ray (thesis §3.3), with the constants of the method.
  std::size_t n_bytes;  ///< The memory of the tree, its lines and its layout.
  std::string method;   ///< The name of the method in Python, such as "bvh-cl", or "custom".
  Vec3 low, high;       ///< The corners of the box around all lines, without their radii.
  std::string simd;     ///< The instruction set of the queries.
};

namespace detail {
class TreeImpl;
}

/// An acceleration tree over lines. It owns a copy of the lines, and copies of a tree share all memory. A tree does not
/// change, so any number of threads may query it at the same time. Queries throw `InputError` for rays, points
/// and radii that they cannot use.
class FASTLINES_API Tree {
 public:
  /// Makes an empty tree. All rays miss it.
  Tree();
  /// Makes a copy, which shares all memory. A tree that is moved from stays as it is.
  Tree(const Tree&) = default;
  /// Makes this tree a copy of another one.
  Tree& operator=(const Tree&) = default;

  // One ray, on the calling thread.

  /// Returns the hit with the least t, or a miss. Of hits at the same t, the line with the lower index comes first.
  Hit first_hit(const Ray& ray, float radius, At at = At::closest) const;
  /// Returns whether the ray hits any line.
  bool any_hit(const Ray& ray, float radius, At at = At::closest) const;
  /// Returns the number of lines that the ray hits.
  std::size_t count_hits(const Ray& ray, float radius, At at = At::closest) const;
  /// Returns one hit for each line that the ray hits, in the order of t.
  std::vector<Hit> all_hits(const Ray& ray, float radius, At at = At::closest) const;
  /// Writes all hits to a vector, which is cleared first. So calls can share its memory.
  void all_hits(const Ray& ray, float radius, std::vector<Hit>& to, At at = At::closest) const;
  /// Returns the first k of all hits by t, or by their distance, or fewer if there are fewer.
  std::vector<Hit> next_hits(const Ray& ray, float radius, std::size_t k, At at = At::closest,
                             Rank rank = Rank::t) const;
  /// Writes the first k of all hits to a vector, which is cleared first.
  void next_hits(const Ray& ray, float radius, std::size_t k, std::vector<Hit>& to, At at = At::closest,
                 Rank rank = Rank::t) const;

  // Batches of rays, on several threads.

  /// Returns the hit of each ray that has the least t, or a miss.
  Hits first_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  /// Returns 1 for each ray that hits any line, and 0 for the others.
  std::vector<std::uint8_t> any_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  /// Returns the number of lines that each ray hits.
  std::vector<std::int64_t> count_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  /// Returns all hits of each ray, in the order of t.
  HitLists all_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  /// Returns the first k of all hits of each ray.
  HitLists next_hits(const Rays& rays, const PerRay& radius, std::size_t k, const QueryOptions& options = {}) const;

  /// Returns sums over all hits of each ray, without listing them. Hits are those `At::closest`. The sums are the same
  /// for every tree, kernel and number of threads, bit for bit.
  Gathered gather(const Rays& rays, const PerRay& radius, const GatherOptions& what = {},
                  const QueryOptions& options = {}) const;

  /// A callback that gets the index of a ray and the hits of that ray.
  using Sink = std::function<void(std::size_t ray, const Hits& hits)>;
  /// Calls `sink` for each ray, in the order of the rays, on the calling thread. Only up to two million hits are in
  /// memory at a time, or those of one ray if it has more. All rays are checked first.
  void all_hits(const Rays& rays, const PerRay& radius, const Sink& sink, const QueryOptions& options = {}) const;

  // One point, on the calling thread. Lines are ranked by their distance, and then by their index.

  /// Returns the nearest line that is at most `max_distance` away, or none.
  NearLine nearest(const Point& point, float max_distance = infinity, To to = To::surface) const;
  /// Returns the k nearest lines in their order, or fewer if there are fewer.
  std::vector<NearLine> k_nearest(const Point& point, std::size_t k, float max_distance = infinity,
                                  To to = To::surface) const;
  /// Writes the k nearest lines to a vector, which is cleared first. So calls can share its memory.
  void k_nearest(const Point& point, std::size_t k, std::vector<NearLine>& lines, float max_distance = infinity,
                 To to = To::surface) const;
  /// Returns all lines within a radius of the point, in their order.
  std::vector<NearLine> within(const Point& point, float radius, To to = To::surface) const;
  /// Writes all lines within a radius to a vector, which is cleared first.
  void within(const Point& point, float radius, std::vector<NearLine>& lines, To to = To::surface) const;
  /// Returns the number of lines within a radius of the point.
  std::size_t count_within(const Point& point, float radius, To to = To::surface) const;

  // Batches of points, on several threads.

  /// Returns the nearest line of each point, or none.
  NearLines nearest(const Points& points, const PerPoint& max_distance = infinity,
                    const PointOptions& options = {}) const;
  /// Returns the k nearest lines of each point: those of point i are the entries from k·i on. The last ones are none if
  /// there are fewer lines.
  NearLines k_nearest(const Points& points, std::size_t k, const PerPoint& max_distance = infinity,
                      const PointOptions& options = {}) const;
  /// Returns all lines within a radius of each point.
  NearLists within(const Points& points, const PerPoint& radius, const PointOptions& options = {}) const;
  /// Returns the number of lines within a radius of each point.
  std::vector<std::int64_t> count_within(const Points& points, const PerPoint& radius,
                                         const PointOptions& options = {}) const;

  // Pairs of lines, on several threads.

  /// Returns all pairs of lines of this tree whose distance is at most the radius.
  Pairs pairs(float radius, const PairOptions& options = {}) const;
  /// Returns all pairs of a line of this tree and a line of another one. Both trees have the same offset.
  Pairs pairs(float radius, const Tree& other, const PairOptions& options = {}) const;

  // The lines, and hits on them. Arrays are valid as long as the tree or a copy of it.

  /// Returns the number of lines.
  std::size_t size() const;
  /// Returns the lines of a tree over segments. Of one over round cones, it returns none.
  std::span<const Segment> segments() const;
  /// Returns the lines of a tree over round cones. Of one over segments, it returns none.
  std::span<const RoundCone> round_cones() const;
  /// Returns a line of either kind. Segments have radii of 0.
  RoundCone line(std::int64_t prim) const;
  /// Returns the strand of each line, −1 for none. It is empty if no line has one.
  std::span<const std::int64_t> strands() const;
  /// Returns the offset of lines that Python has read with one. Lines, rays, boxes and places are less the offset here;
  /// points are not.
  Vec3d offset() const;
  /// Returns where a hit is, and how the line and its surface lie there. The ray and the radius are those of the query.
  Place place(const Ray& ray, float radius, const Hit& hit) const;
  /// Returns the point of a line near a point that is nearest to it, in the caller's coordinates: that of the surface,
  /// or of the axis. It is NaN for none.
  Vec3d place(const Point& point, const NearLine& found, To to = To::surface) const;

  // The tree itself.

  /// Returns the tree's size, cost and box.
  TreeFacts facts() const;

  /// Returns the same tree over as many lines that have moved, with new boxes. It is faster to make than a new tree,
  /// and slower to query the farther lines have moved. Strands are kept.
  Tree refit(std::span<const Segment> segments, unsigned n_threads = 0) const;
  /// Returns the same tree over round cones that have moved.
  Tree refit(std::span<const RoundCone> cones, unsigned n_threads = 0) const;

  /// Writes the tree and its lines to a file (`.flt`), which Python reads too. Throws `FileError`.
  void save(const std::string& path) const;

 private:
  friend FASTLINES_API Tree build(std::span<const Segment>, const BuildOptions&);
  friend FASTLINES_API Tree build(std::span<const RoundCone>, const BuildOptions&);
  friend FASTLINES_API Tree load(const std::string&);
  explicit Tree(std::shared_ptr<const detail::TreeImpl> impl);

  std::shared_ptr<const detail::TreeImpl> impl_;
};

/// Builds a tree over lines, which are copied. Coordinates and radii must be finite. Throws `InputError`.
FASTLINES_API Tree build(std::span<const Segment> segments, const BuildOptions& options = {});
/// Builds a tree over lines that have a thickness of their own.
FASTLINES_API Tree build(std::span<const RoundCone> cones, const BuildOptions& options = {});

/// Reads a tree over lines that this library or Python has written. Throws `FileError`.
FASTLINES_API Tree load(const std::string& path);

/// Returns the instruction set of trees to come: "avx512", "avx2", "sse42", "neon" or "portable".
FASTLINES_API const char* simd();
/// Chooses the instruction set of trees that are built or loaded from now on. nullptr chooses the widest that this
/// processor has. That is the default, unless the environment variable FASTLINES_SIMD names one. Answers do not depend
/// on it. Throws `InputError`.
FASTLINES_API void set_simd(const char* name);

/// Returns the version of the library, such as "0.1.0".
FASTLINES_API const char* version();

}  // namespace fl
