// The rule for the boxes of children: the difference between a BVH and a KD tree.
#pragma once

namespace fastlines {

/// A child's box is tight around its references (BVH), or one half of its parent's box (KD tree).
enum class BoxRule { tight, cut };

}  // namespace fastlines
