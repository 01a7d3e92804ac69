/* The offline pipeline, design 1-3: mesh -> K, M -> factor -> modes -> modal derivatives -> U ->
 * polynomial -> model. Each stage frees what the next ones do not need; nothing as large as
 * tets x columns is ever held. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/precompute.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/threads.h"
#include "precompute/basis/actuator_shapes.h"
#include "precompute/basis/basis.h"
#include "precompute/basis/cubic_error.h"
#include "precompute/basis/eigen.h"
#include "precompute/basis/handles.h"
#include "precompute/basis/imported_basis.h"
#include "precompute/basis/modal_derivatives.h"
#include "precompute/basis/mode_check.h"
#include "precompute/basis/order_error.h"
#include "precompute/basis/parameter_shapes.h"
#include "precompute/estimate.h"
#include "precompute/fem/about_state.h"
#include "precompute/fem/rigid_modes.h"
#include "precompute/model/model_fill.h"
#include "precompute/model/single_precision.h"
#include "precompute/options_check.h"
#include "precompute/polynomial/actuator_reduce.h"
#include "precompute/polynomial/cubature_motion.h"
#include "precompute/polynomial/polynomial_reduce.h"
#include "precompute/polynomial/region_shares.h"

#define ORDER_ERRORS_TETS 50000
#define CUBIC_ERRORS_TETS 20000
#define INCOMPRESSIBLE 1e10 /* lambda over mu beyond which mu is lost in rounding */

typedef struct pipeline {
  const thrum_mesh *mesh;
  const uint8_t *fixed;
  const thrum_ranks *ranks; /* that share the body, of which the mesh is a part; NULL: none */
  thrum_precompute_options options;
  thrum_fem fem;
  thrum_sparse stiffness, mass;
  thrum_factor *factor;
  double *rigid, *rigid_dual; /* Z and M Z of a free body, free_count x 6; else NULL */
  double *candidates;         /* free_count x (k + k (k + 1) / 2): modes, then derivatives */
  double *change;             /* S of an imported basis, rank x rank */
  double *shapes;             /* of parameters, shape_count fields of 3 vertex_count */
  int64_t shape_count;
  double *compliance; /* of the actuators' forces at rest, and behind them the lengths of their
                         answers, 2 actuator_count */
  thrum_precomputed result;
} pipeline;

static void pipeline_free(pipeline *p) {
  thrum_fem_free(&p->fem);
  thrum_sparse_free(&p->stiffness);
  thrum_sparse_free(&p->mass);
  thrum_factor_free(p->factor);
  p->factor = NULL;
  free(p->candidates);
  p->candidates = NULL;
  free(p->rigid);
  free(p->change);
  free(p->shapes);
  free(p->compliance);
  p->compliance = NULL;
  p->change = p->rigid = p->shapes = NULL;
}

// Z and M Z of a free body
static thrum_status find_rigid(pipeline *p, thrum_error *error) {
  const int64_t count = THRUM_RIGID_COUNT * p->fem.free_count;
  THRUM_TRY(thrum_reserve(&p->rigid, 2 * count, sizeof(double), "the rigid modes", error));
  p->rigid_dual = p->rigid + count;
  THRUM_TRY(thrum_rigid_modes(&p->fem, &p->mass, p->rigid, p->rigid_dual, error));
  return thrum_rigid_residual(&p->stiffness, p->rigid, &p->result.rigid_residual, error);
}

// before the large arrays are taken
static thrum_status check_memory(const pipeline *p, thrum_error *error) {
  if (p->ranks)
    return THRUM_OK;
  thrum_estimate estimate;
  thrum_estimate_memory(&p->fem, &p->stiffness, p->factor, &p->options, &estimate);
  return estimate.fits ? THRUM_OK : thrum_estimate_refuse(&estimate, error);
}

// volume and mass of the whole body
static void weigh_body(pipeline *p) {
  double sums[2];
  thrum_fem_weigh(&p->fem, &sums[0], &sums[1]);
  thrum_ranks_sum(p->ranks, sums, 2);
  p->result.volume = sums[0];
  p->result.mass = sums[1];
}

