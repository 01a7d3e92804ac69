/* `thrum convert` and `thrum check` are run as they are typed and tested by their exit codes, JSON,
 * warnings and files.
 * SPDX-License-Identifier: Apache-2.0 */
// clang-format off
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on

#include "tests/support/test_folder.h"

#include <math.h>

static cJSON *run_json(int exit_code, program_result run) {
  assert_int_equal(run.exit_code, exit_code);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static bool has_flag(const cJSON *object, const char *name) {
  const cJSON *flag;
  cJSON_ArrayForEach(flag, cJSON_GetObjectItem(object, "flags")) {
    if (strcmp(cJSON_GetObjectItem(flag, "name")->valuestring, name) == 0)
      return true;
  }
  return false;
}

static void converting_there_and_back_gives_the_same_check(void **state) {
  (void)state;
  static const char *const names[] = {"a.veg", "a.msh", "a.node", "a.mesh",
                                      "a.vtk", "a.vtu", "a.inp"};
  cJSON *first = run_json(0, thrum_run(folder, "check", "beam:6x3x3@1x0.3x0.3", "--json", NULL));
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    // each format holds the same mesh
    cJSON *converted =
        run_json(0, thrum_run(folder, "convert", "beam:6x3x3@1x0.3x0.3", names[i], "--json", NULL));
    assert_true(json_value(converted, "vertices") == json_value(first, "vertices"));
    cJSON *check = run_json(0, thrum_run(folder, "check", names[i], "--json", NULL));

    // counts and measures survive the way there and back exactly
    static const char *const keys[] = {"vertices", "tets", "volume_m3", "ratio_min", "genus"};
    for (size_t k = 0; k < sizeof keys / sizeof *keys; k++)
      assert_true(json_value(check, keys[k]) == json_value(first, keys[k]));
    cJSON_Delete(check);
    cJSON_Delete(converted);
  }
  cJSON_Delete(first);
}

/* How often the command asks for the unit of a mesh. */
static int questions(program_result run) {
  int count = 0;
  for (const char *at = run.err; (at = strstr(at, "m long: is its file in")) != NULL; at++)
    count++;
  if (run.exit_code != 0 && run.exit_code != 3)
    fail_msg("exit code %d: %s", run.exit_code, run.err);
  program_result_free(&run);
  return count;
}

/* Every command that takes a mesh asks once for the unit of one that is 120 m long, and a unit or a
 * scale answers it; a generator's numbers are metres. */
static void the_unit_of_a_long_body_is_asked_for_once(void **state) {
  (void)state;
  static const char *const material[] = {"--young",   "2.1e11", "--poisson", "0.3",
                                         "--density", "7850",   "-q"};
#define OF(command, mesh, ...)                                                                     \
  questions(thrum_run(folder, command, mesh, "--fix", "x<0.001", material[0], material[1],         \
                      material[2], material[3], material[4], material[5], __VA_ARGS__, NULL))
#define LOAD "--load", "constant:0,0,-1@tip"
  assert_int_equal(
      questions(thrum_run(folder, "convert", "beam:6x2x2@120x20x20", "long.vtu", NULL)), 0);
  assert_int_equal(OF("precompute", "long.vtu", "-o", "m.npz", "-q"), 1);
  assert_int_equal(OF("precompute", "long.vtu", "-o", "m.npz", "-q", "--scale", "0.001"), 0);
  assert_int_equal(OF("precompute", "long.vtu", "-o", "m.npz", "-q", "--unit", "mm-t-s"), 0);
  assert_int_equal(OF("precompute", "long.vtu", "-o", "m.npz", "-q", "--unit", "m-kg-s"), 0);
  assert_int_equal(OF("precompute", "beam:6x2x2@120x20x20", "-o", "m.npz", "-q"), 0);
  assert_int_equal(OF("static", "long.vtu", "--full", LOAD), 1);
  assert_int_equal(OF("simulate", "long.vtu", "--full", "-o", "r", "--time", "0.002", "--dt",
                      "0.001", "-q", LOAD),
                   1);
  assert_int_equal(questions(thrum_run(folder, "convert", "long.vtu", "other.vtu", NULL)), 1);
  assert_int_equal(
      questions(thrum_run(folder, "convert", "long.vtu", "o.vtu", "--scale", "0.001", NULL)), 0);

  // a scene of two bodies of the mesh
  assert_true(
      text_file_write(in_folder("long.json"),
                      "{\"time\": 0.002, \"dt\": 0.001, \"bodies\": ["
                      "{\"model\": \"long.vtu\", \"fix\": \"x<1\"},"
                      "{\"model\": \"long.vtu\", \"fix\": \"x<1\", \"position\": [0, 99, 0]}]}"));
  assert_int_equal(questions(thrum_run(folder, "simulate", "long.json", "-o", "s", "-q", NULL)), 1);

  // what is flagged with a unit is what the unit has not explained
  cJSON *check = run_json(3, thrum_run(folder, "check", "long.vtu", "--json", NULL));
  assert_true(has_flag(check, "units"));
  cJSON_Delete(check);
  check = run_json(0, thrum_run(folder, "check", "long.vtu", "--scale", "0.001", "--json", NULL));
  assert_false(has_flag(check, "units"));
  cJSON_Delete(check);

  // steel in MPa, by an option
  program_result run =
      thrum_run(folder, "precompute", "long.vtu", "--scale", "0.001", "--fix", "x<0.001", "--young",
                "2.1e5", "--density", "7850", "-o", "m.npz", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "no material has a Young's modulus of 2.1e+05 Pa"));
  program_result_free(&run);
