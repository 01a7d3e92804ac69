/* Keywords of Abaqus decks that place, make or name nodes and elements, that say another law, or
 * that are passed over with a word. Positions and volumes are those that the keywords define.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/mesh_support.h"

#include <math.h>
#include <sys/stat.h>

#include "mesh/elastic.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_groups.h"

#define CLOSE_TO(a, b) assert_true(fabs((a) - (b)) < 1e-12)

static double volume(const thrum_mesh *mesh) {
  double sum = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    sum += thrum_mesh_tet_volume(mesh, t);
  return sum;
}

/* Reads a deck that must be good, and returns its volume. */
static double volume_of(const char *text) {
  thrum_mesh mesh = mesh_good("a.inp", text);
  assert_int_equal(mesh.flipped_tets, 0);
  const double result = volume(&mesh);
  thrum_mesh_free(&mesh);
  return result;
}

/* The mesh as it is read, whatever its elements are worth: all nodes are there, in their order. */
static thrum_mesh raw(const char *text) {
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  const thrum_mesh_source source = {"a.inp", text, strlen(text), NULL, false, false};
  if (thrum_mesh_parse_abaqus(&source, &mesh, &error) < 0)
    fail_msg("%s", error.message);
  return mesh;
}

static int64_t group_count(const thrum_mesh *mesh, const char *name) {
  const thrum_group *group = thrum_mesh_find_group(mesh, name);
  return group ? group->count : 0;
}

static bool has_note(const thrum_mesh *mesh, const char *words) {
  for (int64_t n = 0; n < mesh->note_count; n++)
    if (strstr(mesh->notes[n].text, words))
      return true;
  return false;
}

#define TET "*ELEMENT, TYPE=C3D4, ELSET=A\n1, 1, 2, 3, 4\n"
#define THREE "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n"

/* --- numbers and lines -------------------------------------------------------------------------
 */

static void numbers_are_read_as_fortran_writes_them(void **state) {
  (void)state;
  CLOSE_TO(
      volume_of("*NODE\n1, 0.D0, 0., 0.\n2, 1.D0, 0., 0.\n3, 0., 1.d+0, 0.\n4, 0., 0., 1.E0\n" TET),
      1.0 / 6);
  CLOSE_TO(volume_of("*NODE\n1, -0.0D-10, 0., 0.\n2, 0.2+1, 0., 0.\n3, 0., 30.-1, 0.\n"
                     "4, 0., 0., +.1D+01\n" TET),
           1);

  // blank fields are 0, a comma may end a line, and blanks may stand anywhere
  CLOSE_TO(volume_of("*NODE\n1,,,\n2,1\n3, ,1,\n  4 ,,,  1. ,\n" TET), 1.0 / 6);
  mesh_bad("a.inp", "*NODE\n1, 1.D, 0, 0\n" TET, "a.inp:2: expected the x coordinate, found '1.D'");
  mesh_bad("a.inp", "*NODE\n1, 1.0E1D2, 0, 0\n" TET, "expected the x coordinate, found '1.0E1D2'");
  mesh_bad("a.inp", "*NODE\n1, 1D999, 0, 0\n" TET, "a.inp:2: the x coordinate is '1D999'");
  mesh_bad("a.inp", THREE "4, 0, 0, 1\n*ELEMENT, TYPE=C3D4\n1, 1, , 3, 4\n",
           "a.inp:7: a node of the element is blank");
}

static void keyword_lines_may_be_continued_quoted_and_spaced(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "a.inp",
      "** a comment\n*node , nset = All Nodes,\n** between\n system = r\n1,0,0,0\n2,1,0,0\n"
      "** among data\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=\"A, B\"\n1,1,2,3,4\n"
      "*SOLIDSECTION, ELSET=\"A, B\", MATERIAL=m 1\n*Material, name=M1\n*Elastic\n1.D5,.3\n"
      "*Density\n1.-9\n*NSET, NSET=tip\n4, all nodes\n");
  assert_int_equal(group_count(&mesh, "All Nodes"), 4);
  assert_int_equal(group_count(&mesh, "tip"), 4);
  assert_string_equal(thrum_mesh_region_text(&mesh, 0).text, "A, B");
  assert_true(mesh.materials[0].young == 1e5 && mesh.materials[0].density == 1e-9);
  thrum_mesh_free(&mesh);

  // names are the same in any case
  mesh = mesh_good("a.inp", THREE "4,0,0,1\n" TET "*NSET, NSET=Foot\n1\n*NSET, NSET=FOOT\n2\n");
  assert_int_equal(group_count(&mesh, "Foot"), 2);
  assert_null(thrum_mesh_find_group(&mesh, "FOOT"));
  thrum_mesh_free(&mesh);
}

/* --- nodes -------------------------------------------------------------------------------------
 */