static thrum_status run_assemble(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  bool free_body = false;
  THRUM_TRY(
      thrum_fem_create_of_order(p->mesh, p->fixed, p->options.quadrature_order, &p->fem, error));
  THRUM_TRY(thrum_fem_take_state(p->mesh, &p->fem, error));
  p->fem.ranks = p->ranks;
  p->fem.law = p->options.law;
  if (p->ranks)
    THRUM_TRY(p->ranks->take(p->ranks->context, &p->fem, error));

  // whether a body that is shared is held was judged before it was cut
  if (p->ranks)
    free_body = p->ranks->free_body;
  else
    THRUM_TRY(thrum_options_check_body(&p->options, &p->fem, &free_body, error));

  p->result.free_dofs = thrum_ranks_size(p->ranks, p->fem.free_count);
  if (p->fem.rule)
    p->result.quadrature_order =
        p->options.quadrature_order > 0 ? p->options.quadrature_order : p->fem.usual_order;
  p->result.rigid_count = free_body ? THRUM_RIGID_COUNT : 0;
  weigh_body(p);

  THRUM_TRY(thrum_fem_pattern(&p->fem, &p->stiffness, error));
  THRUM_TRY(thrum_fem_mass(&p->fem, p->options.mass, &p->stiffness, &p->mass, error));
  THRUM_TRY(thrum_report(reporter, 0.5, error));

  // an imported basis needs no factor, whose plan tells the size otherwise
  if (p->options.imported)
    THRUM_TRY(check_memory(p, error));

  THRUM_TRY(thrum_fem_stiffness(&p->fem, NULL, &p->stiffness, error));
  return free_body ? find_rigid(p, error) : THRUM_OK;
}

// a resistance to change of volume that hides the one to change of shape in rounding
static bool say_incompressible(const pipeline *p, thrum_error *error) {
  for (int64_t i = 0; i < p->fem.region_count; i++) {
    const double ratio = p->fem.lambda[i] / p->fem.mu[i];
    if (!(ratio > INCOMPRESSIBLE))
      continue;
    thrum_error_set(
        error, THRUM_SINGULAR,
        "Poisson's ratio of region %lld is %.17g, so near 1/2 that the material resists "
        "a change of volume %.1g times as much as one of shape, which is lost in "
        "rounding: take 0.499 or less",
        (long long)i + 1, p->mesh->materials[i].poisson, ratio);
    return true;
  }
  return false;
}

// what lets a body move without strain, or nearly so
static thrum_status say_singular(const pipeline *p, thrum_error *error) {
  if (say_incompressible(p, error))
    return THRUM_SINGULAR;
  if (p->mesh->about)
    return thrum_error_set(error, THRUM_SINGULAR,
                           "the stiffness about the state is not positive: the body has buckled "
                           "there; ask for less of the state");
  return thrum_error_set(error, THRUM_SINGULAR,
                         "the stiffness is singular: a part hangs on by a vertex or an edge and "
                         "can still move, or the body is so thin that it has no stiffness across; "
                         "%smend the mesh (see thrum check)",
                         p->rigid ? "" : "fix more with --fix, or ");
}

// the solver of several processes in place of a factor
static thrum_status share_factor(pipeline *p, thrum_error *error) {
  const thrum_ranks *ranks = p->ranks;
  const thrum_status status = ranks->prepare(ranks->context, &p->stiffness, &p->mass, error);
  if (status == THRUM_SINGULAR)
    return say_singular(p, error);
  THRUM_TRY(status);
  return thrum_factor_share(ranks, p->fem.free_count, &p->factor, error);
}

static thrum_status factorise(pipeline *p, thrum_error *error) {
  thrum_support_springs springs;

  // a free body's stiffness is singular until six springs hold it
  if (p->rigid)
    thrum_support_springs_add(&p->fem, &p->stiffness, &springs);

  // memory is checked as soon as the plan tells the factor's size
  thrum_status status = thrum_factor_plan(&p->stiffness, &p->factor, error);
  if (status >= 0 && thrum_factor_nonzeros(p->factor) >= THRUM_SINGLE_NONZEROS)
    thrum_factor_set_single(p->factor, &p->stiffness);
  THRUM_THEN(status, check_memory(p, error));
  THRUM_THEN(status, thrum_factor_compute(&p->stiffness, p->factor, error));

  // what is singular in single precision may be none in double
  if (status == THRUM_SINGULAR && thrum_factor_is_single(p->factor)) {
    thrum_factor_set_single(p->factor, NULL);
    status = check_memory(p, error);
    THRUM_THEN(status, thrum_factor_compute(&p->stiffness, p->factor, error));
  }

  if (p->rigid)
    thrum_support_springs_remove(&springs, &p->stiffness);

  return status == THRUM_SINGULAR ? say_singular(p, error) : status;
}

