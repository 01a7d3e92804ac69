/* A free body whose spin and shape act on each other (thrum/floating_frame.h).
 *
 * A slender bar of length l that spins across its axis at w stretches in its frame until E u'' =
 * -rho w^2 (x + u), u = 0 in the middle and u' = 0 at the ends, so that a half has the length tan(k
 * l/2)/k with k = w sqrt(rho/E). A body that spins about its middle axis and swings keeps its
 * energy, and the angular momentum that its mass and velocities have.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "validation/published/published.h"

#define YOUNG 1e6
#define DENSITY 1000.0

/* A body in flight. */
typedef struct flight {
  thrum_precomputed made;
  thrum_inertia *inertia;
  thrum_state *state;
  thrum_rigid_frame frame;
  double *work, *q, *p; /* one block */
} flight;

static void land(flight *f) {
  thrum_state_destroy(f->state);
  thrum_inertia_destroy(f->inertia);
  thrum_precomputed_free(&f->made);
  free(f->work);
}

/* Makes a flight that is at rest in its shape; land() frees it, whatever came of it. */
static thrum_status take_off(const published_body *body, int64_t modes, int64_t rank,
                             const thrum_state_def *def, flight *f, thrum_error *error) {
  *f = (flight){.work = NULL};
  THRUM_TRY(published_precompute(body, modes, rank, false, &f->made, error));
  const thrum_model *model = &f->made.model;
  THRUM_TRY(thrum_inertia_create(model, 0, NULL, &f->inertia, error));
  THRUM_TRY(thrum_state_create(model, def, &f->state, error));
  THRUM_TRY(thrum_rigid_frame_of(model, &f->frame, error));

  const size_t count = thrum_floating_frame_work_count(f->inertia), r = (size_t)model->rank;
  THRUM_TRY(thrum_reserve(&f->work, (int64_t)(count + 2 * r), sizeof *f->work, "a body that spins",
                          error));
  f->q = f->work + count;
  f->p = f->q + r;
  return THRUM_OK;
}

/* Starts it from its q and p with a spin. */
static thrum_status start(flight *f, const double spin[3], thrum_error *error) {
  THRUM_TRY(thrum_state_set(&f->made.model, f->state, f->q, f->p, error));
  THRUM_TRY(thrum_floating_frame_settle(f->inertia, f->q, f->p, &f->frame, f->work, error));
  thrum_floating_frame_spin(NULL, spin, &f->frame);
  return THRUM_OK;
}

static thrum_status step(flight *f, thrum_error *error) {
  static const double none[3] = {0};
  return thrum_floating_frame_step(&f->made.model, f->state, f->inertia, NULL, &f->frame, none,
                                   NULL, f->work, error);
}

/* --- the bar ---------------------------------------------------------------------------------- */

/* Half of how far the mean places of the end faces of a bar of unit length have parted [m]. */
static double stretch_of(const flight *f) {
  const thrum_model *model = &f->made.model;
  double sum = 0, count = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    const double side = 2 * model->vertices[3 * v] - 1;
    if (fabs(fabs(side) - 1) > 1e-9)
      continue;
    for (int64_t i = 0; i < model->rank; i++)
      sum += side * model->basis[3 * v * model->rank + i] * f->q[i];
    count++;
  }
  return sum / count;
}

static thrum_status bar_row(const published_sink *sink, int cells, thrum_error *error) {
  published_body body = {.material = {YOUNG, 0, DENSITY}};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx2x2@1x0.1x0.1", cells);
  thrum_state_def def = thrum_default_state_def();
  def.dt = 5e-3;
  def.damping_alpha = 30;
  flight f;
  thrum_status status = take_off(&body, 12, 30, &def, &f, error);

  // damped until it rests in its frame
  const double spin[3] = {0, 0, 4};
  THRUM_THEN(status, start(&f, spin, error));
  for (int n = 0; n < 600 && status >= 0; n++)
    status = step(&f, error);
  THRUM_THEN(status, thrum_state_get(&f.made.model, f.state, f.q, NULL, error));
  if (status >= 0) {
    double now[3];
    thrum_rigid_frame_velocity(&f.frame, NULL, now);
    const double k = now[2] * sqrt(DENSITY / YOUNG), closed = tan(0.5 * k) / k - 0.5;
    published_add(sink, "spin", "stretch of a half of a bar, mm", body.mesh, cells, 1e3 * closed,
                  1e3 * stretch_of(&f));
  }
  land(&f);
  return status;
}

/* --- what is kept ----------------------------------------------------------------------------- */

static double energy_of(const flight *f) {
  thrum_energies energies = {0};
  thrum_state_energies(&f->made.model, f->state, &energies, NULL);
  return energies.kinetic + energies.potential + thrum_rigid_frame_energy(&f->frame, NULL);
}

/* The angular momentum of the deformed body with the velocities that it has. */
static double momentum_of(flight *f) {
  thrum_rigid_frame now = f->frame;
  double spin[3];
  thrum_rigid_frame_velocity(&f->frame, NULL, spin);
  thrum_state_get(&f->made.model, f->state, f->q, f->p, NULL);
  thrum_floating_frame_settle(f->inertia, f->q, f->p, &now, f->work, NULL);
  thrum_floating_frame_spin(NULL, spin, &now);
  return sqrt(now.momentum[0] * now.momentum[0] + now.momentum[1] * now.momentum[1] +
              now.momentum[2] * now.momentum[2]);
}

static void note(double ratio, double *furthest) {
  if (fabs(ratio - 1) > fabs(*furthest - 1))
    *furthest = ratio;
}

/* Steps of a soft top that spins about its middle axis and swings. */
static thrum_status top_rows(const published_sink *sink, int steps, thrum_error *error) {
  const published_body body = {.mesh = "beam:4x2x1@1x0.6x0.2", .material = {1e5, 0.3, 1000}};
  thrum_state_def def = thrum_default_state_def();
  def.dt = 5e-3;
  flight f;
  thrum_status status = take_off(&body, 4, 6, &def, &f, error);
  for (int i = 0; i < 6 && status >= 0; i++)
    f.p[i] = (i % 2 ? -0.3 : 0.3) * sqrt(f.made.mass);
  const double spin[3] = {0.2, 8, 0.2};
  THRUM_THEN(status, start(&f, spin, error));

  // the worst ratios of the run to its start
  double energy = 1, momentum = 1;
  const double first = status >= 0 ? energy_of(&f) : 1, angular = status >= 0 ? momentum_of(&f) : 1;
  for (int n = 0; n < steps && status >= 0; n++) {
    status = step(&f, error);
    note(energy_of(&f) / first, &energy);
    note(momentum_of(&f) / angular, &momentum);
  }
  land(&f);
  if (status < 0)
    return status;
  char setting[64];
  snprintf(setting, sizeof setting, "%d steps", steps);
  published_add(sink, "spin", "energy of a soft top", setting, 0, 1, energy);
  published_add(sink, "spin", "angular momentum of a soft top", setting, 0, 1, momentum);
  return THRUM_OK;
}

thrum_status published_spin(const published_sink *sink, thrum_error *error) {
  for (int level = 0; level <= sink->level; level++)
    THRUM_TRY(bar_row(sink, 6 << level, error));
  int steps = 1000;
  for (int level = 0; level <= sink->level; level++, steps *= 10)
    THRUM_TRY(top_rows(sink, steps, error));
  return THRUM_OK;
}
