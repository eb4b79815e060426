# Cross-compiles by zig, the Clang with libc++ and the systems' headers of the package ziglang, which must be in the Python
# on the PATH: `cmake --toolchain cpp/tests/zig.cmake -DZIG_TARGET=x86_64-windows-gnu`. Wine runs what is for Windows.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ZIG_TARGET)
string(REGEX MATCH "^([^-]+)-([^-]+)" _ "${ZIG_TARGET}")
set(CMAKE_SYSTEM_PROCESSOR ${CMAKE_MATCH_1})
if(CMAKE_MATCH_2 STREQUAL "windows")
  set(CMAKE_SYSTEM_NAME Windows)
  set(CMAKE_CROSSCOMPILING_EMULATOR wine)
elseif(CMAKE_MATCH_2 STREQUAL "macos")
  set(CMAKE_SYSTEM_NAME Darwin)
  set(CMAKE_INSTALL_NAME_TOOL true)  # nothing is installed
else()
  set(CMAKE_SYSTEM_NAME Linux)
endif()

set(CMAKE_C_COMPILER python -m ziglang cc -target ${ZIG_TARGET})
set(CMAKE_CXX_COMPILER python -m ziglang c++ -target ${ZIG_TARGET})
# CMake takes the archiver as one program.
foreach(tool ar ranlib)
  set(program ${CMAKE_BINARY_DIR}/zig-${tool})
  file(WRITE ${program} "#!/bin/sh\nexec python -m ziglang ${tool} \"$@\"\n")
  file(CHMOD ${program} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  string(TOUPPER CMAKE_${tool} variable)
  set(${variable} ${program})
endforeach()