static thrum_status run_factor(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  (void)reporter;
  THRUM_TRY(p->ranks ? share_factor(p, error) : factorise(p, error));
  p->result.factor_nonzeros = thrum_factor_nonzeros(p->factor);
  p->result.flops[THRUM_STAGE_factor] = thrum_factor_flops(p->factor);
  if (p->ranks)
    p->result.solver = p->ranks->solver_use(p->ranks->context);

  // solves keep to the complement of the rigid modes
  if (p->rigid)
    thrum_factor_deflate(p->factor, THRUM_RIGID_COUNT, p->rigid, p->rigid_dual);
  return THRUM_OK;
}

// a mechanism passes the factor by rounding; its strain energy then is nothing to speak of
static thrum_status check_mechanism(const pipeline *p, thrum_error *error) {
  double stiffest = 0;
  for (int64_t i = 0; i < p->fem.free_count; i++)
    stiffest =
        fmax(stiffest, p->stiffness.value[p->stiffness.begin[i]] / p->mass.value[p->mass.begin[i]]);
  thrum_ranks_largest(p->ranks, &stiffest, 1);
  if (p->result.mode_omega2[0] > 1e-16 * stiffest)
    return THRUM_OK;
  if (say_incompressible(p, error))
    return THRUM_SINGULAR;
  return thrum_error_set(error, THRUM_SINGULAR,
                         "the body can move without strain, or is so thin that it hardly resists "
                         "(a mode of %g Hz): %smend the mesh (see thrum check)",
                         sqrt(fmax(p->result.mode_omega2[0], 0)) / THRUM_TWO_PI,
                         p->rigid ? "" : "fix more with --fix, or ");
}

// counts the modes below a shift in the gap before `next`
static thrum_status count_modes(pipeline *p, double next, thrum_error *error) {
  thrum_precomputed *result = &p->result;
  int64_t below;
  result->shift = thrum_mode_shift(p->options.modes, result->mode_omega2, next, &below);
  const thrum_status status = p->ranks ? p->ranks->count_below(p->ranks->context, result->shift,
                                                               &result->shift_count, error)
                                       : thrum_inertia_count(&p->stiffness, &p->mass, result->shift,
                                                             &result->shift_count, error);
  result->mode_counted = status >= 0;
  result->modes_complete = result->shift_count == below + result->rigid_count;
  return status;
}

// whether modes are counted, too
static bool is_counted(const pipeline *p) {
  return p->ranks ? p->ranks->counts(p->ranks->context)
                  : thrum_options_counted(&p->options, p->fem.free_count);
}

// that no mode was missed: by search, and by count where asked for
static thrum_status check_modes(pipeline *p, thrum_error *error) {
  const int64_t k = p->options.modes;
  thrum_precomputed *result = &p->result;
  thrum_status status =
      thrum_mode_search(&p->stiffness, &p->mass, p->factor, k, result->mode_omega2, p->candidates,
                        &result->modes_recovered, &result->next_omega2, error);

  // modes that were found late, or by several processes, are brought into the same form as the
  // others
  if (status >= 0 && (p->ranks || result->modes_recovered > 0))
    thrum_eigen_canonicalise_fem(&p->fem, false, k, result->mode_omega2,
                                 1e-10 * result->mode_omega2[k - 1], p->candidates, 1,
                                 p->fem.free_count);

  result->modes_complete = true;
  if (status < 0 || !is_counted(p))
    return status;

  status = count_modes(p, result->next_omega2, error);
  // one too many may still be the next of a cluster that begins among the modes
  if (status >= 0 && !result->modes_complete)
    status = count_modes(p, result->mode_omega2[k - 1], error);
  return status;
}

