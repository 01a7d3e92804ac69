/* `thrum mesh` with the meshing programs, where they are installed, and with stand-ins for them
 * that fail in every way. The arguments are the paths of Gmsh and TetGen; an absent one
 * is "". SPDX-License-Identifier: Apache-2.0 */
// clang-format off
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
// clang-format on

#include "tests/support/test_folder.h"

#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <time.h>

static const char *tools[2]; /* gmsh, tetgen */
static char path_before[4096];

#define CUBE                                                                                       \
  "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"                       \
  "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
#define FURTHER                                                                                    \
  "v 2 0 0\nv 2 0 1\nv 2 1 0\nv 2 1 1\nv 3 0 0\nv 3 0 1\nv 3 1 0\nv 3 1 1\n"                       \
  "f 9 10 12 11\nf 13 15 16 14\nf 9 13 14 10\nf 11 12 16 15\nf 9 11 15 13\nf 10 14 16 12\n"

#define SMALL                                                                                      \
  "v .3 .3 .3\nv .3 .3 .6\nv .3 .6 .3\nv .3 .6 .6\nv .6 .3 .3\nv .6 .3 .6\nv .6 .6 .3\n"           \
  "v .6 .6 .6\n"

static void write_text(const char *name, const char *text) {
  assert_true(text_file_write(in_folder(name), text));
}

static int setup(void **state) {
  (void)state;
  const char *path = getenv("PATH");
  snprintf(path_before, sizeof path_before, "%s", path != NULL ? path : "");
  if (test_folder_make(folder) == NULL || mkdir(in_folder("bin"), 0700) != 0 ||
      mkdir(in_folder("tmp"), 0700) != 0 || setenv("TMPDIR", in_folder("tmp"), 1) != 0)
    return -1;
  return !text_file_write(in_folder("cube.obj"), CUBE) ||
         !text_file_write(in_folder("two.obj"), CUBE FURTHER);
}

static int teardown(void **state) {
  (void)state;
  setenv("PATH", path_before, 1);
  test_folder_remove(folder);
  return 0;
}

/* The folder for temporary files is empty. */
static void expect_swept(void) {
  DIR *temporary = opendir(in_folder("tmp"));
  assert_non_null(temporary);
  const struct dirent *entry;
  while ((entry = readdir(temporary)) != NULL)
    if (entry->d_name[0] != '.')
      fail_msg("%s is left behind", entry->d_name);
  closedir(temporary);
}

/* From here on only stand-ins are found. */
static void stand_in(const char *name, const char *script) {
  char text[2048];
  snprintf(text, sizeof text, "#!/bin/sh\n%s\n", script);
  char path[64];
  snprintf(path, sizeof path, "bin/%s", name);
  write_text(path, text);
  assert_int_equal(chmod(in_folder(path), 0700), 0);
  assert_int_equal(setenv("PATH", in_folder("bin"), 1), 0);
}

static void remove_stand_ins(void) {
  unlink(in_folder("bin/gmsh"));
  unlink(in_folder("bin/tetgen"));
  assert_int_equal(setenv("PATH", in_folder("bin"), 1), 0);
}

static void expect_refusal(program_result run, int code, const char *words) {
  if (run.exit_code != code || strstr(run.err, words) == NULL || run.out[0] != 0)
    fail_msg("wanted %d '%s', got %d '%s' '%s'", code, words, run.exit_code, run.err, run.out);
  program_result_free(&run);
  assert_false(file_exists(in_folder("out.msh")));
  expect_swept();
}

