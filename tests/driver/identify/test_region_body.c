/* Tests of the shares of regions: their sum is the mesh of other materials, and a motion of such a
 * body tells the materials of both regions.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "driver/identify/identify_fit.h"
#include "precompute/model/model_fem.h"
#include "tests/support/random_model.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

enum { ROWS = 150, MODES = 3 };

/* The beam of the folder with two regions: the half at the wall and the other. */
typedef struct beam {
  const thrum_model *loaded;
  thrum_model model;
  int32_t *region;
  double material[6];
} beam;

static int make_beam(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return 1;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x1x1@1x0.1x0.08", "--order", "2", "--fix", "x<0.001",
                "--young", "1e6", "--poisson", "0.3", "--density", "1000", "--modes", "3", "--rank",
                "8", "-o", "beam.npz", "-q", NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

static void beam_open(beam *b) {
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &b->loaded, NULL), THRUM_OK);
  b->model = *b->loaded;
  b->region = random_alloc(b->model.tet_count, sizeof *b->region);
  for (int64_t t = 0; t < b->model.tet_count; t++) {
    const int32_t *v = b->model.tets + 4 * t;
    double x = 0;
    for (int i = 0; i < 4; i++)
      x += b->model.vertices[3 * v[i]] / 4;
    b->region[t] = x < 0.5 ? 0 : 1;
  }
  memcpy(b->material, b->loaded->material, 3 * sizeof(double));
  memcpy(b->material + 3, b->loaded->material, 3 * sizeof(double));
  b->model.region_count = 2;
  b->model.tet_region = b->region;
  b->model.material = b->material;
}

static void beam_close(beam *b) {
  free(b->region);
  thrum_model_destroy(b->loaded);
}

