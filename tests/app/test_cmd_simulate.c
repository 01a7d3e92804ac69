/* Tests of `thrum simulate` as a command: the effect of loads and starts, and the contents of a
 * run's files. The loads
 * act on a body without strain energy, whose momentum must be the integral of the force.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/file.h"
#include "io/npy_file.h"
#include "tests/support/program_object.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"
#include "thrum/displacement.h"
#include "thrum/external_load.h"
#include "thrum/polynomial.h"

static const double pi = 3.14159265358979323846;
static const char *const integrators[] = {"imexv", "newmark", "verlet", "midpoint"};

static int make_models(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL || !save_particle(in_folder("particle.npz"), 0, 0) ||
      !save_oscillator(in_folder("duffing.npz"), 400, 1e4) ||
      !save_npy(in_folder("start.npy"), (const double[]){0.1, 0.5}, 2, 1))
    return 1;
  return !precompute_beam("8x2x2@1x0.1x0.1", "5", "10");
}

/* Runs into the folder "run" with up to ten more arguments, asserts the exit code and returns the
 * JSON. */
static cJSON *simulate_code(int code, const char *model, const char *const *more) {
  const char *arguments[10] = {NULL};
  for (int n = 0; n < 10 && more[n] != NULL; n++)
    arguments[n] = more[n];

  // a list that ends early leaves NULLs, which end the argument list
  program_result run =
      thrum_run(folder, "simulate", model, "-o", "run", "--json", arguments[0], arguments[1],
                arguments[2], arguments[3], arguments[4], arguments[5], arguments[6], arguments[7],
                arguments[8], arguments[9], NULL);
  return program_object(run, code);
}

#define SIMULATE(model, ...) simulate_code(0, model, (const char *const[11]){__VA_ARGS__})

static const char *text_of(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_true(cJSON_IsString(item));
  return item->valuestring;
}

/* Reads an array of "run" that must have this shape; the caller frees it. */
static double *read_array(const char *name, int64_t rows, int64_t columns) {
  char file[64];
  double *values = NULL;
  int64_t got_rows = 0, got_columns = 0;
  snprintf(file, sizeof file, "run/%s", name);
  assert_int_equal(thrum_npy_read_f8(in_folder(file), &values, &got_rows, &got_columns, NULL), 0);
  assert_int_equal(got_rows, rows);
  assert_int_equal(got_columns, columns);
  return values;
}

static energy_row *read_rows(int64_t expected) {
  int64_t count = 0;
  energy_row *rows = read_energies(in_folder("run/energy.csv"), &count);
  assert_non_null(rows);
  assert_int_equal(count, expected);
  return rows;
}

static void assert_near(double value, double expected, double tolerance) {
  if (!(fabs(value - expected) <= tolerance))
    print_error("%.17g is not %.17g within %g\n", value, expected, tolerance);
  assert_true(fabs(value - expected) <= tolerance);
}

/* Runs the load on the free particle with an integrator and a time step; its momentum at the end
 * must be U^T f times `integral`, the load's time integral per newton. */
static void assert_momentum(const char *integrator, const char *dt, const char *load,
                            const double reduced[2], double integral) {
  cJSON *object = SIMULATE("particle.npz", "--integrator", integrator, "--dt", dt, "--load", load,
                           "--time", "1.2");
  assert_string_equal(text_of(object, "status"), "done");
  cJSON_Delete(object);
  double *end = read_array("end.npy", 2, PARTICLE_RANK);
  for (int i = 0; i < PARTICLE_RANK; i++)
    assert_near(end[PARTICLE_RANK + i], reduced[i] * integral, 1e-9 * (1 + fabs(reduced[i])));
  free(end);
}

static void an_impulse_gives_force_times_duration_at_every_time_step(void **state) {
  (void)state;
  static const char *const steps[] = {"0.003", "0.001", "0.002", "0.01"};

  // rows z of vertex 4 times -40 N
  const double reduced[2] = {-40 * 0.7, -40 * 0.9};
  for (int n = 0; n < 4; n++) {
    for (int k = 0; k < 4; k++)
      assert_momentum(integrators[n], steps[k], "impulse:0,0,-40@vertex=4", reduced, 0.003);
  }
  assert_momentum("imexv", "0.003", "impulse:0,0,-40@tip,until=0.006", reduced, 0.006);
  assert_momentum("imexv", "0.003", "impulse:0,0,-40@tip,from=0.3", reduced, 0.003);
}

