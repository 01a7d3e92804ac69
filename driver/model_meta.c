/* Metadata of models. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model_meta.h"

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
