/* Triangle surfaces from .obj and .stl: the statements that are read, ignored or refused, and the
 * place that the message names; every truncation and many mutations of valid files.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <float.h>
#include <math.h>
#include <sys/stat.h>

#include "mesh/formats/surface_read.h"
#include "mesh/surface_mesh.h"

static thrum_surface_mesh good_bytes(const char *name, const void *data, size_t size) {
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  if (thrum_surface_mesh_read(mesh_write(name, data, size), 1, &surface, &error) < 0)
    fail_msg("%s", error.message);
  return surface;
}

static thrum_surface_mesh good(const char *name, const char *text) {
  return good_bytes(name, text, strlen(text));
}

static void bad_bytes(const char *name, const void *data, size_t size, const char *words) {
  thrum_surface_mesh surface = {.vertex_count = 77};
  thrum_error error = {0};
  const thrum_status status =
      thrum_surface_mesh_read(mesh_write(name, data, size), 1, &surface, &error);
  if (status >= 0)
    fail_msg("was read, and should be refused with '%s'", words);
  assert_int_equal(error.status, status);
  mesh_check_message(&error, words);
  assert_int_equal(surface.vertex_count, 77);
}

static void bad(const char *name, const char *text, const char *words) {
  bad_bytes(name, text, strlen(text), words);
}

static void expect_triangles(const thrum_surface_mesh *surface, const int32_t *triangles,
                             int64_t count) {
  assert_int_equal(surface->triangle_count, count);
  assert_memory_equal(surface->triangles, triangles, (size_t)count * 3 * sizeof *triangles);
}

#define SQUARE "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"

static void polygons_become_fans_in_the_winding_of_the_file(void **state) {
  (void)state;
  thrum_surface_mesh surface = good("a.obj", SQUARE "v 0.5 2 0\nf 1 2 3 5 4\n");
  static const int32_t fan[] = {0, 1, 2, 0, 2, 4, 0, 4, 3};
  expect_triangles(&surface, fan, 3);
  assert_int_equal(surface.vertex_count, 5);
  assert_int_equal(surface.polygons, 1);
  assert_int_equal(surface.triangle_line[2], 6);
  assert_true(surface.vertices[13] == 2);
  thrum_surface_mesh_free(&surface);
}

/* All of these texts describe the square of two triangles. */
static void spellings_of_a_face_mean_the_same(void **state) {
  (void)state;

  // corners with and without further indices, continued lines, ignored statements, line endings
  static const char *const texts[] = {
      SQUARE "f 1 2 3 4\n",
      SQUARE "f -4 -3 -2 -1\n",
      SQUARE "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1 4/1/1\n",
      SQUARE "f 1//1 2//1 3//1 4//1",
      SQUARE "f 1/1 2/1 3/1 4/1 # a comment\n",
      SQUARE "f 1/ 2/ 3// 4\n",
      SQUARE "f 1 \\\n 2 3\\\n 4\n",
      SQUARE "f 1 2 3 4 \\\n\nl 1 2\n",
      SQUARE "f\t1  2\t3 4 \\",
      "\xef\xbb\xbf" SQUARE "fo 1 2 3 4\n",
      "f 1 2 3 4\n" SQUARE,
      "# Blender\nmtllib a.mtl\no Square\n" SQUARE
      "g a b\nusemtl m\ns off\nf 1 2 3 4\nl 1 2 3\np 1\n",
      "v 0 0 0 1\r\nv 1 0 0 1\r\nv 1 1 0 0.5 0.5 0.5\r\nv 0 1 0 1 0.5 0.5 0.5\r\nf 1 2 3 4\r\n",
      "v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3 4\r",
      "v 0 \\\n0 0\nv 1 0 \\\r\n 0\nv 1e0 1. .0\nV -0 +1 0\nF 1 2 3 4\n"};

  // the square
  static const int32_t two[] = {0, 1, 2, 0, 2, 3};
  static const double corners[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
    thrum_surface_mesh surface = good("a.OBJ", texts[i]);
    expect_triangles(&surface, two, 2);
    assert_int_equal(surface.vertex_count, 4);
    for (int n = 0; n < 12; n++)
      assert_true(surface.vertices[n] == corners[n]);
    thrum_surface_mesh_free(&surface);
  }
}

