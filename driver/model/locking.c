/* Models say by how much their tetrahedra lock. A frequency that is too high by the share e
 * belongs to a body that is too stiff by (1 + e)^2, and gives way under a load by as much too
 * little. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/locking.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/model/model_meta.h"
#include "driver/spec/model_names.h"
#include "io/json.h"
#include "io/percent.h"
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

/* Tells that such tetrahedra are too stiff, and what helps. */
static void warn_of(const char *name, const char *kind, const double *errors, int64_t count,
                    const char *kept, const char *help) {
  char text[LOCKING_TEXT_MAX], share[PERCENT_MAX];
  const double most = locking_most(errors, count);
  if (!(most > LOCKING_TOLD))
    return;

  // of a body that hardly moves the digits tell nothing
  const double less = 1 - 1 / ((1 + most) * (1 + most));
  config_warn("%s: its %s tetrahedra are too stiff: first frequencies are about %s too high, "
              "and loads move it by %s %s %% too little; %s%s%s",
              name, kind, locking_text(errors, count, text), less > 0.99 ? "more than" : "up to",
              percent_text(fmin(less, 0.99), share), kept, kept[0] != 0 ? ": " : "", help);
}

void locking_warn_of(const char *name, const double *errors, int64_t count, const char *kept) {
  char help[100] = "make the model with --order 2";

  // of a model that comes with Thrum, the command
  for (int n = 0; n < MODEL_NAME_COUNT; n++)
    if (strcmp(model_names[n], name) == 0)
      snprintf(help, sizeof help, "thrum precompute %s --order 2 -o %s2.npz makes a better one",
               name, name);
  warn_of(name, "linear", errors, count, kept, help);
}

void locking_warn_of_ten(const char *name, const double *errors, int64_t count) {
  warn_of(name, "ten-node", errors, count, "", "make the model of a finer mesh");
}

void locking_warn_of_solids(const char *name, const double *errors, int64_t count) {
  char text[LOCKING_TEXT_MAX];
  double least = 0;
  for (int64_t i = 0; i < count; i++)
    least = fmin(least, errors[i]);
  if (locking_most(errors, count) > LOCKING_TOLD || least < -LOCKING_TOLD)
    config_warn(
        "%s: its elements are too few or too distorted: by a finer mesh its first frequencies "
        "are about %s too high; make the model of a finer mesh",
        name, locking_text(errors, count, text));
}

/* The errors that the metadata of a model know of its elements, by their key; returns how many. */
static int64_t errors_of(const cJSON *meta, const char *key,
                         double errors[THRUM_ORDER_ERRORS_MAX]) {
  const cJSON *item = NULL;
  int64_t count = 0;
  cJSON_ArrayForEach(item, model_meta_find(meta, "mesh", key)) {
    if (count < THRUM_ORDER_ERRORS_MAX && cJSON_IsNumber(item))
      errors[count++] = item->valuedouble;
  }
  return count;
}

/* The largest Poisson's ratio of a region. */
static double largest_poisson(const thrum_model *model) {
  double largest = -1;
  for (int64_t i = 0; i < model->region_count; i++)
    largest = fmax(largest, model->material[3 * i + 1]);
  return largest;
}

void locking_warn(const char *name, const thrum_model *model) {
  double errors[THRUM_ORDER_ERRORS_MAX];
  const bool ten = model->midsides != NULL, solids = model->solid_count > 0;
  cJSON *meta = model_meta_parse(model);
  const int64_t count = errors_of(meta,
                                  solids ? "finer_error"
                                  : ten  ? "ten_node_error"
                                         : "order_error",
                                  errors);
  cJSON_Delete(meta);
  if (solids)
    locking_warn_of_solids(name, errors, count);
  else if (!ten)
    locking_warn_of(name, errors, count, "");
  else if (count > 0)
    locking_warn_of_ten(name, errors, count);
  else if (largest_poisson(model) >= LOCKING_POISSON)
    config_warn("%s: ten-node tetrahedra of a Poisson's ratio of %g may be too stiff, and by how "
                "much is not known of this model: make it anew, or of a finer mesh",
                name, largest_poisson(model));
}

const char *locking_line(const thrum_model *model, char line[LOCKING_LINE_MAX]) {
  double errors[THRUM_ORDER_ERRORS_MAX], own[THRUM_ORDER_ERRORS_MAX];
  double finer[THRUM_ORDER_ERRORS_MAX];
  char text[LOCKING_TEXT_MAX], own_text[LOCKING_TEXT_MAX];
  cJSON *meta = model_meta_parse(model);
  const int64_t count = errors_of(meta, "order_error", errors);
  const int64_t own_count = errors_of(meta, "ten_node_error", own);
  const int64_t finer_count = errors_of(meta, "finer_error", finer);
  cJSON_Delete(meta);
  line[0] = 0;
  if (model->solid_count > 0) {
    if (finer_count > 0)
      snprintf(line, LOCKING_LINE_MAX,
               "by a finer mesh the first frequencies are about %s too high",
               locking_text(finer, finer_count, text));
    else
      snprintf(line, LOCKING_LINE_MAX,
               "by how much they are too stiff is not known: compare with a finer mesh");
    return line;
  }
  if (count == 0 && model->midsides == NULL)
    return line;

  // what is, and what would have been
  const char *first = locking_text(errors, count, text);
  if (model->midsides == NULL)
    snprintf(line, LOCKING_LINE_MAX,
             "four nodes, by which the first frequencies are about %s too "
             "high",
             first);
  else if (own_count == 0)
    snprintf(line, LOCKING_LINE_MAX,
             "ten nodes; by how much they are too stiff is not known of this file%s%s",
             count > 0 ? ", with four the first frequencies would be too high by " : "",
             count > 0 ? first : "");
  else
    snprintf(line, LOCKING_LINE_MAX,
             "ten nodes, by which the first frequencies are about %s too high%s%s",
             locking_text(own, own_count, own_text), count > 0 ? "; with four by " : "",
             count > 0 ? first : "");
  return line;
}

void locking_json(cJSON *object, const thrum_model *model) {
  cJSON *meta = model_meta_parse(model);
  const cJSON *by = model_meta_find(meta, "mesh", "order_by");
  double errors[THRUM_ORDER_ERRORS_MAX];
  json_number(object, "order", model->tet_count == 0 ? NAN : model->midsides != NULL ? 2 : 1);
  json_string(object, "order_by", cJSON_IsString(by) ? by->valuestring : NULL);
  static const char *const keys[] = {"order_error", "ten_node_error", "finer_error"};
  for (size_t k = 0; k < sizeof keys / sizeof *keys; k++) {
    const int64_t count = errors_of(meta, keys[k], errors);
    if (count > 0)
      json_numbers(object, keys[k], errors, count);
    else
      cJSON_AddNullToObject(object, keys[k]);
  }
  cJSON_Delete(meta);
}
