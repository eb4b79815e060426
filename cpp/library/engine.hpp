// What is compiled for each instruction set, and what the rest of the library sees of it. The objects of an instruction
// set export only their `Engine`, so no function of one is ever called by another (cpp/library/CMakeLists.txt).
#pragma once

#include <algorithm>
#include <array>

#include "fastlines/api/tree.hpp"
#include "near_queries.hpp"

namespace fl::detail {

/// What a file of a tree has beside what is used here: attributes of lines, for instance.
struct FileRest {
  struct Section {
    std::string name, dtype, shape;  ///< as in the header of the file
    std::vector<std::byte> bytes;
  };
  std::vector<Section> sections;
  std::vector<std::pair<std::string, std::string>> metadata;
};

/// A copy of the strands of lines, which is empty if no line has one.
inline std::vector<std::int64_t> strands_of(std::span<const std::int64_t> given) {
  const bool has_strand = std::ranges::any_of(given, [](std::int64_t strand) { return strand >= 0; });
  return has_strand ? std::vector(given.begin(), given.end()) : std::vector<std::int64_t>();
}

/// What a tree is besides its arrays.
struct TreeOrigin {
  std::string method;                      ///< its name in Python
  double c_trav, c_prim;                   ///< of its cost
  bool is_cut;                             ///< whether its boxes are cut, as in KD trees
  std::string settings;                    ///< all settings of the build, as JSON
  std::string limits_hit;                  ///< the number of nodes that each limit affected, as JSON
  std::vector<std::int64_t> strands;       ///< of each line, or none
  Vec3d offset{};                          ///< what is subtracted from the coordinates of a tree from a file
  std::optional<double> built_cost{};      ///< of a tree that was refitted: its cost before
  std::shared_ptr<const FileRest> rest{};  ///< of a tree from a file, to be saved again
  /// The low and the high corner of the box whose frame queries compute in; by default that of the tree.
  std::optional<std::array<float, 6>> frame{};

  /// Records that all boxes are tight, as after a refit.
  void be_tight();
};

/// The arrays of a tree as a file keeps them: rows of 9 words for a node, of 3 for a reference. The lines are those of
/// one of both kinds.
struct TreeArrays {
  std::span<const std::uint32_t> nodes, refs;
  std::span<const Segment> segments;
  std::span<const RoundCone> cones;
  bool has_radius = false;
};

/// A tree for one instruction set.
class TreeImpl {
 public:
  virtual ~TreeImpl();

  virtual Hit first_hit(const Ray& ray, float radius, At at) const = 0;
  virtual bool any_hit(const Ray& ray, float radius, At at) const = 0;
  virtual std::size_t count_hits(const Ray& ray, float radius, At at) const = 0;
  virtual void all_hits(const Ray& ray, float radius, At at, std::vector<Hit>& to) const = 0;
  virtual void next_hits(const Ray& ray, float radius, std::size_t k, At at, Rank rank, std::vector<Hit>& to) const = 0;

  virtual Hits first_hits(const Rays& rays, const PerRay& radius, const QueryOptions& options) const = 0;
  virtual std::vector<std::uint8_t> any_hits(const Rays& rays, const PerRay& radius,
                                             const QueryOptions& options) const = 0;
  virtual std::vector<std::int64_t> count_hits(const Rays& rays, const PerRay& radius,
                                               const QueryOptions& options) const = 0;
  /// Throws InputError for a batch that cannot be used.
  virtual void check(const Rays& rays, const PerRay& radius, const QueryOptions& options) const = 0;
  /// All hits, or the first k; nothing if there are more than `max_hits`.
  virtual std::optional<HitLists> list_hits(const Rays& rays, const PerRay& radius, std::optional<std::size_t> k,
                                            const QueryOptions& options, std::size_t max_hits) const = 0;

  virtual void gather(const Rays& rays, const PerRay& radius, const GatherOptions& what, const QueryOptions& options,
                      Gathered& to) const = 0;

  virtual const NearQueries& near_queries() const = 0;

  /// The same tree over lines that have moved. Throws InputError if they are not as many, or of the other kind.
  virtual std::shared_ptr<const TreeImpl> refit(std::span<const Segment> lines, unsigned n_threads) const = 0;
  virtual std::shared_ptr<const TreeImpl> refit(std::span<const RoundCone> lines, unsigned n_threads) const = 0;

  /// How large and how far from zero the scene is.
  virtual double scene_size() const = 0;
  virtual TreeFacts facts() const = 0;
  virtual std::size_t size() const = 0;
  virtual const TreeOrigin& origin() const = 0;
  virtual TreeArrays arrays() const = 0;
};

using TreePointer = std::shared_ptr<const TreeImpl>;

/// The functions of an instruction set.
struct Engine {
  const char* simd;
  TreePointer (*build_segments)(std::span<const Segment>, const BuildOptions&);
  TreePointer (*build_cones)(std::span<const RoundCone>, const BuildOptions&);
  /// Lay out a tree of a file, after a check of all that queries rely on. Throws InputError.
  TreePointer (*restore)(const TreeArrays&, const TreeOrigin&);
};

/// The engine for trees that are made from now on.
const Engine& current_engine();

}  // namespace fl::detail
