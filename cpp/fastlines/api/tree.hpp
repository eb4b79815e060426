// Trees over lines, and their queries: build once, then ask with any radius.
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
#include "ray.hpp"

namespace fl {

/// Input that cannot be used: the message says what was given, what was expected, and what to do.
struct FASTLINES_API InputError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
  ~InputError() override;
};

/// A file that cannot be read or written.
struct FASTLINES_API FileError : std::runtime_error {
  using std::runtime_error::runtime_error;
  ~FileError() override;
};

/// Thrown by a call whose progress callback returned false.
struct FASTLINES_API Cancelled : std::runtime_error {
  using std::runtime_error::runtime_error;
  ~Cancelled() override;
};

/// The named trees: `best` is made for fast queries, the others are those of the thesis.
enum class Method { best, bvh_cl, bvh_ss, bvh_d2, kd_cl, kd_d2 };

/// Called now and then with the fraction that is done, from the thread that called; returns whether to go on.
using Progress = std::function<bool(double)>;

struct BuildOptions {
  Method method = Method::best;
  /// Of `best`: from 0, the fastest build, to 1, the best tree. By default 0.5, or 0 from 262,144 lines on.
  std::optional<float> effort;
  unsigned n_threads = 0;  ///< 0: one for each core. The tree does not depend on it.
  Progress progress;
};

/// How a batch is traced. Answers do not depend on the kernel or on the number of threads.
struct QueryOptions {
  At at = At::closest;
  enum class Kernel { automatic, single, wave, bundle } kernel = Kernel::automatic;
  unsigned n_threads = 0;  ///< 0: one for each core. Batches of up to 256 rays take one.
  Progress progress;
};

/// What a tree is made of.
struct TreeFacts {
  std::size_t n_prims, n_nodes, n_refs;
  double cost;          ///< the expected cost of a ray (thesis §3.3), with the constants of the method
  std::size_t n_bytes;  ///< the memory of the tree, its lines and its layout
  std::string method;   ///< as Python names it: "best", "bvh-cl", …, or "custom"
  Vec3 low, high;       ///< the corners of the box around all lines, without their radii
  std::string simd;     ///< the instruction set of its queries
};

namespace detail {
class TreeImpl;
}

/// An acceleration tree over lines. It owns a copy of them; copies of a tree share all memory.
class FASTLINES_API Tree {
 public:
  /// A tree over no lines; every ray misses.
  Tree();

  // One ray, on the calling thread.

  Hit first_hit(const Ray& ray, float radius, At at = At::closest) const;
  bool any_hit(const Ray& ray, float radius) const;
  std::size_t count_hits(const Ray& ray, float radius) const;
  /// All lines that the ray hits, in the order of t, and at the same t of their index.
  std::vector<Hit> all_hits(const Ray& ray, float radius, At at = At::closest) const;
  /// The same into a vector, which is cleared first. Its memory is used again.
  void all_hits(const Ray& ray, float radius, std::vector<Hit>& to, At at = At::closest) const;
  /// The first k of all hits.
  std::vector<Hit> next_hits(const Ray& ray, float radius, std::size_t k, At at = At::closest) const;
  void next_hits(const Ray& ray, float radius, std::size_t k, std::vector<Hit>& to, At at = At::closest) const;

  // Batches of rays, on several threads.

  Hits first_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  /// 1 for each ray that hits anything, 0 for the others.
  std::vector<std::uint8_t> any_hit(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  std::vector<std::int64_t> count_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  HitLists all_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options = {}) const;
  HitLists next_hits(const Rays& rays, const PerRay& radius, std::size_t k, const QueryOptions& options = {}) const;

  /// Called with the index of a ray and its hits, in the order of the rays, from the thread that called.
  using Sink = std::function<void(std::size_t ray, const Hits& hits)>;
  /// Hand all hits to a sink, a part of the rays at a time. So lists that would not fit into memory can be used.
  void all_hits(const Rays& rays, const PerRay& radius, const Sink& sink, const QueryOptions& options = {}) const;

  TreeFacts facts() const;
  std::size_t size() const;  ///< the number of lines

  /// Write the tree and its lines to a file (`.flt`), which Python reads too. Throws FileError.
  void save(const std::string& path) const;

 private:
  friend FASTLINES_API Tree build(std::span<const Segment>, const BuildOptions&);
  friend FASTLINES_API Tree build(std::span<const RoundCone>, const BuildOptions&);
  friend FASTLINES_API Tree load(const std::string&);
  explicit Tree(std::shared_ptr<const detail::TreeImpl> impl);

  std::shared_ptr<const detail::TreeImpl> impl_;
};

/// Build a tree over lines, which are copied. Coordinates and radii must be finite.
FASTLINES_API Tree build(std::span<const Segment> segments, const BuildOptions& options = {});
FASTLINES_API Tree build(std::span<const RoundCone> cones, const BuildOptions& options = {});

/// Read a tree that this library or Python has written. Throws FileError.
FASTLINES_API Tree load(const std::string& path);

/// The instruction set of trees that are built or loaded from now on: "avx512", "avx2", "sse42", "neon" or "portable".
FASTLINES_API const char* simd();
/// Choose it; nullptr for the widest that this processor has, the default. Answers do not depend on it.
FASTLINES_API void set_simd(const char* name);

/// The version of the library, such as "0.1.0".
FASTLINES_API const char* version();

}  // namespace fl
