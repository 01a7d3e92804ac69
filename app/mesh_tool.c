/* Runs Gmsh and TetGen on a surface; see mesh_tool.h. Gmsh gets the triangles as one surface
 * with a volume in it, and takes HXT; with a size, or where that fails, Delaunay, as HXT of
 * Gmsh 4.8 breaks down at sizes below the surface's. TetGen takes -pYq1.3/12: facets as they are
 * (Y), bounds on the radius-edge ratio and the dihedral angles, and with a size one on the volume
 * (a).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "app/mesh_tool.h"

#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "io/file.h"
#include "mesh/formats/file_suffix.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/surface_write.h"
#include "mesh/surface_check.h"
#include "platform/program.h"
#include "platform/temp_folder.h"
#include "thrum/thrum.h"

const char *const mesh_tool_names[] = {"gmsh", "tetgen", NULL};

#define LOG "log.txt"
#define ARGUMENT_MAX 64

thrum_status mesh_tool_choose(mesh_tool wanted, int64_t shells, mesh_tool *tool,
                              thrum_error *error) {
  const bool gmsh = program_exists("gmsh"), tetgen = program_exists("tetgen");
  if (wanted == MESH_TOOL_NONE && !gmsh && !tetgen)
    return thrum_error_set(error, THRUM_MISSING,
                           "a surface is meshed by Gmsh or TetGen, and neither is installed: "
                           "apt-get install gmsh, or apt-get install tetgen");

  // Gmsh is preferred, but it cannot mesh several shells
  mesh_tool chosen = wanted;
  if (wanted == MESH_TOOL_NONE)
    chosen = tetgen && (shells > 1 || !gmsh) ? MESH_TOOL_TETGEN : MESH_TOOL_GMSH;

  // the refusal names the command that would help
  if (chosen == MESH_TOOL_GMSH ? !gmsh : !tetgen)
    return thrum_error_set(error, THRUM_MISSING, "%s is not installed: apt-get install %s",
                           mesh_tool_names[chosen], mesh_tool_names[chosen]);
  if (chosen == MESH_TOOL_GMSH && shells > 1)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the surface has %" PRId64 " parts, which TetGen meshes and Gmsh does "
                           "not: %s",
                           shells, tetgen ? "--tool tetgen" : "apt-get install tetgen");

  *tool = chosen;
  return THRUM_OK;
}

/* Runs a command whose words are options, or files of the temporary folder. */
static thrum_status run(temp_folder *temp, const char *const *words, temp_folder_end *end,
                        thrum_error *error) {
  char texts[12][TEMP_FOLDER_PATH_MAX], *argv[13];
  int count = 0;
  for (; count < 12 && words[count] != NULL; count++) {
    // a name with a dot is a file
    if (count > 0 && words[count][0] != '-' && strchr(words[count], '.') != NULL)
      temp_folder_path(temp, words[count], texts[count]);
    else
      snprintf(texts[count], sizeof texts[count], "%s", words[count]);
    argv[count] = texts[count];
  }
  argv[count] = NULL;
  return temp_folder_run(temp, argv, LOG, end, error);
}

static thrum_status run_gmsh(temp_folder *temp, const mesh_tool_job *job,
                             const thrum_surface_mesh *surface, int algorithm, temp_folder_end *end,
                             thrum_error *error) {
  static const char *const words[] = {"gmsh",  "-3", "-nopopup", "-save_all",   "-format",
                                      "msh41", "-o", "mesh.msh", "surface.geo", NULL};
  char path[TEMP_FOLDER_PATH_MAX], script[400];

  // Merge ends its line; the last line needs its end too
  int length = snprintf(script, sizeof script,
                        "Merge \"surface.msh\";\nSurface Loop(1) = {1};\nVolume(1) = {1};\n"
                        "Mesh.Algorithm3D = %d;\n",
                        algorithm);
  if (job->size > 0)
    length += snprintf(script + length, sizeof script - (size_t)length,
                       "Mesh.CharacteristicLengthMax = %.17g;\n", job->size);

  // the script merges the surface, so both files are written first
  temp_folder_path(temp, "surface.msh", path);
  thrum_status status = thrum_surface_write_msh(path, surface, error);
  temp_folder_path(temp, "surface.geo", path);
  THRUM_THEN(status, thrum_file_write_atomic(path, script, (size_t)length, error));
  return status < 0 ? status : run(temp, words, end, error);
}

