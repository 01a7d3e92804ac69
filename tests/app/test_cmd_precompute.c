/* Tests of `thrum precompute` as a command: its results, its options, and what it refuses.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/test_folder.h"
#include "thrum/thrum.h"

#define BEAM "beam:8x2x2@1x0.1x0.1"
#define ROOT "x<0.001"

/* Returns the k-th number of an array in an object; NaN when there is none. */
static double number_at(const cJSON *object, const char *key, int k) {
  const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItemCaseSensitive(object, key), k);
  return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static int count_of(const cJSON *object, const char *key) {
  return cJSON_GetArraySize(cJSON_GetObjectItemCaseSensitive(object, key));
}

/* Runs a precompute that must succeed, with up to two more options; returns its JSON. */
static cJSON *precompute(const char *mesh, const char *fix, const char *option, const char *value,
                         const char *option2, const char *value2) {
  program_result run =
      thrum_run(folder, "precompute", mesh, "--order", "1", "-o", "made.npz", "--fix", fix,
                "--modes", "4", "--rank", "8", "--json", option, value, option2, value2, NULL);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

/* Asserts that each frequency of `b` is `factor` times that of `a`. */
static void assert_frequencies_scale(const cJSON *a, const cJSON *b, double factor) {
  static const char *const keys[] = {"frequencies_hz", "basis_frequencies_hz"};
  for (int key = 0; key < 2; key++) {
    const int count = count_of(a, keys[key]);
    assert_true(count > 0);
    assert_int_equal(count, count_of(b, keys[key]));
    for (int k = 0; k < count; k++) {
      const double expected = factor * number_at(a, keys[key], k);
      assert_true(fabs(number_at(b, keys[key], k) - expected) <= 1e-7 * expected);
    }
  }
}

static void beam_gives_the_documented_keys(void **state) {
  (void)state;

  // the counts follow from the grid of cells, six tetrahedra in each
  cJSON *object = precompute(BEAM, ROOT, NULL, NULL, NULL, NULL);
  assert_true(json_value(object, "vertices") == 9 * 3 * 3);
  assert_true(json_value(object, "tets") == 8 * 2 * 2 * 6);
  assert_true(json_value(object, "fixed") == 3 * 3);
  assert_true(json_value(object, "rank") == 8);
  assert_true(json_value(object, "modes") == 4);

  // a frequency is listed for each mode and for each basis vector
  assert_int_equal(count_of(object, "frequencies_hz"), 4);
  assert_int_equal(count_of(object, "basis_frequencies_hz"), 8);
  assert_true(json_value(object, "explicit_modes") + json_value(object, "implicit_modes") == 8);

  // 1 m x 0.1 m x 0.1 m of the default 1000 kg/m^3
  assert_true(fabs(json_value(object, "volume_m3") - 0.01) < 1e-14);
  assert_true(fabs(json_value(object, "mass_kg") - 10) < 1e-11);
  assert_true(json_value(object, "peak_mb") > 1);

  // basis vectors are ordered by frequency
  for (int k = 1; k < 8; k++) {
    assert_true(number_at(object, "basis_frequencies_hz", k) >=
                number_at(object, "basis_frequencies_hz", k - 1));
  }

  cJSON_Delete(object);
}

/* Two directions of the derivatives for each mode, at most half of those that there are, and 30. */
static void a_rank_that_is_not_given_has_room_for_derivatives(void **state) {
  (void)state;
  static const char *const modes[] = {"1", "3", "12", "20"};
  static const double ranks[] = {2, 6, 36, 50};
  for (int n = 0; n < 4; n++) {
    program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "made.npz",
                                   "--fix", ROOT, "--modes", modes[n], "--json", NULL);
    assert_int_equal(run.exit_code, 0);
    cJSON *object = json_line(run.out);
    assert_non_null(object);
    assert_true(json_value(object, "rank") == ranks[n]);
    cJSON_Delete(object);
    program_result_free(&run);
  }
}

static void stages_do_not_overlap(void **state) {
  (void)state;
  cJSON *object = precompute(BEAM, ROOT, NULL, NULL, NULL, NULL);

  // sum the stages without their total
  const cJSON *seconds = cJSON_GetObjectItemCaseSensitive(object, "seconds");
  const double total = json_value(seconds, "total");
  double sum = 0;
  int stages = 0;
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, seconds) {
    assert_true(item->valuedouble >= 0);
    if (strcmp(item->string, "total") == 0)
      continue;
    sum += item->valuedouble;
    stages++;
  }

  // times that overlapped would add up to more than the total
  assert_true(stages >= 6);
  assert_true(total > 0 && sum <= total * (1 + 1e-9));
  cJSON_Delete(object);
}