/* A closed surface becomes a mesh of its volume that keeps its triangles. */
static void a_surface_is_filled(void **state) {
  (void)state;
  assert_int_equal(setenv("PATH", path_before, 1), 0);

  // the surface of a beam, exported from its model
  program_result run = thrum_run(folder, "export", "beam:1x1x1@1x1x1", "--obj", "no.obj", NULL);
  program_result_free(&run);
  run = thrum_run(folder, "precompute", "beam:8x3x3@1x0.3x0.3", "--order", "1", "--fix", "x<0.001",
                  "--modes", "2", "-q", "-o", "beam.npz", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);
  run = thrum_run(folder, "export", "beam.npz", "--obj", "skin.obj", NULL);
  assert_int_equal(run.exit_code, 0);
  program_result_free(&run);

  // each tool at a fine and at a coarse size, into two formats
  static const char *const names[] = {"gmsh", "tetgen"};
  static const char *const sizes[] = {"0.1", "9"};
  static const char *const outputs[] = {"a.msh", "a.veg"};

  for (int tool = 0; tool < 2; tool++)
    for (int n = 0; n < 2 && *tools[tool]; n++) {
      run = thrum_run(folder, "mesh", "skin.obj", "-o", outputs[n], "--tool", names[tool], "--size",
                      sizes[n], "--json", "-q", NULL);
      if (run.exit_code != 0 && run.exit_code != 3)
        fail_msg("%s: %s", names[tool], run.err);
      assert_string_equal(run.err, "");
      cJSON *object = json_line(run.out);
      assert_non_null(object);
      program_result_free(&run);

      // the report: the tool, the volume, the triangles and no groups
      assert_string_equal(cJSON_GetObjectItem(object, "tool")->valuestring, names[tool]);
      assert_true(fabs(json_value(object, "volume_m3") - 0.09) < 1e-12);
      assert_true(fabs(json_value(object, "surface_volume_m3") - 0.09) < 1e-12);
      assert_true(json_value(object, "surface_triangles") == 2 * (2 * 3 * 3 + 4 * 8 * 3));
      assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "groups")), 0);
      const double tets = json_value(object, "tets");
      cJSON_Delete(object);

      // the file holds that mesh, and no temporary file remains
      run = thrum_run(folder, "check", outputs[n], "--json", NULL);
      object = json_line(run.out);
      assert_true(json_value(object, "tets") == tets);
      cJSON_Delete(object);
      program_result_free(&run);
      expect_swept();
    }
}

/* A cube as ASCII facets, whose corners are repeated for each facet. */
static void write_stl_cube(const char *name, int edge) {
  static const int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1},
                                  {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};

  // two triangles a face
  char text[4096] = "solid cube\n";
  for (int f = 0; f < 12; f++) {
    strcat(text, "facet normal 0 0 0\nouter loop\n");
    for (int c = 0; c < 3; c++) {
      const int corner = faces[f / 2][c == 0 ? 0 : c + f % 2];
      snprintf(text + strlen(text), 64, "vertex %d %d %d\n", corner / 4 * edge,
               corner / 2 % 2 * edge, corner % 2 * edge);
    }
    strcat(text, "endloop\nendfacet\n");
  }
  strcat(text, "endsolid cube\n");
  write_text(name, text);
}

static void an_stl_in_millimetres_is_joined_scaled_and_filled(void **state) {
  (void)state;
  write_stl_cube("cube.stl", 1000);
  write_stl_cube("part.stl", 100);

  // each tool meshes it at the scale of metres
  static const char *const names[] = {"gmsh", "tetgen"};
  assert_int_equal(setenv("PATH", path_before, 1), 0);
  for (int tool = 0; tool < 2; tool++) {
    if (!*tools[tool])
      continue;
    program_result run = thrum_run(folder, "mesh", "cube.stl", "-o", "stl.msh", "--scale", "0.001",
                                   "--tool", names[tool], "--json", "-q", NULL);
    cJSON *object = json_line(run.out);
    if (object == NULL)
      fail_msg("%s", run.err);
    assert_true(fabs(json_value(object, "volume_m3") - 1) < 1e-12);
    assert_null(strstr(run.err, "--scale 0.001"));
    cJSON_Delete(object);
    program_result_free(&run);

    // a cube of 100 m is meshed, and its unit asked for
    run = thrum_run(folder, "mesh", "part.stl", "-o", "stl.msh", "--tool", names[tool], "-q", NULL);
    assert_non_null(strstr(run.err, "100 m long; if they are millimetres, give --scale 0.001"));
    program_result_free(&run);
  }
}

