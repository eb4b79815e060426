# The instruction sets that engines are compiled for (`simd_sets`) and the flags of each (`simd_NAME`). The portable code
# is for other processors: NumPy too needs SSE4.2 or NEON. The C++ tests compile it everywhere.
if(CMAKE_CXX_COMPILER_ID STREQUAL "MSVC")
  message(FATAL_ERROR "fastlines needs GCC 12, Clang 16 or later. On Windows, use clang-cl: cmake -T ClangCL")
elseif(MINGW AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  message(FATAL_ERROR "MinGW's GCC frees thread_local objects before it destroys them. Use Clang, such as clang-cl.")
endif()
set(CMAKE_CXX_SCAN_FOR_MODULES OFF)  # there are none, and with Clang the scan needs another program
set(simd_portable -DFASTLINES_PORTABLE)
set(processor ${CMAKE_SYSTEM_PROCESSOR})
if(APPLE AND CMAKE_OSX_ARCHITECTURES)
  set(processor ${CMAKE_OSX_ARCHITECTURES})
endif()
if(processor MATCHES "x86_64|AMD64")
  set(simd_sets sse42 avx2 avx512)
  set(simd_sse42 -msse4.2)
  # GCC's default tuning splits unaligned loads. Of six others tried with AVX-512, haswell was the fastest.
  set(simd_avx2 -mavx2 -mfma -mbmi -mbmi2 -mtune=haswell)
  # Ice Lake, Zen 4 and later: with dot products of bytes (VNNI).
  set(simd_avx512 -mavx512f -mavx512dq -mavx512vl -mavx512bw -mavx512vbmi -mavx512vnni -mavx2 -mfma
                  -mbmi -mbmi2 -mtune=haswell -mprefer-vector-width=512)
elseif(processor MATCHES "aarch64|arm64|ARM64")
  set(simd_sets neon)
else()
  set(simd_sets portable)
endif()

set(cpp_dir ${CMAKE_CURRENT_LIST_DIR})

# The widest set that the processor of this machine has, or all sets when compiling for another machine.
function(find_host_simd to)
  set(${to} ${simd_sets} PARENT_SCOPE)
  list(LENGTH simd_sets n_sets)
  if(n_sets EQUAL 1 OR CMAKE_CROSSCOMPILING OR CMAKE_OSX_ARCHITECTURES)
    return()
  endif()
  set(program ${CMAKE_BINARY_DIR}/CMakeFiles/host_simd.cpp)
  file(WRITE ${program} "#include <cstdio>\n#include \"engine/best_simd.hpp\"\n"
                        "int main() { std::puts(fastlines::best_simd()); }\n")
  try_run(FASTLINES_HOST_SIMD_EXIT FASTLINES_HOST_SIMD_COMPILED ${CMAKE_BINARY_DIR}/CMakeFiles ${program}
          CMAKE_FLAGS -DINCLUDE_DIRECTORIES=${cpp_dir} RUN_OUTPUT_VARIABLE found)
  string(STRIP "${found}" found)
  if(NOT FASTLINES_HOST_SIMD_COMPILED OR NOT found MATCHES "^(sse42|avx2|avx512|portable)$")
    message(FATAL_ERROR "cannot find out which instruction set this processor has: pass -DFASTLINES_SIMD=all")
  endif()
  set(${to} ${found} PARENT_SCOPE)
endfunction()

# The instruction sets to compile for. Whatever is to run on other machines needs all of them.
set(FASTLINES_SIMD host CACHE STRING "The instruction sets to compile for: host, all, or a list")
if(FASTLINES_SIMD STREQUAL "host" OR FASTLINES_SIMD STREQUAL "")
  find_host_simd(simd_to_build)
elseif(FASTLINES_SIMD STREQUAL "all")
  set(simd_to_build ${simd_sets})
else()
  set(simd_to_build ${FASTLINES_SIMD})
endif()
foreach(simd IN LISTS simd_to_build)
  if(NOT simd IN_LIST simd_sets AND NOT simd STREQUAL "portable")
    message(FATAL_ERROR "FASTLINES_SIMD=${FASTLINES_SIMD}: expected host, all, or some of ${simd_sets} and portable")
  endif()
endforeach()

# Answers are defined to the bit: the compiler must not contract to fused multiply-adds.
# Nothing reads errno after sqrt or relies on floating-point traps. Saying so lets the compiler vectorise loops over rays
# and changes no bit. A parent project's -ffast-math would change bits.
set(simd_all -fno-fast-math -ffp-contract=off -fno-math-errno -fno-trapping-math)
set(simd_warnings -Wall -Wextra -Wno-psabi)
if(MSVC)  # clang-cl hides these options behind a prefix, and its -Wall turns on every warning there is
  list(TRANSFORM simd_all PREPEND "/clang:")
  set(simd_warnings /W4)
endif()

# The sources that are compiled for each instruction set: for modules and the library, and for modules alone. Those that
# take longest come first, so that the others compile beside them. The bindings are compiled as one, since most of their
# time goes into the same headers.
set(engine_sources)
foreach(part queries_segments queries_round_cones trees points pairs)
  list(APPEND engine_sources ${cpp_dir}/engine/${part}.cpp)
endforeach()
set(module_sources ${cpp_dir}/engine/queries_shapes.cpp ${cpp_dir}/engine/queries_spread_cones.cpp)
foreach(part engine_query engine_gather engine_points engine_pairs engine_in_box engine_routes engine_frames engine_build engine_layout
        engine_hair engine_paths engine_looks engine)
  list(APPEND module_sources ${cpp_dir}/bindings/${part}.cpp)
  list(APPEND module_bindings ${cpp_dir}/bindings/${part}.cpp)
endforeach()

# In nanobind's split mode, modules use the stable ABI of Python, and the package nanobind-backend has what depends on
# Python's version. Where there is no such package, -DFASTLINES_BACKEND= links nanobind into each module. Modules keep
# no state between calls, so free-threaded builds of Python run them without the GIL.
set(FASTLINES_BACKEND nanobind_backend CACHE STRING "The Python module that has nanobind; empty links it statically")
set(nanobind_mode NB_STATIC FREE_THREADED)
if(FASTLINES_BACKEND)
  set(nanobind_mode BACKEND_MODULE ${FASTLINES_BACKEND} FREE_THREADED)
endif()

# Compiles these sources of the target `name` as one unit.
function(compile_as_one name)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  set_source_files_properties(${ARGN} PROPERTIES UNITY_GROUP bindings)
endfunction()

# Adds the flags of the instruction set `simd` to the target `name`.
function(compile_for_simd name simd)
  target_link_libraries(${name} PRIVATE fastlines_core)
  # Unique symbols would be shared by all instruction sets in a process, and optimisation at link time would merge their
  # functions.
  target_compile_options(${name} PRIVATE ${simd_warnings} $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique -fno-lto>
                                         ${simd_${simd}})
  # Before GCC 13, the AVX-512 intrinsics start from a variable that is initialised with itself, which GCC warns about.
  if(simd STREQUAL "avx512" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
    target_compile_options(${name} PRIVATE -Wno-uninitialized -Wno-maybe-uninitialized)
  endif()
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_VISIBILITY_PRESET hidden
                                           VISIBILITY_INLINES_HIDDEN ON INTERPROCEDURAL_OPTIMIZATION OFF)
endfunction()

# Adds the Python module `name` with the sources ARGN for the instruction set `simd`. It exports only its init function.
set(simd_exports ${cpp_dir}/bindings/exports.map)
function(add_simd_module name simd)
  nanobind_add_module(${name} ${nanobind_mode} NOMINSIZE ${ARGN})
  compile_as_one(${name} ${module_bindings})
  compile_for_simd(${name} ${simd})
  target_compile_definitions(${name} PRIVATE FASTLINES_MODULE=${name})
  if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
    target_link_options(${name} PRIVATE "LINKER:--version-script=${simd_exports}")
  endif()
endfunction()
