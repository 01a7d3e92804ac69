/* A polite request to stop: the first Ctrl-C is noted, the second one ends the program. Long calls
 * of libraries cannot be broken off, so that another thread may end the program in their place.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_STOP_REQUEST_H
#define THRUM_PLATFORM_STOP_REQUEST_H

#include <stdbool.h>

/* From now on the first SIGINT, SIGTERM or SIGHUP is noted and does nothing else; a second one ends
 * the program as usual. Signals that the caller set to be ignored, as nohup does, stay ignored. A
 * setting of the process, for programs. */
void thrum_stop_request_catch(void);

/* Whether such a signal has arrived. Who is told so ends the program in order. */
bool thrum_stop_requested(void);

/* From now on `end` is called, with `context` and on a thread of its own, where nobody has asked
 * thrum_stop_requested for a second since the signal: a long call has not come back. It ends the
 * program. NULL: long calls are waited for, as they are at first. On the thread that called
 * thrum_stop_request_catch. */
void thrum_stop_request_end_by(void (*end)(void *context), void *context);

#endif
