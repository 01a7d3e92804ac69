/* The state about which a model is made, as --about says it: stretch:EX,EY,EZ, temperature:DT,ALPHA
 * or FILE.npy. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_ABOUT_H
#define THRUM_DRIVER_MAKE_ABOUT_H

#include "config/options.h"
#include "mesh/mesh.h"

/* For the `take` of an option: refuses a text that says no state. */
thrum_status about_option_check(const config_given *given);

/* Gives the mesh its state; tetrahedra become solids. */
thrum_status about_find(const char *text, const uint8_t *fixed, thrum_mesh *mesh,
                        thrum_error *error);

/* The sum of the loads that bring the body to its state, and stay: what pulls at its free
 * components there [N]. Zero but for rounding of a stretch and a temperature, which only what is
 * held brings about. */
thrum_status about_loads(const thrum_mesh *mesh, const uint8_t *fixed, double loads[3],
                         thrum_error *error);

#endif
