/* `thrum embed`: a fine surface bound to the mesh of a model, to be shown in its place. The work is
 * done in precompute/; here it is asked for and reported. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/export/embedded_surface.h"
#include "driver/make/named_model.h"
#include "io/json.h"
#include "io/paths.h"
#include "io/report.h"

typedef struct embed_request {
  const char *model, *surface, *output;
  double scale;
  bool json, quiet;
} embed_request;

#define AT(member) CONFIG_AT(embed_request, member)

static const config_option options[] = {
    OPTION_TEXT("output", "FILE.npz", NULL, "the surface file to write", .letter = 'o', AT(output)),
    OPTION_NUMBER("scale", NULL, "1",
                  "multiply the surface's lengths by this, such as 0.01 for centimetres", AT(scale),
                  CONFIG_ABOVE(0)),
    OPTION_JSON(embed_request),
    OPTION_QUIET(embed_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_embed = {
    .name = "embed",
    .summary = "bind a fine surface to a model, to be shown in its place",
    .usage = "MODEL SURFACE -o FILE.npz [OPTIONS]",
    .about =
        "Binds a fine triangle surface (.obj, .stl) to the tetrahedra of a model, so that it is "
        "shown in place of the mesh: each vertex follows the tetrahedron that it lies in, or else "
        "the nearest. MODEL is a model file with a mesh, or the name of a model that comes with "
        "Thrum. FILE.npz holds the surface and its rows of the basis; programs load it with "
        "thrum_surface_load, thrum export --surface shows it.",
    .options = options,
    .examples = "embed bridge.npz bridge.obj -o bridge_shown.npz\n"
                "embed horse statue.stl --scale 0.001 -o statue.npz --json",
    .exits = "0 done, 1 refused, 2 usage, 3 done, but a vertex lies farther outside the mesh than "
             "a tenth of its length",
};

static int read_options(int argc, char **argv, embed_request *request) {
  CONFIG_TRY(config_options_read(&command_embed, argc, argv, request));
  if (argc - optind != 2)
    return config_usage("embed", "give the model and the surface, MODEL SURFACE");
  request->model = argv[optind];
  request->surface = argv[optind + 1];
  if (request->output == NULL)
    return config_usage("embed", "say where to write the embedded surface: -o FILE.npz");
  if (path_same_file(request->output, request->model) ||
      path_same_file(request->output, request->surface))
    return config_usage("embed", "%s is what is read: write to another file", request->output);
  return COMMAND_DONE;
}

static const report_line lines[] = {
    REPORT_LINE("surface", "{surface}"),
    REPORT_LINE("size", "{vertices} vertices, {triangles} triangles, rank {rank}"),
    REPORT_LINE("outside the mesh",
                "{outside} vertices[, up to {outside_max_m:.3g} m (vertex {outside_vertex})]"),
    REPORT_LINE("largest weight", "{weight_max:.3g}"),
    {0}};

static cJSON *make_report(const embed_request *request, const thrum_embed *embed, bool far) {
  const thrum_embedding *e = &embed->embedding;
  const thrum_embed_report *report = &embed->report;
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", far ? "flagged" : "done");
  json_string(object, "surface", request->output);
  json_string(object, "model", request->model);

  json_number(object, "vertices", (double)e->vertex_count);
  json_number(object, "triangles", (double)e->triangle_count);
  json_number(object, "rank", (double)e->rank);

  // vertices are counted from 1
  json_number(object, "outside", (double)report->outside);
  json_number(object, "outside_max_m", report->distance_max);
  if (report->farthest >= 0)
    json_number(object, "outside_vertex", (double)(report->farthest + 1));
  json_number(object, "extent_m", report->extent);
  json_number(object, "weight_max", report->weight_max);
  return object;
}

int cmd_embed(int argc, char **argv) {
  embed_request request = {.scale = 1};
  CONFIG_TRY(read_options(argc, argv, &request));

  thrum_error error = {0};
  thrum_embed embed = {0};
  const thrum_model *model = NULL;
  bool far = false;

  // the output is checked before the long work
  thrum_status status = path_check_output(request.output, &error);
  THRUM_THEN(status, named_model_load(request.model, request.quiet, &model, NULL, &error));
  THRUM_THEN(status, embedded_surface_make(model, request.model, request.surface, request.scale,
                                           request.quiet, &embed, &error));

  THRUM_THEN(status, thrum_embed_save(request.output, &embed.embedding, &error));
  if (status >= 0) {
    far = embedded_surface_warn(&embed.report, request.surface);
    report_show(make_report(&request, &embed, far), NULL, request.json, REPORT_LABEL_WIDE, lines);
  }

  thrum_embed_free(&embed);
  thrum_model_destroy(model);
  return config_end(status, far, &error);
}
