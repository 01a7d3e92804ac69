/* Meshes are written and read back: vertices return bit for bit, tetrahedra and regions in their
 * order, and groups and materials as far as the format can hold them; the rest is counted.
 * SPDX-License-Identifier: Apache-2.0 */
#include <float.h>
#include <locale.h>
#include <math.h>
#include <sys/stat.h>

#include "io/file.h"
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_groups.h"
#include "tests/support/mesh_support.h"

enum { VERTICES = 27 };

/* The block of 2 x 2 x 2 cells has coordinates that no short decimal represents, two regions that
 * alternate along the list of tetrahedra, and groups that overlap. */
static thrum_mesh make_mesh(bool materials) {
  thrum_mesh mesh = {0};
  assert_int_equal(thrum_mesh_read("beam:2x2x2@1x1x1", 1, &mesh, NULL), THRUM_OK);
  assert_int_equal(mesh.vertex_count, VERTICES);

  // full mantissas, and one tiny number
  for (int64_t i = 0; i < 3 * mesh.vertex_count; i++)
    mesh.vertices[i] = mesh.vertices[i] / 3 * (1 + 1e-7 * (double)(i % 11)) + (i == 4 ? 1e-300 : 0);

  // two materials whose constants are no short decimals either
  free(mesh.materials);
  mesh.materials = calloc(2, sizeof *mesh.materials);
  assert_non_null(mesh.materials);
  mesh.region_count = 2;
  mesh.has_material = materials;
  if (materials) {
    mesh.materials[0] = (thrum_material){1e6 / 3, 0.1 + 0.2, 1000.1};
    mesh.materials[1] = (thrum_material){2e9, 0.3, 7850};
  }

  // regions, and a group whose name needs escaping
  for (int64_t t = 0; t < mesh.tet_count; t++)
    mesh.tet_region[t] = t % 3 == 1;
  const int32_t few[] = {26, 3, 7};
  assert_int_equal(thrum_mesh_add_group(&mesh, "a few & <more>", few, 3, NULL), THRUM_OK);
  return mesh;
}

/* Writes the mesh as a file called `name`, and reads it back. */
static thrum_mesh round_trip(const thrum_mesh *mesh, const char *name,
                             const thrum_mesh_write_options *options, thrum_mesh_lost *lost) {
  thrum_mesh read = {0};
  thrum_error error = {0};

  // the folder is emptied at the end
  const char *path = mesh_write_text(name, "");
  if (strstr(name, ".node"))
    mesh_write_text("m.ele", "");
  if (thrum_mesh_write(path, mesh, options, lost, &error) < 0)
    fail_msg("%s", error.message);
  if (thrum_mesh_read(path, 1, &read, &error) < 0)
    fail_msg("%s", error.message);

  // no number has changed
  assert_int_equal(read.vertex_count, mesh->vertex_count);
  assert_int_equal(read.tet_count, mesh->tet_count);
  assert_memory_equal(read.vertices, mesh->vertices,
                      (size_t)mesh->vertex_count * 3 * sizeof(double));
  assert_memory_equal(read.tets, mesh->tets, (size_t)mesh->tet_count * 4 * sizeof(int32_t));
  return read;
}

static void check_regions(const thrum_mesh *read, const thrum_mesh *mesh) {
  assert_int_equal(read->region_count, mesh->region_count);
  assert_memory_equal(read->tet_region, mesh->tet_region,
                      (size_t)mesh->tet_count * sizeof(int32_t));
}

static const thrum_group *find_group(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  return NULL;
}

/* The mesh has every group, with its name and its vertices. */
static void check_groups(const thrum_mesh *read, const thrum_mesh *mesh) {
  for (int64_t g = 0; g < mesh->group_count; g++) {
    const thrum_group *group = &mesh->groups[g], *found = find_group(read, group->name);
    assert_non_null(found);
    assert_int_equal(found->count, group->count);
    assert_memory_equal(found->vertices, group->vertices,
                        (size_t)group->count * sizeof *group->vertices);
  }
}

