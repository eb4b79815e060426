// Objects that a thread keeps from call to call.
#pragma once

namespace fastlines {

/// The T of the calling thread, made by its first call and freed when the thread ends. It is on the heap, so that
/// threads which never call it pay for a pointer only. Destructors of static objects may call it, too: they get a new
/// one.
template <class T>
T& thread_scratch() {
  static thread_local T* scratch = nullptr;
  if (!scratch) [[unlikely]] {
    static thread_local const struct AtExit {
      ~AtExit() {
        delete scratch;
        scratch = nullptr;
      }
    } at_exit;
    scratch = new T;
    (void)&at_exit;
  }
  return *scratch;
}

}  // namespace fastlines
