// The kernels for GPUs as a library of the host, which runs one thread after the other
// (tests/support/emulated_device.py).
#include <cstring>

#include "fastlines/device/kernels.hpp"

using namespace fastlines;

namespace {

/// A kernel by its name, with arguments of 64 bits each.
struct NamedKernel {
  const char* name;
  void (*run)(std::uint64_t n, const std::uint64_t* arguments);
};

template <auto kernel>
struct KernelCall;

template <class... Arguments, void (*kernel)(Arguments...)>
struct KernelCall<kernel> {
  static void run(std::uint64_t n, const std::uint64_t* arguments) {
    [=]<std::size_t... i>(std::index_sequence<i...>) {
      emulate_threads(n, kernel, argument<Arguments>(arguments[i])...);
    }(std::index_sequence_for<Arguments...>());
  }

 private:
  template <class T>
  static T argument(std::uint64_t bits) {
    T value;
    static_assert(sizeof value == sizeof bits);
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
};

#define NAMED(kernel) {#kernel, KernelCall<kernel>::run}
constexpr NamedKernel kKernels[] = {
    NAMED(first_closest), NAMED(first_surface), NAMED(any_hit),     NAMED(any_entry),    NAMED(count_hits),
    NAMED(count_entries), NAMED(all_closest),   NAMED(all_surface), NAMED(next_closest), NAMED(next_surface),
    NAMED(near_closest),  NAMED(near_surface),  NAMED(count_prims), NAMED(move_lists),   NAMED(sum_runs),
    NAMED(scan_runs),     NAMED(check_rays),    NAMED(first_steps)};

}  // namespace

/// Run a kernel in n threads; returns whether there is one of this name.
extern "C" bool run(const char* name, std::uint64_t n, const std::uint64_t* arguments) {
  for (const NamedKernel& kernel : kKernels)
    if (std::strcmp(kernel.name, name) == 0) {
      kernel.run(n, arguments);
      return true;
    }
  return false;
}
