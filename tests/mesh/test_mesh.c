/* Valid meshes: the generator, the readers, and the result of cleaning.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read.h"
#include "tests/support/mesh_support.h"

#include <math.h>

#define BEAM1K "beam:20x3x3@1x0.15x0.15,split=6"

/* The corners of a unit tetrahedron and one more vertex, in the notations that files use. */
#define VEG_VERTICES "*VERTICES\n5 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
#define VEG_TWO_TETS "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 4 5\n"
#define MATERIAL "*MATERIAL BODY\nENU, 1000, 5e6, 0.4\n*REGION\nallElements, BODY\n"

static thrum_mesh read_ok(const char *name, double scale) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(name, scale, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

static double volume(const thrum_mesh *mesh) {
  double sum = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    sum += thrum_mesh_tet_volume(mesh, t);
  return sum;
}

static const thrum_group *group(const thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  fail_msg("no group %s", name);
  return NULL;
}

static void check_group(const thrum_mesh *mesh, const char *name, int64_t count,
                        const int32_t *vertices) {
  const thrum_group *found = group(mesh, name);
  assert_int_equal(found->count, count);
  assert_memory_equal(found->vertices, vertices, (size_t)count * sizeof *vertices);
}

static void the_beam_equals_beam1k(void **state) {
  (void)state;
  thrum_mesh beam = read_ok(BEAM1K, 1), file = read_ok(THRUM_TEST_DATA "/beam1k.veg", 1);

  // the same connectivity, index by index
  assert_int_equal(beam.vertex_count, 336);
  assert_int_equal(file.vertex_count, 336);
  assert_int_equal(beam.tet_count, 1080);
  assert_int_equal(file.tet_count, 1080);
  assert_memory_equal(beam.tets, file.tets, 1080 * 4 * sizeof *beam.tets);

  // the file has six digits, so its numbers may differ from the generated ones in the last bit
  for (int i = 0; i < 3 * 336; i++) {
    char a[32], b[32];
    snprintf(a, sizeof a, "%.6g", beam.vertices[i]);
    snprintf(b, sizeof b, "%.6g", file.vertices[i]);
    assert_string_equal(a, b);
    assert_true(fabs(beam.vertices[i] - file.vertices[i]) <= 1e-17);
  }

  // the same material
  assert_memory_equal(beam.materials, file.materials, sizeof *beam.materials);
  assert_int_equal(beam.region_count, file.region_count);

  thrum_mesh_free(&beam);
  thrum_mesh_free(&file);
}

static void a_beam_fills_its_box_and_faces(void **state) {
  (void)state;
  thrum_mesh m = read_ok("beam:2x4x2@0.7x1.5e-1x.3", 1);
  assert_int_equal(m.vertex_count, 3 * 5 * 3);
  assert_int_equal(m.tet_count, 6 * 2 * 4 * 2);
  assert_true(fabs(volume(&m) - 0.7 * 0.15 * 0.3) < 1e-15);

  // every named face consists of the vertices in its plane
  static const struct {
    const char *name;
    int axis;
    double at;
    int64_t count;
  } faces[] = {{"left", 0, 0, 15},    {"right", 0, 0.7, 15},    {"front", 1, -0.075, 9},
               {"back", 1, 0.075, 9}, {"bottom", 2, -0.15, 15}, {"top", 2, 0.15, 15}};
  for (size_t f = 0; f < sizeof faces / sizeof *faces; f++) {
    const thrum_group *face = group(&m, faces[f].name);
    assert_int_equal(face->count, faces[f].count);
    for (int64_t i = 0; i < face->count; i++)
      assert_true(m.vertices[3 * face->vertices[i] + faces[f].axis] == faces[f].at);
  }

  // the middle of the right face is a vertex here
  const thrum_group *tip = group(&m, "tip");
  assert_int_equal(tip->count, 1);
  const double *p = m.vertices + 3 * tip->vertices[0];
  assert_true(p[0] == 0.7 && p[1] == 0 && p[2] == 0);

  thrum_mesh_free(&m);
}

static void neighbouring_cells_of_a_beam_share_faces(void **state) {
  (void)state;
  thrum_mesh m = read_ok("beam:3x2x2@3x2x2", 1);

  // inside, each triangle belongs to two tetrahedra; on the surface, to one
  int64_t once = 0;
  for (int64_t f = 0; f < 4 * m.tet_count; f++) {
    int pairs = 0;
    for (int64_t g = 0; g < 4 * m.tet_count; g++) {
      int common = 0;
      for (int a = 0; a < 4; a++)
        for (int b = 0; b < 4; b++)
          common += a != f % 4 && b != g % 4 && m.tets[f / 4 * 4 + a] == m.tets[g / 4 * 4 + b];
      pairs += common == 3;
    }
    assert_true(pairs == 1 || pairs == 2);
    once += pairs == 1;
  }

  // the surface has two triangles for each square
  assert_int_equal(once, 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));

  thrum_mesh_free(&m);
}

