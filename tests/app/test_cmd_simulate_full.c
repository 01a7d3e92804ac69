/* `thrum simulate --full` is compared with the reduced model, and refuses what it cannot do.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/npy_file.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !save_oscillator(in_folder("duffing.npz"), 400, 1e4))
    return 1;
  return !precompute_beam("6x1x1@1x0.2x0.2", "5", "15");
}

/* Runs into `run` with up to ten more arguments; the caller frees the JSON. */
static cJSON *simulate(const char *run_name, const char *const *more) {
  const char *a[10] = {NULL};
  for (int n = 0; n < 10 && more[n] != NULL; n++)
    a[n] = more[n];
  program_result run = thrum_run(folder, "simulate", "beam.npz", "-o", run_name, "--json", "-q",
                                 a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7], a[8], a[9], NULL);
  if (run.exit_code != 0)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

#define SIMULATE(run_name, ...) simulate(run_name, (const char *const[11]){__VA_ARGS__})

static double *read_q(const char *name, int64_t *rows) {
  double *values = NULL;
  int64_t columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder(name), &values, rows, &columns, NULL), 0);
  assert_int_equal(columns, 15);
  return values;
}

/* A small swing is the same in both models: the full order has no modes whose frequency it could
 * match. */
static void a_small_swing_is_that_of_the_reduced_model(void **state) {
  (void)state;
  int64_t rows = 0, other = 0;
  cJSON *reduced = SIMULATE("reduced", "--time", "0.3", "--start", "mode:1,1e-6", "--integrator",
                            "energy", "--frequency-matching", "off");
  cJSON *full = SIMULATE("full", "--time", "0.3", "--start", "mode:1,1e-6", "--full");

  double *q = read_q("reduced/q.npy", &rows), *whole = read_q("full/q.npy", &other);
  assert_int_equal(rows, other);

  // both have the same coordinates, beside the largest of them
  double size = 0;
  for (int64_t k = 0; k < 15 * rows; k++)
    size = fmax(size, fabs(q[k]));
  for (int64_t k = 0; k < 15 * rows; k++)
    assert_true(fabs(q[k] - whole[k]) <= 1e-4 * size);

  // energies agree too, and the full order keeps its own
  const double energy = json_value(full, "energy_first_j");
  assert_true(fabs(energy - json_value(reduced, "energy_first_j")) <= 1e-6 * energy);
  assert_true(fabs(json_value(full, "energy_last_j") - energy) <= 1e-9 * energy);

  // three for each of the 6 x 4 vertices that move
  const cJSON *about = cJSON_GetObjectItemCaseSensitive(full, "full");
  assert_true(json_value(about, "components") == 72);
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(reduced, "full")));

  free(q);
  free(whole);
  cJSON_Delete(reduced);
  cJSON_Delete(full);
}

/* Loads, the base's motion and a start act on both alike while the motion is small. */
static void loads_and_base_motion_act_as_on_the_reduced_model(void **state) {
  (void)state;
  static const char *const what[][4] = {
      {"--load", "gravity:0,0,-0.001", NULL, NULL},
      {"--load", "sine:0,0,-0.001@tip,f=3", "--damping", "0.5,0.001"},
      {"--base-motion", "sine:0,0,0.001,f=2", NULL, NULL},
  };
  for (int n = 0; n < 3; n++) {
    int64_t rows = 0, other = 0;
    cJSON *reduced = SIMULATE("reduced", "--time", "0.4", "--integrator", "energy", what[n][0],
                              what[n][1], what[n][2], what[n][3]);
    cJSON *full =
        SIMULATE("full", "--time", "0.4", "--full", what[n][0], what[n][1], what[n][2], what[n][3]);

    double *q = read_q("reduced/q.npy", &rows), *whole = read_q("full/q.npy", &other);

    // the largest coordinate is the measure of what differs
    double size = 0;
    for (int64_t k = 0; k < 15 * rows; k++)
      size = fmax(size, fabs(q[k]));
    assert_true(size > 0 && rows == other);

    // the lowest two coordinates are compared: derivatives are no modes, so what lies outside the
    // basis moves them too
    for (int64_t k = 0; k < 15 * rows; k++)
      assert_true(k % 15 >= 2 || fabs(q[k] - whole[k]) <= 0.01 * size);

    // without damping the balance of energy closes to the tolerance of the steps
    if (n != 1) {
      const cJSON *work = cJSON_GetObjectItemCaseSensitive(full, "work");
      assert_true(fabs(json_value(work, "balance_j")) <= 1e-9 * json_value(full, "energy_max_j"));
    }

    free(q);
    free(whole);
    cJSON_Delete(reduced);
    cJSON_Delete(full);
  }
}

/* Small swings do not depend on the law, as all have the same moduli there; each keeps its energy.
 */
