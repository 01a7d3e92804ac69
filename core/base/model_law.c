/* Which law of elasticity a model names (model_law.h). SPDX-License-Identifier: Apache-2.0 */
#include "core/base/model_law.h"

#include <math.h>
#include <string.h>

bool thrum_law_find(const char *name, size_t length, thrum_law *law) {
#define X(constant, value, text)                                                                   \
  if (strlen(text) == length && memcmp(name, text, length) == 0) {                                 \
    *law = THRUM_LAW_##constant;                                                                   \
    return true;                                                                                   \
  }
  THRUM_LAW_LIST(X)
#undef X
  return false;
}

const char *thrum_law_name(thrum_law law) {
#define X(constant, value, text) text,
  static const char *const names[] = {THRUM_LAW_LIST(X) "by region"};
#undef X
  return names[law];
}

thrum_law thrum_law_of_model(const thrum_model *model) {
  thrum_law law = THRUM_LAW_STVK;
  if (model->region_law)
    return THRUM_LAW_BY_REGION;
  if (model->point_law && model->law_bytes > 0)
    thrum_law_find((const char *)model->point_law, (size_t)model->law_bytes - 1, &law);
  return law;
}

thrum_law thrum_law_of_region(const thrum_model *model, int64_t region) {
  return model->region_law ? (thrum_law)model->region_law[region] : thrum_law_of_model(model);
}

bool thrum_law_gives_way(const thrum_model *model, thrum_law law) {
  for (int64_t i = 0; law == THRUM_LAW_BY_REGION && i < model->law_count; i++)
    if (model->region_law[i] == THRUM_LAW_STVK)
      return true;
  return law == THRUM_LAW_STVK;
}

double thrum_law_yield(const thrum_model *model, int64_t region, double yield) {
  if (!model->region_law)
    return yield;
  if (model->region_law[region] == THRUM_LAW_STVK)
    return INFINITY;
  return model->region_yield && model->region_yield[region] > 0 ? model->region_yield[region]
                                                                : yield;
}

bool thrum_law_has_yield(const thrum_model *model) {
  for (int64_t i = 0; model->region_yield && i < model->law_count; i++)
    if (model->region_yield[i] > 0)
      return true;
  return false;
}