static void real_meshes_have_their_published_sizes(void **state) {
  (void)state;
  static const struct {
    const char *name;
    int64_t vertices, tets;
    double volume, young;
  } meshes[] = {{"beam3_tet", 208, 450, 4.8e-3, 1e7},
                {"simpleBridge", 4000, 12827, 0, 1e7},
                {"yeahright", 21122, 71577, 0, 1e6}};

  // the folder is optional: beam1k, which is always there, has its own test
  for (size_t i = 0; *THRUM_DATA && i < sizeof meshes / sizeof *meshes; i++) {
    char path[512];
    snprintf(path, sizeof path, "%s/%s.veg", THRUM_DATA, meshes[i].name);
    thrum_mesh m = read_ok(path, 1);
    assert_int_equal(m.vertex_count, meshes[i].vertices);

    // sizes and volume as published
    assert_int_equal(m.tet_count, meshes[i].tets);
    assert_true(meshes[i].volume == 0 || fabs(volume(&m) / meshes[i].volume - 1) < 1e-9);

    // the material from the file, and a mesh that needs no cleaning
    assert_true(m.has_material && m.region_count == 1);
    assert_true(m.materials[0].young == meshes[i].young && m.materials[0].poisson == 0.45 &&
                m.materials[0].density == 1000);
    assert_int_equal(m.flipped_tets + m.dropped_vertices, 0);
    thrum_mesh_free(&m);
  }
}

static void a_veg_may_come_in_any_dress(void **state) {
  (void)state;
  thrum_mesh plain = mesh_good("plain.veg", VEG_VERTICES VEG_TWO_TETS MATERIAL);

  // byte-order mark, CR LF, comments, tabs, commas, lower case, sections in another order
  thrum_mesh dressed =
      mesh_good("dressed.veg", "\xef\xbb\xbf# a mesh\r\n\r\n*region\r\nallElements, BODY # it\r\n"
                               "*Material BODY\r\nENU,1000,5000000,0.4\r\n*elements\r\nTETS\r\n"
                               "2,4,0\r\n\t1, 1, 2, 3, 4\r\n2 2 3 4 5\r\n*vertices\r\n5 3 0 0\r\n"
                               "1 0 0.0 -0\r\n2\t+1 0 0\r\n\r\n3 0 10e-1 0\r\n4 0 0 .1E1\r\n"
                               "5 1. 1 1");
  assert_int_equal(dressed.vertex_count, 5);
  assert_int_equal(thrum_mesh_hash(&plain), thrum_mesh_hash(&dressed));
  assert_memory_equal(plain.materials, dressed.materials, sizeof *plain.materials);

  // numbered from 0, with attributes and markers as TetGen writes them
  thrum_mesh zero =
      mesh_good("zero.veg", "*VERTICES\n5 3 1 1\n0 0 0 0 7 1\n1 1 0 0 7 1\n2 0 1 0 7 1\n"
                            "3 0 0 1 7 1\n4 1 1 1 7 0\n*ELEMENTS\nTET\n2 4 1\n0 0 1 2 3 9\n"
                            "1 1 2 3 4 9\n" MATERIAL);
  assert_int_equal(thrum_mesh_hash(&plain), thrum_mesh_hash(&zero));

  thrum_mesh_free(&plain);
  thrum_mesh_free(&dressed);
  thrum_mesh_free(&zero);
}

