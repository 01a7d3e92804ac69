/* `thrum simulate --base-motion` moves the base by a file or a sine, and refuses bad ones.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>

#include "io/npy_file.h"
#include "tests/support/base64_decode.h"
#include "tests/support/simulate_support.h"
#include "tests/support/test_folder.h"

static int make_models(void **state) {
  (void)state;
  return test_folder_make(folder) == NULL || !save_particle(in_folder("particle.npz"), 0, 0);
}

static cJSON *base_motion(int code, const char *with, const char *more, const char *more_value) {
  program_result run =
      thrum_run(folder, "simulate", "particle.npz", "-o", "run", "--integrator", "energy", "--dt",
                "0.01", "--time", "1", "--json", "--base-motion", with, more, more_value, NULL);
  if (run.exit_code != code)
    print_error("exit code %d: %s", run.exit_code, run.err);
  assert_int_equal(run.exit_code, code);
  cJSON *object = json_line(run.out);
  program_result_free(&run);
  return object;
}

/* Reads q after each step, rows x 2. */
static double *read_q(int64_t *rows) {
  double *values = NULL;
  int64_t columns = 0;
  assert_int_equal(thrum_npy_read_f8(in_folder("run/q.npy"), &values, rows, &columns, NULL), 0);
  assert_int_equal(columns, PARTICLE_RANK);
  return values;
}

/* Without stiffness q'' = -m a: under 2 m/s^2 along x a parabola, and what the base puts in is the
 * kinetic energy. Blanks, a byte-order mark, CR and comments do not matter. */
static void a_file_of_accelerations_moves_the_body(void **state) {
  (void)state;
  int64_t rows = 0;
  assert_true(
      text_file_write(in_folder("push.csv"),
                      "\xef\xbb\xbf# a lift\r\ntime, ax, ay, az\r\n0,2,0,0\r\n\r\n5, 2,0,0"));

  // the motion is the parabola to rounding, along x alone
  cJSON *object = base_motion(0, "push.csv", NULL, NULL);
  double *q = read_q(&rows);
  assert_int_equal(rows, 101);
  for (int64_t k = 0; k < rows; k++) {
    const double t = 0.01 * (double)k;
    assert_true(fabs(q[2 * k] + particle_axis_mass[0] * t * t) <= 1e-12);
    assert_true(q[2 * k + 1] == 0);
  }

  // the energy is that of the speed reached, and all of it is work of the base
  const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
  const double energy = json_value(object, "energy_last_j");
  assert_true(fabs(energy - 0.5 * pow(2 * particle_axis_mass[0], 2)) <= 1e-12);
  assert_true(fabs(json_value(work, "base_j") - energy) <= 1e-12 * energy);
  assert_true(json_value(work, "load_j") == 0);
  assert_true(fabs(json_value(work, "balance_j")) <= 1e-12 * energy);

  free(q);
  cJSON_Delete(object);
}

/* A base that moves by x = t^3 (at rest first) takes the body along in no time: relative to it the
 * body stays behind by the same. */
static void a_file_of_positions_is_a_motion_too(void **state) {
  (void)state;
  int64_t rows = 0;

  // the columns x, y, z are positions, and y is the one that moves
  FILE *file = fopen(in_folder("cube.csv"), "w");
  assert_non_null(file);
  fputs("t,x,y,z\n", file);
  for (int k = 0; k <= 200; k++)
    fprintf(file, "%.17g 0 %.17g 0\n", 0.01 * k, pow(0.01 * k, 3));
  fclose(file);

  cJSON *object = base_motion(0, "cube.csv", NULL, NULL);
  double *q = read_q(&rows);

  // axis_mass of y: 0 on the first, 2.5 on the second coordinate
  for (int64_t k = 0; k < rows; k++)
    assert_true(fabs(q[2 * k + 1] + particle_axis_mass[3] * pow(0.01 * (double)k, 3)) <= 2e-4);
  free(q);
  cJSON_Delete(object);
}