static void nodes_below_a_system_are_moved_and_turned_with_it(void **state) {
  (void)state;

  // the origin alone
  CLOSE_TO(volume_of(THREE "*SYSTEM\n0., 0., 1.\n*NODE\n4, 0., 0., 1.\n" TET), 1.0 / 3);

  // x goes to y by a turn about z, and all three axes change places by a second line
  thrum_mesh mesh = raw(THREE "*SYSTEM\n1,2,3, 1,5,9\n*NODE\n4, 1., 0., 4.\n"
                              "*SYSTEM\n0,0,0, 0,0,2\n1,0,0\n*NODE\n5, 1,2,3\n"
                              "*SYSTEM\n*NODE\n6, 7,8,9\n" TET "2, 2, 3, 4, 5\n3, 3, 4, 5, 6\n");
  const double *x = mesh.vertices + 9;
  CLOSE_TO(x[0], 1);
  CLOSE_TO(x[1], 3);
  CLOSE_TO(x[2], 7);
  CLOSE_TO(x[3], 2);
  CLOSE_TO(x[4], 3);
  CLOSE_TO(x[5], 1);
  CLOSE_TO(x[8], 9);
  thrum_mesh_free(&mesh);
  mesh_bad("a.inp", THREE "*SYSTEM\n0,0,0, 0,0,2\n*NODE\n4,0,0,1\n" TET,
           "the points of the *SYSTEM on line 5 lie on one line");

  // it ends with its part
  mesh = mesh_good("a.inp", "*PART, NAME=P\n*SYSTEM\n0,0,5\n" THREE "4,0,0,1\n" TET
                            "*END PART\n*ASSEMBLY, NAME=Q\n*INSTANCE, NAME=I, PART=P\n0,0,1\n"
                            "*END INSTANCE\n*END ASSEMBLY\n");
  CLOSE_TO(mesh.vertices[2], 6);
  thrum_mesh_free(&mesh);
}

static void nodes_may_have_cylindrical_coordinates(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", "*NODE\n1,0,0,0\n2,1,0,0\n4,0,0,1\n"
                                       "*NODE, SYSTEM=C\n3, 2., 30., 0.5\n" TET);
  CLOSE_TO(mesh.vertices[6], sqrt(3));
  CLOSE_TO(mesh.vertices[7], 1);
  CLOSE_TO(mesh.vertices[8], 0.5);
  thrum_mesh_free(&mesh);
  mesh_bad("a.inp", "*NODE, SYSTEM=S\n1, 1,0,0\n", "a.inp:1: *NODE, SYSTEM=S is not read");
}

static void a_node_that_is_given_again_is_where_it_was_given_last(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", THREE "4,0,0,1\n2,1,0,0\n" TET "*NODE\n4,0,0,3\n");
  CLOSE_TO(volume(&mesh), 0.5);
  assert_true(has_note(&mesh, "1 nodes are given again in another place, node 4 first"));
  thrum_mesh_free(&mesh);
}