static void element_sets_become_regions_and_groups(void **state) {
  (void)state;
  thrum_mesh m =
      mesh_good("sets.veg", VEG_VERTICES VEG_TWO_TETS
                "*MATERIAL soft\nENU, 1000, 1e6, 0.3\n*MATERIAL hard\nENU, 2000, 1e9, .2\n"
                "*SET upper part\n2,\n*SET both\n1,\n2\n*SET none\n"
                "*REGION\nallElements, soft\n*REGION\nupper part, hard\n");

  // a set with a material of its own becomes a region
  assert_int_equal(m.region_count, 2);
  assert_int_equal(m.tet_region[0], 0);
  assert_int_equal(m.tet_region[1], 1);
  assert_true(m.materials[0].young == 1e6 && m.materials[1].young == 1e9);
  assert_true(m.materials[1].density == 2000 && m.materials[1].poisson == 0.2);

  // every set that is not empty becomes a group of vertices
  assert_int_equal(m.group_count, 2);
  check_group(&m, "upper part", 4, (const int32_t[]){1, 2, 3, 4});
  check_group(&m, "both", 5, (const int32_t[]){0, 1, 2, 3, 4});

  thrum_mesh_free(&m);
}

/* Vega's own reader passes over these as well, but a user may have meant them. */
static void a_material_that_no_element_has_is_said(void **state) {
  (void)state;
  static const struct {
    const char *more, *note;
  } cases[] = {
      {"*REGION\nallElements, BODY\n", "no element is of the material 'C'"},
      {"*REGION\nallElements, BODY\n*REGION\nallElements, C\n",
       "no element is of the material 'BODY'"},
      {"*SET s\n1\n*REGION\ns, C\n*REGION\nallElements, BODY\n",
       "no element is of the material 'C'"},
      {"*SET s\n2\n*SET allElements\n2 1\n*REGION\nallElements, BODY\n*REGION\ns, C\n", NULL}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[2000];
    snprintf(text, sizeof text, "%s*MATERIAL C\nENU, 2000, 5e6, 0.3\n%s",
             VEG_VERTICES VEG_TWO_TETS MATERIAL, cases[n].more);
    thrum_mesh m = mesh_good("two.veg", text);
    assert_int_equal(m.note_count, cases[n].note ? 1 : 0);
    if (cases[n].note)
      assert_string_equal(m.notes[0].text, cases[n].note);
    thrum_mesh_free(&m);
  }
}

static void a_veg_without_material_says_so(void **state) {
  (void)state;
  thrum_mesh m = mesh_good("bare.veg", VEG_VERTICES VEG_TWO_TETS);
  assert_false(m.has_material);
  assert_int_equal(m.region_count, 1);
  assert_true(m.materials[0].young == 0 && m.materials[0].density == 0);
  thrum_mesh_free(&m);
}

static void included_files_are_read_in_place(void **state) {
  (void)state;
  thrum_mesh plain = mesh_good("plain.veg", VEG_VERTICES VEG_TWO_TETS MATERIAL);
  mesh_write_text("a.node", "5 3 0 0\n1 0 0 0\n2 1 0 0\n*INCLUDE rest.node\n5 1 1 1\n");
  mesh_write_text("rest.node", "3 0 1 0\n4 0 0 1\n");
  mesh_write_text("a.ele", "2 4 0\n1 1 2 3 4\n2 2 3 4 5\n");
  thrum_mesh parts = mesh_good("parts.veg", "*VERTICES\n*INCLUDE a.node\n*ELEMENTS\nTET\n"
                                            "*INCLUDE a.ele\n" MATERIAL);
  assert_int_equal(thrum_mesh_hash(&plain), thrum_mesh_hash(&parts));
  thrum_mesh_free(&plain);
  thrum_mesh_free(&parts);
}

static void an_inverted_file_is_flipped_and_counted(void **state) {
  (void)state;
  thrum_mesh good = mesh_good("good.veg", VEG_VERTICES VEG_TWO_TETS);
  thrum_mesh m =
      mesh_good("flip.veg", VEG_VERTICES "*ELEMENTS\nTET\n2 4 0\n1 1 2 4 3\n2 2 3 5 4\n");
  assert_int_equal(m.flipped_tets, 2);
  assert_int_equal(good.flipped_tets, 0);
  assert_true(volume(&m) > 0);
  assert_int_equal(thrum_mesh_hash(&m), thrum_mesh_hash(&good));
  thrum_mesh_free(&good);
  thrum_mesh_free(&m);
}