// the modes on all components, for the caller that asked
static thrum_status keep_modes(pipeline *p, thrum_error *error) {
  const int64_t rows = 3 * p->fem.vertex_count, k = p->options.modes;
  THRUM_TRY(thrum_reserve(&p->result.mode_vectors, k * rows, sizeof(double), "the modes", error));
  for (int64_t i = 0; i < k; i++)
    thrum_fem_scatter(&p->fem, p->candidates + i * p->fem.free_count,
                      p->result.mode_vectors + i * rows);
  return THRUM_OK;
}

static thrum_status run_modes(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  const int64_t k = p->options.modes, n = p->fem.free_count;
  thrum_precomputed *result = &p->result;
  result->mode_count = k;
  const int64_t shapes = thrum_options_shapes(&p->options);

  // the derivatives will stand behind the modes, so room for both is taken at once
  THRUM_TRY(thrum_reserve(&p->candidates, (shapes + shapes * (shapes + 1) / 2) * n, sizeof(double),
                          "the modes and derivatives", error));
  THRUM_TRY(thrum_reserve(&result->mode_omega2, shapes, sizeof(double), "the modes", error));
  THRUM_TRY(thrum_reserve(&result->mode_residual, k, sizeof(double), "the modes", error));

  thrum_status status = thrum_eigen_lowest(&p->stiffness, &p->mass, p->factor, k,
                                           result->mode_omega2, p->candidates, reporter, error);

  // no mode may be missing, none may be a mechanism
  THRUM_THEN(status, check_modes(p, error));
  THRUM_THEN(status, thrum_eigen_residuals(&p->stiffness, &p->mass, k, result->mode_omega2,
                                           p->candidates, result->mode_residual, error));
  THRUM_THEN(status, check_mechanism(p, error));
  if (status >= 0 && !p->fem.rule && !p->ranks && !p->options.order_known &&
      p->fem.solids.count == 0) {
    // a large mesh gets the first two, as each takes some hundredths of the time of all stages
    const int64_t most = p->fem.tet_count > ORDER_ERRORS_TETS ? 2 : THRUM_ORDER_ERRORS_MAX;
    result->order_error_count = k < most ? k : most;
    const thrum_order_body body = {p->mesh, &p->fem, p->factor, p->rigid, p->rigid_dual};
    status = thrum_order_errors(&body, result->order_error_count, p->candidates,
                                result->order_error, error);
  }
  if (status >= 0 && p->fem.rule && !p->ranks && p->fem.tet_count <= CUBIC_ERRORS_TETS) {
    result->cubic_error_count = k < THRUM_CUBIC_ERRORS_MAX ? k : THRUM_CUBIC_ERRORS_MAX;
    const thrum_order_body body = {p->mesh, &p->fem, p->factor, p->rigid, p->rigid_dual};
    status = thrum_cubic_errors(&body, result->cubic_error_count, p->candidates,
                                result->cubic_error, error);
  }
  if (status >= 0 && p->options.keep_modes)
    status = keep_modes(p, error);

  // the stiffness has served: later stages need its factor alone, if that is in double precision
  p->result.flops[THRUM_STAGE_modes] = thrum_factor_solve_flops(p->factor);
  if (!thrum_factor_is_single(p->factor))
    thrum_sparse_free(&p->stiffness);
  return status;
}

/* Modes and their derivatives first, then responses and all derivatives that have one of them. */
static thrum_status part_candidates(pipeline *p, thrum_error *error) {
  const int64_t k = p->options.modes, n = p->fem.free_count,
                shapes = thrum_options_shapes(&p->options);
  const int64_t usual = k + k * (k + 1) / 2, all = shapes + shapes * (shapes + 1) / 2;
  const size_t column = sizeof(double) * (size_t)n;
  double *others = NULL;
  THRUM_TRY(thrum_reserve(&others, (all - usual) * n, sizeof *others, "the responses", error));

  // the responses stand between the modes and the derivatives
  memcpy(others, p->candidates + k * n, column * (size_t)(shapes - k));
  const double *from = p->candidates + shapes * n;
  double *to = p->candidates + k * n, *other = others + (shapes - k) * n;
  for (int64_t i = 0; i < shapes; i++)
    for (int64_t j = i; j < shapes; j++, from += n) {
      double **at = j < k ? &to : &other;
      memmove(*at, from, column);
      *at += n;
    }
  memcpy(p->candidates + usual * n, others, column * (size_t)(all - usual));
  free(others);
  return THRUM_OK;
}

