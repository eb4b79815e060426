// A library for LD_PRELOAD whose allocations and new threads fail on demand: the n-th, or the n-th and all after it.
//
// Only calls from chosen modules count, so that the interpreter itself never runs out of memory.
#include <dlfcn.h>
#include <link.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
}

namespace {

/// The code of a chosen module.
struct Module {
  std::uintptr_t begin, end;
};
Module modules[64];
int n_modules = 0;

enum Kind { kMemory = 1, kThreads = 2 };
std::atomic<int> armed{0};  // the kind that fails, or none
std::atomic<long> n_seen{0};
long fail_from = 0, fail_to = 0;

bool is_turn() {
  const long i = ++n_seen;
  return i >= fail_from && i <= fail_to;
}

bool fails(const void* caller) {
  if (armed.load(std::memory_order_relaxed) != kMemory) return false;
  const auto at = reinterpret_cast<std::uintptr_t>(caller);
  for (int i = 0; i < n_modules; ++i)
    if (at >= modules[i].begin && at < modules[i].end) return is_turn();
  return false;
}

void* aligned(std::size_t alignment, std::size_t n_bytes) {
  return __libc_memalign(alignment < sizeof(void*) ? sizeof(void*) : alignment, n_bytes);
}

void* or_throw(void* data) {
  if (!data) throw std::bad_alloc();
  return data;
}

}  // namespace

#define CALLER __builtin_return_address(0)

extern "C" {

/// Counts the calls of the loaded modules whose path contains `name`. Returns how many parts of code count so far.
int faults_watch(const char* name) {
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* data) {
        if (!std::strstr(info->dlpi_name, static_cast<const char*>(data))) return 0;
        for (int i = 0; i < info->dlpi_phnum && n_modules < 64; ++i) {
          const auto& part = info->dlpi_phdr[i];
          if (part.p_type == PT_LOAD && (part.p_flags & PF_X))
            modules[n_modules++] = {info->dlpi_addr + part.p_vaddr, info->dlpi_addr + part.p_vaddr + part.p_memsz};
        }
        return 0;
      },
      const_cast<char*>(name));
  return n_modules;
}

/// From now on calls first to last of a kind fail.
void faults_arm(int kind, long first, long last) {
  n_seen = 0, fail_from = first, fail_to = last;
  armed = kind;
}

/// Ends that, and returns how many calls there were.
long faults_disarm() {
  armed = 0;
  return n_seen;
}

void* malloc(std::size_t n) { return fails(CALLER) ? (errno = ENOMEM, nullptr) : __libc_malloc(n); }

void* calloc(std::size_t n, std::size_t size) {
  return fails(CALLER) ? (errno = ENOMEM, nullptr) : __libc_calloc(n, size);
}

void* realloc(void* data, std::size_t n) { return fails(CALLER) ? (errno = ENOMEM, nullptr) : __libc_realloc(data, n); }

void* aligned_alloc(std::size_t alignment, std::size_t n) {
  return fails(CALLER) ? (errno = ENOMEM, nullptr) : aligned(alignment, n);
}

void* memalign(std::size_t alignment, std::size_t n) {
  return fails(CALLER) ? (errno = ENOMEM, nullptr) : aligned(alignment, n);
}

int posix_memalign(void** data, std::size_t alignment, std::size_t n) {
  void* const made = fails(CALLER) ? nullptr : aligned(alignment, n);
  if (!made) return ENOMEM;
  *data = made;
  return 0;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*), void* argument) {
  if (armed == kThreads && is_turn()) return EAGAIN;
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  return create(thread, attributes, start, argument);
}

}  // extern "C"

void* operator new(std::size_t n) { return fails(CALLER) ? throw std::bad_alloc() : or_throw(__libc_malloc(n)); }
void* operator new[](std::size_t n) { return fails(CALLER) ? throw std::bad_alloc() : or_throw(__libc_malloc(n)); }
void* operator new(std::size_t n, const std::nothrow_t&) noexcept { return fails(CALLER) ? nullptr : __libc_malloc(n); }
void* operator new[](std::size_t n, const std::nothrow_t&) noexcept {
  return fails(CALLER) ? nullptr : __libc_malloc(n);
}
void* operator new(std::size_t n, std::align_val_t alignment) {
  return fails(CALLER) ? throw std::bad_alloc() : or_throw(aligned(std::size_t(alignment), n));
}
void* operator new[](std::size_t n, std::align_val_t alignment) {
  return fails(CALLER) ? throw std::bad_alloc() : or_throw(aligned(std::size_t(alignment), n));
}
void operator delete(void* data) noexcept { std::free(data); }
void operator delete[](void* data) noexcept { std::free(data); }
void operator delete(void* data, std::size_t) noexcept { std::free(data); }
void operator delete[](void* data, std::size_t) noexcept { std::free(data); }
void operator delete(void* data, std::align_val_t) noexcept { std::free(data); }
void operator delete[](void* data, std::align_val_t) noexcept { std::free(data); }
void operator delete(void* data, std::size_t, std::align_val_t) noexcept { std::free(data); }
void operator delete[](void* data, std::size_t, std::align_val_t) noexcept { std::free(data); }
