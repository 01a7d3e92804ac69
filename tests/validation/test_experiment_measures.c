/* Tests of the measures of the experiments: slopes, amplitudes and impulses.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "tests/support/random_model.h"
#include "tests/support/simulate_support.h"
#include "thrum/displacement.h"
#include "validation/experiments/long_run.h"

static void a_line_has_its_slope_and_no_error(void **state) {
  (void)state;
  double values[50];
  for (int n = 0; n < 50; n++)
    values[n] = 7 - 0.25 * n;
  const experiment_trend line = experiment_slope(values, 50, 2),
                         none = experiment_slope(values, 2, 2);
  assert_true(fabs(line.slope + 0.125) < 1e-14 && line.error < 1e-14);
  assert_true(isnan(none.slope) && isnan(none.error) && isnan(none.error_correlated));
}

/* y = 0, 1, 0, 1 at x = 0..3: slope 1/5, residuals -.2 .6 -.6 .2, error sqrt(0.8 / 2 / 5). */
static void a_zigzag_has_the_textbook_error(void **state) {
  (void)state;
  static const double values[4] = {0, 1, 0, 1};
  const experiment_trend zigzag = experiment_slope(values, 4, 1);
  assert_true(fabs(zigzag.slope - 0.2) < 1e-15);
  assert_true(fabs(zigzag.error - sqrt(0.08)) < 1e-15);
  // successive residuals change sign, which is taken as no correlation
  assert_true(zigzag.error_correlated == zigzag.error);
}

/* Rows of noise without a trend, in which each value keeps a share of the one before: about one row
 * in twenty should lie beyond two standard errors. Errors from independent residuals report a trend
 * in half of the rows. */
static void values_that_wander_have_no_trend(void **state) {
  (void)state;
  enum { ROWS = 400, COUNT = 200 };

  random_state random = {11};
  int told[2] = {0, 0};

  // the noise settles before the row begins
  for (int row = 0; row < ROWS; row++) {
    double values[COUNT], at = 0;
    for (int k = -50; k < COUNT; k++) {
      double noise;
      random_vector(&random, 1, 1.0, &noise);
      at = 0.8 * at + noise;
      if (k >= 0)
        values[k] = 3 + at;
    }

    // a trend is reported by the plain and by the corrected error
    const experiment_trend trend = experiment_slope(values, COUNT, 1);
    told[0] += fabs(trend.slope) > 2 * trend.error;
    told[1] += fabs(trend.slope) > 2 * trend.error_correlated;
  }

  // independent residuals report far too many trends, the corrected error about as many as it
  // should
  assert_true(told[0] > ROWS / 3);
  assert_true(told[1] > ROWS / 100 && told[1] < ROWS / 8);
}

static const double particle_push[3] = {0, 2, 0};

static const thrum_model *load_particle(void) {
  const thrum_model *model = NULL;
  thrum_error error = {0};
  char path[] = "/tmp/thrum-study-XXXXXX";
  const int file = mkstemp(path);
  assert_true(file >= 0);
  close(file);
  assert_true(save_particle(path, 4, 9));
  assert_int_equal(thrum_model_load(path, &model, &error), THRUM_OK);
  unlink(path);
  return model;
}

static void amplitude_is_the_mean_displacement_of_the_group(void **state) {
  (void)state;
  static const double q[PARTICLE_RANK] = {0.3, -0.7};

  // the two groups share a vertex; a group that does not exist is refused
  const thrum_model *model = load_particle();
  experiment_body body;
  thrum_error error = {0};
  assert_int_equal(experiment_body_init("particle", model, "nothing", particle_push, &body, &error),
                   THRUM_MISSING);
  assert_int_equal(experiment_body_init("particle", model, "a, b", particle_push, &body, &error),
                   THRUM_OK);

  // vertices 1, 2 and 4 share the force, and the box is the unit cube
  double mean[3] = {0, 0, 0};
  double u[12];
  assert_int_equal(thrum_displacement(model, q, 0, 4, u, &error), THRUM_OK);
  for (int axis = 0; axis < 3; axis++)
    mean[axis] = (u[axis] + u[3 + axis] + u[9 + axis]) / 3;
  const double expected = sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]);
  assert_true(fabs(experiment_body_amplitude(&body, q) - expected) < 1e-15);
  assert_true(body.length == 1 && body.direction[1] == 1);

  // the displacement along the push under 1 N is the compliance
  const double still[PARTICLE_RANK] = {body.push[0] / 4, body.push[1] / 9};
  double moved = 0;
  for (int i = 0; i < PARTICLE_RANK; i++)
    moved += body.tip[PARTICLE_RANK + i] * still[i];
  assert_true(fabs(moved - body.compliance) < 1e-15);

  experiment_body_free(&body);
  thrum_model_destroy(model);
}

/* A slow body has the whole impulse as momentum afterwards, whether the 3 ms of the impulse are
 * many steps, some steps and a part, or less than one. */
static void a_strike_gives_its_whole_impulse_at_any_step(void **state) {
  (void)state;
  static const double steps[5] = {1e-4, 7e-4, 2e-3, 3e-3, 1e-2};

  // a body whose periods are long against the impulse
  const thrum_model *model = load_particle();
  experiment_body body;
  thrum_error error = {0};
  assert_int_equal(experiment_body_init("particle", model, "a, b", particle_push, &body, &error),
                   THRUM_OK);

  for (int n = 0; n < 5; n++) {
    // the impulse is applied to a body at rest
    thrum_state_def def = thrum_default_state_def();
    def.integrator = THRUM_INTEGRATOR_ENERGY;
    def.dt = steps[n];
    thrum_state *strung = NULL;
    assert_int_equal(thrum_state_create(model, &def, &strung, &error), THRUM_OK);
    assert_int_equal(experiment_strike(&body, 0.7, def.dt, strung, &error), THRUM_OK);

    // the momentum is the impulse, in relation to its largest entry
    double p[PARTICLE_RANK];
    assert_int_equal(thrum_state_get(model, strung, NULL, p, &error), THRUM_OK);
    double size = 0, off = 0;
    for (int i = 0; i < PARTICLE_RANK; i++) {
      size = fmax(size, fabs(0.7 * body.push[i]));
      off = fmax(off, fabs(p[i] - 0.7 * body.push[i]));
    }
    if (!(size > 0 && off < 1e-3 * size))
      fail_msg("dt %g: off by %g of %g", def.dt, off, size);
    thrum_state_destroy(strung);
  }

  experiment_body_free(&body);
  thrum_model_destroy(model);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_line_has_its_slope_and_no_error),
      cmocka_unit_test(a_zigzag_has_the_textbook_error),
      cmocka_unit_test(values_that_wander_have_no_trend),
      cmocka_unit_test(amplitude_is_the_mean_displacement_of_the_group),
      cmocka_unit_test(a_strike_gives_its_whole_impulse_at_any_step),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
