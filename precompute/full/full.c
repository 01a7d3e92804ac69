/* The full-order body: making it, setting and reading it, and what its steps are made of.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/full/full_private.h"
#include "runtime/material/principal.h"

#define DEF_COOKIE UINT32_C(0x66756c6c)
#define PARTS_MAX 64 /* of a step that cannot be solved at once */

thrum_full_def thrum_default_full_def(void) {
  return (thrum_full_def){.cookie = DEF_COOKIE,
                          .scheme = THRUM_FULL_ENERGY,
                          .dt = 0.003,
                          .newmark_beta = 0.25,
                          .newmark_gamma = 0.5,
                          .tolerance = 1e-10,
                          .iterations_max = 50,
                          .solver = THRUM_FULL_CHOLESKY,
                          .plastic = {INFINITY, INFINITY, INFINITY},
                          .solver_tolerance = 1e-10};
}

static bool is_positive(double value) {
  return isfinite(value) && value > 0;
}

static bool is_not_negative(double value) {
  return isfinite(value) && value >= 0;
}

static thrum_status check_def(const thrum_full_def *def, thrum_error *error) {
  const char *wrong = NULL;
  if (!def || def->cookie != DEF_COOKIE)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_default_full_def");

  // the first value that is out of range is named
  if (!is_positive(def->dt))
    wrong = "dt must be above 0 s";
  else if (!is_not_negative(def->damping_alpha) || !is_not_negative(def->damping_beta))
    wrong = "damping must not be negative";
  else if (def->scheme == THRUM_FULL_NEWMARK && !is_positive(def->newmark_beta))
    wrong = "Newmark's beta must be above 0; central differences are its explicit form";
  else if (!(def->newmark_gamma >= 0 && def->newmark_gamma <= 1))
    wrong = "Newmark's gamma must be in [0, 1]";
  else if (!is_positive(def->tolerance) || !is_positive(def->solver_tolerance) ||
           def->tolerance > 0.01 || def->solver_tolerance > 0.01)
    wrong = "tolerances must be in (0, 0.01]";
  else if (def->iterations_max < 1)
    wrong = "iterations_max must be 1 or more";
  else if (def->scheme == THRUM_FULL_CENTRAL && def->damping_beta > 0)
    wrong = "central differences take no damping of the stiffness";
  else if (def->law < THRUM_LAW_STVK || def->law > THRUM_LAW_BY_REGION)
    wrong = "there is no such law of the material";
  else if (!(def->plastic.yield > 0) || !(def->plastic.creep > 0) || !(def->plastic.largest > 0))
    wrong = "yield, creep and largest plastic strain must be above 0";

  return wrong ? thrum_error_set(error, THRUM_INVALID_ARGUMENT, "full order: %s", wrong) : THRUM_OK;
}

/* The vectors and fields of the lists in the header. */
static thrum_status allocate(thrum_full *full) {
  const int64_t n = full->body.fem.free_count, all = 3 * full->body.fem.vertex_count;
#define X(name) full->name = thrum_scope_allocate(&full->memory, n, sizeof(double));
  FULL_VECTORS(X)
#undef X
#define X(name) full->name = thrum_scope_allocate(&full->memory, all, sizeof(double));
  FULL_FIELDS(X)
#undef X
  if (full->body.acting)
    full->acted = thrum_scope_allocate(&full->memory, 2 * all, sizeof(double));
  if (full->body.acting)
    full->levels = thrum_scope_allocate(&full->memory, full->body.acting->count, sizeof(double));
  return full->memory.status;
}

/* Values of their own on the pattern of the stiffness; where the mass lies in it. */
static thrum_status share_pattern(thrum_full *full) {
  const thrum_sparse *stiffness = &full->body.stiffness, *mass = &full->body.mass;
  const int64_t entries = stiffness->begin[stiffness->size];

  // tangent and system borrow the pattern and own their values
  full->tangent = full->system = *stiffness;
  full->tangent.value = thrum_scope_allocate(&full->memory, entries, sizeof(double));
  full->system.value = thrum_scope_allocate(&full->memory, entries, sizeof(double));
  full->mass_slot = thrum_scope_allocate(&full->memory, mass->begin[mass->size], sizeof(int64_t));
  THRUM_TRY(full->memory.status);

  memcpy(full->tangent.value, stiffness->value, (size_t)entries * sizeof(double));
  memcpy(full->system.value, stiffness->value, (size_t)entries * sizeof(double));

  // rows ascend in both, so one walk finds the place of every entry of the mass
  for (int64_t j = 0; j < mass->size; j++) {
    int64_t at = stiffness->begin[j];
    for (int64_t e = mass->begin[j]; e < mass->begin[j + 1]; e++) {
      while (stiffness->row[at] != mass->row[e])
        at++;
      full->mass_slot[e] = at;
    }
  }
  return THRUM_OK;
}

