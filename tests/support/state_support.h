/* States for tests: one heap block each, calls that must succeed, and an independent reference
 * solution by the classical Runge-Kutta method. Header only.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_STATE_SUPPORT_H
#define THRUM_TESTS_SUPPORT_STATE_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/random_model.h"
#include "thrum/thrum.h"

#define RANK_MAX 16

/* Every integrator, and how many they are. */
#define X(name, value, text) THRUM_INTEGRATOR_##name,
static const thrum_integrator every_integrator[] = {THRUM_INTEGRATOR_LIST(X)};
#undef X
enum { INTEGRATOR_COUNT = sizeof every_integrator / sizeof every_integrator[0] };

static const double pi = 3.14159265358979323846;

/* The default def but for its integrator. */
static inline thrum_state_def imexv_def(void) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  return def;
}

/* A state that the test owns; free it with state_free. */
static inline thrum_state *state_make(const thrum_model *model, const thrum_state_def *def) {
  size_t size = 0;
  thrum_error error;
  if (thrum_state_size(model, def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  thrum_state *state = NULL;
  if (thrum_state_init(memory, size, model, def, &state, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return state;
}

static inline void state_free(thrum_state *state) {
  free(state);
}

static inline void state_put(const thrum_model *model, thrum_state *state, const double *q,
                             const double *p) {
  assert_int_equal(thrum_state_set(model, state, q, p, NULL), THRUM_OK);
}

static inline void state_push(const thrum_model *model, thrum_state *state, const double *force) {
  assert_int_equal(thrum_state_set_force(model, state, force, NULL), THRUM_OK);
}

static inline void state_read(const thrum_model *model, thrum_state *state, double *q, double *p) {
  assert_int_equal(thrum_state_get(model, state, q, p, NULL), THRUM_OK);
}

static inline void state_steps(const thrum_model *model, thrum_state *state, int64_t count) {
  thrum_error error;
  for (int64_t k = 0; k < count; k++)
    if (thrum_step(model, state, &error) < 0)
      fail_msg("%s", error.message);
}

static inline thrum_energies state_energy(const thrum_model *model, thrum_state *state) {
  thrum_energies energies = {0, 0, 0, 0};
  assert_int_equal(thrum_state_energies(model, state, &energies, NULL), THRUM_OK);
  return energies;
}

/* How a step of the energy integrator moves a mode (design 7): both 1 where it turns at the
 * frequency of the trapezoidal rule. */
typedef struct matched_step {
  double stretch; /* its time step over dt */
  double speed;   /* its velocity in the middle of the step over (q' - q)/dt */
} matched_step;

/* The same of each mode, by the frequency that the state says it has. */
static inline void state_matched_steps(const thrum_model *model, const thrum_state *state,
                                       double dt, matched_step *by) {
  thrum_stepped_mode modes[RANK_MAX];
  assert_int_equal(thrum_state_stepped_modes(model, state, modes, NULL), THRUM_OK);
  for (int64_t i = 0; i < model->rank; i++) {
    const double x = pi * dt * modes[i].hertz;
    const bool matched =
        x > 0 && fabs(modes[i].stepped_hertz - modes[i].hertz) < 1e-12 * modes[i].hertz;
    by[i].stretch = matched ? tan(x) / x : 1;
    by[i].speed = matched ? x / sin(x) : 1;
  }
}

/* A copy of the whole memory block, to compare or to restore. */
static inline void *state_snapshot(const thrum_state *state) {
  const size_t size = thrum_state_bytes(state);
  void *copy = aligned_alloc(64, size);
  assert_non_null(copy);
  return memcpy(copy, state, size);
}

static inline double largest_difference(const double *a, const double *b, int64_t n) {
  double largest = 0;
  for (int64_t i = 0; i < n; i++) {
    const double difference = fabs(a[i] - b[i]);
    largest = difference > largest || isnan(difference) ? difference : largest;
  }
  return largest;
}

/* f(t) = amplitude sin(frequency t + i) for coordinate i, and its mean over [a, b]. */
typedef struct test_load {
  double amplitude, frequency;
} test_load;

static inline double test_load_at(const test_load *load, int64_t i, double t) {
  return load->amplitude * sin(load->frequency * t + (double)i);
}

static inline double test_load_mean(const test_load *load, int64_t i, double a, double b) {
  if (load->amplitude == 0)
    return 0;
  const double phase = (double)i;
  return load->amplitude * (cos(load->frequency * a + phase) - cos(load->frequency * b + phase)) /
         (load->frequency * (b - a));
}

/* d(q, p)/dt of q'' = f - R(q) - D q'. */
static inline void reference_rate(const thrum_model *model, const thrum_state_def *def,
                                  const test_load *load, double t, const double *q, const double *p,
                                  double *dq, double *dp, double *work) {
  double force[RANK_MAX], product[RANK_MAX];
  thrum_internal_force(model, q, force, work);
  thrum_tangent_product(model, q, p, product, work);
  for (int64_t i = 0; i < model->rank; i++) {
    const double stiff =
        def->damping_form == THRUM_DAMPING_TANGENT ? product[i] : model->omega2[i] * p[i];
    dq[i] = p[i];
    dp[i] =
        test_load_at(load, i, t) - force[i] - def->damping_alpha * p[i] - def->damping_beta * stiff;
  }
}

/* Advances q, p from t by `count` classical Runge-Kutta steps of size h. */
static inline void reference_advance(const thrum_model *model, const thrum_state_def *def,
                                     const test_load *load, double t, double h, int64_t count,
                                     double *q, double *p) {
  static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
  double *work = random_alloc((int64_t)thrum_work_count(model), sizeof(double));
  const int64_t r = model->rank;

  for (int64_t k = 0; k < count; k++) {
    double dq[RANK_MAX] = {0}, dp[RANK_MAX] = {0}, q_sum[RANK_MAX], p_sum[RANK_MAX];
    memcpy(q_sum, q, (size_t)r * sizeof *q);
    memcpy(p_sum, p, (size_t)r * sizeof *p);

    // the four stages, each from the rate of the one before
    for (int s = 0; s < 4; s++) {
      double q_at[RANK_MAX], p_at[RANK_MAX];
      for (int64_t i = 0; i < r; i++) {
        q_at[i] = q[i] + at[s] * h * dq[i];
        p_at[i] = p[i] + at[s] * h * dp[i];
      }
      reference_rate(model, def, load, t + ((double)k + at[s]) * h, q_at, p_at, dq, dp, work);
      for (int64_t i = 0; i < r; i++) {
        q_sum[i] += weight[s] * h * dq[i];
        p_sum[i] += weight[s] * h * dp[i];
      }
    }

    memcpy(q, q_sum, (size_t)r * sizeof *q);
    memcpy(p, p_sum, (size_t)r * sizeof *p);
  }
  free(work);
}

#endif
