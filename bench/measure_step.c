/* Time of a step of a body that swings. Every batch restores the same snapshot, so that all of them
 * do the same work. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "bench/measure.h"
#include "platform/clock.h"
#include "thrum/condensed_model.h"
#include "thrum/displacement.h"

#define WARM_STEPS 1024 /* until monitors and Jacobians have found their rhythm */
#define WHOLE_STEPS 64  /* a batch has a multiple of it, as what is done now and then repeats so */
#define BATCH_US 5000.0
#define STEPS_LEAST 20
#define STEPS_MOST 2000

thrum_status bench_check_implicit(int64_t rank, int64_t wanted, thrum_error *error) {
  return wanted <= rank
             ? THRUM_OK
             : thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                               "%lld implicit modes are asked for, the model has only %lld",
                               (long long)wanted, (long long)rank);
}

/* A dt between the bounds of h omega = 2 c of two neighbouring modes. */
thrum_status bench_step_choose_dt(const thrum_model *model, bench_step *bench, thrum_error *error) {
  const int64_t r = model->rank, wanted = bench->implicit_wanted;
  THRUM_TRY(bench_check_implicit(r, wanted, error));
  // between the slowest implicit mode and the fastest explicit one
  const double above = wanted > 0 ? model->omega2[r - wanted] : 4.0 * model->omega2[r - 1];
  const double below = wanted < r ? model->omega2[r - wanted - 1] : 0.25 * model->omega2[0];
  bench->def.dt = 2.0 * bench->def.split_safety / pow(above * below, 0.25);
  if (!(above > below))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "no time step makes exactly %lld modes implicit: two have one frequency",
                           (long long)wanted);
  return THRUM_OK;
}

thrum_status bench_step_momentum(const thrum_model *model, const bench_step *bench, double *p,
                                 thrum_error *error) {
  thrum_state *state;
  THRUM_TRY(thrum_state_create(model, &bench->def, &state, error));
  thrum_status status = bench_step_start(model, bench, state, error);
  THRUM_THEN(status, thrum_state_get(model, state, NULL, p, error));
  thrum_state_destroy(state);
  return status;
}

/* Starts the body from its rest position with the speed that would bring the first mode alone to
 * the swing. So the body bends freely, where a displaced mode would be stretched. */
thrum_status bench_step_start(const thrum_model *model, const bench_step *bench, thrum_state *state,
                              thrum_error *error) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  double *p = calloc((size_t)(model->rank + shape->rank), sizeof *p);
  if (!p)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a start");
  double *extents = p + model->rank;
  thrum_status status = THRUM_MISSING;
  if (shape->basis)
    status = thrum_basis_extents(shape, extents, error);
  else
    thrum_error_set(error, status, "the model has no basis to measure a swing in metres by");
  if (status >= 0) {
    p[0] = sqrt(model->omega2[0]) * bench->swing / extents[0];
    status = thrum_state_set(model, state, NULL, p, error);
  }
  free(p);
  return status;
}

static thrum_status run_steps(const thrum_model *model, thrum_state *state, int64_t steps,
                              thrum_error *error) {
  thrum_status status = THRUM_OK;
  for (int64_t k = 0; k < steps && status >= 0; k++)
    status = thrum_step(model, state, error);
  return status;
}

/* Counts the operations of the passes of a step and the coefficients that they read: a force meets
 * each coefficient with 4 operations, a restriction with 2, a tangent as thrum_pass_cost_of
 * says, of the implicit modes alone with 6. A force on the explicit modes alone meets those of
 * terms with three or four of them with 4, the others with 2. */