static void formats_that_hold_everything_give_it_back(void **state) {
  (void)state;
  static const struct {
    const char *name;
    thrum_mesh_write_options options;
  } formats[] = {{"m.vtk", {0}},
                 {"m.vtk", {.binary = true}},
                 {"m.vtu", {0}},
                 {"m.vtu", {.ascii = true}},
                 {"m.inp", {0}}};

  // each format is written with and without materials
  for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
    for (int materials = 0; materials < 2; materials++) {
      thrum_mesh mesh = make_mesh(materials);
      thrum_mesh_lost lost;
      thrum_mesh read = round_trip(&mesh, formats[i].name, &formats[i].options, &lost);

      // nothing is lost, and regions, groups and materials return
      assert_int_equal(lost.groups + lost.names + lost.materials + lost.regions, 0);
      check_regions(&read, &mesh);
      check_groups(&read, &mesh);
      assert_int_equal(read.has_material, materials);
      assert_memory_equal(read.materials, mesh.materials, 2 * sizeof *mesh.materials);
      thrum_mesh_free(&read);
      thrum_mesh_free(&mesh);
    }
}

/* Abaqus passes over capitals, and some characters become others: groups stay as many as they are.
 */
static void groups_that_differ_in_capitals_stay_apart_in_a_deck(void **state) {
  (void)state;
  thrum_mesh mesh = make_mesh(false);
  const char *const names[] = {"Far", "FAR", "a,b", "a*b"};
  for (int32_t n = 0; n < 4; n++) {
    const int32_t vertices[] = {n, n + 10};
    assert_int_equal(thrum_mesh_add_group(&mesh, names[n], vertices, 2, NULL), THRUM_OK);
  }
  thrum_mesh_lost lost = {0};
  thrum_mesh read = round_trip(&mesh, "m.inp", &(thrum_mesh_write_options){0}, &lost);
  int found = 0;
  for (int64_t g = 0; g < read.group_count; g++)
    found +=
        read.groups[g].count == 2 && read.groups[g].vertices[1] == read.groups[g].vertices[0] + 10;
  assert_int_equal(found, 4);
  assert_true(lost.names >= 3);
  thrum_mesh_free(&read);
  thrum_mesh_free(&mesh);
}

static void gmsh_files_hold_groups_and_regions_but_no_materials(void **state) {
  (void)state;
  for (int n = 0; n < 4; n++) {
    const thrum_mesh_write_options options = {.binary = n % 2, .msh_version = n < 2 ? 22 : 41};
    thrum_mesh mesh = make_mesh(true);
    thrum_mesh_lost lost;
    thrum_mesh read = round_trip(&mesh, "m.msh", &options, &lost);
    assert_int_equal(lost.materials, 2);
    assert_int_equal(lost.groups + lost.names + lost.regions, 0);
    check_regions(&read, &mesh);
    check_groups(&read, &mesh);
    assert_false(read.has_material);
    thrum_mesh_free(&read);
    thrum_mesh_free(&mesh);
  }
}

static void vega_files_hold_regions_with_materials_but_no_groups_of_vertices(void **state) {
  (void)state;
  thrum_mesh mesh = make_mesh(true);
  const int64_t groups = mesh.group_count;
  thrum_mesh_lost lost;
  thrum_mesh read = round_trip(&mesh, "m.veg", &(thrum_mesh_write_options){0}, &lost);

  // groups of faces and points are no unions of tetrahedra
  assert_int_equal(lost.groups, groups);
  check_regions(&read, &mesh);
  assert_true(read.has_material);
  assert_memory_equal(read.materials, mesh.materials, 2 * sizeof *mesh.materials);
  thrum_mesh_free(&read);

  // a group of all vertices is a union, and its name is adapted to the format
  int32_t all[VERTICES];
  for (int i = 0; i < VERTICES; i++)
    all[i] = i;
  assert_int_equal(thrum_mesh_add_group(&mesh, "everything, everywhere", all, VERTICES, NULL), 0);
  read = round_trip(&mesh, "m.veg", &(thrum_mesh_write_options){0}, &lost);
  assert_int_equal(lost.groups, groups);
  assert_int_equal(lost.names, 1);
  const thrum_group *group = find_group(&read, "everything_ everywhere");
  assert_non_null(group);
  assert_int_equal(group->count, VERTICES);

  thrum_mesh_free(&read);
  thrum_mesh_free(&mesh);
}

