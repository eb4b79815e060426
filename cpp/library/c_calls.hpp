// What the functions of the C interface share: each calls the C++ one, and turns exceptions into a status and a
// message.
#pragma once

#include <cstring>
#include <new>
#include <span>
#include <string>

#include "fastlines/api/tree.hpp"
#include "fastlines/fastlines.h"

struct fl_tree {
  fl::Tree tree;
};

namespace fl::detail {

/// Keeps what `fl_error_message` returns, and returns the status.
fl_status fail(fl_status status, const char* what);

/// Calls call() and returns its status.
template <class Call>
fl_status guarded(Call&& call) noexcept {
  try {
    call();
    return FL_OK;
  } catch (const fl::InputError& error) {
    return fail(FL_INPUT_ERROR, error.what());
  } catch (const fl::FileError& error) {
    return fail(FL_FILE_ERROR, error.what());
  } catch (const fl::Cancelled& error) {
    return fail(FL_CANCELLED, error.what());
  } catch (const std::bad_alloc&) {
    return fail(FL_NO_MEMORY, "there is not enough memory");
  } catch (const std::exception& error) {
    return fail(FL_OTHER_ERROR, error.what());
  } catch (...) {
    return fail(FL_OTHER_ERROR, "an unknown error");
  }
}

inline void require(const void* pointer, const char* name) {
  if (!pointer) throw fl::InputError(std::string(name) + " is NULL; expected a pointer");
}

/// Copies a column, if the caller wants it.
template <class T>
void copy_if(std::span<const T> from, T* to) {
  if (to && !from.empty()) std::memcpy(to, from.data(), from.size_bytes());
}

}  // namespace fl::detail
