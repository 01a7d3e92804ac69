/* `thrum check`: what a mesh is like and what may be wrong with it. The work is done in
 * precompute/; here it is asked for and shown. SPDX-License-Identifier: Apache-2.0 */

#include "app/check_report.h"
#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/make/named_model.h"
#include "driver/spec/shared_options.h"
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
        "Reads a tetrahedral mesh (.veg, .msh, .node, .ele, .mesh, .vtk, .vtu, .inp, a generator "
        "such as beam:20x3x3@1x0.15x0.15, or the name of a model that comes with Thrum) and says "
        "what it is like: size, volume, mass, "
        "pieces, surface, shape of its tetrahedra, groups, regions. What may be wrong is flagged, "
        "with what to do: pieces that nothing joins, vertices on top of each other, hinges, "
        "likely mistakes of units, coordinates far from the origin, locking, slivers.",
    .options = options,
    .examples = "check bracket.msh\n"
                "check horse\n"
                "check bracket.inp --unit mm-t-s --json",
    .exits = "0 nothing to flag, 1 refused, 2 usage, 3 something is flagged",
};

/* Reads the mesh; the name of one of our models stands for its mesh, its order and its material. */
static thrum_status read_mesh(const check_request *request, thrum_mesh *mesh, thrum_error *error) {
  model_recipe recipe;
  thrum_mesh_read_options reading = request->reading;
  THRUM_TRY(model_recipe_find(request->mesh_name, &recipe, error));
  model_recipe_read(&recipe, &reading);
  THRUM_TRY(
      thrum_mesh_read_with(recipe.found ? recipe.mesh : request->mesh_name, &reading, mesh, error));
  THRUM_TRY(thrum_mesh_check_kept(request->mesh_name, &reading, mesh, error));
  for (int64_t m = 0; m < mesh->region_count && recipe.found; m++)
    mesh->materials[m] = recipe.material;
  mesh->has_material = mesh->has_material || recipe.found;
  return THRUM_OK;
}

int cmd_check(int argc, char **argv) {
  check_request request = {.reading = {.scale = 1}};
  CONFIG_TRY(
      config_options_read_one(&command_check, "mesh", argc, argv, &request, &request.mesh_name));

  // refused: the mesh cannot be read; flagged: it can, but has defects
  thrum_error error = {0};
  thrum_mesh mesh = {0};
  thrum_mesh_examined examined;
  thrum_status status = read_mesh(&request, &mesh, &error);
  THRUM_THEN(status, thrum_mesh_examine(&mesh, &examined, &error));

  unsigned flags = 0;
  if (status >= 0) {
    flags = thrum_mesh_flags(&mesh, &examined);
    if (thrum_mesh_unit_is_said(&request.reading))
      flags &= ~(unsigned)THRUM_EXAMINE_UNITS;
    check_report_show(check_report_object(request.mesh_name, &mesh, &examined, flags),
                      request.json);
  }

  thrum_mesh_free(&mesh);
  return config_end(status, flags != 0, &error);
}
