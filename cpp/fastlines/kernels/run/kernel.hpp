// The kernels that a query may name.
#pragma once

namespace fastlines {

/// Which kernel to use; `automatic` chooses by the divergence of each group and by measured costs.
enum class Kernel { automatic, single, wave, bundle };

}  // namespace fastlines