static void square_and_constant_loads_act_within_their_window(void **state) {
  (void)state;
  const double reduced[2] = {0.5 * 6, 0};
  for (int n = 0; n < 4; n++) {
    const char *name = integrators[n];
    assert_momentum(name, "0.003", "square:6,0,0@vertex=2", reduced, 0.3);
    assert_momentum(name, "0.01", "square:6,0,0@vertex=2,until=0.5,from=0.1", reduced, 0.4);
    assert_momentum(name, "0.003", "constant:6,0,0@vertex=2", reduced, 1.2);
    assert_momentum(name, "0.003", "constant:6,0,0@vertex=2,from=0.25", reduced, 0.95);
  }
}

static void a_sine_gives_the_integral_of_its_sine(void **state) {
  (void)state;

  // row y of vertex 3
  const double reduced[2] = {0, 0.5};
  const double f = 2, omega = 2 * pi * f;
  for (int n = 0; n < 4; n++) {
    const char *name = integrators[n];
    assert_momentum(name, "0.003", "sine:0,1,0@vertex=3,f=2", reduced,
                    (1 - cos(omega * 1.2)) / omega);
    assert_momentum(name, "0.01", "sine:0,1,0@vertex=3,f=2,until=0.25", reduced, 2 / omega);
    assert_momentum(name, "0.003", "sine:0,1,0@vertex=3,from=0.5,f=2", reduced,
                    (1 - cos(omega * 0.7)) / omega);
  }
}

static void gravity_pulls_each_coordinate_by_its_axis_mass(void **state) {
  (void)state;
  const double reduced[2] = {-9.81 * 0.7 + 1.5, -9.81 * -0.3};
  for (int n = 0; n < 4; n++)
    assert_momentum(integrators[n], "0.003", "gravity:1,0,-9.81", reduced, 1.2);
}

static void a_force_is_shared_equally_by_the_vertices_of_its_target(void **state) {
  (void)state;

  // z rows: 0 and (0.1, 0.3), (0.2, -0.4), (0.7, 0.9); held vertices count as sharers
  const double group[2] = {12.0 / 3 * (0.1 + 0.7), 12.0 / 3 * (0.3 + 0.9)};
  const double all[2] = {12.0 / 4 * (0.1 + 0.2 + 0.7), 12.0 / 4 * (0.3 - 0.4 + 0.9)};
  assert_momentum("imexv", "0.003", "constant:0,0,12@a, b", group, 1.2);
  assert_momentum("imexv", "0.003", "constant:0,0,12@a, b,until=0.6", group, 0.6);
  assert_momentum("imexv", "0.003", "constant:0,0,12@all", all, 1.2);
}

static void loads_add_up(void **state) {
  (void)state;
  cJSON *object = SIMULATE("particle.npz", "--time", "0.6", "--load", "constant:3,0,0@vertex=2",
                           "--load", "square:0,2,0@vertex=3", "--load", "gravity:0,0,-1");
  cJSON_Delete(object);
  double *end = read_array("end.npy", 2, PARTICLE_RANK);
  assert_near(end[2], 0.6 * 1.5 - 0.6 * 0.7, 1e-9);
  assert_near(end[3], 0.3 * 2 * 0.5 + 0.6 * 0.3, 1e-9);
  free(end);
}

static void a_load_on_held_vertices_is_warned_of(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "particle.npz", "-o", "run", "--time", "0.1",
                                 "--load", "constant:0,0,1@held", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "moves nothing"));
  program_result_free(&run);
}

/* Returns the standard error of a short run of the free body under two loads. */
static char *free_run(const char *first, const char *second) {
  program_result run = thrum_run(folder, "simulate", "free.npz", "-o", "run", "--time", "0.1",
                                 "--accept-error", "100%", "--load", first, "--load", second, NULL);
  assert_int_equal(run.exit_code, 0);
  char *said = run.err;
  run.err = NULL;
  program_result_free(&run);
  return said;
}

static void make_free(void) {
  program_result made = thrum_run(folder, "precompute", "beam:4x1x1@1x0.2x0.2", "--order", "1",
                                  "-o", "free.npz", "--modes", "3", "--rank", "3", NULL);
  assert_int_equal(made.exit_code, 0);
  program_result_free(&made);
}

static void the_resultant_of_loads_on_a_free_body_is_warned_of(void **state) {
  (void)state;
  make_free();

  // unequal forces leave a resultant of 2 N
  char *pulled = free_run("constant:3,0,0@right", "constant:-1,0,0@left");
  assert_non_null(strstr(pulled, "(2, 0, 0 N at full strength)"));

  // opposite forces have no resultant to warn of
  char *stretched = free_run("constant:3,0,0@right", "constant:-3,0,0@left");
  assert_null(strstr(stretched, "resultant"));

  // gravity has its own warning
  char *falling = free_run("gravity:0,0,-9.81", "constant:0,0,0@left");
  assert_non_null(strstr(falling, "falls without a strain"));
  assert_null(strstr(falling, "resultant"));

  free(pulled);
  free(stretched);
  free(falling);
}

