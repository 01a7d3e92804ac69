/* Tests of a law for each region of a mesh, from the command line: the model file, runs beside the
 * unreduced mesh, flow in one region, and what is refused.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "runtime/material/material_law.h"
#include "tests/support/model_archive.h"
#include "tests/support/test_folder.h"

#define BODY                                                                                       \
  "bar.mesh", "--fix", "x<0.001", "--young", "1e6", "--poisson", "0.3", "--density", "1000", "-q"
#define MODEL "--modes", "5", "--rank", "15", "--cubature", "--cubature-error", "0.01"
#define MIXED "--material", "1:stvk", "--material", "2:neo-hookean"

static double number_of(const cJSON *object, const char *key) {
  const cJSON *found = cJSON_GetObjectItemCaseSensitive(object, key);
  assert_non_null(found);
  return found->valuedouble;
}

static void assert_done(program_result run) {
  if (run.exit_code != 0)
    fail_msg("%s%s", run.out, run.err);
  program_result_free(&run);
}

/* A beam whose tetrahedra of the first half are region 1, and of the other region 2. */
static int make_bar(void **state) {
  assert_int_equal(make_folder(state), 0);
  assert_done(thrum_run(folder, "convert", "beam:8x2x2@1x0.15x0.15,split=6", "one.mesh", NULL));
  FILE *from = fopen(in_folder("one.mesh"), "r"), *to = fopen(in_folder("bar.mesh"), "w");
  assert_true(from != NULL && to != NULL);

  // the last number of a tetrahedron is its region
  char line[256];
  long tets = -1, place = 0;
  while (fgets(line, sizeof line, from)) {
    long v[4];
    if (tets > 0 && place < tets && sscanf(line, "%ld %ld %ld %ld", v, v + 1, v + 2, v + 3) == 4)
      fprintf(to, "%ld %ld %ld %ld %d\n", v[0], v[1], v[2], v[3], place++ < tets / 2 ? 1 : 2);
    else
      fputs(line, to);
    if (tets == 0)
      tets = strtol(line, NULL, 10);
    tets = strncmp(line, "Tetrahedra", 10) == 0 ? 0 : tets;
  }

  // the mesh had tetrahedra
  fclose(from);
  assert_int_equal(fclose(to), 0);
  assert_true(place > 100);
  return 0;
}

/* A number of the JSON object that a run prints. */
static double figure(program_result run, const char *key) {
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const double value = number_of(object, key);
  cJSON_Delete(object);
  program_result_free(&run);
  return value;
}

static void a_model_of_two_laws_moves_and_rests_as_the_mesh_does(void **state) {
  (void)state;
  assert_done(
      thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, MIXED, "-o", "mixed.npz", NULL));
  program_result run = thrum_run(folder, "info", "mixed.npz", "--json", NULL);
  cJSON *object = json_line(run.out);
  assert_true(number_of(object, "format_major") == 4);
  const cJSON *laws = cJSON_GetObjectItemCaseSensitive(object, "region_laws");
  static const char *const expected[] = {"stvk", "neo-hookean"};
  for (int n = 0; n < 2; n++)
    assert_string_equal(
        cJSON_GetObjectItemCaseSensitive(cJSON_GetArrayItem(laws, n), "law")->valuestring,
        expected[n]);
  cJSON_Delete(object);
  program_result_free(&run);
  run = thrum_run(folder, "info", "mixed.npz", NULL);
  assert_non_null(strstr(run.out, "rho = 1000 kg/m^3, neo-hookean\n"));
  assert_non_null(strstr(run.out, "by region\n"));
  program_result_free(&run);

  // a swing of a third of the length, which keeps its energy
#define SWING "--load", "square:0,0,-60@vertices_2,until=0.2", "--time", "0.5", "--json", "-q"
  const double reduced = figure(
      thrum_run(folder, "simulate", "mixed.npz", SWING, "-o", "run", NULL), "peak_displacement_m");
  const double whole =
      figure(thrum_run(folder, "simulate", "mixed.npz", SWING, "--full", "-o", "whole", NULL),
             "peak_displacement_m");
  assert_true(reduced > 0.2 && fabs(reduced / whole - 1) < 0.02);
  assert_true(fabs(figure(thrum_run(folder, "simulate", "mixed.npz", SWING, "-o", "again", NULL),
                          "drift")) < 1e-13);

  // the model rests near its mesh, and the mesh by itself rests like that; another law does not
