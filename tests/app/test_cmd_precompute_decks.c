/* Tests of `thrum precompute` and `thrum check` on what decks of other programs need: a unit, a
 * material for each region, the name of the regions, a polynomial without its mesh.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "precompute/vega_model.h"
#include "precompute/vega_reduced.h"
#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

/* Two cubes of 10 mm, one of them fixed at its foot, in tonnes and megapascals. */
static const char DECK[] =
    "*NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n8,0,10,10\n"
    "9,0,0,20\n10,10,0,20\n11,10,10,20\n12,0,10,20\n*NSET,NSET=foot\n1,2,3,4\n"
    "*ELEMENT,TYPE=C3D8,ELSET=LOWER\n1,1,2,3,4,5,6,7,8\n*ELEMENT,TYPE=C3D8,ELSET=UPPER\n"
    "2,5,6,7,8,9,10,11,12\n*SOLID SECTION,ELSET=LOWER,MATERIAL=STEEL\n"
    "*SOLID SECTION,ELSET=UPPER,MATERIAL=STEEL\n*MATERIAL,NAME=STEEL\n*ELASTIC\n2.1e5,0.3\n";
static const char DENSITY[] = "*DENSITY\n7.85e-9\n";

static const char *write_deck(bool density) {
  char text[2000];
  snprintf(text, sizeof text, "%s%s", DECK, density ? DENSITY : "");
  assert_true(text_file_write(in_folder("deck.inp"), text));
  return "deck.inp";
}

static double first_frequency(program_result run) {
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const double hertz =
      cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, "frequencies_hz"), 0)
          ->valuedouble;
  cJSON_Delete(object);
  program_result_free(&run);
  return hertz;
}

#define PRECOMPUTE(...)                                                                            \
  thrum_run(folder, "precompute", "deck.inp", "-o", "deck.npz", "--fix", "foot", "--modes", "2",   \
            "--rank", "2", "--json", "-q", __VA_ARGS__, NULL)

static void a_unit_is_that_of_lengths_and_materials(void **state) {
  (void)state;
  write_deck(true);
  const double unit = first_frequency(PRECOMPUTE("--unit", "mm-t-s"));

  // the same in SI, by hand
  const double si =
      first_frequency(PRECOMPUTE("--scale", "0.001", "--young", "2.1e11", "--density", "7850"));
  assert_true(fabs(unit / si - 1) < 1e-12);

  // without the unit a warning says what may be meant; an unknown one is refused
  program_result run = PRECOMPUTE("--modes", "2");
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "a density is 7.85e-09 kg/m^3"));
  assert_non_null(strstr(run.err, "needs --unit mm-t-s"));
  assert_non_null(strstr(run.err, "2 hexahedra were cut into 12 tetrahedra of four nodes"));
  program_result_free(&run);
  run = PRECOMPUTE("--unit", "furlong");
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "LENGTH-MASS-TIME"));
  program_result_free(&run);
}