static void several_parts_are_for_tetgen(void **state) {
  (void)state;
  assert_int_equal(setenv("PATH", path_before, 1), 0);

  // two separate cubes are meshed as two pieces
  if (*tools[1]) {
    program_result run =
        thrum_run(folder, "mesh", "two.obj", "-o", "two.vtu", "--json", "-q", NULL);
    assert_int_equal(run.exit_code, 3); // two pieces are flagged
    cJSON *object = json_line(run.out);
    assert_non_null(object);
    assert_true(json_value(object, "pieces") == 2);
    assert_true(fabs(json_value(object, "volume_m3") - 2) < 1e-14);
    cJSON_Delete(object);
    program_result_free(&run);

    // a cavity stays empty, and a nested cube of the same winding is flagged
    write_text("cavity.obj", CUBE SMALL "f 11 12 10 9\nf 14 16 15 13\nf 10 14 13 9\n"
                                        "f 15 16 12 11\nf 13 15 11 9\nf 12 16 14 10\n");
    run = thrum_run(folder, "mesh", "cavity.obj", "-o", "cavity.vtu", "-q", "--json", NULL);
    assert_string_equal(run.err, "");
    object = json_line(run.out);
    assert_non_null(object);
    assert_true(fabs(json_value(object, "volume_m3") - 0.973) < 1e-14);
    assert_true(json_value(object, "surfaces") == 2);
    cJSON_Delete(object);
    program_result_free(&run);

    write_text("nested.obj", CUBE SMALL "f 9 10 12 11\nf 13 15 16 14\nf 9 13 14 10\n"
                                        "f 11 12 16 15\nf 9 11 15 13\nf 10 14 16 12\n");
    run = thrum_run(folder, "mesh", "nested.obj", "-o", "nested.vtu", "-q", NULL);
    assert_int_equal(run.exit_code, 3);
    assert_non_null(strstr(run.err, "encloses 1.027 m^3, the mesh fills 1 m^3"));
    program_result_free(&run);
  }

  // without TetGen the refusal says which program is needed
  remove_stand_ins();
  stand_in("gmsh", "exit 0");
  expect_refusal(thrum_run(folder, "mesh", "two.obj", "-o", "out.msh", NULL), 1,
                 "has 2 parts, which TetGen meshes and Gmsh does not: apt-get install tetgen");
}

static void triangles_that_cross_are_found(void **state) {
  (void)state;
  write_text("cross.obj", CUBE "v .5 .5 .5\nv .5 .5 2\nv .5 .7 .5\nv .8 .5 .5\n"
                               "f 9 10 11\nf 9 11 12\nf 9 12 10\nf 10 12 11\n");
  assert_int_equal(setenv("PATH", path_before, 1), 0);
  if (*tools[1])
    expect_refusal(thrum_run(folder, "mesh", "cross.obj", "-o", "out.msh", "-q", NULL), 1,
                   "cross.obj: the surface crosses itself: ");
  // as TetGen says it
  remove_stand_ins();
  stand_in("tetgen", "[ \"$1\" = -d ] || exit 3\n"
                     "echo '  Facet #12 intersects facet #13 at triangles:'\n"
                     "echo '!! Found 4 pairs of faces are intersecting.'; kill -ABRT $$");
  expect_refusal(thrum_run(folder, "mesh", "cross.obj", "-o", "out.msh", "-q", NULL), 1,
                 "the surface crosses itself: 4 pairs of triangles, the first in lines 14 and 19");
}

static void a_missing_tool_is_named_with_its_package(void **state) {
  (void)state;
  remove_stand_ins();
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", NULL), 1,
                 "apt-get install gmsh, or apt-get install tetgen");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "--tool", "gmsh", NULL), 1,
                 "gmsh is not installed: apt-get install gmsh");
}

static void a_tool_that_fails_is_quoted_in_one_line(void **state) {
  (void)state;
  static const struct {
    const char *script, *words;
  } cases[] = {{"echo 'Info : x'; echo 'Error   : no\tluck'; echo more; exit 4",
                "cube.obj: gmsh failed (exit code 4): Error   : no?luck (--verbose shows"},
               {"echo hello; exit 1", "gmsh failed (exit code 1): hello"},
               {"exit 1", "gmsh failed (exit code 1): "},
               {"kill -SEGV $$", "gmsh broke down (signal 11)"},
               {"exit 0", "what gmsh made is no mesh: cannot be read: No such file"},
               {"f=; for a; do case $a in *mesh.msh) f=$a;; esac; done; echo '$MeshFormat' >$f",
                "what gmsh made is no mesh: "},
               {"f=; for a; do case $a in *mesh.msh) f=$a;; esac; done; : >$f",
                "what gmsh made is no mesh: "}};

  // the first line with an error, or the first line, is quoted
  remove_stand_ins();
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    stand_in("gmsh", cases[n].script);
    program_result run = thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "-q", NULL);
    assert_true(line_count_is(run.err, 1));
    expect_refusal(run, 1, cases[n].words);
  }

  // with --verbose the whole output is shown
  stand_in("gmsh", "echo all that; echo there is; exit 1");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "-q", "--verbose", NULL), 1,
                 "all that\nthere is\nthrum: ");
}

