/* Test of the norm of a motion against its definition (design 5).
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "core/state/motion_norm.h"

enum { RANK = 5 };

static void it_is_the_root_of_its_sum_for_every_split(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 71, RANK, 3, 150, 1);
  const double q[RANK] = {0.3, -0.1, 0.7, 0.2, -0.4}, p[RANK] = {2, 5, -3, 1, 4}, h = 0.02;
  for (int split = 0; split <= RANK; split++) {
    thrum_state_def def = imexv_def();
    def.dt = h;
    def.explicit_count = split;
    def.split_rule = THRUM_SPLIT_COUNT;
    thrum_state *state = state_make(&m.model, &def);

    // explicit coordinates count by their stiffness alone
    double sum = 0;
    for (int i = 0; i < RANK; i++)
      sum += ((i < split ? 0 : 1) + h * h / 4 * m.omega2[i]) * q[i] * q[i] + h * h * p[i] * p[i];
    const double norm = thrum_motion_norm(&m.model, state, q, p);
    assert_true(fabs(norm - sqrt(sum)) <= 1e-14 * norm);
    state_free(state);
  }
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_is_the_root_of_its_sum_for_every_split),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