#undef LOAD
#undef OF
}

static void order_makes_and_drops_middle_nodes(void **state) {
  (void)state;

  // ten nodes there and back, and by their corners
  cJSON *made = run_json(0, thrum_run(folder, "convert", "beam:2x2x2@1x1x1", "ten.msh", "--order",
                                      "2", "--json", NULL));
  assert_true(json_value(made, "order") == 2 && json_value(made, "vertices") == 125);
  cJSON_Delete(made);
  cJSON *check = run_json(0, thrum_run(folder, "check", "ten.msh", "--json", NULL));
  assert_true(json_value(check, "order") == 2 && json_value(check, "vertices") == 125);
  cJSON_Delete(check);
  program_result run = thrum_run(folder, "convert", "ten.msh", "four.veg", "--order", "1", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "48 tetrahedra of ten nodes were read by their corners"));
  assert_non_null(strstr(run.out, "27 vertices, 48 tetrahedra"));
  program_result_free(&run);

  // a format without ten nodes is refused, and so is another order
  run = thrum_run(folder, "convert", "ten.msh", "ten.veg", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "Vega's format has no tets of ten nodes"));
  program_result_free(&run);
  run = thrum_run(folder, "check", "ten.msh", "--order", "3", NULL);
  assert_int_equal(run.exit_code, 2);
  program_result_free(&run);
}

static void a_group_or_material_that_the_format_cannot_hold_is_warned_of(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "convert", "beam:2x2x2@1x1x1", "b.msh", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "warning: b.msh: 1 material has no place in this format"));
  program_result_free(&run);
  run = thrum_run(folder, "convert", "beam:2x2x2@1x1x1", "b.veg", NULL);
  assert_non_null(strstr(run.err, "warning: b.veg: 7 groups have no place in this format"));
  program_result_free(&run);
}

static void a_likely_mistake_is_flagged_with_exit_code_3(void **state) {
  (void)state;
  cJSON *large = run_json(3, thrum_run(folder, "check", "beam:6x3x3@1000x300x300", "--json", NULL));
  assert_true(has_flag(large, "units"));
  assert_string_equal(cJSON_GetObjectItem(large, "status")->valuestring, "flagged");
  cJSON_Delete(large);
  program_result run = thrum_run(folder, "check", "beam:6x3x3@1000x300x300", NULL);
  assert_int_equal(run.exit_code, 3);
  assert_non_null(strstr(run.out, "is its file in millimetres? --scale 0.001"));
  program_result_free(&run);
}

static void a_model_by_name_is_checked_with_its_material(void **state) {
  (void)state;
  cJSON *check = run_json(0, thrum_run(folder, "check", "beam", "--json", NULL));
  assert_true(json_value(check, "tets") == 1080);
  assert_true(json_value(check, "mass_kg") > 0);
  cJSON_Delete(check);
}