static void each_region_may_have_a_material_of_its_own(void **state) {
  (void)state;
  write_deck(false);

  // the file has no density, so both regions need a material, and both get it
  const double both =
      first_frequency(PRECOMPUTE("--scale", "0.001", "--material", "LOWER:2.1e11,0.3,7850",
                                 "--material", "UPPER:2.1e11,0.3,7850"));
  const double all = first_frequency(
      PRECOMPUTE("--scale", "0.001", "--young", "2.1e11", "--poisson", "0.3", "--density", "7850"));
  assert_true(both == all);

  // a heavier upper half swings more slowly
  const double heavy =
      first_frequency(PRECOMPUTE("--scale", "0.001", "--young", "2.1e11", "--poisson", "0.3",
                                 "--density", "7850", "--material", "UPPER:2.1e11,0.3,15700"));
  assert_true(heavy < 0.8 * all && heavy > 0.7 * all);

  static const struct {
    const char *material;
    int code;
    const char *words;
  } bad[] = {{"LOWER:2.1e11,0.3,7850", 1, "does not say what region 'UPPER' is made of"},
             {"MIDDLE:2.1e11,0.3,7850", 1, "'MIDDLE' is no region; the regions are LOWER, UPPER"},
             {"LOWER", 2, "write REGION:E,NU,RHO"},
             {"LOWER:1,2", 2, "write REGION:E,NU,RHO"},
             {":1,0.3,1", 2, "write REGION:E,NU,RHO"},
             {"LOWER:1,0.3,1,2", 2, "write REGION:E,NU,RHO"},
             {"LOWER:1,0.5,1", 2, "NU is between"},
             {"LOWER:nan,0.3,1", 2, "are above 0"},
             {"LOWER:1,0.3,0", 2, "are above 0"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    program_result run = PRECOMPUTE("--material", bad[n].material);
    assert_int_equal(run.exit_code, bad[n].code);
    if (!strstr(run.err, bad[n].words))
      fail_msg("expected '%s' in %s", bad[n].words, run.err);
    program_result_free(&run);
  }
  program_result run = PRECOMPUTE("--material", "LOWER:1,0.3,1", "--material", "LOWER:1,0.3,1");
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "region 'LOWER' comes twice"));
  program_result_free(&run);
}

/* The largest displacement that a static run of the full order finds [m]. */
static double static_peak(program_result run) {
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const cJSON *peak = cJSON_GetObjectItemCaseSensitive(object, "peak_displacement_m");
  assert_non_null(peak);
  const double metres = peak->valuedouble;
  cJSON_Delete(object);
  program_result_free(&run);
  return metres;
}

#define STATIC(...)                                                                                \
  thrum_run(folder, "static", "deck.inp", "--full", "--fix", "foot", "--load",                     \
            "constant:1000,0,0@all", "--json", "-q", __VA_ARGS__, NULL)

static void the_full_order_takes_unit_regions_and_order_of_a_mesh_too(void **state) {
  (void)state;
  write_deck(true);
  const double unit = static_peak(STATIC("--unit", "mm-t-s", "--order", "1"));
  const double si =
      static_peak(STATIC("--scale", "0.001", "--order", "1", "--material", "LOWER:2.1e11,0.3,7850",
                         "--material", "UPPER:2.1e11,0.3,7850"));
  assert_true(unit > 0 && fabs(unit / si - 1) < 1e-9);

  // ten nodes bend more easily, and so does a lower half that is softer
  assert_true(static_peak(STATIC("--unit", "mm-t-s", "--order", "2")) > 1.2 * unit);
  assert_true(static_peak(STATIC("--unit", "mm-t-s", "--order", "1", "--material",
                                 "LOWER:1e11,0.3,7850")) > 1.2 * unit);

  // simulate steps it, and neither takes them where a model has its own
  program_result run =
      thrum_run(folder, "simulate", "deck.inp", "--full", "--fix", "foot", "--unit", "mm-t-s",
                "--material", "UPPER:1e11,0.3,7850", "--time", "1e-5", "--dt", "1e-6", "--start",
                "mode:1,1e-6", "-q", "-o", "run", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "beam", "--unit", "mm-t-s", "-o", "run2", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "are of a mesh; a model has its own"));
  program_result_free(&run);
}

static void check_names_regions_and_what_was_read(void **state) {
  (void)state;
  write_deck(true);

  // programs get names and notes as JSON
  program_result run = thrum_run(folder, "check", "deck.inp", "--unit", "mm-t-s", "--json", NULL);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  const cJSON *names = cJSON_GetObjectItemCaseSensitive(object, "region_names");
  assert_string_equal(cJSON_GetArrayItem(names, 0)->valuestring, "LOWER");
  assert_string_equal(cJSON_GetArrayItem(names, 1)->valuestring, "UPPER");
  const cJSON *notes = cJSON_GetObjectItemCaseSensitive(object, "notes");
  assert_string_equal(cJSON_GetArrayItem(notes, 0)->valuestring,
                      "2 hexahedra were cut into 12 tetrahedra of four nodes");
  cJSON_Delete(object);
  program_result_free(&run);

  // and for people
  run = thrum_run(folder, "check", "deck.inp", "--unit", "mm-t-s", NULL);
  assert_non_null(strstr(run.out, "LOWER: E = 2.1e+11 Pa, nu = 0.3, rho = 7850 kg/m^3"));
  program_result_free(&run);
}

