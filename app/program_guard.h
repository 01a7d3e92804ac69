/* Guards a program before and after its command, so that a failure never looks like a success.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_PROGRAM_GUARD_H
#define THRUM_APP_PROGRAM_GUARD_H

#include <stdbool.h>

/* Before all else in main; false, with a line on standard error where there is one, when the
 * program should end with COMMAND_REFUSED. */
bool program_guard_begin(char **argv);

/* The exit code of a program whose command returned `code`. */
int program_guard_end(int code);

#endif
