/* `thrum mesh`: fills a closed surface with tetrahedra, by Gmsh or TetGen, and says what came out.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app/check_report.h"
#include "app/cmd.h"
#include "app/mesh_tool.h"
#include "config/message.h"
#include "config/options.h"
#include "config/progress.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/formats/surface_read.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_flags.h"
#include "mesh/midsides.h"
#include "mesh/surface_check.h"
#include "mesh/surface_join.h"
#include "mesh/surface_repair.h"
#include "mesh/surface_sheet.h"

/* How far the volume of the mesh may be off that of the surface. */
#define VOLUME_TOLERANCE 1e-6

#define TETS_MAX 1e8 /* beyond what a machine meshes; a size is then taken for a mistake */

typedef struct mesh_request {
  const char *surface, *output;
  int tool;
  double size, scale;
  int64_t order;
  double thickness; /* 0: a body is filled */
  int64_t layers;
  int side;
  bool json, quiet, verbose;
} mesh_request;

/* The surface, the mesh in it, and what there is to say of both. */
typedef struct mesh_work {
  thrum_surface_mesh surface;
  thrum_surface_checked checked;
  thrum_surface_repairs repairs;
  thrum_mesh mesh;
  thrum_mesh_examined examined;
  mesh_tool tool;
  unsigned flags;
  bool other_volume;
} mesh_work;

static const char *const sides[] = {"middle", "top", "bottom", NULL};

#define AT(member) CONFIG_AT(mesh_request, member)

static const config_option table[] = {
    OPTION_TEXT("output", "MESH", NULL, "the mesh to write", .letter = 'o', AT(output)),
    OPTION_NUMBER("size", "m", "as the surface has them", "about the length of edges inside",
                  AT(size), CONFIG_ABOVE(0)),
    OPTION_NUMBER("scale", NULL, "1", "multiply lengths by this, such as 0.001 for millimetres",
                  AT(scale), CONFIG_ABOVE(0)),
    OPTION_COUNT("order", "1; 2 of a geometry",
                 "of the tetrahedra; 2: ten nodes, those in the middle of straight edges, or on "
                 "the geometry",
                 AT(order), CONFIG_RANGE(1, 2)),

    // a sheet in place of a body
    OPTION_HEADING("of a sheet"),
    OPTION_NUMBER("thickness", "m", "the surface is filled",
                  "make a sheet of the surface, which may be open then: triangles become wedges, "
                  "polygons of four corners hexahedra",
                  AT(thickness), CONFIG_ABOVE(0)),
    OPTION_COUNT("layers", "1", "of elements through the thickness", AT(layers),
                 CONFIG_RANGE(1, 100)),
    OPTION_CHOICE("side", sides, "middle",
                  "where the surface lies in the sheet; the top is where its triangles go round "
                  "counterclockwise",
                  AT(side)),

    // how the work is done and shown
    OPTION_CHOICE("tool", mesh_tool_names, "whichever is installed", "what fills the surface",
                  AT(tool)),
    OPTION_FLAG("verbose", "show all that the tool says", AT(verbose)),
    OPTION_JSON(mesh_request),
    OPTION_QUIET(mesh_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_mesh = {
    .name = "mesh",
    .summary = "fill a closed surface with tetrahedra, by Gmsh or TetGen",
    .usage = "SURFACE -o MESH [OPTIONS]",
    .about =
        "Fills a closed triangle surface (.obj, .stl) with tetrahedra and writes the mesh in the "
        "format that the suffix of MESH names (see thrum convert). The work is done by Gmsh or "
        "TetGen, whichever is installed (apt-get install gmsh, apt-get install tetgen); of both, "
        "by Gmsh, but by TetGen for several parts. The surface is checked first, and mended where "
        "nothing is lost; its triangles stay as they are otherwise. The mesh is checked "
        "afterwards, as thrum check does. With --thickness the surface becomes a sheet of wedges "
        "and "
        "hexahedra instead, without another program. A geometry (.step, .stp, .iges, .igs, .brep) "
        "is "
        "meshed by Gmsh, with a group face_N of each face.",
    .options = table,
    .examples = "mesh statue.obj -o statue.msh\n"
                "mesh roof.obj -o roof.vtu --thickness 0.25\n"
                "mesh part.step -o part.msh --size 0.005\n"
                "mesh part.stl -o part.veg --scale 0.001 --size 0.01 --tool tetgen",
    .exits = "0 done, 1 refused, 2 usage, 3 done, but something is flagged",
};

static int read_options(int argc, char **argv, mesh_request *request) {
  CONFIG_TRY(
      config_options_read_one(&command_mesh, "surface", argc, argv, request, &request->surface));
  if (request->output == NULL)
    return config_usage("mesh", "say where to write the mesh: -o MESH");
  if (!thrum_mesh_is_named(request->output) || strncmp(request->output, "beam:", 5) == 0)
    return config_usage("mesh",
                        "'%s' names no format of meshes; end it in .msh, .veg, .vtu, .ele, "
                        "...: see thrum convert --help",
                        request->output);
  if (mesh_tool_is_geometry(request->surface) &&
      (request->thickness > 0 || request->tool == MESH_TOOL_TETGEN))
    return config_usage("mesh", "a geometry is filled by Gmsh: leave --thickness and --tool out");
  if (request->thickness > 0 && (request->size > 0 || request->order > 1 || request->tool >= 0))
    return config_usage("mesh", "--thickness makes a sheet of the surface as it is: leave --size, "
                                "--order and --tool out");
  if (!(request->thickness > 0) && (request->layers > 1 || request->side > 0))
    return config_usage("mesh", "--layers and --side are of a sheet: give --thickness");
  const bool quadratic =
      request->order == 2 || (mesh_tool_is_geometry(request->surface) && request->order != 1);
  if (quadratic && !thrum_mesh_write_takes(request->output, THRUM_FORM_TET10))
    return config_usage("mesh",
                        "the format of '%s' has no tetrahedra of ten nodes: give --order 1, or "
                        "write another one",
                        request->output);
  if (request->thickness > 0 && !thrum_mesh_write_takes(request->output, THRUM_FORM_HEX8))
    return config_usage("mesh",
                        "the format of '%s' has no wedges and hexahedra: take .msh, .inp, "
                        ".vtu, .vtk or .mesh",
                        request->output);
  return COMMAND_DONE;
}

/* A regular tetrahedron of edge H fills H^3 / (6 sqrt 2). */
static thrum_status check_size(const mesh_request *request, const mesh_work *work,
                               thrum_error *error) {
  const double tets = fabs(work->checked.volume) / pow(request->size, 3) * 6 * sqrt(2);
  if (!(request->size > 0) || tets <= TETS_MAX)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "edges of %g m would make %.0e tetrahedra of %.150s: raise --size",
                         request->size, tets, path_basename(request->surface));
}

/* Mends the surface where it has a fault that a mesher minds and that can be mended. */
static thrum_status repair_surface(const char *path, mesh_work *work, thrum_error *error) {
  const thrum_surface_checked *c = &work->checked;
  if (c->flat.count + c->twice.count + c->open.count + c->crowded.count == 0)
    return THRUM_OK;
  THRUM_TRY(thrum_surface_repair(&work->surface, &work->repairs, error));
  if (work->surface.triangle_count == 0)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "%.200s: all of its triangles are without area or on each other, so "
                           "they enclose nothing",
                           path);
  return thrum_surface_check(&work->surface, &work->checked, error);
}

