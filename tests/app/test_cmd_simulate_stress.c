/* Tests of `thrum simulate --stress` and its monitors: the peak is that of the recorded states,
 * warnings are printed and change no step, and a model without a mesh has neither.
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/file.h"
#include "io/npy_file.h"
#include "tests/support/linear_fields.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !save_oscillator(in_folder("duffing.npz"), 400, 1e4))
    return 1;
  return !precompute_beam("8x2x2@1x0.1x0.1", "5", "10");
}

static cJSON *member(const cJSON *object, const char *key) {
  cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_non_null(item);
  return item;
}

static cJSON *json_of(program_result *run) {
  if (run->exit_code != 0)
    print_error("exit code %d: %s", run->exit_code, run->err);
  assert_int_equal(run->exit_code, 0);
  cJSON *object = json_line(run->out);
  assert_non_null(object);
  return object;
}

static void the_peak_stress_is_that_of_the_recorded_states(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "run", "--json", "--time", "0.6", "--load",
                "impulse:0,0,-40@tip", "--stress", "--frames", "every-50", NULL);

  cJSON *object = json_of(&run);
  cJSON *stress = member(object, "stress"), *monitor = member(object, "monitor");

  // the recorded coordinates, from which the library reads the stress again
  const thrum_model *model = NULL;
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &model, NULL), 0);
  double *q = NULL;
  int64_t rows = 0, rank = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder("run/q.npy"), &q, &rows, &rank, NULL), 0);
  assert_int_equal(rank, model->rank);
  assert_int_equal(rows, 201);

  // the largest stress and the least stretch of all tetrahedra and rows
  const thrum_stress_points *stress_points = stress_points_make(model, NULL, 0);
  double *mises = need((size_t)model->tet_count, sizeof *mises), peak = -1;
  double *stretch = need((size_t)model->tet_count, sizeof *stretch), least = 1;
  const thrum_stress_points_output output = {.von_mises = mises, .stretch = stretch};

  int64_t tet = 0, row = 0;
  for (int64_t k = 0; k < rows; k++) {
    assert_int_equal(thrum_stress_points_read(stress_points, q + k * rank, NULL, &output, NULL),
                     THRUM_OK);
    for (int64_t n = 0; n < model->tet_count; n++) {
      least = fmin(least, stretch[n]);
      if (mises[n] > peak) {
        peak = mises[n];
        tet = n;
        row = k;
      }
    }
  }

  // peak, place and time of the centres are those; tetrahedra are counted from 1
  assert_true(json_value(stress, "centre_peak_von_mises_pa") == peak);
  assert_true(json_value(stress, "centre_peak_tet") == (double)tet + 1);
  assert_close(json_value(stress, "centre_peak_time_s"), 0.003 * (double)row, 1e-12);

  // that of the nodes of this mesh of linear tetrahedra is called what it is, and has its place
  assert_string_equal(member(stress, "kind")->valuestring, "patch average");
  const int64_t vertex = (int64_t)json_value(stress, "peak_vertex") - 1;
  for (int axis = 0; axis < 3; axis++)
    assert_true(cJSON_GetArrayItem(member(stress, "peak_place_m"), axis)->valuedouble ==
                model->vertices[3 * vertex + axis]);
  assert_true(json_value(stress, "peak_region") == 1);
  const double nodes = json_value(stress, "peak_von_mises_pa");
  assert_true(nodes > 0.3 * peak && nodes <= peak);

  // the sampled tets of this beam are a part of its tets, and see nearly the worst of them
  const double seen = json_value(monitor, "least_stretch");
  assert_true(seen >= least && 1 - seen > 0.8 * (1 - least));
  assert_int_equal(cJSON_GetArraySize(member(monitor, "warnings")), 0);
  assert_true(json_value(monitor, "load_share_outside") > 0.5);

  // every frame has the stress
  for (int frame = 0; frame < 5; frame++) {
    char name[64];
    snprintf(name, sizeof name, "run/frames/frame_%06d.vtu", frame);
    void *bytes = NULL;
    size_t size = 0;
    assert_int_equal(thrum_file_read(in_folder(name), &bytes, &size, NULL), 0);
    assert_non_null(strstr(bytes, "Name=\"von_mises_centre\""));
    assert_non_null(strstr(bytes, "Name=\"von_mises_patch_average\""));
    free(bytes);
  }

  free(stretch);
  free(mises);
  stress_points_free(stress_points);
  free(q);
  thrum_model_destroy(model);
  cJSON_Delete(object);
  program_result_free(&run);
}

static void a_body_pushed_too_far_is_warned_of_and_steps_as_it_would(void **state) {
  (void)state;
  const char *const load = "square:0,0,-400@tip";
  program_result on = thrum_run(folder, "simulate", "beam.npz", "-o", "on", "--json", "--time",
                                "0.3", "--load", load, "-q", "--accept-error", "100%", NULL);
  program_result off = thrum_run(folder, "simulate", "beam.npz", "-o", "off", "--json", "--time",
                                 "0.3", "--load", load, "-q", "--monitor", "off", NULL);

  cJSON *object = json_of(&on), *quiet = json_of(&off);

  // the body moves further than its basis can follow the mesh
  assert_true(json_value(member(object, "error_estimate"), "share") > 0.1);
  assert_true(cJSON_IsNull(member(quiet, "error_estimate")));

  // without the monitor nothing is said
  assert_true(cJSON_IsNull(member(quiet, "monitor")));
  assert_true(cJSON_IsNull(member(quiet, "stress")));
  assert_null(strstr(off.err, "the basis"));

  // the monitor changes no step: both runs have the same energies
  char *with = text_file_read(in_folder("on/energy.csv"));
  char *without = text_file_read(in_folder("off/energy.csv"));
  assert_string_equal(with, without);

  free(with);
  free(without);
  cJSON_Delete(object);
  cJSON_Delete(quiet);
  program_result_free(&on);
  program_result_free(&off);
}

static void a_model_without_a_mesh_has_no_stress_and_no_monitor(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "duffing.npz", "-o", "bare", "--json",
                                 "--time", "0.1", "-q", NULL);

  // without a mesh the monitor is left out
  cJSON *object = json_of(&run);
  assert_true(cJSON_IsNull(member(object, "monitor")));
  cJSON_Delete(object);
  program_result_free(&run);

  // stress that is asked for cannot be left out, so it is refused
  run = thrum_run(folder, "simulate", "duffing.npz", "-o", "refused", "--stress", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "--stress"));
  assert_true(line_count_is(run.err, 1));
  assert_false(file_exists(in_folder("refused")));
  program_result_free(&run);

  // the monitor is on or off
  run = thrum_run(folder, "simulate", "beam.npz", "-o", "refused", "--monitor", "maybe", NULL);
  assert_int_equal(run.exit_code, 2);
  program_result_free(&run);
}

/* The largest von Mises stress of a run of one short step from a bent shape. */
static double first_peak(const char *how, const char *law) {
  program_result run =
      thrum_run(folder, "simulate", "beam.npz", "-o", "bent", "--start", "mode:1,0.05", "--dt",
                "1e-6", "--time", "1e-6", "--stress", "--json", "-q", how, law, NULL);
  cJSON *object = json_of(&run);
  const double peak = member(member(object, "stress"), "peak_von_mises_pa")->valuedouble;
  cJSON_Delete(object);
  program_result_free(&run);
  return peak;
}

static void the_full_order_has_the_stress_of_its_own_displacements(void **state) {
  (void)state;

  // the same shape, in a model's coordinates and as displacements of the mesh
  const double reduced = first_peak(NULL, NULL), full = first_peak("--full", NULL);
  assert_true(reduced > 0 && fabs(full / reduced - 1) < 1e-5);

  // another law has another stress there, which is that of its tetrahedra
  const double other = first_peak("--full", "--law=neo-hookean");
  assert_true(other > 0 && fabs(other / full - 1) > 1e-4 && fabs(other / full - 1) < 0.5);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_peak_stress_is_that_of_the_recorded_states),
      cmocka_unit_test(the_full_order_has_the_stress_of_its_own_displacements),
      cmocka_unit_test(a_body_pushed_too_far_is_warned_of_and_steps_as_it_would),
      cmocka_unit_test(a_model_without_a_mesh_has_no_stress_and_no_monitor),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