/* With `seek`, TetGen only looks for triangles that cross. */
static thrum_status run_tetgen(temp_folder *temp, const mesh_tool_job *job,
                               const thrum_surface_mesh *surface, bool seek, temp_folder_end *end,
                               thrum_error *error) {
  char option[ARGUMENT_MAX] = "-d", path[TEMP_FOLDER_PATH_MAX];
  const char *const words[] = {"tetgen", option, "surface.smesh", NULL};

  // the largest one; on average they have a third of it, that of edges of the size
  const double volume = job->size * job->size * job->size / (2 * sqrt(2));
  if (!seek && job->size > 0)
    snprintf(option, sizeof option, "-pYq1.3/12a%.17g", volume);
  else if (!seek)
    snprintf(option, sizeof option, "-pYq1.3/12");

  // a point in each cavity marks it as a hole; the search for crossings needs none
  double *holes = NULL;
  int64_t hole_count = 0;
  temp_folder_path(temp, "surface.smesh", path);
  thrum_status status = job->cavities && !seek
                            ? thrum_surface_cavities(surface, &holes, &hole_count, error)
                            : THRUM_OK;
  THRUM_THEN(status, thrum_surface_write_smesh(path, surface, holes, hole_count, error));
  free(holes);
  return status < 0 ? status : run(temp, words, end, error);
}

/* Returns the output of the tool, ended by 0, which the caller frees; NULL when there is none. */
static char *read_log(const temp_folder *temp) {
  char path[TEMP_FOLDER_PATH_MAX];
  void *text = NULL;
  size_t size = 0;
  temp_folder_path(temp, LOG, path);
  return thrum_file_read(path, &text, &size, NULL) >= 0 ? text : NULL;
}

/* Returns the place in the file of a triangle that TetGen counts from 1. */
static int64_t line_of(const thrum_surface_mesh *surface, int64_t facet) {
  return facet >= 1 && facet <= surface->triangle_count ? surface->triangle_line[facet - 1] : 0;
}

/* Asks TetGen, where it is installed, for triangles that cross; true when it names some. */
static bool find_crossing(temp_folder *temp, const mesh_tool_job *job,
                          const thrum_surface_mesh *surface, thrum_error *error) {
  temp_folder_end end;
  long long pairs = 0, first = 0, second = 0;
  if (!program_exists("tetgen") || run_tetgen(temp, job, surface, true, &end, NULL) < 0)
    return false;

  // TetGen reports the number of pairs, then each pair by facet numbers
  char *log = read_log(temp);
  const char *count = log != NULL ? strstr(log, "Found ") : NULL;
  const char *facets = log != NULL ? strstr(log, "Facet #") : NULL;
  const bool found = count != NULL && sscanf(count, "Found %lld pairs of faces", &pairs) == 1 &&
                     facets != NULL && pairs > 0 &&
                     sscanf(facets, "Facet #%lld intersects facet #%lld", &first, &second) == 2;
  free(log);

  // the message gives lines of the user's file, not TetGen's numbers
  if (found)
    thrum_error_set(error, THRUM_BAD_VALUE,
                    "%.150s: the surface crosses itself: %lld pairs of triangles, the first in %s "
                    "%" PRId64 " and %" PRId64,
                    job->path, pairs, surface->binary ? "facets" : "lines", line_of(surface, first),
                    line_of(surface, second));
  return found;
}

/* Copies the line of the log that says most: the first Error that names a place, else the first
 * Error, else the last line. */
static void pick_line(const char *log, char line[160]) {
  int best = -1;
  line[0] = 0;
  while (*log != 0) {
    const size_t width = strcspn(log, "\n");
    const bool error = strncmp(log, "Error", 5) == 0;
    const int rank = !error ? 0 : memchr(log, '(', width) == NULL ? 1 : 2;
    if (width > 0 && (rank > best || (rank == 0 && best == 0))) {
      best = rank;
      snprintf(line, 160, "%.*s", width < 159 ? (int)width : 159, log);
    }
    log += width + (log[width] == '\n');
  }
  config_one_line(line);
}