static void json_is_alone_on_standard_output(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "made.npz",
                                 "--fix", ROOT, "--modes", "3", "--rank", "6", "--json", NULL);
  assert_int_equal(run.exit_code, 0);

  cJSON *object = json_line(run.out);
  assert_non_null(object);
  cJSON_Delete(object);

  // progress goes to standard error, as plain lines when that is no terminal
  assert_non_null(strstr(run.err, "linear modes"));
  assert_null(strchr(run.err, '\r'));
  program_result_free(&run);

  // with --quiet only the summary is left, on standard output, and a warning of what locks
  run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "made.npz", "--fix", ROOT,
                  "--modes", "3", "--rank", "6", "--quiet", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, BEAM ": its linear tetrahedra are too stiff: first"));
  assert_ptr_equal(strchr(run.err, '\n'), run.err + strlen(run.err) - 1);
  assert_non_null(strstr(run.out, "81 vertices"));
  program_result_free(&run);

  // two cells of ten nodes are a little too stiff where the volume hardly changes, as here
  run = thrum_run(folder, "precompute", BEAM, "-o", "made.npz", "--fix", ROOT, "--modes", "3",
                  "--rank", "6", "--order", "2", "--quiet", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, BEAM ": its ten-node tetrahedra are too stiff: first"));
  program_result_free(&run);

  // and leave nothing to warn of where it does
  run = thrum_run(folder, "precompute", BEAM, "-o", "made.npz", "--fix", ROOT, "--modes", "3",
                  "--rank", "6", "--order", "2", "--poisson", "0", "--quiet", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_string_equal(run.err, "");
  program_result_free(&run);
}

static void two_reproducible_runs_write_the_same_bytes(void **state) {
  (void)state;
  const char *names[] = {"first.npz", "second.npz"};

  for (int n = 0; n < 2; n++) {
    program_result run =
        thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", names[n], "--fix", ROOT,
                  "--modes", "4", "--rank", "8", "--reproducible", NULL);
    assert_int_equal(run.exit_code, 0);
    program_result_free(&run);
  }

  // a file that held a time or an address would differ
  char compare[] = "/usr/bin/cmp";
  char first[] = "first.npz", second[] = "second.npz";
  char *argv[] = {compare, first, second, NULL};
  program_result same = program_execute(folder, argv);
  assert_int_equal(same.exit_code, 0);
  program_result_free(&same);
}

static void generator_equals_the_reference_file(void **state) {
  (void)state;
  cJSON *generated = precompute("beam:20x3x3@1x0.15x0.15,split=6", ROOT, NULL, NULL, NULL, NULL);

  cJSON *read = precompute(THRUM_TEST_DATA "/beam1k.veg", THRUM_TEST_DATA "/beam1k.bou", NULL, NULL,
                           NULL, NULL);

  // the counts are the same, and so are the frequencies
  static const char *const same[] = {"vertices", "tets", "fixed", "free_dofs"};
  for (int n = 0; n < 4; n++) {
    assert_true(json_value(generated, same[n]) == json_value(read, same[n]));
  }
  assert_frequencies_scale(generated, read, 1);

  cJSON_Delete(generated);
  cJSON_Delete(read);
}

/* omega^2 = k/m: stiffness enters once, mass once, and lengths as 1/L. */
static void material_and_scale_act_as_physics_says(void **state) {
  (void)state;
  const char *mesh = THRUM_TEST_DATA "/beam1k.veg", *fix = THRUM_TEST_DATA "/beam1k.bou";

  // each model differs from the plain one in one quantity
  cJSON *plain = precompute(mesh, fix, NULL, NULL, NULL, NULL);
  cJSON *stiff = precompute(mesh, fix, "--young", "2e7", NULL, NULL);
  cJSON *heavy = precompute(mesh, fix, "--density", "4000", NULL, NULL);
  cJSON *large = precompute(mesh, fix, "--scale", "2", NULL, NULL);
  cJSON *named = precompute(mesh, fix, "--young", "5e6", "--poisson", "0.4");

  // frequencies go as the root of stiffness over mass; the values named are those of the file
  assert_frequencies_scale(plain, stiff, 2);
  assert_frequencies_scale(plain, heavy, 0.5);
  assert_frequencies_scale(plain, large, 0.5);
  assert_frequencies_scale(plain, named, 1);

  // the mass grows as the cube of the scale
  assert_true(fabs(json_value(large, "mass_kg") / json_value(plain, "mass_kg") - 8) < 1e-12);

  cJSON_Delete(plain);
  cJSON_Delete(stiff);
  cJSON_Delete(heavy);
  cJSON_Delete(large);
  cJSON_Delete(named);
}

/* The lumped mass minus the consistent one is positive semidefinite tet by tet, so no eigenvalue
 * may be larger with it. */
static void lumped_mass_never_raises_a_frequency(void **state) {
  (void)state;
  cJSON *consistent = precompute(BEAM, ROOT, "--mass", "consistent", NULL, NULL);
  cJSON *lumped = precompute(BEAM, ROOT, "--mass", "lumped", NULL, NULL);
  for (int k = 0; k < 4; k++) {
    const double above = number_at(consistent, "frequencies_hz", k);
    assert_true(number_at(lumped, "frequencies_hz", k) < above);
    assert_true(number_at(lumped, "frequencies_hz", k) > 0.5 * above);
  }
  cJSON_Delete(consistent);
  cJSON_Delete(lumped);
}

