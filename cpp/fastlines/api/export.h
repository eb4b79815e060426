/* FASTLINES_API marks what the compiled library exports. With Windows' DLL, define FASTLINES_SHARED. */
#ifndef FASTLINES_EXPORT_H
#define FASTLINES_EXPORT_H

#if defined(__SIZEOF_POINTER__) && __SIZEOF_POINTER__ != 8
#error "fastlines needs a 64-bit processor: sizes of trees and answers pass 2^32 bytes"
#endif

#if defined(_WIN32) && defined(FASTLINES_BUILDS)
#define FASTLINES_API __declspec(dllexport)
#elif defined(_WIN32) && defined(FASTLINES_SHARED)
#define FASTLINES_API __declspec(dllimport)
#elif defined(_WIN32)
#define FASTLINES_API
#else
#define FASTLINES_API __attribute__((visibility("default")))
#endif

#endif