/* What the modes gain where regions change, beside the rank. */
static thrum_status find_parameter_shapes(pipeline *p, thrum_error *error) {
  const int64_t k = p->options.modes, count = thrum_options_added(&p->options, &p->fem);
  if (count < 1)
    return THRUM_OK;
  THRUM_TRY(thrum_reserve(&p->shapes, count * 3 * p->fem.vertex_count, sizeof *p->shapes,
                          "the shapes of the parameters", error));
  THRUM_TRY(thrum_parameter_shapes(&p->fem, p->options.mass, p->factor, k, p->candidates,
                                   p->result.mode_omega2, count, p->shapes, &p->shape_count,
                                   error));
  p->options.rank += p->shape_count;
  return THRUM_OK;
}

static thrum_status run_derivatives(pipeline *p, const thrum_reporter *reporter,
                                    thrum_error *error) {
  const int64_t k = p->options.modes, n = p->fem.free_count,
                shapes = thrum_options_shapes(&p->options);
  const int64_t actuators = p->options.actuator_count, acting = shapes - actuators;
  thrum_status status = thrum_handle_responses(
      &p->fem, &p->mass, p->factor, p->options.handle_count, p->options.handles,
      p->candidates + k * n, p->result.mode_omega2 + k, error);
  THRUM_THEN(status, thrum_reserve(&p->compliance, 2 * actuators, sizeof *p->compliance,
                                   "the actuators", error));
  THRUM_THEN(status,
             thrum_actuator_responses(&p->fem, &p->mass, p->factor, actuators, p->options.actuators,
                                      p->candidates + acting * n, p->result.mode_omega2 + acting,
                                      p->compliance + actuators, p->compliance, error));

  THRUM_THEN(status, thrum_derivatives(&p->fem, p->factor, shapes, p->candidates,
                                       p->candidates + shapes * n, reporter, error));
  THRUM_THEN(status, thrum_actuator_derivatives(&p->fem, p->factor, actuators, p->options.actuators,
                                                p->compliance + actuators, shapes, p->candidates,
                                                p->candidates + shapes * n, error));
  if (shapes > k)
    THRUM_THEN(status, part_candidates(p, error));
  THRUM_THEN(status, find_parameter_shapes(p, error));

  // how many steps the solves took is known now
  if (p->ranks)
    p->result.solver = p->ranks->solver_use(p->ranks->context);

  // the factor is the largest array of all, and it has served
  p->result.flops[THRUM_STAGE_derivatives] =
      thrum_factor_solve_flops(p->factor) - p->result.flops[THRUM_STAGE_modes];
  thrum_factor_free(p->factor);
  p->factor = NULL;
  if (p->ranks)
    p->ranks->release(p->ranks->context);
  thrum_sparse_free(&p->stiffness);
  return status;
}

static thrum_status make_basis(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  const int64_t r = p->options.rank, k = p->options.modes;
  double *basis = thrum_model_writable(p->result.model.basis);
  if (!p->options.imported) {
    const thrum_basis_def def = {
        .fem = &p->fem,
        .mass = &p->mass,
        .stiffness = &p->stiffness,
        .selection = p->options.selection,
        .rank = r,
        .modes = k,
        .candidates = p->candidates,
        .omega2 = p->result.mode_omega2,
        .shares = p->options.shares,
        .response_count = thrum_options_responses(&p->options),
        .responses = p->candidates + (k + k * (k + 1) / 2) * p->fem.free_count,
        .trained_count = p->shapes ? p->shape_count : p->options.trained_count,
        .trained = p->shapes ? p->shapes : p->options.trained};

    // the stiffness, which the solves had no room for, is made again
    if (def.selection == THRUM_SELECTION_MODES) {
      THRUM_TRY(thrum_fem_pattern(&p->fem, &p->stiffness, error));
      THRUM_TRY(thrum_fem_stiffness(&p->fem, NULL, &p->stiffness, error));
      THRUM_TRY(thrum_reserve(&p->result.coordinates, r, sizeof *p->result.coordinates, "the basis",
                              error));
    }
    return thrum_basis(&def, basis, &p->result.basis_orthonormality, p->result.coordinates,
                       reporter, error);
  }

  // an imported basis takes the place of modes and derivatives
  p->result.modes_complete = true;
  THRUM_TRY(thrum_reserve(&p->change, r * r, sizeof(double), "the imported basis", error));
  THRUM_TRY(thrum_imported_basis_fill(&p->fem, p->mesh, &p->mass, p->rigid_dual,
                                      p->options.imported, basis, p->change, &p->result.imported,
                                      error));
  p->result.basis_orthonormality = p->result.imported.orthonormality_after;
  return THRUM_OK;
}