/* The model's body with more of it held. */
static thrum_status hold(thrum_full *full, const uint8_t *held, thrum_error *error) {
  const int64_t vertices = full->model->vertex_count;
  full->fixed = thrum_scope_allocate(&full->memory, vertices, 1);
  THRUM_TRY(full->memory.status);
  for (int64_t v = 0; v < vertices; v++)
    full->fixed[v] = (uint8_t)(full->model->fixed[v] | (held ? held[v] : 0));
  thrum_model seen = *full->model;
  seen.fixed = full->fixed;
  THRUM_TRY(thrum_model_fem_create(&seen, &full->body, error));
  full->body.fem.law = full->def.law;
  THRUM_TRY(thrum_model_fem_actuate(&seen, &full->body, error));
  if (full->def.quadrature == THRUM_FULL_EXACT)
    return THRUM_OK;

  // masses stay exact; forces and the stiffness at rest are those of four points
  THRUM_TRY(thrum_fem_create_of_order(&full->body.mesh, full->fixed, 2, &full->four, error));
  full->four.law = full->def.law;
  THRUM_TRY(thrum_fem_stiffness(&full->four, NULL, &full->body.stiffness, error));
  full->four.acting = full->body.acting;
  return THRUM_OK;
}

static thrum_status fill(thrum_full *full, const uint8_t *held, thrum_error *error) {
  const thrum_full_def *def = &full->def;
  THRUM_TRY(hold(full, held, error));
  THRUM_TRY(allocate(full));
  THRUM_TRY(share_pattern(full));
  THRUM_TRY(full_plastic_make(full));
  THRUM_TRY(full_linear_make(def->solver, def->shared, def->solver_tolerance, &full->system,
                             &full->linear, error));

  // Newmark solves with the mass alone for its first acceleration
  if (def->scheme == THRUM_FULL_NEWMARK) {
    THRUM_TRY(full_linear_make(def->solver, def->shared, def->solver_tolerance, &full->body.mass,
                               &full->mass, error));
    THRUM_TRY(full_linear_prepare(&full->mass, error));
  }

  if (def->scheme == THRUM_FULL_CENTRAL)
    THRUM_TRY(full_central_begin(full, error));

  return THRUM_OK;
}

thrum_status thrum_full_create(const thrum_model *model, const uint8_t *held,
                               const thrum_full_def *def, thrum_full **full, thrum_error *error) {
  THRUM_TRY(check_def(def, error));
  if (!model->vertices)
    return thrum_error_set(error, THRUM_MISSING, "full order: the model has no mesh to go back to");
  if (model->solid_count > 0 && (def->law != THRUM_LAW_STVK || !isinf(def->plastic.yield) ||
                                 def->quadrature != THRUM_FULL_EXACT))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "full order: laws other than Saint Venant-Kirchhoff's, plastic flow and "
                           "four points are those of tetrahedra: make the model with --element tet "
                           "(precompute, or a run of a mesh)");
  if (def->law == THRUM_LAW_BY_REGION && !model->region_law)
    return thrum_error_set(error, THRUM_MISSING,
                           "full order: the regions of this model have no laws of their own");

  // the body is at rest and unloaded
  thrum_full *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "the full-order body", error));
  made->memory = thrum_scope_begin("the full-order body", error);
  made->def = *def;
  made->model = model;
  made->fresh = true;
  made->dt_stable = NAN;

  // a body that failed half way is freed
  thrum_status status = fill(made, held, error);
  if (status >= 0)
    *full = made;
  else
    thrum_full_free(made);
  return status;
}

void thrum_full_free(thrum_full *full) {
  if (!full)
    return;
  full_linear_free(&full->linear);
  full_linear_free(&full->mass);
  thrum_model_fem_free(&full->body);
  thrum_fem_free(&full->four);
  thrum_scope_free(&full->memory);
  free(full);
}