static void nodes_are_made_along_lines_parabolas_and_arcs(void **state) {
  (void)state;
  const double half = sqrt(0.5);
  const struct {
    const char *ends, *line;
    double middle[2];
  } cases[] = {
      {"1,0,1,0\n9,2,0,0\n2,1,-5,0\n", "*NGEN\n1, 9, 4\n", {1, 0.5}},
      {"1,0,1,0\n9,2,0,0\n2,1,-5,0\n", "*NGEN, LINE=P\n1, 9, 4, , 1, 1, 0\n", {1, 1}},
      {"1,0,1,0\n9,1,0,0\n2,1,1,0\n", "*NGEN, LINE=C\n1, 9, 4, 2\n", {1 - half, 1 - half}},
      // about (1, 0) with z up the way from (0, 0) to (1, 1) is the longer one, of 270 degrees
      {"1,0,0,0\n9,1,1,0\n2,1,-5,0\n",
       "*NGEN, LINE=C\n1, 9, 4, , 1,0,0, 0,0,1\n",
       {1 + half, -half}}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[400];
    snprintf(text, sizeof text,
             "*NODE\n%s4,0,0,1\n%s*ELEMENT, TYPE=C3D4\n1,1,5,9,4\n2,1,9,2,4\n*NSET, NSET=m\n5\n",
             cases[n].ends, cases[n].line);
    thrum_mesh mesh = raw(text);
    const int32_t v = thrum_mesh_find_group(&mesh, "m")->vertices[0];
    CLOSE_TO(mesh.vertices[3 * v], cases[n].middle[0]);
    CLOSE_TO(mesh.vertices[3 * v + 1], cases[n].middle[1]);
    thrum_mesh_free(&mesh);
  }

  // centre and normal of an arc are given in the system of the nodes, whose y is z here
  thrum_mesh turned =
      raw("*SYSTEM\n2,3,4, 3,3,4\n2,3,5\n*NODE\n1,1,0,0\n9,0,1,0\n2,0,0,0\n3,0,0,1\n"
          "*NGEN, LINE=C\n1, 9, 4, , 0,0,0, 0,0,-1\n*ELEMENT, TYPE=C3D4\n"
          "1,1,9,2,3\n*NSET, NSET=m\n5\n");
  const double *way = turned.vertices + 3 * thrum_mesh_find_group(&turned, "m")->vertices[0];
  CLOSE_TO(way[0], 2 - half);
  CLOSE_TO(way[1], 3);
  CLOSE_TO(way[2], 4 - half);
  thrum_mesh_free(&turned);

  // the set has the ends as well, also where the numbers go down
  thrum_mesh mesh = mesh_good("a.inp", "*NODE\n1,0,0,0\n4,3,0,0\n5,0,1,0\n6,0,0,1\n"
                                       "*NGEN, NSET=E\n4, 1\n*ELEMENT, TYPE=C3D4\n1,1,2,5,6\n"
                                       "2,2,3,5,6\n3,3,4,5,6\n");
  assert_int_equal(group_count(&mesh, "E"), 4);
  CLOSE_TO(volume(&mesh), 0.5);
  thrum_mesh_free(&mesh);

  static const char *const bad[][2] = {
      {"*NGEN\n1, 9, 3\n", "a.inp:7: node 9 is not above this line"},
      {"*NGEN\n1, 4, 2\n", "a.inp:7: steps of 2 do not lead from node 1 to node 4"},
      {"*NGEN\n1, 4, 0\n", "steps of 0 do not lead"},
      {"*NGEN, LINE=X\n1, 4\n", "a.inp:6: *NGEN knows LINE=P and LINE=C"},
      {"*NGEN, LINE=C, SYSTEM=C\n1, 4\n", "*NGEN with SYSTEM is not read"},
      {"*NGEN, LINE=C\n2, 3, 1, , .5, .5, 0\n", "an arc of 180 degrees or more needs the normal"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    char text[300];
    snprintf(text, sizeof text, THREE "4,0,0,1\n%s" TET, bad[n][0]);
    mesh_bad("a.inp", text, bad[n][1]);
  }
}

#define ENDS                                                                                       \
  "*NODE, NSET=FIRST\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n"                                        \
  "*NODE, NSET=LAST\n31,0,0,3\n32,1,0,3\n33,1,1,3\n34,0,1,3\n"
#define BRICK "*ELEMENT, TYPE=C3D8, ELSET=BAR\n1, 1,2,3,4,11,12,13,14\n"

static void a_bar_may_be_filled_and_generated(void **state) {
  (void)state;

  // three layers of one brick, from the nodes of its ends
  thrum_mesh mesh = mesh_good("a.inp", ENDS "*NFILL, NSET=ALL\nFIRST, LAST, 3, 10\n" BRICK
                                            "*ELGEN, ELSET=GENERATED\n1, 3, 10, 5\n");
  assert_int_equal(mesh.vertex_count, 16);
  assert_int_equal(mesh.cut_elements, 3);
  assert_int_equal(group_count(&mesh, "ALL"), 16);
  assert_int_equal(group_count(&mesh, "GENERATED"), 16);
  assert_int_equal(group_count(&mesh, "BAR"), 8);
  CLOSE_TO(volume(&mesh), 3);
  thrum_mesh_free(&mesh);

  // rows and layers: 2 x 3 x 4 cells from the corners of a grid
  mesh = mesh_good(
      "a.inp",
      "*NODE\n1,0,0,0\n3,2,0,0\n31,0,3,0\n33,2,3,0\n*NGEN, NSET=A\n1,3\n*NGEN, NSET=B\n31,33\n"
      "*NFILL, NSET=FLOOR\nA, B, 3, 10\n*NCOPY, CHANGE NUMBER=100, OLD SET=FLOOR, SHIFT, "
      "MULTIPLE=4, NEW SET=UP\n0,0,1\n*ELEMENT, TYPE=C3D8\n1, 1,2,12,11,101,102,112,111\n"
      "*ELGEN, ELSET=E\n1, 2, 1, 1, 3, 10, 10, 4, 100, 100\n");
  assert_int_equal(mesh.vertex_count, 3 * 4 * 5);
  assert_int_equal(mesh.cut_elements, 24);
  assert_int_equal(group_count(&mesh, "UP"), 48);
  CLOSE_TO(volume(&mesh), 24);
  thrum_mesh_free(&mesh);

  // a set in its own order, which is that of the file's nodes only if it is not sorted
  mesh = mesh_good("a.inp", "*NODE\n4,0,0,0\n3,1,0,0\n2,1,1,0\n1,0,1,0\n"
                            "*NSET, NSET=FIRST, UNSORTED\n4,3,2,1\n*NODE, NSET=LAST\n"
                            "31,0,0,3\n32,1,0,3\n33,1,1,3\n34,0,1,3\n*NSET, NSET=TOP, UNSORTED\n"
                            "31,32,33,34\n*NFILL\nFIRST, TOP, 1, 10\n*ELEMENT, TYPE=C3D8\n"
                            "1, 4,3,2,1,31,32,33,34\n");
  CLOSE_TO(volume(&mesh), 3);
  thrum_mesh_free(&mesh);

  mesh_bad("a.inp", ENDS "*NFILL, BIAS=1.5\nFIRST, LAST, 3, 10\n" BRICK,
           "a.inp:11: *NFILL with BIAS is not read");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, NONE, 3, 10\n" BRICK,
           "a.inp:12: 'NONE' is no node set above this line");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, LAST, 99999999, 10\n" BRICK, "are no nodes to make");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, LAST, 4194304, 10\n" BRICK,
           "keywords make more than 4194304 nodes and elements");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, LAST, 3, 10\n*ELGEN\n7, 3, 10\n",
           "a.inp:14: element 7 is not above this line");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, LAST, 3, 10\n" BRICK "*ELGEN\n1, 4, 10, 5\n",
           "names vertex 41, which is not in the file");
  mesh_bad("a.inp", ENDS "*NFILL\nFIRST, LAST, 3, 10\n" BRICK "*ELGEN\n1, 4000000, 0, 1, 4000000\n",
           "a.inp:16: 4000000 elements in steps of 0");
  mesh_bad("a.inp",
           ENDS "*NFILL\nFIRST, LAST, 3, 10\n" BRICK "*ELGEN\n1, 4000000, 0, 1, 4000000, 1, 1\n",
           "keywords make more than 4194304 nodes and elements");
}

