/* Tests of the placement of a run's body: the stored placement gives back the matrix that it was
 * taken from, for any rotation.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "driver/record/run_placement.h"

/* Fills a column-major matrix: a scale, a rotation by the quaternion w, x, y, z, and a shift. */
static void fill(const double q[4], double scale, const double shift[3], double matrix[16]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  memset(matrix, 0, 16 * sizeof *matrix);
  for (int n = 0; n < 9; n++)
    matrix[4 * (n / 3) + n % 3] = scale * turn[n % 3][n / 3];
  memcpy(matrix + 12, shift, 3 * sizeof *shift);
  matrix[15] = 1;
}

static void a_place_tells_its_matrix(void **state) {
  (void)state;

  // rotations about axes and diagonals, half turns and nearly half turns among them
  static const double turns[][4] = {{1, 0, 0, 0},  {0, 1, 0, 0},    {0, 0, 1, 0},
                                    {0, 0, 0, 1},  {1, 1, 1, 1},    {-1, 2, 3, -4},
                                    {0, 1, -1, 0}, {1e-9, 0, 1, 1}, {3, -1, 2, 5}};
  static const double shift[3] = {0.3, -2, 5}, in[3] = {0.7, -0.2, 0.4};

  // each rotation goes with the same scale and the same shift
  for (size_t n = 0; n < sizeof turns / sizeof turns[0]; n++) {
    double q[4], length = 0, matrix[16], again[16], row[RUN_PLACEMENT_COLUMNS], out[3];

    // the matrix of the normalised quaternion
    for (int i = 0; i < 4; i++)
      length = hypot(length, turns[n][i]);
    for (int i = 0; i < 4; i++)
      q[i] = turns[n][i] / length;
    fill(q, 2.5, shift, matrix);

    // a matrix becomes a placement and comes back
    run_placement_of(matrix, row);
    const run_placement place = {.placed = true, .scale = 2.5};
    run_placement_matrix(&place, row, again);
    run_placement_point(again, in, out);

    // the matrix that comes back maps a point to the same place
    for (int axis = 0; axis < 3; axis++) {
      const double wanted = matrix[axis] * in[0] + matrix[4 + axis] * in[1] +
                            matrix[8 + axis] * in[2] + matrix[12 + axis];
      assert_true(fabs(out[axis] - wanted) < 1e-14);
    }
  }
}

static void a_body_stands_where_its_run_says(void **state) {
  (void)state;
  // a rotation by 90 degrees about z, at twice the size
  const run_placement placed = {
      .placed = true, .position = {1, 2, 3}, .rotation = {sqrt(0.5), 0, 0, sqrt(0.5)}, .scale = 2};
  const run_placement alone = {.placed = false};
  double matrix[16], x[3] = {0.5, -0.25, 4};
  run_placement_matrix(&alone, NULL, matrix);
  run_placement_point(matrix, x, x);
  assert_true(x[0] == 0.5 && x[1] == -0.25 && x[2] == 4);
  run_placement_matrix(&placed, NULL, matrix);
  run_placement_point(matrix, x, x);
  assert_true(fabs(x[0] - 1.5) < 1e-15 && fabs(x[1] - 3) < 1e-15 && fabs(x[2] - 11) < 1e-15);
}

int main(void) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(a_place_tells_its_matrix),
                                     cmocka_unit_test(a_body_stands_where_its_run_says)};
  return cmocka_run_group_tests(tests, NULL, NULL);
}