static thrum_status run_basis(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  thrum_status status = thrum_model_fill_mesh(p->mesh, p->fixed, p->options.rank,
                                              p->options.cubature, &p->result.model, error);
  THRUM_THEN(status, make_basis(p, reporter, error));
  THRUM_THEN(status, thrum_model_fill_axis_mass(&p->fem, p->options.mass, &p->result.model, error));
  if (status >= 0 && p->rigid)
    status = thrum_model_fill_rigid(&p->fem, p->rigid, &p->result.model, error);

  // matrices and candidates have served
  thrum_sparse_free(&p->stiffness);
  thrum_sparse_free(&p->mass);
  free(p->candidates);
  p->candidates = NULL;
  return status;
}

/* What the points were chosen by, which a state asks for before it flows. */
static thrum_status fill_training(pipeline *p, thrum_error *error) {
  double *training = NULL, yield = INFINITY;
  THRUM_TRY(thrum_reserve(&training, THRUM_TRAINING_NUMBERS, sizeof *training, "the model", error));
  p->result.model.point_training = training;

  // the smallest yield of a region, its own or that of the body
  for (int64_t i = 0; i < p->fem.region_count; i++)
    yield = fmin(yield, thrum_fem_yield(&p->fem, i, p->options.cubature_yield));
  training[THRUM_TRAINING_STRAIN] = p->result.cubature.strain;
  training[THRUM_TRAINING_YIELD] = isinf(yield) ? 0 : yield;
  training[THRUM_TRAINING_PLASTIC] = p->result.cubature.plastic;
  training[THRUM_TRAINING_LEARNED] = p->options.cubature_refine > 0;
  return THRUM_OK;
}

// points from the forces of the body, once its frequencies are there
static thrum_status make_points(pipeline *p, const thrum_reporter *reporter, thrum_error *error) {
  const int64_t r = p->options.rank, k = p->options.modes;
  const thrum_cubature_def def = {.error = p->options.cubature_error,
                                  .most = p->options.cubature_points,
                                  .range = p->options.cubature_range,
                                  .masters = k > 0 && k < r ? k : (r + 1) / 2,
                                  .yield = p->options.cubature_yield,
                                  .refine = p->options.cubature_refine};
  thrum_model *model = &p->result.model;
  THRUM_TRY(thrum_cubature(&p->fem, &def, model, &p->result.cubature, reporter, error));
  THRUM_TRY(thrum_model_fill_law(&p->fem, model, error));
  THRUM_TRY(fill_training(p, error));

  // as a large model is packed: that changes the force by far less than any choice of points
  thrum_single_round(thrum_model_writable(model->point_gradients),
                     9 * model->point_count * model->rank);
  return thrum_cubature_motion(&p->fem, &def, model, &p->result.cubature, error);
}

// linear, c3 and c4: the imported ones in the new coordinates, or the body's
static thrum_status make_polynomial(pipeline *p, double *linear, const thrum_reporter *reporter,
                                    thrum_error *error) {
  thrum_model *model = &p->result.model;
  if (p->options.cubature)
    return thrum_reduced_stiffness(&p->fem, model->rank, model->basis, linear, error);
  double *c3 = thrum_model_writable(model->c3), *c4 = thrum_model_writable(model->c4);
  if (p->options.imported && p->options.imported->linear)
    return thrum_imported_polynomial(&p->fem, p->options.imported, p->change, model, linear, c3, c4,
                                     &p->result.imported, error);
  // one DSYRK of six rows a point
  const double columns = thrum_options_columns(&p->options);
  p->result.flops[THRUM_STAGE_polynomial] =
      6 * (double)thrum_fem_points(&p->fem) * columns * (columns + 1);
  return thrum_polynomial_reduce(&p->fem, model->rank, thrum_options_squared(&p->options),
                                 model->basis, linear, c3, c4, reporter, error);
}