/* The exit code of a run with --spin and one more option. */
static int spin_code(const char *model, const char *option, const char *value) {
  program_result run = thrum_run(folder, "simulate", model, "-o", "spun", "--spin", "0,90,0",
                                 "--time", "0.1", option, value, NULL);
  const int code = run.exit_code;
  program_result_free(&run);
  return code;
}

static void a_free_body_that_spins_stretches_and_keeps_its_energy(void **state) {
  (void)state;
  make_free();
  cJSON *object =
      SIMULATE("free.npz", "--spin", "100,1000,0", "--time", "2", "--accept-error", "100%");
  const cJSON *spin = cJSON_GetObjectItemCaseSensitive(object, "spin_last_deg_s");
  const double first = cJSON_GetObjectItemCaseSensitive(object, "energy_first_j")->valuedouble;
  const double last = cJSON_GetObjectItemCaseSensitive(object, "energy_last_j")->valuedouble;
  assert_int_equal(cJSON_GetArraySize(spin), 3);
  assert_true(first > 0 && fabs(last / first - 1) <= 1e-12);
  assert_true(cJSON_GetObjectItemCaseSensitive(object, "peak_displacement_m")->valuedouble > 1e-5);
  cJSON_Delete(object);

  // what a body that spins cannot have, and a body that is held
  assert_int_equal(spin_code("free.npz", "--load", "constant:1,0,0@left"), 2);
  assert_int_equal(spin_code("free.npz", "--integrator", "newmark"), 2);
  assert_int_equal(spin_code("free.npz", "--condense", "2"), 2);
  assert_int_equal(spin_code("beam.npz", "--dt", "0.001"), 1);
}

/* Finds the largest vertex displacement of the beam at q, and its vertex, counted from 1. */
static double largest_displacement(const thrum_model *model, const double *q, int64_t *vertex) {
  double largest = 0;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double u[3];
    assert_int_equal(thrum_displacement(model, q, v, 1, u, NULL), 0);
    const double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    if (length > largest) {
      largest = length;
      *vertex = v + 1;
    }
  }
  return largest;
}

static const thrum_model *load_beam(void) {
  const thrum_model *model = NULL;
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &model, NULL), 0);
  return model;
}

static void a_mode_starts_at_rest_with_its_amplitude(void **state) {
  (void)state;
  const thrum_model *model = load_beam();

  cJSON *object = SIMULATE("beam.npz", "--time", "0.03", "--start", "mode:2,-0.01");
  cJSON_Delete(object);
  double *q = read_array("q.npy", 11, 10);
  energy_row *rows = read_rows(11);

  // the amplitude is the largest displacement of a vertex, with the sign as given
  int64_t vertex = 0;
  assert_near(largest_displacement(model, q, &vertex), 0.01, 1e-15);
  assert_true(q[1] < 0);

  // the start lies in the second mode alone, and at rest
  for (int i = 0; i < 10; i++)
    assert_true(i == 1 || q[i] == 0);
  assert_true(rows[0].kinetic == 0 && rows[0].potential > 0);

  free(rows);
  free(q);
  thrum_model_destroy(model);
}

static void every_integrator_swings_the_beam_and_keeps_its_energy(void **state) {
  (void)state;
  const thrum_model *model = load_beam();
  for (int n = 0; n < 4; n++) {
    cJSON *object = SIMULATE("beam.npz", "--time", "1", "--dt", "0.0005", "--start", "mode:1,0.01",
                             "--integrator", integrators[n]);

    // the energy stays within 2 % of the first one, and drifts by less than 0.1 %
    const double first = json_value(object, "energy_first_j");
    assert_string_equal(text_of(object, "status"), "done");
    assert_string_equal(text_of(object, "integrator"), integrators[n]);
    assert_true(first > 0 && fabs(json_value(object, "drift")) < 1e-3);
    assert_true(json_value(object, "energy_min_j") >= 0.98 * first);
    assert_true(json_value(object, "energy_max_j") <= 1.02 * first);

    // the figures of the run fit together
    assert_true(json_value(object, "steps") == 2000);
    assert_near(json_value(object, "simulated_s"), 1, 1e-12);
    assert_true(json_value(object, "us_per_step") > 0);

    // only implicit modes are iterated on
    const double explicit_modes = json_value(object, "explicit_modes");
    assert_true(explicit_modes + json_value(object, "implicit_modes") == 10);
    assert_true((json_value(object, "mean_iterations") > 0) == (explicit_modes < 10));

    // it swings: the other side is reached, and the peak is that of the recorded states
    double *q = read_array("q.npy", 2001, 10);
    double least = 0, peak = 0;
    int64_t vertex = 0, peak_vertex = 0;
    for (int64_t row = 0; row < 2001; row++) {
      least = fmin(least, q[10 * row]);
      const double length = largest_displacement(model, q + 10 * row, &vertex);
      if (length > peak) {
        peak = length;
        peak_vertex = vertex;
      }
    }

    assert_true(least < -0.9 * q[0]);
    assert_near(json_value(object, "peak_displacement_m"), peak, 1e-15);
    assert_true(json_value(object, "peak_vertex") == (double)peak_vertex);

    free(q);
    cJSON_Delete(object);
  }
  thrum_model_destroy(model);
}