/* --- state ------------------------------------------------------------------------------------ */

thrum_status thrum_full_set(thrum_full *full, const double *u, const double *v,
                            thrum_error *error) {
  const thrum_fem *fem = &full->body.fem;
  const int64_t all = 3 * fem->vertex_count;
  if ((u && !thrum_all_finite(u, all)) || (v && !thrum_all_finite(v, all)))
    return thrum_error_set(error, THRUM_BAD_VALUE, "u or v holds a number that is not finite");
  for (int64_t i = 0; i < fem->free_count; i++) {
    full->u[i] = u ? u[fem->component[i]] : 0;
    full->v[i] = v ? v[fem->component[i]] : 0;
  }
  memset(full->held, 0, (size_t)all * sizeof *full->held);
  full->linear.ready = false;
  full->fresh = true;
  return THRUM_OK;
}

thrum_status thrum_full_displace(thrum_full *full, const double *u, thrum_error *error) {
  const thrum_fem *fem = &full->body.fem;
  THRUM_TRY(thrum_full_set(full, u, NULL, error));
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    full->held[c] = fem->dof[c] < 0 ? u[c] : 0;
  return THRUM_OK;
}

void thrum_full_get(const thrum_full *full, double *u, double *v) {
  if (u)
    full_place(full, full->u, 0, NULL, u);
  if (v)
    thrum_fem_scatter(&full->body.fem, full->v, v);
}

thrum_status thrum_full_set_force(thrum_full *full, const double *forces, thrum_error *error) {
  const thrum_fem *fem = &full->body.fem;
  if (forces && !thrum_all_finite(forces, 3 * fem->vertex_count))
    return thrum_error_set(error, THRUM_BAD_VALUE, "forces hold a number that is not finite");
  for (int64_t i = 0; i < fem->free_count; i++) {
    const double force = forces ? forces[fem->component[i]] : 0;
    full->fresh = full->fresh || force != full->f[i];
    full->f[i] = force;
  }
  return THRUM_OK;
}

thrum_status thrum_full_set_actuation(thrum_full *full, const double *levels, thrum_error *error) {
  struct thrum_fem_acting *acting = full->body.acting;
  if (!acting)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the model has no actuators: make it with thrum precompute --actuator");
  if (levels && !thrum_all_finite(levels, acting->count))
    return thrum_error_set(error, THRUM_BAD_VALUE, "a level is not finite");
  for (int64_t k = 0; k < acting->count; k++) {
    const double level = levels ? levels[k] : 0;
    full->fresh = full->fresh || level != acting->levels[k];
    acting->levels[k] = full->levels[k] = level;
  }
  return THRUM_OK;
}

double thrum_full_acting_energy(thrum_full *full) {
  full_place(full, full->u, 0, NULL, full->place);
  return thrum_fem_acting_energy(full_elastic(full), full->place, NULL);
}

/* One step of the present dt; the body is untouched unless it is done. */
static thrum_status step_once(thrum_full *full, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  const thrum_status status = full->def.scheme == THRUM_FULL_CENTRAL
                                  ? full_step_central(full, error)
                                  : full_step_implicit(full, error);
  if (status < 0)
    return status;

  // a candidate that is not finite is refused before it is taken over
  double sum = 0;

  for (int64_t i = 0; i < n; i++)
    sum += fabs(full->u[i] + full->d[i]) + fabs(full->v_next[i]) + fabs(full->a_next[i]);
  if (!isfinite(sum))
    return thrum_error_set(error, THRUM_NOT_FINITE,
                           "step %lld at t = %g s leaves the range of finite numbers: lower dt or "
                           "the load",
                           (long long)full->steps, (double)full->steps * full->def.dt);

  for (int64_t i = 0; i < n; i++)
    full->u[i] += full->d[i];
  memcpy(full->v, full->v_next, (size_t)n * sizeof *full->v);

  memcpy(full->a, full->a_next, (size_t)n * sizeof *full->a);
  full->fresh = false;
  full_plastic_flow(full, full->def.dt);
  return THRUM_OK;
}