/* Says why there is no mesh. `reason` is that of the reader, which names a file that is removed. */
static thrum_status refuse(temp_folder *temp, const mesh_tool_job *job,
                           const thrum_surface_mesh *surface, const temp_folder_end *end,
                           const thrum_error *reason, thrum_error *error) {
  const char *name = mesh_tool_names[job->tool], *said = strstr(reason->message, ": ");
  const char *hint = job->verbose ? "" : " (--verbose shows all that it said)";
  char line[160] = "";

  char *log = read_log(temp);
  if (log != NULL)
    pick_line(log, line);
  free(log);

  // a surface that crosses itself is the user's to mend, whatever the tool said
  if (find_crossing(temp, job, surface, error))
    return THRUM_BAD_VALUE;

  // otherwise the tool itself failed, and another one may not
  if (end->signal != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%.100s: %s broke down (signal %d): %s%s",
                           job->path, name, end->signal, line, hint);
  if (end->code != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%.100s: %s failed (exit code %d): %s%s",
                           job->path, name, end->code, line, hint);
  return thrum_error_set(error, THRUM_UNSUPPORTED, "%.100s: what %s made is no mesh: %.150s%s",
                         job->path, name, said != NULL ? said + 2 : reason->message, hint);
}

static void show_log(const temp_folder *temp) {
  char *log = read_log(temp);
  if (log != NULL)
    fputs(log, stderr);
  free(log);
}

/* Runs the tool once, and reads what it made: *made says whether it is a mesh. */
static thrum_status try_once(temp_folder *temp, const mesh_tool_job *job,
                             const thrum_surface_mesh *surface, int algorithm, temp_folder_end *end,
                             thrum_error *reason, thrum_mesh *mesh, bool *made,
                             thrum_error *error) {
  char path[TEMP_FOLDER_PATH_MAX];
  const bool gmsh = job->tool == MESH_TOOL_GMSH;
  const thrum_status status = gmsh ? run_gmsh(temp, job, surface, algorithm, end, error)
                                   : run_tetgen(temp, job, surface, false, end, error);
  if (job->verbose)
    show_log(temp);
  temp_folder_path(temp, gmsh ? "mesh.msh" : "surface.1.ele", path);

  // Gmsh may leave half a mesh behind and say so by its exit code
  *made = status >= 0 && end->code == 0 && thrum_mesh_read(path, 1, mesh, reason) >= 0;
  return status;
}

thrum_status mesh_tool_run(const mesh_tool_job *job, const thrum_surface_mesh *surface,
                           thrum_mesh *mesh, thrum_error *error) {
  // Gmsh has two algorithms: HXT is faster, Delaunay fails less often and says more
  enum { DELAUNAY = 1, HXT = 10 };

  temp_folder temp;
  temp_folder_end end = {0};
  thrum_error reason = {0};
  bool made = false;
  thrum_status status = THRUM_OK;
  THRUM_TRY(temp_folder_open(&temp, error));

  // HXT breaks down at sizes below the surface's, so with a size Delaunay is tried at once
  if (job->tool == MESH_TOOL_GMSH && !(job->size > 0))
    status = try_once(&temp, job, surface, HXT, &end, &reason, mesh, &made, error);

  if (status >= 0 && !made)
    status = try_once(&temp, job, surface, DELAUNAY, &end, &reason, mesh, &made, error);
  if (status >= 0 && !made)
    status = refuse(&temp, job, surface, &end, &reason, error);

  temp_folder_close(&temp);
  return status;
}

/* --- geometries ------------------------------------------------------------------------------- */

static const char *const geometry_suffixes[] = {".step", ".stp", ".iges", ".igs", ".brep", NULL};

/* The suffix that OpenCASCADE's reader goes by; NULL: none. */
static const char *geometry_suffix(const char *path) {
  for (int n = 0; geometry_suffixes[n] != NULL; n++)
    if (thrum_file_has_suffix(path, geometry_suffixes[n]))
      return geometry_suffixes[n];
  return NULL;
}

bool mesh_tool_is_geometry(const char *path) {
  return geometry_suffix(path) != NULL;
}

