// The interface of the thesis (§5.4), on the same trees: a tree of one method is built from an array of floats, and
// finds the first line, or all lines, that a ray comes near to.
#pragma once

#include "tree.hpp"

namespace fl {

/// A hit, or a miss by default.
struct Intersection {
  float t = infinity;  ///< Where the ray comes closest to the line, in units of the length of its direction.
  int id = -1;         ///< The index of the line.
};

/// A tree of one of the methods.
class FASTLINES_API AccTree {
 public:
  /// Makes an empty tree.
  explicit AccTree(Method method) : method_(method) {}

  /// Builds the tree over n lines of six floats each, which are both ends. It may be called again.
  void Build(const float* lines, int n);

  /// Finds the first line at a distance of at most d from the ray, and returns whether there is one. Otherwise `hit` is
  /// left as it is. `hit` may be null.
  bool Intersect(const Ray& ray, Intersection* hit, float d) const;
  /// Finds all lines at a distance of at most d from the ray, in the order of t, and returns whether there are any.
  /// `hits` is cleared first. It may be null.
  bool IntersectAll(const Ray& ray, std::vector<Intersection>* hits, float d) const;

  /// Returns the tree, with which all other queries are possible.
  const Tree& tree() const { return tree_; }

 private:
  Method method_;
  Tree tree_;
};

/// A bounding volume hierarchy.
class BVH : public AccTree {
 public:
  /// The methods.
  static constexpr Method CL = Method::bvh_cl, SS = Method::bvh_ss, D2 = Method::bvh_d2;
  /// Makes an empty tree.
  explicit BVH(Method method = D2) : AccTree(method) {}
};

/// A KD tree.
class KD : public AccTree {
 public:
  /// The methods.
  static constexpr Method CL = Method::kd_cl, D2 = Method::kd_d2;
  /// Makes an empty tree.
  explicit KD(Method method = D2) : AccTree(method) {}
};

}  // namespace fl
