/* A run that is made again with a richer model, and compared.
 *
 * The richer model has all coordinates of the model and some more: directions in which the residual
 * of the mesh pushes it, and in which the mesh follows the loads but for blows. What it does
 * otherwise under the same loads, with the same step, is a part of what the mesh would do
 * otherwise, and in dynamics most of it: phases that drift apart, vibration that the basis does not
 * have, bending that it locks. Lengths are taken in the norm of the mass, in which both bases are
 * orthonormal. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/basis_rerun.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "driver/run/stepper.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "precompute/richer_model.h"
#include "runtime/material/material_law.h"

#define STEP_LEAST 0.5   /* that stepping again may take, however short the run was [s] */
#define STEP_SHARE 2.0   /* of the time of the run that it may take */
#define FLOPS_MOST 3e10  /* of the polynomial: about two seconds */
#define FLOPS_ASKED 1e12 /* the same where --judge on asks for it */
#define ADDED_MOST 8     /* coordinates, */
#define ADDED_LEAST 3    /* and as many at least, or it is not worth it */
#define BLOW 0.1         /* of the slowest period: a shorter load is over before it has moved */

/* Operations of a polynomial of this rank. */
static double flops_of(const thrum_fem *fem, double rank) {
  const double columns = rank + rank * (rank + 1) / 2;
  return 6 * (double)thrum_fem_points(fem) * columns * columns;
}

double basis_rerun_seconds(const basis_asked *asked, double seconds) {
  if (asked->judging == BASIS_JUDGE_ON)
    return INFINITY;
  return fmin(BASIS_SECONDS_MOST, fmax(STEP_LEAST, STEP_SHARE * seconds));
}

const char *basis_rerun_why_not(const thrum_model *model, thrum_integrator integrator) {
  if (thrum_law_of_model(model) != THRUM_LAW_STVK)
    return "the law of the material has no polynomial";
  if (integrator == THRUM_INTEGRATOR_VERLET || integrator == THRUM_INTEGRATOR_RK4)
    return "stiffer directions have no explicit step";
  return NULL;
}

int64_t basis_rerun_added(const thrum_model_statics *statics, const thrum_model *model,
                          double *flops) {
  const thrum_fem *fem = &statics->body.fem;
  int64_t added = ADDED_MOST;
  while (added >= ADDED_LEAST && (flops_of(fem, (double)(model->rank + added)) > *flops ||
                                  model->rank + added > THRUM_RANK_MAX))
    added--;
  if (added < ADDED_LEAST)
    return 0;
  *flops -= flops_of(fem, (double)(model->rank + added));
  return added;
}

/* y = C x of the richer model's change. */
static void carry(const thrum_richer_model *richer, int64_t rank, const double *x, double *y) {
  for (int64_t k = 0; k < richer->model.rank; k++) {
    y[k] = 0;
    for (int64_t i = 0; i < rank; i++)
      y[k] += richer->change[k * rank + i] * x[i];
  }
}

/* What static: starts have of the coordinates of a model. */
static thrum_status make_static(const simulate_request *request, const thrum_model *model,
                                double *q, thrum_error *error) {
  start_spec *statics = NULL;
  int64_t count = 0;
  double none[THRUM_RANK_MAX] = {0};
  THRUM_TRY(thrum_reserve(&statics, request->start_count + 1, sizeof *statics, "a start", error));
  for (int64_t n = 0; n < request->start_count; n++)
    if (request->starts[n].kind == START_STATIC)
      statics[count++] = request->starts[n];
  const thrum_status status =
      count > 0 ? start_specs_make(model, statics, count, q, none, error) : THRUM_OK;
  free(statics);
  return status;
}

thrum_status basis_rerun_start(const basis_record *record, const thrum_richer_model *richer,
                               double *q, double *p, thrum_error *error) {
  double before[THRUM_RANK_MAX], poor[THRUM_RANK_MAX] = {0}, rich[THRUM_RANK_MAX] = {0};
  THRUM_TRY(make_static(record->request, record->model, poor, error));
  THRUM_TRY(make_static(record->request, &richer->model, rich, error));

  for (int64_t i = 0; i < record->model->rank; i++)
    before[i] = record->rows[0].q[i] - poor[i];
  carry(richer, record->model->rank, before, q);
  carry(richer, record->model->rank, record->rows[0].p, p);
  for (int64_t k = 0; k < richer->model.rank; k++)
    q[k] += rich[k];
  return THRUM_OK;
}

/* Sums of squares: of differences and of the richer run. */
typedef struct sums {
  double lacking, moved, slower, fast;
} sums;

static thrum_status compare(const basis_record *record, const thrum_richer_model *richer,
                            const basis_row *row, const driver_stepper *stepper, sums *to,
                            thrum_error *error) {
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX], of_q[THRUM_RANK_MAX], of_p[THRUM_RANK_MAX];
  THRUM_TRY(stepper->kind->snapshot(stepper->self, 0, q, p, error));
  carry(richer, record->model->rank, row->q, of_q);
  carry(richer, record->model->rank, row->p, of_p);
  for (int64_t k = 0; k < richer->model.rank; k++) {
    to->lacking += (q[k] - of_q[k]) * (q[k] - of_q[k]);
    to->slower += (p[k] - of_p[k]) * (p[k] - of_p[k]);
    to->moved += q[k] * q[k];
    to->fast += p[k] * p[k];
  }
  return THRUM_OK;
}