/* The shares of moduli and densities, for bodies of others. */
static thrum_status make_shares(pipeline *p, thrum_error *error) {
  thrum_model *model = &p->result.model;
  const int64_t r = model->rank, regions = model->region_count;
  double *energy = NULL, *mass = NULL;
  model->energy_size = r * r + model->c3_count + model->c4_count;
  model->mass_size = r * (r + 3);
  THRUM_TRY(
      thrum_reserve(&energy, 2 * regions * model->energy_size, sizeof *energy, "the model", error));
  model->region_energy = energy;
  THRUM_TRY(thrum_reserve(&mass, regions * model->mass_size, sizeof *mass, "the model", error));
  model->region_mass = mass;
  ((int32_t *)thrum_model_writable(model->format))[1] += THRUM_MODEL_FORMAT_MINOR_PARAMETERS;
  return thrum_region_shares(&p->fem, p->options.mass, model, energy, mass, error);
}

static thrum_status make_actuators(pipeline *p, thrum_error *error) {
  thrum_model *model = &p->result.model;
  ((int32_t *)thrum_model_writable(model->format))[1] += THRUM_MODEL_FORMAT_MINOR_ACTUATORS;
  return thrum_actuators_reduce(&p->fem, p->options.actuator_count, p->options.actuators,
                                p->compliance, model, error);
}

static thrum_status run_polynomial(pipeline *p, const thrum_reporter *reporter,
                                   thrum_error *error) {
  const int64_t r = p->options.rank;
  thrum_model *model = &p->result.model;
  double *linear = NULL;
  THRUM_TRY(thrum_reserve(&linear, r * r, sizeof *linear, "the polynomial", error));

  thrum_status status = make_polynomial(p, linear, reporter, error);

  double *omega2 = thrum_model_writable(model->omega2);
  double worst = 0;
  for (int64_t i = 0; i < r && status >= 0; i++) {
    // equal frequencies may differ by rounding either way; the model wants them ascending
    omega2[i] = i > 0 ? fmax(omega2[i - 1], linear[i * r + i]) : linear[0];
    for (int64_t j = 0; j < i; j++)
      worst = fmax(worst, fabs(linear[i * r + j]));
  }

  if (status >= 0)
    p->result.basis_diagonality = worst / omega2[r - 1];
  free(linear);

  if (status >= 0 && p->options.cubature)
    return make_points(p, reporter, error);
  if (status >= 0 && p->options.parameters)
    status = make_shares(p, error);
  if (status >= 0 && p->options.actuator_count > 0)
    status = make_actuators(p, error);
  if (status >= 0 && p->options.imported && p->options.imported->linear)
    status = thrum_imported_check(&p->fem, model, &p->result.imported, error);
  if (status >= 0 && p->options.single)
    status = thrum_single_precision_round(model, &p->result.single_error, error);
  return status;
}

static thrum_status run_all(pipeline *p, thrum_error *error) {
  thrum_status (*const stages[THRUM_STAGE_COUNT])(pipeline *, const thrum_reporter *,
                                                  thrum_error *) = {
      run_assemble, run_factor, run_modes, run_derivatives, run_basis, run_polynomial};
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    // an imported basis needs nothing solved
    if (p->options.imported && stage > THRUM_STAGE_assemble && stage < THRUM_STAGE_basis)
      continue;

    const thrum_reporter reporter = {&p->options, (thrum_stage)stage};
    const double began = clock_seconds();
    const double worked = clock_process_seconds();

    THRUM_TRY(thrum_report(&reporter, 0, error));
    THRUM_TRY(stages[stage](p, &reporter, error));
    THRUM_TRY(thrum_report(&reporter, 1, error));
    p->result.seconds[stage] = clock_seconds() - began;
    p->result.cpu_seconds[stage] = clock_process_seconds() - worked;
    p->result.peak_mb[stage] = clock_peak_mb();
  }
  return THRUM_OK;
}