/* Tells what was mended, each in a line of its own. */
static void warn_repairs(const mesh_work *work, const char *name) {
  const struct {
    int64_t count;
    const char *words;
  } lines[] = {{work->repairs.joined, "vertices at open edges were joined with others close by"},
               {work->repairs.flat, "triangles without area were taken away"},
               {work->repairs.split, "triangles were split at a vertex on their edge"},
               {work->repairs.twice, "triangles that were there again were taken away"},
               {work->repairs.walls, "pairs of triangles that enclose nothing were taken away"}};
  for (size_t n = 0; n < sizeof lines / sizeof *lines; n++)
    if (lines[n].count > 0)
      config_warn("%s: %" PRId64 " %s", name, lines[n].count, lines[n].words);
}

/* Reads, checks and mends the surface; vertices that are there several times are joined if it is
 * open. */
static thrum_status read_surface(const mesh_request *request, mesh_work *work,
                                 config_progress *progress, thrum_error *error) {
  int64_t joined = 0;
  config_progress_update(progress, "reading the surface", 0);
  THRUM_TRY(thrum_surface_mesh_read(request->surface, request->scale, &work->surface, error));
  THRUM_TRY(thrum_surface_check(&work->surface, &work->checked, error));

  // an open surface may have each corner once for every triangle, as .stl files do
  if (work->checked.open.count > 0) {
    THRUM_TRY(thrum_surface_join(&work->surface, &joined, error));
    THRUM_TRY(thrum_surface_check(&work->surface, &work->checked, error));
  }
  THRUM_TRY(repair_surface(request->surface, work, error));
  THRUM_TRY(thrum_surface_meshable(&work->surface, &work->checked, request->surface, error));
  THRUM_TRY(check_size(request, work, error));
  config_progress_end(progress, true);

  // defects that do not keep the mesher from its work
  const char *name = path_basename(request->surface);
  if (joined > 0)
    config_warn("%s: %" PRId64 " vertices on top of others were joined with them", name, joined);
  warn_repairs(work, name);
  if (work->checked.turned.count > 0)
    config_warn("%s: the triangles go round opposite ways at %" PRId64 " edges", name,
                work->checked.turned.count);
  return THRUM_OK;
}