/* A copy of the geometry in the folder, whose name needs no quotes, and the script that meshes it.
 */
static thrum_status write_geometry(temp_folder *temp, const mesh_tool_job *job, int order,
                                   bool straight, thrum_error *error) {
  char path[TEMP_FOLDER_PATH_MAX], script[1000];
  void *data = NULL;
  size_t size = 0;
  int length = snprintf(
      script, sizeof script,
      "SetFactory(\"OpenCASCADE\");\nGeometry.OCCTargetUnit = \"M\";\n"
      "Merge \"part%s\";\nv() = Volume \"*\";\ns() = Surface \"*\";\n"
      "For i In {0:#s()-1}\nPhysical Surface(Sprintf(\"face_%%g\", s(i)), s(i)) = {s(i)};\n"
      "EndFor\nFor i In {0:#v()-1}\n"
      "Physical Volume(Sprintf(\"body_%%g\", v(i)), v(i)) = {v(i)};\nEndFor\n"
      "Mesh.CharacteristicLengthFromCurvature = 1;\nMesh.MinimumElementsPerTwoPi = 16;\n"
      "Mesh.ElementOrder = %d;\nMesh.SecondOrderLinear = %d;\n",
      geometry_suffix(job->path), order, straight);
  if (job->size > 0)
    length += snprintf(script + length, sizeof script - (size_t)length,
                       "Mesh.CharacteristicLengthMax = %.17g;\n", job->size);
  THRUM_TRY(thrum_file_read(job->path, &data, &size, error));
  char name[32];
  snprintf(name, sizeof name, "part%s", geometry_suffix(job->path));
  temp_folder_path(temp, name, path);
  thrum_status status = thrum_file_write_atomic(path, data, size, error);
  free(data);
  temp_folder_path(temp, "part.geo", path);
  THRUM_THEN(status, thrum_file_write_atomic(path, script, (size_t)length, error));
  return status;
}

/* Says why there is no mesh of a geometry. */
static thrum_status refuse_geometry(const temp_folder *temp, const mesh_tool_job *job,
                                    const temp_folder_end *end, const thrum_error *reason,
                                    thrum_error *error) {
  char line[160] = "";
  char *log = read_log(temp);
  if (log != NULL)
    pick_line(log, line);
  free(log);
  const char *hint = job->verbose ? "" : " (--verbose shows all that it said)";
  if (end->signal != 0 || end->code != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%.150s: Gmsh failed: %s%s", job->path, line,
                           hint);
  const char *said = strstr(reason->message, ": ");
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "%.100s: what Gmsh made of it is no mesh of a body: %.150s%s", job->path,
                         said != NULL ? said + 2 : reason->message, hint);
}

thrum_status mesh_tool_geometry(const mesh_tool_job *job, int order, thrum_mesh *mesh,
                                bool *straight, thrum_error *error) {
  static const char *const words[] = {"gmsh", "-3",       "-nopopup", "-format", "msh41",
                                      "-o",   "mesh.msh", "part.geo", NULL};
  temp_folder temp;
  temp_folder_end end = {0};
  thrum_error reason = {0};
  bool made = false;
  if (!program_exists("gmsh"))
    return thrum_error_set(error, THRUM_MISSING,
                           "a geometry is meshed by Gmsh, which is not installed: apt-get install "
                           "gmsh");
  THRUM_TRY(temp_folder_open(&temp, error));
  thrum_status status = THRUM_OK;
  for (int attempt = 0; attempt < order && status >= 0 && !made; attempt++) {
    char path[TEMP_FOLDER_PATH_MAX];
    *straight = attempt > 0;
    status = write_geometry(&temp, job, order, *straight, error);
    THRUM_THEN(status, run(&temp, words, &end, error));
    if (status >= 0 && job->verbose)
      show_log(&temp);
    temp_folder_path(&temp, "mesh.msh", path);
    made = status >= 0 && end.code == 0 && end.signal == 0 &&
           thrum_mesh_read(path, 1, mesh, &reason) >= 0;
  }
  if (status >= 0 && !made)
    status = refuse_geometry(&temp, job, &end, &reason, error);
  temp_folder_close(&temp);
  return status;
}