#define WEIGHT "--load", "constant:0,0,-20@vertices_2", "--json", "-q"
  const double rest =
      figure(thrum_run(folder, "static", "mixed.npz", WEIGHT, NULL), "peak_displacement_m");
  const double full = figure(thrum_run(folder, "static", "mixed.npz", WEIGHT, "--full", NULL),
                             "peak_displacement_m");
  const double mesh = figure(thrum_run(folder, "static", BODY, MIXED, "--order", "1", "--load",
                                       "constant:0,0,-20@vertices_2", "--full", "--json", NULL),
                             "peak_displacement_m");
  const double other =
      figure(thrum_run(folder, "static", "mixed.npz", WEIGHT, "--full", "--law", "stvk", NULL),
             "peak_displacement_m");
  assert_true(rest > 0.05 && fabs(rest / full - 1) < 0.02);
  assert_true(fabs(mesh / full - 1) < 1e-9 && fabs(other / full - 1) > 1e-4);
}

static void regions_of_one_law_are_the_file_of_that_law(void **state) {
  (void)state;
  size_t sizes[2];
  unsigned char *bytes[2];
  assert_done(thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, "--reproducible",
                        "--law", "corotational", "-o", "one.npz", NULL));
  assert_done(thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, "--reproducible",
                        "--material", "1:corotational", "--material", "2:1e6,0.3,1000,corotational",
                        "-o", "two.npz", NULL));
  static const char *const names[] = {"one.npz", "two.npz"};
  for (int n = 0; n < 2; n++) {
    FILE *file = fopen(in_folder(names[n]), "rb");
    assert_non_null(file);
    bytes[n] = malloc(1 << 20);
    assert_non_null(bytes[n]);
    sizes[n] = fread(bytes[n], 1, 1 << 20, file);
    fclose(file);
  }
  assert_true(sizes[0] > 1000 && sizes[0] < 1 << 20 && sizes[0] == sizes[1]);
  assert_memory_equal(bytes[0], bytes[1], sizes[0]);
  free(bytes[0]);
  free(bytes[1]);

  // the mesh of a model of several laws keeps them, unless one is asked for
  assert_done(
      thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, MIXED, "-o", "mixed.npz", NULL));
  assert_done(thrum_run(folder, "precompute", "mixed.npz", MODEL, "-q", "-o", "kept.npz", NULL));
  assert_true(figure(thrum_run(folder, "info", "kept.npz", "--json", NULL), "format_major") == 4);
  assert_done(thrum_run(folder, "precompute", "mixed.npz", MODEL, "-q", "--law", "stvk", "-o",
                        "kept.npz", NULL));
  assert_true(figure(thrum_run(folder, "info", "kept.npz", "--json", NULL), "format_major") == 1);
}

/* A scene of one body of the bar, of this material; the program's run of it. */
static program_result run_scene(const char *model, const char *material) {
  FILE *file = fopen(in_folder("scene.json"), "w");
  assert_non_null(file);
  fprintf(file,
          "{\"time\": 0.05, \"gravity\": [0, 0, -9.81], \"bodies\": [{\"model\": \"%s\",%s "
          "\"material\": {%s}}]}",
          model, strstr(model, ".mesh") ? " \"order\": 1, \"fix\": \"x<0.001\"," : "", material);
  assert_int_equal(fclose(file), 0);
  return thrum_run(folder, "simulate", "scene.json", "-o", "scene", "--json", "-q", NULL);
}

