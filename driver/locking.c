/* Models say by how much their linear tetrahedra lock. A frequency that is too high by the share e
 * belongs to a body that is too stiff by (1 + e)^2, and gives way under a load by as much too
 * little. SPDX-License-Identifier: Apache-2.0 */
#include "driver/locking.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/model_meta.h"
#include "io/json.h"
#include "precompute/precompute.h"

double locking_most(const double *errors, int64_t count) {
  double most = 0;
  for (int64_t i = 0; i < count; i++)
    most = fmax(most, errors[i]);
  return most;
}

const char *locking_text(const double *errors, int64_t count, char text[LOCKING_TEXT_MAX]) {
  size_t used = 0;
  text[0] = 0;
  for (int64_t i = 0; i < count && used < LOCKING_TEXT_MAX; i++)
    used += (size_t)snprintf(text + used, LOCKING_TEXT_MAX - used, "%s%.2g", i > 0 ? ", " : "",
                             100 * errors[i]);
  if (used < LOCKING_TEXT_MAX)
    snprintf(text + used, LOCKING_TEXT_MAX - used, " %%");
  return text;
}

void locking_warn_of(const char *name, const double *errors, int64_t count, const char *kept) {
  char text[LOCKING_TEXT_MAX];
  const double most = locking_most(errors, count);
  if (!(most > LOCKING_TOLD))
    return;
  config_warn("%s: its linear tetrahedra are too stiff: first frequencies are about %s too high, "
              "and loads move it by up to %.2g %% too little; %s%s--order 2 mends that when its "
              "model is made",
              name, locking_text(errors, count, text), 100 * (1 - 1 / ((1 + most) * (1 + most))),
              kept, kept[0] != 0 ? "; " : "");
}

void locking_warn(const char *name, const thrum_model *model) {
  double errors[THRUM_ORDER_ERRORS_MAX];
  int64_t count = 0;
  if (model->midsides != NULL)
    return;
  cJSON *meta = model_meta_parse(model);
  const cJSON *list = model_meta_find(meta, "mesh", "order_error"), *item = NULL;
  cJSON_ArrayForEach(item, list) {
    if (count < THRUM_ORDER_ERRORS_MAX && cJSON_IsNumber(item))
      errors[count++] = item->valuedouble;
  }
  cJSON_Delete(meta);
  locking_warn_of(name, errors, count, "");
}

void locking_json(cJSON *object, const cJSON *meta) {
  const cJSON *by = model_meta_find(meta, "mesh", "order_by");
  const cJSON *errors = model_meta_find(meta, "mesh", "order_error");
  json_string(object, "order_by", cJSON_IsString(by) ? by->valuestring : NULL);
  if (cJSON_IsArray(errors))
    cJSON_AddItemToObject(object, "order_error", cJSON_Duplicate(errors, true));
  else
    cJSON_AddNullToObject(object, "order_error");
}
