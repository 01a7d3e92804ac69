/* `thrum check`: what a mesh is like and what may be wrong with it. The work is done in
 * precompute/; here it is asked for and shown. SPDX-License-Identifier: Apache-2.0 */

#include "app/check_report.h"
#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/shared_options.h"
#include "io/json.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_flags.h"

typedef struct check_request {
  const char *mesh_name;
  thrum_mesh_read_options reading;
  bool json;
} check_request;

static const config_option options[] = {
    OPTION_GROUP(mesh_read_rows, "", CONFIG_AT(check_request, reading)),
    OPTION_JSON(check_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_check = {
    .name = "check",
    .summary = "say what a mesh is like, and what may be wrong with it",
    .usage = "MESH [OPTIONS]",
    .about =
        "Reads a tetrahedral mesh (.veg, .msh, .node, .ele, .mesh, .vtk, .vtu, .inp, or a "
        "generator such as beam:20x3x3@1x0.15x0.15) and says what it is like: size, volume, mass, "
        "pieces, surface, shape of its tetrahedra, groups, regions. What may be wrong is flagged, "
        "with what to do: pieces that nothing joins, vertices on top of each other, hinges, "
        "likely mistakes of units, coordinates far from the origin, locking, slivers.",
    .options = options,
    .examples = "check bracket.msh\n"
                "check bracket.inp --unit mm-t-s --json",
    .exits = "0 nothing to flag, 1 refused, 2 usage, 3 something is flagged",
};

static int read_options(int argc, char **argv, check_request *request) {
  const int code = config_options_read(&command_check, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  return config_one_argument("check", "mesh", argc, argv, &request->mesh_name);
}

int cmd_check(int argc, char **argv) {
  check_request request = {.reading = {.scale = 1}};
  const int code = read_options(argc, argv, &request);
  if (code != COMMAND_DONE)
    return code;

  // refused: the mesh cannot be read; flagged: it can, but has defects
  thrum_error error = {0};
  thrum_mesh mesh = {0};
  thrum_mesh_examined examined;
  thrum_status status = thrum_mesh_read_with(request.mesh_name, &request.reading, &mesh, &error);
  THRUM_THEN(status, thrum_mesh_examine(&mesh, &examined, &error));

  unsigned flags = 0;
  if (status >= 0) {
    flags = thrum_mesh_flags(&mesh, &examined);
    if (request.json)
      json_print(check_report_object(request.mesh_name, &mesh, &examined, flags));
    else
      check_report_print(request.mesh_name, &mesh, &examined, flags);
  }

  thrum_mesh_free(&mesh);
  if (status < 0)
    return config_refuse(&error);
  return flags != 0 ? COMMAND_FLAGGED : COMMAND_DONE;
}
