/* Two hashes tell a model from others, for the runs that were made with it.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/model_hash.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file_hash.h"
#include "io/json.h"
#include "io/npz.h"

uint64_t model_arrays_hash(const thrum_model *model) {
  thrum_npz_array arrays[THRUM_NPZ_ARRAYS_MAX];
  const int count = thrum_npz_of_model(model, arrays);
  uint64_t hash = 0;

  // the version follows from the other arrays, and meta says how the model was made and in what
  // time
  for (int n = 0; n < count; n++) {
    const thrum_npz_array *array = &arrays[n];
    if (strcmp(array->name, "format") == 0 || strcmp(array->name, "meta") == 0)
      continue;

    // names and sizes, so that no bytes may be taken for those of another array
    hash = hash_bytes(hash, array->name, strlen(array->name) + 1);
    hash = hash_bytes(hash, &array->size, sizeof array->size);
    hash = hash_bytes(hash, array->data, array->size);
  }
  return hash != 0 ? hash : 1;
}

thrum_status model_hash_make(const char *path, const thrum_model *model, model_hash *hash,
                             thrum_error *error) {
  THRUM_TRY(file_hash(path, &hash->bytes, error));
  hash->arrays = model_arrays_hash(model);
  return THRUM_OK;
}

static void add_hash(cJSON *object, const char *key, uint64_t hash) {
  char text[20];
  snprintf(text, sizeof text, "%016" PRIx64, hash);
  cJSON_AddStringToObject(object, key, text);
}

void model_hash_json(cJSON *object, const model_hash *hash) {
  add_hash(object, "model_hash", hash->bytes);
  add_hash(object, "model_arrays_hash", hash->arrays);
}

/* Reads 16 hexadecimal digits; false where there are others. */
static bool read_hash(const cJSON *object, const char *key, uint64_t *hash) {
  const char *text = json_text_of(object, key);
  if (text == NULL || strlen(text) != 16 || strspn(text, "0123456789abcdef") != 16)
    return false;
  *hash = strtoull(text, NULL, 16);
  return true;
}

bool model_hash_read(const cJSON *object, model_hash *hash) {
  *hash = (model_hash){0};
  read_hash(object, "model_arrays_hash", &hash->arrays);
  return read_hash(object, "model_hash", &hash->bytes);
}

thrum_status model_hash_matches(const char *path, const thrum_model *model, const model_hash *hash,
                                bool *same, thrum_error *error) {
  uint64_t bytes = 0;
  THRUM_TRY(file_hash(path, &bytes, error));
  *same = bytes == hash->bytes;
  if (*same || hash->arrays == 0)
    return THRUM_OK;

  // other bytes may hold the same model, made again
  const thrum_model *read = NULL;
  const thrum_status status = model == NULL ? thrum_model_load(path, &read, error) : THRUM_OK;
  if (status < 0)
    return status == THRUM_OUT_OF_MEMORY ? status : THRUM_OK;
  *same = model_arrays_hash(model != NULL ? model : read) == hash->arrays;
  thrum_model_destroy(read);
  return THRUM_OK;
}