/* The step again as `parts` shorter ones, which keep what the scheme keeps. */
static thrum_status step_in_parts(thrum_full *full, int parts, const double *start,
                                  thrum_error *error) {
  const size_t vector = (size_t)full->body.fem.free_count * sizeof(double);
  const double dt = full->def.dt;
  const bool fresh = full->fresh;
  thrum_status status = THRUM_OK;
  full_plastic_keep(full);

  // factors of the system belong to the time step, so they go with it
  full->def.dt = dt / parts;
  full->linear.ready = false;
  for (int k = 0; k < parts && status >= 0; k++)
    status = step_once(full, error);

  full->def.dt = dt;
  full->linear.ready = false;

  // on failure the body is as it was
  if (status < 0) {
    memcpy(full->u, start, vector);
    memcpy(full->v, start + full->body.fem.free_count, vector);
    memcpy(full->a, start + 2 * full->body.fem.free_count, vector);
    full->fresh = fresh;
    full_plastic_return(full);
  }

  return status;
}

thrum_status thrum_full_step(thrum_full *full, thrum_error *error) {
  const int64_t n = full->body.fem.free_count;
  thrum_status status = step_once(full, error);

  // a step that does not converge is tried again in 2, 4, ... shorter ones
  if (status == THRUM_NOT_CONVERGED) {
    double *start = NULL;
    THRUM_TRY(thrum_reserve(&start, 3 * n, sizeof *start, "shorter steps", error));
    memcpy(start, full->u, (size_t)n * sizeof *start);
    memcpy(start + n, full->v, (size_t)n * sizeof *start);
    memcpy(start + 2 * n, full->a, (size_t)n * sizeof *start);

    for (int parts = 2; parts <= PARTS_MAX && status == THRUM_NOT_CONVERGED; parts *= 2)
      status = step_in_parts(full, parts, start, error);
    free(start);
    full->substep_steps += status >= 0;
  }

  // the text of what failed on the way is no error of a step that is done
  if (status >= 0 && error)
    *error = (thrum_error){0};

  full->steps += status >= 0;
  return status;
}

thrum_full_energies thrum_full_energy(const thrum_full *full) {
  thrum_full_energies found = {0, 0, 0};
  full_place(full, full->u, 0, NULL, full->place);
  found.potential = thrum_fem_energy(full_elastic(full), full->place, NULL) -
                    thrum_fem_acting_energy(full_elastic(full), full->place, NULL);
  if (full->def.scheme == THRUM_FULL_CENTRAL) {
    for (int64_t i = 0; i < full->body.fem.free_count; i++)
      found.kinetic += 0.5 * full->lumped[i] * full->v[i] * full->v[i];
  } else {
    thrum_sparse_product(&full->body.mass, full->v, 1, full->product);
    found.kinetic = 0.5 * full_dot(full, full->v, full->product);
  }
  found.total = found.kinetic + found.potential;
  return found;
}

/* The least principal stretch at a point; negative where it is turned inside out, as far as NaN. */
static double stretch_of(const thrum_tet *tet) {
  double gradient[3][3], green[3][3], grown[3], axes[3][3], cofactor[3];
  memcpy(gradient, tet->displacement, sizeof gradient);
  thrum_green_strain(gradient, green);
  thrum_principal_stretches(green, grown, axes);
  thrum_cross3(tet->deformation[0], tet->deformation[1], cofactor);
  const double least = 1 + fmin(fmin(grown[0], grown[1]), grown[2]);
  return thrum_dot3(cofactor, tet->deformation[2]) > 0 ? least : -least;
}

double thrum_full_least_stretch(const thrum_full *full, bool gives_way) {
  const thrum_fem *fem = &full->body.fem;
  double least = INFINITY;
  full_place(full, full->u, 0, NULL, full->place);
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int p = 0; p < fem->point_count; p++) {
      thrum_tet tet;
      thrum_fem_tet_at(fem, t, p, full->place, &tet);
      if (!gives_way || tet.law == THRUM_LAW_STVK)
        least = fmin(least, stretch_of(&tet));
    }
  for (int64_t s = 0; s < fem->solids.count; s++)
    for (int p = 0; p < fem->solids.tables[fem->solids.form[s]].points; p++) {
      thrum_tet tet;
      thrum_fem_solid_at(fem, s, p, full->place, &tet);
      least = fmin(least, stretch_of(&tet));
    }
  return least;
}