static void copies_are_shifted_turned_and_reflected(void **state) {
  (void)state;
  static const struct {
    const char *copy;
    double place[3]; /* of node 3, which was at (1, 1, 0) */
  } cases[] = {
      {"SHIFT\n1,2,3\n", {2, 3, 3}},
      {"SHIFT\n1,0,0\n0,0,0, 0,0,1, 90.\n", {-1, 2, 0}},
      {"REFLECT=POINT\n0,0,2\n", {-1, -1, 4}},
      {"REFLECT=LINE\n0,0,0, 0,1,0\n", {-1, 1, 0}},
      {"REFLECT=MIRROR\n3,0,0, 3,1,0\n3,0,1\n", {5, 1, 0}},
  };
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[600];
    snprintf(text, sizeof text,
             ENDS "*NSET, NSET=THREE\n3\n*NCOPY, CHANGE NUMBER=100, OLD SET=THREE, NEW SET=COPY, %s"
                  "*NFILL\nFIRST, LAST, 3, 10\n" BRICK "*ELEMENT, TYPE=C3D4\n9, 31,32,33,103\n",
             cases[n].copy);
    thrum_mesh mesh = raw(text);
    const int32_t v = thrum_mesh_find_group(&mesh, "COPY")->vertices[0];
    for (int c = 0; c < 3; c++)
      CLOSE_TO(mesh.vertices[3 * v + c], cases[n].place[c]);
    thrum_mesh_free(&mesh);
  }
  static const char *const bad[][2] = {
      {"*NCOPY, CHANGE NUMBER=100, OLD SET=FIRST, POLE\n1,2,3\n", "*NCOPY with POLE is not read"},
      {"*NCOPY, CHANGE NUMBER=100, OLD SET=FIRST\n1,2,3\n", "*NCOPY needs SHIFT or REFLECT"},
      {"*NCOPY, OLD SET=FIRST, SHIFT\n1,2,3\n", "*NCOPY needs CHANGE NUMBER=N"},
      {"*NCOPY, CHANGE NUMBER=1, OLD SET=X, SHIFT\n1,2,3\n", "'X' is no node set above"},
      {"*NCOPY, CHANGE NUMBER=-1, OLD SET=FIRST, SHIFT\n1,2,3\n", "would have the number 0"},
      {"*NCOPY, CHANGE NUMBER=9, OLD SET=FIRST, REFLECT=LINE\n1,2,3,1,2,3\n",
       "on top of each other"},
      {"*NCOPY, CHANGE NUMBER=9, OLD SET=FIRST, SHIFT, MULTIPLE=2000000000\n1,2,3\n",
       "keywords make more than"},
      {"*NCOPY, CHANGE NUMBER=9, OLD SET=FIRST, SHIFT\n1,2,3\n1,2,3,1,2,3,90\n",
       "*NCOPY turns about an axis between equal points"},
      {"*SYSTEM\n1,0,0\n*NCOPY, CHANGE NUMBER=9, OLD SET=FIRST, SHIFT\n1,2,3\n",
       "*NCOPY is not read below *SYSTEM"},
      {"*NMAP, NSET=FIRST, TYPE=CYLINDRICAL\n",
       "a.inp:11: *NMAP is not read; write the deck with"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    char text[400];
    snprintf(text, sizeof text, ENDS "%s" BRICK, bad[n][0]);
    mesh_bad("a.inp", text, bad[n][1]);
  }
}

