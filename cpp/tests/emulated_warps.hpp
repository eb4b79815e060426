// Emulates the warps of a GPU on the host. The kernels are compiled as for a GPU, and each of their threads is a fiber,
// which runs until it waits for other lanes.
//
// Which fiber runs next is random. So lanes that do not wait for one another where they must give wrong answers, and
// lanes that wait for others that never come end the test.
#pragma once

#include <setjmp.h>
#include <ucontext.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <vector>

#include "fastlines/layout/wide_bvh.hpp"
#include "fastlines/rays/ray_batch.hpp"
#include "random.hpp"

/// What CUDA calls the numbers of the calling thread.
inline struct EmulatedIndex {
  unsigned x = 0;
} threadIdx, blockIdx, blockDim;

namespace fastlines::test {

/// What lanes do together.
enum class Together { vote, shuffle, sync };

/// One thread of a block.
struct Fiber {
  enum class State { ready, waiting, done };

  std::vector<char> stack = std::vector<char>(1 << 16);
  ucontext_t start;
  jmp_buf here;
  bool begun = false;
  State state = State::done;
  Together what;
  unsigned mask;
  std::uint32_t given, from, taken;  // a value, the lane whose value is taken, and that value
};

/// A block of threads, one fiber each.
class EmulatedBlock {
 public:
  static constexpr unsigned kThreads = FASTLINES_BLOCK, kWarp = 32;

  /// Run a thread's work in all threads.
  void run(const std::function<void()>& work) {
    work_ = &work;
    std::vector<unsigned> ready;
    for (unsigned i = 0; i < kThreads; ++i) {
      fibers_[i].state = Fiber::State::ready;
      ready.push_back(i);
    }
    unsigned n_done = 0;
    while (!ready.empty()) {
      // Run any thread until it waits or is done.
      std::swap(ready[random_.below(std::uint32_t(ready.size()))], ready.back());
      const unsigned i = ready.back();
      ready.pop_back();
      threadIdx.x = i;
      resume(fibers_[i]);
      if (fibers_[i].state == Fiber::State::waiting)
        meet(i, ready);
      else
        ++n_done;
    }
    if (n_done < kThreads) fail("lanes wait for others that do not come");
  }

  /// Wait until all lanes of a mask do the same; returns the votes, or the value of a lane.
  std::uint32_t wait(Together what, unsigned mask, std::uint32_t given, unsigned from = 0) {
    Fiber& fiber = fibers_[threadIdx.x];
    if (!(mask >> threadIdx.x % kWarp & 1)) fail("a mask lacks the lane that gives it");
    fiber.state = Fiber::State::waiting;
    fiber.what = what;
    fiber.mask = mask;
    fiber.given = given;
    fiber.from = from;
    pause(fiber);
    return fiber.taken;
  }

  static EmulatedBlock& current() {
    static const auto block = std::make_unique<EmulatedBlock>();
    return *block;
  }

  EmulatedBlock() {
    for (Fiber& fiber : fibers_) {
      getcontext(&fiber.start);
      fiber.start.uc_stack.ss_sp = fiber.stack.data();
      fiber.start.uc_stack.ss_size = fiber.stack.size();
      makecontext(&fiber.start, work_for_ever, 0);
    }
  }

 private:
  /// Let the lanes that wait with this thread go on, if all are there.
  void meet(unsigned thread, std::vector<unsigned>& ready) {
    Fiber* const warp = &fibers_[thread / kWarp * kWarp];
    const Fiber& last = fibers_[thread];
    std::uint32_t votes = 0;
    for (unsigned lane = 0; lane < kWarp; ++lane) {
      if (!(last.mask >> lane & 1)) continue;
      const Fiber& other = warp[lane];
      if (other.state == Fiber::State::done) fail("a lane waits for one that is done");
      if (other.state != Fiber::State::waiting) return;
      if (other.what != last.what || other.mask != last.mask) fail("lanes wait for one another in different places");
      votes |= std::uint32_t(other.given != 0) << lane;
    }
    for (unsigned lane = 0; lane < kWarp; ++lane) {
      if (!(last.mask >> lane & 1)) continue;
      Fiber& other = warp[lane];
      if (last.what == Together::shuffle && !(last.mask >> other.from & 1)) fail("a lane takes a value of none");
      other.taken = last.what == Together::vote ? votes : warp[other.from].given;
      other.state = Fiber::State::ready;
      ready.push_back(thread / kWarp * kWarp + lane);
    }
  }

  static void work_for_ever() {
    EmulatedBlock& block = current();
    for (;;) {
      (*block.work_)();
      Fiber& fiber = block.fibers_[threadIdx.x];
      fiber.state = Fiber::State::done;
      block.pause(fiber);
    }
  }

  /// Go on with a fiber until it pauses. (`swapcontext` would call the system each time.)
  [[gnu::noinline]] void resume(Fiber& fiber) {
    if (_setjmp(scheduler_)) return;
    if (std::exchange(fiber.begun, true)) _longjmp(fiber.here, 1);
    setcontext(&fiber.start);
  }
  [[gnu::noinline]] void pause(Fiber& fiber) {
    if (!_setjmp(fiber.here)) _longjmp(scheduler_, 1);
  }

  [[noreturn]] static void fail(const char* why) {
    std::printf("thread %u: %s\n", threadIdx.x, why);
    std::fflush(stdout);
    std::_Exit(1);  // the stacks of fibers are in use
  }

  Fiber fibers_[kThreads];
  jmp_buf scheduler_;
  const std::function<void()>* work_ = nullptr;
  Random random_{8};
};

}  // namespace fastlines::test

inline std::uint32_t __ballot_sync(unsigned mask, bool vote) {
  return fastlines::test::EmulatedBlock::current().wait(fastlines::test::Together::vote, mask, vote);
}

template <class T>
T __shfl_sync(unsigned mask, T value, int lane, int width) {
  static_assert(sizeof(T) == sizeof(std::uint32_t));
  const unsigned first = threadIdx.x % 32 / unsigned(width) * unsigned(width);
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  bits = fastlines::test::EmulatedBlock::current().wait(fastlines::test::Together::shuffle, mask, bits,
                                                        first + unsigned(lane) % unsigned(width));
  std::memcpy(&value, &bits, sizeof bits);
  return value;
}

inline void __syncwarp(unsigned mask) {
  fastlines::test::EmulatedBlock::current().wait(fastlines::test::Together::sync, mask, 0);
}

inline int __ffs(int mask) { return __builtin_ffs(mask); }
inline int __popc(unsigned mask) { return __builtin_popcount(mask); }
inline unsigned atomicAdd(unsigned* number, unsigned more) { return std::exchange(*number, *number + more); }

#define __global__ inline
#define __launch_bounds__(n_threads)
#define __shared__ static
#define __CUDACC__
#include "fastlines/device/kernels.hpp"
#undef __CUDACC__

namespace fastlines {

/// Stacks are not noted.
inline int deepest_stack = 0;

/// Runs a kernel as n threads or more, in whole blocks.
template <class Kernel, class... Arguments>
void emulate_threads(std::uint64_t n, const Kernel& kernel, const Arguments&... arguments) {
  const std::function<void()> work = [&] { kernel(arguments...); };
  blockDim.x = FASTLINES_BLOCK;
  for (blockIdx.x = 0; std::uint64_t(blockIdx.x) * blockDim.x < n; ++blockIdx.x)
    test::EmulatedBlock::current().run(work);
}

}  // namespace fastlines
