/* Runs other programs, without a shell and without input. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_PROGRAM_H
#define THRUM_PLATFORM_PROGRAM_H

#include <signal.h>
#include <stdbool.h>
#include <sys/types.h>

/* Where a program runs; {0} is this folder, with all that it prints thrown away. */
typedef struct program_place {
  const char *folder;      /* NULL: that of this program */
  const char *log;         /* file for what it prints; NULL: none */
  bool messages;           /* what it prints goes to our standard error instead */
  bool own_group;          /* Ctrl-C in the terminal does not reach it */
  const sigset_t *signals; /* its signal mask; NULL: ours */
} program_place;

/* Starts argv[0], found in PATH. Returns 0 or the errno of what failed. */
int program_start(char *const *argv, const program_place *place, pid_t *child);

/* Starts it and waits; returns whether it was found and ended with 0. */
bool program_run(char *const *argv, const program_place *place);

/* Returns whether there is a program of that name in PATH. */
bool program_exists(const char *name);

#endif
