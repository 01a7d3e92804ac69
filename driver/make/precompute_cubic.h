/* A model of VegaFEM's polynomial alone, `thrum precompute FILE.cub`.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_CUBIC_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_CUBIC_H

#include "driver/make/precompute_request.h"

/* Is the name that of a .cub file? */
bool precompute_cubic_is_named(const char *name);

/* Makes and writes the model and prints the result. Options of a mesh or a basis are refused. */
thrum_status precompute_cubic_make(const precompute_request *request, thrum_error *error);

#endif
