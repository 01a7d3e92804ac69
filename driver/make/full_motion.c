/* The motion of the full order, sampled. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/full_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/full/full.h"
#include "thrum/equilibrium.h"
#include "thrum/external_load.h"

void full_motion_between(double time, int64_t samples, double begin, double dt, int64_t count,
                         const double *from, const double *to,
                         void (*take)(void *context, int64_t index, double share,
                                      const double *value),
                         void *context, double *work) {
  const double spacing = time / (double)samples, slack = 1e-9 * spacing;
  // the samples in (begin, begin + dt]; the first step's begin belongs to no sample
  for (int64_t n = (int64_t)floor((begin + slack) / spacing) + 1;
       n <= samples && (double)n * spacing <= begin + dt + slack; n++) {
    const double s = ((double)n * spacing - begin) / dt, r = 1 - s;

    // cubic Hermite: values, then slopes
    for (int64_t i = 0; i < count; i++) {
      const double a = from[i], va = dt * from[count + i], b = to[i], vb = dt * to[count + i];
      work[i] = r * r * ((1 + 2 * s) * a + s * va) + s * s * ((3 - 2 * s) * b - r * vb);
      work[count + i] = (6 * s * r * (b - a) + r * (1 - 3 * s) * va + s * (3 * s - 2) * vb) / dt;
    }
    take(context, n - 1, s, work);
  }
}

/* A motion under way: what take() needs, and the fields of the stepping, which are two ends, a
 * sample between them, and the forces. */
typedef struct motion {
  const full_motion_script *script;
  const full_motion_observer *observer;
  int64_t all; /* components */
  double dt;
  double *from, *to, *between, *forces; /* u, then v; from owns them all */
  double *unit;                         /* M 1 along x, y and z; NULL: the base is still */
  double energy_from, energy_to;
} motion;

static void take(void *context, int64_t index, double share, const double *value) {
  const motion *m = context;
  m->observer->take(m->observer->context, index, value, value + m->all,
                    (1 - share) * m->energy_from + share * m->energy_to);
}

/* The mean forces of all loads and of the base in a step. */
static void load(const motion *m, int64_t step) {
  const full_motion_script *script = m->script;
  memset(m->forces, 0, (size_t)m->all * sizeof *m->forces);
  for (int64_t n = 0; n < script->load_count; n++) {
    const double mean = thrum_load_mean(&script->courses[n], step, m->dt);
    for (int64_t c = 0; c < m->all && mean != 0; c++)
      m->forces[c] += mean * script->forces[n * m->all + c];
  }
  if (m->unit == NULL)
    return;

  // relative to the base, its acceleration acts as gravity against it
  double mean[3];
  base_motions_mean(script->base_motions, script->base_motion_count, step, m->dt, mean);
  for (int axis = 0; axis < 3; axis++)
    for (int64_t c = 0; c < m->all && mean[axis] != 0; c++)
      m->forces[c] -= mean[axis] * m->unit[axis * m->all + c];
}

/* Brings the body to where it starts, which is m->from. */
static thrum_status begin(motion *m, thrum_full *full, thrum_error *error) {
  const full_motion_script *script = m->script;
  if (script->held_by != NULL) {
    thrum_full_equilibrium found;
    THRUM_TRY(thrum_full_rest(full, script->held_by, NULL, &found, error));
    THRUM_TRY(thrum_full_set_force(full, NULL, error));
  }
  thrum_full_get(full, m->from, m->from + m->all);
  if (script->start != NULL) {
    for (int64_t c = 0; c < m->all; c++)
      m->from[c] += script->start[c];
    THRUM_TRY(thrum_full_set(full, m->from, NULL, error));
  }
  m->energy_from = thrum_full_energy(full).total;

  // the base moves all of the mass
  for (int axis = 0; axis < 3 && m->unit != NULL; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    thrum_full_add_gravity(full, unit, m->unit + axis * m->all);
  }
  return THRUM_OK;
}