static void each_law_swings_as_linear_elasticity_where_swings_are_small(void **state) {
  (void)state;
  static const char *const laws[] = {"stvk", "corotational", "neo-hookean"};
  double *q[3], size = 0;
  int64_t rows = 0;
  for (int n = 0; n < 3; n++) {
    cJSON *object =
        SIMULATE("law", "--full", "--law", laws[n], "--time", "0.3", "--start", "mode:1,1e-5");
    const double energy = json_value(object, "energy_first_j");
    assert_true(fabs(json_value(object, "energy_last_j") - energy) <= 1e-9 * energy);
    q[n] = read_q("law/q.npy", &rows);
    cJSON_Delete(object);
  }

  // beside the largest coordinate; a law is not another, so some digit differs
  bool differ = false;
  for (int64_t k = 0; k < 15 * rows; k++)
    size = fmax(size, fabs(q[0][k]));
  for (int n = 1; n < 3; n++)
    for (int64_t k = 0; k < 15 * rows; k++) {
      assert_true(fabs(q[n][k] - q[0][k]) <= 1e-3 * size);
      differ = differ || q[n][k] != q[0][k];
    }
  assert_true(differ);
  for (int n = 0; n < 3; n++)
    free(q[n]);

  // a model knows one law, and says so in one line
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "none", "--law", "neo-hookean", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "--law goes with --full"));
  assert_true(line_count_is(run.err, 1));
  program_result_free(&run);
}

static void plastic_flow_is_in_the_balance_of_energy(void **state) {
  (void)state;
  cJSON *object = SIMULATE("flow", "--full", "--law", "corotational", "--yield", "0.01", "--time",
                           "0.4", "--load", "impulse:0,0,-30000@tip");
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const double lost = json_value(work, "dissipated_j"), load = json_value(work, "load_j");
  assert_true(lost > 0.01 * load && lost == json_value(work, "plastic_j"));
  assert_true(fabs(json_value(work, "balance_j")) <= 1e-9 * load);
  assert_true(json_value(object, "plastic_strain") > 0.001);

  // the table says it too, and a monitor of reduced coordinates is refused
  program_result run = thrum_run(folder, "simulate", "beam.npz", "--full", "--yield", "0.01",
                                 "--time", "0.01", "-q", "-o", "table", NULL);
  assert_non_null(strstr(run.out, "material     stvk, flows beyond a strain of 0.01: 0 J taken"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "beam.npz", "--full", "--monitor", "on", "-o", "none", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "--monitor is of a reduced model"));
  program_result_free(&run);

  // 100 rows of free motion, whose loss to the flow is no drift
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "drift")));
  cJSON_Delete(object);
}

static void a_body_in_equilibrium_stays_and_frames_show_it(void **state) {
  (void)state;
  cJSON *object = SIMULATE("rest", "--full", "--time", "0.1", "--start", "static:gravity:0,0,-9.81",
                           "--load", "gravity:0,0,-9.81");

  // the energy of the equilibrium stays what it is
  const double energy = json_value(object, "energy_first_j");
  assert_true(energy > 0.1);
  assert_true(fabs(json_value(object, "energy_max_j") - energy) <= 1e-9 * energy);
  cJSON_Delete(object);

  // the explicit integrator stays below its stability bound, and writes its frames
  object = SIMULATE("shown", "--full", "--time", "0.05", "--dt", "0.0002", "--integrator", "verlet",
                    "--frames", "every-100");
  assert_true(file_exists(in_folder("shown/frames/frame_000002.vtu")));
  const cJSON *about = cJSON_GetObjectItemCaseSensitive(object, "full");
  assert_true(json_value(about, "dt_stable") > 0.0002);
  cJSON_Delete(object);
}

static void what_damping_takes_has_no_figure_and_is_not_printed_as_one(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "damped", "--full", "--time", "0.03",
                "--load", "gravity:0,0,-1", "--damping", "0.5,0.001", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "dissipation by damping not counted"));
  assert_null(strstr(run.out, "nan"));
  program_result_free(&run);
}

static void options_that_need_the_reduced_model_are_refused(void **state) {
  (void)state;
  static const struct {
    int code;
    const char *says, *model, *arguments[3];
  } cases[] = {
      {2, "imexv", "beam.npz", {"--integrator", "imexv"}},
      {2, "rest only", "beam.npz", {"--damping-form", "tangent"}},
      {2, "--stress is of a material that does not flow", "beam.npz", {"--stress", "--yield=0.1"}},
      {1, "wants a --yield", "beam.npz", {"--creep", "2"}},
      {2, "--yield wants a number above 0", "beam.npz", {"--yield", "-0.1"}},
      {2, "cholesky or cg", "beam.npz", {"--linear-solver", "lu"}},
      {1, "not stable at dt = 0.1", "beam.npz", {"--integrator=verlet", "--dt", "0.1"}},
      {1, "no basis", "duffing.npz", {NULL}},
  };

  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    // the message is one line, and no folder is left
    const char *const *a = cases[n].arguments;
    program_result run = thrum_run(folder, "simulate", cases[n].model, "-o", "none", "--full", a[0],
                                   a[1], a[2], NULL);
    if (run.exit_code != cases[n].code || strstr(run.err, cases[n].says) == NULL)
      fail_msg("case %d: exit %d: %s", (int)n, run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    assert_false(file_exists(in_folder("none")));
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_small_swing_is_that_of_the_reduced_model),
      cmocka_unit_test(loads_and_base_motion_act_as_on_the_reduced_model),
      cmocka_unit_test(each_law_swings_as_linear_elasticity_where_swings_are_small),
      cmocka_unit_test(plastic_flow_is_in_the_balance_of_energy),
      cmocka_unit_test(a_body_in_equilibrium_stays_and_frames_show_it),
      cmocka_unit_test(what_damping_takes_has_no_figure_and_is_not_printed_as_one),
      cmocka_unit_test(options_that_need_the_reduced_model_are_refused),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
