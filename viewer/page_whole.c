/* What the page makes of models with their whole meshes, which come with a scene file that is
 * dropped: links and coupled bodies need them.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

/* The model that page_open_model read last, with all of its mesh, as one of the page's; it stays
 * where it is. Bodies of it have no surface. Returns its number, or a status below 0. */
int32_t EXPORT(page_keep_model)(void) {
  const thrum_model *model = page_opened_model();
  if (model == NULL)
    return thrum_error_set(&js_failure, THRUM_INVALID_ARGUMENT, "no model file was opened");
  const page_model made = {.model = *model};
  const int32_t number = page_model_add(&made);
  if (number >= 0)
    page_keep_opened();
  return number;
}

/* The group of this name in a model: returns its 0-based vertices, and numbers has their count; or
 * NULL. */
const int32_t *EXPORT(page_group)(int32_t model, const char *name) {
  const page_model *of = page_model_at(model);
  const int32_t *vertices = NULL;
  int64_t count = 0;
  if (of == NULL || thrum_model_group(&of->model, name, &vertices, &count, &js_failure) < 0)
    return NULL;
  js_number[0] = (double)count;
  return vertices;
}

/* Writes the numbers of the inertia of a model's shape, 9 + 9 rank (rank + 1). */
int32_t EXPORT(page_inertia)(int32_t model, double *out) {
  const page_model *of = page_model_at(model);
  thrum_inertia *inertia = NULL;
  if (of == NULL)
    return thrum_error_set(&js_failure, THRUM_INVALID_ARGUMENT, "there is no such model");
  THRUM_TRY(thrum_inertia_create(&of->model, 0, NULL, &inertia, &js_failure));
  thrum_inertia_numbers(inertia, out);
  thrum_inertia_destroy(inertia);
  return THRUM_OK;
}