/* A mesh of the cube, from a stand-in that works; its command line records the request. */
#define ONE_CUBE "8 3 0 0\n1 0 0 0\n2 0 0 1\n3 0 1 0\n4 0 1 1\n5 1 0 0\n6 1 0 1\n7 1 1 0\n8 1 1 1\n"
#define SIX_TETS "6 4 0\n1 1 8 4 2\n2 1 8 2 6\n3 1 8 6 5\n4 1 8 5 7\n5 1 8 7 3\n6 1 8 3 4\n"

static void the_other_tool_helps_where_one_fails(void **state) {
  (void)state;

  // Gmsh fails; TetGen records its options and delivers the cube
  remove_stand_ins();
  stand_in("gmsh", "echo 'Error : tired'; exit 1");
  stand_in("tetgen",
           "[ $1 = -d ] && exit 0\nd=${2%/*}\necho \"$1\" >$d/../../asked\n"
           "echo '" ONE_CUBE "' >$d/surface.1.node\necho '" SIX_TETS "' >$d/surface.1.ele");

  // the failure is reported, and the other tool's mesh is used
  program_result run =
      thrum_run(folder, "mesh", "cube.obj", "-o", "good.msh", "-q", "--json", NULL);
  assert_int_equal(run.exit_code, 3); // all corners are on the surface
  assert_non_null(strstr(run.err, "gmsh failed (exit code 1): Error : tired"));
  assert_non_null(strstr(run.err, "; trying tetgen"));

  cJSON *object = json_line(run.out);
  assert_non_null(object);
  assert_string_equal(cJSON_GetObjectItem(object, "tool")->valuestring, "tetgen");
  assert_true(json_value(object, "tets") == 6);
  assert_true(fabs(json_value(object, "volume_m3") - 1) < 1e-15);
  cJSON_Delete(object);
  program_result_free(&run);
  expect_swept();

  // the options that TetGen was given, without a size
  char *asked = text_file_read(in_folder("asked"));
  assert_string_equal(asked, "-pYq1.3/12\n");
  free(asked);

  // with a size a bound on the volume is added
  run = thrum_run(folder, "mesh", "cube.obj", "-o", "good.msh", "-q", "--size", "0.5", NULL);
  assert_int_equal(run.exit_code, 3);
  program_result_free(&run);
  asked = text_file_read(in_folder("asked"));
  assert_true(fabs(strtod(asked + strlen("-pYq1.3/12a"), NULL) - 0.125 / sqrt(8)) < 1e-15);
  free(asked);

  // a tool that was named is not replaced by the other
  expect_refusal(
      thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "--tool", "gmsh", "-q", NULL), 1,
      "gmsh failed");
}

static void nap(void) {
  const struct timespec while_waiting = {0, 20000000};
  nanosleep(&while_waiting, NULL);
}

