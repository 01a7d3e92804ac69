/* `thrum convert`: from one mesh format to another. The work is done in mesh/formats/; here it
 * is asked for, and what the format cannot hold is said. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/make/element_order.h"
#include "driver/model/mesh_warnings.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

typedef struct convert_request {
  const char *input, *output;
  thrum_mesh_read_options reading;
  thrum_mesh_write_options options;
  bool json;
} convert_request;

static thrum_status take_msh(const config_given *given, void *request) {
  const bool old = strcmp(given->text, "2.2") == 0;
  if (!old && strcmp(given->text, "4.1") != 0)
    return config_given_wrong(given);
  ((convert_request *)request)->options.msh_version = old ? 22 : 41;
  return THRUM_OK;
}

#define AT(member) CONFIG_AT(convert_request, member)

static const char *const msh_versions[] = {"2.2", "4.1", NULL};
static const config_option options[] = {
    OPTION_GROUP(mesh_read_rows, "", AT(reading)),
    OPTION_FLAG("binary", ".msh, .vtk: numbers as bytes, not as text", AT(options.binary)),
    OPTION_FLAG("ascii", ".vtu: numbers as text, not as bytes", AT(options.ascii)),
    OPTION_CHOICE("msh", msh_versions, "4.1", "version of a .msh", .value = "VERSION",
                  .take = take_msh),
    OPTION_JSON(convert_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_convert = {
    .name = "convert",
    .summary = "from one mesh format to another",
    .usage = "IN OUT [OPTIONS]",
    .about =
        "Reads a mesh and writes it in the format that the suffix of OUT names: .veg "
        "(Vega), .msh (Gmsh), .node or .ele (TetGen, both files), .mesh (Medit), .vtk and .vtu "
        "(VTK), .inp (Abaqus). IN is one of these too, or a generator such as "
        "beam:20x3x3@1x0.15x0.15. Vertices keep all their bits; groups, regions and materials are "
        "carried as far as OUT can hold them, and what it cannot is counted in a warning. "
        "Hexahedra "
        "and wedges stay what they are; .veg, .node and .ele have tetrahedra alone, and get those "
        "that they are cut into.",
    .options = options,
    .examples = "convert bracket.inp bracket.vtu\n"
                "convert part.node part.msh --msh 2.2 --binary --scale 0.001",
};

static int read_options(int argc, char **argv, convert_request *request) {
  CONFIG_TRY(config_options_read(&command_convert, argc, argv, request));
  if (argc - optind != 2)
    return config_usage("convert", "give the mesh to read and the mesh to write, IN OUT");
  request->input = argv[optind];
  request->output = argv[optind + 1];
  if (request->options.binary && request->options.ascii)
    return config_usage("convert", "--binary and --ascii exclude each other");
  return COMMAND_DONE;
}

static void warn_lost(const thrum_mesh_lost *lost, const char *name) {
  // the counts are of what was in the mesh that was read
  if (lost->groups > 0)
    config_warn("%s: %" PRId64 " %s no place in this format and %s left out", name, lost->groups,
                lost->groups == 1 ? "group has" : "groups have",
                lost->groups == 1 ? "was" : "were");
  if (lost->names > 0)
    config_warn("%s: %" PRId64 " %s there under another name or a number", name, lost->names,
                lost->names == 1 ? "group is" : "groups are");

  if (lost->materials > 0)
    config_warn("%s: %" PRId64 " %s no place in this format and %s left out", name, lost->materials,
                lost->materials == 1 ? "material has" : "materials have",
                lost->materials == 1 ? "was" : "were");
  if (lost->regions > 0)
    config_warn("%s: %" PRId64 " %s there as %s only", name, lost->regions,
                lost->regions == 1 ? "region without material is" : "regions without materials are",
                lost->regions == 1 ? "a group" : "groups");
  if (lost->directed > 0)
    config_warn("%s: directions of %" PRId64 " %s no place in this format: the isotropic mean is "
                "there",
                name, lost->directed, lost->directed == 1 ? "material have" : "materials have");
}

static void print_json(const convert_request *request, const thrum_mesh *mesh,
                       const thrum_mesh_lost *lost) {
  // the mesh that was written
  cJSON *object = cJSON_CreateObject();
  int64_t counts[THRUM_FORMS];
  thrum_mesh_count_forms(mesh, counts);
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "mesh", request->output);
  json_number(object, "vertices", (double)mesh->vertex_count);
  json_number(object, "tets", (double)(counts[THRUM_FORM_TET4] + counts[THRUM_FORM_TET10]));
  element_solids_json(object, mesh);
  json_number(object, "order", mesh->midsides ? 2 : 1);
  json_number(object, "regions", (double)mesh->region_count);
  json_number(object, "groups", (double)mesh->group_count);

  // what reading has changed, and what the format could not hold
  json_number(object, "flipped_tets", (double)mesh->flipped_tets);
  json_number(object, "dropped_vertices", (double)mesh->dropped_vertices);
  json_number(object, "cornered_tets", (double)mesh->cornered_tets);
  mesh_notes_object(object, mesh);
  json_number(object, "lost_groups", (double)lost->groups);
  json_number(object, "lost_names", (double)lost->names);
  json_number(object, "lost_materials", (double)lost->materials);
  json_number(object, "lost_regions", (double)lost->regions);
  json_number(object, "lost_directions", (double)lost->directed);
  json_print(object);
}

/* "480 tetrahedra", or how many solids there are of each form. */
static thrum_solid_words elements_in_words(const thrum_mesh *mesh) {
  thrum_solid_words words;
  if (mesh->solid_count > 0)
    return thrum_solid_count_words(mesh->solid_form, mesh->solid_count);
  snprintf(words.text, sizeof words.text, "%" PRId64 " tetrahedra", mesh->tet_count);
  return words;
}