static void a_damped_beam_comes_to_rest_where_its_force_balances_gravity(void **state) {
  (void)state;
  const thrum_model *model = load_beam();
  double force[10] = {0}, internal[10];

  // the reduced force of gravity, by the library
  const double gravity[3] = {0, 0, -9.81};
  double *work = malloc(thrum_work_count(model) * sizeof *work);
  assert_non_null(work);
  assert_int_equal(thrum_load_add_gravity(model, gravity, force, NULL), 0);

  for (int n = 0; n < 4; n++) {
    cJSON *object = SIMULATE("beam.npz", "--time", "4", "--dt", "0.0005", "--integrator",
                             integrators[n], "--load", "gravity:0,0,-9.81", "--damping", "12");

    // the load never ends and there is damping: no drift to speak of
    assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "drift")));

    cJSON_Delete(object);

    // at rest the internal force equals the load, and nothing moves
    double *end = read_array("end.npy", 2, 10);
    thrum_internal_force(model, end, internal, work);
    for (int i = 0; i < 10; i++) {
      assert_near(internal[i], force[i], 1e-6 * fabs(force[0]));
      assert_near(end[10 + i], 0, 1e-6);
    }
    free(end);
  }

  free(work);
  thrum_model_destroy(model);
}

static void rows_hold_the_energies_of_their_states(void **state) {
  (void)state;
  const thrum_model *model = load_beam();
  double *work = malloc(thrum_work_count(model) * sizeof *work);
  assert_non_null(work);

  cJSON *object = SIMULATE("beam.npz", "--time", "0.3", "--load", "impulse:0,1,-4@tip");
  double *q = read_array("q.npy", 101, 10), *end = read_array("end.npy", 2, 10);
  energy_row *rows = read_rows(101);

  // each row agrees with the strain energy of the recorded state
  double least = rows[0].total, most = rows[0].total;
  for (int64_t n = 0; n < 101; n++) {
    assert_true(rows[n].step == (double)n);
    assert_near(rows[n].time, 0.003 * (double)n, 1e-15);
    assert_near(rows[n].potential, thrum_strain_energy(model, q + 10 * n, work), 1e-15);
    assert_near(rows[n].total, rows[n].kinetic + rows[n].potential, 1e-15);
    least = fmin(least, rows[n].total);
    most = fmax(most, rows[n].total);
  }

  // the reduced mass matrix is the identity, so the last row's kinetic energy follows from the
  // final momentum
  double kinetic = 0;
  for (int i = 0; i < 10; i++) {
    kinetic += 0.5 * end[10 + i] * end[10 + i];
    assert_true(end[i] == q[10 * 100 + i]);
  }

  assert_near(rows[100].kinetic, kinetic, 1e-15);

  // full digits: the figures are those of the rows
  assert_true(json_value(object, "energy_first_j") == rows[0].total);
  assert_true(json_value(object, "energy_last_j") == rows[100].total);
  assert_true(json_value(object, "energy_min_j") == least);
  assert_true(json_value(object, "energy_max_j") == most);

  cJSON_Delete(object);
  free(rows);
  free(end);
  free(q);
  free(work);
  thrum_model_destroy(model);
}

/* The numbers of a row of probes.csv behind its step and its time. */
static void read_probes(int64_t row, double *values, int count) {
  char *text = text_file_read(in_folder("run/probes.csv"));
  assert_non_null(text);
  char *at = text;
  for (int64_t n = 0; n <= row; n++)
    at = strchr(at, '\n') + 1;
  assert_true(strtoll(at, &at, 10) == row);
  strtod(at + 1, &at);
  for (int n = 0; n < count; n++)
    values[n] = strtod(at + 1, &at);
  assert_int_equal(*at, '\n');
  free(text);
}