/* All stages on a mesh or a part of one, with checked options; the result is whole or nothing. */
static thrum_status run_pipeline(pipeline *p, thrum_precomputed *result, thrum_error *error) {
  THRUM_TRY(thrum_threads_ready(p->options.threads, error));

  // all stages, with the number of threads that was asked for
  const thrum_threads before = thrum_threads_set(p->options.threads);
  thrum_status status = run_all(p, error);
  if (!p->ranks)
    THRUM_THEN(status, thrum_model_check(&p->result.model, error));
  if (status == THRUM_OK)
    p->result.model.identity = thrum_model_identity(&p->result.model);

  // the libraries get their threads back
  pipeline_free(p);
  thrum_threads_restore(before);
  if (status >= 0)
    *result = p->result;
  else
    thrum_precomputed_free(&p->result);
  return status;
}

thrum_status thrum_precompute(const thrum_mesh *mesh, const uint8_t *fixed,
                              const thrum_precompute_options *options, thrum_precomputed *result,
                              thrum_error *error) {
  pipeline p = {.mesh = mesh, .fixed = fixed, .options = thrum_options_complete(options)};

  // what cannot be computed is refused before anything is
  THRUM_TRY(thrum_options_check(&p.options, error));
  if (!mesh->has_material)
    return thrum_error_set(error, THRUM_MISSING,
                           "the mesh says no material: give --young, --poisson and --density");

  if (mesh->about && (p.options.cubature || p.options.parameters || p.options.imported ||
                      p.options.actuator_count > 0 || mesh->springs))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a model about a state goes without cubature points, parameters, "
                           "actuators, springs to the ground and an imported basis");
  if (mesh->elastic_count > 0 && (p.options.cubature || p.options.parameters ||
                                  p.options.law != THRUM_LAW_STVK || mesh->solid_count == 0))
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "elasticity with directions is Saint Venant-Kirchhoff's: leave out "
                           "cubature points, parameters and other laws");
  if (mesh->solid_count > 0 &&
      (p.options.cubature || p.options.parameters || p.options.law != THRUM_LAW_STVK))
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "cubature points, parameters and laws other than Saint "
        "Venant-Kirchhoff's are those of tetrahedra: give --element tet, which cuts the elements");
  if (p.options.law == THRUM_LAW_BY_REGION && !mesh->laws)
    return thrum_error_set(error, THRUM_MISSING, "the regions of the mesh have no laws");

  // a point of the material cannot stand for a spring, nor can a polynomial from elsewhere
  const bool other = options->shared != NULL || p.options.cubature || p.options.parameters ||
                     (p.options.imported && p.options.imported->linear);
  if (mesh->springs && other)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "springs to the ground go without cubature points, parameters, an "
                           "imported polynomial, and several processes");

  // several processes take over where there are any
  const thrum_precompute_shared *shared = options->shared;
  if (shared != NULL && mesh->solid_count > 0)
    return thrum_error_set(
        error, THRUM_UNSUPPORTED,
        "several processes take tetrahedra alone: give --element tet, which cuts "
        "the elements, or make the model in one process");
  if (shared != NULL)
    return shared->precompute(shared->context, mesh, fixed, &p.options, result, error);
  if (p.options.solver == THRUM_SOLVER_CG)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "conjugate gradients are those of several processes, of which this is "
                           "none: take the factor");
  return run_pipeline(&p, result, error);
}

thrum_status thrum_precompute_part(const thrum_mesh *part, const uint8_t *fixed,
                                   const thrum_precompute_options *options,
                                   const thrum_ranks *ranks, thrum_precomputed *result,
                                   thrum_error *error) {
  pipeline p = {.mesh = part, .fixed = fixed, .ranks = ranks, .options = *options};
  return run_pipeline(&p, result, error);
}

void thrum_precomputed_free(thrum_precomputed *result) {
  thrum_model_fill_free(&result->model);
  free(result->mode_omega2);
  free(result->mode_residual);
  free(result->mode_vectors);
  free(result->coordinates);
  *result = (thrum_precomputed){0};
}
