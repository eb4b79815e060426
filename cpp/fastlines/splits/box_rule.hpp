// Where BVH and KD tree differ: how a child's box is made.
#pragma once

namespace fastlines {

/// How a child's box is made: tight around what lies in it (BVH), or cut out of its parent's (KD tree).
enum class BoxRule { tight, cut };

}  // namespace fastlines
