/* Cases of trainings. SPDX-License-Identifier: Apache-2.0 */
#include "driver/train_case.h"

#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

thrum_status train_case_parse(const char *text, train_case *c, thrum_error *error) {
  int64_t most = 1;
  for (const char *at = text; *at != 0; at++)
    most += *at == ';';
  *c = (train_case){.texts = malloc(strlen(text) + 1),
                    .loads = calloc((size_t)most, sizeof *c->loads),
                    .courses = calloc((size_t)most, sizeof *c->courses)};
  if (c->texts == NULL || c->loads == NULL || c->courses == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a load");
  strcpy(c->texts, text);

  // the texts of the loads are pieces of the copy
  for (char *piece = c->texts; piece != NULL;) {
    char *end = strchr(piece, ';');
    if (end != NULL)
      *end++ = 0;
    THRUM_TRY(load_spec_parse(piece, &c->loads[c->count], error));
    c->courses[c->count] = c->loads[c->count].course;
    c->count++;
    piece = end;
  }
  return THRUM_OK;
}

void train_case_free(train_case *c) {
  free(c->texts);
  free(c->loads);
  free(c->courses);
  free(c->forces);
  *c = (train_case){0};
}

/* What a load says of itself, which begins with the option that it has in simulate, with another
 * one. */
static const char *renamed(const char *message) {
  static const char other[] = "--load ";
  return message + (strncmp(message, other, sizeof other - 1) == 0 ? sizeof other - 1 : 0);
}

thrum_status train_case_fill(const thrum_model *model, const char *option, train_case *c,
                             thrum_error *error) {
  const int64_t all = 3 * model->vertex_count;
  c->forces = thrum_allocate(c->count * all, sizeof *c->forces, "a load", error);
  if (c->forces == NULL)
    return THRUM_OUT_OF_MEMORY;
  memset(c->forces, 0, (size_t)(c->count * all) * sizeof *c->forces);

  // reducing a load first gives an error that names it and its target
  for (int64_t n = 0; n < c->count; n++) {
    double reduced[THRUM_RANK_MAX];
    thrum_error detail = {0};
    const thrum_status status = load_spec_reduce(model, &c->loads[n], reduced, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--%s %.300s", option, renamed(detail.message));
    THRUM_TRY(load_spec_fill(model, &c->loads[n], c->forces + n * all, error));
  }
  return THRUM_OK;
}

thrum_status train_case_reduce(const thrum_model *model, const train_case *c, double *directions,
                               thrum_error *error) {
  for (int64_t n = 0; n < c->count; n++)
    THRUM_TRY(load_spec_reduce(model, &c->loads[n], directions + n * model->rank, error));
  return THRUM_OK;
}

thrum_status train_case_option_take(const config_given *given, const char **texts, int64_t *count) {
  train_case parsed = {0};
  thrum_error error = {0};
  const thrum_status status = train_case_parse(given->text, &parsed, &error);
  train_case_free(&parsed);

  if (status < 0)
    return config_given_refuse(given, "--%s %s", given->option->name, renamed(error.message));
  texts[(*count)++] = given->text;
  return THRUM_OK;
}