static int convert(const convert_request *request) {
  thrum_error error = {0};
  thrum_mesh mesh = {0};
  thrum_mesh_lost lost = {0};
  thrum_mesh_read_options reading = request->reading;
  if (reading.element == THRUM_ELEMENT_SHELL)
    return config_usage("convert", "no format tells solid-shells: leave --element out");

  // elements stay what they are, as far as the format has them
  if (reading.element == THRUM_ELEMENT_AUTO)
    reading.element = thrum_mesh_write_takes(request->output, THRUM_FORM_HEX8) ? THRUM_ELEMENT_FILE
                                                                               : THRUM_ELEMENT_TET;
  thrum_status status = thrum_mesh_read_with(request->input, &reading, &mesh, &error);
  if (status < 0)
    return config_refuse(&error);

  mesh_warnings_print(&mesh, path_basename(request->input),
                      strncmp(request->input, "beam:", 5) == 0 ? NULL : &request->reading);

  // what the format cannot hold is a warning and no failure
  status = thrum_mesh_write(request->output, &mesh, &request->options, &lost, &error);
  if (status >= 0) {
    warn_lost(&lost, path_basename(request->output));
    if (request->json)
      print_json(request, &mesh, &lost);
    else
      printf("%s: %" PRId64 " vertices, %s, %" PRId64 " group%s, %" PRId64 " region%s\n",
             request->output, mesh.vertex_count, elements_in_words(&mesh).text, mesh.group_count,
             mesh.group_count == 1 ? "" : "s", mesh.region_count,
             mesh.region_count == 1 ? "" : "s");
  }

  thrum_mesh_free(&mesh);
  return status < 0 ? config_refuse(&error) : COMMAND_DONE;
}

int cmd_convert(int argc, char **argv) {
  convert_request request = {.reading = {.scale = 1}};
  CONFIG_TRY(read_options(argc, argv, &request));
  return convert(&request);
}
