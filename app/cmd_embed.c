/* `thrum embed`: a fine surface bound to the mesh of a model, to be shown in its place. The work is
 * done in precompute/; here it is asked for and reported. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/embedded_surface.h"
#include "driver/named_model.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/interrupt.h"

typedef struct embed_request {
  const char *model, *surface, *output;
  double scale;
  bool json, quiet;
} embed_request;

static void print_help(void) {
  fputs(
      "usage: thrum embed MODEL SURFACE -o FILE.npz [OPTIONS]\n\n"
      "Binds a fine triangle surface (.obj, .stl) to the tetrahedra of a model, so that it is\n"
      "shown in place of the mesh: each vertex follows the tetrahedron that it lies in, or else\n"
      "the nearest. MODEL is a model file with a mesh, or the name of a model that comes with\n"
      "Thrum. FILE.npz holds the surface and its rows of the basis; programs load it with\n"
      "thrum_surface_load, `thrum export --surface` shows it.\n\n"
      "  -o, --output FILE  the surface file to write\n"
      "      --scale S      multiply the surface's lengths by S, such as 0.01 for centimetres (1)\n"
      "      --json         print one JSON object instead of the table\n"
      "  -q, --quiet        no progress\n"
      "  -h, --help         this text\n\n"
      "examples:\n"
      "  thrum embed bridge.npz bridge.obj -o bridge_shown.npz\n"
      "  thrum embed horse statue.stl --scale 0.001 -o statue.npz --json\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 done, but a vertex lies farther outside the\n"
      "mesh than a tenth of its length\n",
      stdout);
}

#define FIELD(member) .field = offsetof(embed_request, member)

static const config_option table[] = {
    {.name = "output", .letter = 'o', .kind = CONFIG_TEXT, FIELD(output)},
    {.name = "scale", .kind = CONFIG_NUMBER, FIELD(scale), .most = INFINITY, .above = true},
    CONFIG_OPTION_JSON(embed_request),
    CONFIG_OPTION_QUIET(embed_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

static int read_options(int argc, char **argv, embed_request *request) {
  const int code = config_options_read("embed", table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
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

static void print_table(const embed_request *request, const thrum_embed *embed) {
  const thrum_embedding *e = &embed->embedding;
  const thrum_embed_report *report = &embed->report;
  printf("%-18s%s\n%-18s%" PRId64 " vertices, %" PRId64 " triangles, rank %" PRId64 "\n", "surface",
         request->output, "size", e->vertex_count, e->triangle_count, e->rank);
  printf("%-18s%" PRId64 " vertices", "outside the mesh", report->outside);
  if (report->outside > 0)
    printf(", up to %.3g m (vertex %" PRId64 ")", report->distance_max, report->farthest + 1);
  printf("\n%-18s%.3g\n", "largest weight", report->weight_max);
}

static void print_json(const embed_request *request, const thrum_embed *embed, bool far) {
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
  json_print(object);
}

int cmd_embed(int argc, char **argv) {
  embed_request request = {.scale = 1};
  const int code = read_options(argc, argv, &request);
  if (code != COMMAND_DONE)
    return code;

  thrum_error error = {0};
  thrum_embed embed = {0};
  const thrum_model *model = NULL;
  bool far = false;

  // the output is checked before the long work
  thrum_status status = path_check_output(request.output, &error);
  if (status >= 0)
    status = cli_model_load(request.model, request.quiet, &model, NULL, &error);
  if (status >= 0)
    status = cli_embed(model, request.model, request.surface, request.scale, request.quiet, &embed,
                       &error);
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");

  if (status >= 0)
    status = thrum_embed_save(request.output, &embed.embedding, &error);
  if (status >= 0) {
    far = cli_warn_embedded(&embed.report, request.surface);
    if (request.json)
      print_json(&request, &embed, far);
    else
      print_table(&request, &embed);
  }

  thrum_embed_free(&embed);
  thrum_model_free(model);
  if (status < 0)
    return config_refuse(&error);
  return far ? COMMAND_FLAGGED : COMMAND_DONE;
}
