/* `thrum export`: what a model holds, in the formats of other programs.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/export/array_code.h"
#include "driver/export/body_header.h"
#include "driver/export/fmu_write.h"
#include "driver/export/glb.h"
#include "driver/export/nlvib.h"
#include "driver/export/vertex_cache.h"
#include "driver/make/named_model.h"
#include "driver/record/run_entries.h"
#include "driver/scene/scene_read.h"
#include "driver/spec/actuate_spec.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/paths.h"
#include "platform/interrupt.h"
#include "precompute/fem/matrix_market.h"
#include "precompute/model/model_fem.h"
#include "precompute/vega_reduced.h"

#define FILES_MAX 15
#define FPS_DEFAULT 60

typedef struct export_request {
  const char *model;     /* or the folder of a run */
  const char *run_model; /* the run's model, in place of what run.json says */
  const char *glb, *pc2, *mdd, *obj;
  const char *surface; /* shown in place of the skin */
  double fps;
  const char *vega_basis, *vega_cubic, *matrices;
  const char *numpy, *torch, *jax;
  const char *header;
  const char *fmu;
  const char *nlvib;
  damping_spec damping; /* in that */
  bool fmi3, fmi_given;
  fmu_target targets[FMU_TARGETS_MAX];
  int64_t target_count;
  bool single, json;
} export_request;

/* The files that have been written. */
typedef struct export_files {
  int count;
  char path[FILES_MAX][4200]; /* longer ones the system refuses */
  const char *what[FILES_MAX];
} export_files;

#define AT(member) CONFIG_AT(export_request, member)