static void regions_add_up_to_the_mesh_of_their_moduli(void **state) {
  (void)state;
  static const double factors[2] = {1.3, 0.7};
  beam b;
  region_shares shares;
  region_body body;
  thrum_error error;
  beam_open(&b);
  const int64_t r = b.model.rank;
  if (region_shares_open(&b.model, false, &shares, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(shares.count, 2);
  for (int n = 0; n < 6; n++)
    shares.values[n] *= n % 3 < 2 ? factors[n / 3] : 1;
  if (region_body_make(&shares, shares.values, &body, &error) < 0)
    fail_msg("%s", error.message);

  // the mesh of these moduli, at u = U q
  thrum_model_fem fem = {0};
  b.material[0] *= factors[0];
  b.material[3] *= factors[1];
  assert_int_equal(thrum_model_fem_elements(&b.model, &fem, &error), THRUM_OK);
  random_state random = {2};
  double *u = random_alloc(3 * b.model.vertex_count, sizeof *u), x[16], q[16] = {0};
  double *work = random_alloc((int64_t)thrum_work_count(&body.model), sizeof *work);
  random_vector(&random, r, 0.05, x);
  for (int64_t i = 0; i < r; i++)
    for (int64_t j = 0; j < r; j++)
      q[i] += body.turn[i * r + j] * x[j];
  for (int64_t c = 0; c < 3 * b.model.vertex_count; c++)
    for (int64_t i = 0; i < r; i++)
      u[c] += b.model.basis[c * r + i] * q[i];
  const double full = thrum_fem_energy(&fem.fem, u, NULL);
  assert_true(fabs(thrum_strain_energy(&body.model, x, work) / full - 1) < 1e-9);

  // and by the parts
  double parts = 0;
  for (int n = 0; n < 6; n++) {
    const double share = n % 3 < 2 ? shares.values[n] : 0;
    parts += share * thrum_strain_energy(body.parts[n].form, x, work);
    for (int64_t i = 0; i < r * r; i++)
      parts += share * 0.5 * body.parts[n].linear[i] * x[i / r] * x[i % r];
  }
  assert_true(fabs(parts / full - 1) < 1e-9);
  free(u);
  free(work);
  thrum_model_fem_free(&fem);
  region_body_free(&body);
  region_shares_close(&shares);
  beam_close(&b);
}

/* A ring-down of the body with other values, seen at its end, as a file. */
static void record(const beam *b, const region_shares *shares, const double *values, double dt) {
  region_body body;
  thrum_state *state = NULL;
  const int64_t r = b->model.rank;
  assert_int_equal(region_body_make(shares, values, &body, NULL), THRUM_OK);
  double damping[16], start[16] = {0}, x[16], q[16];
  // what is no linear mode has the rate of the slowest
  for (int64_t i = 0; i < r; i++)
    damping[i] = 2 * 0.02 * sqrt(body.model.omega2[i < MODES ? i : 0]);
  body.model.damping = damping;
  thrum_mode_add(&b->model, 0, 0.05, start, NULL);
  thrum_mode_add(&b->model, 2, 0.01, start, NULL);
  for (int64_t j = 0; j < r; j++) {
    x[j] = 0;
    for (int64_t i = 0; i < r; i++)
      x[j] += body.back[j * r + i] * start[i];
  }
  thrum_state_def def = thrum_default_state_def();
  def.dt = dt;
  def.tolerance = 1e-10;
  assert_int_equal(thrum_state_create(&body.model, &def, &state, NULL), THRUM_OK);
  assert_int_equal(thrum_state_set(&body.model, state, x, NULL, NULL), THRUM_OK);

  load_target target;
  load_vertices at = {0};
  assert_int_equal(load_target_parse("near:1,0.05,0", "--at", &target, NULL), THRUM_OK);
  assert_int_equal(load_target_find(&b->model, &target, &at, NULL), THRUM_OK);
  FILE *file = fopen(in_folder("ring.csv"), "w");
  assert_non_null(file);
  fputs("time_s,near:1 0.05 0.y_m,near:1 0.05 0.z_m\n", file);
  for (int n = 0; n < ROWS; n++) {
    double mean[3];
    assert_int_equal(thrum_state_get(&body.model, state, x, NULL, NULL), THRUM_OK);
    for (int64_t i = 0; i < r; i++) {
      q[i] = 0;
      for (int64_t j = 0; j < r; j++)
        q[i] += body.turn[i * r + j] * x[j];
    }
    thrum_displacement_mean(&b->model, at.list, at.count, q, mean, NULL);
    fprintf(file, "%.17g,%.17g,%.17g\n", n * 4 * dt, mean[1], mean[2]);
    assert_true(thrum_steps(&body.model, state, 4, NULL, NULL) >= 0);
  }
  assert_int_equal(fclose(file), 0);
  load_vertices_free(&at);
  thrum_state_destroy(state);
  region_body_free(&body);
}

/* Fits what the request names, with its dt, to a recording of a body of these materials (E, nu and
 * density of each region), and finds what was recorded. */
static void find(identify_request request, const double *material, const double *truth,
                 int64_t count) {
  beam b;
  region_shares shares;
  thrum_error error;
  double values[6];
  beam_open(&b);
  assert_int_equal(region_shares_open(&b.model, true, &shares, NULL), THRUM_OK);
  for (int g = 0; g < 2; g++) {
    const double *m = material + 3 * g;
    values[3 * g] = m[0] * m[1] / ((1 + m[1]) * (1 - 2 * m[1]));
    values[3 * g + 1] = m[0] / (2 * (1 + m[1]));
    values[3 * g + 2] = m[2];
  }
  record(&b, &shares, values, request.dt);
  region_shares_close(&shares);

  // steps as those of the recording, so that it can be met exactly
  start_spec starts[2];
  assert_int_equal(start_spec_parse("mode:1,0.05", &starts[0], NULL), THRUM_OK);
  assert_int_equal(start_spec_parse("mode:3,0.01", &starts[1], NULL), THRUM_OK);
  char path[128];
  snprintf(path, sizeof path, "%s", in_folder("ring.csv"));
  request.recording_path = path;
  request.ratio = true;
  request.ratio_count = 1;
  request.start_modes = 1;
  request.starts = starts;
  request.start_count = 2;
  request.iterations = 40;
  identify_fit fit;
  if (identify_fit_open(&request, &b.model, &fit, &error) < 0 || identify_fit_run(&fit, &error) < 0)
    fail_msg("%s", error.message);
  assert_true(fit.converged);
  assert_int_equal(fit.count, count);
  for (int64_t n = 0; n < count; n++)
    if (!(fabs(fit.parameters[n].value / truth[n] - 1) < 1e-4))
      fail_msg("%s: %.9g, not %g", fit.parameters[n].name, fit.parameters[n].value, truth[n]);
  assert_true(fit.rms < 1e-6 * fit.motion);
  identify_fit_close(&fit);
  beam_close(&b);
}

static void a_motion_tells_the_moduli_of_both_regions(void **state) {
  (void)state;
  const identify_request request = {.dt = 0.004, .young = true};
  find(request, (const double[]){1.2e6, 0.3, 1000, 0.85e6, 0.3, 1000},
       (const double[]){1.2e6, 0.85e6, 0.02}, 3);
}

static void a_motion_tells_poissons_ratios_and_densities(void **state) {
  (void)state;
  const identify_request density = {.dt = 0.004, .density = true};
  const identify_request poisson = {.dt = 0.0005, .poisson = true};
  find(density, (const double[]){1e6, 0.3, 1100, 1e6, 0.3, 930}, (const double[]){1100, 930, 0.02},
       3);
  find(poisson, (const double[]){1e6, 0.32, 1000, 1e6, 0.33, 1000},
       (const double[]){0.32, 0.33, 0.02}, 3);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(regions_add_up_to_the_mesh_of_their_moduli),
      cmocka_unit_test(a_motion_tells_the_moduli_of_both_regions),
      cmocka_unit_test(a_motion_tells_poissons_ratios_and_densities),
  };
  return cmocka_run_group_tests(tests, make_beam, remove_folder);
}