static void elements_are_copied_and_reflected(void **state) {
  (void)state;
  static const struct {
    const char *type, *nodes;
    int count;
    double volume;
  } cases[] = {{"C3D8", "1,2,3,4,5,6,7,8", 8, 1},
               {"C3D6", "1,2,3,5,6,7", 8, 0.5},
               {"C3D5", "1,2,3,4,5", 8, 1.0 / 3},
               {"C3D4", "1,2,3,5", 8, 1.0 / 6},
               {"C3D10", "1,2,3,5,9,10,13,17,18,19", 19, 1.0 / 6},
               {"C3D20", "1,2,3,4,5,6,7,8,9,10,11,12,20,21,22,23,17,24,25,26", 26, 1}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[1500];
    snprintf(text, sizeof text,
             "*NODE, NSET=N\n1,0,0,0\n2,1,0,0\n3,1,1,0\n4,0,1,0\n5,0,0,1\n6,1,0,1\n7,1,1,1\n"
             "8,0,1,1\n%s%s*NCOPY, OLD SET=N, CHANGE NUMBER=100, REFLECT=MIRROR\n0,0,0, 1,0,0\n"
             "0,1,0\n*ELEMENT, TYPE=%s, ELSET=E\n1, %s\n"
             "*ELCOPY, ELEMENT SHIFT=10, OLD SET=E, SHIFT NODES=100, REFLECT, NEW SET=F\n",
             cases[n].count > 8 ? "9,.5,0,0\n10,1,.5,0\n11,.5,1,0\n12,0,.5,0\n13,.5,.5,0\n"
                                  "17,0,0,.5\n18,.5,0,.5\n19,.5,.5,.5\n"
                                : "",
             cases[n].count > 19 ? "20,.5,0,1\n21,1,.5,1\n22,.5,1,1\n23,0,.5,1\n24,1,0,.5\n"
                                   "25,1,1,.5\n26,0,1,.5\n"
                                 : "",
             cases[n].type, cases[n].nodes);

    // a face is shared with the copy only where the base lies in the plane; nothing is inside out
    thrum_mesh mesh = mesh_good("a.inp", text);
    assert_int_equal(mesh.flipped_tets, 0);
    CLOSE_TO(volume(&mesh), 2 * cases[n].volume);
    assert_true(group_count(&mesh, "F") >= 4);
    thrum_mesh_free(&mesh);
  }
  mesh_bad("a.inp", ENDS "*ELCOPY, OLD SET=E, SHIFT NODES=1\n", "*ELCOPY needs ELEMENT SHIFT=N");
  mesh_bad("a.inp", ENDS "*ELCOPY, ELEMENT SHIFT=1, OLD SET=E, SHIFT NODES=1\n",
           "*ELCOPY names the set 'E', which is no element set above it");
}

/* --- files -------------------------------------------------------------------------------------
 */

static void files_may_be_taken_in(void **state) {
  (void)state;
  mesh_write_text("nodes.txt", "2,1,0,0\n3,0,1,0\n");
  mesh_write_text("tets.txt", "1,1,2,3,4\n");

  // among data lines, and in the place of them; lines behind the file go on
  thrum_mesh mesh =
      mesh_good("a.inp", "*NODE, NSET=N\n1,0,0,0\n*INCLUDE, INPUT=nodes.txt\n4,0,0,1\n"
                         "*ELEMENT, TYPE=C3D4, ELSET=A, INPUT=tets.txt\n");
  CLOSE_TO(volume(&mesh), 1.0 / 6);
  assert_int_equal(group_count(&mesh, "N"), 4);
  thrum_mesh_free(&mesh);
  mesh_write_text("b.inp", TET);
  CLOSE_TO(volume_of("*NODE, INPUT=nodes.txt\n1,0,0,0\n4,0,0,1\n*include,\n input=\"b.inp\"\n"),
           1.0 / 6);

  // circles, folders above, and files that are not there
  mesh_write_text("b.inp", "*INCLUDE, INPUT=c.inp\n");
  mesh_write_text("c.inp", "*INCLUDE, INPUT=b.inp\n");
  mesh_bad("a.inp", "*INCLUDE, INPUT=a.inp\n", "a.inp:1: *INCLUDE goes in a circle");
  mesh_bad("a.inp", "*NODE\n*INCLUDE, INPUT=b.inp\n", "c.inp:1: *INCLUDE goes in a circle");
  mesh_bad("a.inp", "*NODE, INPUT=a.inp\n", "a.inp:1: INPUT= goes in a circle");
  mesh_bad("a.inp", "*NODE, INPUT=../a.inp\n", "a.inp:1: INPUT= leads out of the folder");
  mesh_bad("a.inp", "*INCLUDE, INPUT=/etc/passwd\n", "a.inp:1: *INCLUDE leads out of the folder");
  mesh_bad("a.inp", "*NODE\n1,0,0,0\n*INCLUDE, INPUT=none.inp\n*ELEMENT, TYPE=C3D4\n1,1,1,1,1\n",
           "a.inp:3: cannot find the included file");
  mesh_bad("a.inp", "*INCLUDE\n", "a.inp:1: *INCLUDE names no file");

  // a step may name files of another program, which are not opened
  CLOSE_TO(volume_of(THREE "4,0,0,1\n" TET "*SUBMODEL, TYPE=NODE, INPUT=global.frd\nN\n"), 1.0 / 6);
}

/* --- sets and regions --------------------------------------------------------------------------
 */

#define TWO                                                                                        \
  "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n*ELEMENT, TYPE=C3D4, ELSET=V1\n1,1,2,3,4\n" \
  "*ELEMENT, TYPE=C3D4, ELSET=V2\n2,2,3,4,5\n"

