/* Signals that end the program, see interrupt.h. The handler calls nothing but functions that POSIX
 * allows there. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/interrupt.h"

#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
enum { SIGNAL_COUNT = sizeof signals / sizeof signals[0] };

static const char *volatile marked;
static const char *volatile last_line;
static sigset_t held_before;

static void end_cleanly(int number) {
  const char *temporary = marked, *line = last_line;
  if (temporary != NULL)
    unlink(temporary);
  if (line != NULL && write(STDERR_FILENO, line, strlen(line)) < 0)
    line = NULL;
  // SA_RESETHAND has put the default action back; it comes as soon as the handler returns
  raise(number);
}

void thrum_interrupt_clean(const char *line) {
  last_line = line;
  struct sigaction action, before;
  memset(&action, 0, sizeof action);
  action.sa_handler = end_cleanly;
  action.sa_flags = (int)SA_RESETHAND;
  // one at a time: a second signal waits for the first one's end
  sigemptyset(&action.sa_mask);
  for (int i = 0; i < SIGNAL_COUNT; i++)
    sigaddset(&action.sa_mask, signals[i]);
  for (int i = 0; i < SIGNAL_COUNT; i++)
    if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
      sigaction(signals[i], &action, NULL);
}

void thrum_interrupt_mark(const char *temporary) {
  marked = temporary;
}

void thrum_interrupt_hold(void) {
  sigset_t all;
  sigfillset(&all);
  sigprocmask(SIG_BLOCK, &all, &held_before);
}

void thrum_interrupt_let(void) {
  sigprocmask(SIG_SETMASK, &held_before, NULL);
}
