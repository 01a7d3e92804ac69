/* A library for LD_PRELOAD that fails one allocation of a program, or all from one on, and counts
 * them. For tests on glibc.
 *
 *   THRUM_FAULT_AT     which allocation fails, from 1; 0 or not set: none
 *   THRUM_FAULT_ALL    set: all from that one on fail
 *   THRUM_FAULT_COUNT  path of a file that gets the number of allocations when the program ends
 *
 * A crash ends the program with exit code 139, after a line with the functions that it was in.
 * Allocations that the loader and the C library make before main are not counted, nor those that
 * gcov makes at the end.
 * SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE // dladdr
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <malloc.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <ucontext.h>
#include <unistd.h>

#define CRASHED 139
#define FRAMES 24

// glibc's own, which these stand in front of
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static atomic_long counted;
static const char *count_path;
static long fail_at;
static bool fail_all, begun;

static void say(const char *text) {
  if (write(STDERR_FILENO, text, strlen(text)) < 0)
    _exit(CRASHED);
}

/* Says where an address lies. */
static void say_place(void *address) {
  Dl_info info;
  if (dladdr(address, &info) == 0 || info.dli_fname == NULL)
    return;
  const char *slash = strrchr(info.dli_fname, '/');
  say(" ");
  say(slash != NULL ? slash + 1 : info.dli_fname);
  say(":");
  say(info.dli_sname != NULL ? info.dli_sname : "?");
}

/* Says which functions of which libraries the crash was in, the innermost first. A stack that is
 * broken ends this by a second crash. */
static void crash(int number, siginfo_t *about, void *context) {
  void *frames[FRAMES];
  (void)about;
  begun = false;
  say(number == SIGABRT ? "aborted in" : "crashed in");
#ifdef __x86_64__
  say_place((void *)((ucontext_t *)context)->uc_mcontext.gregs[REG_RIP]);
#else
  (void)context;
#endif
  const int count = backtrace(frames, FRAMES);
  for (int n = 2; n < count; n++)
    say_place(frames[n]);
  say("\n");
  _exit(CRASHED);
}

__attribute__((constructor)) static void begin(void) {
  static const int signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
  static char memory[1 << 16];
  const stack_t stack = {.ss_sp = memory, .ss_size = sizeof memory};
  struct sigaction action = {.sa_sigaction = crash,
                             .sa_flags = (int)(SA_SIGINFO | SA_ONSTACK | SA_RESETHAND)};
  void *frames[2];
  const char *at = getenv("THRUM_FAULT_AT");
  fail_at = at != NULL ? atol(at) : 0;
  fail_all = getenv("THRUM_FAULT_ALL") != NULL;
  count_path = getenv("THRUM_FAULT_COUNT");

  // the first backtrace takes memory, which must not count later
  backtrace(frames, 2);
  sigaltstack(&stack, NULL);
  for (size_t n = 0; n < sizeof signals / sizeof signals[0]; n++)
    sigaction(signals[n], &action, NULL);

  // programs that this one starts run undisturbed
  unsetenv("LD_PRELOAD");
  begun = true;
}

__attribute__((destructor)) static void end(void) {
  begun = false;
  FILE *file = count_path != NULL ? fopen(count_path, "w") : NULL;
  if (file == NULL)
    return;
  fprintf(file, "%ld\n", atomic_load(&counted));
  fclose(file);
}

static bool fails(void) {
  if (!begun)
    return false;
  const long number = atomic_fetch_add(&counted, 1) + 1;
  if (number != fail_at && !(fail_all && fail_at > 0 && number > fail_at))
    return false;
  errno = ENOMEM;
  return true;
}

/* A program that counts what it reaches (gcc --coverage) asks for this when it has ended and begins
 * to write its counts, which finds no memory of its own to be lacking. */
char *getenv(const char *name) {
  const size_t length = strlen(name);
  if (strncmp(name, "GCOV_", 5) == 0)
    begun = false;
  for (char **at = environ; at != NULL && *at != NULL; at++)
    if (strncmp(*at, name, length) == 0 && (*at)[length] == '=')
      return *at + length + 1;
  return NULL;
}

void *malloc(size_t size) {
  return fails() ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
  return fails() ? NULL : __libc_calloc(count, size);
}

void *realloc(void *memory, size_t size) {
  return fails() ? NULL : __libc_realloc(memory, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
  return fails() ? NULL : __libc_memalign(alignment, size);
}

void *memalign(size_t alignment, size_t size) {
  return fails() ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void **memory, size_t alignment, size_t size) {
  void *made = fails() ? NULL : __libc_memalign(alignment, size);
  if (made == NULL)
    return ENOMEM;
  *memory = made;
  return 0;
}