static void fix_takes_predicates_files_groups_and_axes(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("held.bou"), "1, 2 3\n4:9 # the root\n"));

  // four ways to hold the root, and one that holds more
  cJSON *predicate = precompute(BEAM, ROOT, NULL, NULL, NULL, NULL);
  cJSON *file = precompute(BEAM, "held.bou", NULL, NULL, NULL, NULL);
  cJSON *group = precompute(BEAM, "left", NULL, NULL, NULL, NULL);
  cJSON *axes = precompute(BEAM, "left:xyz", NULL, NULL, NULL, NULL);
  cJSON *both = precompute(BEAM, "left:xy", "--fix", "left:z", NULL, NULL);
  cJSON *more = precompute(BEAM, ROOT, "--fix", "x>0.999:y", NULL, NULL);

  // each of them holds the same nine vertices
  const cJSON *same[] = {file, group, axes, both};
  for (int n = 0; n < 4; n++) {
    assert_true(json_value(same[n], "fixed") == 9);
    assert_frequencies_scale(predicate, same[n], 1);
  }

  // nine vertices more are held along one axis
  assert_true(json_value(more, "fixed") == 18);
  assert_true(json_value(more, "free_dofs") == 3 * (81 - 9) - 9);

  // a constraint more raises every frequency, or leaves it
  assert_true(number_at(more, "frequencies_hz", 0) >= number_at(predicate, "frequencies_hz", 0));

  cJSON_Delete(predicate);
  cJSON_Delete(file);
  cJSON_Delete(group);
  cJSON_Delete(axes);
  cJSON_Delete(both);
  cJSON_Delete(more);
}

static void meta_says_what_was_done_but_not_where(void **state) {
  (void)state;
  const char *path = in_folder("held.bou");
  assert_true(text_file_write(path, "1:9\n"));
  cJSON *line = precompute(BEAM, path, "--fix", "y<0&x<0.001", NULL, NULL);

  const thrum_model *model = NULL;
  assert_int_equal(thrum_model_load(in_folder("made.npz"), &model, NULL), THRUM_OK);

  // the version and the hash of the mesh identify how the model was made
  cJSON *meta = cJSON_ParseWithLength((const char *)model->meta, (size_t)model->meta_bytes);
  assert_non_null(meta);
  assert_string_equal(cJSON_GetObjectItem(meta, "version")->valuestring, thrum_version());
  const cJSON *mesh = cJSON_GetObjectItem(meta, "mesh");
  assert_string_equal(cJSON_GetObjectItem(mesh, "hash")->valuestring,
                      cJSON_GetObjectItem(line, "mesh_hash")->valuestring);

  // constraints are recorded in their order, a file by its name without its folder
  const cJSON *fix = cJSON_GetObjectItem(cJSON_GetObjectItem(meta, "options"), "fix");
  assert_int_equal(cJSON_GetArraySize(fix), 2);
  assert_string_equal(cJSON_GetArrayItem(fix, 0)->valuestring, "held.bou");
  assert_string_equal(cJSON_GetArrayItem(fix, 1)->valuestring, "y<0&x<0.001");

  assert_int_equal(count_of(meta, "materials"), 1);

  // numbers in the JSON line and in meta are the same doubles
  for (int k = 0; k < 8; k++) {
    assert_true(number_at(meta, "basis_frequencies_hz", k) ==
                number_at(line, "basis_frequencies_hz", k));
  }

  // the path of the folder is not in the file
  char *text = cJSON_PrintUnformatted(meta);
  assert_null(strstr(text, folder));
  free(text);

  cJSON_Delete(meta);
  cJSON_Delete(line);
  thrum_model_destroy(model);
}

/* Writes a cube of six tetrahedra with the vertices 1 to 8. `vertex9` is the line of one vertex
 * more, or empty; `tets` holds the lines of the tetrahedra. */
static void write_cube(const char *name, const char *vertex9, const char *tets) {
  char text[2000];
  snprintf(text, sizeof text,
           "*VERTICES\n%d 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 0 0 1\n6 1 0 1\n7 0 1 1\n"
           "8 1 1 1\n%s*ELEMENTS\nTET\n6 4 0\n%s"
           "*MATERIAL rubber\nENU, 1000, 1e6, 0.3\n*REGION\nallElements, rubber\n",
           vertex9[0] != 0 ? 9 : 8, vertex9, tets);
  assert_true(text_file_write(in_folder(name), text));
}

#define CUBE_TETS "1 1 2 4 8\n2 1 4 3 8\n3 1 3 7 8\n4 1 7 5 8\n5 1 5 6 8\n6 1 6 2 8\n"
#define CUBE_TETS_INVERTED "1 2 1 4 8\n2 4 1 3 8\n3 3 1 7 8\n4 7 1 5 8\n5 5 1 6 8\n6 6 1 2 8\n"

