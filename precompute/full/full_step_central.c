/* Explicit central differences with lumped mass, in the form of velocities at whole steps
 * (design 13): half a kick, a drift, half a kick, both under the mean load of the step,
 *
 *   v+ = v + h/2 (M^-1 (f - R(u)) - alpha v),  u' = u + h v+,
 *   v' = (v+ + h/2 M^-1 (f - R(u')))/(1 + alpha h/2).
 *
 * Stable at rest for h < 2/omega_max, which power iterations on M^-1 K bound from below; they go on
 * until they change by less than a thousandth, and a thousandth is kept back.
 * Cost: one assembly of forces a step, nothing to solve.
 * Source: Courant, Friedrichs & Lewy 1928, doi:10.1007/BF01448839.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "precompute/full/full_private.h"

#define POWER_MAX 2000
#define SETTLED 1e-6
#define KEPT_BACK 0.999

/* Largest eigenvalue of M^-1 K at rest. */
static double largest_omega2(thrum_full *full) {
  const int64_t n = full->body.fem.free_count;
  double before = 0, now = 0;

  // signs that alternate and sizes that do not repeat: rich in what is fastest
  for (int64_t i = 0; i < n; i++)
    full->trial[i] = (i % 2 ? -1.0 : 1.0) * (1.0 + 0.5 * sin((double)i));

  for (int k = 0; k < POWER_MAX; k++) {
    double norm = 0, along = 0;
    for (int64_t i = 0; i < n; i++)
      norm += full->lumped[i] * full->trial[i] * full->trial[i];
    for (int64_t i = 0; i < n; i++)
      full->trial[i] /= sqrt(norm);

    // the Rayleigh quotient of a vector of unit mass norm, and the next vector
    thrum_sparse_product(&full->body.stiffness, full->trial, 1, full->product);
    along = full_dot(full, full->trial, full->product);
    for (int64_t i = 0; i < n; i++)
      full->trial[i] = full->product[i] / full->lumped[i];

    before = now;
    now = along;
    if (k > 20 && fabs(now - before) <= SETTLED * now)
      break;
  }

  return now;
}

thrum_status full_central_begin(thrum_full *full, thrum_error *error) {
  const thrum_fem *fem = &full->body.fem;
  thrum_fem_vertex_mass(fem, THRUM_MASS_LUMPED, full->place);
  for (int64_t i = 0; i < fem->free_count; i++)
    full->lumped[i] = full->place[fem->component[i] / 3];
  full->dt_stable = KEPT_BACK * 2 / sqrt(largest_omega2(full));
  if (full->def.dt < full->dt_stable)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "full order: central differences are not stable at dt = %g s; of this "
                         "mesh they take less than %.3g s at rest, and less again where it is "
                         "compressed or stretched",
                         full->def.dt, full->dt_stable);
}

/* M^-1 (f - R) at u + d into `a`. */
static void accelerate(thrum_full *full, const double *d, double *a) {
  const int64_t n = full->body.fem.free_count;
  memcpy(a, full->f, (size_t)n * sizeof *a);
  full_place(full, full->u, 1, d, full->place);
  full_subtract_forces(full, full->place, a);
  for (int64_t i = 0; i < n; i++)
    a[i] /= full->lumped[i];
}

thrum_status full_step_central(thrum_full *full, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  const double h = full->def.dt, alpha = full->def.damping_alpha;
  (void)error;
  if (full->fresh)
    accelerate(full, NULL, full->a);
  for (int64_t i = 0; i < n; i++) {
    full->v_next[i] = full->v[i] + 0.5 * h * (full->a[i] - alpha * full->v[i]);
    full->d[i] = h * full->v_next[i];
  }
  accelerate(full, full->d, full->a_next);
  for (int64_t i = 0; i < n; i++)
    full->v_next[i] = (full->v_next[i] + 0.5 * h * full->a_next[i]) / (1 + 0.5 * alpha * h);
  return THRUM_OK;
}
