/* Pictures of bodies: what is nearer hides what is behind, colours say how far, and the place at
 * rest is seen where the body no longer is. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "validation/pictures/render.h"

#define SIZE 60

/* Two squares that face the x axis, the first one nearer to an eye there. */
static const double squares[24] = {1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1,
                                   0, -2, -2, 0, 2, -2, 0, 2, 2, 0, -2, 2};
static const int32_t faces[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};

static const uint8_t *pixel(const experiment_image *image, int x, int y) {
  return image->pixels + 3 * (y * image->width + x);
}

static experiment_image draw(const double *moved, const double *value) {
  const experiment_solid solid = {8, squares, moved, value, 4, faces};
  const experiment_view view = {.azimuth = 0, .width = SIZE, .height = SIZE};
  thrum_error error = {0};
  experiment_image image;
  assert_int_equal(experiment_image_make(SIZE, SIZE, &image, &error), THRUM_OK);
  assert_int_equal(experiment_render(&solid, &view, &image, &error), THRUM_OK);
  return image;
}

static void the_nearer_square_hides_the_other(void **state) {
  (void)state;
  static const double value[8] = {1, 1, 1, 1, 0, 0, 0, 0};
  experiment_image image = draw(squares, value);
  const uint8_t *middle = pixel(&image, SIZE / 2, SIZE / 2), *edge = pixel(&image, 7, SIZE / 2);
  // red in front of blue
  assert_true(middle[0] > 2 * middle[2]);
  assert_true(edge[2] > 2 * edge[0]);
  assert_true(pixel(&image, 0, 0)[0] == 255 && pixel(&image, 0, 0)[2] == 255);
  experiment_image_free(&image);
}

static void where_a_body_has_left_its_rest_is_grey(void **state) {
  (void)state;
  static const double value[8] = {0};
  double moved[24];
  memcpy(moved, squares, sizeof moved);
  for (int v = 0; v < 8; v++)
    moved[3 * v + 1] += 3;
  experiment_image image = draw(moved, value);
  // with the eye on the x axis and z up, y points to the right
  const uint8_t *left = pixel(&image, 8, SIZE / 2), *right = pixel(&image, SIZE - 9, SIZE / 2);
  assert_true(left[0] == left[1] && left[1] == left[2] && left[0] < 250 && left[0] > 200);
  assert_true(right[2] > right[0] + 50);
  experiment_image_free(&image);
}

static void a_view_beyond_the_picture_is_refused(void **state) {
  (void)state;
  static const double value[8] = {0};
  const experiment_solid solid = {8, squares, squares, value, 4, faces};
  const experiment_view view = {.left = 1, .width = SIZE, .height = SIZE};
  thrum_error error = {0};
  experiment_image image;
  assert_int_equal(experiment_image_make(SIZE, SIZE, &image, &error), THRUM_OK);
  assert_int_equal(experiment_render(&solid, &view, &image, &error), THRUM_INVALID_ARGUMENT);
  experiment_image_free(&image);
}

static void colours_go_from_blue_to_red(void **state) {
  (void)state;
  double low[3], high[3], over[3];
  experiment_color(0, low);
  experiment_color(1, high);
  experiment_color(7, over);
  assert_true(low[2] > low[0] && high[0] > high[2]);
  assert_memory_equal(high, over, sizeof high);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_nearer_square_hides_the_other),
      cmocka_unit_test(where_a_body_has_left_its_rest_is_grey),
      cmocka_unit_test(a_view_beyond_the_picture_is_refused),
      cmocka_unit_test(colours_go_from_blue_to_red),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
