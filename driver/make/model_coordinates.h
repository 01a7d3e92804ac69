/* What the coordinates of a model are: linear modes, what derivatives show beside them, responses
 * of handles, trained shapes, touch modes. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MAKE_MODEL_COORDINATES_H
#define THRUM_DRIVER_MAKE_MODEL_COORDINATES_H

#include <cjson/cJSON.h>

#include "driver/make/precompute_outcome.h"

/* Adds "coordinates", one object for each, in their order; nothing of an imported basis. */
void model_coordinates_add(cJSON *object, const precompute_outcome *outcome);

/* Prints the same from the metadata of a model with these frequencies, runs of modes and of shapes
 * of one kind in one line each; nothing where the metadata has none, or of another number. */
void model_coordinates_print(const cJSON *meta, const double *hertz, int64_t rank);

#endif
