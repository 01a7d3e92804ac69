/* Metadata of models. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/model_meta.h"

#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "io/json.h"
#include "mesh/mesh_groups.h"

cJSON *model_meta_parse(const thrum_model *model) {
  if (model->meta == NULL || model->meta_bytes < 2)
    return NULL;
  cJSON *meta = cJSON_ParseWithLength((const char *)model->meta, (size_t)model->meta_bytes);
  if (meta != NULL && !cJSON_IsObject(meta)) {
    cJSON_Delete(meta);
    return NULL;
  }
  return meta;
}

const cJSON *model_meta_find(const cJSON *meta, const char *object, const char *key) {
  const cJSON *holder = object != NULL ? cJSON_GetObjectItemCaseSensitive(meta, object) : meta;
  return cJSON_GetObjectItemCaseSensitive(holder, key);
}

int64_t model_meta_modes(const thrum_model *model) {
  cJSON *meta = model_meta_parse(model);
  const int64_t count = cJSON_GetArraySize(model_meta_find(meta, NULL, "frequencies_hz"));
  cJSON_Delete(meta);
  return count > 0 && count < model->rank ? count : model->rank;
}

const char *model_meta_region(const cJSON *meta, int64_t region) {
  const cJSON *materials = model_meta_find(meta, NULL, "materials");
  const char *name = json_text_of(cJSON_GetArrayItem(materials, (int)region), "region");
  char number[24];
  snprintf(number, sizeof number, "%" PRId64, region + 1);

  // a region without a name is called by its number
  const bool none = name == NULL || strcmp(name, number) == 0;
  return none || thrum_mesh_name_fault(name, strlen(name)) != NULL ? NULL : name;
}