static void tets_wound_either_way_are_flipped_where_they_must_be(void **state) {
  (void)state;
  thrum_mesh good = mesh_good("good.veg", VEG_VERTICES VEG_TWO_TETS);
  thrum_mesh m =
      mesh_good("mixed.veg", VEG_VERTICES "*ELEMENTS\nTET\n2 4 0\n1 1 2 3 4\n2 2 3 5 4\n");
  assert_int_equal(m.flipped_tets, 1);
  assert_int_equal(thrum_mesh_hash(&m), thrum_mesh_hash(&good));
  thrum_mesh_free(&good);
  thrum_mesh_free(&m);
}

static void loose_vertices_are_dropped_and_counted(void **state) {
  (void)state;
  thrum_mesh m = mesh_good("loose.veg", "*VERTICES\n6 3 0 0\n1 9 9 9\n2 0 0 0\n3 1 0 0\n4 8 8 8\n"
                                        "5 0 1 0\n6 0 0 1\n*ELEMENTS\nTET\n1 4 0\n1 2 3 5 6\n"
                                        "*SET all\n1\n" MATERIAL);
  assert_int_equal(m.vertex_count, 4);
  assert_int_equal(m.dropped_vertices, 2);
  assert_int_equal(m.file_vertex_count, 6);
  static const int32_t map[] = {-1, 0, 1, -1, 2, 3}, all[] = {0, 1, 2, 3};
  assert_memory_equal(m.file_vertex, map, sizeof map);
  assert_memory_equal(m.tets, all, sizeof all);
  check_group(&m, "all", 4, all);
  assert_true(m.vertices[3] == 1 && m.vertices[11] == 1);
  assert_true(fabs(volume(&m) - 1.0 / 6) < 1e-16);
  thrum_mesh_free(&m);
}

static void a_scale_turns_lengths_into_metres(void **state) {
  (void)state;
  const char *path = mesh_write_text("mm.veg", VEG_VERTICES VEG_TWO_TETS);
  thrum_mesh metres = read_ok(path, 1), millimetres = read_ok(path, 1e-3);
  assert_true(fabs(volume(&millimetres) / volume(&metres) - 1e-9) < 1e-24);
  thrum_mesh_free(&metres);
  thrum_mesh_free(&millimetres);
  // a generated beam is scaled like any other mesh
  metres = read_ok("beam:2x2x2@1x0.5x0.25", 1);
  millimetres = read_ok("beam:2x2x2@1000x500x250", 1e-3);
  for (int64_t i = 0; i < 3 * metres.vertex_count; i++)
    assert_true(fabs(millimetres.vertices[i] - metres.vertices[i]) < 1e-15);
  thrum_mesh_free(&metres);
  thrum_mesh_free(&millimetres);
}

static void the_hash_sees_every_part_of_the_mesh(void **state) {
  (void)state;
  thrum_mesh m = read_ok("beam:1x1x1@1x1x1", 1);
  uint64_t hash = thrum_mesh_hash(&m);

  // a single bit of a coordinate, a corner and a region each change the hash
  double x = m.vertices[4];
  m.vertices[4] = nextafter(x, 9);
  assert_int_not_equal(thrum_mesh_hash(&m), hash);
  m.vertices[4] = x;
  m.tets[7]++;
  assert_int_not_equal(thrum_mesh_hash(&m), hash);
  m.tets[7]--;
  m.tet_region[5]++;
  assert_int_not_equal(thrum_mesh_hash(&m), hash);
  m.tet_region[5]--;
  assert_int_equal(thrum_mesh_hash(&m), hash);

  // the hash of an empty mesh is FNV-1a over two counts of zero
  thrum_mesh empty = {0};
  uint64_t expected = UINT64_C(14695981039346656037);
  for (int i = 0; i < 16; i++)
    expected *= UINT64_C(1099511628211);
  assert_int_equal(thrum_mesh_hash(&empty), expected);

  thrum_mesh_free(&m);
}

/* The file has sparse tags out of order, one unused node and two volumes, one of them in two
 * groups. */
#define MSH_22                                                                                     \
  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n0 34 \"corner\"\n3 1 \"soft\"\n"       \
  "3 9 \"the whole\"\n$EndPhysicalNames\n$Nodes\n6\n700 1 1 1\n10 0 0 0\n20 1 0 0\n30 0 1 0\n"     \
  "40 0 0 1\n5 4 4 4\n$EndNodes\n$Comments\nno $End of this\n$EndComments\n$Elements\n6\n"         \
  "1 15 2 34 1 10\n2 2 2 33 2 20 30 40\n3 4 2 1 1 10 20 30 40\n4 4 2 9 1 10 20 30 40\n"            \
  "5 4 2 9 2 20 30 40 700\n6 15 2 0 2 5\n$EndElements\n"

