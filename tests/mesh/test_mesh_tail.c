/* Rare faults of meshes, in every format that is read: the same broken body is refused or flagged
 * in the same words in each; and texts that are unusual in each format's own way.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <sys/stat.h>

#include "io/file.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_examine.h"
#include "mesh/mesh_flags.h"
#include "tests/support/mesh_support.h"

typedef struct format {
  const char *name;
  thrum_mesh_write_options options;
  bool text;
} format;

static const format formats[] = {
    {"t.veg", {false, false, 0}, true},  {"t.msh", {false, false, 41}, true},
    {"t.msh", {false, false, 22}, true}, {"t.msh", {true, false, 41}, false},
    {"t.msh", {true, false, 22}, false}, {"t.ele", {false, false, 0}, true},
    {"t.mesh", {false, false, 0}, true}, {"t.vtk", {false, false, 0}, true},
    {"t.vtk", {true, false, 0}, false},  {"t.vtu", {false, true, 0}, true},
    {"t.vtu", {false, false, 0}, false}, {"t.inp", {false, false, 0}, true},
};
enum { FORMATS = sizeof formats / sizeof formats[0], POINTS = 10, TETS = 6 };

/* The vertices and tetrahedra of a broken body, and the expected verdict. */
typedef struct body {
  const char *what;
  double points[POINTS][3];
  int point_count;
  int32_t tets[TETS][4];
  int tet_count;
  bool refused;
  unsigned flag;   /* expected if the body is read */
  int64_t flipped; /* the least number of flipped tetrahedra */
} body;

#define CORNERS                                                                                    \
  {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {                                                               \
    0, 0, 1                                                                                        \
  }

static const body bodies[] = {
    {"whole", {CORNERS}, 4, {{0, 1, 2, 3}}, 1, false, 0, 0},
    {"wound the wrong way",
     {CORNERS, {1, 1, 1}},
     5,
     {{0, 1, 2, 3}, {1, 3, 2, 4}},
     2,
     false,
     THRUM_EXAMINE_REPAIRED,
     1},
    {"the same tet twice", {CORNERS}, 4, {{0, 1, 2, 3}, {1, 2, 0, 3}}, 2, true, 0, 0},
    {"three tets on a face",
     {CORNERS, {1, 1, 1}, {2, 2, 2}},
     6,
     {{0, 1, 2, 3}, {1, 2, 3, 4}, {1, 2, 3, 5}},
     3,
     true,
     0,
     0},
    {"flat", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, 4, {{0, 1, 2, 3}}, 1, true, 0, 0},
    {"a vertex twice in a tet", {CORNERS}, 4, {{0, 1, 2, 2}}, 1, true, 0, 0},
    {"two pieces",
     {CORNERS, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}},
     8,
     {{0, 1, 2, 3}, {4, 5, 6, 7}},
     2,
     false,
     THRUM_EXAMINE_PIECES,
     0},
    {"two tets that share an edge alone",
     {CORNERS, {0, 0, -1}, {0, -1, 0}},
     6,
     {{0, 1, 2, 3}, {0, 1, 5, 4}},
     2,
     false,
     THRUM_EXAMINE_HINGES,
     0},
    {"vertices on top of each other",
     {CORNERS, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}},
     8,
     {{0, 1, 2, 3}, {4, 6, 5, 7}},
     2,
     false,
     THRUM_EXAMINE_COINCIDENT,
     1},
    {"coordinates at 1e9",
     {{1e9, 1e9, 1e9}, {1e9 + 1, 1e9, 1e9}, {1e9, 1e9 + 1, 1e9}, {1e9, 1e9, 1e9 + 1}},
     4,
     {{0, 1, 2, 3}},
     1,
     false,
     THRUM_EXAMINE_FAR,
     0},
};
enum { BODIES = sizeof bodies / sizeof bodies[0], TWICE = 2 };

static thrum_mesh mesh_of(const body *b) {
  thrum_mesh mesh = {.vertex_count = b->point_count, .tet_count = b->tet_count, .region_count = 1};
  mesh.vertices = malloc(sizeof b->points);
  mesh.tets = malloc(sizeof b->tets);
  mesh.tet_region = calloc(TETS, sizeof *mesh.tet_region);
  mesh.materials = calloc(1, sizeof *mesh.materials);
  assert_true(mesh.vertices && mesh.tets && mesh.tet_region && mesh.materials);
  memcpy(mesh.vertices, b->points, sizeof b->points);
  memcpy(mesh.tets, b->tets, sizeof b->tets);
  mesh.materials[0] = (thrum_material){1e6, 0.3, 1000};
  mesh.has_material = true;
  return mesh;
}

