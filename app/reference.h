/* Prints the pages that are generated from the tables of all commands: `thrum help --reference` and
 * so on. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_REFERENCE_H
#define THRUM_APP_REFERENCE_H

/* Prints what `option` names: --reference, --scene-keys, --man or --bash. COMMAND_DONE, or
 * COMMAND_USAGE after a line. */
int reference_print(const char *option);

#endif