static void a_scene_gives_regions_of_a_mesh_their_materials(void **state) {
  (void)state;
#define ALL "\"young\": 1e6, \"poisson\": 0.3, \"density\": 1000"
  static const char *const materials[] = {
      ALL ", \"law\": \"neo-hookean\"", ALL ", \"regions\": \"2:neo-hookean\"",
      ALL ", \"law\": \"corotational\", \"regions\": [\"1:2e6,0.3,1000,stvk\", \"2:neo-hookean\"]"};
  static const char *const laws[] = {"neo-hookean", NULL, NULL};
  double energy[3];
  for (int n = 0; n < 3; n++) {
    program_result run = run_scene("bar.mesh", materials[n]);
    if (run.exit_code != 0)
      fail_msg("%s", run.err);
    cJSON *object = json_line(run.out);
    const cJSON *body = cJSON_GetArrayItem(cJSON_GetObjectItem(object, "bodies"), 0);
    const char *law = cJSON_GetObjectItem(body, "law")->valuestring;
    assert_string_equal(law, laws[n] ? laws[n] : thrum_law_name(THRUM_LAW_BY_REGION));
    energy[n] = number_of(body, "energy_last_j");
    cJSON_Delete(object);
    program_result_free(&run);
  }
  assert_true(energy[0] != energy[1] && energy[1] != energy[2]);

  // what is no material, no region, or of a model
  static const struct {
    const char *model, *material, *says;
  } wrong[] = {
      {"bar.mesh", "\"regions\": [\"1:stvk\", \"2:rubber\"]", "is no material of a region"},
      {"bar.mesh", ALL ", \"regions\": \"3:neo-hookean\"", "'3' is no region; regions are 1 to 2"},
      {"bar.mesh", "\"regions\": 7", "regions"},
      {"bar.mesh", "\"regions\": \"1:stvk\", \"yield\": 0.1", "or a region of one"},
      {"beam", "\"regions\": \"1:stvk\"", "is of a mesh"},
  };
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++) {
    program_result run = run_scene(wrong[n].model, wrong[n].material);
    assert_true(run.exit_code != 0);
    if (!strstr(run.err, wrong[n].says))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void tradeoff_says_how_a_model_of_one_law_is_made_of_a_mesh_of_several(void **state) {
  (void)state;
  assert_done(thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, MIXED, "-q", "-o",
                        "mixed.npz", NULL));
  program_result run =
      thrum_run(folder, "tradeoff", "mixed.npz", "--law", "stvk", "--quick", "--ranks", "8",
                "--load", "square:0,0,-10@vertices_2", "--time", "0.1", "--cubature", "off", "-o",
                "trade", "--error", "90%", "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);

  // precompute would take the laws of the regions from the file
  cJSON *object = json_line(run.out);
  const cJSON *commands = cJSON_GetObjectItemCaseSensitive(object, "commands");
  const cJSON *made = cJSON_GetObjectItemCaseSensitive(commands, "precompute");
  assert_true(cJSON_IsString(made));
  if (!strstr(made->valuestring, " --law stvk"))
    fail_msg("%s", made->valuestring);
  cJSON_Delete(object);
  program_result_free(&run);
}

static void a_region_with_a_yield_flows_and_the_account_closes(void **state) {
  (void)state;
  assert_done(thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, "--material",
                        "1:corotational,0.02", "--material", "2:stvk", "-o", "flow.npz", NULL));
#define PULL "--load", "square:0,0,-60@vertices_2,until=0.2", "--time", "0.4", "--json", "-q"
  double taken[2];
  for (int whole = 0; whole < 2; whole++) {
    program_result run = thrum_run(folder, "simulate", "flow.npz", PULL, "-o",
                                   whole ? "mesh" : "flow", whole ? "--full" : NULL, NULL);
    if (run.exit_code != 0)
      fail_msg("%s", run.err);
    cJSON *object = json_line(run.out);
    const cJSON *work = cJSON_GetObjectItemCaseSensitive(object, "work");
    taken[whole] = number_of(work, "plastic_j");
    const double load = number_of(work, "load_j");
    assert_true(taken[whole] > 0.1 * load && taken[whole] < load);
    assert_true(fabs(number_of(work, "balance_j")) <= 1e-8 * load);
    cJSON_Delete(object);
    program_result_free(&run);
  }
  assert_true(fabs(taken[0] / taken[1] - 1) < 0.2);

  // one law for the whole body takes the yield away, and with it what stresses do not go with
  assert_done(thrum_run(folder, "simulate", "flow.npz", "--full", "--law", "corotational",
                        "--stress", PULL, "-o", "whole", NULL));

  // learned points have no place at which something flows
  program_result learned = thrum_run(folder, "precompute", BODY, "--order", "1", MODEL,
                                     "--material", "1:corotational,0.02", "--material", "2:stvk",
                                     "--cubature-refine", "9", "-o", "none.npz", NULL);
  assert_true(learned.exit_code != 0 && learned.exit_code != 3);
  assert_non_null(strstr(learned.err, "not refined where a region has a yield"));
  program_result_free(&learned);

  // what a yield does not go with
  static const struct {
    const char *command, *arguments[2], *says;
  } cases[] = {
      {"simulate", {"--integrator=imexv", "-q"}, "a region of this model has a yield of its own"},
      {"simulate", {"--stress", "-q"}, "--stress is of a material that does not flow"},
      {"tradeoff", {"--quick", "--load=impulse:0,0,-1@vertices_2"}, "has a region that flows"},
  };
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    program_result run = thrum_run(folder, cases[n].command, "flow.npz", "-o", "none",
                                   cases[n].arguments[0], cases[n].arguments[1], NULL);
    assert_int_equal(run.exit_code, 1);
    if (!strstr(run.err, cases[n].says))
      fail_msg("%s", run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void laws_of_regions_that_cannot_be_are_refused_in_one_line(void **state) {
  (void)state;
  static const struct {
    int code;
    const char *arguments[4], *says;
  } cases[] = {
      {1, {"--material", "3:neo-hookean", "--cubature"}, "'3' is no region; regions are 1 to 2"},
      {1, {"--material", "1:neo-hookean"}, "need --cubature: a polynomial cannot hold them"},
      {1, {"--material", "1:stvk", "--material", "1:stvk"}, "region '1' comes twice"},
      {2, {"--material", "1:stvk", "--yield=0.1", "--cubature"}, "--yield needs"},
      {2, {"--material", "1:rubber", "--cubature"}, "is no material of a region"},
      {2, {"--material", "1:stvk,0.02", "--cubature"}, "stvk has no yield"},
      {2, {"--material", "1:corotational,0", "--cubature"}, "YIELD is a strain, above 0"},
      {2, {"--material", "1:corotational,-1", "--cubature"}, "YIELD is a strain, above 0"},
      {2, {"--material", "1:corotational,nan", "--cubature"}, "YIELD is a strain, above 0"},
      {2, {"--material", "1:corotational,0.1,2", "--cubature"}, "is no material of a region"},
      {2, {"--material", "1:corotational,", "--cubature"}, "is no material of a region"},
      {2, {"--material", "1:1e6,corotational", "--cubature"}, "is no material of a region"},
  };
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    const char *const *a = cases[n].arguments;
    program_result run = thrum_run(folder, "precompute", BODY, "--order", "1", "-o", "none.npz",
                                   a[0], a[1], a[2], a[3], NULL);
    if (run.exit_code != cases[n].code || !strstr(run.err, cases[n].says))
      fail_msg("case %d: exit %d: %s", (int)n, run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }

  // one law for the whole body, or laws of regions
  program_result run = thrum_run(folder, "static", BODY, MIXED, "--order", "1", "--full", "--law",
                                 "stvk", "--load", "gravity:0,0,-1", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "--material gives a region one of its own"));
  program_result_free(&run);

  // what they would take is said without them being made
  run = thrum_run(folder, "precompute", BODY, "--order", "1", MODEL, MIXED, "--dry-run", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

#define PADDED THRUM_TEST_DATA "/../../examples/scenes/padded.msh"

/* A model knows its regions by the names of the mesh, and so does what is made of the model. */
static void regions_keep_their_names_in_the_model(void **state) {
  (void)state;
#define NAMED                                                                                      \
  "--modes", "2", "--rank", "4", "--cubature", "--cubature-points", "20", "--cubature-error", "1", \
      "-q", "-o"
  assert_done(thrum_run(folder, "precompute", PADDED, "--order", "1", NAMED, "named.npz",
                        "--material", "block:2e7,0.3,1500,stvk", "--material",
                        "pad:2e5,0.4,1000,corotational,0.02", NULL));
  program_result run = thrum_run(folder, "info", "named.npz", NULL);
  assert_non_null(strstr(run.out, "region 1, pad: E = 200000 Pa, nu = 0.4, rho = 1000 kg/m^3, "
                                  "corotational, flows beyond a strain of 0.02\n"));
  assert_non_null(strstr(run.out, "region 2, block: E = 2e+07 Pa, nu = 0.3"));
  program_result_free(&run);
  run = thrum_run(folder, "info", "named.npz", "--json", NULL);
  cJSON *object = json_line(run.out);
  static const char *const lists[] = {"materials", "region_laws"};
  for (int n = 0; n < 2; n++) {
    const cJSON *second = cJSON_GetArrayItem(cJSON_GetObjectItem(object, lists[n]), 1);
    assert_string_equal(cJSON_GetObjectItem(second, "name")->valuestring, "block");
    assert_true(number_of(second, "region") == 2);
  }
  cJSON_Delete(object);
  program_result_free(&run);

  // the mesh of the model has them as well
  run = thrum_run(folder, "precompute", "named.npz", NAMED, "none.npz", "--material", "head:stvk",
                  NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "'head' is no region; the regions are pad, block\n"));
  program_result_free(&run);
  assert_done(thrum_run(folder, "precompute", "named.npz", NAMED, "again.npz", "--material",
                        "block:1e7,0.3,1500", NULL));
  run = thrum_run(folder, "info", "again.npz", NULL);
  assert_non_null(strstr(run.out, "region 2, block: E = 1e+07 Pa"));
  program_result_free(&run);
}

/* A rate and a bound are those of the regions that flow, and want no yield of the others. */
static void a_rate_goes_with_the_yield_of_a_region(void **state) {
  (void)state;
  double strain[3];
  static const char *const options[] = {NULL, "--creep=0.1", "--largest-plastic-strain=0.001"};
  for (int n = 0; n < 3; n++)
    strain[n] =
        figure(thrum_run(folder, "simulate", "flow.npz", PULL, "-o", "slow", options[n], NULL),
               "plastic_strain");
  assert_true(strain[0] > 0.01 && strain[1] < 0.5 * strain[0]);
  assert_true(strain[2] <= 0.001 * (1 + 1e-9) && strain[2] > 0);

  // the same in a scene, whose key that is
  assert_true(text_file_write(in_folder("slow.json"),
                              "{\"time\": 0.1, \"bodies\": [{\"model\": \"flow.npz\", "
                              "\"material\": {\"creep\": 0.1}}]}"));
  assert_done(thrum_run(folder, "simulate", "slow.json", "-o", "creeps", "-q", NULL));
  assert_true(text_file_write(in_folder("slow.json"),
                              "{\"time\": 0.1, \"bodies\": [{\"model\": \"mixed.npz\", "
                              "\"material\": {\"creep\": 0.1}}]}"));
  program_result run = thrum_run(folder, "simulate", "slow.json", "-o", "creeps", "-q", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "bodies[0].material.yield: is needed"));
  program_result_free(&run);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_model_of_two_laws_moves_and_rests_as_the_mesh_does),
      cmocka_unit_test(regions_of_one_law_are_the_file_of_that_law),
      cmocka_unit_test(a_scene_gives_regions_of_a_mesh_their_materials),
      cmocka_unit_test(tradeoff_says_how_a_model_of_one_law_is_made_of_a_mesh_of_several),
      cmocka_unit_test(a_region_with_a_yield_flows_and_the_account_closes),
      cmocka_unit_test(regions_keep_their_names_in_the_model),
      cmocka_unit_test(a_rate_goes_with_the_yield_of_a_region),
      cmocka_unit_test(laws_of_regions_that_cannot_be_are_refused_in_one_line),
  };
  return cmocka_run_group_tests(tests, make_bar, remove_folder);
}
