// The GIL, released for long work and acquired again.
//
// While Python ends, a daemon thread that takes the GIL does not come back. From Python 3.14 on it sleeps until the
// process is over. Before that, Python calls pthread_exit. With glibc this unwinds the stack, and every function of
// nanobind is noexcept: the process is aborted. Elsewhere the stack is gone while a worker still uses what is on it.
// Here such a thread sleeps whatever the version. So what it holds, the arrays of a query among them, stays alive.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>

#if __has_include(<pthread.h>)
#include <pthread.h>
#endif

namespace fastlines {

inline void sleep_for_ever(void*) {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// Call something that may acquire the GIL and does not throw; a thread that Python ends in there sleeps for ever. Not
/// inlined: in a noexcept function, compilers may leave out the cleanup on unwinding.
template <class Call>
[[gnu::noinline]] void outlast_python(Call&& call) {
#if __has_include(<pthread.h>)
  pthread_cleanup_push(sleep_for_ever, nullptr);
  call();
  pthread_cleanup_pop(0);
#else
  call();
#endif
}

/// Releases the GIL for its lifetime.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  ~WithoutGil() {
    outlast_python([this] { PyEval_RestoreThread(state_); });
  }
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;

  /// Acquire the GIL for one call, which may run Python.
  template <class Call>
  void with_gil(Call&& call) {
    outlast_python([&] {
      PyEval_RestoreThread(state_);
      call();
      state_ = PyEval_SaveThread();
    });
  }

 private:
  PyThreadState* state_;
};

}  // namespace fastlines