void thrum_full_internal_forces(thrum_full *full, double *forces, double *loads) {
  thrum_fem alone = *full_elastic(full);
  alone.acting = NULL;
  full_place(full, full->u, 0, NULL, full->place);
  thrum_fem_energy(&alone, full->place, forces);
  if (loads)
    thrum_fem_acting_loads(full_elastic(full), full->place, loads);
}

thrum_fem_inversion thrum_full_inverted(thrum_full *full) {
  full_place(full, full->u, 0, NULL, full->place);
  return thrum_fem_inverted(&full->body.fem, full->place);
}

thrum_full_report thrum_full_report_get(const thrum_full *full) {
  return (thrum_full_report){.free_count = full->body.fem.free_count,
                             .steps = full->steps,
                             .substep_steps = full->substep_steps,
                             .iterations = full->iterations,
                             .factorisations =
                                 full->linear.factorisations + full->mass.factorisations,
                             .solver_iterations = full->linear.iterations + full->mass.iterations,
                             .dt_stable = full->dt_stable,
                             .plastic_work = full->plastic_work};
}

void thrum_full_peak(const thrum_full *full, double *length, int64_t *vertex) {
  full_place(full, full->u, 0, NULL, full->place);
  for (int64_t v = 0; v < full->body.fem.vertex_count; v++) {
    const double *u = full->place + 3 * v;
    const double moved = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    if (moved > *length) {
      *length = moved;
      *vertex = v;
    }
  }
}

void thrum_full_mean(const thrum_full *full, const int32_t *vertices, int64_t count,
                     double mean[3]) {
  full_place(full, full->u, 0, NULL, full->place);
  mean[0] = mean[1] = mean[2] = 0;
  if (!vertices)
    count = full->body.fem.vertex_count;
  for (int64_t k = 0; k < count; k++)
    for (int axis = 0; axis < 3; axis++)
      mean[axis] += full->place[3 * (vertices ? vertices[k] : k) + axis] / (double)count;
}

void thrum_full_momentum(const thrum_full *full, double linear[3], double angular[3]) {
  const thrum_fem *fem = &full->body.fem;

  // M v, with the mass that the scheme uses
  if (full->def.scheme == THRUM_FULL_CENTRAL)
    for (int64_t i = 0; i < fem->free_count; i++)
      full->product[i] = full->lumped[i] * full->v[i];
  else
    thrum_sparse_product(&full->body.mass, full->v, 1, full->product);

  // both fields on all components, held ones included
  thrum_fem_scatter(fem, full->product, full->forces);
  full_place(full, full->u, 0, NULL, full->place);

  for (int axis = 0; axis < 3; axis++)
    linear[axis] = angular[axis] = 0;

  for (int64_t v = 0; v < fem->vertex_count; v++) {
    const double *p = full->forces + 3 * v;
    double x[3];
    for (int axis = 0; axis < 3; axis++) {
      x[axis] = fem->vertices[3 * v + axis] + full->place[3 * v + axis];
      linear[axis] += p[axis];
    }
    for (int axis = 0; axis < 3; axis++)
      angular[axis] +=
          x[(axis + 1) % 3] * p[(axis + 2) % 3] - x[(axis + 2) % 3] * p[(axis + 1) % 3];
  }
}

void thrum_full_add_gravity(const thrum_full *full, const double acceleration[3], double *forces) {
  const thrum_fem *fem = &full->body.fem;
  // row sums of the mass that the scheme uses, by the place that forces are taken in
  const bool lumped = full->def.scheme == THRUM_FULL_CENTRAL;
  thrum_fem_vertex_mass(fem, lumped ? THRUM_MASS_LUMPED : full->body.kind, full->place);
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    forces[c] += full->place[c / 3] * acceleration[c % 3];
}

void thrum_full_project(const thrum_full *full, const double *field, double *reduced) {
  const thrum_fem *fem = &full->body.fem;
  const int64_t rank = full->model->rank;
  memset(reduced, 0, (size_t)rank * sizeof *reduced);
  thrum_fem_gather(fem, field, full->trial);
  thrum_sparse_product(&full->body.mass, full->trial, 1, full->product);
  for (int64_t i = 0; i < fem->free_count; i++)
    for (int64_t k = 0; k < rank; k++)
      reduced[k] += full->model->basis[fem->component[i] * rank + k] * full->product[i];
}
