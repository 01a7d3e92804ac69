/* The frame of a program, see program_guard.h. SPDX-License-Identifier: Apache-2.0 */
#include "app/program_guard.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "app/address_space.h"
#include "config/message.h"
#include "io/json.h"
#include "platform/interrupt.h"

/* Whether the command has come to its end. */
static bool ended;

/* A library that ends the program, as MUMPS does where it finds no memory, may do so with exit code
 * 0: that must not pass for success. */
static void note_exit(void) {
  if (ended)
    return;
  thrum_interrupt_remove();
  fputs("thrum: a library ended the program: out of memory?\n", stderr);
  fflush(stderr);
  _exit(COMMAND_REFUSED);
}

static bool is_closed(int number) {
  return fcntl(number, F_GETFD) == -1;
}

/* A closed standard stream would lend its number to the first file that is opened, and what is
 * printed would go into that file: a place that cannot be written to keeps the number. Without
 * standard output nothing is begun, for what is printed could not be, and a failure is to leave
 * everything as it was. */
static bool fill_standard_streams(void) {
  const bool silent = is_closed(STDOUT_FILENO);
  for (int number = STDIN_FILENO; number <= STDERR_FILENO; number++)
    if (is_closed(number) && open("/dev/null", O_RDONLY) != number)
      return false;

  if (silent)
    fputs("thrum: standard output is closed: send it to /dev/null if it is not wanted\n", stderr);
  return !silent;
}

bool program_guard_begin(char **argv) {
  if (!fill_standard_streams())
    return false;
  address_space_begin(argv);

  // commands that leave something say another line
  thrum_interrupt_clean("\nthrum: stopped; nothing was written\n");
  json_watch_memory();
  if (atexit(note_exit) != 0) {
    fputs("thrum: out of memory\n", stderr);
    return false;
  }
#ifdef SIGXFSZ
  // a file beyond the size limit is to be an error of writing and not the end of the program
  signal(SIGXFSZ, SIG_IGN);
#endif
  return true;
}

int program_guard_end(int code) {
  ended = true;

  // a report that lacks parts must not pass for a whole one
  if (json_memory_failed() && (code == COMMAND_DONE || code == COMMAND_FLAGGED)) {
    fputs("thrum: out of memory: the results are not complete\n", stderr);
    code = COMMAND_REFUSED;
  }

  // a full disk or a closed pipe must not pass for success
  if (fflush(stdout) != 0 || ferror(stdout)) {
    fputs("thrum: standard output could not be written\n", stderr);
    return code == COMMAND_DONE || code == COMMAND_FLAGGED ? COMMAND_REFUSED : code;
  }
  return code;
}
