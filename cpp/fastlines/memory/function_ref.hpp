// A reference to a callable. Templates that take one are compiled once, not once for each lambda that is passed to
// them.
#pragma once

#include <concepts>
#include <memory>
#include <type_traits>
#include <utility>

namespace fastlines {

template <class Signature>
class FunctionRef;

/// Refers to a callable, which must outlive it. A call is one indirect call.
template <class Result, class... Args>
class FunctionRef<Result(Args...)> {
 public:
  template <class Callable>
    requires(!std::same_as<std::remove_cvref_t<Callable>, FunctionRef> &&
             std::is_invocable_r_v<Result, Callable&, Args...>)
  FunctionRef(Callable&& callable)  // NOLINT: converts, as the parameter of a function does
      : callable_(const_cast<void*>(static_cast<const void*>(std::addressof(callable)))),
        call_([](void* to, Args... args) -> Result {
          return (*static_cast<std::remove_reference_t<Callable>*>(to))(std::forward<Args>(args)...);
        }) {}

  Result operator()(Args... args) const { return call_(callable_, std::forward<Args>(args)...); }

 private:
  void* callable_;
  Result (*call_)(void*, Args...);
};

}  // namespace fastlines