static void probes_follow_the_mean_of_their_targets(void **state) {
  (void)state;
  const thrum_model *model = load_beam();
  cJSON *object = SIMULATE("beam.npz", "--time", "0.3", "--load", "impulse:0,1,-4@tip", "--probe",
                           "near:1,0.04,0.06", "--probe", "x>0.9", "--judge", "off");
  double *q = read_array("q.npy", 101, 10), values[6];

  // both targets by hand: the beam's end is at x = 1, with its corners 0.05 from the axis
  int32_t corner = -1, end[9];
  int count = 0;
  for (int32_t v = 0; v < model->vertex_count; v++) {
    const double *x = model->vertices + 3 * v;
    if (x[0] > 0.9)
      end[count++] = v;
    if (x[0] > 0.9 && x[1] > 0.04 && x[2] > 0.04)
      corner = v;
  }
  assert_int_equal(count, 9);

  double farthest = 0;
  for (int64_t row = 0; row < 101; row++) {
    double expected[6];
    read_probes(row, values, 6);
    assert_int_equal(thrum_displacement_mean(model, &corner, 1, q + 10 * row, expected, NULL), 0);
    assert_int_equal(thrum_displacement_mean(model, end, 9, q + 10 * row, expected + 3, NULL), 0);
    for (int i = 0; i < 6; i++)
      assert_true(values[i] == expected[i]);
    farthest = fmax(farthest, hypot(hypot(values[0], values[1]), values[2]));
  }

  // the report has the vertex and the largest displacement
  const cJSON *probe = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "probes"), 0);
  assert_string_equal(text_of(probe, "at"), "near:1,0.04,0.06");
  assert_true(json_value(probe, "vertex") == corner + 1);
  assert_near(json_value(probe, "farthest_m"), farthest, 1e-15);
  cJSON_Delete(object);
  free(q);

  // without --probe it is followed where the load acts, of the mesh as well
  cJSON_Delete(
      SIMULATE("beam.npz", "--time", "0.03", "--load", "impulse:0,1,-4@tip", "--judge", "off"));
  read_probes(10, values, 3);
  const double reduced = values[2];
  cJSON_Delete(SIMULATE("beam.npz", "--time", "0.03", "--load", "impulse:0,1,-4@tip", "--full"));
  read_probes(10, values, 3);
  assert_near(values[2], reduced, 0.1 * fabs(reduced)); // of ten modes
  thrum_model_destroy(model);
}

/* The first line of probes.csv; the caller frees it. */
static char *head_of_probes(void) {
  char *text = text_file_read(in_folder("run/probes.csv"));
  assert_non_null(text);
  text[strcspn(text, "\n")] = 0;
  return text;
}

static void probes_are_named_by_their_targets(void **state) {
  (void)state;

  // keys of a load are none of its target
  cJSON *object = SIMULATE("beam.npz", "--time", "0.03", "--load",
                           "constant:0,0,-1@vertex=5,from=0.01,until=0.02", "--judge", "off");
  char *head = head_of_probes();
  assert_string_equal(head, "step,time_s,vertex=5.x_m,vertex=5.y_m,vertex=5.z_m");
  const cJSON *probe = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "probes"), 0);
  assert_string_equal(text_of(probe, "at"), "vertex=5");
  cJSON_Delete(object);
  free(head);

  // a line end in a predicate ends no line of the file
  cJSON_Delete(SIMULATE("beam.npz", "--time", "0.03", "--probe", "x>0.9\n", "--judge", "off"));
  head = head_of_probes();
  assert_string_equal(head, "step,time_s,x>0.9?.x_m,x>0.9?.y_m,x>0.9?.z_m");
  free(head);
}

static void record_every_keeps_each_nth_row_and_the_last_energy(void **state) {
  (void)state;
  cJSON *object = SIMULATE("beam.npz", "--time", "0.3", "--start", "mode:1,0.01");
  energy_row *all = read_rows(101);
  cJSON_Delete(object);

  // every seventh of 100 steps leaves 15 rows, with step 98 the last of them
  object = SIMULATE("beam.npz", "--time", "0.3", "--start", "mode:1,0.01", "--record-every", "7");
  energy_row *some = read_rows(15);
  double *q = read_array("q.npy", 15, 10);

  // rows that are kept have the same bytes, and the last energy is that of step 100
  for (int64_t n = 0; n < 15; n++)
    assert_memory_equal(&some[n], &all[7 * n], sizeof *some);
  assert_true(json_value(object, "rows") == 15);
  assert_true(json_value(object, "energy_last_j") == all[100].total);

  cJSON_Delete(object);
  free(q);
  free(some);
  free(all);
}

