/* The parts of a mesh that --fix can name: predicates, files of numbers, groups, components; and
 * the specifications that it refuses. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_fix.h"
#include "tests/support/mesh_support.h"

#include <sys/stat.h>

#define BEAM1K "beam:20x3x3@1x0.15x0.15,split=6"

/* Vertices 1 and 4 belong to no tetrahedron. */
#define LOOSE                                                                                      \
  "*VERTICES\n6 3 0 0\n1 9 9 9\n2 0 0 0\n3 1 0 0\n4 8 8 8\n5 0 1 0\n6 0 0 1\n*ELEMENTS\nTET\n"     \
  "1 4 0\n1 2 3 5 6\n"

static thrum_mesh beam(void) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(BEAM1K, 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

/* The support bytes after one specification on a free mesh; the caller frees them. */
static uint8_t *fix(const thrum_mesh *mesh, const char *spec, int64_t expected) {
  uint8_t *fixed = calloc((size_t)mesh->vertex_count, 1);
  assert_non_null(fixed);
  int64_t count = -1;
  thrum_error error = {0};
  if (thrum_mesh_fix(mesh, spec, fixed, &count, &error) < 0)
    fail_msg("%s: %s", spec, error.message);
  if (count != expected)
    fail_msg("%s names %lld, not %lld", spec, (long long)count, (long long)expected);
  int64_t held = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    held += fixed[v] != 0;
  assert_int_equal(held, expected);
  return fixed;
}

static void refused(const thrum_mesh *mesh, const char *spec, const char *words) {
  uint8_t *fixed = malloc((size_t)mesh->vertex_count);
  assert_non_null(fixed);
  memset(fixed, 2, (size_t)mesh->vertex_count);

  // outputs with known values, so that a change would be seen
  int64_t count = -7;
  thrum_error error = {0};
  thrum_status status = thrum_mesh_fix(mesh, spec, fixed, &count, &error);
  if (status >= 0)
    fail_msg("not refused: %s", spec);
  assert_int_equal(error.status, status);
  mesh_check_message(&error, words);

  // a refusal changes nothing
  assert_int_equal(count, -7);
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    assert_int_equal(fixed[v], 2);

  free(fixed);
}

static void a_predicate_picks_by_rest_position(void **state) {
  (void)state;
  thrum_mesh m = beam();
  uint8_t *fixed = fix(&m, "x<0.01&z>0", 8);
  for (int64_t v = 0; v < m.vertex_count; v++) {
    const double *p = m.vertices + 3 * v;
    assert_int_equal(fixed[v], p[0] < 0.01 && p[2] > 0 ? 7 : 0);
  }
  free(fixed);
  thrum_mesh_free(&m);
}

static void comparisons_are_strict_unless_they_say_equal(void **state) {
  (void)state;
  thrum_mesh m = beam();
  refused(&m, "x<0", "names no vertex");
  refused(&m, "x>1", "names no vertex");
  free(fix(&m, "x<=0", 16));
  free(fix(&m, "x>=1", 16));
  free(fix(&m, "y>=0.075", 84));
  free(fix(&m, "z<=-7.5e-2", 84));
  free(fix(&m, "x<=0&x>=0", 16));
  free(fix(&m, "x>-1", 336));
  thrum_mesh_free(&m);
}

static void blanks_in_a_predicate_do_not_matter(void **state) {
  (void)state;
  thrum_mesh m = beam();
  uint8_t *tight = fix(&m, "x<0.01&z>=-.1:xz", 16);
  uint8_t *loose = fix(&m, "  x < 0.01 &\tz >= -.1 : xz\n", 16);
  assert_memory_equal(tight, loose, (size_t)m.vertex_count);
  free(tight);
  free(loose);
  thrum_mesh_free(&m);
}

static void a_suffix_picks_components(void **state) {
  (void)state;
  thrum_mesh m = beam();
  static const struct {
    const char *spec;
    uint8_t bits;
  } cases[] = {{"left", 7},    {"left:xyz", 7}, {"left:x", 1},    {"left:y", 2}, {"left:z", 4},
               {"left:xz", 5}, {"left:zyx", 7}, {"left : zy", 6}, {"x<=0:z", 4}, {"x<=0: xy", 3}};

  // letters in any order, with blanks or without
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
    uint8_t *fixed = fix(&m, cases[i].spec, 16);

    // the face x = 0 has the first sixteen vertices
    for (int v = 0; v < 336; v++)
      assert_int_equal(fixed[v], v < 16 ? cases[i].bits : 0);
    free(fixed);
  }

  thrum_mesh_free(&m);
}

