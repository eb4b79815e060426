// The switch of the mutants, and operators that are a choice on it. Each mutated copy of a source includes this first.
//
// The names of the switches are the numbers of the mutants. The file that FASTLINES_MUTANTS names has a byte for each:
// 0 is off, 1 is on, and 2 is off and becomes 0 as soon as the code that it would change is reached. Processes map the
// file, so the mutant may change while they run.
//
// An operator is replaced by an object between two operators: `a < b` becomes `a < Less{17, 18} < b`. So it needs no
// parser: precedence stays as it was. Constant expressions take the original.
#pragma once

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <type_traits>

namespace mutants {

inline constexpr int kMost = 1 << 16;
inline unsigned char none[kMost];
inline unsigned char* switches = none;

[[gnu::constructor]] inline void map_switches() {
  const char* const path = std::getenv("FASTLINES_MUTANTS");
  const int file = path && switches == none ? open(path, O_RDWR) : -1;
  if (file < 0) return;
  void* const mapped = mmap(nullptr, kMost, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (mapped != MAP_FAILED) switches = static_cast<unsigned char*>(mapped);
  close(file);
}

[[gnu::noinline, gnu::cold]] inline bool reach(int number) {
  if (switches[number] == 2) switches[number] = 0;
  return switches[number] == 1;
}

/// Whether a mutant is active; number 0 never is.
[[gnu::always_inline]] constexpr bool on(int number) {
  if (__builtin_is_constant_evaluated()) return false;
  return switches[number] != 0 && reach(number);
}

/// Hides a value from the compiler, which may otherwise take an index or an address past an array for impossible, and
/// leave out the mutant.
template <class T>
[[gnu::always_inline]] inline T hidden(T value) {
  if constexpr (std::is_scalar_v<T>) {
    const volatile T kept = value;
    return kept;
  } else {
    return value;
  }
}

template <class T>
[[gnu::always_inline]] constexpr T constant(int number, T replacement, T original) {
  return on(number) ? hidden(replacement) : original;
}

/// Operators that become one of two others.
#define MUTANTS_OPERATOR(Name, op, first, second)                                    \
  struct Name {                                                                      \
    int a, b;                                                                        \
  };                                                                                 \
  template <class L>                                                                 \
  struct Name##After {                                                               \
    L left;                                                                          \
    int a, b;                                                                        \
  };                                                                                 \
  template <class L>                                                                 \
  [[gnu::always_inline]] constexpr Name##After<L> operator op(L left, Name name) {   \
    return {left, name.a, name.b};                                                   \
  }                                                                                  \
  template <class L, class R>                                                        \
  [[gnu::always_inline]] constexpr auto operator op(Name##After<L> after, R right) { \
    if (on(after.a)) return hidden(after.left first right);                          \
    if (on(after.b)) return hidden(after.left second right);                         \
    return after.left op right;                                                      \
  }

MUTANTS_OPERATOR(Less, <, <=, >=)
MUTANTS_OPERATOR(LessEqual, <=, <, >)
MUTANTS_OPERATOR(Greater, >, >=, <=)
MUTANTS_OPERATOR(GreaterEqual, >=, >, <)
MUTANTS_OPERATOR(Equal, ==, !=, !=)
MUTANTS_OPERATOR(NotEqual, !=, ==, ==)
MUTANTS_OPERATOR(Plus, +, -, -)
MUTANTS_OPERATOR(Minus, -, +, +)
MUTANTS_OPERATOR(Times, *, /, /)
MUTANTS_OPERATOR(Over, /, *, *)
MUTANTS_OPERATOR(And, &, |, |)
MUTANTS_OPERATOR(Or, |, &, &)
#undef MUTANTS_OPERATOR

/// `x += y` that becomes `x -= y`, and the reverse.
#define MUTANTS_ASSIGNMENT(Name, op, other)                                          \
  struct Name {                                                                      \
    int number;                                                                      \
  };                                                                                 \
  template <class R>                                                                 \
  struct Name##Before {                                                              \
    R right;                                                                         \
    int number;                                                                      \
  };                                                                                 \
  template <class R>                                                                 \
  [[gnu::always_inline]] constexpr Name##Before<R> operator op(Name name, R right) { \
    return {right, name.number};                                                     \
  }                                                                                  \
  template <class L, class R>                                                        \
  [[gnu::always_inline]] constexpr L& operator op(L& left, Name##Before<R> before) { \
    if (on(before.number)) return left = hidden(L(left other before.right));         \
    return left op before.right;                                                     \
  }

MUTANTS_ASSIGNMENT(Add, +=, -=)
MUTANTS_ASSIGNMENT(Subtract, -=, +=)
#undef MUTANTS_ASSIGNMENT

}  // namespace mutants