/* Writes the body and returns the file's path. */
static const char *write_body(const body *b, const format *f) {
  thrum_mesh mesh = mesh_of(b);
  thrum_mesh_lost lost;
  thrum_error error = {0};
  // so that the files are removed at the end
  mesh_write_text("t.node", "");
  const char *path = mesh_write_text(f->name, "");
  if (thrum_mesh_write(path, &mesh, &f->options, &lost, &error) < 0)
    fail_msg("%s: %s", f->name, error.message);
  thrum_mesh_free(&mesh);
  return path;
}

static void every_format_says_the_same_of_a_broken_body(void **state) {
  (void)state;
  for (int n = 0; n < BODIES; n++) {
    const body *b = &bodies[n];
    for (int k = 0; k < FORMATS; k++) {
      thrum_mesh mesh = {0};
      thrum_error error = {0};
      const char *path = write_body(b, &formats[k]);
      const thrum_status status = thrum_mesh_read(path, 1, &mesh, &error);

      // Gmsh repeats a tetrahedron for each of its physical groups, so repeats count once
      const bool once = strcmp(formats[k].name, "t.msh") == 0 && n == TWICE;
      if ((status < 0) != (b->refused && !once))
        fail_msg("%s in %s: status %d, %s", b->what, formats[k].name, status, error.message);
      if (status < 0) {
        // the message names the file, and the tetrahedron or its line
        assert_non_null(strstr(error.message, formats[k].name));
        assert_true(strlen(error.message) > 30);
        continue;
      }

      // a body that is read is flagged in the examination
      assert_int_equal(mesh.tet_count, once ? 1 : b->tet_count);
      thrum_mesh_examined examined;
      assert_true(thrum_mesh_examine(&mesh, &examined, &error) >= 0);
      if ((thrum_mesh_flags(&mesh, &examined) & b->flag) != b->flag)
        fail_msg("%s in %s: not flagged", b->what, formats[k].name);
      assert_true(mesh.flipped_tets >= b->flipped);
      thrum_mesh_free(&mesh);
    }
  }
}

static char *read_file(const char *path) {
  enum { ROOM = 100000 };
  char *text = malloc(ROOM);
  FILE *file = fopen(path, "rb");
  assert_true(text != NULL && file != NULL);
  const size_t size = fread(text, 1, ROOM - 1, file);
  text[size] = 0;
  fclose(file);
  return text;
}

static void write_file(const char *path, const char *text) {
  assert_true(thrum_file_write_atomic(path, text, strlen(text), NULL) >= 0);
}

/* The position of the tetrahedra in the text of a file. */
static char *find_tets(char *text, const format *f) {
  static const struct {
    const char *name, *head;
  } heads[] = {{"t.veg", "*ELEMENTS"},   {"t.msh", "$Elements"}, {"t.ele", ""},
               {"t.mesh", "Tetrahedra"}, {"t.vtk", "CELLS"},     {"t.vtu", "connectivity"},
               {"t.inp", "*ELEMENT"}};
  const char *head = NULL;
  for (size_t n = 0; n < sizeof heads / sizeof heads[0]; n++)
    if (strcmp(heads[n].name, f->name) == 0)
      head = heads[n].head;
  char *at = strstr(text, head);
  assert_non_null(at);
  return at;
}

/* Each number after the head of the tetrahedra in turn becomes an index beyond 2^31 or 2^63: the
 * file is refused in one line or read as another mesh, without a crash or an index out of range. */
