/* Starting under a limit of the address space. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_APP_ADDRESS_SPACE_H
#define THRUM_APP_ADDRESS_SPACE_H

/* Before all else: where the address space is limited, starts the program anew with one thread of
 * BLAS, so that it can end; else, or when that fails, does nothing. */
void address_space_begin(char **argv);

#endif