static void inverted_files_are_flipped_and_spare_vertices_dropped(void **state) {
  (void)state;
  write_cube("cube.veg", "", CUBE_TETS);
  write_cube("odd.veg", "9 5 5 5\n", CUBE_TETS_INVERTED);

  cJSON *plain = precompute("cube.veg", ROOT, "--rank", "4", NULL, NULL);
  cJSON *cleaned = precompute("odd.veg", ROOT, "--rank", "4", NULL, NULL);
  assert_frequencies_scale(plain, cleaned, 1);

  // whichever of the two orientations is positive, exactly one file was flipped
  assert_true(json_value(plain, "flipped_tets") + json_value(cleaned, "flipped_tets") == 6);

  // the vertex that no tetrahedron uses is gone
  assert_true(json_value(cleaned, "dropped_vertices") == 1);
  assert_true(json_value(cleaned, "vertices") == 8);

  cJSON_Delete(plain);
  cJSON_Delete(cleaned);

  // dropping a vertex is warned of
  program_result run = thrum_run(folder, "precompute", "odd.veg", "--order", "1", "-o", "made.npz",
                                 "--fix", ROOT, "--modes", "3", "--rank", "3", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "thrum: warning: odd.veg: 1 vert"));
  program_result_free(&run);
}

/* Near 1/2 rounding is felt, and linear tetrahedra lock at any ratio: both are said. */
static void poissons_ratios_near_a_half_are_warned_of(void **state) {
  static const struct {
    const char *poisson, *order;
    bool rounds, locks;
  } cases[] = {{"0.49", "1", false, true},
               {"0.4901", "2", false, false},
               {"0.4901", "auto", false, false},
               {"0.4999999", "1", true, true},
               {"0.499999999", "2", true, false}};

  (void)state;

  // each is made, with the warnings that it deserves
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    program_result run = thrum_run(folder, "precompute", "beam:4x2x2@1x0.2x0.2", "-o", "made.npz",
                                   "--fix", ROOT, "--modes", "2", "--rank", "2", "--poisson",
                                   cases[n].poisson, "--order", cases[n].order, NULL);
    assert_int_equal(run.exit_code, 0);
    assert_int_equal(strstr(run.err, "is above 0.49999") != NULL, cases[n].rounds);
    assert_int_equal(strstr(run.err, "linear tetrahedra are too stiff") != NULL, cases[n].locks);
    program_result_free(&run);
  }
}

/* Asserts that the precompute is refused with exit 1, the last line of standard error names
 * `wanted`, standard output is empty, and nothing was written. */
static void assert_refused_with(const char *wanted, const char *mesh, const char *option,
                                const char *value, const char *option2, const char *value2) {
  remove(in_folder("never.npz"));

  program_result run = thrum_run(folder, "precompute", mesh, "--order", "1", "-o", "never.npz",
                                 "--json", "--quiet", option, value, option2, value2, NULL);

  // show what was said instead before the assertions stop the test
  const char *line = strncmp(run.err, "thrum: ", 7) == 0 ? run.err : NULL;
  if (run.exit_code != 1 || line == NULL || strstr(line, wanted) == NULL) {
    print_error("%s %s: exit %d: %s\n", mesh, value != NULL ? value : "", run.exit_code, run.err);
  }

  assert_int_equal(run.exit_code, 1);
  assert_non_null(line);
  assert_true(line_count_is(run.err, 1));
  assert_non_null(strstr(line, wanted));

  // neither a result nor a file is left
  assert_string_equal(run.out, "");
  assert_false(file_exists(in_folder("never.npz")));
  program_result_free(&run);
}

/* One body comes as two kinds of file in two units: the cube in metres, and in millimetres by
 * Gmsh, whose files hold no material. */
static void gmsh_files_give_the_model_of_the_same_mesh(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("cube.msh"),
                              "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n"
                              "2 1 \"the clamp\"\n3 2 \"body\"\n$EndPhysicalNames\n$Nodes\n8\n"
                              "1 0 0 0\n2 1000 0 0\n3 0 1000 0\n4 1000 1000 0\n5 0 0 1000\n"
                              "6 1000 0 1000\n7 0 1000 1000\n8 1000 1000 1000\n$EndNodes\n"
                              "$Elements\n8\n1 2 2 1 1 1 3 7\n2 2 2 1 1 1 7 5\n3 4 2 2 1 1 2 4 8\n"
                              "4 4 2 2 1 1 4 3 8\n5 4 2 2 1 1 3 7 8\n6 4 2 2 1 1 7 5 8\n"
                              "7 4 2 2 1 1 5 6 8\n8 4 2 2 1 1 6 2 8\n$EndElements\n"));

  write_cube("cube.veg", "", CUBE_TETS);

  // the physical group, the same with its axes, and a predicate hold the same face
  cJSON *numbers[3];
  static const char *const fixes[] = {"the clamp", "the clamp:xyz", ROOT};
  for (int n = 0; n < 3; n++) {
    program_result run = thrum_run(folder, "precompute", n < 2 ? "cube.msh" : "cube.veg", "--order",
                                   "1", "-o", "made.npz", "--fix", fixes[n], "--modes", "4",
                                   "--rank", "4", "--json", "--scale", n < 2 ? "1e-3" : "1",
                                   "--young", "1e6", "--poisson", "0.3", "--density", "1000", NULL);
    if (run.exit_code != 0)
      print_error("%s", run.err);
    assert_int_equal(run.exit_code, 0);
    numbers[n] = json_line(run.out);
    assert_true(json_value(numbers[n], "fixed") == 4);
    program_result_free(&run);
  }

  // both descriptions of the body give one model
  assert_frequencies_scale(numbers[2], numbers[0], 1);
  assert_frequencies_scale(numbers[2], numbers[1], 1);
  for (int n = 0; n < 3; n++)
    cJSON_Delete(numbers[n]);

  // without a material in the file, all three of its numbers must be given
  assert_refused_with("give --young, --poisson and --density", "cube.msh", "--scale", "1e-3",
                      "--young", "1e6");
}

