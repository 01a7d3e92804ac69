/* The key "error" of bodies: how many coordinates each of them has to step. The scene runs its
 * first seconds with all coordinates, then condensed to more and more of them (design 16), until
 * the shape of the body errs by no more than was asked for. Bodies do not touch each other, so one
 * run tries a number of coordinates on all of them.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "config/message.h"
#include "driver/scene_run.h"

#define TRIAL_TIME 2.0 /* of the scene [s] that is tried, or all of it */
#define TRIAL_EVERY 4  /* steps between two shapes that are compared */

static const int64_t candidates[] = {2, 3, 4, 6, 8, 10, 12, 16, 20, 24, 32};
enum { CANDIDATES = sizeof candidates / sizeof candidates[0] };

/* A body whose number of coordinates is sought. */
typedef struct sought {
  int32_t number;
  double *rows;      /* shapes with all coordinates, rank each; owned */
  double size, away; /* sums of squares of these shapes, and of the differences */
  bool lost, found;
} sought;

typedef struct search {
  scene_run *run;
  sought *bodies;
  int32_t count;
  int64_t steps;
} search;

static bool is_sought(const scene_body_run *body) {
  return body->spec->error > 0;
}

/* "error" goes without what it finds. */
static thrum_status check(const scene_run *run, const scene_body_run *body) {
  thrum_error detail = {0};
  if (body->spec->rank == 0 && body->spec->condense == 0 && thrum_model_masters(body->model) == 0)
    return THRUM_OK;
  thrum_error_set(&detail, THRUM_INVALID_ARGUMENT,
                  "it finds how many coordinates are stepped, so leave out rank and condense, and "
                  "take a model that was not precomputed condensed");
  return scene_run_refuse(run, &body->spec->settings.at, "error", THRUM_INVALID_ARGUMENT, &detail);
}

static thrum_status open_search(scene_run *run, search *s, thrum_error *error) {
  s->run = run;
  s->steps = (int64_t)fmin((double)run->steps, ceil(TRIAL_TIME / run->dt));
  s->bodies = calloc((size_t)run->spec.bodies.count, sizeof *s->bodies);
  if (s->bodies == NULL)
    return scene_run_no_memory(error);

  // room for the shapes of each
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    if (!is_sought(&run->bodies[n]))
      continue;
    THRUM_TRY(check(run, &run->bodies[n]));
    sought *body = &s->bodies[s->count++];
    body->number = n;
    const size_t rows = (size_t)(s->steps / TRIAL_EVERY + 1);
    body->rows = calloc(rows * (size_t)run->bodies[n].model->rank, sizeof *body->rows);
    if (body->rows == NULL)
      return scene_run_no_memory(error);
  }
  return THRUM_OK;
}

static void close_search(search *s) {
  for (int32_t n = 0; s->bodies != NULL && n < s->count; n++)
    free(s->bodies[n].rows);
  free(s->bodies);
}

/* Compares the shape of a body with row `row`, or makes it that. */
static void look(const search *s, sought *body, int64_t row, bool whole) {
  double q[THRUM_RANK_MAX];
  const int64_t rank = s->run->bodies[body->number].model->rank;
  double *kept = body->rows + row * rank;
  thrum_scene_body_info info;
  thrum_scene_body(s->run->scene, body->number, &info, NULL);
  body->lost = body->lost || info.status < 0 ||
               thrum_scene_body_shape(s->run->scene, body->number, q, NULL) < 0;
  for (int64_t i = 0; i < rank && !body->lost; i++) {
    if (whole)
      kept[i] = q[i];
    body->size += whole ? q[i] * q[i] : 0;
    body->away += (q[i] - kept[i]) * (q[i] - kept[i]);
  }
}

/* The first steps of the scene from its start, as its bodies are now. */
static thrum_status try(search *s, bool whole, thrum_error *error) {
  for (int32_t n = 0; n < s->count; n++) {
    s->bodies[n].away = 0;
    s->bodies[n].lost = false;
  }
  THRUM_TRY(thrum_scene_reset(s->run->scene, error));

  // a body that fails stops, the others go on
  for (int64_t step = 0; step < s->steps; step++) {
    thrum_scene_step(s->run->scene, NULL);
    for (int32_t n = 0; n < s->count && (step + 1) % TRIAL_EVERY == 0; n++)
      if (whole || !s->bodies[n].found)
        look(s, &s->bodies[n], step / TRIAL_EVERY, whole);
  }
  return THRUM_OK;
}

/* Tries one number of coordinates on all bodies that have none yet. */
static thrum_status try_candidate(search *s, int64_t masters, thrum_error *error) {
  int32_t tried = 0;
  for (int32_t n = 0; n < s->count; n++) {
    sought *body = &s->bodies[n];
    if (body->found || masters > s->run->bodies[body->number].model->rank / 2)
      continue;
    THRUM_TRY(thrum_scene_set_condensed(s->run->scene, body->number, masters, error));
    tried++;
  }
  if (tried == 0)
    return THRUM_OK;

  // those that err by no more than was asked for keep it
  THRUM_TRY(try(s, false, error));
  for (int32_t n = 0; n < s->count; n++) {
    sought *body = &s->bodies[n];
    scene_body_run *of = &s->run->bodies[body->number];
    if (body->found || masters > of->model->rank / 2)
      continue;
    const double error_found = sqrt(body->away / body->size);
    body->found = !body->lost && error_found <= of->spec->error;
    if (body->found) {
      of->request.condense = masters;
      of->error_found = error_found;
    }
  }
  return THRUM_OK;
}

/* Bodies for which no number was good enough are stepped whole. */
static thrum_status end_search(search *s, thrum_error *error) {
  for (int32_t n = 0; n < s->count; n++) {
    sought *body = &s->bodies[n];
    const scene_body_spec *spec = s->run->bodies[body->number].spec;
    if (body->found)
      continue;
    THRUM_TRY(thrum_scene_set_condensed(s->run->scene, body->number, 0, error));
    config_warn("body '%.100s': in the first %g s no number of coordinates errs by at most %g, so "
                "all are stepped",
                spec->name, (double)s->steps * s->run->dt, spec->error);
  }
  return thrum_scene_reset(s->run->scene, error);
}

thrum_status scene_run_find_detail(scene_run *run, thrum_error *error) {
  search s = {0};
  thrum_status status = open_search(run, &s, error);
  if (status >= 0 && s.count > 0) {
    status = try(&s, true, error);

    // one that fails or stays at rest says nothing of its error
    for (int32_t n = 0; n < s.count; n++)
      if (s.bodies[n].lost || !(s.bodies[n].size > 0))
        s.bodies[n].size = 0;
    for (int c = 0; c < CANDIDATES && status >= 0; c++)
      status = try_candidate(&s, candidates[c], error);
    THRUM_THEN(status, end_search(&s, error));
  }
  close_search(&s);
  return status;
}
