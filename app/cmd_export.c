/* `thrum export`: what a model holds, in the formats of other programs. SPDX-License-Identifier:
 * Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/glb.h"
#include "driver/named_model.h"
#include "driver/scene_folder.h"
#include "driver/vertex_cache.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/interrupt.h"
#include "precompute/fem/matrix_market.h"
#include "precompute/model/model_fem.h"
#include "precompute/vega_reduced.h"

#define FILES_MAX 9
#define FPS_DEFAULT 60

typedef struct export_request {
  const char *model;     /* or the folder of a run */
  const char *run_model; /* the run's model, in place of what run.json says */
  const char *glb, *pc2, *mdd, *obj;
  const char *surface; /* shown in place of the skin */
  double fps;
  const char *vega_basis, *vega_cubic, *matrices;
  bool single, json;
} export_request;

/* What has been written. */
typedef struct export_files {
  int count;
  char path[FILES_MAX][4200]; /* longer ones the system refuses */
  const char *what[FILES_MAX];
} export_files;

static void print_help(void) {
  fputs(
      "usage: thrum export MODEL WHAT... [OPTIONS]\n\n"
      "Writes what a model or a run holds in the formats of other programs. MODEL is a model\n"
      "file, the name of a model that comes with Thrum, or the folder of a run, such as that of a\n"
      "body in the run of a scene, which is shown where the body is.\n\n"
      "of a run:\n"
      "      --glb FILE              glTF 2.0: the surface, the coordinates as morph targets, the\n"
      "                              motion as their weights\n"
      "      --pc2 FILE, --mdd FILE  vertex caches of the surface that --obj writes\n"
      "      --fps F                 rows of these, at most F a second (default 60; 0: all that\n"
      "                              the run recorded)\n"
      "      --model FILE            the run's model, where it lies elsewhere now\n\n"
      "of a model or a run:\n"
      "      --obj FILE              the surface at rest, in metres\n"
      "      --surface FILE          all of these show this surface in place of the mesh's own: a\n"
      "                              file of `thrum embed`, or an .obj or .stl in metres\n\n"
      "of a model:\n"
      "      --vega-basis FILE.U     the basis U as VegaFEM reads it\n"
      "      --float                 U in single precision (.URendering.float)\n"
      "      --vega-cubic FILE.cub   the reduced forces as VegaFEM's cubic polynomials\n"
      "      --matrices PREFIX       stiffness [N/m] and mass [kg] of the free components as\n"
      "                              Matrix Market, PREFIX.K.mtx and PREFIX.M.mtx, and in\n"
      "                              PREFIX.rows.txt the vertex and axis of each row\n"
      "      --json                  print one JSON object instead of the table\n"
      "  -h, --help                  this text\n\n"
      "`thrum precompute --import-basis` takes U and the forces back; its --export-modes writes\n"
      "the linear modes.\n\n"
      "examples:\n"
      "  thrum export run --glb run.glb\n"
      "  thrum export run --obj beam.obj --pc2 beam.pc2 --fps 25\n"
      "  thrum export run --surface shown.npz --glb run.glb\n"
      "  thrum export beam.npz --vega-basis beam.U --vega-cubic beam.cub\n"
      "  thrum export beam.npz --vega-basis beam.URendering.float --float\n"
      "  thrum export bridge --matrices bridge\n",
      stdout);
}

#define FIELD(member) .field = offsetof(export_request, member)

