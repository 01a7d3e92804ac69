/* A polite request to stop: the first Ctrl-C is noted, the second one ends the program.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_STOP_REQUEST_H
#define THRUM_PLATFORM_STOP_REQUEST_H

#include <stdbool.h>

/* From now on the first SIGINT, SIGTERM or SIGHUP is noted and does nothing else; a second one ends
 * the program as usual. Signals that the caller set to be ignored, as nohup does, stay ignored. A
 * setting of the process, for programs. */
void thrum_stop_request_catch(void);

/* Whether such a signal has arrived. */
bool thrum_stop_requested(void);

#endif
