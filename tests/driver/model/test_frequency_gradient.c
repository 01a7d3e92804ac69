/* Tests of the derivatives of frequencies: against the frequencies of the mesh with other
 * materials, and by their sums.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "driver/model/frequency_gradient.h"
#include "tests/support/random_model.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

enum { MODES = 4 };

typedef struct bar {
  const char *mesh, *order, *spring; /* spring: an option, or another that changes nothing */
} bar;

/* Makes a bar of this material and loads it. */
static const thrum_model *bar_of(bar of, double young, double poisson, double density) {
  char texts[3][40];
  snprintf(texts[0], sizeof texts[0], "%.17g", young);
  snprintf(texts[1], sizeof texts[1], "%.17g", poisson);
  snprintf(texts[2], sizeof texts[2], "%.17g", density);
  program_result run =
      thrum_run(folder, "precompute", of.mesh, of.order, "--fix", "x<0.001", of.spring, "--young",
                texts[0], "--poisson", texts[1], "--density", texts[2], "--modes", "4", "--rank",
                "4", "-o", "beam.npz", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  const thrum_model *model = NULL;
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &model, NULL), THRUM_OK);
  return model;
}

static const thrum_model *beam_of(double young, double poisson, double density) {
  const bar beam = {"beam:6x1x1@1x0.1x0.08", "--order=2", "--quiet"};
  return bar_of(beam, young, poisson, density);
}

/* Hexahedra, of which the moduli are in the rows, and a beam on a spring, which is of no region. */
static void elements_with_rows_and_springs_have_theirs(void **state) {
  (void)state;
  static const bar bars[] = {{"beam:6x1x1@1x0.1x0.08,hex", "--element=solid", "--quiet"},
                             {"beam:6x1x1@1x0.01x0.3,hex", "--element=shell", "--quiet"},
                             {"beam:6x1x1@1x0.1x0.08", "--order=2", "--spring=x>0.99:200"}};
  for (int n = 0; n < 3; n++) {
    frequency_gradient found;
    const thrum_model *model = bar_of(bars[n], 1e6, 0.3, 1000);
    assert_int_equal(frequency_gradient_find(model, MODES, &found, NULL), THRUM_OK);
    const thrum_model *of[2][2] = {
        {bar_of(bars[n], 0.999e6, 0.3, 1000), bar_of(bars[n], 1.001e6, 0.3, 1000)},
        {bar_of(bars[n], 1e6, 0.299, 1000), bar_of(bars[n], 1e6, 0.301, 1000)}};
    for (int i = 0; i < MODES; i++) {
      const double young = log(of[0][1]->omega2[i] / of[0][0]->omega2[i]) / (2 * 0.002);
      const double poisson = log(of[1][1]->omega2[i] / of[1][0]->omega2[i]) / (2 * 0.002);
      assert_true(fabs(found.young[i] - young) < 1e-5);
      assert_true(fabs(found.poisson[i] - poisson) < 1e-4 * fabs(poisson) + 1e-6);
      assert_true(n == 2 || fabs(found.young[i] - 0.5) < 1e-9);
    }
    assert_true(n < 2 || found.young[0] < 0.4);
    frequency_gradient_free(&found);
    for (int k = 0; k < 4; k++)
      thrum_model_destroy(of[k / 2][k % 2]);
    thrum_model_destroy(model);
  }
}

static void derivatives_are_those_of_the_mesh(void **state) {
  (void)state;
  frequency_gradient found;
  const thrum_model *model = beam_of(1e6, 0.3, 1000);
  assert_int_equal(frequency_gradient_find(model, MODES, &found, NULL), THRUM_OK);
  assert_int_equal(found.modes, MODES);
  const thrum_model *less = beam_of(1e6, 0.299, 1000), *more = beam_of(1e6, 0.301, 1000);
  for (int i = 0; i < MODES; i++) {
    // of one region a frequency goes as the root of E over rho
    assert_true(fabs(found.young[i] - 0.5) < 1e-9);
    assert_true(fabs(found.density[i] + 0.5) < 1e-9);
    const double differences = log(more->omega2[i] / less->omega2[i]) / (2 * 0.002);
    assert_true(fabs(found.poisson[i] - differences) < 1e-4 * fabs(differences) + 1e-6);
  }
  frequency_gradient_free(&found);
  thrum_model_destroy(less);
  thrum_model_destroy(more);
  thrum_model_destroy(model);
}

/* Regions share what the whole has, and modes of one frequency share their sum. */
static void shares_add_up(void **state) {
  (void)state;
  frequency_gradient found, paired;
  const thrum_model *loaded = beam_of(1e6, 0, 1000);
  thrum_model model = *loaded;
  double material[6], omega2[MODES];
  int32_t *region = random_alloc(model.tet_count, sizeof *region);
  for (int64_t t = 0; t < model.tet_count; t++)
    region[t] = t < model.tet_count / 3 ? 0 : 1;
  memcpy(material, loaded->material, 3 * sizeof *material);
  memcpy(material + 3, loaded->material, 3 * sizeof *material);
  memcpy(omega2, loaded->omega2, sizeof omega2);
  model.region_count = 2;
  model.tet_region = region;
  model.material = material;
  model.omega2 = omega2;
  assert_int_equal(frequency_gradient_find(&model, MODES, &found, NULL), THRUM_OK);
  for (int i = 0; i < MODES; i++) {
    assert_true(fabs(found.young[2 * i] + found.young[2 * i + 1] - 0.5) < 1e-9);
    assert_true(fabs(found.density[2 * i] + found.density[2 * i + 1] + 0.5) < 1e-9);
    assert_true(found.young[2 * i] > 0 && found.young[2 * i + 1] > 0);
    assert_true(isfinite(found.poisson[2 * i]));
  }

  // as if the first two had one frequency
  omega2[1] = omega2[0];
  assert_int_equal(frequency_gradient_find(&model, MODES, &paired, NULL), THRUM_OK);
  const double trace = found.young[0] + found.young[2] * loaded->omega2[1] / omega2[0];
  assert_true(fabs(paired.young[0] + paired.young[2] - trace) < 1e-9);
  assert_true(paired.young[0] <= paired.young[2]);

  // without a mesh there is nothing to change
  model.tets = NULL;
  frequency_gradient none;
  assert_int_equal(frequency_gradient_find(&model, MODES, &none, NULL), THRUM_MISSING);
  frequency_gradient_free(&none);
  frequency_gradient_free(&found);
  frequency_gradient_free(&paired);
  free(region);
  thrum_model_destroy(loaded);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(derivatives_are_those_of_the_mesh),
      cmocka_unit_test(elements_with_rows_and_springs_have_theirs),
      cmocka_unit_test(shares_add_up),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
