/* Models say by how much their linear tetrahedra lock. A frequency that is too high by the share e
 * belongs to a body that is too stiff by (1 + e)^2, and gives way under a load by as much too
 * little. SPDX-License-Identifier: Apache-2.0 */
#include "driver/locking.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/model_meta.h"
#include "driver/percent.h"
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
  for (int64_t i = 0; i < count && used < LOCKING_TEXT_MAX; i++) {
    char share[PERCENT_MAX];
    used += (size_t)snprintf(text + used, LOCKING_TEXT_MAX - used, "%s%s", i > 0 ? ", " : "",
                             percent_text(errors[i], share));
  }
  if (used < LOCKING_TEXT_MAX)
    snprintf(text + used, LOCKING_TEXT_MAX - used, " %%");
  return text;
}

void locking_warn_of(const char *name, const double *errors, int64_t count, const char *kept) {
  char text[LOCKING_TEXT_MAX], share[PERCENT_MAX];
  const double most = locking_most(errors, count);
  if (!(most > LOCKING_TOLD))
    return;

  // of a body that hardly moves the digits tell nothing
  const double less = 1 - 1 / ((1 + most) * (1 + most));
  config_warn("%s: its linear tetrahedra are too stiff: first frequencies are about %s too high, "
              "and loads move it by %s %s %% too little; %s%smake the model with --order 2",
              name, locking_text(errors, count, text), less > 0.99 ? "more than" : "up to",
              percent_text(fmin(less, 0.99), share), kept, kept[0] != 0 ? ": " : "");
}

/* The errors that the metadata of a model know; returns how many. */
static int64_t errors_of(const cJSON *meta, double errors[THRUM_ORDER_ERRORS_MAX]) {
  const cJSON *item = NULL;
  int64_t count = 0;
  cJSON_ArrayForEach(item, model_meta_find(meta, "mesh", "order_error")) {
    if (count < THRUM_ORDER_ERRORS_MAX && cJSON_IsNumber(item))
      errors[count++] = item->valuedouble;
  }
  return count;
}

void locking_warn(const char *name, const thrum_model *model) {
  double errors[THRUM_ORDER_ERRORS_MAX];
  if (model->midsides != NULL)
    return;
  cJSON *meta = model_meta_parse(model);
  locking_warn_of(name, errors, errors_of(meta, errors), "");
  cJSON_Delete(meta);
}

const char *locking_line(const thrum_model *model, char line[LOCKING_LINE_MAX]) {
  double errors[THRUM_ORDER_ERRORS_MAX];
  char text[LOCKING_TEXT_MAX];
  cJSON *meta = model_meta_parse(model);
  const int64_t count = errors_of(meta, errors);
  cJSON_Delete(meta);
  line[0] = 0;
  if (count == 0)
    return line;

  // what is, or what would have been
  const char *first = locking_text(errors, count, text);
  if (model->midsides != NULL)
    snprintf(line, LOCKING_LINE_MAX,
             "ten nodes, by --order auto; with four the first frequencies would be about %s too "
             "high",
             first);
  else
    snprintf(line, LOCKING_LINE_MAX,
             "four nodes, by which the first frequencies are about %s too "
             "high",
             first);
  return line;
}

void locking_json(cJSON *object, const thrum_model *model) {
  cJSON *meta = model_meta_parse(model);
  const cJSON *by = model_meta_find(meta, "mesh", "order_by");
  double errors[THRUM_ORDER_ERRORS_MAX];
  const int64_t count = errors_of(meta, errors);
  json_number(object, "order", model->tet_count == 0 ? NAN : model->midsides != NULL ? 2 : 1);
  json_string(object, "order_by", cJSON_IsString(by) ? by->valuestring : NULL);
  if (count > 0)
    json_numbers(object, "order_error", errors, count);
  else
    cJSON_AddNullToObject(object, "order_error");
  cJSON_Delete(meta);
}
