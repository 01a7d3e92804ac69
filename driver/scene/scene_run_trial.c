/* Trial runs for the keys "error" and "budget": one body of the scene file in a scene of its own,
 * with all coordinates and then condensed (design 16), over the first seconds.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_trial.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "driver/scene/scene_run_world.h"
#include "io/file_hash.h"
#include "platform/allocate.h"
#include "precompute/build_info.h"
#include "thrum/version.h"

#define TRIAL_TIME 2.0 /* of the scene [s] that is tried, or all of it */
#define TRIAL_EVERY 4  /* steps between two shapes that are compared */

double scene_trial_seconds(const scene_run *run) {
  return fmin(run->spec.time, TRIAL_TIME);
}

static int64_t trial_steps(const scene_run *run) {
  return (int64_t)fmin((double)run->steps, ceil(TRIAL_TIME / run->dt));
}

/* --- what a trial depends on ------------------------------------------------------------------ */

static uint64_t hash_numbers(uint64_t hash, const double *values, int64_t count) {
  return hash_bytes(hash, values, (size_t)count * sizeof *values);
}

static uint64_t hash_course(uint64_t hash, const thrum_load *course) {
  double numbers[LOAD_COURSE_NUMBERS];
  load_course_numbers(course, numbers);
  return hash_numbers(hash, numbers, LOAD_COURSE_NUMBERS);
}

/* Adds the definition of the body's state to the hash. */
static uint64_t hash_state(uint64_t hash, const thrum_state_def *def) {
  // field by field: the bytes between fields have any content
  const double numbers[] = {(double)def->integrator,
                            def->dt,
                            def->damping_alpha,
                            def->damping_beta,
                            (double)def->damping_form,
                            (double)def->split_rule,
                            def->split_safety,
                            def->newmark_beta,
                            def->newmark_gamma,
                            def->tolerance,
                            (double)def->explicit_count,
                            (double)def->iterations_max,
                            (double)def->split_form,
                            (double)def->adaptive,
                            (double)def->fallback,
                            (double)def->solver,
                            (double)def->frequency_matched,
                            (double)def->untrained_flow};

  return hash_numbers(hash, numbers, sizeof numbers / sizeof numbers[0]);
}

/* Adds an obstacle to the hash. */
static uint64_t hash_obstacle(uint64_t hash, const thrum_obstacle *obstacle) {
  const double numbers[] = {
      (double)obstacle->shape, (double)obstacle->inside, obstacle->radius,  obstacle->stiffness,
      obstacle->damping,       obstacle->restitution,    obstacle->friction};
  hash = hash_numbers(hash, numbers, sizeof numbers / sizeof numbers[0]);
  hash = hash_numbers(hash_numbers(hash, obstacle->centre, 3), obstacle->normal, 3);
  hash = hash_numbers(hash_numbers(hash, obstacle->half, 3), obstacle->rotation, 9);
  return hash_numbers(hash, obstacle->velocity, 3);
}

/* Adds to the hash what acts on all bodies of the scene. */
static uint64_t hash_world(uint64_t hash, const scene_run *run) {
  const scene_wind_spec *wind = &run->spec.wind;
  hash = hash_numbers(hash, run->spec.gravity, 3);

  // base motions by their numbers: those of a file may change under the same name
  for (int64_t n = 0; n < run->base_motion_count; n++) {
    const base_motion_spec *base = &run->base_motions[n];
    hash = hash_course(hash_numbers(hash, base->amplitude, 3), &base->course);
    if (base->sine)
      continue;
    hash = hash_numbers(hash, base->motion.times, base->motion.count);
    hash = hash_numbers(hash, base->motion.accelerations, 3 * base->motion.count);
  }

  // wind and obstacles
  if (wind->at.node != NULL) {
    const double numbers[] = {wind->velocity[0], wind->velocity[1], wind->velocity[2],
                              wind->density, wind->drag};
    hash = hash_numbers(hash, numbers, 5);
  }
  for (int64_t n = 0; n < run->spec.obstacles.count; n++) {
    thrum_obstacle obstacle;
    if (thrum_scene_obstacle_get(run->scene, (int32_t)n, &obstacle, NULL) >= 0)
      hash = hash_obstacle(hash, &obstacle);
  }
  return hash;
}

