// A library for LD_PRELOAD whose calls that change, or read, files below one folder fail on demand: the n-th, or all
// from there.
#include <dlfcn.h>
#include <fcntl.h>
#include <limits.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

char folder[PATH_MAX];
enum Kind { kNone = 0, kChanges = 1, kReads = 2 };
int armed = kNone;  // the kind that fails
long n_seen = 0, fail_from = 0, fail_to = 0;
int fail_with = 0;
char failed[32];

/// A folder counts as below itself.
bool is_below(const char* path) {
  const std::size_t n = std::strlen(folder);
  return path && std::strncmp(path, folder, n) == 0 && (path[n] == '/' || path[n] == 0);
}

bool is_below(int descriptor) {
  char link[64], path[PATH_MAX];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t n = readlink(link, path, sizeof path - 1);
  if (n < 0) return false;
  path[n] = 0;
  return is_below(path);
}

template <class File>
bool fails(const char* call, File file, int kind = kChanges) {
  if (armed != kind || !is_below(file)) return false;
  const long i = ++n_seen;
  if (i < fail_from || i > fail_to) return false;
  if (i == fail_from) std::snprintf(failed, sizeof failed, "%s", call);
  errno = fail_with;
  return true;
}

/// Whether a call that reads fails, or reads half, which is a fault without an error number.
template <class File>
bool fails_to_read(const char* call, File file, std::size_t* n = nullptr) {
  if (armed != kReads || (!fail_with && (!n || *n < 2)) || !fails(call, file, kReads)) return false;
  if (fail_with) return true;
  *n /= 2;
  return false;
}

/// The function of the C library of the same type and name.
template <class Function>
Function* next(Function*, const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

/// Opening to read, and folders, do not count.
bool changes(int flags) { return (flags & O_ACCMODE) != O_RDONLY && !(flags & O_DIRECTORY); }

bool opening_fails(int flags, const char* path) {
  if (changes(flags)) return fails("open", path);
  return !(flags & O_DIRECTORY) && fails_to_read("open", path);
}

int mode_of(int flags, va_list more) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(more, int) : 0; }

}  // namespace

#define NEXT(name) (next(&name, #name))

