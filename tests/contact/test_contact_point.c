/* Tests of the products that a sweep makes with the rows of a point: they have the bits of
 * core/base/two_lanes.h whatever the processor has.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "contact/contact_point.h"
#include "contact/contact_private.h"
#include "core/base/two_lanes.h"
#include "tests/support/random_model.h"

enum { MOST = 40 };

static void a_point_moves_and_is_pushed_by_the_bits_of_two_lanes(void **context) {
  (void)context;
  random_state random = {7};
  for (int32_t rank = 1; rank <= MOST; rank++) {
    double rows[3 * MOST], x[MOST], weights[MOST], moved[MOST], force[3], u[3], expected[3];
    thrum_contact contact = {.rank = rank};
    thrum_contact_run run = {.contact = &contact, .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    random_vector(&random, 3 * rank, 1, rows);
    random_vector(&random, rank, 1, x);
    random_vector(&random, rank, 1, weights);
    random_vector(&random, 3, 1, force);

    // how the point moves with the shape
    thrum_point_shape(&run, rows, x, u);
    thrum_rows_times(rank, rows, x, expected);
    for (int axis = 0; axis < 3; axis++)
      assert_true(u[axis] == expected[axis]);

    // how a force on it moves the shape
    memcpy(moved, x, sizeof moved);
    run.view.weights = weights;
    run.view.moved = moved;
    thrum_shape_push(&run, rows, force);
    thrum_rows_push(rank, rows, force, weights, x);
    assert_memory_equal(moved, x, (size_t)rank * sizeof *x);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_point_moves_and_is_pushed_by_the_bits_of_two_lanes),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
