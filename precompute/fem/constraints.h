/* Do the held components stop every rigid motion? SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_FEM_CONSTRAINTS_H
#define THRUM_PRECOMPUTE_FEM_CONSTRAINTS_H

#include <stdbool.h>

#include "precompute/fem/fem.h"

/* THRUM_OK when every connected part of the mesh is held against its six rigid motions, *free_body
 * false, and when the mesh is one part of which nothing is held, *free_body true;
 * THRUM_UNSUPPORTED when nothing is held of several parts, THRUM_SINGULAR with the number of free
 * motions and the place when a part is held too little. */
thrum_status thrum_constraints_check(const thrum_fem *fem, bool *free_body, thrum_error *error);

#endif