static void a_run_continues_from_the_end_of_another(void **state) {
  (void)state;
  for (int n = 0; n < 4; n++) {
    // one run of the whole time
    cJSON *object = SIMULATE("duffing.npz", "--time", "0.9", "--integrator", integrators[n],
                             "--start", "start.npy", "--dt", "0.003");
    double *whole = read_array("end.npy", 2, 1);
    cJSON_Delete(object);

    // the same time in two halves, the second from the end of the first
    cJSON_Delete(SIMULATE("duffing.npz", "--time", "0.45", "--integrator", integrators[n],
                          "--start", "start.npy", "--dt", "0.003"));
    assert_int_equal(rename(in_folder("run/end.npy"), in_folder("half.npy")), 0);
    cJSON_Delete(SIMULATE("duffing.npz", "--time", "0.45", "--integrator", integrators[n],
                          "--start", "half.npy", "--dt", "0.003"));

    // both reach one state, and it is not rest
    double *half = read_array("end.npy", 2, 1);
    assert_near(half[0], whole[0], 1e-9);
    assert_near(half[1], whole[1], 1e-8);
    assert_true(fabs(whole[0]) > 1e-4 || fabs(whole[1]) > 1e-3);

    free(half);
    free(whole);
  }
}

static void starts_add_up_and_a_plain_vector_is_q(void **state) {
  (void)state;
  const double q[10] = {0.001, 0.002, 0, 0, 0, 0, 0, 0, 0, 0.0001};
  assert_true(save_npy(in_folder("vector.npy"), q, 10, 0));

  cJSON_Delete(
      SIMULATE("beam.npz", "--time", "0.003", "--start", "mode:1,0.01", "--start", "vector.npy"));
  double *sum = read_array("q.npy", 2, 10);

  // the mode alone, for the difference of the two
  cJSON_Delete(SIMULATE("beam.npz", "--time", "0.003", "--start", "mode:1,0.01"));
  double *mode = read_array("q.npy", 2, 10);

  for (int i = 0; i < 10; i++)
    assert_near(sum[i], mode[i] + q[i], 1e-17);
  free(mode);
  free(sum);
}

static void two_runs_write_the_same_bytes(void **state) {
  (void)state;
  static const char *const files[] = {"run/energy.csv", "run/q.npy", "run/end.npy"};
  void *first[3], *second[3];
  size_t sizes[3], size = 0;

  // the first pass keeps the files' bytes, the second compares with them
  for (int pass = 0; pass < 2; pass++) {
    cJSON_Delete(SIMULATE("beam.npz", "--time", "0.6", "--load", "square:0,1,-4@tip"));
    for (int n = 0; n < 3; n++) {
      assert_int_equal(thrum_file_read(in_folder(files[n]), pass == 0 ? &first[n] : &second[n],
                                       pass == 0 ? &sizes[n] : &size, NULL),
                       0);
      if (pass == 0)
        continue;
      assert_int_equal(size, sizes[n]);
      assert_memory_equal(first[n], second[n], size);
      free(first[n]);
      free(second[n]);
    }
  }
}

static void run_json_holds_the_options_and_what_json_printed(void **state) {
  (void)state;

  cJSON *printed = SIMULATE("beam.npz", "--time", "0.3", "--load", "gravity:0,0,-9.81", "--damping",
                            "0.3,0.001", "--integrator=imexv", "--split", "4", "--safety=0.25");

  // the file and the line on standard output are the same object
  char *text = text_file_read(in_folder("run/run.json"));
  assert_non_null(text);
  cJSON *written = cJSON_Parse(text);
  assert_true(cJSON_Compare(printed, written, true));

  // options stand as numbers and texts, not as they were typed
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(written, "options");
  const cJSON *damping = cJSON_GetObjectItemCaseSensitive(options, "damping");
  const cJSON *loads = cJSON_GetObjectItemCaseSensitive(options, "load");
  assert_true(cJSON_GetArrayItem(damping, 0)->valuedouble == 0.3);
  assert_true(cJSON_GetArrayItem(damping, 1)->valuedouble == 0.001);
  assert_int_equal(cJSON_GetArraySize(loads), 1);
  assert_string_equal(cJSON_GetArrayItem(loads, 0)->valuestring, "gravity:0,0,-9.81");

  // the split that was asked for is the one that was used
  assert_true(json_value(options, "split") == 4);
  assert_true(json_value(written, "explicit_modes") == 4);
  assert_true(json_value(written, "implicit_modes") == 6);

  // FNV-1a of the model's bytes
  void *bytes = NULL;
  size_t size = 0;
  assert_int_equal(thrum_file_read(in_folder("beam.npz"), &bytes, &size, NULL), 0);
  uint64_t hash = UINT64_C(0xcbf29ce484222325);
  for (size_t n = 0; n < size; n++)
    hash = (hash ^ ((const unsigned char *)bytes)[n]) * UINT64_C(0x100000001b3);

  char expected[24];
  snprintf(expected, sizeof expected, "%016llx", (unsigned long long)hash);
  assert_string_equal(text_of(written, "model_hash"), expected);
  assert_int_equal(strlen(text_of(written, "model_arrays_hash")), 16);

  free(bytes);
  free(text);
  cJSON_Delete(written);
  cJSON_Delete(printed);
}

