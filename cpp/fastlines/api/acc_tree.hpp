// The interface of the thesis (§5.4), on the same trees: a tree of a method, built from an array of floats, then asked
// for the first or for all lines that a ray comes near to.
#pragma once

#include "tree.hpp"

namespace fl {

/// The distance along the ray to a line, and the index of that line.
struct Intersection {
  float t = infinity;
  int id = -1;
};

/// A tree of one of the methods. `Build` may be called again.
class FASTLINES_API AccTree {
 public:
  explicit AccTree(Method method) : method_(method) {}

  /// Build over n lines of six floats each: both ends.
  void Build(const float* lines, int n);

  /// Find the first line that the ray passes at a distance of at most d. Returns whether there is one.
  bool Intersect(const Ray& ray, Intersection* hit, float d) const;
  /// Find all of them, in the order of t. Returns whether there is one.
  bool IntersectAll(const Ray& ray, std::vector<Intersection>* hits, float d) const;

  const Tree& tree() const { return tree_; }

 private:
  Method method_;
  Tree tree_;
};

/// A bounding volume hierarchy.
class BVH : public AccTree {
 public:
  static constexpr Method CL = Method::bvh_cl, SS = Method::bvh_ss, D2 = Method::bvh_d2;
  explicit BVH(Method method = D2) : AccTree(method) {}
};

/// A KD tree.
class KD : public AccTree {
 public:
  static constexpr Method CL = Method::kd_cl, D2 = Method::kd_d2;
  explicit KD(Method method = D2) : AccTree(method) {}
};

}  // namespace fl
