/* One implicit step of the full-order body, for the increment d = u' - u (design 13):
 *
 *   Newmark   0 = f - R(u') - M a' - C v',       a' = (d - h v)/(beta h^2) - (1/(2 beta) - 1) a,
 *                                                v' = v + h [(1 - gamma) a + gamma a']
 *   energy    0 = f - R-bar - C d/h - M (2 d/h^2 - 2 v/h),   v' = 2 d/h - v,
 *             R-bar_a = sum_e w F-bar S-bar grad N_a, F-bar and S-bar the means of both ends
 *             or sum_e w P-bar grad N_a, the discrete gradient of another law (material_law_mean.c)
 *   midpoint  the same with R(u + d/2)
 *
 * As E' - E = sym(F-bar^T (G' - G)), R-bar d is the change of V exactly; S-bar is symmetric, so the
 * angular momentum stays too. Its Jacobian is not symmetric; that at the middle, 1/2 K(u + d/2),
 * stands in for it, so it is quasi-Newton that solves, with factors kept while they serve.
 * Corrections are measured in the norm of the matrix, |delta|^2 = delta r.
 * Cost: an assembly of forces an iteration; a factorisation every few steps.
 * Sources: Simo & Tarnow 1992, doi:10.1007/BF00913408; Gonzalez 2000, Exact energy and momentum
 * conserving algorithms for general models in nonlinear elasticity,
 * doi:10.1016/S0045-7825(00)00189-4.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <math.h>
#include <string.h>

#include "precompute/fem/fem_solids.h"
#include "precompute/full/full_private.h"
#include "precompute/material/material_law_mean.h"

#define SLOW 0.05               /* contraction above which factors are made anew */
#define FLOOR (4 * DBL_EPSILON) /* of the increment and the displacement */
#define STALLED 1e-12 /* of the increment: rounding may keep a step from being solved better */

/* F-bar and S-bar, the means of both ends, into `to`. */
static void average(const thrum_tet *from, thrum_tet *to) {
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      to->stress[c][d] = 0.5 * (from->stress[c][d] + to->stress[c][d]);
      to->deformation[c][d] = 0.5 * (from->deformation[c][d] + to->deformation[c][d]);
    }
}

/* Adds the mean forces at one point of a tet. */
static void add_mean_forces(thrum_full *full, int64_t t, int p) {
  const thrum_fem *fem = full_elastic(full);
  thrum_tet from, to;

  // other laws take both ends at once
  if (thrum_fem_law(fem, fem->tet_region[t]) == THRUM_LAW_STVK) {
    thrum_tet_deform(fem, t, p, full->place, &from);
    thrum_tet_deform(fem, t, p, full->place_to, &to);
    average(&from, &to);
  } else {
    thrum_fem_tet_at(fem, t, p, full->place, &from);
    thrum_fem_tet_at(fem, t, p, full->place_to, &to);
    thrum_law_mean_stress(to.law, to.lambda, to.mu, from.displacement, to.displacement, to.stress);
  }

  // w F-bar S-bar grad N_a, or w P-bar grad N_a
  for (int a = 0; a < fem->node_count; a++) {
    double force[3];
    thrum_tet_traction(&to, to.gradient[a], force);
    for (int c = 0; c < 3; c++)
      full->forces[3 * (int64_t)fem->nodes[fem->node_count * t + a] + c] += to.weight * force[c];
  }
}

/* Adds the mean forces of the springs to the ground. */
static void add_mean_springs(thrum_full *full) {
  const thrum_fem *fem = full_elastic(full);
  for (int64_t c = 0; fem->springs && c < 3 * fem->vertex_count; c++)
    full->forces[c] += fem->springs[c] * 0.5 * (full->place[c] + full->place_to[c]);
}

/* Adds the mean forces of what acts: the integral over the way, by Simpson's rule, which is exact
 * for volumes and strains. */