static void formats_of_one_mark_a_vertex_hold_groups_that_do_not_overlap(void **state) {
  (void)state;
  static const char *const names[] = {"m.node", "m.mesh"}, *const marks[] = {"marker_1",
                                                                             "vertices_1"};

  // TetGen and Medit store one number per vertex, so the first group survives and overlaps are lost
  for (int i = 0; i < 2; i++) {
    thrum_mesh mesh = make_mesh(true);
    thrum_mesh_lost lost;
    thrum_mesh read = round_trip(&mesh, names[i], &(thrum_mesh_write_options){0}, &lost);
    assert_int_equal(lost.materials, 2);
    assert_int_equal(lost.groups + lost.names, mesh.group_count);
    assert_true(lost.groups > 0 && lost.names >= 2);
    check_regions(&read, &mesh);

    // the first group returns under the name of its mark
    const thrum_group *first = find_group(&read, marks[i]);
    assert_non_null(first);
    assert_int_equal(first->count, mesh.groups[0].count);
    thrum_mesh_free(&read);
    thrum_mesh_free(&mesh);
  }
}

static void extreme_numbers_come_back_bit_for_bit(void **state) {
  (void)state;
  const double numbers[] = {DBL_MAX / 1e280,      DBL_MIN * 1e290, 1.0 / 3,        0.1,
                            123456789012345678.0, 5e-324,          nextafter(1, 2)};
  thrum_mesh mesh = make_mesh(false);
  for (int i = 0; i < 7; i++) {
    thrum_mesh_out out = {0};
    out.status = THRUM_IO; // nothing is flushed
    thrum_out_number(&out, numbers[i]);
    out.buffer[out.used] = 0;
    assert_true(strtod(out.buffer, NULL) == numbers[i]);
  }
  thrum_mesh_free(&mesh);
}

static void a_mesh_that_cannot_be_written_is_refused_and_no_file_is_left(void **state) {
  (void)state;
  static const char *const names[] = {"no-such-folder/m.vtk", "m.obj", "m", "no/m.node"};

  // bad folders, an unknown format and a name without one
  thrum_mesh mesh = make_mesh(false);
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    char path[200];
    struct stat about;
    thrum_mesh_lost lost, before;
    memset(&lost, 0x5a, sizeof lost);
    before = lost;
    thrum_error error = {0};
    snprintf(path, sizeof path, "%s/%s", mesh_folder, names[i]);

    // the refusal leaves no file and does not touch the report
    assert_true(thrum_mesh_write(path, &mesh, &(thrum_mesh_write_options){0}, &lost, &error) < 0);
    mesh_check_message(&error, names[i]);
    assert_memory_equal(&lost, &before, sizeof lost);
    assert_int_not_equal(stat(path, &about), 0);
  }

  thrum_mesh_free(&mesh);
}

/* Reading and writing where the decimal mark is a comma, if this machine has such a locale. */
static void a_locale_with_decimal_commas_makes_no_difference(void **state) {
  (void)state;
  static const char *const names[] = {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "nl_NL.UTF-8"};
  static const char *const files[] = {"m.vtk", "m.inp", "m.veg", "m.node", "m.mesh", "m.msh"};
  for (size_t i = 0; i < 4 && !setlocale(LC_ALL, names[i]); i++)
    continue;
  thrum_mesh mesh = make_mesh(true);
  for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
    thrum_mesh_lost lost;
    thrum_mesh read = round_trip(&mesh, files[i], &(thrum_mesh_write_options){0}, &lost);
    thrum_mesh_free(&read);
  }
  setlocale(LC_ALL, "C");
  thrum_mesh_free(&mesh);
}