/* SIGINT ends the tool and the processes it started, and removes the temporary files. */
static void a_signal_ends_the_tool_and_sweeps(void **state) {
  (void)state;
  static const int signals[] = {SIGINT, SIGTERM, SIGHUP};

  // a tool that starts a process of its own and waits
  remove_stand_ins();
  char script[512];
  snprintf(script, sizeof script, "/bin/sleep 100 & echo $! >%s\necho $$ >>%s\nwait",
           in_folder("pids"), in_folder("pids"));
  stand_in("gmsh", script);
  for (int n = 0; n < 3; n++) {
    // the program, running that tool
    unlink(in_folder("pids"));
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(folder) != 0 || freopen("/dev/null", "w", stderr) == NULL)
        _exit(126);
      execl(THRUM_PROGRAM, "thrum", "mesh", "cube.obj", "-o", "out.msh", (char *)NULL);
      _exit(127);
    }

    // the tool and its process are running once both numbers are there
    long pids[2] = {0};
    for (int tries = 0; tries < 3000 && pids[1] == 0; tries++) {
      nap();
      char *text = text_file_read(in_folder("pids"));
      if (text != NULL && sscanf(text, "%ld\n%ld\n", &pids[0], &pids[1]) != 2)
        pids[1] = 0;
      free(text);
    }
    assert_true(pids[1] > 0);

    // the signal ends the program
    assert_int_equal(kill(child, signals[n]), 0);
    int ended = 0;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == signals[n]);

    // the orphaned processes are gone, or zombies that init has yet to reap
    for (int p = 0; p < 2; p++) {
      char stat[64], *text = NULL;
      snprintf(stat, sizeof stat, "/proc/%ld/stat", pids[p]);
      for (int tries = 0; tries < 3000; tries++) {
        free(text);
        text = text_file_read(stat);
        if (text == NULL || strstr(text, ") Z ") != NULL)
          break;
        nap();
      }
      if (text != NULL && strstr(text, ") Z ") == NULL)
        fail_msg("process %ld goes on", pids[p]);
      free(text);
    }

    // neither the output nor a temporary file remains
    assert_false(file_exists(in_folder("out.msh")));
    expect_swept();
  }
}

/* A cube with a vertex on an edge that one of its sides has as a triangle without area, one
 * triangle twice, and its corners written twice for one side. */
static void a_surface_is_mended_and_filled(void **state) {
  (void)state;
  static const char *const names[] = {"gmsh", "tetgen"};
  assert_int_equal(setenv("PATH", path_before, 1), 0);
  write_text("mend.obj", "v 0 0 0\nv 0 0 1\nv 0 1 0\nv 0 1 1\nv 1 0 0\nv 1 0 1\nv 1 1 0\nv 1 1 1\n"
                         "v .5 0 0\nv 0 0 1\nv 1 0 1.0000001\nv 1 1 1\nv 0 1 1\nf 1 2 4 3\n"
                         "f 5 7 8 6\nf 1 9 6\nf 9 5 6\nf 1 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 1 5 9\n"
                         "f 5 7 8\nf 10 11 12 13\n");
  for (int tool = 0; tool < 2; tool++) {
    if (!*tools[tool])
      continue;
    program_result run = thrum_run(folder, "mesh", "mend.obj", "-o", "a.msh", "--tool", names[tool],
                                   "--json", "-q", NULL);
    if (run.exit_code != 0 && run.exit_code != 3)
      fail_msg("%s: %s", names[tool], run.err);
    assert_non_null(strstr(run.err, "mend.obj: 1 triangles without area were taken away"));
    cJSON *object = json_line(run.out);
    program_result_free(&run);
    const cJSON *repairs = cJSON_GetObjectItem(object, "surface_repairs");
    assert_non_null(repairs);
    assert_true(json_value(repairs, "vertices_joined") == 1);
    assert_true(json_value(repairs, "flat_triangles") == 1);
    assert_true(json_value(repairs, "split_triangles") == 1);
    assert_true(json_value(repairs, "repeated_triangles") == 1);
    assert_true(fabs(json_value(object, "volume_m3") - 1) < 1e-6);
    cJSON_Delete(object);
    unlink(in_folder("a.msh"));
  }
  unlink(in_folder("mend.obj"));
}