#define MSH_41                                                                                     \
  "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n0 34 \"corner\"\n3 1 \"soft\"\n"       \
  "3 9 \"the whole\"\n$EndPhysicalNames\n$Entities\n2 0 1 2\n1 0 0 0 1 34\n2 4 4 4 0\n"            \
  "2 0 0 0 1 1 1 1 -33 0\n1 0 0 0 1 1 1 2 1 9 0\n2 0 0 0 1 1 1 1 9 0\n$EndEntities\n"              \
  "$Nodes\n3 6 5 700\n2 2 0 3\n20\n30\n40\n1 0 0\n0 1 0\n0 0 1\n3 2 1 2\n700\n5\n1 1 1 0 0 0\n"    \
  "4 4 4 0 0 0\n0 1 0 1\n10\n0 0 0\n$EndNodes\n$Elements\n5 5 1 9\n0 1 15 1\n1 10\n2 2 2 1\n"      \
  "3 20 30 40\n3 1 4 1\n5 10 20 30 40\n3 2 4 1\n9 20 30 40 700\n0 2 15 1\n2 5\n$EndElements\n"

static void check_gmsh(const char *name, const char *text) {
  thrum_mesh m = mesh_good(name, text);

  // the unused node is dropped, and the tags are mapped to consecutive indices
  assert_int_equal(m.vertex_count, 5);
  assert_int_equal(m.dropped_vertices, 1);
  assert_int_equal(m.tet_count, 2);
  assert_false(m.has_material);
  static const int32_t tets[] = {0, 1, 2, 3, 1, 2, 3, 4};
  assert_memory_equal(m.tets, tets, sizeof tets);

  // physical volumes become regions, and all physical groups become groups of vertices
  assert_int_equal(m.region_count, 2);
  assert_int_equal(m.tet_region[0], 0);
  assert_int_equal(m.tet_region[1], 1);
  assert_int_equal(m.group_count, 4);
  check_group(&m, "corner", 1, (const int32_t[]){0});
  check_group(&m, "soft", 4, (const int32_t[]){0, 1, 2, 3});
  check_group(&m, "the whole", 5, (const int32_t[]){0, 1, 2, 3, 4});
  check_group(&m, "physical_2_33", 3, (const int32_t[]){1, 2, 3});

  // each vertex knows its number in the file
  static const int64_t numbers[] = {5, 10, 20, 30, 40, 700};
  assert_memory_equal(m.file_number, numbers, sizeof numbers);

  thrum_mesh_free(&m);
}

static void gmsh_2_2_gives_groups_and_regions(void **state) {
  (void)state;
  check_gmsh("a.msh", MSH_22);
}

static void gmsh_4_1_gives_the_same_as_2_2(void **state) {
  (void)state;
  check_gmsh("b.msh", MSH_41);
  thrum_mesh a = mesh_good("a.msh", MSH_22), b = mesh_good("b.msh", MSH_41);
  assert_int_equal(thrum_mesh_hash(&a), thrum_mesh_hash(&b));
  thrum_mesh_free(&a);
  thrum_mesh_free(&b);
}

static void gmsh_tags_may_be_huge(void **state) {
  (void)state;
  thrum_mesh m = mesh_good("huge.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n"
                                       "1000000000000000000 0 0 0\n7 1 0 0\n8 0 1 0\n9 0 0 1\n"
                                       "$EndNodes\n$Elements\n1\n1 4 0 1000000000000000000 7 8 9\n"
                                       "$EndElements\n");
  assert_int_equal(m.vertex_count, 4);
  assert_int_equal(m.tets[0], 3);
  assert_true(m.file_number[3] == INT64_C(1000000000000000000));
  thrum_mesh_free(&m);
}