/* Runs the tool that was chosen. Where the user chose none and the first one cannot mesh the
 * surface, the other one is tried. */
static thrum_status run_tool(const mesh_request *request, mesh_work *work,
                             config_progress *progress, thrum_error *error) {
  thrum_status status =
      mesh_tool_choose((mesh_tool)request->tool, work->checked.shells, &work->tool, error);
  for (int n = 0; n < 2 && status >= 0; n++) {
    const mesh_tool_job job = {.path = request->surface,
                               .tool = work->tool,
                               .size = request->size,
                               .cavities =
                                   work->checked.shells > 1 && work->checked.turned.count == 0,
                               .verbose = request->verbose};

    char label[64];
    snprintf(label, sizeof label, "meshing with %s", mesh_tool_names[work->tool]);
    config_progress_update(progress, label, 0);
    status = mesh_tool_run(&job, &work->surface, &work->mesh, error);
    config_progress_end(progress, status >= 0);
    if (status >= 0)
      return status;

    // only a surface that this tool cannot mesh is tried with the other one
    const mesh_tool other = work->tool == MESH_TOOL_GMSH ? MESH_TOOL_TETGEN : MESH_TOOL_GMSH;
    if (status != THRUM_UNSUPPORTED || n > 0 || request->tool >= 0 ||
        mesh_tool_choose(other, work->checked.shells, &work->tool, NULL) < 0)
      return status;
    config_warn("%s; trying %s", error->message, mesh_tool_names[other]);
    status = THRUM_OK;
  }
  return status;
}

static void warn_volume(const mesh_request *request, mesh_work *work) {
  const double wanted = fabs(work->checked.volume), got = work->examined.volume;
  work->other_volume =
      work->checked.turned.count == 0 && !(fabs(got - wanted) <= VOLUME_TOLERANCE * wanted);
  if (work->other_volume)
    config_warn(
        "%s: the surface encloses %.6g m^3, the mesh fills %.6g m^3; do closed surfaces lie inside "
        "others, or go round the wrong way?",
        path_basename(request->surface), wanted, got);
}

/* A surface has no unit: most parts in millimetres are longer than this when read as metres. The
 * bound is that of meshes (mesh_flags.c). */
#define EXTENT_ASKED 20.0

static void warn_unit(const mesh_request *request, const mesh_work *work) {
  if (request->scale == 1 && work->examined.extent >= EXTENT_ASKED)
    config_warn("%s: its numbers were taken as metres, so the body is %.3g m long; if they are "
                "millimetres, give --scale 0.001",
                path_basename(request->surface), work->examined.extent);
}

static void print_results(const mesh_request *request, const mesh_work *work) {
  const char *tool = work->tool >= 0 ? mesh_tool_names[work->tool] : NULL;
  const bool flagged = work->flags != 0 || work->other_volume;

  // the object of `thrum check` with the surface added
  cJSON *object = check_report_object(request->output, &work->mesh, &work->examined, work->flags);
  cJSON_ReplaceItemInObjectCaseSensitive(object, "status",
                                         cJSON_CreateString(flagged ? "flagged" : "done"));
  json_string(object, "surface", request->surface);
  json_string(object, "tool", request->thickness > 0 ? NULL : tool);
  json_number(object, "surface_volume_m3",
              work->checked.shells == 0 || request->thickness > 0 ? NAN
                                                                  : fabs(work->checked.volume));
  json_number(object, "surface_shells", (double)work->checked.shells);
  cJSON *repairs = cJSON_AddObjectToObject(object, "surface_repairs");
  json_number(repairs, "vertices_joined", (double)work->repairs.joined);
  json_number(repairs, "flat_triangles", (double)work->repairs.flat);
  json_number(repairs, "split_triangles", (double)work->repairs.split);
  json_number(repairs, "repeated_triangles", (double)work->repairs.twice);
  json_number(repairs, "empty_pairs", (double)work->repairs.walls);
  check_report_show(object, request->json);
}

