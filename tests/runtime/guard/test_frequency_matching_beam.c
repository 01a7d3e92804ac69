/* The purpose of frequency matching (design 7): the energy integrator follows a swinging beam
 * with less error. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"
#include "thrum/thrum.h"

enum { RANK = 15, ROWS = 200 };

/* The rows of q at each 3 ms of a run over 0.6 s from the momentum p, in steps of 3 ms / finer. */
static void rows_of(const thrum_model *model, thrum_integrator integrator, int32_t matched,
                    int finer, const double *p, double rows[ROWS][RANK]) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = integrator;
  def.dt = 0.003 / finer;
  def.frequency_matched = matched;
  def.tolerance = finer > 1 ? 1e-10 : 0;
  thrum_state *state = NULL;
  assert_int_equal(thrum_state_create(model, &def, &state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_set(model, state, NULL, p, NULL), THRUM_OK);
  for (int k = 0; k < ROWS; k++) {
    for (int n = 0; n < finer; n++)
      assert_true(thrum_step(model, state, NULL) >= 0);
    assert_int_equal(thrum_state_get(model, state, rows[k], NULL, NULL), THRUM_OK);
  }
  thrum_state_destroy(state);
}

/* From a start in the first mode alone, with which the beam swings by a tenth of its length. */
static void a_swinging_beam_errs_by_at_most_half(void **context) {
  (void)context;
  body beam = body_make("beam:20x3x3@1x0.15x0.15", "x<0.001");
  thrum_precomputed made = body_precompute(&beam, 8, RANK);
  static double reference[ROWS][RANK], rows[ROWS][RANK];
  const double p[RANK] = {3.08};
  double error[2];

  // the reference is of another integrator, of order 4
  rows_of(&made.model, THRUM_INTEGRATOR_FOX_GOODWIN, 1, 32, p, reference);
  for (int32_t matched = 0; matched < 2; matched++) {
    rows_of(&made.model, THRUM_INTEGRATOR_ENERGY, matched, 1, p, rows);
    double square = 0;
    for (int k = 0; k < ROWS; k++)
      for (int i = 0; i < RANK; i++)
        square += pow(rows[k][i] - reference[k][i], 2);
    error[matched] = sqrt(square);
  }
  if (!(error[1] <= 0.5 * error[0]))
    fail_msg("%.3e, without it %.3e", error[1], error[0]);
  thrum_precomputed_free(&made);
  body_free(&beam);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_swinging_beam_errs_by_at_most_half),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
