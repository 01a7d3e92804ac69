/* The metadata that precompute leaves in a model. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_MODEL_META_H
#define THRUM_DRIVER_MODEL_MODEL_META_H

#include <cjson/cJSON.h>

#include "thrum/model.h"

/* The metadata as an object, which the caller deletes; NULL when there is none. Other programs may
 * have written it, so any of its keys may be missing. */
cJSON *model_meta_parse(const thrum_model *model);

/* A member of the metadata, or of its object `object` (NULL: itself); NULL when it is missing. */
const cJSON *model_meta_find(const cJSON *meta, const char *object, const char *key);

/* How many of the coordinates, the first ones, are linear modes of the mesh; all, where the model
 * does not say. */
int64_t model_meta_modes(const thrum_model *model);

/* The name of a region, from 0; NULL where it has none, or one that no region of a mesh may have.
 */
const char *model_meta_region(const cJSON *meta, int64_t region);

#endif