/* A held vertex moves with the base as seen from the ground, and stays as seen from the base. */
static void frames_are_seen_from_the_base_or_the_ground(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("steady.csv"), "0,0,0,8.8\n0.5,0,0,8.8\n1,0,0,8.8\n"));
  for (int ground = 0; ground < 2; ground++) {
    // the same run, shown in one frame of reference and in the other
    program_result run =
        thrum_run(folder, "simulate", "particle.npz", "-o", "seen", "--integrator", "energy",
                  "--dt", "0.01", "--time", "1", "--frames", "every-50", "--base-motion",
                  "steady.csv", "--frames-in", ground ? "ground" : "base", "-q", NULL);
    assert_int_equal(run.exit_code, 0);
    assert_non_null(strstr(run.out, ", frames.pvd, frames/\n"));
    program_result_free(&run);

    // the displacements, behind eight bytes that say how many bytes they are
    static char text[65536];
    static unsigned char bytes[sizeof text];
    FILE *file = fopen(in_folder("seen/frames/frame_000001.vtu"), "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    const char *array = strstr(text, "Name=\"displacement\"");
    assert_non_null(array);
    array += strcspn(array, ">") + 1;
    array += strspn(array, "\n ");
    const uint64_t size = base64_decode(array, strcspn(array, "\n <"), bytes);

    // the base rises by 1/2 8.8 0.5^2 = 1.1 m, which is the displacement of the one held vertex
    int64_t found = 0;
    for (size_t at = 8; at + 3 * sizeof(double) <= size; at += 3 * sizeof(double)) {
      double u[3];
      memcpy(u, bytes + at, sizeof u);
      found += u[0] == 0 && u[1] == 0 && fabs(u[2] - 1.1) <= 1e-12;
    }
    assert_true(found == (ground ? 1 : 0));
  }
}

typedef struct refusal {
  const char *text, *says;
} refusal;

static void bad_files_are_refused_with_their_line(void **state) {
  (void)state;

  // files with too few or too many numbers, times out of order, and columns of other names
  static const refusal cases[] = {
      {"t,ax,ay,az\n0,0,0,1\n0.1,0,0\n", "bad.csv:3:"},
      {"0,0,0,1\n0.1,0,0,1,2\n", "bad.csv:2:"},
      {"0,0,0,1\n0.1,0,zero,1\n", "bad.csv:2:"},
      {"0,0,0,1\n0.1,0,0,1\n0.1,0,0,1\n", "bad.csv:3: the time 0.1 s is not later"},
      {"-1,0,0,1\n0.1,0,0,1\n", "bad.csv:1: the time -1 s is before"},
      {"0,0,0,1\n0.1,0,nan,1\n", "bad.csv:2:"},
      {"t,u,v,w\n0,0,0,1\n0.1,0,0,1\n", "bad.csv:1: the columns"},
      {"0,0,0,1\n", "two lines"},
      {"", "bad.csv"},
  };

  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    assert_true(text_file_write(in_folder("bad.csv"), cases[n].text));
    program_result run = thrum_run(folder, "simulate", "particle.npz", "-o", "none", "--time",
                                   "0.1", "--base-motion", "bad.csv", NULL);
    if (run.exit_code != 1 || strstr(run.err, cases[n].says) == NULL)
      fail_msg("case %d: exit %d: %s", (int)n, run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    assert_false(file_exists(in_folder("none")));
    program_result_free(&run);
  }

  // descriptions of a sine that lack a part, or have one too many
  static const char *const slips[] = {"sine:1,2,3",         "sine:1,2,f=1",
                                      "sine:1,2,3,f=0",     "",
                                      "sine:1,2,3,f=1,g=2", "sine:1,2,3,f=1,from=2,until=1"};
  for (size_t n = 0; n < sizeof slips / sizeof slips[0]; n++) {
    program_result run = thrum_run(folder, "simulate", "particle.npz", "-o", "none",
                                   "--base-motion", slips[n], NULL);
    assert_int_equal(run.exit_code, 2);
    assert_non_null(strstr(run.err, "sine:AX,AY,AZ,f=HZ"));
    program_result_free(&run);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_file_of_accelerations_moves_the_body),
      cmocka_unit_test(a_file_of_positions_is_a_motion_too),
      cmocka_unit_test(frames_are_seen_from_the_base_or_the_ground),
      cmocka_unit_test(bad_files_are_refused_with_their_line),
  };
  return cmocka_run_group_tests(tests, make_models, remove_folder);
}
