/* Two hashes tell a model from others, for the runs that were made with it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_MODEL_MODEL_HASH_H
#define THRUM_DRIVER_MODEL_MODEL_HASH_H

#include <cjson/cJSON.h>
#include <stdbool.h>

#include "thrum/model.h"

/* Both hashes of a model's file, each of 64 bits. */
typedef struct model_hash {
  uint64_t bytes;  /* of all bytes of the file (file_hash) */
  uint64_t arrays; /* of its arrays alone, without `meta`; 0: not known */
} model_hash;

/* The hash of all arrays of a model but `format` and `meta`: of its mesh, its basis and its energy,
 * and not of when and by what program it was made. A model that is made again from the same input
 * has the same. Never 0. Cost: a pass over the model's bytes. */
uint64_t model_arrays_hash(const thrum_model *model);

/* Both hashes of the model that was loaded from this file. */
thrum_status model_hash_make(const char *path, const thrum_model *model, model_hash *hash,
                             thrum_error *error);

/* The two as keys of a report, and back; false where the report has none of bytes, as each has;
 * reports of earlier versions have none of arrays. */
void model_hash_json(cJSON *object, const model_hash *hash);
bool model_hash_read(const cJSON *object, model_hash *hash);

/* Whether the file holds the model of these hashes: the same bytes, or the same arrays. `model` is
 * what was loaded from it, and may be NULL: the file is then read where its bytes differ, and is
 * not the same where it cannot be. */
thrum_status model_hash_matches(const char *path, const thrum_model *model, const model_hash *hash,
                                bool *same, thrum_error *error);

#endif