static void element_sets_without_sections_are_regions(void **state) {
  (void)state;
  static const struct {
    const char *sets;
    int count;
    const char *names[2];
  } cases[] = {
      {"", 2, {"V1", "V2"}},
      {"*ELSET, ELSET=steel\n1\n*ELSET, ELSET=rubber\n2\n", 2, {"steel", "rubber"}},
      {"*ELSET, ELSET=both\n1,2\n*ELSET, ELSET=steel\n1\n*ELSET, ELSET=rubber\n2\n",
       2,
       {"steel", "rubber"}},
      {"*ELSET, ELSET=printed\n1\n", 2, {"V1", "V2"}},
      {"*ELSET, ELSET=a\n1\n*ELSET, ELSET=b\n1\n", 2, {"V1", "V2"}},
      {"*SOLID SECTION, ELSET=whole, MATERIAL=M\n*ELSET, ELSET=whole\n1,2\n*MATERIAL, NAME=M\n",
       1,
       {"whole"}}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    char text[600];
    snprintf(text, sizeof text, TWO "%s", cases[n].sets);
    thrum_mesh mesh = mesh_good("a.inp", text);
    assert_int_equal(mesh.region_count, cases[n].count);
    for (int i = 0; i < cases[n].count; i++)
      assert_string_equal(thrum_mesh_region_text(&mesh, i).text, cases[n].names[i]);
    assert_int_equal(mesh.note_count, 0);
    thrum_mesh_free(&mesh);
  }

  // what is in no set is a region without a name; sets across each other are none
  thrum_mesh mesh =
      mesh_good("a.inp", "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
                         "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n2,2,3,4,5\n*ELSET, ELSET=hard\n2\n");
  assert_int_equal(mesh.region_count, 2);
  assert_string_equal(thrum_mesh_region_text(&mesh, 1).text, "hard");
  thrum_mesh_free(&mesh);
  mesh = mesh_good("a.inp", "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n6,3,0,0\n"
                            "*ELEMENT, TYPE=C3D4, ELSET=all\n1,1,2,3,4\n2,2,3,4,5\n3,2,4,5,6\n"
                            "*ELSET, ELSET=a\n1,2\n*ELSET, ELSET=b\n2,3\n");
  assert_int_equal(mesh.region_count, 1);
  assert_string_equal(thrum_mesh_region_text(&mesh, 0).text, "all");
  assert_true(has_note(&mesh, "element sets overlap, so they are groups and no regions"));
  thrum_mesh_free(&mesh);
}

static void sets_take_their_members_from_ranges_names_and_elements(void **state) {
  (void)state;

  // a range may come before its nodes, and end with its first number
  thrum_mesh mesh = mesh_good("a.inp", "*NSET, NSET=R, GENERATE\n1, 5, 2\n2\n" TWO
                                       "*NSET, NSET=E, ELSET=V2\n*ELSET, ELSET=W\nV1, 2\n"
                                       "*NSET, NSET=V1\n1\n");
  assert_int_equal(group_count(&mesh, "R"), 4);
  assert_int_equal(group_count(&mesh, "E"), 4);
  assert_int_equal(group_count(&mesh, "W"), 5);

  // a name of both kinds is told of
  assert_int_equal(group_count(&mesh, "V1"), 4);
  assert_true(has_note(&mesh, "'V1' is a node set and an element set with more nodes"));
  thrum_mesh_free(&mesh);
  mesh_bad("a.inp", TWO "*NSET, NSET=E, ELSET=V3\n", "the set names 'V3', which is no element set");

  // sets that double with every line are refused before they fill the memory
  char text[8000];
  size_t used = (size_t)sprintf(text, TWO "*ELSET, ELSET=s0\n1,2\n");
  for (int n = 1; n < 60; n++)
    used += (size_t)sprintf(text + used, "*ELSET, ELSET=s%d\ns%d, s%d\n", n, n - 1, n - 1);
  mesh_bad("a.inp", text, "the sets name far more than the file holds");
}

static void sets_of_a_part_and_of_the_assembly_may_have_one_name(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "a.inp",
      "*PART, NAME=P\n" THREE "4,0,0,1\n" TET "*NSET, NSET=Set-1\n1,2,3,4\n*ELSET, ELSET=Set-1\n1\n"
      "*ELSET, ELSET=Set-2\n1\n*SOLID SECTION, ELSET=Set-1, MATERIAL=M\n*END PART\n"
      "*ASSEMBLY, NAME=Q\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n*NODE\n1, 9,9,9\n"
      "*NSET, NSET=Set-1, INSTANCE=I\n1\n*NSET, NSET=Set-2, INSTANCE=I\n2\n*NSET, NSET=Own\nI.3\n"
      "*NSET, NSET=Reference\n1\n*NSET, NSET=Both\nSet-1, Own, Reference, I.4\n"
      "*NSET, NSET=Part\nI.Set-1\n*END ASSEMBLY\n*MATERIAL, NAME=M\n");
  assert_int_equal(group_count(&mesh, "Set-1"), 4);
  assert_int_equal(group_count(&mesh, "Assembly.Set-1"), 1);
  assert_int_equal(group_count(&mesh, "Set-2"), 4);
  assert_int_equal(group_count(&mesh, "Assembly.Set-2"), 1);
  assert_int_equal(group_count(&mesh, "Own"), 1);
  assert_int_equal(group_count(&mesh, "Reference"), 0);
  assert_int_equal(group_count(&mesh, "Both"), 3);
  assert_int_equal(group_count(&mesh, "Part"), 4);
  assert_string_equal(thrum_mesh_region_text(&mesh, 0).text, "Set-1");
  thrum_mesh_free(&mesh);
}

/* --- laws, sections and what is passed over ----------------------------------------------------
 */