static void bad_files_are_refused_by_name(void **state) {
  (void)state;

  // a corner that does not exist, a flat tetrahedron, a coordinate that is no number
  write_cube("cube.veg", "", CUBE_TETS);
  write_cube("index.veg", "",
             "1 1 2 4 8\n2 1 4 3 8\n3 1 3 7 8\n4 1 7 5 8\n5 1 5 6 8\n6 1 6 2 11\n");
  write_cube("flat.veg", "", "1 1 2 4 8\n2 1 4 3 8\n3 1 2 3 4\n4 1 7 5 8\n5 1 5 6 8\n6 1 6 2 8\n");
  write_cube("nan.veg", "9 0 nan 0\n", CUBE_TETS);

  // files that are no mesh at all
  assert_true(text_file_write(in_folder("words.veg"), "not a mesh at all\n"));
  assert_true(text_file_write(in_folder("words.msh"), "not a mesh at all\n"));
  assert_true(text_file_write(in_folder("empty.veg"), ""));
  assert_true(text_file_write(in_folder("mesh.txt"), "1 2 3\n"));

  // the message names the file, and the corner or the element where there is one
  assert_refused_with("missing.veg", "missing.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("index.veg", "index.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("11", "index.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("3", "flat.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("nan.veg", "nan.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("words.veg", "words.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("words.msh", "words.msh", "--fix", ROOT, NULL, NULL);
  assert_refused_with("empty.veg", "empty.veg", "--fix", ROOT, NULL, NULL);
  assert_refused_with("mesh.txt", "mesh.txt", "--fix", ROOT, NULL, NULL);

  // names that are no file
  assert_refused_with("beam", "beam:0x1x1@1x1x1", "--fix", ROOT, NULL, NULL);
  assert_refused_with("", "/", "--fix", ROOT, NULL, NULL);
  assert_refused_with("name of the mesh is empty", "", "--fix", ROOT, NULL, NULL);
}

static void every_truncation_of_a_mesh_is_refused_or_complete(void **state) {
  (void)state;
  write_cube("cube.veg", "", CUBE_TETS);

  char *text = text_file_read(in_folder("cube.veg"));
  assert_non_null(text);

  // up to the last tet a cut loses something that is needed
  const size_t length = (size_t)(strstr(text, "6 1 6 2 8") - text);
  for (size_t cut = 0; cut < length; cut += 7) {
    const char kept = text[cut];
    text[cut] = 0;
    assert_true(text_file_write(in_folder("cut.veg"), text));
    text[cut] = kept;
    assert_refused_with("cut.veg", "cut.veg", "--fix", ROOT, NULL, NULL);
  }
  free(text);
}

static void bad_materials_are_refused(void **state) {
  (void)state;
  static const char *const bad[][3] = {{"--poisson", "0.5", "above -1 and below 0.5, not '0.5'"},
                                       {"--poisson", "0.7", "above -1 and below 0.5, not '0.7'"},
                                       {"--poisson", "-1", "above -1 and below 0.5, not '-1'"},
                                       {"--young", "0", "number from 1e-30 to 1e+30 Pa, not '0'"},
                                       {"--young", "-5", "from 1e-30 to 1e+30 Pa, not '-5'"},
                                       {"--density", "0", "number from 1e-30 to 1e+30 kg/m^3"},
                                       {"--density", "-1", "1e+30 kg/m^3, not '-1'"},
                                       {"--scale", "0", "number above 0, not '0'"},
                                       {"--scale", "-1", "number above 0, not '-1'"},
                                       // possible, but beyond the range of the solvers
                                       {"--young", "1e300", "from 1e-30 to 1e+30"},
                                       {"--young", "1e-310", "from 1e-30 to 1e+30"},
                                       {"--density", "1e300", "from 1e-30 to 1e+30"},
                                       {"--density", "1e-308", "from 1e-30 to 1e+30"}};

  // a number out of its range is a mistake of usage, which the message puts beside the range
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++) {
    program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "never.npz",
                                   "--fix", ROOT, bad[n][0], bad[n][1], NULL);
    if (run.exit_code != 2 || strstr(run.err, bad[n][2]) == NULL)
      fail_msg("%s %s: exit %d, %s", bad[n][0], bad[n][1], run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }

  // the same holds for the material in the mesh file, which is then refused as a file
  assert_true(
      text_file_write(in_folder("rubber.veg"),
                      "*VERTICES\n4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                      "*ELEMENTS\nTETS\n1 4 0\n1 1 2 3 4\n"
                      "*MATERIAL rubber\nENU, 1000, 1e6, 0.5\n*REGION\nallElements, rubber\n"));
  assert_refused_with("Poisson's ratio of region 1 is 0.5;", "rubber.veg", "--fix", "x>0.5", NULL,
                      NULL);
}

static void bodies_too_free_and_ranks_too_large_are_refused(void **state) {
  (void)state;
  assert_refused_with("names no vertex", BEAM, "--fix", "x<-1", NULL, NULL);
  assert_refused_with("thrum: --fix: 'nosuchgroup' is", BEAM, "--fix", "nosuchgroup", NULL, NULL);
  assert_refused_with("thrum: --handles: 'nosuchgroup' is", BEAM, "--fix", ROOT, "--handles",
                      "nosuchgroup");
  assert_refused_with("rank", BEAM, "--fix", ROOT, "--rank", "66");
  assert_refused_with("too many for a mesh", BEAM, "--fix", ROOT, "--modes", "250");
  assert_refused_with("every vertex is fixed", BEAM, "--fix", "x<2", NULL, NULL);

  // held along one axis only, a body still moves freely along the others
  assert_refused_with("rigid motions", BEAM, "--fix", "left:x", NULL, NULL);
}

static void a_body_that_nothing_holds_is_a_free_one(void **state) {
  (void)state;

  // the rigid motions are kept apart from the elastic modes, to rounding
  program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "free.npz",
                                 "--modes", "4", "--rank", "8", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  assert_non_null(strstr(run.err, "this is a free body"));
  cJSON *object = json_line(run.out);
  assert_true(json_value(object, "rigid_modes") == 6);
  assert_true(json_value(object, "fixed") == 0);
  assert_true(json_value(cJSON_GetObjectItem(object, "residuals"), "rigid") < 1e-14);
  cJSON_Delete(object);
  program_result_free(&run);

  // the model says so, and its elastic part can be stepped
  run = thrum_run(folder, "info", "free.npz", NULL);
  assert_non_null(strstr(run.out, "6 rigid modes kept apart"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "free.npz", "-o", "ringing", "--time", "0.3", "--start",
                  "mode:1,0.01", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

static void order_two_makes_a_model_of_ten_node_tetrahedra(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", BEAM, "-o", "ten.npz", "--order", "2",
                                 "--fix", ROOT, "--modes", "4", "--rank", "8", "--json", NULL);
  assert_int_equal(run.exit_code, 0);
  cJSON *object = json_line(run.out);
  assert_true(json_value(object, "order") == 2);
  const double held = json_value(object, "fixed");
  cJSON_Delete(object);
  program_result_free(&run);

  // what is held has its middle nodes, as the file says
  run = thrum_run(folder, "info", "ten.npz", "--json", NULL);
  object = json_line(run.out);
  assert_true(json_value(object, "fixed") == held);
  cJSON_Delete(object);
  program_result_free(&run);

  // the file says so, and it is stepped, reduced and in the full order
  run = thrum_run(folder, "info", "ten.npz", NULL);
  assert_non_null(strstr(run.out, "format 2.0"));
  assert_non_null(strstr(run.out, "tetrahedra of ten nodes"));
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "ten.npz", "-o", "ten", "--time", "0.03", "--stress", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "simulate", "ten.npz", "-o", "whole", "--full", "--time", "0.01", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
}

/* How many vertices a model of ten-node tetrahedra holds by this --fix. */
static double held_by(const char *fix) {
  program_result run =
      thrum_run(folder, "precompute", "beam:4x1x1@1x0.2x0.2", "-o", "held.npz", "--order", "2",
                "--fix", fix, "--modes", "2", "--rank", "4", "-q", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "info", "held.npz", "--json", NULL);
  cJSON *object = json_line(run.out);
  const double held = json_value(object, "fixed");
  cJSON_Delete(object);
  program_result_free(&run);
  return held;
}

/* A list has the numbers of the linear mesh; what lies between them is held as well. */
static void a_list_of_corners_holds_the_middle_nodes_between_them(void **state) {
  (void)state;
  FILE *file = fopen(in_folder("corners.txt"), "w");
  assert_non_null(file);
  fputs("1, 2, 3, 4\n", file);
  assert_int_equal(fclose(file), 0);
  assert_true(held_by("x<0.001") == 9);
  assert_true(held_by("corners.txt") == 9);
}

static void stages_say_time_memory_and_rate(void **state) {
  (void)state;
  cJSON *object = precompute(BEAM, ROOT, NULL, NULL, NULL, NULL);
  static const char *const names[] = {"assemble",    "factor", "modes",
                                      "derivatives", "basis",  "polynomial"};

  const cJSON *stages = cJSON_GetObjectItemCaseSensitive(object, "stages");

  // the peak of memory never falls from one stage to the next
  double peak = 0;
  for (int n = 0; n < 6; n++) {
    const cJSON *row = cJSON_GetObjectItemCaseSensitive(stages, names[n]);
    assert_true(json_value(row, "seconds") >= 0);
    assert_true(json_value(row, "peak_mb") >= peak && json_value(row, "peak_mb") > 0);
    peak = json_value(row, "peak_mb");

    // what is not counted has no rate
    const bool counted = n != 0 && n != 4;
    assert_true(counted == cJSON_IsNumber(cJSON_GetObjectItemCaseSensitive(row, "gflops")));
    assert_true(!counted || json_value(row, "gflops") > 0);
  }

  assert_true(peak <= json_value(object, "peak_mb"));
  cJSON_Delete(object);
}

/* Where the stiffness has lost its digits, pivots are delayed and frequencies differ, by how much
 * hangs on the order of sums. */
static void a_body_that_is_too_thin_is_flagged(void **state) {
  (void)state;
  program_result run =
      thrum_run(folder, "precompute", "beam:12x8x1@0.4x0.3x1.4e-5,hex", "-o", "thin.npz", "--fix",
                "x<1e-9", "--fix", "x>0.3999999", "--fix", "y<-0.1499999", "--fix", "y>0.1499999",
                "--modes", "3", "--rank", "7", NULL);
  assert_true(run.exit_code == 1 || run.exit_code == 3);
  assert_non_null(strstr(run.err, run.exit_code == 3 ? "the stiffness is lost in rounding"
                                                     : "is so thin that it"));
  program_result_free(&run);
}

static void what_solids_have_not_is_refused(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "precompute", "beam:2x1x1@1x0.3x0.3,hex", "-o", "s.npz",
                                 "--fix", "x<0.001", "--modes", "1", "--rank", "2", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "s.npz", "--cubature", "-o", "none.npz", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "give the mesh that it was made from"));
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "beam:2x1x1@1x0.3x0.3,hex", "--quadrature-order", "7",
                  "--fix", "x<0.001", "-o", "none.npz", NULL);
  assert_int_equal(run.exit_code, 1);
  assert_non_null(strstr(run.err, "--quadrature-order is of tetrahedra of ten nodes"));
  program_result_free(&run);
}

static void precompute_says_how_modes_were_checked(void **state) {
  (void)state;
  static const char *const how[] = {"search", "inertia", "auto"};
  for (int n = 0; n < 3; n++) {
    program_result run =
        thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "made.npz", "--fix", ROOT,
                  "--modes", "4", "--check", how[n], "--json", NULL);

    // counting is optional in a build
    if (n == 1 && run.exit_code == 1) {
      assert_non_null(strstr(run.err, "built without MUMPS"));
      program_result_free(&run);
      continue;
    }

    assert_int_equal(run.exit_code, 0);

    // the next frequency, which was not asked for, lies above the last one listed
    cJSON *object = json_line(run.out);
    const cJSON *check = cJSON_GetObjectItem(object, "mode_check");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(check, "complete")));
    const char *method = cJSON_GetObjectItem(check, "method")->valuestring;
    if (n < 2)
      assert_string_equal(method, how[n]);
    assert_true(json_value(check, "next_hz") > number_at(object, "frequencies_hz", 3));

    // the model file keeps what was found
    program_result info = thrum_run(folder, "info", "made.npz", NULL);
    assert_non_null(strstr(info.out, "none missed"));
    assert_non_null(strstr(info.out, method));
    program_result_free(&info);

    cJSON_Delete(object);
    program_result_free(&run);
  }
}

