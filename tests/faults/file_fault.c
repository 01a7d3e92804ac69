/* Runs a program and fails one of its calls to the kernel that read or write files, or all from one
 * on. It sees what the C library does inside, such as the writes of a buffered stream, which a
 * library for LD_PRELOAD does not. For tests on Linux on x86-64.
 *
 *   file_fault KIND COUNT_FILE AT PROGRAM ARGUMENTS
 *
 * KIND is one of the names below; AT is which call fails, from 1; 0: none. COUNT_FILE gets a line
 * for each kind when the program ends, its name and the number of its calls; "-": none. Calls on
 * the standard error do not count, nor do those of programs that the program starts. Ends as the
 * program does; 125 where the kernel does not let one process trace another.
 * SPDX-License-Identifier: Apache-2.0 */
#define _GNU_SOURCE // WALL
#include <errno.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#define NO_TRACE 125
#define THREADS_MAX 256
#define CALLS_MAX 6

/* A kind of fault: the calls of the kernel that fail, and the errno that they give. */
typedef struct fault {
  const char *name;
  long calls[CALLS_MAX]; /* ends with -1 */
  int number;            /* errno */
  bool from_there_on;    /* all that follow fail as well */
  bool after;            /* the call is made, and then says that it failed */
} fault;

static const fault faults[] = {
    {"open", {SYS_open, SYS_openat, -1}, EMFILE, false, false},
    {"read", {SYS_read, SYS_pread64, SYS_readv, -1}, EIO, false, false},
    {"write", {SYS_write, SYS_pwrite64, SYS_writev, -1}, EIO, false, false},
    {"full",
     {SYS_write, SYS_pwrite64, SYS_writev, SYS_ftruncate, SYS_mkdir, -1},
     ENOSPC,
     true,
     false},
    {"fsync", {SYS_fsync, SYS_fdatasync, -1}, EIO, false, false},
    {"close", {SYS_close, -1}, EIO, false, true},
    {"rename", {SYS_rename, SYS_renameat, SYS_renameat2, -1}, EIO, false, false},
    {"folder", {SYS_mkdir, SYS_mkdirat, -1}, EACCES, false, false},
    {"remove", {SYS_unlink, SYS_unlinkat, SYS_rmdir, -1}, EACCES, false, false},
};
#define FAULTS (sizeof faults / sizeof *faults)

/* A thread of the program: whether it is inside a call, and whether that one fails. */
typedef struct thread {
  pid_t id;
  bool inside, fails;
} thread;

static thread threads[THREADS_MAX];

static thread *thread_of(pid_t id) {
  for (int n = 0; n < THREADS_MAX; n++)
    if (threads[n].id == id)
      return &threads[n];
  for (int n = 0; n < THREADS_MAX; n++)
    if (threads[n].id == 0) {
      threads[n] = (thread){.id = id};
      return &threads[n];
    }
  fputs("file_fault: too many threads\n", stderr);
  exit(NO_TRACE);
}

static bool is_of(const fault *what, const struct user_regs_struct *registers) {
  for (int n = 0; what->calls[n] >= 0; n++)
    if ((long)registers->orig_rax == what->calls[n]) {
      const bool on_a_number = what->calls[n] == SYS_read || what->calls[n] == SYS_write ||
                               what->calls[n] == SYS_writev || what->calls[n] == SYS_close;
      return !on_a_number || registers->rdi != STDERR_FILENO;
    }
  return false;
}

/* A thread has stopped before or after a call; counted has a number of calls for each fault. */
static void at_call(const fault *what, thread *of, long at, long *counted) {
  struct user_regs_struct registers;
  if (ptrace(PTRACE_GETREGS, of->id, NULL, &registers) != 0)
    return;
  of->inside = !of->inside;

  // before: a call that is to fail becomes none, where it is not to be made
  if (of->inside) {
    for (size_t n = 0; n < FAULTS; n++)
      counted[n] += is_of(&faults[n], &registers);
    if (!is_of(what, &registers))
      return;
    const long number = counted[what - faults];
    of->fails = number == at || (what->from_there_on && at > 0 && number > at);
    if (of->fails && !what->after) {
      registers.orig_rax = (unsigned long long)-1;
      ptrace(PTRACE_SETREGS, of->id, NULL, &registers);
    }
    return;
  }

  if (of->fails) {
    registers.rax = (unsigned long long)-what->number;
    ptrace(PTRACE_SETREGS, of->id, NULL, &registers);
  }
  of->fails = false;
}

/* Follows all threads until the program has ended; its exit code. */
static int follow(pid_t program, const fault *what, long at, long *counted) {
  int status;
  for (;;) {
    const pid_t id = waitpid(-1, &status, __WALL);
    if (id < 0)
      return NO_TRACE;
    thread *of = thread_of(id);
    if (WIFEXITED(status) || WIFSIGNALED(status)) {
      of->id = 0;
      if (id == program)
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      continue;
    }

    // 0x80 marks a call; the rest are signals, which are handed on, and events of the tracing
    int signal = WSTOPSIG(status);
    if (signal == (SIGTRAP | 0x80))
      at_call(what, of, at, counted);
    if ((signal & ~0x80) == SIGTRAP || signal == SIGSTOP)
      signal = 0;
    ptrace(PTRACE_SYSCALL, id, NULL, (void *)(intptr_t)signal);
  }
}

int main(int argc, char **argv) {
  const fault *what = NULL;
  for (size_t n = 0; argc > 4 && n < FAULTS; n++)
    if (strcmp(argv[1], faults[n].name) == 0)
      what = &faults[n];
  if (what == NULL) {
    fputs("usage: file_fault KIND COUNT_FILE AT PROGRAM ARGUMENTS\n", stderr);
    return 2;
  }

  // the program waits until it is traced
  const pid_t program = fork();
  if (program == 0) {
    if (ptrace(PTRACE_TRACEME, 0, NULL, NULL) != 0)
      _exit(NO_TRACE);
    raise(SIGSTOP);
    execv(argv[4], argv + 4);
    _exit(127);
  }

  int status;
  if (program < 0 || waitpid(program, &status, 0) != program || !WIFSTOPPED(status) ||
      ptrace(PTRACE_SETOPTIONS, program, NULL,
             (void *)(intptr_t)(PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_EXITKILL)) !=
          0)
    return NO_TRACE;
  ptrace(PTRACE_SYSCALL, program, NULL, NULL);

  long counted[FAULTS] = {0};
  const int code = follow(program, what, atol(argv[3]), counted);
  FILE *file = strcmp(argv[2], "-") != 0 ? fopen(argv[2], "w") : NULL;
  if (file != NULL) {
    for (size_t n = 0; n < FAULTS; n++)
      fprintf(file, "%s %ld\n", faults[n].name, counted[n]);
    fclose(file);
  }
  return code;
}
