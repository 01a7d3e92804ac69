/* What the whole mesh says of the critical load of a reduced model. SPDX-License-Identifier:
 * Apache-2.0 */
#ifndef THRUM_DRIVER_STATICS_STATIC_CRITICAL_H
#define THRUM_DRIVER_STATICS_STATIC_CRITICAL_H

#include "driver/statics/static_options.h"

/* Where a model buckles at `critical` of the load, *mesh becomes the factor at which its mesh
 * would, by extrapolation; it stays as it is where that is not known: a path from elsewhere, a free
 * body, a mesh of many components. */
thrum_status static_critical_look(const static_request *request, const thrum_model *model,
                                  double critical, double *mesh, thrum_error *error);

#endif