static void an_output_that_cannot_be_written_is_refused_at_once(void **state) {
  (void)state;
  static const char *const outputs[] = {"nowhere/made.npz", ".", "made/", ""};
  for (int n = 0; n < 4; n++) {
    program_result run = thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", outputs[n],
                                   "--fix", ROOT, NULL);
    assert_int_equal(run.exit_code, 1);
    assert_true(line_count_is(run.err, 1));
    assert_non_null(strstr(run.err, outputs[n]));
    program_result_free(&run);
  }
}

static void a_refusal_leaves_an_earlier_model_alone(void **state) {
  (void)state;
  assert_true(text_file_write(in_folder("kept.npz"), "earlier"));
  program_result run =
      thrum_run(folder, "precompute", BEAM, "--order", "1", "-o", "kept.npz", "--fix", "x<2", NULL);
  assert_int_equal(run.exit_code, 1);
  program_result_free(&run);
  char *text = text_file_read(in_folder("kept.npz"));
  assert_string_equal(text, "earlier");
  free(text);
}

/* Asserts that the program exits with 2 and says how it is used, with `wanted` in the text. */
static void assert_usage(const char *wanted, const char *a, const char *b, const char *c,
                         const char *d, const char *e, const char *f) {
  program_result run = thrum_run(folder, a, b, c, d, e, f, NULL);
  if (run.exit_code != 2 || strstr(run.err, wanted) == NULL)
    print_error("%s", run.err);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, wanted));
  assert_string_equal(run.out, "");
  program_result_free(&run);
}