static void vertices_of_an_obj_keep_their_order_used_or_not(void **state) {
  (void)state;
  thrum_surface_mesh surface = good("a.obj", "v 9 9 9\n" SQUARE "v 0 0 0\nf 2 3 4\n");
  static const int32_t one[] = {1, 2, 3};
  expect_triangles(&surface, one, 1);
  assert_int_equal(surface.vertex_count, 6);
  assert_true(surface.vertices[0] == 9);
  thrum_surface_mesh_free(&surface);
  // a negative index counts back from its own line
  surface = good("a.obj", SQUARE "f -3 -2 -1\nv 7 7 7\nf -2 -1 1\n");
  static const int32_t relative[] = {1, 2, 3, 3, 4, 0};
  expect_triangles(&surface, relative, 2);
  thrum_surface_mesh_free(&surface);
}

#define FACET(x)                                                                                   \
  "facet normal 0 0 nan\n outer loop\n  vertex " x " 0 0\n  vertex 1 0 0\n  vertex 1 1 0\n"        \
  " endloop\nendfacet\n"

static void corners_of_an_stl_at_one_place_are_one_vertex(void **state) {
  (void)state;
  thrum_surface_mesh surface = good("a.stl", "solid of my own\n" FACET("0") FACET("-0")
                                                 FACET("2") "endsolid of my own\n"
                                                            "SOLID\n" FACET("1e-300") "ENDSOLID\n");
  static const int32_t triangles[] = {0, 1, 2, 0, 1, 2, 3, 1, 2, 4, 1, 2};
  expect_triangles(&surface, triangles, 4);
  assert_int_equal(surface.vertex_count, 5);
  assert_int_equal(surface.merged, 7);
  assert_false(surface.binary);
  assert_int_equal(surface.triangle_line[1], 9);
  thrum_surface_mesh_free(&surface);

  // the next solid ends one that has no end of its own
  surface = good("a.stl", "solid a\n" FACET("0") "solid b\n" FACET("2") "endsolid\n");
  assert_int_equal(surface.triangle_count, 2);
  thrum_surface_mesh_free(&surface);
}

/* A strip of `facets` triangles over (i, 0), (i, 1) in binary. */
static size_t make_binary(unsigned char *bytes, uint32_t facets, const char *header) {
  memset(bytes, 0, 84 + 50 * (size_t)facets);
  memcpy(bytes, header, strlen(header));
  memcpy(bytes + 80, &facets, 4);
  for (uint32_t n = 0; n < facets; n++)
    for (uint32_t c = 0; c < 3; c++) {
      const float corner[3] = {(float)((n + c) / 2), (float)((n + c) % 2), -0.0f};
      memcpy(bytes + 84 + 50 * n + 12 + 12 * c, corner, sizeof corner);
    }
  return 84 + 50 * (size_t)facets;
}

static void a_binary_stl_is_known_by_its_size(void **state) {
  (void)state;
  enum { FACETS = 1000 };

  // the header may begin like that of an ASCII file
  static unsigned char bytes[84 + 50 * FACETS + 1];
  static const char *const headers[] = {"", "solid but binary"};
  for (int h = 0; h < 2; h++) {
    const size_t size = make_binary(bytes, FACETS, headers[h]);
    thrum_surface_mesh surface = good_bytes("b.stl", bytes, size);
    assert_int_equal(surface.triangle_count, FACETS);
    assert_int_equal(surface.vertex_count, FACETS + 2);
    assert_true(surface.binary);

    // the vertices are shared, and each triangle knows its facet
    for (int32_t n = 0; n < FACETS; n++)
      for (int32_t c = 0; c < 3; c++)
        assert_int_equal(surface.triangles[3 * n + c], n + c);
    assert_int_equal(surface.triangle_line[FACETS - 1], FACETS);
    thrum_surface_mesh_free(&surface);
  }

  // sizes that do not fit the count of facets
  make_binary(bytes, FACETS, "");
  bad_bytes("b.stl", bytes, sizeof bytes - 2, "50084 bytes, this file has 50083: is it cut short?");
  bad_bytes("b.stl", bytes, sizeof bytes, "this file has 50085");
  bad_bytes("b.stl", bytes, 83, "neither 'solid' nor the 84 bytes");

  // no facets, and a facet with a NaN
  make_binary(bytes, 0, "");
  bad_bytes("b.stl", bytes, 84, "there are no facets");
  const size_t size = make_binary(bytes, FACETS, "");
  const float nan = (float)NAN;
  memcpy(bytes + 84 + 50 * 4 + 20, &nan, sizeof nan);
  bad_bytes("b.stl", bytes, size, "facet 5 has a corner that is not a finite number");
}

