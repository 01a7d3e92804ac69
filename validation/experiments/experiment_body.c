/* Bodies of the experiments, and the impulse that bends one by so much.
 *
 * The mean displacement of the loaded group is the transpose of a force that the group shares: U^T
 * of 1 N along an axis, times q. SPDX-License-Identifier: Apache-2.0 */
#include "validation/experiments/experiment_body.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "platform/allocate.h"
#include "thrum/external_load.h"

#define SWING_SECONDS 3.0 /* within which a swing reaches its amplitude */
#define SWING_TRIES 12
#define SWING_NEAR 1e-3 /* relative */

/* f^T K^-1 f of a reduced force. */
static double compliance(const thrum_model *model, const double *force) {
  double sum = 0;
  for (int64_t i = 0; i < model->rank; i++)
    sum += force[i] * force[i] / model->omega2[i];
  return sum;
}

/* A unit vector: as given, or the softest axis. */
static void choose_direction(const double given[3], experiment_body *body) {
  double softest = -1;
  const double length = sqrt(given[0] * given[0] + given[1] * given[1] + given[2] * given[2]);
  for (int axis = 0; axis < 3; axis++)
    body->direction[axis] = length > 0 ? given[axis] / length : 0;

  // without a direction: the axis along which 1 N moves the group furthest
  for (int axis = 0; axis < 3 && !(length > 0); axis++) {
    const double soft = compliance(body->model, body->tip + axis * body->model->rank);
    // a tie is not for rounding to settle
    if (soft > softest * (1 + 1e-6)) {
      softest = soft;
      memset(body->direction, 0, sizeof body->direction);
      // downwards, so that a push along z bends as a weight does
      body->direction[axis] = axis == 2 ? -1 : 1;
    }
  }
}

thrum_status experiment_body_init(const char *name, const thrum_model *model, const char *group,
                                  const double direction[3], experiment_body *body,
                                  thrum_error *error) {
  const int32_t *vertices = NULL;
  int64_t count = 0;
  thrum_status status = thrum_model_group(model, group, &vertices, &count, NULL);
  if (status < 0)
    return thrum_error_set(error, status, "%.100s: the model has no group '%.100s' to push", name,
                           group);

  experiment_body made = {.name = name, .model = model};
  const int64_t rank = model->rank;
  THRUM_TRY(thrum_reserve(&made.push, 4 * rank, sizeof *made.push, name, error));
  made.tip = made.push + rank;
  for (int axis = 0; axis < 3 && status >= 0; axis++) {
    const double unit[3] = {axis == 0, axis == 1, axis == 2};
    status = thrum_load_add_shared(model, vertices, count, unit, made.tip + axis * rank, error);
  }
  if (status < 0) {
    free(made.push);
    return status;
  }

  // the push is 1 N along that direction
  choose_direction(direction, &made);
  for (int axis = 0; axis < 3; axis++)
    for (int64_t i = 0; i < rank; i++)
      made.push[i] += made.direction[axis] * made.tip[axis * rank + i];
  made.compliance = compliance(model, made.push);
  made.length = thrum_box3_longest(model->vertices, model->vertex_count);
  *body = made;
  return THRUM_OK;
}

thrum_status experiment_body_smooth(const experiment_body *body, experiment_body *smooth,
                                    thrum_error *error) {
  const size_t rank = (size_t)body->model->rank;
  experiment_body made = *body;
  THRUM_TRY(thrum_reserve(&made.push, 4 * rank, sizeof *made.push, body->name, error));
  made.tip = made.push + rank;
  memcpy(made.tip, body->tip, 3 * rank * sizeof *made.tip);

  // along the axis in which the first vector moves the group most
  for (int axis = 0; axis < 3; axis++)
    if (fabs(made.tip[(size_t)axis * rank]) > fabs(made.push[0]))
      made.push[0] = made.tip[(size_t)axis * rank];
  made.compliance = compliance(made.model, made.push);
  *smooth = made;
  return THRUM_OK;
}