static void count_passes(const thrum_model *model, bench_step *bench) {
  const double all = bench_terms(model->rank), evaluations = bench->iterations + 1.0;
  const int64_t implicit = bench->implicit_modes;
  const int64_t moved = model->rank - implicit;
  const double inner = bench_terms(implicit), held = bench_terms(moved);
  const double with_three =
      (double)(thrum_c3_count(moved) * (implicit + 1) + thrum_c4_count(moved));
  double forces = evaluations, tangents = bench->factorisations, restricted;

  // explicit integrators are counted apart and return
  switch (bench->def.integrator) {
  case THRUM_INTEGRATOR_ENERGY:
  case THRUM_INTEGRATOR_NEWMARK:
  case THRUM_INTEGRATOR_FOX_GOODWIN:
  case THRUM_INTEGRATOR_MIDPOINT:
  case THRUM_INTEGRATOR_BACKWARD_EULER:
  case THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER:
    // a tangent brings the force of its point
    forces -= tangents;
    break;
  case THRUM_INTEGRATOR_RK4:
    forces = 4.0;
    break;
  case THRUM_INTEGRATOR_MANIFOLD:
    forces *= 2.0;
    break;
  case THRUM_INTEGRATOR_VERLET:
  case THRUM_INTEGRATOR_IMEXV:
    if (implicit == model->rank)
      break;

    // one force on the explicit modes, one restriction, and evaluations of the implicit modes alone
    restricted = implicit > 0 ? all - held - inner : 0.0;
    bench->operations = 2.0 * (all + with_three + restricted);
    bench->coefficients = all + restricted;
    if (implicit > 0) {
      bench->operations += (4.0 * evaluations + 6.0 * bench->factorisations) * inner;
      bench->coefficients += (evaluations + bench->factorisations) * inner;
    }
    return;
  }

  // all others evaluate whole forces and tangents
  const thrum_pass_cost tangent = thrum_pass_cost_of(model->rank, THRUM_PASS_TANGENT, 0);
  bench->operations = 4.0 * forces * all + tangents * tangent.operations;
  bench->coefficients = forces * all + tangents * tangent.coefficients;
}

/* Batches from the snapshot. */
static thrum_status measure(const thrum_model *model, thrum_state *state, const void *snapshot,
                            double *samples, bench_step *bench, thrum_error *error) {
  const size_t bytes = thrum_state_kept_bytes(state);
  thrum_status status = THRUM_OK;
  int64_t steps = bench->steps;

  // a batch of about BATCH_US unless the caller gave its steps
  if (steps == 0) {
    const double began = clock_thread_seconds();
    status = run_steps(model, state, STEPS_LEAST, error);
    const double one = 1e6 * (clock_thread_seconds() - began) / STEPS_LEAST;
    steps = (int64_t)ceil(fmin(STEPS_MOST, BATCH_US / one) / WHOLE_STEPS) * WHOLE_STEPS;
  }

  // every batch starts from the same state
  for (int64_t n = 0; n < bench->batches && status >= 0; n++) {
    memcpy(state, snapshot, bytes);
    const double began = clock_thread_seconds();
    status = run_steps(model, state, steps, error);
    samples[n] = 1e6 * (clock_thread_seconds() - began) / (double)steps;
  }
  if (status < 0)
    return status;

  const thrum_state_report before = thrum_state_report_get(snapshot);
  const thrum_state_report after = thrum_state_report_get(state);
  bench->time = bench_summary(samples, bench->batches);
  bench->dt = bench->def.dt;
  bench->iterations = (double)(after.iterations - before.iterations) / (double)steps;
  bench->factorisations = (double)(after.factorisations - before.factorisations) / (double)steps;
  bench->implicit_modes = after.implicit_modes;
  bench->steps_measured = steps;
  count_passes(model, bench);
  return THRUM_OK;
}

thrum_status bench_step_run(const thrum_model *model, bench_step *bench, thrum_error *error) {
  thrum_status status = THRUM_OK;
  if (bench->implicit_wanted >= 0)
    status = bench_step_choose_dt(model, bench, error);
  thrum_state *state = NULL;
  THRUM_THEN(status, thrum_state_create(model, &bench->def, &state, error));
  if (status < 0)
    return status;

  void *snapshot = malloc(thrum_state_kept_bytes(state));
  double *samples = calloc((size_t)bench->batches, sizeof *samples);
  if (!snapshot || !samples)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a state");

  // the first steps factor and fill caches: they are not measured
  THRUM_THEN(status, bench_step_start(model, bench, state, error));
  THRUM_THEN(status, run_steps(model, state, WARM_STEPS, error));
  if (status >= 0) {
    memcpy(snapshot, state, thrum_state_kept_bytes(state));
    status = measure(model, state, snapshot, samples, bench, error);
  }

  thrum_state_destroy(state);
  free(snapshot);
  free(samples);
  return status < 0 ? status : THRUM_OK;
}