static thrum_status step_all(motion *m, thrum_full *full, double *us_per_step, thrum_error *error) {
  const int64_t all = m->all, steps = thrum_step_count(m->script->time, m->dt);
  const full_motion_observer *observer = m->observer;
  double seconds = 0;

  // only the step itself is timed
  for (int64_t k = 0; k < steps; k++) {
    load(m, k);
    const double began = clock_thread_seconds();
    THRUM_TRY(thrum_full_set_force(full, m->forces, error));
    THRUM_TRY(thrum_full_step(full, error));
    seconds += clock_thread_seconds() - began;
    thrum_full_get(full, m->to, m->to + all);

    // samples lie between steps
    m->energy_to = thrum_full_energy(full).total;
    full_motion_between(m->script->time, observer->samples, (double)k * m->dt, m->dt, all, m->from,
                        m->to, take, m, m->between);
    memcpy(m->from, m->to, 2 * (size_t)all * sizeof *m->from);
    m->energy_from = m->energy_to;
    if (observer->progress != NULL &&
        !observer->progress(observer->progress_context, (double)(k + 1) / (double)steps))
      return thrum_error_set(error, THRUM_INTERRUPTED, "interrupted");
  }
  if (us_per_step != NULL)
    *us_per_step = 1e6 * seconds / (double)steps;
  return THRUM_OK;
}

thrum_status full_motion_run(const thrum_model *model, const full_motion_script *script, double dt,
                             const full_motion_observer *observer, double *us_per_step,
                             thrum_error *error) {
  const int64_t all = 3 * model->vertex_count;
  motion m = {.script = script, .observer = observer, .all = all, .dt = dt};
  thrum_full *full = NULL;
  thrum_full_def def = thrum_default_full_def();
  def.dt = dt;
  def.damping_alpha = script->damping_alpha;
  def.damping_beta = script->damping_beta;
  def.law = thrum_law_of_model(model);
  if (script->yield > 0)
    def.plastic.yield = script->yield;

  // one block for all fields
  const int64_t fields = script->base_motion_count > 0 ? 10 : 7;
  THRUM_TRY(thrum_reserve(&m.from, fields * all, sizeof *m.from, "the full order", error));
  m.to = m.from + 2 * all;
  m.between = m.to + 2 * all;
  m.forces = m.between + 2 * all;
  m.unit = script->base_motion_count > 0 ? m.forces + all : NULL;

  thrum_status status = thrum_full_create(model, NULL, &def, &full, error);
  THRUM_THEN(status, begin(&m, full, error));
  THRUM_THEN(status, step_all(&m, full, us_per_step, error));
  thrum_full_free(full);
  free(m.from);
  return status;
}

/* --- the same on a reduced model --------------------------------------------------------------
 */

/* q = the model's own equilibrium under the forces. */
static thrum_status reduced_rest(const thrum_model *model, const double *forces, double *q,
                                 thrum_error *error) {
  const thrum_equilibrium_def def = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  double load[THRUM_RANK_MAX] = {0};
  size_t size = 0;
  THRUM_TRY(thrum_load_add_field(model, forces, load, error));
  THRUM_TRY(thrum_equilibrium_size(model, &size, error));
  void *workspace = NULL;
  THRUM_TRY(thrum_reserve_aligned(&workspace, size, "an equilibrium", error));
  const thrum_status status =
      thrum_equilibrium(model, &def, load, q, workspace, size, &report, error);
  free(workspace);
  return status;
}

thrum_status full_motion_reduced_start(const thrum_model *model, const thrum_model_fem *body,
                                       const full_motion_script *script, double *q,
                                       thrum_error *error) {
  const int64_t n = body->fem.free_count, rank = model->rank;
  memset(q, 0, (size_t)rank * sizeof *q);
  if (script->held_by != NULL)
    THRUM_TRY(reduced_rest(model, script->held_by, q, error));
  if (script->start == NULL)
    return THRUM_OK;

  // U^T M of the displacement, which other bases may not show in full
  double *field = NULL;
  THRUM_TRY(thrum_reserve(&field, 2 * n, sizeof *field, "a start", error));
  thrum_fem_gather(&body->fem, script->start, field);
  thrum_sparse_product(&body->mass, field, 1, field + n);
  for (int64_t f = 0; f < n; f++)
    for (int64_t i = 0; i < rank; i++)
      q[i] += model->basis[body->fem.component[f] * rank + i] * field[n + f];
  free(field);
  return THRUM_OK;
}

thrum_status full_motion_reduced_base(const thrum_model *model, const full_motion_script *script,
                                      int64_t step, double dt, double *force, thrum_error *error) {
  double mean[3];
  if (script->base_motion_count == 0)
    return THRUM_OK;
  base_motions_mean(script->base_motions, script->base_motion_count, step, dt, mean);
  return thrum_base_motion_load(model, mean, force, error);
}