static void specs_add_up(void **state) {
  (void)state;
  thrum_mesh m = beam();
  uint8_t *fixed = fix(&m, "left:x", 16);
  int64_t count = 0;
  assert_int_equal(thrum_mesh_fix(&m, "bottom:z", fixed, &count, NULL), THRUM_OK);
  assert_int_equal(count, 84);
  assert_int_equal(fixed[0], 5);
  assert_int_equal(fixed[1], 1);
  assert_int_equal(fixed[16], 4);
  free(fixed);
  thrum_mesh_free(&m);
}

static void a_file_lists_vertices_as_bou_does(void **state) {
  (void)state;
  thrum_mesh m = beam();

  // the file of the sample mesh names the same vertices as the group
  uint8_t *group = fix(&m, "left", 16);
  uint8_t *file = fix(&m, THRUM_TEST_DATA "/beam1k.bou", 16);
  assert_memory_equal(group, file, (size_t)m.vertex_count);
  free(file);

  // every notation of the same list
  static const char *const lists[] = {"1:16",
                                      "1,2,3,4,5,6,7,8,\n9,10,11,12,13,14,15,16,\n\n",
                                      "# the wall\n16:16 1 : 15 # all\n",
                                      "1 2 3\t4,5 , 6\r\n7:16",
                                      "1:9,8:16,3,3,3",
                                      "\357\273\2771: 16\n"};
  for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
    file = fix(&m, mesh_write_text("list.bou", lists[i]), 16);
    assert_memory_equal(group, file, (size_t)m.vertex_count);
    free(file);
  }

  // a file takes a suffix too
  char spec[160];
  snprintf(spec, sizeof spec, "%.150s:y", mesh_write_text("list.bou", "336"));
  file = fix(&m, spec, 1);
  assert_int_equal(file[335], 2);

  free(file);
  free(group);
  thrum_mesh_free(&m);
}

static void bad_lists_are_refused_with_their_line(void **state) {
  (void)state;
  thrum_mesh m = beam();
  static const struct {
    const char *text, *words;
  } cases[] = {
      {"1\n337\n", "bad.bou:2: vertex 337 is not in the mesh, which has 336, from 1 to 336"},
      {"0", "bad.bou:1: vertex 0 is not in the mesh"},
      {"-1", "bad.bou:1: vertex -1 is not in the mesh"},
      {"99999999999999999999", "expected a vertex number or a range a:b"},
      {"1, two", "bad.bou:1: expected a vertex number or a range a:b, found 'two'"},
      {"1.5", "found '1.5'"},
      {"3:1", "bad.bou:1: the range 3:1 runs backwards"},
      {"1:1000000000000000000", "vertex 1000000000000000000 is not in the mesh"},
      {"1:", "expected a vertex number or a range a:b"},
      {":3", "expected a vertex number or a range a:b"},
      {"1:2:3", "expected a vertex number or a range a:b"},
      {"1;2", "found '1;2'"}};

  // the message names the line and the word at fault
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    refused(&m, mesh_write_text("bad.bou", cases[i].text), cases[i].words);

  thrum_mesh_free(&m);
}