static void add_mean_actuators(thrum_full *full) {
  const thrum_fem *fem = full_elastic(full);
  const int64_t all = 3 * fem->vertex_count;
  if (!fem->acting)
    return;
  for (int k = 0; k < 3; k++) {
    for (int64_t c = 0; c < all; c++)
      full->acted[c] = (1 - 0.5 * k) * full->place[c] + 0.5 * k * full->place_to[c];
    memset(full->acted + all, 0, (size_t)all * sizeof *full->acted);
    thrum_fem_acting_energy(fem, full->acted, full->acted + all);
    for (int64_t c = 0; c < all; c++)
      full->forces[c] += (k == 1 ? 4 : 1) / 6.0 * full->acted[all + c];
  }
}

/* r -= R-bar between full->place and full->place_to. */
static void take_mean_forces(thrum_full *full, double *r) {
  const thrum_fem *fem = full_elastic(full);
  memset(full->forces, 0, (size_t)(3 * fem->vertex_count) * sizeof *full->forces);
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int p = 0; p < fem->point_count; p++)
      add_mean_forces(full, t, p);
  add_mean_springs(full);
  add_mean_actuators(full);
  thrum_fem_solids_mean_force(fem, full->place, full->place_to, full->forces);

  for (int64_t i = 0; i < fem->free_count; i++)
    r[i] -= full->forces[fem->component[i]];
}

/* v' and a' of the increment. */
static void advance(thrum_full *full) {
  const double h = full->def.dt, beta = full->def.newmark_beta, gamma = full->def.newmark_gamma;
  for (int64_t i = 0; i < full->body.fem.free_count; i++) {
    const double d = full->d[i], v = full->v[i], a = full->a[i];
    if (full->def.scheme == THRUM_FULL_NEWMARK) {
      full->a_next[i] = (d - h * v) / (beta * h * h) - (0.5 / beta - 1) * a;
      full->v_next[i] = v + h * ((1 - gamma) * a + gamma * full->a_next[i]);
    } else {
      full->v_next[i] = 2 * d / h - v;
      full->a_next[i] = 0;
    }
  }
}

/* Residual r of the increment. */
static void evaluate(thrum_full *full) {
  const int64_t n = full->body.fem.free_count;
  const double h = full->def.dt;
  advance(full);

  memcpy(full->r, full->f, (size_t)n * sizeof *full->r);

  // Newmark balances the forces at the end of the step
  if (full->def.scheme == THRUM_FULL_NEWMARK) {
    full_place(full, full->u, 1, full->d, full->place_to);
    full_subtract_forces(full, full->place_to, full->r);
    full_subtract_mass(full, 1, full->a_next, full->r);
    full_subtract_damping(full, 1, full->v_next, full->r);
    return;
  }

  // the others balance mean forces against the change of momentum
  if (full->def.scheme == THRUM_FULL_ENERGY) {
    full_place(full, full->u, 0, NULL, full->place);
    full_place(full, full->u, 1, full->d, full->place_to);
    take_mean_forces(full, full->r);
  } else {
    full_place(full, full->u, 0.5, full->d, full->place);
    full_subtract_forces(full, full->place, full->r);
  }

  full_subtract_damping(full, 1 / h, full->d, full->r);
  for (int64_t i = 0; i < n; i++)
    full->trial[i] = full->v_next[i] - full->v[i];
  full_subtract_mass(full, 1 / h, full->trial, full->r);
}

/* Factors the matrix at the present increment. Where it is not positive definite, the matrix of the
 * shape at rest takes its place: the step is then short enough for the mass to rule. With laws
 * other than Saint Venant-Kirchhoff's the tangent is made positive at each point instead. */
