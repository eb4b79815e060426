// Chooses the engine of an instruction set.
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <iterator>

#include "engine.hpp"
#include "engine/best_simd.hpp"

using fl::detail::Engine;

// CMake defines FASTLINES_ENGINES as ENGINE(avx512) ENGINE(avx2) …: the compiled ones, the widest first.
#define ENGINE(simd) const Engine* fastlines_engine_##simd();
extern "C" {
FASTLINES_ENGINES
}
#undef ENGINE

namespace fl {
namespace detail {
namespace {

/// The compiled engines, the widest first.
std::vector<const Engine*> engines() {
#define ENGINE(simd) fastlines_engine_##simd(),
  return {FASTLINES_ENGINES};
#undef ENGINE
}

/// The place of an instruction set among all of them, the widest first; their number for a name that is none.
std::size_t place_of(const char* simd) {
  std::size_t i = 0;
  while (i < std::size(fastlines::kSimdNames) && std::strcmp(fastlines::kSimdNames[i], simd) != 0) ++i;
  return i;
}

/// Whether this processor can run an engine.
bool can_run(const Engine& engine) { return place_of(engine.simd) >= place_of(fastlines::best_simd()); }

/// The engine of an instruction set, or the best one for nullptr. Throws InputError.
const Engine& find(const char* simd) {
  std::string available;
  for (const Engine* engine : engines()) {
    if (!can_run(*engine)) continue;
    if (!simd || std::strcmp(engine->simd, simd) == 0) return *engine;
    available += (available.empty() ? "" : ", ") + std::string(engine->simd);
  }
  if (!simd) throw InputError("this library is not compiled for the instruction sets of this processor");
  throw InputError("the instruction set \"" + std::string(simd) + "\" is not available here; expected one of " +
                   available);
}

std::atomic<const Engine*> chosen{nullptr};

}  // namespace

const Engine& current_engine() {
  if (const Engine* engine = chosen.load()) return *engine;
  const char* const given = std::getenv("FASTLINES_SIMD");
  // "host", "all" and lists name what is compiled, and leave the choice open.
  const bool is_choice =
      given && *given && std::strcmp(given, "host") != 0 && std::strcmp(given, "all") != 0 && !std::strchr(given, ';');
  const Engine& engine = find(is_choice ? given : nullptr);
  const Engine* none = nullptr;
  chosen.compare_exchange_strong(none, &engine);  // unless set_simd has chosen one meanwhile
  return *chosen.load();
}

}  // namespace detail

const char* simd() { return detail::current_engine().simd; }

void set_simd(const char* name) { detail::chosen.store(&detail::find(name)); }

const char* version() { return FASTLINES_VERSION; }

}  // namespace fl
