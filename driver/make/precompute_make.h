/* The pipeline from a mesh to a written model file. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_PRECOMPUTE_MAKE_H
#define THRUM_DRIVER_MAKE_PRECOMPUTE_MAKE_H

#include "driver/make/precompute_outcome.h"

/* Receives the outcome while the mesh and the model are still there. */
typedef void precompute_show(const precompute_outcome *outcome);

/* Reads the mesh, makes the model and writes it to request->output. `show`, which may be NULL, is
 * told the outcome once the file is there. *flagged: residuals are larger than they should be. */
thrum_status precompute_make(const precompute_request *request, precompute_show *show,
                             bool *flagged, thrum_error *error);

#endif
