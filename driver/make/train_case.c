/* Cases of trainings. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/train_case.h"

#include <stdlib.h>
#include <string.h>

/* Returns what follows `prefix` in the text; NULL where it begins otherwise. */
static const char *after(const char *text, const char *prefix) {
  const size_t length = strlen(prefix);
  return strncmp(text, prefix, length) == 0 ? text + length : NULL;
}

/* One piece of the text. */
static thrum_status parse_piece(const char *piece, train_case *c, thrum_error *error) {
  const char *base_motion = after(piece, "base-motion:"), *start = after(piece, "start:");

  // motions and starts are named, a load is not
  if (base_motion != NULL) {
    THRUM_TRY(base_motion_parse(base_motion, &c->base_motions[c->base_motion_count], error));
    c->base_motion_count++;
    return THRUM_OK;
  }

  if (start != NULL) {
    start_spec *parsed = &c->starts[c->start_count];
    THRUM_TRY(start_spec_parse(start, parsed, error));
    if (parsed->kind == START_FILE)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "'%.200s': the coordinates in a file are those of one basis, and "
                             "another is made here: start from mode:NUMBER,METRES or static:LOAD",
                             piece);
    c->start_count++;
    return THRUM_OK;
  }

  THRUM_TRY(load_spec_parse(piece, &c->loads[c->count], error));
  c->courses[c->count] = c->loads[c->count].course;
  c->count++;
  return THRUM_OK;
}

thrum_status train_case_parse(const char *text, train_case *c, thrum_error *error) {
  int64_t most = 1;
  for (const char *at = text; *at != 0; at++)
    most += *at == ';';
  *c = (train_case){.memory = thrum_scope_begin("a load", error)};
  c->texts = thrum_scope_allocate(&c->memory, (int64_t)strlen(text) + 1, 1);
  c->loads = thrum_scope_allocate(&c->memory, most, sizeof *c->loads);
  c->courses = thrum_scope_allocate(&c->memory, most, sizeof *c->courses);
  c->base_motions = thrum_scope_allocate(&c->memory, most, sizeof *c->base_motions);
  c->starts = thrum_scope_allocate(&c->memory, most, sizeof *c->starts);
  THRUM_TRY(c->memory.status);
  strcpy(c->texts, text);

  // the texts of the pieces are parts of the copy
  for (char *piece = c->texts; piece != NULL;) {
    char *end = strchr(piece, ';');
    if (end != NULL)
      *end++ = 0;
    THRUM_TRY(parse_piece(piece, c, error));
    piece = end;
  }
  return THRUM_OK;
}

void train_case_free(train_case *c) {
  for (int64_t n = 0; n < c->base_motion_count; n++)
    base_motion_close(&c->base_motions[n]);
  thrum_scope_free(&c->memory);
  free(c->forces);
  free(c->held_by);
  free(c->start);
  *c = (train_case){0};
}

/* The message about a piece begins with the option that it has in `thrum simulate`; returns what
 * comes after that option. */
static const char *renamed(const char *message) {
  static const char *const others[] = {"--load ", "--base-motion ", "--start "};
  for (size_t n = 0; n < sizeof others / sizeof others[0]; n++)
    if (after(message, others[n]) != NULL)
      return after(message, others[n]);
  return message;
}

/* Where the body starts. */
static thrum_status fill_starts(const thrum_model *model, train_case *c, thrum_error *error) {
  double q[THRUM_RANK_MAX] = {0}, p[THRUM_RANK_MAX] = {0};
  int64_t modes = 0, statics = 0;
  for (int64_t n = 0; n < c->start_count; n++) {
    modes += c->starts[n].kind == START_MODE;
    statics += c->starts[n].kind == START_STATIC;
  }
  const int64_t all = 3 * model->vertex_count;
  if (modes > 0)
    THRUM_TRY(thrum_reserve(&c->start, all, sizeof *c->start, "a load", error));
  if (statics > 0)
    THRUM_TRY(thrum_reserve(&c->held_by, all, sizeof *c->held_by, "a load", error));

  // shapes of modes add up; loads of equilibria act together
  for (int64_t n = 0; n < c->start_count; n++) {
    const start_spec *start = &c->starts[n];
    if (start->kind == START_MODE) {
      THRUM_TRY(start_specs_make(model, start, 1, q, p, error));
      continue;
    }
    double reduced[THRUM_RANK_MAX];
    THRUM_TRY(load_spec_reduce(model, &start->load, reduced, error));
    THRUM_TRY(load_spec_fill(model, &start->load, c->held_by, error));
  }
  return modes > 0 ? thrum_displacement(model, q, 0, model->vertex_count, c->start, error)
                   : THRUM_OK;
}

thrum_status train_case_fill(const thrum_model *model, const char *option, train_case *c,
                             thrum_error *error) {
  const int64_t all = 3 * model->vertex_count;
  THRUM_TRY(thrum_reserve(&c->forces, c->count * all, sizeof *c->forces, "a load", error));

  // reducing a load first gives an error that names it and its target
  for (int64_t n = 0; n < c->count; n++) {
    double reduced[THRUM_RANK_MAX];
    thrum_error detail = {0};
    const thrum_status status = load_spec_reduce(model, &c->loads[n], reduced, &detail);
    if (status < 0)
      return thrum_error_set(error, status, "--%s %.300s", option, renamed(detail.message));
    THRUM_TRY(load_spec_fill(model, &c->loads[n], c->forces + n * all, error));
  }

  // base motions and starts say what they are themselves
  thrum_error detail = {0};
  thrum_status status = fill_starts(model, c, &detail);
  for (int64_t n = 0; n < c->base_motion_count && status >= 0; n++)
    status = base_motion_read(&c->base_motions[n], &detail);
  return status < 0 ? thrum_error_set(error, status, "--%s %.300s", option, renamed(detail.message))
                    : THRUM_OK;
}

full_motion_script train_case_script(const train_case *c) {
  return (full_motion_script){.load_count = c->count,
                              .courses = c->courses,
                              .forces = c->forces,
                              .base_motion_count = c->base_motion_count,
                              .base_motions = c->base_motions,
                              .held_by = c->held_by,
                              .start = c->start};
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