static thrum_status take_target(const config_given *given, void *request) {
  export_request *r = request;
  thrum_error error = {0};
  if (r->target_count == FMU_TARGETS_MAX)
    return config_given_refuse(given, "there may be %d places, and no more", FMU_TARGETS_MAX);
  fmu_target *target = &r->targets[r->target_count];
  target->name = given->text;
  if (load_target_parse(given->text, "--at", &target->target, &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->target_count++;
  return THRUM_OK;
}

static thrum_status take_damping(const config_given *given, void *request) {
  return damping_spec_take_rayleigh(given, &((export_request *)request)->damping);
}

static thrum_status take_ratios(const config_given *given, void *request) {
  return damping_spec_take_ratios(given, &((export_request *)request)->damping);
}

static const char *const fmi_names[] = {"2", "3", NULL};

static const config_option options[] = {
    // what each kind of source can be written as
    OPTION_HEADING("of a run, or of the run of a scene"),
    OPTION_TEXT("glb", "FILE", NULL,
                "glTF 2.0: the surface with normals and colour, the coordinates as morph targets, "
                "the motion as their weights; of a scene all bodies, each in its place",
                AT(glb)),
    OPTION_NUMBER("fps", "1/s", "60", "rows of what moves, at most; 0: all that the run recorded",
                  AT(fps), CONFIG_FROM(0)),

    OPTION_HEADING("of a run"),
    OPTION_TEXT("pc2", "FILE", NULL, "a vertex cache of the surface that --obj writes", AT(pc2)),
    OPTION_TEXT("mdd", "FILE", NULL, "the same in another format", AT(mdd)),
    OPTION_TEXT("model", "FILE", NULL, "the run's model, where it lies elsewhere now",
                AT(run_model)),

    OPTION_HEADING("of a model or a run"),
    OPTION_TEXT("obj", "FILE", NULL, "the surface at rest, in metres", AT(obj)),
    OPTION_TEXT("surface", "FILE", NULL,
                "all of these show this surface in place of the mesh's own: a file of thrum embed, "
                "or an .obj or .stl in metres",
                AT(surface)),

    OPTION_HEADING("of a model"),
    OPTION_TEXT("vega-basis", "FILE.U", NULL, "the basis U as VegaFEM reads it", AT(vega_basis)),
    OPTION_FLAG("float", "U in single precision (.URendering.float)", AT(single)),
    OPTION_TEXT("vega-cubic", "FILE.cub", NULL, "the reduced forces as VegaFEM's cubic polynomials",
                AT(vega_cubic)),
    OPTION_TEXT("numpy", "FILE.py", NULL,
                "readable array code: energy, force, tangent and steps of any number of bodies at "
                "once, with its numbers in FILE_coefficients.npz",
                AT(numpy)),
    OPTION_TEXT("torch", "FILE.py", NULL, "the same for PyTorch, which derives it", AT(torch)),
    OPTION_TEXT("jax", "FILE.py", NULL, "the same for JAX", AT(jax)),
    OPTION_TEXT(
        "header", "FILE.h", NULL,
        "C for controllers, without heap: energy, force, tangent and steps, and the numbers "
        "of the model as constants",
        AT(header)),
    OPTION_TEXT(
        "fmu", "FILE.fmu", NULL,
        "a Functional Mock-up Unit for co-simulation and model exchange, with forces in and "
        "displacements out",
        AT(fmu)),
    OPTION_CHOICE("fmi", fmi_names, "2", "the version of FMI that the unit is of", AT(fmi3),
                  .given = offsetof(export_request, fmi_given)),
    OPTION_TEXT("at", "TARGET", "each group that moves",
                "where forces act on the unit, and displacements are told; of --nlvib the rows "
                "of T, none by default",
                .repeats = true, .take = take_target),
    OPTION_TEXT("nlvib", "FILE.mat", NULL,
                "mass, damping, stiffness, exponents and coefficients, M, D, K, p and E, as NLvib "
                "and other programs of MATLAB and Octave read them",
                AT(nlvib)),
    OPTION_DAMPING(.take = take_damping),
    OPTION_DAMPING_RATIO(take_ratios),
    OPTION_TEXT("matrices", "PREFIX", NULL,
                "stiffness [N/m] and mass [kg] of the free components as Matrix Market, "
                "PREFIX.K.mtx and PREFIX.M.mtx, and in PREFIX.rows.txt the vertex and axis of "
                "each row",
                AT(matrices)),
    OPTION_JSON(export_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_export = {
    .name = "export",
    .summary = "write a model in the formats of other programs",
    .usage = "MODEL WHAT... [OPTIONS]",
    .about =
        "Writes what a model or a run holds in the formats of other programs. MODEL is a model "
        "file, the name of a model that comes with Thrum, or the folder of a run: of one body, of "
        "a scene, or of a body in the run of a scene, which is shown where the body is.",
    .options = options,
    .notes = "thrum precompute --import-basis takes U and the forces back; its --export-modes "
             "writes\nthe linear modes.\n",
    .examples = "export run --glb run.glb\n"
                "export fallen --glb fallen.glb\n"
                "export run --obj beam.obj --pc2 beam.pc2 --fps 25\n"
                "export run --surface shown.npz --glb run.glb\n"
                "export beam.npz --vega-basis beam.U --vega-cubic beam.cub\n"
                "export beam.npz --vega-basis beam.URendering.float --float\n"
                "export beam.npz --numpy beam_arrays.py\n"
                "export beam.npz --header beam.h\n"
                "export beam.npz --nlvib beam.mat --damping-ratio 0.002 --at tip\n"
                "export beam.npz --fmu beam.fmu --fmi 3 --at tip --at near:0.5,0,0\n"
                "export bridge --matrices bridge",
};

/* Refuses files that would overwrite an input or each other. */
static int check_files(const export_request *request) {
  const struct {
    const char *option, *path;
  } files[] = {{"--glb", request->glb},
               {"--pc2", request->pc2},
               {"--mdd", request->mdd},
               {"--obj", request->obj},
               {"--vega-basis", request->vega_basis},
               {"--vega-cubic", request->vega_cubic},
               {"--numpy", request->numpy},
               {"--torch", request->torch},
               {"--jax", request->jax},
               {"--header", request->header},
               {"--fmu", request->fmu},
               {"--nlvib", request->nlvib}};

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

/* Refuses a name that says another form than the binary one of glTF, which --glb writes. */
static int check_form(const export_request *request) {
  static const char *const others[] = {".usd", ".usda", ".usdc", ".usdz", ".abc",
                                       ".fbx", ".dae",  ".obj",  ".stl",  ".ply"};
  const char *dot = request->glb ? strrchr(request->glb, '.') : NULL;
  bool other = dot != NULL && strcasecmp(dot, ".gltf") == 0;
  for (size_t n = 0; n < sizeof others / sizeof others[0] && dot != NULL; n++)
    other = other || strcasecmp(dot, others[n]) == 0;
  if (!other)
    return COMMAND_DONE;
  return config_usage("export",
                      "--glb writes the binary form of glTF: give '%s' a name that ends "
                      "with .glb",
                      request->glb);
}

/* Refuses options that ask for a format which is not written, with what makes it. */
static int check_formats(int argc, char **argv) {
  static const char *const names[] = {"--usd", "--usda", "--usdc", "--usdz", "--abc", "--alembic"};
  for (int a = 1; a < argc; a++)
    for (size_t n = 0; n < sizeof names / sizeof names[0]; n++)
      if (strncmp(argv[a], names[n], strlen(names[n])) == 0 &&
          strchr("=", argv[a][strlen(names[n])]) != NULL)
        return config_usage("export",
                            "there is no %s: USD and Alembic are not written; write --glb, of "
                            "which Blender makes both (docs/exchange.md says why)",
                            names[n]);
  return COMMAND_DONE;
}

/* Refuses what has no motion: a name of what is there is a mistake of the command line. */
static int refuse_still(const char *name) {
  model_recipe recipe = {0};
  thrum_error error = {0};
  const bool named = model_recipe_find(name, &recipe, NULL) >= 0 && recipe.found;
  if (named || access(name, F_OK) == 0)
    return config_usage("export",
                        "--glb, --pc2 and --mdd are of a run: name its folder; '%s' is none", name);
  thrum_error_set(&error, THRUM_MISSING,
                  "%.250s: no such folder: name the one of a run that thrum simulate wrote", name);
  return config_refuse(&error);
}

static int read_options(int argc, char **argv, export_request *request) {
  CONFIG_TRY(check_formats(argc, argv));
  CONFIG_TRY(
      config_options_read_one(&command_export, "model", argc, argv, request, &request->model));

  // what is written decides what must be read
  const bool motion = request->glb || request->pc2 || request->mdd;
  const bool of_model = request->vega_basis || request->vega_cubic || request->matrices ||
                        request->numpy || request->torch || request->jax || request->header ||
                        request->fmu || request->nlvib;
  if (!motion && !of_model && !request->obj)
    return config_usage("export",
                        "say what to write: --glb, --pc2, --mdd, --obj, --vega-basis, "
                        "--vega-cubic, --numpy, --torch, --jax, --header, --fmu, --nlvib or "
                        "--matrices");
  CONFIG_TRY(check_form(request));

  // the bodies of a scene have surfaces and models of their own
  if (is_scene_folder(request->model)) {
    if (request->pc2 || request->mdd || request->obj || of_model || request->surface ||
        request->run_model || request->single)
      return config_usage(
          "export",
          "'%s' is the run of a scene, which leaves by --glb alone: name the folder "
          "of one of its bodies, %s/NAME",
          request->model, request->model);
    char mark[4200];
    snprintf(mark, sizeof mark, "%s/%s", request->model, SCENE_JSON);
    if (path_same_file(request->glb, mark))
      return config_usage("export", "%s belongs to the run: write to another file", request->glb);
    return check_files(request);
  }

  thrum_error error = {0};
  if (recorded_folder_check(request->model, ", or a model file", &error) < 0)
    return config_refuse(&error);

  // the folder of a run for motion, a model for what belongs to a model
  const bool is_run = is_run_folder(request->model);
  if (motion && !is_run)
    return refuse_still(request->model);
  if (of_model && is_run)
    return config_usage("export",
                        "--vega-basis, --vega-cubic, --numpy, --torch, --jax, --header, --fmu, "
                        "--nlvib and --matrices are of a model: name its file, not '%s'",
                        request->model);

  if (!is_run && request->run_model)
    return config_usage("export", "--model goes with the folder of a run");
  if (request->surface && !motion && !request->obj)
    return config_usage("export", "--surface goes with --glb, --pc2, --mdd or --obj");
  if (request->single && !request->vega_basis)
    return config_usage("export", "--float goes with --vega-basis");
  if ((request->fmi_given && !request->fmu) ||
      (request->target_count > 0 && !request->fmu && !request->nlvib))
    return config_usage("export", "--fmi and --at go with --fmu, --at with --nlvib too");
  if (damping_spec_given(&request->damping) && !request->nlvib)
    return config_usage("export", "--damping and --damping-ratio go with --nlvib");
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
  // the body behind the model, with its matrices
  thrum_model_fem body = {0};
  thrum_status status = thrum_model_fem_create(model, &body, error);

  // each matrix, and which row is which component
  THRUM_THEN(status,
             thrum_matrix_market_write(note(files, "stiffness", prefix, ".K.mtx"), &body.stiffness,
                                       "stiffness at rest of the free components [N/m]", error));
  THRUM_THEN(status, thrum_matrix_market_write(note(files, "mass", prefix, ".M.mtx"), &body.mass,
                                               body.kind == THRUM_MASS_LUMPED
                                                   ? "lumped mass of the free components [kg]"
                                                   : "consistent mass of the free components [kg]",
                                               error));
  THRUM_THEN(status, thrum_rows_write(note(files, "rows", prefix, ".rows.txt"), &body.fem, error));

  thrum_model_fem_free(&body);
  return status;
}

/* The code for each array library that is asked for, with its coefficients. */
static thrum_status write_arrays(const export_request *request, const thrum_model *model,
                                 export_files *files, thrum_error *error) {
  const struct {
    const char *path, *what;
    array_library library;
  } codes[] = {{request->numpy, "numpy", ARRAY_NUMPY},
               {request->torch, "torch", ARRAY_TORCH},
               {request->jax, "jax", ARRAY_JAX}};
  thrum_status status = THRUM_OK;
  for (size_t n = 0; n < sizeof codes / sizeof *codes && status >= 0; n++) {
    char coefficients[4200];
    if (codes[n].path == NULL)
      continue;
    status = array_code_write(codes[n].path, codes[n].library, model, error);
    THRUM_THEN(status,
               array_code_coefficients(codes[n].path, coefficients, sizeof coefficients, error));
    if (status >= 0) {
      note(files, codes[n].what, codes[n].path, "");
      note(files, "coefficients", coefficients, "");
    }
  }
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
  if (status >= 0)
    status = write_arrays(request, model, files, error);
  if (status >= 0 && request->header)
    status = body_header_write(note(files, "header", request->header, ""), model, error);
  if (status >= 0 && request->fmu)
    status = fmu_write(note(files, "fmu", request->fmu, ""), request->fmi3 ? 3 : 2, model,
                       request->targets, request->target_count, error);
  if (status >= 0 && request->nlvib)
    status = nlvib_write(note(files, "nlvib", request->nlvib, ""), model, &request->damping,
                         request->targets, request->target_count, error);
  if (status >= 0 && request->matrices)
    status = write_matrices(model, request->matrices, files, error);
  return status;
}

/* Refuses to write over what the run in `folder` was read from. */
static thrum_status spare_run(const export_request *request, const char *folder,
                              const recorded_run *run, thrum_error *error) {
  const char *const paths[] = {request->glb, request->pc2, request->mdd, request->obj};
  for (size_t n = 0; n < sizeof paths / sizeof *paths; n++)
    if (paths[n] != NULL && recorded_run_holds(folder, run, paths[n]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s belongs to the run or is its model: write to another file",
                             paths[n]);
  return THRUM_OK;
}

/* The motion and the surface of a run, or the surface of a model alone. */
static thrum_status write_surface(const export_request *request, const recorded_run *run,
                                  export_files *files, thrum_error *error) {
  render_mesh shown = {0};
  thrum_status status = render_mesh_make(run->model, request->surface, &shown, error);
  if (status >= 0 && request->glb)
    status = glb_write(note(files, "glb", request->glb, ""),
                       &(glb_body){.run = run, .shown = &shown}, 1, error);
  if (status >= 0 && request->pc2)
    status = pc2_write(note(files, "pc2", request->pc2, ""), run, &shown, error);
  if (status >= 0 && request->mdd)
    status = mdd_write(note(files, "mdd", request->mdd, ""), run, &shown, error);
  if (status >= 0 && request->obj)
    status = obj_write(note(files, "obj", request->obj, ""), &run->place, &shown, error);
  render_mesh_free(&shown);
  return status;
}

static thrum_status export_run(const export_request *request, export_files *files,
                               thrum_error *error) {
  recorded_run run = {0};
  THRUM_TRY(recorded_run_read(request->model, request->run_model, &run, error));
  recorded_run_thin(&run, request->fps);
  thrum_status status = spare_run(request, request->model, &run, error);
  THRUM_THEN(status, write_surface(request, &run, files, error));
  recorded_run_free(&run);
  return status;
}

/* A file that is stepped elsewhere has the body without its actuators, which is said; a gas would
 * be missing at any level, so it is refused. */
static thrum_status look_at_actuators(const export_request *request, const thrum_model *model,
                                      thrum_error *error) {
  const bool steps = request->vega_cubic || request->numpy || request->torch || request->jax ||
                     request->header || request->fmu || request->nlvib;
  if (!steps || thrum_model_actuators(model) == 0)
    return THRUM_OK;
  THRUM_TRY(actuate_specs_no_gas(model, "the file", error));
  config_warn("the actuators of the model are left out: the file has the passive body");
  return THRUM_OK;
}

static thrum_status export_model(const export_request *request, export_files *files,
                                 thrum_error *error) {
  recorded_run still = {0};
  THRUM_TRY(named_model_load(request->model, false, &still.model, NULL, error));
  thrum_status status = look_at_actuators(request, still.model, error);
  THRUM_THEN(status, write_all(request, still.model, files, error));
  if (status >= 0 && request->obj)
    status = write_surface(request, &still, files, error);
  recorded_run_free(&still);
  return status;
}

/* All bodies of a scene in one file. */
static thrum_status export_scene(const export_request *request, export_files *files,
                                 thrum_error *error) {
  recorded_scene scene = {0};
  THRUM_TRY(recorded_scene_read(request->model, &scene, error));
  render_mesh *shown = NULL;
  glb_body *bodies = NULL;
  thrum_status status = thrum_reserve(&shown, scene.count, sizeof *shown, "the scene", error);
  THRUM_THEN(status, thrum_reserve(&bodies, scene.count, sizeof *bodies, "the scene", error));

  // each body by the surface of its own mesh
  for (int64_t n = 0; n < scene.count && status >= 0; n++) {
    char body[4200];
    snprintf(body, sizeof body, "%s/%s", request->model, scene.names[n]);
    status = spare_run(request, body, &scene.runs[n], error);
    recorded_run_thin(&scene.runs[n], request->fps);
    THRUM_THEN(status, render_mesh_make(scene.runs[n].model, NULL, &shown[n], error));
    bodies[n] = (glb_body){.name = scene.names[n], .run = &scene.runs[n], .shown = &shown[n]};
  }
  THRUM_THEN(status, glb_write(note(files, "glb", request->glb, ""), bodies, scene.count, error));

  for (int64_t n = 0; n < scene.count && shown != NULL; n++)
    render_mesh_free(&shown[n]);
  free(shown);
  free(bodies);
  recorded_scene_free(&scene);
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
  CONFIG_TRY(read_options(argc, argv, &request));

  thrum_error error = {0};
  export_files files = {0};
  // what is exported goes by what the path names: a scene's run, a run or a model
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");
  const thrum_status status =
      is_scene_folder(request.model) ? export_scene(&request, &files, &error)
      : is_run_folder(request.model) ? export_run(&request, &files, &error)
                                     : export_model(&request, &files, &error);
  if (status < 0)
    return config_refuse(&error);
  print_files(&request, &files);
  return COMMAND_DONE;
}