static void indices_past_what_can_be_counted_are_refused(void **state) {
  (void)state;
  static const char *const huge[] = {"2147483648", "4294967297", "9223372036854775808",
                                     "99999999999999999999999", "-2147483649"};
  for (int k = 0; k < FORMATS; k++) {
    if (!formats[k].text)
      continue;

    // a valid file to change
    const char *path = write_body(&bodies[0], &formats[k]);
    char *text = read_file(path);
    int refused = 0, numbers = 0;
    for (char *at = find_tets(text, &formats[k]); *at != 0;) {
      // the next number that stands by itself
      const size_t length = strspn(at, "0123456789");
      if (length == 0 || (at > text && strchr("\t\n ,>", at[-1]) == NULL)) {
        at += length > 0 ? length : 1;
        continue;
      }

      // the file with that number replaced
      for (size_t n = 0; n < sizeof huge / sizeof huge[0]; n++) {
        char *changed = malloc(strlen(text) + 40);
        assert_non_null(changed);
        sprintf(changed, "%.*s%s%s", (int)(at - text), text, huge[n], at + length);
        write_file(path, changed);
        free(changed);

        // a refusal names the file in one line
        thrum_mesh mesh = {0};
        thrum_error error = {0};
        if (thrum_mesh_read(path, 1, &mesh, &error) < 0) {
          refused++;
          if (strstr(error.message, "t.") == NULL || strchr(error.message, '\n') != NULL)
            fail_msg("%s: '%s'", formats[k].name, error.message);
        }

        // a mesh that was read has valid indices
        for (int64_t i = 0; i < 4 * mesh.tet_count; i++)
          assert_true(mesh.tets[i] >= 0 && mesh.tets[i] < mesh.vertex_count);
        thrum_mesh_free(&mesh);
      }
      numbers++;
      at += length;
    }

    // at least the four corners must be checked
    if (refused < 4 * 5)
      fail_msg("%s: %d of %d refused", formats[k].name, refused, numbers * 5);
    free(text);
  }
}

/* A byte-order mark and the line endings of other machines change nothing. */
static void marks_and_ends_of_lines_make_no_difference(void **state) {
  (void)state;
  for (int k = 0; k < FORMATS; k++) {
    if (!formats[k].text)
      continue;
    const char *path = write_body(&bodies[0], &formats[k]);
    char *text = read_file(path);
    char *changed = malloc(2 * strlen(text) + 4);
    assert_non_null(changed);

    // the mark, and CR LF for each LF
    memcpy(changed, "\xef\xbb\xbf", 3);
    size_t used = 3;
    for (const char *at = text; *at != 0; at++) {
      if (*at == '\n')
        changed[used++] = '\r';
      changed[used++] = *at;
    }
    changed[used] = 0;

    // the mesh is read as before
    write_file(path, changed);
    thrum_mesh mesh = {0};
    thrum_error error = {0};
    if (thrum_mesh_read(path, 1, &mesh, &error) < 0)
      fail_msg("%s: %s", formats[k].name, error.message);
    assert_int_equal(mesh.tet_count, 1);
    thrum_mesh_free(&mesh);
    free(changed);
    free(text);
  }
}

/* A line of a million characters is inserted in front of each line of the file in turn. */
static void a_line_of_a_million_characters_is_survived(void **state) {
  (void)state;
  enum { LONG = 1000000 };
  for (int k = 0; k < FORMATS; k++) {
    if (!formats[k].text)
      continue;

    // a valid file, and room for the long line
    const char *path = write_body(&bodies[0], &formats[k]);
    char *text = read_file(path);
    char *changed = malloc(strlen(text) + LONG + 2);
    assert_non_null(changed);
    int lines = 0;
    for (const char *at = text; at != NULL && *at != 0 && lines < 12; lines++) {
      // the line before which the long one is inserted
      const size_t before = (size_t)(at - text);
      memcpy(changed, text, before);
      memset(changed + before, '7', LONG);
      changed[before + LONG] = '\n';
      strcpy(changed + before + LONG + 1, at);

      // the file is read, or refused with a message of one line
      write_file(path, changed);
      thrum_mesh mesh = {0};
      thrum_error error = {0};
      if (thrum_mesh_read(path, 1, &mesh, &error) < 0) {
        assert_null(strchr(error.message, '\n'));
        assert_non_null(strstr(error.message, "t."));
      }
      thrum_mesh_free(&mesh);

      at = strchr(at, '\n');
      at = at != NULL ? at + 1 : NULL;
    }

    assert_true(lines > 1);
    free(changed);
    free(text);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_format_says_the_same_of_a_broken_body),
      cmocka_unit_test(indices_past_what_can_be_counted_are_refused),
      cmocka_unit_test(marks_and_ends_of_lines_make_no_difference),
      cmocka_unit_test(a_line_of_a_million_characters_is_survived),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