/* Two thin wedges, each taken as three hexahedra, have the numbers of their file. */
static void the_worst_elements_are_those_of_the_file(void **state) {
  (void)state;
  static const char deck[] =
      "*NODE\n101,0,0,0\n102,1,0,0\n103,1,1,0\n104,0,1,0\n"
      "105,0,0,0.1\n106,1,0,0.1\n107,1,1,0.1\n108,0,1,0.1\n"
      "*ELEMENT, TYPE=C3D6\n21,101,102,103,105,106,107\n22,101,103,104,105,107,108\n";
  assert_true(text_file_write(in_folder("wedges.inp"), deck));
  cJSON *check = run_json(0, thrum_run(folder, "check", "wedges.inp", "--json", NULL));
  int rows = 0;
  const cJSON *row, *number;
  cJSON_ArrayForEach(row, cJSON_GetObjectItem(check, "worst_elements")) {
    const double element = json_value(row, "element");
    assert_true(element == 21 || element == 22);
    cJSON_ArrayForEach(number, cJSON_GetObjectItem(row, "vertices"))
        assert_true(number->valuedouble >= 101 && number->valuedouble <= 108);
    rows++;
  }
  assert_int_equal(rows, 5);
  cJSON_Delete(check);
}

static void one_of_a_kind_is_said_in_the_singular(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "check", "beam:1x1x1@1x1x1", NULL);
  assert_non_null(strstr(run.out, "1 cell over the thickness"));
  program_result_free(&run);
}

static void wrong_arguments_and_unknown_formats_are_refused(void **state) {
  (void)state;
  static const struct {
    int exit_code;
    const char *arguments[5];
    const char *words;
  } cases[] = {{1, {"check", "no.msh"}, "no.msh"},
               {1, {"check", "no.stl"}, "no.stl: unknown kind of mesh; it is a surface"},
               {1, {"check", "no.npz"}, "thrum info says what a model file holds"},
               {1, {"check", "no.txt"}, "unknown kind of mesh; give a .veg"},
               {2, {"check"}, "no mesh given"},
               {2, {"check", "--scale", "-1", "x"}, "--scale wants a number above 0"},
               {2, {"check", "--jsno", "x"}, "did you mean '--json'"},
               {2, {"convert", "a.msh"}, "IN OUT"},
               {2, {"convert", "--msh", "3", "a.msh", "b.msh"}, "--msh wants 2.2 or 4.1"},
               {1, {"convert", "beam:2x2x2@1x1x1", "x.stl"}, "x.stl: unknown kind of mesh"},
               {1, {"convert", "beam:2x2x2@1x1x1", "no/x.vtu"}, "no/x.vtu"}};

  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    const char *const *a = cases[i].arguments;
    program_result run = thrum_run(folder, a[0], a[1], a[2], a[3], a[4], NULL);
    assert_int_equal(run.exit_code, cases[i].exit_code);
    if (!strstr(run.err, cases[i].words))
      fail_msg("expected '%s' in: %s", cases[i].words, run.err);

    // a refusal is one line, and standard output stays empty
    assert_true(line_count_is(run.err, 1));
    assert_string_equal(run.out, "");
    program_result_free(&run);
  }
}

int main(void) {
  if (test_folder_make(folder) == NULL)
    return 1;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(converting_there_and_back_gives_the_same_check),
      cmocka_unit_test(the_unit_of_a_long_body_is_asked_for_once),
      cmocka_unit_test(order_makes_and_drops_middle_nodes),
      cmocka_unit_test(a_group_or_material_that_the_format_cannot_hold_is_warned_of),
      cmocka_unit_test(a_likely_mistake_is_flagged_with_exit_code_3),
      cmocka_unit_test(a_model_by_name_is_checked_with_its_material),
      cmocka_unit_test(the_worst_elements_are_those_of_the_file),
      cmocka_unit_test(one_of_a_kind_is_said_in_the_singular),
      cmocka_unit_test(wrong_arguments_and_unknown_formats_are_refused),
  };
  const int failed = cmocka_run_group_tests(tests, NULL, NULL);
  test_folder_remove(folder);
  return failed;
}