static void a_surface_with_faults_is_refused_before_a_tool_runs(void **state) {
  (void)state;

  // a tool that must not be reached
  remove_stand_ins();
  stand_in("gmsh", "exit 9");

  // surfaces that are open, missing or of an unknown kind
  write_text("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expect_refusal(thrum_run(folder, "mesh", "open.obj", "-o", "out.msh", NULL), 1,
                 "open.obj:4: the surface is not closed: edges of one triangle: 3");
  expect_refusal(thrum_run(folder, "mesh", "none.stl", "-o", "out.msh", NULL), 1, "none.stl");

  // nothing is left of triangles on a line, or of two on each other
  write_text("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 3 2 1\n");
  write_text("wall.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n");
  expect_refusal(thrum_run(folder, "mesh", "line.obj", "-o", "out.msh", NULL), 1,
                 "line.obj: all of its triangles are without area or on each other");
  expect_refusal(thrum_run(folder, "mesh", "wall.obj", "-o", "out.msh", NULL), 1,
                 "wall.obj: all of its triangles are without area or on each other");
  expect_refusal(thrum_run(folder, "mesh", "cube.msh", "-o", "out.msh", NULL), 1,
                 "unknown kind of surface");

  // outputs that are missing or cannot be written
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", NULL), 2, "-o MESH");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "no/out.msh", NULL), 1,
                 "no/out.msh cannot be written");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "x.stl", NULL), 2,
                 "'x.stl' names no format");

  // tools and sizes out of range
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "--tool", "netgen", NULL),
                 2, "gmsh");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "--size", "1e-9", NULL), 1,
                 "raise --size");
  expect_refusal(thrum_run(folder, "mesh", "cube.obj", "-o", "out.msh", "--size", "0", NULL), 2,
                 "--size wants");
}

/* A plate of 40 x 20 x 10 mm with a hole, as a STEP file in millimetres: in metres, its curved
 * sides have middle nodes on them, and each face is a group. */
static void a_geometry_is_meshed(void **state) {
  (void)state;
  if (*tools[0] == 0)
    return;
  assert_int_equal(setenv("PATH", path_before, 1), 0);
  char command[600];
  write_text("make.geo", "SetFactory(\"OpenCASCADE\");\nBox(1)={0,0,0,40,20,10};\n"
                         "Cylinder(2)={20,10,-1,0,0,12,4};\n"
                         "BooleanDifference{Volume{1};Delete;}{Volume{2};Delete;}\n"
                         "Save \"part.step\";\n");
  snprintf(command, sizeof command, "cd '%s' && '%s' make.geo - >make.log 2>&1", folder, tools[0]);
  if (system(command) != 0 || !file_exists(in_folder("part.step")))
    return; // of this Gmsh OpenCASCADE is no part
  program_result run = thrum_run(folder, "mesh", "part.step", "-o", "part.msh", "--size", "0.01",
                                 "--json", "-q", NULL);
  if (run.exit_code != 0)
    fail_msg("%s", run.err);
  cJSON *object = json_line(run.out);
  const double exact = 0.04 * 0.02 * 0.01 - 3.14159265358979 * 0.004 * 0.004 * 0.01;
  assert_true(fabs(json_value(object, "volume_m3") / exact - 1) < 1e-4);
  assert_true(json_value(object, "order") == 2);
  assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(object, "groups")), 7 + 1);
  cJSON_Delete(object);
  program_result_free(&run);

  // what is no geometry is said in a line
  write_text("bad.step", "no geometry\n");
  expect_refusal(thrum_run(folder, "mesh", "bad.step", "-o", "out.veg", "-q", NULL), 2,
                 "the format of 'out.veg' has no tetrahedra of ten nodes: give --order 1");
  expect_refusal(thrum_run(folder, "mesh", "bad.step", "-o", "out.msh", "-q", NULL), 1,
                 "bad.step: ");
}

int main(int argc, char **argv) {
  signals_as_in_a_terminal();
  for (int n = 0; n < 2; n++)
    tools[n] = n + 1 < argc ? argv[n + 1] : "";

  // surfaces that are filled
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_surface_is_filled),
      cmocka_unit_test(a_surface_is_mended_and_filled),
      cmocka_unit_test(an_stl_in_millimetres_is_joined_scaled_and_filled),
      cmocka_unit_test(several_parts_are_for_tetgen),
      cmocka_unit_test(a_geometry_is_meshed),

      // surfaces and tools that fail
      cmocka_unit_test(triangles_that_cross_are_found),
      cmocka_unit_test(a_missing_tool_is_named_with_its_package),
      cmocka_unit_test(a_tool_that_fails_is_quoted_in_one_line),
      cmocka_unit_test(the_other_tool_helps_where_one_fails),
      cmocka_unit_test(a_signal_ends_the_tool_and_sweeps),
      cmocka_unit_test(a_surface_with_faults_is_refused_before_a_tool_runs),
  };
  return cmocka_run_group_tests(tests, setup, teardown);
}