static void wrong_usage_is_told_apart_from_refusal(void **state) {
  (void)state;

  // commands and options that do not exist
  assert_usage("usage", NULL, NULL, NULL, NULL, NULL, NULL);
  assert_usage("did you mean 'precompute'", "precomptue", NULL, NULL, NULL, NULL, NULL);
  assert_usage("unknown command", "melt", NULL, NULL, NULL, NULL, NULL);
  assert_usage("unknown option", "--melt", NULL, NULL, NULL, NULL, NULL);

  // arguments and values that are missing or misspelt
  assert_usage("no mesh", "precompute", NULL, NULL, NULL, NULL, NULL);
  assert_usage("-o", "precompute", BEAM, NULL, NULL, NULL, NULL);
  assert_usage("did you mean '--young'", "precompute", BEAM, "--yuong", "1", NULL, NULL);
  assert_usage("needs a value", "precompute", BEAM, "--young", NULL, NULL, NULL);
  assert_usage("needs a value", "precompute", BEAM, "-o", NULL, NULL, NULL);
  assert_usage("takes no value", "precompute", BEAM, "--json=1", NULL, NULL, NULL);

  // values that are no number of the kind wanted
  assert_usage("number", "precompute", BEAM, "--young", "soft", NULL, NULL);
  assert_usage("number", "precompute", BEAM, "--young", "nan", NULL, NULL);
  assert_usage("number", "precompute", BEAM, "--density", "1e400", NULL, NULL);
  assert_usage("number", "precompute", BEAM, "--density", "0x10", NULL, NULL);
  assert_usage("whole number", "precompute", BEAM, "--modes", "0", NULL, NULL);
  assert_usage("whole number", "precompute", BEAM, "--rank", "1.5", NULL, NULL);
  assert_usage("whole number", "precompute", BEAM, "--threads", "-1", NULL, NULL);

  // choices, and an argument too many
  assert_usage("consistent or lumped", "precompute", BEAM, "--mass", "heavy", NULL, NULL);
  assert_usage("auto, search or inertia", "precompute", BEAM, "--check", "twice", NULL, NULL);
  assert_usage("one mesh", "precompute", BEAM, BEAM, "-o", "made.npz", NULL);
}