#define SECTION TET "*SOLID SECTION, ELSET=A, MATERIAL=M\n*MATERIAL, NAME=M\n"

static void another_law_is_told_of(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good("a.inp", THREE "4,0,0,1\n" SECTION
                                             "*ELASTIC\n1e5,.3\n*DENSITY\n1\n*CONDUCTIVITY\n1\n"
                                             "*PLASTIC\n1,0\n*EXPANSION\n1e-5\n");
  assert_int_equal(mesh.note_count, 1);
  assert_string_equal(mesh.notes[0].text,
                      "material 'M' has *PLASTIC on line 16, which is not read: it is taken as "
                      "linear elastic, by its *ELASTIC");
  assert_true(mesh.has_material);
  thrum_mesh_free(&mesh);

  // without constants of its own the material has to be said
  mesh = mesh_good("a.inp", THREE "4,0,0,1\n" SECTION "*HYPERELASTIC, NEO HOOKE\n1,0\n");
  assert_false(mesh.has_material);
  assert_true(has_note(&mesh, "material 'M' is *HYPERELASTIC on line 10"));
  assert_true(has_note(&mesh, "--material A:E,NU,RHO"));
  thrum_mesh_free(&mesh);

  // a law of a material that nothing is made of does not matter
  mesh = mesh_good("a.inp", THREE "4,0,0,1\n" SECTION "*ELASTIC\n1e5,.3\n*DENSITY\n1\n"
                                  "*MATERIAL, NAME=OTHER\n*CREEP\n1\n");
  assert_int_equal(mesh.note_count, 0);
  thrum_mesh_free(&mesh);
  mesh_bad("a.inp", THREE "4,0,0,1\n" SECTION "*ELASTIC, TYPE=ANISO\n1,1,1,1,1,1,1,1\n",
           "a.inp:10: *ELASTIC of type ANISO is not supported, only ISOTROPIC, ORTHO");
  mesh_bad("a.inp", THREE "4,0,0,1\n" TET "*SOLID SECTION, ELSET=A, COMPOSITE\n",
           "a.inp:8: *SOLID SECTION, COMPOSITE is not read");
}

/* Constants of both kinds are the same material, along the directions of the section's orientation,
 * which turn with the instance; a deck that is written has them again. */
static void orthotropic_materials_are_read_and_written(void **state) {
  (void)state;
  static const double own[9] = {9e3, 4e3, 2e3, 0.3, 0.25, 0.35, 1500, 1200, 800};
  double row[THRUM_ELASTIC_NUMBERS] = {0};
  memcpy(row + THRUM_ELASTIC_YOUNG, own, sizeof own);
  thrum_elastic_matrix root, c;
  assert_true(thrum_elastic_root(row, root));
  thrum_elastic_stiffness(root, c);
  for (int moduli = 0; moduli < 2; moduli++) {
    char text[1500];
    snprintf(text, sizeof text,
             "%s*ORIENTATION, NAME=O, SYSTEM=RECTANGULAR\n0,1,0,0,0,1\n3,90\n"
             "*MATERIAL, NAME=M\n*DENSITY\n2\n*ELASTIC, TYPE=%s\n",
             THREE "4,0,0,1\n" TET "*SOLID SECTION, ELSET=A, MATERIAL=M, ORIENTATION=O\n",
             moduli ? "ORTHO" : "ENGINEERING CONSTANTS");
    const double nine[9] = {c[0][0], c[0][1], c[1][1], c[0][2], c[1][2],
                            c[2][2], c[5][5], c[4][4], c[3][3]};
    for (int n = 0; n < 9; n++)
      snprintf(text + strlen(text), sizeof text - strlen(text), "%.17g%s", (moduli ? nine : own)[n],
               n == 7 ? "\n" : ",");
    thrum_mesh mesh = mesh_good("a.inp", text);
    assert_int_equal(mesh.elastic_count, 1);
    for (int k = 0; k < 9; k++)
      assert_true(fabs(mesh.elastic[THRUM_ELASTIC_YOUNG + k] / own[k] - 1) < 1e-12);
    double axes[3][3];
    assert_true(thrum_elastic_axes(mesh.elastic, NULL, axes));
    assert_true(fabs(axes[0][2] - 1) < 1e-12 && fabs(axes[1][1] + 1) < 1e-12);

    char path[200];
    snprintf(path, sizeof path, "%s/b.inp", mesh_folder);
    mesh_write_text("b.inp", "");
    thrum_mesh_lost lost = {0};
    thrum_mesh again = {0};
    assert_int_equal(thrum_mesh_write(path, &mesh, &(thrum_mesh_write_options){0}, &lost, NULL), 0);
    assert_int_equal(lost.directed, 0);
    assert_int_equal(thrum_mesh_read(path, 1, &again, NULL), THRUM_OK);
    assert_int_equal(again.elastic_count, 1);
    for (int k = 0; k < THRUM_ELASTIC_NUMBERS; k++)
      assert_true(fabs(again.elastic[k] - mesh.elastic[k]) <=
                  1e-12 * fabs(mesh.elastic[k]) + 1e-12);
    thrum_mesh_free(&again);
    thrum_mesh_free(&mesh);
  }

  // what is wrong with one
  static const char head[] =
      THREE "4,0,0,1\n" TET "*SOLID SECTION, ELSET=A, MATERIAL=M, ORIENTATION=O\n"
            "*MATERIAL, NAME=M\n*DENSITY\n2\n";
  static const char good[] = "*ELASTIC, TYPE=ENGINEERING CONSTANTS\n9e3,4e3,2e3,.3,.25,.35,1500,"
                             "1200\n800\n";
  static const char *const bad[][2] = {
      {"*ELASTIC, TYPE=ORTHO\n1,1,1,1,1,1,1,1\n", "nine constants"},
      {"*ELASTIC, TYPE=ORTHO\n1,2,1,0,0,1,1,1\n1\n", "no positive energy"},
      {"*ELASTIC, TYPE=ENGINEERING CONSTANTS\n1,1,1,2,0,0,1,1\n1\n", "no positive energy"},
      {"", "no orientation 'O'"},
      {"*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL\n0,0,0,0,0,1\n", "needs an *ORIENTATION"},
      {"*ORIENTATION, NAME=O\n1,0,0,2,0,0\n", "needs an *ORIENTATION"}};
  for (size_t n = 0; n < sizeof bad / sizeof *bad; n++) {
    char text[1500];
    snprintf(text, sizeof text, "%s%s%s", head, n < 3 ? "" : good, bad[n][0]);
    mesh_bad("a.inp", text, bad[n][1]);
  }
}