static thrum_status refresh(thrum_full *full, thrum_error *error) {
  const bool newmark = full->def.scheme == THRUM_FULL_NEWMARK;
  const double h = full->def.dt, beta = full->def.newmark_beta;
  const double of_mass = newmark ? 1 / (beta * h * h) : 2 / (h * h);
  const double of_damping = newmark ? full->def.newmark_gamma / (beta * h) : 1 / h;
  const double of_tangent = newmark ? 1 : 0.5;

  // the tangent where the integrator evaluates the force: at the end, or in the middle of the step
  full_place(full, full->u, newmark ? 1 : 0.5, full->d, full->place_to);
  thrum_status status = full_assemble(full, full->place_to, of_tangent, of_mass, of_damping, error);
  THRUM_THEN(status, full_linear_prepare(&full->linear, error));
  if (status != THRUM_SINGULAR)
    return status;

  // a matrix that is positive definite in its place
  full->positive = full->def.law != THRUM_LAW_STVK;
  const double *place = full->positive ? full->place_to : NULL;
  status = full_assemble(full, place, of_tangent, of_mass, of_damping, error);
  full->positive = false;
  return status >= 0 ? full_linear_prepare(&full->linear, error) : status;
}

/* Newmark: a = M^-1 (f - R - C v) where the load or the state is new, so that an impulse counts
 * once. */
static thrum_status take_acceleration(thrum_full *full, thrum_error *error) {
  memcpy(full->r, full->f, (size_t)full->body.fem.free_count * sizeof *full->r);
  full_place(full, full->u, 0, NULL, full->place);
  full_subtract_forces(full, full->place, full->r);
  full_subtract_damping(full, 1, full->v, full->r);
  return full_linear_solve(&full->mass, full->r, full->a, error);
}

/* Length in the norm of the matrix. */
static double norm_of(thrum_full *full, const double *x) {
  thrum_sparse_product(&full->system, x, 1, full->product);
  return sqrt(fmax(full_dot(full, x, full->product), 0));
}

/* Good enough: within the tolerance, or where rounding beside the increment and the displacement
 * stops the corrections from falling. */
static bool is_solved(thrum_full *full, double size, double before) {
  const double whole = norm_of(full, full->d);
  const double floor = FLOOR * fmax(whole, norm_of(full, full->u));
  return size <= full->def.tolerance * whole + floor ||
         (size <= STALLED * whole + 16 * floor && size > 0.5 * before);
}

static thrum_status say_stuck(thrum_full *full, thrum_error *error) {
  full->linear.ready = false;
  return thrum_error_set(error, THRUM_NOT_CONVERGED,
                         "step %lld of the full order at t = %g s did not converge; the body is as "
                         "it was before it: lower dt or the load",
                         (long long)full->steps, (double)full->steps * full->def.dt);
}

thrum_status full_step_implicit(thrum_full *full, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  thrum_status status = THRUM_OK;
  if (full->def.scheme == THRUM_FULL_NEWMARK && full->fresh)
    status = take_acceleration(full, error);

  // the first guess goes straight on
  for (int64_t i = 0; i < n; i++)
    full->d[i] = full->def.dt * full->v[i];

  double before = INFINITY, first = 0;
  bool renew = !full->linear.ready;
  for (int32_t k = 0; status >= 0; k++) {
    if (k == full->def.iterations_max)
      return say_stuck(full, error);

    evaluate(full);
    if (renew)
      status = refresh(full, error);
    THRUM_THEN(status, full_linear_solve(&full->linear, full->r, full->delta, error));

    // far from the solution a matrix may have no factors, or be of no use to conjugate gradients
    if (status == THRUM_SINGULAR)
      return say_stuck(full, error);
    if (status < 0)
      break;

    // the correction in the norm of the matrix; one that grows beyond the first is lost
    const double size = sqrt(fabs(full_dot(full, full->delta, full->r)));
    first = k == 0 ? size : first;
    if (!isfinite(size) || (k > 8 && size > first))
      return say_stuck(full, error);

    for (int64_t i = 0; i < n; i++)
      full->d[i] += full->delta[i];
    full->iterations++;
    if (is_solved(full, size, before))
      break;

    // factors that contract slowly are made anew
    renew = size > SLOW * before;
    before = size;
  }

  if (status >= 0)
    advance(full);
  return status;
}