static void lists_use_the_numbers_of_the_file(void **state) {
  (void)state;
  thrum_mesh m = mesh_good("loose.veg", LOOSE);

  // number 2 of the file is the first vertex that is kept; 4 was dropped
  uint8_t *fixed = fix(&m, mesh_write_text("l.bou", "2 4 6"), 2);
  assert_int_equal(fixed[0], 7);
  assert_int_equal(fixed[3], 7);
  free(fixed);

  // a range may contain dropped vertices; a list of dropped ones alone is refused
  free(fix(&m, mesh_write_text("l.bou", "1:6"), 4));
  refused(&m, mesh_write_text("l.bou", "1 4"), "names no vertex");
  refused(&m, mesh_write_text("l.bou", "7"), "which has 6, from 1 to 6");
  thrum_mesh_free(&m);

  // the tags of a Gmsh file may have gaps
  m = mesh_good("gaps.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n700 0 0 0\n7 1 0 0\n"
                            "8 0 1 0\n90 0 0 1\n50 5 5 5\n$EndNodes\n$Elements\n1\n"
                            "1 4 0 700 7 8 90\n$EndElements\n");
  fixed = fix(&m, mesh_write_text("l.bou", "700"), 1);
  assert_int_equal(fixed[3], 7);
  free(fixed);
  free(fix(&m, mesh_write_text("l.bou", "8:90"), 2));
  refused(&m, mesh_write_text("l.bou", "9"),
          "vertex 9 is not in the mesh, which has 5, from 7 to 700");

  thrum_mesh_free(&m);
}

static void the_lists_of_real_meshes_are_read(void **state) {
  (void)state;
  static const struct {
    const char *mesh, *list;
    int64_t count;
  } cases[] = {{"beam3_tet.veg", "beam3.bou", 8}, {"simpleBridge.veg", "simpleBridge.bou", 121}};

  // the folder is optional: beam1k.bou, which is always there, has its own test
  for (size_t i = 0; *THRUM_DATA && i < sizeof cases / sizeof *cases; i++) {
    char mesh_path[512], list_path[512];
    snprintf(mesh_path, sizeof mesh_path, "%s/%s", THRUM_DATA, cases[i].mesh);
    snprintf(list_path, sizeof list_path, "%s/%s", THRUM_DATA, cases[i].list);
    thrum_mesh m = {0};
    assert_int_equal(thrum_mesh_read(mesh_path, 1, &m, NULL), THRUM_OK);
    free(fix(&m, list_path, cases[i].count));
    thrum_mesh_free(&m);
  }
}

static void bad_predicates_are_refused(void **state) {
  (void)state;
  thrum_mesh m = beam();
  static const char *const specs[] = {
      "<",      ">",       "x<",        "x<0.01&",  "&x<0.01", "x<0.01&&z>0", "w<1",
      "x=<1",   "x<<1",    "x<0.01abc", "0.01>x",   "0<x<1",   "x<1|y<1",     "x<nan",
      "x>-inf", "x<1e999", "x<0,01",    "x<0.01:",  "x<1:w",   "x<1:x:y",     "xy<1",
      "X<1",    "x<1 2",   "x<0x10",    "left&x<1", "x<1:xq",  ":x<1"};
  for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
    refused(&m, specs[i], "is no predicate; write comparisons in metres joined by &");
  refused(&m, "x>5", "'x>5' names no vertex of the mesh, which extends from 0 to ");
  thrum_mesh_free(&m);
}

static void near_picks_the_one_nearest_vertex(void **state) {
  (void)state;
  thrum_mesh m = beam();
  for (int64_t v = 0; v < m.vertex_count; v++) {
    const double *x = m.vertices + 3 * v;
    char spec[120];
    snprintf(spec, sizeof spec, "near: %.17g, %.17g,%.17g :z", x[0] + 1e-4, x[1] - 1e-4, x[2]);
    uint8_t *fixed = fix(&m, spec, 1);
    for (int64_t w = 0; w < m.vertex_count; w++)
      assert_int_equal(fixed[w], w == v ? 4 : 0);
    free(fixed);
  }

  static const char *const specs[] = {"near:",        "near:1",        "near:1,2",
                                      "near:1,2,",    "near:1,2,3,4",  "near:1;2;3",
                                      "near:nan,0,0", "near:1,2,1e999"};
  for (size_t i = 0; i < sizeof specs / sizeof *specs; i++)
    refused(&m, specs[i], "is no point; write its coordinates in metres");

  // a place in millimetres, or one of another mesh
  refused(&m, "near:1000,0,0:xy",
          "'near:1000,0,0' is far from all vertices of the mesh, which extends from 0 to 1 in x");
  thrum_mesh_free(&m);
}