/* Steps as far as there is time, and compares all rows on the way. */
static thrum_status step_all(basis_record *record, const thrum_richer_model *richer,
                             const driver_stepper *stepper, double seconds, thrum_error *error) {
  basis_estimate *estimate = &record->estimate;
  const double end = clock_seconds() + basis_rerun_seconds(&record->request->basis, seconds);
  sums of = {0};
  int64_t step = 0, last = 0;
  for (int64_t n = 0; n < record->count; n++) {
    for (; step < record->rows[n].step && clock_seconds() < end; step++)
      THRUM_TRY(stepper->kind->advance(stepper->self, step, error));
    if (step < record->rows[n].step)
      break;
    THRUM_TRY(compare(record, richer, &record->rows[n], stepper, &of, error));
    last = step;
  }

  if (!(of.moved > 0) || !isfinite(of.lacking) || !isfinite(of.moved))
    return THRUM_OK;
  estimate->why = NULL;
  estimate->share = sqrt(of.lacking / of.moved);
  estimate->velocity = of.fast > 0 ? sqrt(of.slower / of.fast) : NAN;
  estimate->until = (double)last * record->request->def.dt;
  estimate->added = richer->model.rank - record->model->rank;
  return THRUM_OK;
}

static thrum_status run_again(basis_record *record, const thrum_richer_model *richer,
                              double seconds, thrum_error *error) {
  simulate_request request = *record->request;
  driver_stepper stepper = {0};
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  THRUM_TRY(basis_rerun_start(record, richer, q, p, error));

  // all coordinates are stepped, from where the run began
  request.start_count = 0;
  if (request.def.integrator == THRUM_INTEGRATOR_MANIFOLD) {
    request.def.integrator = THRUM_INTEGRATOR_ENERGY;
    request.def.frequency_matched = 0; // as manifold, which turns no mode at its own frequency
  }
  thrum_status status =
      driver_stepper_reduced_from(&request, &richer->model, q, p, &stepper, error);
  THRUM_THEN(status, step_all(record, richer, &stepper, seconds, error));
  driver_stepper_close(&stepper);
  return status;
}

/* Is a load a blow, over before the body has moved? What the mesh follows it by at rest is no part
 * of the motion after it, in which the body is bent and such a direction is stiff. */
static bool is_blow(const thrum_model *model, const load_spec *load) {
  const double period = THRUM_TWO_PI / sqrt(model->omega2[0]);
  return !load->gravity && load->course.until - load->course.from < BLOW * period;
}

/* The loads of a run at their full strength, which the mesh follows in directions of its own. */
static thrum_status fill_loads(const basis_record *record, const double *masses, double **loads,
                               int64_t *count, thrum_error *error) {
  const simulate_request *request = record->request;
  const int64_t all = 3 * record->model->vertex_count;
  const int64_t bases = request->base_motion_count > 0 ? 3 : 0;
  const bool spins = simulate_spins(request);
  int64_t statics = 0;
  for (int64_t n = 0; n < request->start_count; n++)
    statics += request->starts[n].kind == START_STATIC;
  THRUM_TRY(thrum_reserve(loads, all * (request->load_count + statics + bases + spins),
                          sizeof **loads, "the loads of a run", error));

  // loads, those of starts, the three axes of the base, and the spin
  double *to = *loads;
  for (int64_t n = 0; n < request->load_count; n++) {
    if (is_blow(record->model, &request->loads[n]))
      continue;
    THRUM_TRY(basis_record_load(record, masses, &request->loads[n], to, error));
    to += all;
  }
  for (int64_t n = 0; n < request->start_count; n++)
    if (request->starts[n].kind == START_STATIC) {
      THRUM_TRY(basis_record_load(record, masses, &request->starts[n].load, to, error));
      to += all;
    }
  for (int64_t axis = 0; axis < bases; axis++, to += all)
    for (int64_t v = 0; v < record->model->vertex_count; v++)
      to[3 * v + axis] = masses[v];
  if (spins) {
    basis_record_add_spin(record, masses, to);
    to += all;
  }
  *count = (to - *loads) / all;
  return THRUM_OK;
}

thrum_status basis_rerun(basis_record *record, const thrum_basis_judge *judge, double seconds,
                         thrum_error *error) {
  double flops = record->request->basis.judging == BASIS_JUDGE_ON ? FLOPS_ASKED : FLOPS_MOST;
  const bool can = basis_rerun_why_not(record->model, record->request->def.integrator) == NULL;
  const int64_t added =
      can ? basis_rerun_added(thrum_basis_judge_statics(judge), record->model, &flops) : 0;
  thrum_richer_model richer = {.change = NULL};
  thrum_error detail = {0};
  double *loads = NULL;
  int64_t count = 0;
  if (added == 0)
    return THRUM_OK;

  thrum_status status =
      fill_loads(record, thrum_basis_judge_masses(judge), &loads, &count, &detail);
  for (int64_t n = 0; n < record->request->load_count; n++)
    record->estimate.about =
        record->estimate.about || is_blow(record->model, &record->request->loads[n]);
  THRUM_THEN(status,
             thrum_richer_model_make(record->model, judge, loads, count, added, &richer, &detail));
  if (status >= 0 && richer.change != NULL)
    status = run_again(record, &richer, seconds, &detail);
  thrum_richer_model_free(&richer);
  free(loads);

  // a richer run that cannot be made leaves the estimate as it is
  if (status != THRUM_OUT_OF_MEMORY)
    return THRUM_OK;
  *error = detail;
  return status;
}
