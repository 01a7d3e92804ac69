/* Tests of `thrum precompute` and `thrum check` on what decks of other programs need: a unit, a
 * material for each region, the name of the regions, a polynomial without its mesh.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh.h"
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
  program_result run = PRECOMPUTE("--element", "tet");
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

/* How often a text has these words. */
static int count_of(const char *text, const char *words) {
  int count = 0;
  for (const char *at = strstr(text, words); at != NULL; at = strstr(at + 1, words))
    count++;
  return count;
}

/* A deck in millimetres whose materials are in SI, so that its lengths alone are wrong. */
#define BODY "body.msh", "--fix", "x<1", "--young", "1e9", "--poisson", "0.3", "--density", "1000"
#define PUSHED "--load", "constant:0,0,-1@all"

static void every_command_asks_once_for_the_unit_of_a_long_body(void **state) {
  (void)state;
  thrum_mesh mesh;
  assert_int_equal(thrum_mesh_read("beam:3x1x1@60x20x20", 1, &mesh, NULL), THRUM_OK);
  thrum_mesh_write_options options = {0};
  thrum_mesh_lost lost = {0};
  assert_int_equal(thrum_mesh_write(in_folder("body.msh"), &mesh, &options, &lost, NULL), THRUM_OK);
  thrum_mesh_free(&mesh);
  assert_true(
      text_file_write(in_folder("page.html"),
                      "<script type=\"application/octet-stream\" id=\"thrum-pack\"></script>"));
  setenv("THRUM_VIEWER", in_folder("page.html"), 1);
  assert_true(text_file_write(in_folder("scene.json"),
                              "{\"time\":0.01,\"bodies\":[{\"name\":\"a\",\"model\":\"body.msh\","
                              "\"material\":{\"young\":1e9,\"poisson\":0.3,\"density\":1000}}]}"));
  static const char *const commands[][20] = {
      {"precompute", BODY, "-o", "body.npz"},
      {"precompute", BODY, "--dry-run"},
      {"precompute", BODY, "--unit", "m-kg-s", "-o", "body.npz"},
      {"precompute", BODY, "--scale", "0.5", "-o", "body.npz"},
      {"static", BODY, "--full", PUSHED},
      {"simulate", BODY, "--full", PUSHED, "--time", "0.01", "-o", "run"},
      {"tradeoff", BODY, PUSHED, "--quick", "-o", "search"},
      {"convert", "body.msh", "body.vtu"},
      {"check", "body.msh"},
      {"simulate", "scene.json", "-o", "scene"},
      {"view", "scene.json", "-o", "scene.html"}};
  for (size_t n = 0; n < sizeof commands / sizeof *commands; n++) {
    const char *const *c = commands[n];
    program_result run =
        thrum_run(folder, c[0], c[1], c[2], c[3], c[4], c[5], c[6], c[7], c[8], c[9], c[10], c[11],
                  c[12], c[13], c[14], c[15], c[16], c[17], c[18], NULL);
    if (run.exit_code != 0 && run.exit_code != 3)
      fail_msg("%s %s: %s", c[0], c[1], run.err);
    const int asked = count_of(run.err, "is its file in millimetres?") +
                      count_of(run.out, "is its file in millimetres?");
    if (asked != (n == 2 || n == 3 ? 0 : 1))
      fail_msg("%s %s asks %d times: %s", c[0], c[1], asked, run.err);
    program_result_free(&run);
  }
  unsetenv("THRUM_VIEWER");
}

/* A generated body is asked about where it could not carry itself: not a bridge of steel, nor
 * jelly. */
static void a_beam_that_its_weight_would_crush_is_asked_for_its_unit(void **state) {
  (void)state;
  static const struct {
    int asked;
    const char *options[4];
  } cases[] = {{1, {"beam:4x1x1@1000x100x100"}},
               {0, {"beam:4x1x1@1000x100x100", "--scale", "0.001"}},
               {0, {"beam:4x1x1@1000x100x100", "--young", "2e11"}},
               {0, {"beam:4x1x1@40x10x10"}},
               {0, {"beam:4x1x1@9x1x1", "--young", "1e4"}}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    const char *const *o = cases[n].options;
    program_result run =
        thrum_run(folder, "precompute", "--dry-run", "--order", "1", o[0], o[1], o[2], o[3], NULL);
    assert_int_equal(run.exit_code, 0);
    if (count_of(run.err, "are its lengths in millimetres?") != cases[n].asked)
      fail_msg("%s: %s", o[0], run.err);
    program_result_free(&run);
  }
}

/* A unit is that of the file, not of options. */
static void options_in_the_unit_of_the_file_are_told_to_be_in_si(void **state) {
  (void)state;
  write_deck(true);
  program_result run = PRECOMPUTE("--unit", "mm-t-s", "--young", "2.1e5", "--density", "7.85e-9");
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "a density is 7.85e-09 kg/m^3"));
  assert_non_null(strstr(run.err, "options are in Pa and kg/m^3 whatever --unit says"));
  assert_null(strstr(run.err, "needs --unit"));
  program_result_free(&run);
  run = PRECOMPUTE("--unit", "mm-t-s", "--young", "2.1e11", "--density", "7850");
  assert_null(strstr(run.err, "kg/m^3"));
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
  const double unit = static_peak(STATIC("--unit", "mm-t-s", "--element", "tet", "--order", "1"));
  const double si =
      static_peak(STATIC("--scale", "0.001", "--element", "tet", "--order", "1", "--material",
                         "LOWER:2.1e11,0.3,7850", "--material", "UPPER:2.1e11,0.3,7850"));
  assert_true(unit > 0 && fabs(unit / si - 1) < 1e-9);

  // ten nodes bend more easily, and so does a lower half that is softer
  assert_true(static_peak(STATIC("--unit", "mm-t-s", "--order", "2")) > 1.2 * unit);
  assert_true(static_peak(STATIC("--unit", "mm-t-s", "--element", "tet", "--order", "1",
                                 "--material", "LOWER:1e11,0.3,7850")) > 1.2 * unit);

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
  program_result run = thrum_run(folder, "check", "deck.inp", "--unit", "mm-t-s", "--element",
                                 "tet", "--json", NULL);
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
  thrum_model_destroy(beam);
  thrum_model_destroy(cubic);

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
      cmocka_unit_test(every_command_asks_once_for_the_unit_of_a_long_body),
      cmocka_unit_test(a_beam_that_its_weight_would_crush_is_asked_for_its_unit),
      cmocka_unit_test(options_in_the_unit_of_the_file_are_told_to_be_in_si),
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