static void an_unknown_name_lists_the_groups(void **state) {
  (void)state;
  thrum_mesh m = beam();

  // misspelled names and suffixes
  refused(&m, "lift",
          "'lift' is neither a file nor a group; the groups are left, right, front, back, "
          "bottom, top, tip");
  refused(&m, "left:w", "'left:w' is neither");
  refused(&m, "left:", "'left:' is neither");
  refused(&m, "", "what to fix is empty");
  refused(&m, " \n", "what to fix is empty");
  refused(&m, ":x", "is neither a file nor a group");
  refused(&m, mesh_folder, "is neither a file nor a group");

  // control characters never reach the terminal
  refused(&m, "a\033[2J\001b\vc\177d", "'a [2J b c d' is neither");

  // a name longer than the message
  char name[3000];
  memset(name, 'n', sizeof name - 1);
  name[sizeof name - 1] = '\0';
  refused(&m, name, "is neither a file nor a group");

  // a group with a long name shortens the list of groups
  free(m.groups[1].name);
  name[255] = '\0';
  m.groups[1].name = malloc(256);
  assert_non_null(m.groups[1].name);
  memcpy(m.groups[1].name, name, 256);
  refused(&m, "lift", "the groups are left, ...");
  thrum_mesh_free(&m);

  // without groups the message suggests a predicate
  m = mesh_good("loose.veg", LOOSE);
  refused(&m, "lift", "the mesh has no groups; use a predicate such as 'x<0.01'");

  thrum_mesh_free(&m);
}

static void names_may_look_like_components(void **state) {
  (void)state;
  thrum_mesh m = mesh_good("named.veg", LOOSE "*SET a:x\n1\n*SET xyz\n1\n*SET with blanks\n1\n");
  uint8_t *fixed = fix(&m, "a:x", 4);
  assert_int_equal(fixed[0], 7);
  free(fixed);
  fixed = fix(&m, "a:x:z", 4);
  assert_int_equal(fixed[0], 4);
  free(fixed);
  free(fix(&m, "xyz", 4));
  free(fix(&m, " with blanks :y", 4));
  thrum_mesh_free(&m);
}

static void a_file_goes_before_a_group(void **state) {
  (void)state;
  char name[160];
  snprintf(name, sizeof name, "%.150s", mesh_write_text("wall", "2"));
  char text[400];
  snprintf(text, sizeof text, "%s*SET %s\n1\n", LOOSE, name);
  thrum_mesh m = mesh_good("both.veg", text);
  free(fix(&m, name, 1));
  assert_int_equal(unlink(name), 0);
  free(fix(&m, name, 4));
  // a folder is no file
  assert_int_equal(mkdir(name, 0700), 0);
  free(fix(&m, name, 4));
  assert_int_equal(rmdir(name), 0);
  thrum_mesh_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // predicates and components
      cmocka_unit_test(a_predicate_picks_by_rest_position),
      cmocka_unit_test(comparisons_are_strict_unless_they_say_equal),
      cmocka_unit_test(blanks_in_a_predicate_do_not_matter),
      cmocka_unit_test(a_suffix_picks_components),
      cmocka_unit_test(specs_add_up),

      // files of numbers
      cmocka_unit_test(a_file_lists_vertices_as_bou_does),
      cmocka_unit_test(bad_lists_are_refused_with_their_line),
      cmocka_unit_test(lists_use_the_numbers_of_the_file),
      cmocka_unit_test(the_lists_of_real_meshes_are_read),

      // refusals and names
      cmocka_unit_test(bad_predicates_are_refused),
      cmocka_unit_test(near_picks_the_one_nearest_vertex),
      cmocka_unit_test(an_unknown_name_lists_the_groups),
      cmocka_unit_test(names_may_look_like_components),
      cmocka_unit_test(a_file_goes_before_a_group),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