void experiment_body_free(experiment_body *body) {
  free(body->push);
  memset(body, 0, sizeof *body);
}

double experiment_body_amplitude(const experiment_body *body, const double *q) {
  double square = 0;
  for (int axis = 0; axis < 3; axis++) {
    double sum = 0;
    for (int64_t i = 0; i < body->model->rank; i++)
      sum += body->tip[axis * body->model->rank + i] * q[i];
    square += sum * sum;
  }
  return sqrt(square) / body->length;
}

thrum_status experiment_kick(const experiment_body *body, double impulse, thrum_state *state,
                             double *energy, thrum_error *error) {
  const int64_t rank = body->model->rank;
  double p[THRUM_RANK_MAX];
  *energy = 0;
  for (int64_t i = 0; i < rank; i++) {
    p[i] = impulse * body->push[i];
    *energy += 0.5 * p[i] * p[i];
  }
  return thrum_state_set(body->model, state, NULL, p, error);
}

thrum_status experiment_strike(const experiment_body *body, double impulse, double dt,
                               thrum_state *state, thrum_error *error) {
  const thrum_load load = {.shape = THRUM_LOAD_CONSTANT, .until = EXPERIMENT_IMPULSE_SECONDS};
  const thrum_model *model = body->model;
  double force[THRUM_RANK_MAX];
  thrum_status status = THRUM_OK;
  // whole steps that begin before its end, up to rounding
  for (int64_t step = 0;
       (double)step * dt < EXPERIMENT_IMPULSE_SECONDS * (1.0 - 1e-6) && status >= 0; step++) {
    const double strength = impulse / EXPERIMENT_IMPULSE_SECONDS * thrum_load_mean(&load, step, dt);
    for (int64_t i = 0; i < model->rank; i++)
      force[i] = strength * body->push[i];
    status = thrum_state_set_force(model, state, force, error);
    THRUM_THEN(status, thrum_step(model, state, error));
  }
  return status >= 0 ? thrum_state_set_force(model, state, NULL, error) : status;
}

/* The largest amplitude in the first seconds after an impulse. */
static thrum_status swing(const experiment_body *body, double impulse, double dt, double *peak,
                          thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  double q[THRUM_RANK_MAX];
  thrum_state *state = NULL;
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.dt = dt;
  THRUM_TRY(thrum_state_create(body->model, &def, &state, error));

  // the peak counts after the impulse, in free motion
  thrum_status status = experiment_strike(body, impulse, dt, state, error);
  *peak = 0;
  for (double time = 0; status >= 0 && time < SWING_SECONDS; time += dt) {
    status = thrum_step(body->model, state, error);
    THRUM_THEN(status, thrum_state_get(body->model, state, q, NULL, error));
    if (status >= 0)
      *peak = fmax(*peak, experiment_body_amplitude(body, q));
  }
  thrum_state_destroy(state);
  return status;
}

thrum_status experiment_impulse(const experiment_body *body, double amplitude, double dt,
                                double *impulse, double *reached, thrum_error *error) {
  // as if the body swung in its softest mode alone
  double trial = amplitude * body->length / (body->compliance * sqrt(body->model->omega2[0]));
  double low = 0, high = 0;
  for (int n = 0; n < SWING_TRIES; n++) {
    double peak = 0;
    THRUM_TRY(swing(body, trial, dt, &peak, error));
    // a swing may jump with the impulse, past what is asked
    if (n == 0 || fabs(peak - amplitude) < fabs(*reached - amplitude)) {
      *impulse = trial;
      *reached = peak;
    }

    if (fabs(peak - amplitude) <= SWING_NEAR * amplitude || !(peak > 0))
      break;
    // the amplitude grows with the impulse, a little less than in proportion
    if (peak < amplitude)
      low = trial;
    else
      high = trial;
    trial *= amplitude / peak;
    if (high > 0 && low > 0 && !(trial > low && trial < high))
      trial = 0.5 * (low + high);
  }
  return THRUM_OK;
}
