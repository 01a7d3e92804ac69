/* Signals that ask a long loop to stop, see stop_request.h. SPDX-License-Identifier: Apache-2.0 */
#include "platform/stop_request.h"

#include <signal.h>
#include <stddef.h>
#include <string.h>

static volatile sig_atomic_t requested;

static void note_request(int signal_number) {
  (void)signal_number;
  requested = 1;
}

void thrum_stop_request_catch(void) {
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
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

bool thrum_stop_requested(void) {
  return requested != 0;
}