static void the_scale_multiplies_lengths(void **state) {
  (void)state;
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  const char *path = mesh_write_text("a.obj", SQUARE "f 1 2 3\n");
  assert_int_equal(thrum_surface_mesh_read(path, 0.25, &surface, &error), THRUM_OK);
  assert_true(surface.vertices[3] == 0.25);
  thrum_surface_mesh_free(&surface);
  path = mesh_write_text("a.obj", "v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n");
  assert_int_equal(thrum_surface_mesh_read(path, 1e10, &surface, &error), THRUM_BAD_VALUE);
  mesh_check_message(&error, "vertex 2 times the scale");
}

static void a_mistake_in_a_surface_file_is_named_with_its_line(void **state) {
  (void)state;
  static const struct {
    const char *name, *text, *words;
  } cases[] = {
      // .obj: vertices
      {"a.obj", "", "there are no faces"},
      {"a.obj", SQUARE, "a.obj:4: there are no faces"},
      {"a.obj", "v 0 0\n", "a.obj:1: the line ends before the z coordinate"},
      {"a.obj", "v 0 0 \\\n\nv 1 2 3\n", "a.obj:3: the vertex before this line ends before"},
      {"a.obj", "v 0 0 x\n", "a.obj:1: expected the z coordinate"},
      {"a.obj", "v 0 0 nan\n", "a.obj:1: the z coordinate is 'nan'"},
      {"a.obj", "v 0 0 1e999\n", "a.obj:1: the z coordinate is"},
      {"a.obj", "v 0 0 0 1 1 1 1 1\n", "a.obj:1: unexpected '1' after the vertex"},
      {"a.obj", "v 0,5 0 0\n", "a.obj:1: expected the x coordinate"},

      // .obj: faces
      {"a.obj", SQUARE "f 1 2\n", "a.obj:5: the face has 2 corners"},
      {"a.obj", SQUARE "f\n", "a.obj:5: the face has 0 corners"},
      {"a.obj", SQUARE "f 1 2 5\n", "a.obj:5: a corner names vertex 5, and the file has 4"},
      {"a.obj", SQUARE "f 1 2 -5\n", "a.obj:5: a corner names vertex -5, and there are 4"},
      {"a.obj", SQUARE "f 1 2 0\n", "a.obj:5: expected a corner such as 7"},
      {"a.obj", SQUARE "f 1 2 3.5\n", "a.obj:5: expected a corner such as 7"},
      {"a.obj", SQUARE "f 1 2 3/0\n", "a.obj:5: expected a corner such as 7"},
      {"a.obj", SQUARE "f 1 2 3/1/1/1\n", "a.obj:5: expected a corner such as 7"},
      {"a.obj", SQUARE "f 1 2 /1\n", "a.obj:5: expected a corner such as 7"},
      {"a.obj", SQUARE "f 1 2 99999999999999999999\n", "a.obj:5: expected a corner"},
      {"a.obj", SQUARE "f 1 2 9999999999\n", "a.obj:5: a corner names vertex 9999999999"},

      // .obj: statements
      {"a.obj", "solid\n", "a.obj:1: expected a statement such as v or f, found 'solid'"},
      {"a.obj", SQUARE "surf 0 1 0 1 1 2 3 4\n", "a.obj:5: 'surf' belongs to a free-form"},

      // .stl
      {"a.stl", "", "neither 'solid' nor"},
      {"a.stl", "solid\nendsolid\n", "there are no facets"},
      {"a.stl", "solid\n" FACET("0"), "the file ends before 'endsolid'; is it cut short?"},
      {"a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "ends before 'vertex'"},
      {"a.stl", "solid\nfacet normal 0 0 1\nvertex 0 0 0\n", "a.stl:3: expected 'outer'"},
      {"a.stl", "solid\n" FACET("nan"), "a.stl:4: the x coordinate is 'nan'"},
      {"a.stl", "solid\n" FACET("0 1"), "a.stl:4: unexpected '0' after the vertex"},
      {"a.stl", "solid\nf 1 2 3\n", "a.stl:2: expected 'facet', found 'f'"},
      {"a.ply", "ply\n",
       "unknown kind of surface; give an .obj or .stl file, which a modeller makes"}};

  // each fault with its line
  for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
    bad(cases[i].name, cases[i].text, cases[i].words);

  // files that cannot be opened or are of no known kind
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  assert_int_equal(thrum_surface_mesh_read("no-such.obj", 1, &surface, &error), THRUM_IO);
  assert_int_equal(thrum_surface_mesh_read("", 1, &surface, &error), THRUM_UNSUPPORTED);
  assert_int_equal(thrum_surface_mesh_read("/tmp", 1, &surface, NULL), THRUM_UNSUPPORTED);
}

/* The text is read or refused; the address sanitizer finds everything else. */
static void try_all(thrum_surface_parser *parse, const char *text, size_t size) {
  char *bytes = malloc(size);
  assert_non_null(bytes);
  uint64_t random = 1;

  // first every truncation, then random single-byte changes
  for (size_t n = 0; n < 3 * size; n++) {
    memcpy(bytes, text, size);
    const size_t kept = n < size ? n : size;
    if (n >= size) {
      random = random * 6364136223846793005u + 1442695040888963407u;
      bytes[random >> 33 & 0xffff % size] = "09-/\\ \nvf.e#"[random >> 50 & 0xb];
    }

    // a refusal leaves nothing, and a surface has valid indices
    thrum_surface_mesh surface = {0};
    thrum_error error = {0};
    const thrum_status status = parse("x", bytes, kept, &surface, &error);
    assert_true((status < 0) == (surface.triangles == NULL));
    for (int64_t t = 0; t < 3 * surface.triangle_count; t++)
      assert_in_range(surface.triangles[t], 0, surface.vertex_count - 1);
    thrum_surface_mesh_free(&surface);
  }

  free(bytes);
}

static void damaged_files_are_read_or_refused(void **state) {
  (void)state;
  static const char obj[] = SQUARE "vt 0 1\ng a\nf 1/1/1 2//1 -2 \\\n 4\nf 1 2 3\n";
  static const char stl[] = "solid\n" FACET("0") FACET("2") "endsolid\n";
  unsigned char binary[84 + 50 * 3];
  try_all(thrum_surface_parse_obj, obj, sizeof obj - 1);
  try_all(thrum_surface_parse_stl, stl, sizeof stl - 1);
  const size_t size = make_binary(binary, 3, "");
  try_all(thrum_surface_parse_stl, (const char *)binary, size);
}

/* A bridge surface that was modelled by hand for a real mesh. */
static void a_real_surface_is_read_whole(void **state) {
  (void)state;
  char path[512];
  snprintf(path, sizeof path, "%s/simpleBridge.obj", THRUM_DATA);
  struct stat there;
  if (!*THRUM_DATA || stat(path, &there) != 0)
    skip();
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  if (thrum_surface_mesh_read(path, 1, &surface, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(surface.vertex_count, 16085);
  assert_int_equal(surface.triangle_count, 32014);
  assert_true(surface.vertices[0] == 4.043663);
  thrum_surface_mesh_free(&surface);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(polygons_become_fans_in_the_winding_of_the_file),
      cmocka_unit_test(spellings_of_a_face_mean_the_same),
      cmocka_unit_test(vertices_of_an_obj_keep_their_order_used_or_not),
      cmocka_unit_test(corners_of_an_stl_at_one_place_are_one_vertex),
      cmocka_unit_test(a_binary_stl_is_known_by_its_size),
      cmocka_unit_test(the_scale_multiplies_lengths),
      cmocka_unit_test(a_mistake_in_a_surface_file_is_named_with_its_line),
      cmocka_unit_test(damaged_files_are_read_or_refused),
      cmocka_unit_test(a_real_surface_is_read_whole),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