/* The polynomial of a model comes back with its bits, as a model that shows coordinates only. */
static void a_polynomial_alone_is_a_model_without_a_mesh(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:6x2x2@1x0.2x0.2", "--order", "1", "--fix", "x<0.001",
                "--modes", "4", "--rank", "8", "-q", "-o", "beam.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "export", "beam.npz", "--vega-cubic", "beam.cub", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "beam.cub", "-o", "cubic.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.out, "cubic.npz: rank 8, "));
  program_result_free(&run);

  const thrum_model *beam = NULL, *cubic = NULL;
  assert_int_equal(thrum_model_load(in_folder("beam.npz"), &beam, NULL), THRUM_OK);
  assert_int_equal(thrum_model_load(in_folder("cubic.npz"), &cubic, NULL), THRUM_OK);
  assert_int_equal(cubic->vertex_count, 0);
  assert_memory_equal(cubic->omega2, beam->omega2, 8 * sizeof(double));
  assert_int_equal(cubic->c4_count, beam->c4_count);
  for (int64_t i = 0; i < beam->c4_count; i++)
    assert_true(fabs(cubic->c4[i] - beam->c4[i]) <= 1e-15 * fabs(beam->c4[i]));
  thrum_model_free(beam);
  thrum_model_free(cubic);

  // it has nothing that a mesh would be needed for, and damage is refused
  run = thrum_run(folder, "precompute", "beam.cub", "--fix", "x<0", "-o", "no.npz", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "is a polynomial without a mesh"));
  program_result_free(&run);
  assert_true(text_file_write(in_folder("bad.cub"), "12345678901234567890"));
  run = thrum_run(folder, "precompute", "bad.cub", "-o", "no.npz", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "is it a .cub file?"));
  program_result_free(&run);
}

/* A stiffness that is not diagonal is turned; its trace and its norm stay. */
static void coordinates_are_turned_until_the_stiffness_is_diagonal(void **state) {
  (void)state;
  thrum_imported_basis read = {0};
  thrum_vega_model made = {0};
  const char *path = THRUM_TEST_DATA "/beam1k.r15.cub";
  assert_int_equal(thrum_vega_cubic_read(path, &read, NULL), THRUM_OK);
  assert_int_equal(thrum_vega_model_read(path, &made, NULL), THRUM_OK);
  assert_int_equal(made.model.rank, 15);
  assert_true(made.changed);

  // neither changes under a turn
  double trace = 0, norm = 0;
  for (int64_t i = 0; i < 15; i++) {
    trace += made.omega2[i] - read.linear[16 * i];
    norm += made.omega2[i] * made.omega2[i];
    assert_true(made.omega2[i] > (i > 0 ? made.omega2[i - 1] : 0));
  }
  for (int64_t n = 0; n < 225; n++)
    norm -= read.linear[n] * read.linear[n];
  assert_true(fabs(trace) < 1e-12 * made.omega2[14] &&
              fabs(norm) < 1e-11 * pow(made.omega2[14], 2));
  assert_int_equal(thrum_model_check(&made.model, NULL), THRUM_OK);
  thrum_vega_model_free(&made);
  thrum_imported_basis_free(&read);
}

int main(void) {
  if (!test_folder_make(folder))
    return 1;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_unit_is_that_of_lengths_and_materials),
      cmocka_unit_test(each_region_may_have_a_material_of_its_own),
      cmocka_unit_test(the_full_order_takes_unit_regions_and_order_of_a_mesh_too),
      cmocka_unit_test(check_names_regions_and_what_was_read),
      cmocka_unit_test(a_polynomial_alone_is_a_model_without_a_mesh),
      cmocka_unit_test(coordinates_are_turned_until_the_stiffness_is_diagonal),
  };
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  test_folder_remove(folder);
  return failed;
}