/* The sheet of an open or closed surface. */
static thrum_status make_sheet(const mesh_request *request, mesh_work *work,
                               config_progress *progress, thrum_error *error) {
  int64_t joined = 0;
  config_progress_update(progress, "reading the surface", 0);
  const thrum_sheet_options options = {request->thickness,
                                       request->layers > 0 ? request->layers : 1,
                                       (thrum_sheet_side)(request->side > 0 ? request->side : 0)};
  THRUM_TRY(thrum_surface_mesh_read(request->surface, request->scale, &work->surface, error));
  THRUM_TRY(thrum_surface_join(&work->surface, &joined, error));
  THRUM_TRY(thrum_surface_check(&work->surface, &work->checked, error));
  config_progress_update(progress, "making the sheet", 0);
  THRUM_TRY(thrum_surface_sheet(&work->surface, &options, request->surface, &work->mesh, error));
  return thrum_mesh_clean(&work->mesh, request->surface, 1, error);
}

/* The body of a geometry, which says its unit itself. */
static thrum_status mesh_geometry(const mesh_request *request, mesh_work *work,
                                  config_progress *progress, thrum_error *error) {
  const mesh_tool_job job = {.path = request->surface,
                             .size = request->size / request->scale,
                             .verbose = request->verbose};
  bool straight = false;
  work->tool = MESH_TOOL_GMSH;
  config_progress_update(progress, "meshing with gmsh", 0);
  const thrum_status status =
      mesh_tool_geometry(&job, request->order == 1 ? 1 : 2, &work->mesh, &straight, error);
  config_progress_end(progress, status >= 0);
  THRUM_TRY(status);
  if (straight)
    config_warn("%s: middle nodes lie on straight edges, as on the geometry elements would turn "
                "inside out; a smaller --size mends it",
                path_basename(request->surface));
  for (int64_t c = 0; c < 3 * work->mesh.vertex_count; c++)
    work->mesh.vertices[c] *= request->scale;
  return THRUM_OK;
}

static thrum_status fill_surface(const mesh_request *request, mesh_work *work,
                                 config_progress *progress, thrum_error *error) {
  THRUM_TRY(read_surface(request, work, progress, error));
  THRUM_TRY(run_tool(request, work, progress, error));
  return request->order == 2 ? thrum_midsides_add(&work->mesh, error) : THRUM_OK;
}

static thrum_status make_mesh(const mesh_request *request, mesh_work *work,
                              config_progress *progress, thrum_error *error) {
  const thrum_mesh_write_options options = {0};
  thrum_mesh_lost lost = {0};
  THRUM_TRY(path_check_output(request->output, error));
  const bool geometry = mesh_tool_is_geometry(request->surface);
  if (geometry)
    THRUM_TRY(mesh_geometry(request, work, progress, error));
  else if (request->thickness > 0)
    THRUM_TRY(make_sheet(request, work, progress, error));
  else
    THRUM_TRY(fill_surface(request, work, progress, error));

  // the mesh is examined before it is written, and written even if it has defects
  config_progress_update(progress, "looking at the mesh", 0);
  THRUM_TRY(thrum_mesh_examine(&work->mesh, &work->examined, error));
  config_progress_end(progress, true);
  work->flags = thrum_mesh_flags(&work->mesh, &work->examined);
  // a surface's unit is asked for by itself
  work->flags &= ~(unsigned)THRUM_EXAMINE_UNITS;
  if (!geometry && !(request->thickness > 0))
    warn_volume(request, work);
  if (!geometry)
    warn_unit(request, work);
  config_progress_update(progress, "writing", 0);
  return thrum_mesh_write(request->output, &work->mesh, &options, &lost, error);
}

int cmd_mesh(int argc, char **argv) {
  mesh_request request = {.scale = 1, .tool = MESH_TOOL_NONE, .side = -1};
  CONFIG_TRY(read_options(argc, argv, &request));

  // a mesh with defects is written and flagged
  thrum_error error = {0};
  mesh_work work = {.tool = MESH_TOOL_NONE};
  config_progress progress = config_progress_make(request.quiet);
  const thrum_status status = make_mesh(&request, &work, &progress, &error);
  config_progress_end(&progress, status >= 0);
  const bool flagged = work.flags != 0 || work.other_volume;
  if (status >= 0)
    print_results(&request, &work);

  thrum_surface_mesh_free(&work.surface);
  thrum_mesh_free(&work.mesh);
  return config_end(status, flagged, &error);
}