static void help_and_version_are_results(void **state) {
  (void)state;

  // both ways to ask for help print the same text to standard output
  static const char *const commands[] = {"precompute", "simulate", "info", "bench"};
  for (int n = 0; n < 4; n++) {
    program_result by_option = thrum_run(folder, commands[n], "--help", NULL);
    program_result by_command = thrum_run(folder, "help", commands[n], NULL);
    assert_int_equal(by_option.exit_code, 0);
    assert_string_equal(by_option.err, "");
    assert_non_null(strstr(by_option.out, "examples:"));
    assert_string_equal(by_option.out, by_command.out);
    program_result_free(&by_option);
    program_result_free(&by_command);
  }

  program_result version = thrum_run(folder, "--version", NULL);
  assert_int_equal(version.exit_code, 0);
  assert_string_equal(version.out, "thrum " THRUM_VERSION_STRING "\n");
  program_result_free(&version);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(beam_gives_the_documented_keys),
      cmocka_unit_test(a_rank_that_is_not_given_has_room_for_derivatives),
      cmocka_unit_test(stages_do_not_overlap),
      cmocka_unit_test(json_is_alone_on_standard_output),
      cmocka_unit_test(two_reproducible_runs_write_the_same_bytes),
      cmocka_unit_test(generator_equals_the_reference_file),

      // what the options do to the model
      cmocka_unit_test(material_and_scale_act_as_physics_says),
      cmocka_unit_test(gmsh_files_give_the_model_of_the_same_mesh),
      cmocka_unit_test(lumped_mass_never_raises_a_frequency),
      cmocka_unit_test(fix_takes_predicates_files_groups_and_axes),
      cmocka_unit_test(meta_says_what_was_done_but_not_where),

      // meshes that are mended or refused
      cmocka_unit_test(poissons_ratios_near_a_half_are_warned_of),
      cmocka_unit_test(inverted_files_are_flipped_and_spare_vertices_dropped),
      cmocka_unit_test(bad_files_are_refused_by_name),
      cmocka_unit_test(every_truncation_of_a_mesh_is_refused_or_complete),
      cmocka_unit_test(bad_materials_are_refused),
      cmocka_unit_test(bodies_too_free_and_ranks_too_large_are_refused),
      cmocka_unit_test(a_body_that_nothing_holds_is_a_free_one),

      // what it says on its way, and how it ends
      cmocka_unit_test(order_two_makes_a_model_of_ten_node_tetrahedra),
      cmocka_unit_test(a_list_of_corners_holds_the_middle_nodes_between_them),
      cmocka_unit_test(stages_say_time_memory_and_rate),
      cmocka_unit_test(a_body_that_is_too_thin_is_flagged),
      cmocka_unit_test(what_solids_have_not_is_refused),
      cmocka_unit_test(precompute_says_how_modes_were_checked),
      cmocka_unit_test(an_output_that_cannot_be_written_is_refused_at_once),
      cmocka_unit_test(a_refusal_leaves_an_earlier_model_alone),
      cmocka_unit_test(wrong_usage_is_told_apart_from_refusal),
      cmocka_unit_test(help_and_version_are_results),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