/* Every truncation and every byte replaced by some others: the file is read or refused. */
static void damaged_binary_files_are_read_or_refused(void **state) {
  (void)state;
  static const unsigned char bytes[] = {0, 1, 0x7f, 0xff};
  for (int version = 0; version < 2; version++) {
    // a valid binary file, as bytes
    const thrum_mesh_write_options options = {.binary = true, .msh_version = version ? 41 : 22};
    thrum_mesh mesh = make_mesh(false);
    thrum_mesh_lost lost;
    thrum_mesh read = round_trip(&mesh, "m.msh", &options, &lost);
    thrum_mesh_free(&read);
    thrum_mesh_free(&mesh);
    char path[200];
    void *data = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/m.msh", mesh_folder);
    assert_int_equal(thrum_file_read(path, &data, &size, NULL), THRUM_OK);

    // each byte is replaced in turn; the last round truncates the file there instead
    unsigned char *copy = malloc(size);
    assert_non_null(copy);
    for (size_t n = 0; n < size; n++)
      for (size_t b = 0; b <= sizeof bytes; b++) {
        memcpy(copy, data, size);
        copy[n] = b < sizeof bytes ? bytes[b] : copy[n];
        thrum_mesh damaged = {0};
        const size_t length = b < sizeof bytes ? size : n;
        const thrum_mesh_source source = {"m.msh", copy, length, NULL, false, false};
        if (thrum_mesh_parse_msh(&source, &damaged, NULL) < 0)
          assert_null(damaged.tets);
        thrum_mesh_free(&damaged);
      }
    free(copy);
    free(data);
  }
}

/* A binary file in the opposite byte order, as another machine may write it. */
static void binary_files_of_the_other_byte_order_are_read(void **state) {
  (void)state;
  unsigned char file[1000];
  size_t used = (size_t)sprintf((char *)file, "$MeshFormat\n2.2 1 8\n");

  // the header, whose 1 tells the byte order
  const unsigned char one[] = {0, 0, 0, 1};
  memcpy(file + used, one, 4);
  used += 4;
  used += (size_t)sprintf((char *)file + used, "\n$EndMeshFormat\n$Nodes\n4\n");

  // four nodes: the origin and the unit points
  for (unsigned n = 0; n < 4; n++) {
    const unsigned char tag[] = {0, 0, 0, (unsigned char)(n + 1)};
    memcpy(file + used, tag, 4);
    used += 4;
    for (unsigned c = 0; c < 3; c++) {
      // the double 1 is 3f f0 00 ...
      memset(file + used, 0, 8);
      if (n == c + 1) {
        file[used] = 0x3f;
        file[used + 1] = 0xf0;
      }
      used += 8;
    }
  }

  // one tetrahedron in physical group 7
  used += (size_t)sprintf((char *)file + used, "\n$EndNodes\n$Elements\n1\n");
  const unsigned char numbers[] = {4, 1, 2, 1, 7, 1, 1, 2, 3, 4};
  for (size_t i = 0; i < sizeof numbers; i++) {
    memset(file + used, 0, 3);
    file[used + 3] = numbers[i];
    used += 4;
  }
  used += (size_t)sprintf((char *)file + used, "\n$EndElements\n");

  // the mesh is as written
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(mesh_write("o.msh", (char *)file, used), 1, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(mesh.tet_count, 1);
  assert_true(mesh.vertices[3] == 1 && mesh.vertices[7] == 1 && mesh.vertices[11] == 1);
  assert_non_null(find_group(&mesh, "physical_3_7"));

  thrum_mesh_free(&mesh);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(formats_that_hold_everything_give_it_back),
      cmocka_unit_test(groups_that_differ_in_capitals_stay_apart_in_a_deck),
      cmocka_unit_test(gmsh_files_hold_groups_and_regions_but_no_materials),
      cmocka_unit_test(vega_files_hold_regions_with_materials_but_no_groups_of_vertices),
      cmocka_unit_test(formats_of_one_mark_a_vertex_hold_groups_that_do_not_overlap),
      cmocka_unit_test(extreme_numbers_come_back_bit_for_bit),
      cmocka_unit_test(a_mesh_that_cannot_be_written_is_refused_and_no_file_is_left),
      cmocka_unit_test(damaged_binary_files_are_read_or_refused),
      cmocka_unit_test(binary_files_of_the_other_byte_order_are_read),
      cmocka_unit_test(a_locale_with_decimal_commas_makes_no_difference),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