static void the_stages_fill_the_total_time(void **state) {
  (void)state;
  cJSON *object = SIMULATE("beam.npz", "--time", "1", "--start", "mode:1,0.01");
  const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(object, "seconds");
  const double sum = json_value(seconds, "read") + json_value(seconds, "step") +
                     json_value(seconds, "output") + json_value(seconds, "plot");
  const double total = json_value(seconds, "total");
  assert_true(total > 0 && sum <= total * (1 + 1e-9) && sum >= 0.9 * total);
  assert_true(json_value(object, "peak_mb") > 1);
  cJSON_Delete(object);
}

static void a_plot_is_drawn_exactly_where_gnuplot_is_installed(void **state) {
  (void)state;

  // whether gnuplot is installed decides what is expected here
  char program[] = "/bin/sh", option[] = "-c", command[] = "command -v gnuplot >/dev/null";
  char *argv[] = {program, option, command, NULL};
  program_result found = program_execute(NULL, argv);

  // the tests' own variable says that none is drawn
  assert_int_equal(setenv("THRUM_GNUPLOT", "", 1), 0);
  cJSON_Delete(SIMULATE("beam.npz", "--time", "0.3", "--start", "mode:1,0.01"));
  assert_false(file_exists(in_folder("run/energy.png")));
  unsetenv("THRUM_GNUPLOT");
  cJSON_Delete(SIMULATE("beam.npz", "--time", "0.3", "--start", "mode:1,0.01"));

  char *image = text_file_read(in_folder("run/energy.png"));
  assert_int_equal(image != NULL, found.exit_code == 0);
  assert_true(image == NULL || memcmp(image, "\x89PNG\r\n\x1a\n", 8) == 0);
  free(image);
  program_result_free(&found);

  // without gnuplot, and with one that fails, the run is complete all the same
  char *saved = strdup(getenv("PATH"));
  assert_non_null(saved);
  for (int n = 0; n < 2; n++) {
    assert_int_equal(setenv("PATH", n == 0 ? "/nonexistent" : folder, 1), 0);
    if (n == 1) {
      assert_true(text_file_write(in_folder("gnuplot"), "#!/bin/sh\nexit 1\n"));
      assert_int_equal(chmod(in_folder("gnuplot"), 0755), 0);
    }
    cJSON *object = SIMULATE("beam.npz", "--time", "0.3", "--start", "mode:1,0.01");
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(object, "files")), 4);
    assert_false(file_exists(in_folder("run/energy.png")));
    assert_false(file_exists(in_folder("run/energy.gp")));
    cJSON_Delete(object);
  }
  setenv("PATH", saved, 1);
  free(saved);
  unlink(in_folder("gnuplot"));
  setenv("THRUM_GNUPLOT", "", 1);
}

static void a_step_that_fails_is_told_once(void **state) {
  (void)state;
  assert_true(save_oscillator(in_folder("fast.npz"), 1e6, 1e6));
  assert_true(save_npy(in_folder("one.npy"), (const double[]){1}, 1, 0));
  cJSON *object = simulate_code(
      3, "fast.npz", (const char *const[11]){"--integrator", "rk4", "--start", "one.npy"});
  const char *message = strstr(text_of(object, "message"), "stopped: step ");
  if (message == NULL || strstr(message + strlen("stopped: step "), "step ") != NULL)
    fail_msg("%s", text_of(object, "message"));
  cJSON_Delete(object);
}