uint64_t scene_trial_hash(const scene_run *run, int32_t n) {
  const scene_body_run *body = &run->bodies[n];
  const thrum_scene_body_def *def = &body->def;
  const uint64_t model = scene_model_of(&run->models, n)->hash.arrays;
  const int64_t rank = body->model->rank;
  uint64_t hash = hash_bytes(0, &model, sizeof model);
  hash = hash_state(hash_world(hash, run), &def->state);

  // the body: where it stands matters to what stands in its way alone
  const double numbers[] = {
      (double)rank,      (double)trial_steps(run), def->scale,           def->stiffness,
      def->density,      (double)def->free,        def->touch_stiffness, (double)def->touch_count,
      body->spec->error, body->spec->budget};
  hash = hash_numbers(hash, numbers, sizeof numbers / sizeof numbers[0]);
  hash = hash_numbers(hash_numbers(hash, def->velocity, 3), def->spin, 3);
  hash = hash_numbers(hash, def->rotation, 4);
  if (run->spec.obstacles.count > 0)
    hash = hash_numbers(hash, def->position, 3);
  if (def->touch_count > 0)
    hash = hash_bytes(hash, def->touch, (size_t)def->touch_count * sizeof *def->touch);
  hash = hash_numbers(hash, body->start, 2 * rank);

  // loads count as they act on the coordinates of the body
  for (int64_t l = 0; l < thrum_scene_load_count(run->scene, n); l++) {
    thrum_scene_load_def load;
    if (thrum_scene_load_get(run->scene, n, l, &load, NULL) < 0)
      continue;
    hash = hash_numbers(hash_course(hash, &load.course), load.reduced, rank);
    if (load.parts != NULL)
      hash = hash_numbers(hash, load.parts, 9 * rank);
  }

  // versions and the compiler, because other code may round differently
  char text[256];
  const int length =
      snprintf(text, sizeof text, "%s|%.120s", thrum_version(), thrum_build_compiler());
  return hash_bytes(hash, text, (size_t)length);
}

/* --- the scene of one body -------------------------------------------------------------------- */

static thrum_status fill(scene_trial *trial, thrum_error *error) {
  const scene_run *run = trial->run;
  thrum_scene_body_def def = run->bodies[trial->number].def;
  for (int64_t n = 0; n < run->base_motion_count; n++)
    THRUM_TRY(scene_run_add_base_motion(&run->base_motions[n], trial->scene, error));
  THRUM_TRY(thrum_scene_set_gravity(trial->scene, run->spec.gravity, error));
  THRUM_TRY(thrum_scene_add_body(trial->scene, &def, NULL, error));

  // loads as the engine has reduced them already
  for (int64_t l = 0; l < thrum_scene_load_count(run->scene, trial->number); l++) {
    thrum_scene_load_def load;
    THRUM_TRY(thrum_scene_load_get(run->scene, trial->number, l, &load, error));
    THRUM_TRY(thrum_scene_add_load(trial->scene, 0, &load, error));
  }
  THRUM_TRY(scene_run_wind(run, trial->scene));
  return scene_run_obstacles(run, trial->scene);
}

/* The shape of the body; false where its run has failed. */
static bool read_shape(const scene_trial *trial, double *q) {
  thrum_scene_body_info info;
  thrum_scene_body(trial->scene, 0, &info, NULL);
  return info.status >= 0 && thrum_scene_body_shape(trial->scene, 0, q, NULL) >= 0;
}

/* The shapes with all coordinates. */
static thrum_status run_whole(scene_trial *trial, thrum_error *error) {
  const int64_t rank = trial->run->bodies[trial->number].model->rank;
  THRUM_TRY(thrum_reserve(&trial->rows, (trial->steps / TRIAL_EVERY + 1) * rank, sizeof(double),
                          "a trial", error));
  for (int64_t step = 0; step < trial->steps; step++) {
    thrum_scene_step(trial->scene, NULL);
    if ((step + 1) % TRIAL_EVERY != 0)
      continue;
    double *row = trial->rows + step / TRIAL_EVERY * rank;

    // one that fails says nothing of its error
    if (!read_shape(trial, row)) {
      trial->size = 0;
      return THRUM_OK;
    }
    for (int64_t i = 0; i < rank; i++)
      trial->size += row[i] * row[i];
  }
  return THRUM_OK;
}

thrum_status scene_trial_open(const scene_run *run, int32_t number, scene_trial *trial,
                              thrum_error *error) {
  *trial = (scene_trial){.run = run, .number = number, .steps = trial_steps(run)};
  THRUM_TRY(thrum_scene_create(run->dt, &trial->scene, error));
  THRUM_TRY(fill(trial, error));
  return run_whole(trial, error);
}

void scene_trial_close(scene_trial *trial) {
  thrum_scene_destroy(trial->scene);
  free(trial->rows);
  *trial = (scene_trial){0};
}

thrum_status scene_trial_run(scene_trial *trial, int64_t masters, double most, double *found,
                             thrum_error *error) {
  const int64_t rank = trial->run->bodies[trial->number].model->rank;
  double away = 0, q[THRUM_RANK_MAX];
  *found = INFINITY;
  THRUM_TRY(thrum_scene_set_condensed(trial->scene, 0, masters, error));
  THRUM_TRY(thrum_scene_reset(trial->scene, error));

  // the sum only grows, so a run that is too far off need not go on
  for (int64_t step = 0; step < trial->steps && away <= most * most * trial->size; step++) {
    thrum_scene_step(trial->scene, NULL);
    if ((step + 1) % TRIAL_EVERY != 0)
      continue;
    const double *row = trial->rows + step / TRIAL_EVERY * rank;
    if (!read_shape(trial, q))
      return THRUM_OK;
    for (int64_t i = 0; i < rank; i++)
      away += (q[i] - row[i]) * (q[i] - row[i]);
  }
  if (away <= most * most * trial->size)
    *found = sqrt(away / trial->size);
  return THRUM_OK;
}
