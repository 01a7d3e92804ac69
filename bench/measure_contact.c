/* A step of many bodies with contact between them and without: three scenes take turns, so that
 * each finds the machine as the others do. Bodies vibrate in all modes and fall; of a pair the
 * lower body is held and bears the other.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "bench/measure_contact.h"

#include <math.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/thread_team.h"
#include "thrum/scene.h"

#define SPEED 1e-3    /* of the vibration, all modes together: times the diagonal a second */
#define APART 2.0     /* diagonals between the bodies of a row */
#define THICKNESS 250 /* the diagonal over the distance that contact keeps */
#define SETTLE 200    /* steps before those that are timed */

/* The scenes and what they share. */
typedef struct trial {
  const bench_contact *bench;
  double *speeds;          /* of the modes */
  double diagonal, height; /* of the body [m] */
  thrum_scene *scenes[BENCH_CONTACT_SCENES];
  double *samples[BENCH_CONTACT_SCENES];
  thrum_thread_team *team;
  thrum_scope memory;
} trial;

/* Body n of a scene: all are in a row, or the first of them in pairs. */
static thrum_status add_body(const trial *t, bench_contact_scene which, int64_t n,
                             thrum_error *error) {
  const bench_contact *bench = t->bench;
  const bool paired = which == BENCH_CONTACT_TOUCHING && n < 2 * bench->pairs;
  const bool upper = paired && n % 2 == 1;
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = bench->model;
  def.triangles = bench->triangles;
  def.triangle_count = bench->triangle_count;
  def.position[0] = APART * t->diagonal * (double)(upper ? n - 1 : n);
  def.position[2] = upper ? t->height + t->diagonal / THICKNESS : 0.0;
  def.p = t->speeds;
  def.free = !paired || upper;
  return thrum_scene_add_body(t->scenes[which], &def, NULL, error);
}

static thrum_status make_scene(trial *t, bench_contact_scene which, thrum_error *error) {
  static const double gravity[3] = {0.0, 0.0, -9.81};
  const thrum_contact_pairs_def contact = thrum_default_contact_pairs_def();
  const bench_contact *bench = t->bench;
  THRUM_TRY(thrum_scene_create(bench->dt, &t->scenes[which], error));
  thrum_scene *scene = t->scenes[which];
  THRUM_TRY(thrum_scene_set_workers(scene, bench->threads, thrum_thread_team_run, t->team, error));

  // bodies touch from their start, so that the room for them is made before the steps
  if (which != BENCH_CONTACT_NONE)
    THRUM_TRY(thrum_scene_set_collisions(scene, &contact, error));
  for (int64_t n = 0; n < bench->bodies; n++)
    THRUM_TRY(add_body(t, which, n, error));
  return thrum_scene_set_gravity(scene, gravity, error);
}

static thrum_status make_trial(trial *t, thrum_error *error) {
  const bench_contact *bench = t->bench;
  const thrum_model *model = bench->model;
  t->memory = thrum_scope_begin("the measurement", error);
  t->speeds = thrum_scope_allocate(&t->memory, model->rank, sizeof *t->speeds);
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++)
    t->samples[n] = thrum_scope_allocate(&t->memory, bench->steps, sizeof *t->samples[n]);
  THRUM_TRY(t->memory.status);

  // a body without `rigid` has no mass of its own, and cannot move as a whole
  if (model->rigid == NULL || model->rank < 1)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model is held: contact is measured with a free body, which "
                           "thrum precompute makes without --fix");

  // find the size of the body, and a vibration that all modes share
  double least[3], most[3];
  thrum_box3(model->vertices, model->vertex_count, least, most);
  t->diagonal = thrum_box3_diagonal(model->vertices, model->vertex_count);
  t->height = most[2] - least[2];
  const double mass = 1.0 / (model->rigid[0] * model->rigid[0]);
  for (int64_t i = 0; i < model->rank; i++)
    t->speeds[i] = SPEED * t->diagonal * sqrt(mass / (double)model->rank);
  THRUM_TRY(thrum_thread_team_make(bench->threads, &t->team, error));
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++)
    THRUM_TRY(make_scene(t, (bench_contact_scene)n, error));
  return THRUM_OK;
}

/* One step of every scene; their times from sample `at` on, unless that is below 0. */
static thrum_status step_all(trial *t, int64_t at, thrum_error *error) {
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++) {
    const double began = clock_seconds();
    THRUM_TRY(thrum_scene_step(t->scenes[n], error));
    if (at >= 0)
      t->samples[n][at] = 1e6 * (clock_seconds() - began);
  }
  return THRUM_OK;
}

static thrum_status measure(trial *t, bench_contact *bench, thrum_error *error) {
  const thrum_scene *touching = t->scenes[BENCH_CONTACT_TOUCHING];
  for (int64_t k = 0; k < SETTLE; k++)
    THRUM_TRY(step_all(t, -1, error));
  const int64_t swept = thrum_scene_collisions(touching).sweeps;
  bench->touches = 0.0;
  for (int64_t k = 0; k < bench->steps; k++) {
    THRUM_TRY(step_all(t, k, error));
    bench->touches += (double)thrum_scene_collisions(touching).touching / (double)bench->steps;
  }

  bench->sweeps = (double)(thrum_scene_collisions(touching).sweeps - swept) / (double)bench->steps;
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++)
    bench->time[n] = bench_summary(t->samples[n], bench->steps);
  return THRUM_OK;
}

thrum_status bench_contact_run(bench_contact *bench, thrum_error *error) {
  trial t = {.bench = bench};
  thrum_status status = THRUM_OK;
  if (2 * bench->pairs > bench->bodies)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld pairs need %lld bodies; there are %lld", (long long)bench->pairs,
                           2 * (long long)bench->pairs, (long long)bench->bodies);
  THRUM_THEN(status, make_trial(&t, error));
  THRUM_THEN(status, measure(&t, bench, error));

  // scenes go before the threads that step them
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++)
    thrum_scene_destroy(t.scenes[n]);
  thrum_thread_team_free(t.team);
  thrum_scope_free(&t.memory);
  return status < 0 ? status : THRUM_OK;
}
