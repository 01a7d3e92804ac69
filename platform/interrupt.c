/* Signals that end the program, see interrupt.h. The handler calls nothing but functions that POSIX
 * allows there. SPDX-License-Identifier: Apache-2.0 */
#include "platform/interrupt.h"

#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
enum { SIGNAL_COUNT = sizeof signals / sizeof signals[0] };

static const char *volatile marked[THRUM_INTERRUPT_FILES];
static const char *volatile last_line;
static sigset_t held_before;
static pthread_t keeper; /* the thread that called thrum_interrupt_clean */

void thrum_interrupt_remove(void) {
  for (int i = 0; i < THRUM_INTERRUPT_FILES; i++)
    if (marked[i] != NULL && unlink(marked[i]) != 0)
      rmdir(marked[i]); // a new folder, as long as it is empty
}

static void end_cleanly(int number) {
  // any thread may get the signal, such as one of OpenBLAS; only the keeper's waits while it is
  // held
  if (!pthread_equal(pthread_self(), keeper)) {
    pthread_kill(keeper, number);
    return;
  }

  const char *line = last_line;
  thrum_interrupt_remove();
  if (line != NULL && write(STDERR_FILENO, line, strlen(line)) < 0)
    line = NULL;

  // the default action comes as soon as the handler returns
  signal(number, SIG_DFL);
  raise(number);
}

void thrum_interrupt_clean(const char *line) {
  last_line = line;
  keeper = pthread_self();

  struct sigaction action, before;
  memset(&action, 0, sizeof action);
  action.sa_handler = end_cleanly;

  // one at a time: a second signal waits for the first one's end
  sigemptyset(&action.sa_mask);

  for (int i = 0; i < SIGNAL_COUNT; i++)
    sigaddset(&action.sa_mask, signals[i]);

  // a signal that is ignored, as under nohup, stays ignored
  for (int i = 0; i < SIGNAL_COUNT; i++)
    if (sigaction(signals[i], NULL, &before) == 0 && before.sa_handler != SIG_IGN)
      sigaction(signals[i], &action, NULL);
}

void thrum_interrupt_mark(const char *temporary) {
  for (int i = 0; i < THRUM_INTERRUPT_FILES; i++)
    if (marked[i] == NULL) {
      marked[i] = temporary;
      return;
    }
}

bool thrum_interrupt_unmark(const char *temporary) {
  bool was = false;
  for (int i = 0; i < THRUM_INTERRUPT_FILES; i++)
    if (temporary != NULL && marked[i] == temporary) {
      marked[i] = NULL;
      was = true;
    }
  return was;
}

void thrum_interrupt_hold(void) {
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &held_before);
}

void thrum_interrupt_let(void) {
  pthread_sigmask(SIG_SETMASK, &held_before, NULL);
}