static void an_explicit_mode_beyond_the_bound_is_warned_of_and_flagged(void **state) {
  (void)state;
  assert_true(save_oscillator(in_folder("fast.npz"), 1e6, 0));
  assert_true(save_npy(in_folder("one.npy"), (const double[]){1}, 1, 0));

  // dt omega = 3 is beyond the bound of 2, so the run overflows and ends early
  cJSON *object = simulate_code(
      3, "fast.npz",
      (const char *const[11]){"--integrator", "verlet", "--start", "one.npy", "--time", "3"});
  assert_string_equal(text_of(object, "status"), "not_finite");
  assert_true(strlen(text_of(object, "message")) > 10);

  const double steps = json_value(object, "steps");
  const int64_t count = (int64_t)json_value(object, "rows");
  assert_true(steps > 10 && steps < 1000 && count <= (int64_t)steps + 1);
  assert_true(cJSON_IsNull(cJSON_GetObjectItemCaseSensitive(object, "drift")));
  cJSON_Delete(object);

  // what was run is written
  free(read_array("q.npy", count, 1));
  energy_row *rows = read_rows(count);
  assert_true(rows[count - 1].step == (double)(count - 1) && isfinite(rows[count - 1].total));
  free(rows);

  program_result run = thrum_run(folder, "simulate", "fast.npz", "-o", "run", "--time", "3",
                                 "--start", "one.npy", "--integrator", "verlet", NULL);
  assert_non_null(strstr(run.err, "beyond the stability bound"));
  program_result_free(&run);
}

static void a_step_longer_than_half_a_period_is_warned_of(void **state) {
  (void)state;
  assert_true(save_oscillator(in_folder("quiet.npz"), 4.0, 0));
  assert_true(save_npy(in_folder("one.npy"), (const double[]){1}, 1, 0));

  // half a period is pi/2 s, and the mode is implicit
  for (int n = 0; n < 2; n++) {
    program_result run = thrum_run(folder, "simulate", "quiet.npz", "-o", "run", "--time", "10",
                                   "--start", "one.npy", "--dt", n == 0 ? "1.6" : "1.5", NULL);
    assert_int_equal(strstr(run.err, "periods of the slowest mode") != NULL, n == 0);
    program_result_free(&run);
  }
}

static void energy_that_grows_by_itself_flags_the_run(void **state) {
  (void)state;

  // dt omega = 2.001: growth by 6 % a step, far from overflow after 200 steps
  const double omega = 2.001 / 0.003;
  assert_true(save_oscillator(in_folder("slow.npz"), omega * omega, 0));
  assert_true(save_npy(in_folder("small.npy"), (const double[]){1e-9}, 1, 0));
  cJSON *object = simulate_code(
      3, "slow.npz",
      (const char *const[11]){"--integrator", "verlet", "--start", "small.npy", "--time", "0.6"});
  assert_string_equal(text_of(object, "status"), "energy_grew");
  assert_true(json_value(object, "drift") > 1e3);
  cJSON_Delete(object);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_impulse_gives_force_times_duration_at_every_time_step),
      cmocka_unit_test(square_and_constant_loads_act_within_their_window),
      cmocka_unit_test(a_sine_gives_the_integral_of_its_sine),
      cmocka_unit_test(gravity_pulls_each_coordinate_by_its_axis_mass),
      cmocka_unit_test(a_force_is_shared_equally_by_the_vertices_of_its_target),
      cmocka_unit_test(loads_add_up),

      // loads on what cannot move are warned of
      cmocka_unit_test(a_load_on_held_vertices_is_warned_of),
      cmocka_unit_test(the_resultant_of_loads_on_a_free_body_is_warned_of),
      cmocka_unit_test(a_free_body_that_spins_stretches_and_keeps_its_energy),

      // starts and integrators
      cmocka_unit_test(a_mode_starts_at_rest_with_its_amplitude),
      cmocka_unit_test(every_integrator_swings_the_beam_and_keeps_its_energy),
      cmocka_unit_test(a_damped_beam_comes_to_rest_where_its_force_balances_gravity),

      // what is written
      cmocka_unit_test(rows_hold_the_energies_of_their_states),
      cmocka_unit_test(probes_follow_the_mean_of_their_targets),
      cmocka_unit_test(probes_are_named_by_their_targets),
      cmocka_unit_test(record_every_keeps_each_nth_row_and_the_last_energy),
      cmocka_unit_test(a_run_continues_from_the_end_of_another),
      cmocka_unit_test(starts_add_up_and_a_plain_vector_is_q),
      cmocka_unit_test(two_runs_write_the_same_bytes),
      cmocka_unit_test(run_json_holds_the_options_and_what_json_printed),
      cmocka_unit_test(the_stages_fill_the_total_time),
      cmocka_unit_test(a_plot_is_drawn_exactly_where_gnuplot_is_installed),

      // runs that are flagged
      cmocka_unit_test(a_step_that_fails_is_told_once),
      cmocka_unit_test(an_explicit_mode_beyond_the_bound_is_warned_of_and_flagged),
      cmocka_unit_test(a_step_longer_than_half_a_period_is_warned_of),
      cmocka_unit_test(energy_that_grows_by_itself_flags_the_run),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
