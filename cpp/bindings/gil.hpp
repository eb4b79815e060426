// Releases the GIL for long work and acquires it again.
//
// While Python shuts down, a daemon thread that acquires the GIL never returns. From Python 3.14 on, the thread sleeps
// until the process ends. Older versions call pthread_exit. With glibc, pthread_exit unwinds the stack; since every
// function of nanobind is noexcept, this aborts the process. Elsewhere the stack vanishes while a worker still uses it.
// Here such a thread sleeps forever with every version, so that all it holds, such as the arrays of a query, stays
// alive.
#pragma once

#include <nanobind/nanobind.h>

#include <chrono>
#include <thread>

#if __has_include(<pthread.h>)
#include <pthread.h>
#endif

namespace fastlines {

inline void sleep_forever(void*) {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

/// Makes a call that may acquire the GIL and does not throw. If Python ends the thread during the call, the thread
/// sleeps forever. Not inlined: in a noexcept function, compilers may omit the cleanup on unwinding.
template <class Call>
[[gnu::noinline]] void outlast_python(Call&& call) {
#if __has_include(<pthread.h>)
  pthread_cleanup_push(sleep_forever, nullptr);
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

  /// Acquires the GIL for one call, which may run Python.
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
