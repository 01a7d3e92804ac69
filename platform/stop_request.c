/* Signals that ask a long loop to stop, see stop_request.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/stop_request.h"

#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stddef.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Looks at whether a request was heeded, 20 ms apart, before a long call is given up. */
enum { LOOKS = 50, LOOK_NANOSECONDS = 20000000 };

static volatile sig_atomic_t requested;
static sem_t noted; /* posted with it */

/* Below `lock`: who ends the program, and how. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static bool heeded, ending;
static void (*end_by)(void *context);
static void *end_context;

static void note_request(int signal_number) {
  (void)signal_number;
  requested = 1;
  sem_post(&noted);
}

/* Has the request been heeded, or else, is there a way to end without that? */
static bool take_over(void (**end)(void *context), void **context, bool *done) {
  pthread_mutex_lock(&lock);
  *done = heeded;
  ending = !heeded && end_by != NULL;
  *end = end_by;
  *context = end_context;
  pthread_mutex_unlock(&lock);
  return ending;
}

static void *watch(void *unused) {
  (void)unused;
  while (sem_wait(&noted) != 0)
    continue;

  // a loop that looks often ends in order
  const struct timespec pause = {0, LOOK_NANOSECONDS};
  bool done = false;
  void (*end)(void *context) = NULL;
  void *context = NULL;
  for (int n = 0; n < LOOKS && !done; n++) {
    nanosleep(&pause, NULL);
    pthread_mutex_lock(&lock);
    done = heeded;
    pthread_mutex_unlock(&lock);
  }
  while (!done && !take_over(&end, &context, &done))
    nanosleep(&pause, NULL);
  if (!done)
    end(context);
  return NULL;
}

/* The thread that waits for the signal, which no signal interrupts. Without it long calls are
 * waited for. */
static void start_watch(void) {
  sigset_t all, before;
  pthread_t thread;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, &before);
  if (pthread_create(&thread, NULL, watch, NULL) == 0)
    pthread_detach(thread);
  pthread_sigmask(SIG_SETMASK, &before, NULL);
}

void thrum_stop_request_catch(void) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
  sem_init(&noted, 0, 0);
  start_watch();
  for (size_t n = 0; n < sizeof signals / sizeof signals[0]; n++) {
    struct sigaction action;
    if (sigaction(signals[n], NULL, &action) != 0 || action.sa_handler == SIG_IGN)
      continue;

    // the handler is taken away by its first call, so the next signal has its default action
    memset(&action, 0, sizeof action);
    action.sa_handler = note_request;
    action.sa_flags = (int)SA_RESETHAND;
    sigemptyset(&action.sa_mask);
    sigaction(signals[n], &action, NULL);
  }
}

/* Locks; where the other thread ends the program already, this one goes no further. */
static void lock_or_wait(void) {
  pthread_mutex_lock(&lock);
  while (ending) {
    pthread_mutex_unlock(&lock);
    pause();
    pthread_mutex_lock(&lock);
  }
}

bool thrum_stop_requested(void) {
  if (requested == 0)
    return false;
  lock_or_wait();
  heeded = true;
  pthread_mutex_unlock(&lock);
  return true;
}

void thrum_stop_request_end_by(void (*end)(void *context), void *context) {
  lock_or_wait();
  end_by = end;
  end_context = context;
  pthread_mutex_unlock(&lock);
}
