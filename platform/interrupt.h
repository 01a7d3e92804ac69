/* Cleans up when a signal stops the program. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_INTERRUPT_H
#define THRUM_PLATFORM_INTERRUPT_H

#include <stdbool.h>

#define THRUM_INTERRUPT_FILES 8

/* From now on SIGINT, SIGTERM and SIGHUP, where they are not ignored, remove the temporary files
 * that thrum_file_writers have open and new folders that are empty, write `line` to standard error
 * and end the process by the signal itself, at once: nothing need wait until a long call of a
 * library comes back. `line` must stay. A setting of the process, for programs. */
void thrum_interrupt_clean(const char *line);

/* Removes those temporary files now, where the program ends without its own end. */
void thrum_interrupt_remove(void);

/* For the writer of files: a temporary file in the making, or a new folder, and that it is none any
 * more, with whether it was; NULL is ignored. The path must stay until then. THRUM_INTERRUPT_FILES
 * at a time, further ones are not removed; one thread at a time. Signals wait between hold and let,
 * so that a file and its mark are one; a pair of them holds no other. */
void thrum_interrupt_mark(const char *temporary);
bool thrum_interrupt_unmark(const char *temporary);
void thrum_interrupt_hold(void);
void thrum_interrupt_let(void);

#endif