extern "C" {

/// From now on calls first to last of a kind, on a folder and files below it, fail with an error number. Reads fail
/// with 0 by reading half.
void faults_arm(int kind, const char* below, int error, long first, long last) {
  std::snprintf(folder, sizeof folder, "%s", below);
  n_seen = 0, fail_from = first, fail_to = last, fail_with = error, failed[0] = 0;
  armed = kind;
}

/// Ends that, and returns how many calls there were.
long faults_disarm() {
  armed = kNone;
  return n_seen;
}

/// The first call that failed.
const char* faults_failed() { return failed; }

#define OPEN(name)                                                          \
  int name(const char* path, int flags, ...) {                              \
    va_list more;                                                           \
    va_start(more, flags);                                                  \
    const int mode = mode_of(flags, more);                                  \
    va_end(more);                                                           \
    return opening_fails(flags, path) ? -1 : NEXT(name)(path, flags, mode); \
  }
OPEN(open)
OPEN(open64)

#define OPEN_AT(name)                                                           \
  int name(int at, const char* path, int flags, ...) {                          \
    va_list more;                                                               \
    va_start(more, flags);                                                      \
    const int mode = mode_of(flags, more);                                      \
    va_end(more);                                                               \
    return opening_fails(flags, path) ? -1 : NEXT(name)(at, path, flags, mode); \
  }
OPEN_AT(openat)
OPEN_AT(openat64)

FILE* fopen(const char* path, const char* mode) {
  const bool is_failing = mode[0] == 'r' ? fails_to_read("open", path) : fails("open", path);
  return is_failing ? nullptr : NEXT(fopen)(path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  const bool is_failing = mode[0] == 'r' ? fails_to_read("open", path) : fails("open", path);
  return is_failing ? nullptr : NEXT(fopen64)(path, mode);
}

ssize_t write(int file, const void* data, size_t n) { return fails("write", file) ? -1 : NEXT(write)(file, data, n); }
ssize_t pwrite(int file, const void* data, size_t n, off_t at) {
  return fails("write", file) ? -1 : NEXT(pwrite)(file, data, n, at);
}
ssize_t pwrite64(int file, const void* data, size_t n, off64_t at) {
  return fails("write", file) ? -1 : NEXT(pwrite64)(file, data, n, at);
}
ssize_t writev(int file, const iovec* parts, int n) { return fails("write", file) ? -1 : NEXT(writev)(file, parts, n); }
size_t fwrite(const void* data, size_t size, size_t n, FILE* file) {
  return fails("write", fileno(file)) ? 0 : NEXT(fwrite)(data, size, n, file);
}
int fputs(const char* text, FILE* file) { return fails("write", fileno(file)) ? EOF : NEXT(fputs)(text, file); }
int fputc(int character, FILE* file) { return fails("write", fileno(file)) ? EOF : NEXT(fputc)(character, file); }
int vfprintf(FILE* file, const char* format, va_list values) {
  return fails("write", fileno(file)) ? -1 : NEXT(vfprintf)(file, format, values);
}
int fprintf(FILE* file, const char* format, ...) {
  va_list values;
  va_start(values, format);
  const int n = vfprintf(file, format, values);
  va_end(values);
  return n;
}
int fflush(FILE* file) { return file && fails("write", fileno(file)) ? EOF : NEXT(fflush)(file); }

/// What is buffered is written, or not; the file is closed in any case.
int fclose(FILE* file) {
  const bool is_failing = changes(fcntl(fileno(file), F_GETFL)) && fails("close", fileno(file));
  const int error = errno, result = NEXT(fclose)(file);
  if (!is_failing) return result;
  errno = error;
  return EOF;
}

ssize_t read(int file, void* to, size_t n) { return fails_to_read("read", file, &n) ? -1 : NEXT(read)(file, to, n); }
ssize_t pread(int file, void* to, size_t n, off_t at) {
  return fails_to_read("read", file, &n) ? -1 : NEXT(pread)(file, to, n, at);
}
ssize_t pread64(int file, void* to, size_t n, off64_t at) {
  return fails_to_read("read", file, &n) ? -1 : NEXT(pread64)(file, to, n, at);
}
size_t fread(void* to, size_t size, size_t n, FILE* file) {
  return fails_to_read("read", fileno(file)) ? 0 : NEXT(fread)(to, size, n, file);
}
void* mmap(void* at, size_t n, int protection, int flags, int file, off_t from) {
  return file >= 0 && fails_to_read("map", file) ? MAP_FAILED : NEXT(mmap)(at, n, protection, flags, file, from);
}
void* mmap64(void* at, size_t n, int protection, int flags, int file, off64_t from) {
  return file >= 0 && fails_to_read("map", file) ? MAP_FAILED : NEXT(mmap64)(at, n, protection, flags, file, from);
}

ssize_t sendfile(int to, int from, off_t* at, size_t n) {
  return fails("write", to) ? -1 : NEXT(sendfile)(to, from, at, n);
}
ssize_t sendfile64(int to, int from, off64_t* at, size_t n) {
  return fails("write", to) ? -1 : NEXT(sendfile64)(to, from, at, n);
}
ssize_t copy_file_range(int from, off64_t* from_at, int to, off64_t* to_at, size_t n, unsigned flags) {
  return fails("write", to) ? -1 : NEXT(copy_file_range)(from, from_at, to, to_at, n, flags);
}

int fsync(int file) { return fails("fsync", file) ? -1 : NEXT(fsync)(file); }
int fdatasync(int file) { return fails("fsync", file) ? -1 : NEXT(fdatasync)(file); }
int ftruncate(int file, off_t n) { return fails("truncate", file) ? -1 : NEXT(ftruncate)(file, n); }
int ftruncate64(int file, off64_t n) { return fails("truncate", file) ? -1 : NEXT(ftruncate64)(file, n); }
int rename(const char* from, const char* to) { return fails("rename", to) ? -1 : NEXT(rename)(from, to); }
int renameat(int from_at, const char* from, int to_at, const char* to) {
  return fails("rename", to) ? -1 : NEXT(renameat)(from_at, from, to_at, to);
}
int mkdir(const char* path, mode_t mode) { return fails("mkdir", path) ? -1 : NEXT(mkdir)(path, mode); }

/// As on Linux, the file is closed even if that fails. Files that were only read do not count.
int close(int file) {
  const bool is_failing = changes(fcntl(file, F_GETFL)) && fails("close", file);
  const int error = errno, result = NEXT(close)(file);
  if (!is_failing) return result;
  errno = error;
  return -1;
}

}  // extern "C"
