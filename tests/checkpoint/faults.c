// Preloaded, lets calls fail as VISCOBAR_FAULT says, from the beginning of main() on:
//
//     malloc:N     the N-th allocation finds no memory, or the first behind it that is not one of HDF5 1.10 for itself
//                  (which then goes on in memory that it has freed) or of SUNContext_Create, SUNLogger_Create or
//                  ARKStepSetTableNum of SUNDIALS 6.4 and 7.1 (which use what they did not get)
//     write:N      from the N-th write on, files take nothing more: no space left
//     short:0      files take at most half of what a write offers, and a kilobyte
//     one-write:N  the N-th write alone fails: no space left
//     close:N      the N-th closing of a file fails: input/output error
//     rename:N     the N-th renaming of a file fails: input/output error
//     fsync:N      the N-th syncing of a file fails: input/output error
//     kill:N       SIGKILL at the N-th write, renaming, closing or syncing of a file
//
// VISCOBAR_FAULT_COUNT is a file to which the number of such calls is written at the end; with VISCOBAR_FAULT_TRACE an
// allocation that fails says who asked for it.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

enum { NONE, MALLOC, WRITE, SHORT, RENAME, FSYNC, ONE_WRITE, CLOSE, KILL };
static int kind = NONE;
static long chosen = 0;
static atomic_long calls = 0;

static atomic_int fired = 0;

static int for_library(void) {
  void* frames[64];
  Dl_info info;
  for (int i = 0, count = backtrace(frames, 64); i < count; ++i) {
    if (!dladdr(frames[i], &info) || !info.dli_fname) continue;
    const char* function = info.dli_sname ? info.dli_sname : "";
    if (strstr(info.dli_fname, "hdf5") || !strncmp(function, "H5", 2) || !strcmp(function, "SUNContext_Create") ||
        !strcmp(function, "SUNLogger_Create") || !strcmp(function, "ARKStepSetTableNum"))
      return 1;
  }
  return 0;
}

static int no_memory(void) {
  if (kind != MALLOC || atomic_fetch_add(&calls, 1) + 1 < chosen || chosen == 0 || fired || for_library()) return 0;
  fired = 1;
  if (getenv("VISCOBAR_FAULT_TRACE")) {
    void* frames[64];
    backtrace_symbols_fd(frames, backtrace(frames, 64), 2);
  }
  errno = ENOMEM;
  return 1;
}

static int nth(int of) { return kind == of && atomic_fetch_add(&calls, 1) + 1 == chosen; }
static int from_nth(int of) { return kind == of && atomic_fetch_add(&calls, 1) + 1 >= chosen; }

static void may_be_killed(void) {
  if (nth(KILL)) raise(SIGKILL);
}

static void arm(void) {
  static const char* const names[] = {
      "", "malloc:", "write:", "short:", "rename:", "fsync:", "one-write:", "close:", "kill:"};
  const char* fault = getenv("VISCOBAR_FAULT");
  if (!fault) return;
  void* frame;
  backtrace(&frame, 1);  // allocates when first called
  for (int k = MALLOC; k <= KILL; ++k) {
    if (strncmp(fault, names[k], strlen(names[k])) != 0) continue;
    chosen = atol(fault + strlen(names[k]));
    kind = k;
  }
}

__attribute__((destructor)) static void count(void) {
  const char* file = getenv("VISCOBAR_FAULT_COUNT");
  kind = NONE;
  FILE* out = file ? fopen(file, "w") : NULL;
  if (!out) return;
  fprintf(out, "%ld", atomic_load(&calls));
  fclose(out);
}

typedef int Main(int, char**, char**);
static Main* program;

static int armed_main(int argc, char** argv, char** environment) {
  arm();
  return program(argc, argv, environment);
}

int __libc_start_main(Main* main, int argc, char** argv, void (*init)(void), void (*fini)(void), void (*rtld)(void),
                      void* stack) {
  typedef int Start(Main*, int, char**, void (*)(void), void (*)(void), void (*)(void), void*);
  Start* start = (Start*)dlsym(RTLD_NEXT, "__libc_start_main");
  program = main;
  return start(armed_main, argc, argv, init, fini, rtld, stack);
}

void* malloc(size_t size) { return no_memory() ? NULL : __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return no_memory() ? NULL : __libc_calloc(count, size); }
void* realloc(void* old, size_t size) { return no_memory() ? NULL : __libc_realloc(old, size); }
void* memalign(size_t alignment, size_t size) { return no_memory() ? NULL : __libc_memalign(alignment, size); }
void* aligned_alloc(size_t alignment, size_t size) { return memalign(alignment, size); }
int posix_memalign(void** memory, size_t alignment, size_t size) {
  *memory = memalign(alignment, size);
  return *memory ? 0 : ENOMEM;
}

static int fails(int error) {
  errno = error;
  return -1;
}

// How much of a write gets through; 0 for none.
static size_t taken(int file, size_t count) {
  if (file <= 2) return count;
  may_be_killed();
  if (from_nth(WRITE) || nth(ONE_WRITE)) return 0;
  if (kind != SHORT || count < 2) return count;
  return count / 2 < 1024 ? count / 2 : 1024;
}

#define REAL(name, ...) ((ssize_t(*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void* data, size_t count) {
  const size_t some = taken(file, count);
  return some || !count ? REAL(write, int, const void*, size_t)(file, data, some) : fails(ENOSPC);
}
ssize_t writev(int file, const struct iovec* parts, int count) {
  return taken(file, 1) ? REAL(writev, int, const struct iovec*, int)(file, parts, count) : fails(ENOSPC);
}
ssize_t pwrite(int file, const void* data, size_t count, off_t at) {
  const size_t some = taken(file, count);
  return some || !count ? REAL(pwrite, int, const void*, size_t, off_t)(file, data, some, at) : fails(ENOSPC);
}
ssize_t pwrite64(int file, const void* data, size_t count, off64_t at) {
  const size_t some = taken(file, count);
  return some || !count ? REAL(pwrite64, int, const void*, size_t, off64_t)(file, data, some, at) : fails(ENOSPC);
}
int rename(const char* from, const char* to) {
  may_be_killed();
  return nth(RENAME) ? fails(EIO) : (int)REAL(rename, const char*, const char*)(from, to);
}
int close(int file) {
  if (file > 2) may_be_killed();
  const int failing = file > 2 && nth(CLOSE), closed = (int)REAL(close, int)(file);
  return failing ? fails(EIO) : closed;
}
void _Exit(int code) {
  count();
  ((void (*)(int))dlsym(RTLD_NEXT, "_Exit"))(code);
  abort();
}
int fsync(int file) {
  may_be_killed();
  return nth(FSYNC) ? fails(EIO) : (int)REAL(fsync, int)(file);
}
