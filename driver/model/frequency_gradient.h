/* How the frequencies of a body change with the materials of its regions.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_FREQUENCY_GRADIENT_H
#define THRUM_DRIVER_MODEL_FREQUENCY_GRADIENT_H

#include "thrum/model.h"

/* Relative changes of the frequency, rows modes x regions: f changes by young times as many percent
 * as E does, by density times as many as rho, and by poisson of itself for a unit of nu. Over all
 * regions young sums up to 1/2 and density to -1/2. Of modes that share a frequency they are those
 * of the frequencies into which the change splits it, in ascending order, each number by itself. */
typedef struct frequency_gradient {
  int64_t modes, regions;
  double *young, *poisson, *density;
} frequency_gradient;

/* Of the first `modes` basis vectors, which are modes of the mesh. THRUM_MISSING where the model
 * has no mesh or basis. frequency_gradient_free frees, whatever came back. */
thrum_status frequency_gradient_find(const thrum_model *model, int64_t modes,
                                     frequency_gradient *found, thrum_error *error);
void frequency_gradient_free(frequency_gradient *found);

/* The end of the modes that share the frequency of mode `first`; omega2 ascend. */
int64_t frequency_shared_end(const double *omega2, int64_t modes, int64_t first);

#endif