/* An installed Gmsh writes the files; where there is none, the texts above stand for it. */
static void files_of_an_installed_gmsh_agree(void **state) {
  (void)state;
  if (system("command -v gmsh >/dev/null 2>&1") != 0)
    return;

  // two adjacent boxes with overlapping physical groups
  const char *geo = mesh_write_text(
      "two.geo", "SetFactory(\"OpenCASCADE\");\nBox(1) = {0,0,0,1,1,1};\nBox(2) = {1,0,0,1,1,1};\n"
                 "BooleanFragments{ Volume{1}; Delete; }{ Volume{2}; Delete; }\n"
                 "Physical Volume(\"soft\") = {1};\nPhysical Volume(\"hard\", 7) = {2};\n"
                 "Physical Volume(\"both\", 9) = {1, 2};\nPhysical Surface(33) = {2};\n"
                 "Mesh.CharacteristicLengthMin = 0.7;\nMesh.CharacteristicLengthMax = 0.7;\n");

  // the file in both formats
  static const char *const formats[] = {"msh22", "msh41"};
  uint64_t hashes[2];
  for (int i = 0; i < 2; i++) {
    const char *path = mesh_write_text(i ? "new.msh" : "old.msh", "");
    char command[512];
    snprintf(command, sizeof command, "gmsh -3 %.120s -format %s -o %.120s >/dev/null 2>&1", geo,
             formats[i], path);
    assert_int_equal(system(command), 0);
    thrum_mesh m = read_ok(path, 1);

    // volume, regions and groups as modelled
    assert_true(fabs(volume(&m) - 2) < 1e-9);
    assert_int_equal(m.region_count, 2);
    assert_int_equal(m.group_count, 4);
    assert_int_equal(group(&m, "both")->count, m.vertex_count);
    assert_int_equal(group(&m, "soft")->count + group(&m, "hard")->count,
                     m.vertex_count + group(&m, "physical_2_33")->count);
    hashes[i] = thrum_mesh_hash(&m);
    thrum_mesh_free(&m);
  }

  // the formats describe the same mesh
  assert_int_equal(hashes[0], hashes[1]);
}

static void a_tet_has_a_sixth_of_its_box(void **state) {
  (void)state;
  double corners[] = {1, 1, 1, 3, 1, 1, 1, 4, 1, 1, 1, 6};
  int32_t tet[] = {0, 1, 2, 3};
  thrum_mesh m = {.vertex_count = 4, .vertices = corners, .tet_count = 1, .tets = tet};
  assert_true(fabs(thrum_mesh_tet_volume(&m, 0) - 5) < 1e-15);
  tet[0] = 1;
  tet[1] = 0;
  assert_true(fabs(thrum_mesh_tet_volume(&m, 0) + 5) < 1e-15);
}

static void freeing_twice_is_harmless(void **state) {
  (void)state;
  thrum_mesh m = read_ok("beam:1x1x1@1x1x1", 1), zero = {0};
  thrum_mesh_free(&m);
  assert_memory_equal(&m, &zero, sizeof m);
  thrum_mesh_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // the generator and the real meshes
      cmocka_unit_test(the_beam_equals_beam1k),
      cmocka_unit_test(a_beam_fills_its_box_and_faces),
      cmocka_unit_test(neighbouring_cells_of_a_beam_share_faces),
      cmocka_unit_test(real_meshes_have_their_published_sizes),

      // VegaFEM's format
      cmocka_unit_test(a_veg_may_come_in_any_dress),
      cmocka_unit_test(element_sets_become_regions_and_groups),
      cmocka_unit_test(a_material_that_no_element_has_is_said),
      cmocka_unit_test(a_veg_without_material_says_so),
      cmocka_unit_test(included_files_are_read_in_place),

      // cleaning and scaling
      cmocka_unit_test(an_inverted_file_is_flipped_and_counted),
      cmocka_unit_test(tets_wound_either_way_are_flipped_where_they_must_be),
      cmocka_unit_test(loose_vertices_are_dropped_and_counted),
      cmocka_unit_test(a_scale_turns_lengths_into_metres),

      // the hash
      cmocka_unit_test(the_hash_sees_every_part_of_the_mesh),

      // Gmsh's formats
      cmocka_unit_test(gmsh_2_2_gives_groups_and_regions),
      cmocka_unit_test(gmsh_4_1_gives_the_same_as_2_2),
      cmocka_unit_test(gmsh_tags_may_be_huge),
      cmocka_unit_test(files_of_an_installed_gmsh_agree),

      // small helpers
      cmocka_unit_test(a_tet_has_a_sixth_of_its_box),
      cmocka_unit_test(freeing_twice_is_harmless),
  };
  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