static void keywords_that_are_passed_over_are_named_if_they_matter(void **state) {
  (void)state;
  thrum_mesh mesh = mesh_good(
      "a.inp",
      "*HEADING\na deck\n" THREE "4,0,0,1\n" TET
      "*ELEMENT, TYPE=S3, ELSET=SKIN\n7,1,2,3\n*SHELL SECTION, ELSET=SKIN, MATERIAL=M\n.1\n"
      "*SURFACE, NAME=S\nA, S1\n*TIE, NAME=T\nS, S\n*TIE, NAME=U\nS, S\n*TIE, NAME=V\nS, S\n"
      "*TRANSFORM, NSET=N\n1,0,0,0,1,0\n*BOUNDARY\n1,1,3\n*FUNNY WORD\n1\n*STEP\n*STATIC\n"
      "*FUNNY LOAD\n1\n*NODE PRINT, NSET=N\nU\n*END STEP\n");
  assert_int_equal(mesh.note_count, 3);
  assert_string_equal(mesh.notes[0].text,
                      "*SHELL SECTION on line 12 is not read: its elements have "
                      "no stiffness and no mass here");
  assert_string_equal(mesh.notes[1].text,
                      "*TIE on line 16 and 2 times more is not read: what it ties or constrains is "
                      "free here");
  assert_string_equal(mesh.notes[2].text,
                      "*FUNNY WORD on line 26 is not read: the keyword is not known here");
  thrum_mesh_free(&mesh);

  static const char *const refused[][2] = {
      {"*IMPERFECTION, FILE=f, STEP=1\n1, 1.\n", "*IMPERFECTION is not read; write the deck"},
      {"*PARAMETER\na = 1\n", "*PARAMETER is not read; write the deck with numbers"},
      {"*SYMMETRIC MODEL GENERATION, REVOLVE\n", "*SYMMETRIC MODEL GENERATION is not read"},
      {"*ELEMENT, TYPE=SC8R\n", "elements of type SC8R are not supported"},
      {"*ELEMENT\n7,1,2\n", "*ELEMENT needs TYPE="}};
  for (size_t n = 0; n < sizeof refused / sizeof *refused; n++) {
    char text[300];
    snprintf(text, sizeof text, THREE "4,0,0,1\n" TET "%s", refused[n][0]);
    mesh_bad("a.inp", text, refused[n][1]);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      // from the lines of a deck to what it says of a body
      cmocka_unit_test(numbers_are_read_as_fortran_writes_them),
      cmocka_unit_test(keyword_lines_may_be_continued_quoted_and_spaced),
      cmocka_unit_test(nodes_below_a_system_are_moved_and_turned_with_it),
      cmocka_unit_test(nodes_may_have_cylindrical_coordinates),
      cmocka_unit_test(a_node_that_is_given_again_is_where_it_was_given_last),
      cmocka_unit_test(nodes_are_made_along_lines_parabolas_and_arcs),
      cmocka_unit_test(a_bar_may_be_filled_and_generated),
      cmocka_unit_test(copies_are_shifted_turned_and_reflected),
      cmocka_unit_test(elements_are_copied_and_reflected),
      cmocka_unit_test(files_may_be_taken_in),
      cmocka_unit_test(element_sets_without_sections_are_regions),
      cmocka_unit_test(sets_take_their_members_from_ranges_names_and_elements),
      cmocka_unit_test(sets_of_a_part_and_of_the_assembly_may_have_one_name),
      cmocka_unit_test(another_law_is_told_of),
      cmocka_unit_test(orthotropic_materials_are_read_and_written),
      cmocka_unit_test(keywords_that_are_passed_over_are_named_if_they_matter),
  };

  return cmocka_run_group_tests(tests, mesh_setup, mesh_teardown);
}
