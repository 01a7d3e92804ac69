/* A free body that is thrown, rotates and vibrates, in the full order: nothing acts on it, so its
 * energy and both momenta stay. The energy-momentum step keeps them to rounding (Simo and Tarnow
 * 1992, The discrete energy-momentum method, doi:10.1007/BF00913408); Newmark does not.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "precompute/full/full.h"
#include "validation/published/published.h"

#define STEPS 300
#define DT 0.01

/* Ratios of the end to the start that are furthest from 1 on the way. */
typedef struct kept {
  double energy, angular, linear;
} kept;

static double length(const double v[3]) {
  return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

static void note(double ratio, double *furthest) {
  if (fabs(ratio - 1) > fabs(*furthest - 1))
    *furthest = ratio;
}

static thrum_status throw(const thrum_model *model, thrum_full *full, thrum_error *error) {
  const int64_t count = model->vertex_count;
  double *u = NULL;
  THRUM_TRY(thrum_reserve(&u, 6 * count, sizeof *u, "a body that is thrown", error));
  double *v = u + 3 * count;

  // a stretch and a bend, and a velocity that moves, turns and bends the body
  for (int64_t n = 0; n < count; n++) {
    const double *x = model->vertices + 3 * n;
    u[3 * n] = 0.1 * x[0];
    u[3 * n + 1] = 0.15 * x[0] * x[0];
    v[3 * n] = 0.3 - 2 * x[1] + x[2];
    v[3 * n + 1] = -0.2 + 2 * x[0] - 3 * x[2];
    v[3 * n + 2] = 0.5 - x[0] + 3 * x[1] + 0.5 * x[0] * x[0];
  }
  const thrum_status status = thrum_full_set(full, u, v, error);
  free(u);
  return status;
}

static thrum_status tumble(const thrum_model *model, thrum_full_scheme scheme, kept *furthest,
                           thrum_error *error) {
  thrum_full_def def = thrum_default_full_def();
  thrum_full *full = NULL;
  double linear[2][3], angular[2][3];
  def.scheme = scheme;
  def.dt = DT;
  def.tolerance = 1e-13;

  thrum_status status = thrum_full_create(model, NULL, &def, &full, error);
  THRUM_THEN(status, throw(model, full, error));
  *furthest = (kept){1, 1, 1};
  if (status >= 0)
    thrum_full_momentum(full, linear[0], angular[0]);
  const double energy = status >= 0 ? thrum_full_energy(full).total : 0;

  // the worst ratio of the run to its start
  for (int k = 0; k < STEPS && status >= 0; k++) {
    status = thrum_full_step(full, error);
    if (status < 0)
      break;
    thrum_full_momentum(full, linear[1], angular[1]);
    note(thrum_full_energy(full).total / energy, &furthest->energy);
    note(length(linear[1]) / length(linear[0]), &furthest->linear);
    note(length(angular[1]) / length(angular[0]), &furthest->angular);
  }
  thrum_full_free(full);
  return status < 0 ? status : THRUM_OK;
}

thrum_status published_tumble(const published_sink *sink, thrum_error *error) {
  static const struct {
    const char *energy, *angular, *linear;
    thrum_full_scheme scheme;
  } schemes[2] = {
      {"energy step: energy", "energy step: angular momentum", "energy step: linear momentum",
       THRUM_FULL_ENERGY},
      {"Newmark: energy", "Newmark: angular momentum", "Newmark: linear momentum",
       THRUM_FULL_NEWMARK},
  };

  published_body body = {.mesh = "beam:5x1x1@1x0.2x0.2", .material = {1e4, 0.3, 1000}};
  thrum_precomputed made = {0};
  thrum_status status = THRUM_OK;
  THRUM_TRY(published_precompute(&body, 2, 2, false, &made, error));

  // the same throw for both schemes
  for (int n = 0; n < 2 && status >= 0; n++) {
    kept furthest;
    status = tumble(&made.model, schemes[n].scheme, &furthest, error);
    if (status < 0)
      break;
    published_add(sink, "tumble", schemes[n].energy, body.mesh, 0, 1, furthest.energy);
    published_add(sink, "tumble", schemes[n].angular, body.mesh, 0, 1, furthest.angular);
    published_add(sink, "tumble", schemes[n].linear, body.mesh, 0, 1, furthest.linear);
  }
  thrum_precomputed_free(&made);
  return status;
}