static const config_option table[] = {
    {.name = "glb", .kind = CONFIG_TEXT, FIELD(glb)},
    {.name = "pc2", .kind = CONFIG_TEXT, FIELD(pc2)},
    {.name = "mdd", .kind = CONFIG_TEXT, FIELD(mdd)},
    {.name = "obj", .kind = CONFIG_TEXT, FIELD(obj)},
    {.name = "surface", .kind = CONFIG_TEXT, FIELD(surface)},
    {.name = "fps", .kind = CONFIG_NUMBER, FIELD(fps), .most = INFINITY, .wants = "rows a second"},
    {.name = "model", .kind = CONFIG_TEXT, FIELD(run_model)},
    {.name = "vega-basis", .kind = CONFIG_TEXT, FIELD(vega_basis)},
    {.name = "float", .kind = CONFIG_FLAG, FIELD(single)},
    {.name = "vega-cubic", .kind = CONFIG_TEXT, FIELD(vega_cubic)},
    {.name = "matrices", .kind = CONFIG_TEXT, FIELD(matrices)},
    CONFIG_OPTION_JSON(export_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

/* What is written may take the place neither of what is read nor of each other. */
static int check_files(const export_request *request) {
  const struct {
    const char *option, *path;
  } files[] = {{"--glb", request->glb},
               {"--pc2", request->pc2},
               {"--mdd", request->mdd},
               {"--obj", request->obj},
               {"--vega-basis", request->vega_basis},
               {"--vega-cubic", request->vega_cubic}};

  // each file against the inputs and against those before it
  const int count = (int)(sizeof files / sizeof *files);
  for (int n = 0; n < count; n++) {
    const char *path = files[n].path;
    if (path == NULL)
      continue;
    if (request->surface && path_same_file(path, request->surface))
      return config_usage("export", "%s is the surface: write to another file", path);
    if (path_same_file(path, request->model))
      return config_usage("export", "%s is the model: write to another file", path);

    for (int m = 0; m < n; m++)
      if (files[m].path && path_same_file(path, files[m].path))
        return config_usage("export", "%s and %s name one file, %s", files[m].option,
                            files[n].option, path);
  }
  return COMMAND_DONE;
}

static int read_options(int argc, char **argv, export_request *request) {
  int code = config_options_read("export", table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  code = config_one_argument("export", "model", argc, argv, &request->model);
  if (code != COMMAND_DONE)
    return code;

  // what is written decides what must be read
  const bool motion = request->glb || request->pc2 || request->mdd;
  const bool of_model = request->vega_basis || request->vega_cubic || request->matrices;
  if (!motion && !of_model && !request->obj)
    return config_usage("export", "say what to write: --glb, --pc2, --mdd, --obj, --vega-basis, "
                                  "--vega-cubic or --matrices");

  // the folder of a run for motion, a model for what belongs to a model
  const bool is_run = cli_is_run(request->model);
  if (cli_run_folder_holds(request->model, CLI_SCENE_JSON))
    return config_usage("export",
                        "'%s' is the run of a scene: name the folder of one of its bodies, %s/NAME",
                        request->model, request->model);
  if (motion && !is_run)
    return config_usage("export", "--glb, --pc2 and --mdd are of a run: name its folder, not '%s'",
                        request->model);
  if (of_model && is_run)
    return config_usage("export",
                        "--vega-basis, --vega-cubic and --matrices are of a model: name its "
                        "file, not '%s'",
                        request->model);

  if (!is_run && request->run_model)
    return config_usage("export", "--model goes with the folder of a run");
  if (request->surface && !motion && !request->obj)
    return config_usage("export", "--surface goes with --glb, --pc2, --mdd or --obj");
  if (request->single && !request->vega_basis)
    return config_usage("export", "--float goes with --vega-basis");
  return check_files(request);
}

/* Notes a file; returns its path, PREFIX followed by SUFFIX. */
static const char *note(export_files *files, const char *what, const char *prefix,
                        const char *suffix) {
  char *path = files->path[files->count];
  snprintf(path, sizeof files->path[0], "%s%s", prefix, suffix);
  files->what[files->count++] = what;
  return path;
}

static thrum_status write_matrices(const thrum_model *model, const char *prefix,
                                   export_files *files, thrum_error *error) {
  thrum_model_fem body = {0};
  thrum_status status = thrum_model_fem_create(model, &body, error);
  if (status >= 0)
    status = thrum_matrix_market_write(note(files, "stiffness", prefix, ".K.mtx"), &body.stiffness,
                                       "stiffness at rest of the free components [N/m]", error);
  if (status >= 0)
    status = thrum_matrix_market_write(note(files, "mass", prefix, ".M.mtx"), &body.mass,
                                       body.kind == THRUM_MASS_LUMPED
                                           ? "lumped mass of the free components [kg]"
                                           : "consistent mass of the free components [kg]",
                                       error);
  if (status >= 0)
    status = thrum_rows_write(note(files, "rows", prefix, ".rows.txt"), &body.fem, error);
  thrum_model_fem_free(&body);
  return status;
}

static thrum_status write_all(const export_request *request, const thrum_model *model,
                              export_files *files, thrum_error *error) {
  thrum_status status = THRUM_OK;
  if (request->vega_basis)
    status = thrum_vega_basis_write(note(files, "basis", request->vega_basis, ""), model,
                                    request->single, error);
  if (status >= 0 && request->vega_cubic)
    status = thrum_vega_cubic_write(note(files, "cubic", request->vega_cubic, ""), model, error);
  if (status >= 0 && request->matrices)
    status = write_matrices(model, request->matrices, files, error);
  return status;
}

/* The motion and the surface of a run, or the surface of a model alone. */
static thrum_status write_surface(const export_request *request, const cli_run *run,
                                  export_files *files, thrum_error *error) {
  cli_shown shown = {0};
  thrum_status status = cli_shown_make(run->model, request->surface, &shown, error);
  if (status >= 0 && request->glb)
    status = cli_glb_write(note(files, "glb", request->glb, ""), run, &shown, error);
  if (status >= 0 && request->pc2)
    status = cli_pc2_write(note(files, "pc2", request->pc2, ""), run, &shown, error);
  if (status >= 0 && request->mdd)
    status = cli_mdd_write(note(files, "mdd", request->mdd, ""), run, &shown, error);
  if (status >= 0 && request->obj)
    status = cli_obj_write(note(files, "obj", request->obj, ""), &run->place, &shown, error);
  cli_shown_free(&shown);
  return status;
}

static thrum_status export_run(const export_request *request, export_files *files,
                               thrum_error *error) {
  cli_run run = {0};
  thrum_status status = cli_run_read(request->model, request->run_model, &run, error);
  if (status < 0)
    return status;
  cli_run_thin(&run, request->fps);
  status = write_surface(request, &run, files, error);
  cli_run_free(&run);
  return status;
}

static void print_files(const export_request *request, const export_files *files) {
  if (!request->json) {
    for (int n = 0; n < files->count; n++)
      printf("%-18s%s\n", files->what[n], files->path[n]);
    return;
  }
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "model", request->model);
  cJSON *list = cJSON_AddObjectToObject(object, "files");
  for (int n = 0; n < files->count; n++)
    json_string(list, files->what[n], files->path[n]);
  json_print(object);
}

int cmd_export(int argc, char **argv) {
  export_request request = {.fps = FPS_DEFAULT};
  const int code = read_options(argc, argv, &request);
  if (code != COMMAND_DONE)
    return code;

  thrum_error error = {0};
  export_files files = {0};
  cli_run still = {0};
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");

  // a run brings its model along
  const bool is_run = cli_is_run(request.model);
  thrum_status status = is_run ? export_run(&request, &files, &error)
                               : cli_model_load(request.model, false, &still.model, NULL, &error);
  if (status >= 0 && !is_run)
    status = write_all(&request, still.model, &files, &error);
  if (status >= 0 && !is_run && request.obj)
    status = write_surface(&request, &still, &files, &error);

  if (status >= 0)
    print_files(&request, &files);
  cli_run_free(&still);
  return status < 0 ? config_refuse(&error) : COMMAND_DONE;
}
