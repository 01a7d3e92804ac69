/* Published problems of thin shells by one solid-shell over the thickness, and a block near
 * incompressibility, within bounds that elements which lock miss by far: validation/shells.py has
 * more of the shells, on finer meshes.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

/* The mean displacement of the last target that a run shows. */
static void shown(program_result run, double mean[3]) {
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *all = cJSON_GetObjectItemCaseSensitive(object, "displacements");
  const cJSON *last = cJSON_GetArrayItem(all, cJSON_GetArraySize(all) - 1);
  const cJSON *numbers = cJSON_GetObjectItemCaseSensitive(last, "mean_m");
  for (int c = 0; c < 3; c++)
    mean[c] = cJSON_GetArrayItem(numbers, c)->valuedouble;
  cJSON_Delete(object);
  program_result_free(&run);
}

static void assert_share(double value, double published, double most) {
  if (!(fabs(value / published - 1) <= most))
    fail_msg("%.6g is not %.6g within %g", value, published, most);
}

#define STRIP(mesh, ...)                                                                           \
  thrum_run(folder, "static", mesh, "--full", "--young", "1.2e6", "--poisson", "0", "--density",   \
            "1", "--fix", "left", "--at", "right", "--monitor", "off", "--json", __VA_ARGS__,      \
            NULL)

/* Sze, Liu & Lo 2004: an end shear of 4 moves the end of a strip of 10 x 1 x 0.1 by 6.698 across
 * and 3.286 along; a moment of 2 pi E I / L closes one of 12 x 1 x 0.1 to a circle, half of it to
 * half a circle, whose end is at 2 L / pi across. */
static void strips_bend_as_far_as_published(void **state) {
  (void)state;
  double mean[3];
  shown(STRIP("beam:16x1x1@10x1x0.1,hex", "--load", "constant:0,0,4@right"), mean);
  assert_share(mean[2], 6.698, 0.002);
  assert_share(mean[0], -3.286, 0.003);
  shown(STRIP("beam:16x1x1@12x1x0.1,hex", "--moment", "0,-26.179938779914944,0@right"), mean);
  assert_share(mean[2], 2 * 12 / 3.14159265358979, 0.01);
  assert_share(mean[0], -12, 0.01);
}

/* Scordelis & Lo's roof, a quarter: 0.3024 at the middle of the free edge under 90 a unit of area.
 */
static void a_roof_of_a_surface_sags_as_far_as_published(void **state) {
  (void)state;
  enum { N = 8 };
  char text[20000];
  int used = 0;
  double mean[3];
  for (int j = 0; j <= N; j++)
    for (int i = 0; i <= N; i++) {
      const double a = 40.0 / 180 * 3.14159265358979 * i / N;
      used += snprintf(text + used, sizeof text - (size_t)used, "v %.15g %.15g %.15g\n",
                       25 * sin(a), 25.0 * j / N, 25 * cos(a));
    }
  for (int j = 0; j < N; j++)
    for (int i = 0; i < N; i++) {
      const int at = j * (N + 1) + i + 1;
      used += snprintf(text + used, sizeof text - (size_t)used, "f %d %d %d %d\n", at, at + 1,
                       at + N + 2, at + N + 1);
    }
  assert_true(text_file_write(in_folder("roof.obj"), text));
  program_result run =
      thrum_run(folder, "mesh", "roof.obj", "-o", "roof.msh", "--thickness", "0.25", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  shown(thrum_run(folder, "static", "roof.msh", "--unit", "m-kg-s", "--full", "--young", "4.32e8",
                  "--poisson", "0", "--density", "36", "--fix", "y<1e-9:xz", "--fix", "y>24.999:y",
                  "--fix", "x<0.05:x", "--load", "gravity:0,0,-0.01", "--at", "x>16&y>24.9",
                  "--monitor", "off", "--json", NULL),
        mean);
  assert_share(1000 * mean[2], -0.3024, 0.02);
}

/* A beam of hexahedra near incompressibility bends as one at 0.45 does; with volumetric locking it
 * would move by a sixth less. */
static void hexahedra_do_not_lock_near_incompressibility(void **state) {
  (void)state;
  static const char *const ratios[] = {"0.45", "0.4999"};
  double mean[2][3];
  for (int n = 0; n < 2; n++)
    shown(thrum_run(folder, "static", "beam:8x2x2@1x0.2x0.2,hex", "--full", "--fix", "left",
                    "--young", "1e6", "--poisson", ratios[n], "--density", "1000", "--load",
                    "gravity:0,0,-0.1", "--at", "right", "--monitor", "off", "--json", NULL),
          mean[n]);
  assert_share(mean[1][2], mean[0][2], 0.05);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(strips_bend_as_far_as_published),
      cmocka_unit_test(hexahedra_do_not_lock_near_incompressibility),
      cmocka_unit_test(a_roof_of_a_surface_sags_as_far_as_published),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
