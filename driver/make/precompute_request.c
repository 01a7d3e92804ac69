/* Options of `thrum precompute`. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "config/message.h"
#include "config/options.h"
#include "driver/make/about.h"
#include "driver/make/precompute_request.h"
#include "driver/make/train_case.h"
#include "driver/model/mesh_of_model.h"
#include "driver/spec/region_material.h"
#include "driver/spec/shared_options.h"
#include "precompute/fem/quadrature.h"

#define COUNT_MAX 1000000 /* no mesh needs more modes; keeps products of counts in range */
#define MEGABYTES_MAX 1099511627776.0
#define TRAIN_STEPS_MOST 1e7 /* of the full order */

/* The most that a rank grows to, unless it is said. */
#define RANK_MAX 100
#define TOUCH_STEPPED_RANK_MAX 40 /* beyond it a step costs too much */

static thrum_status take_memory(const config_given *given, void *request) {
  int64_t megabytes = 0;
  THRUM_TRY(config_given_count(given, &megabytes));
  ((precompute_request *)request)->options.memory_limit = 1048576 * (double)megabytes;
  return THRUM_OK;
}

/* Where the n-th of a list stands, for messages once the mesh is there. The command line takes the
 * place of a whole list, so that a list is of one or the other. */
static void keep_line(const config_given *given, precompute_request *request, int64_t *lines,
                      int64_t n) {
  if (given->file == NULL || n >= CONFIG_FILE_ITEMS_MAX)
    return;
  request->lines_file = given->file->name;
  lines[n] = given->line;
}

static thrum_status take_fix(const config_given *given, void *request) {
  precompute_request *r = request;
  keep_line(given, r, r->fix_lines, r->fix_count);
  r->fixes[r->fix_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_spring(const config_given *given, void *request) {
  precompute_request *r = request;
  r->springs[r->spring_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_actuator(const config_given *given, void *request) {
  precompute_request *r = request;
  r->actuators[r->actuator_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_handle(const config_given *given, void *request) {
  precompute_request *r = request;
  keep_line(given, r, r->handle_lines, r->handle_count);
  r->handles[r->handle_count++] = given->text;
  return THRUM_OK;
}

/* Looked at here, and parsed again when the mesh has told its regions. */
static thrum_status take_about(const config_given *given, void *request) {
  ((precompute_request *)request)->about = given->text;
  return about_option_check(given);
}

static thrum_status take_region_material(const config_given *given, void *request) {
  precompute_request *r = request;
  THRUM_TRY(region_material_option_check(given));
  r->materials[r->material_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_train(const config_given *given, void *request) {
  precompute_request *r = request;
  return train_case_option_take(given, r->train, &r->train_count);
}

static thrum_status take_test(const config_given *given, void *request) {
  precompute_request *r = request;
  return train_case_option_take(given, r->tests, &r->test_count);
}

static thrum_status take_error(const config_given *given, void *request) {
  return error_option_take(given, &((precompute_request *)request)->error);
}

/* In the order of their enums. */
static const char *const masses[] = {"consistent", "lumped", NULL};
static const char *const selections[] = {"modes", "mass", NULL};
static const char *const precisions[] = {"double", "single", NULL};
static const char *const solvers[] = {"auto", "factor", "cg", NULL};
static const char *const checks[] = {"auto", "search", "inertia", NULL};

#define AT(member) CONFIG_AT(precompute_request, member)
#define GIVEN(member) .given = offsetof(precompute_request, member)

static const config_option options[] = {
    OPTION_TEXT("mesh", "MESH", NULL, "the mesh", .argument = true, .path = CONFIG_PATH_NAMED,
                .is_name = is_model_name_or_spec, AT(mesh_name)),
    OPTION_TEXT("output", "FILE.npz", NULL, "the model file to write", .letter = 'o',
                .path = CONFIG_PATH_ALWAYS, AT(output)),
    OPTION_TEXT("fix", "SPEC", "a free body, its six rigid modes kept apart",
                "hold vertices: a predicate in metres such as 'x<0.01&z>0', or a file of 1-based "
                "vertices (2, 3:7, # comment), or a group of the mesh; a suffix such as :z or :xy "
                "picks the axes",
                .path = CONFIG_PATH_IF_THERE, .repeats = true, .take = take_fix),
    OPTION_TEXT("spring", "WHERE:K", NULL,
                "springs between vertices and the ground: WHERE is as of --fix, K their stiffness "
                "together in N/m along each axis, or KX,KY,KZ, such as mid:37 or 'x>0.99:0,0,2e3'; "
                "several add up",
                .repeats = true, .take = take_spring),

    OPTION_FLAG("mean-dilatation",
                "tetrahedra of ten nodes whose change of volume is one number, for rubber: they do "
                "not lock near a Poisson's ratio of 1/2",
                AT(mean_dilatation)),
    OPTION_TEXT("about", "STATE", "a body without stress",
                "the state about which the model is made: stretch:EX,EY,EZ (strains by which what "
                "is held moves), temperature:DT,ALPHA (a change in K and the expansion by K), or "
                "FILE.npy of thrum static --displacements, the loads staying",
                .path = CONFIG_PATH_IF_THERE, .take = take_about),

    // its material, its unit and its elements
    OPTION_GROUP(material_options, "", AT(material)),
    OPTION_MATERIAL(take_region_material),
    OPTION_GROUP(mesh_read_rows, "", AT(reading)),

    OPTION_HEADING("the model"),
    OPTION_COUNT("modes", "10", "linear modes K", AT(options.modes), GIVEN(modes_given),
                 CONFIG_RANGE(1, COUNT_MAX)),
    OPTION_COUNT("rank", "K + 2 K, at most K + 30",
                 "reduced coordinates, at most K (K + 3) / 2: all K modes, and directions of their "
                 "derivatives; those of --handles come beside",
                 AT(options.rank), GIVEN(rank_given), CONFIG_RANGE(1, COUNT_MAX)),
    OPTION_CHOICE(
        "selection", selections, "modes",
        "how the rank is filled: modes takes all linear modes and what of the derivatives "
        "has most strain energy beside them; mass chooses from both by how much they move, "
        "as the thesis and earlier versions did, and may leave modes out",
        AT(options.selection)),
    OPTION_CHOICE("mass", masses, "consistent", "mass matrix", AT(options.mass)),
    OPTION_COUNT("quadrature-order", "4; 5 where edges are curved",
                 "degree to which the points of ten-node tetrahedra are exact: more for strongly "
                 "curved ones; 6 takes 24 points for 14, 7 takes 64",
                 AT(options.quadrature_order),
                 CONFIG_RANGE(THRUM_QUADRATURE_ORDER_MIN, THRUM_QUADRATURE_ORDER_MAX)),
    OPTION_CHOICE("precision", precisions, "double",
                  "of the cubic and quartic coefficients; large models step faster with single, "
                  "and what error that costs is said",
                  AT(options.single)),
    OPTION_CHOICE("check", checks, "auto: inertia for small meshes",
                  "how it is checked that no mode was missed; inertia is an exact count by "
                  "MUMPS, where it is built in",
                  AT(options.check)),
    OPTION_CHOICE("solver", solvers, "auto: factor where it fits into memory",
                  "of the equations of the whole body: a factor, or conjugate gradients with "
                  "algebraic multigrid, which take less memory and are those of thrum-mpi: where "
                  "that is built, thrum goes on as it",
                  AT(options.solver)),
    OPTION_TEXT("handles", "SPEC", NULL,
                "a group, vertex=N, near:X,Y,Z or a predicate that will be pulled: its static "
                "responses to forces along x, "
                "y, z are represented exactly; they and their derivatives take six coordinates "
                "beside those of --rank",
                .repeats = true, .take = take_handle),
    OPTION_TEXT(
        "actuator", "NAME=SPEC", NULL,
        "what acts on the body, at a level that runs set: chamber:GROUP or "
        "chamber:GROUP,cap (a closed surface, or one that caps close, under a pressure in "
        "Pa), pressure:GROUP (a surface whose edge is held), gas:GROUP[,cap][,outside=PA] "
        "(shut in), muscle:REGION,DX,DY,DZ (shortens by its level), swell:REGION, "
        "eigenstrain:REGION,XX,YY,ZZ,YZ,XZ,XY, tendon:PLACE,PLACE,... in N, PLACE vertex=N, "
        "near:X,Y,Z or at:X,Y,Z; each takes two coordinates beside those of --rank",
        .repeats = true, .take = take_actuator),
    OPTION_FLAG("touch",
                "add local response modes over the surface beside the rank, until pulls at any "
                "visible place move it by 80 % of what the mesh says (linear, in the mean over "
                "all directions), or --rank-max is reached, which is told with exit code 3; they "
                "follow at rest what acts on the body and are not stepped, so a step costs what "
                "it costs without them",
                AT(touch)),
    OPTION_FLAG("touch-stepped",
                "--touch, with modes that are stepped: they vibrate and touch as the others do, "
                "and a step costs the fourth power of the rank",
                AT(touch_stepped)),

    OPTION_FLAG("condense",
                "write a condensed model: the linear modes are stepped, all other coordinates "
                "follow at rest; the file is small, and cannot be stepped uncondensed",
                AT(condense)),

    OPTION_FLAG(
        "parameters",
        "keep what Lame's lambda and mu and the density of each region add to the model, so "
        "that they can be set, fitted and differentiated by later; a file of several "
        "regions is that many times as large, and six shapes for each region but one come "
        "beside the rank",
        AT(options.parameters)),

    OPTION_HEADING("points in place of the polynomial"),
    OPTION_LAW("stvk", "; these two need --cubature, as a polynomial cannot hold them",
               AT(options.law), GIVEN(law_given)),
    OPTION_FLAG("cubature",
                "sum the energy over a few points of the mesh, whose weights are chosen by random "
                "states: a step costs as much as points times rank, where the exact polynomial "
                "costs the fourth power of the rank",
                AT(options.cubature)),
    OPTION_NUMBER("cubature-error", NULL, "0.001",
                  "relative error of the internal force, rms over states that were not trained on, "
                  "at which there are enough points; exit code 3 where it is not reached",
                  AT(options.cubature_error), GIVEN(cubature_given), .least = 0,
                  .most = THRUM_CUBATURE_ERROR_MOST, .above = true),
    OPTION_COUNT("cubature-points", "2000", "at most so many points", AT(options.cubature_points),
                 GIVEN(cubature_given), CONFIG_RANGE(1, THRUM_CUBATURE_COUNT_MOST)),
    OPTION_NUMBER("cubature-range", NULL, "0.2",
                  "largest displacement of these states, as a share of the body's diagonal",
                  AT(options.cubature_range), GIVEN(cubature_given), .least = 0,
                  .most = THRUM_CUBATURE_RANGE_MOST, .above = true),
    OPTION_COUNT(
        "cubature-refine", "0",
        "steps in which the gradients of the points are learned from many more random "
        "states, 10000 as a rule: a quarter of the points does for the same error then, and "
        "it takes half a minute to some minutes more",
        AT(options.cubature_refine), CONFIG_RANGE(0, THRUM_CUBATURE_COUNT_MOST)),
    OPTION_NUMBER(
        "yield", NULL, "never",
        "train the points on states that have flowed beyond this strain as well, for runs "
        "with that --yield",
        AT(options.cubature_yield), CONFIG_ABOVE(0)),

    OPTION_HEADING("training"),
    OPTION_TEXT("train", "CASE", NULL,
                "run the full order under this load, as --load of simulate, and give half of the "
                "rank to what modes and derivatives cannot show of its motion; what acts together "
                "is one CASE with ; between: loads, base-motion:MOTION and start:START as those "
                "options of simulate have them",
                .repeats = true, .take = take_train),
    OPTION_TEXT("test", "CASE", NULL,
                "another case, which is not trained on: the error in it is printed too; without "
                "--train of the usual basis",
                .repeats = true, .take = take_test),
    OPTION_FLAG("by-share",
                "weigh modes and derivatives by what they do in the training, and not by their "
                "frequencies; better on some bodies and worse on others: look at --test",
                AT(by_share)),
    OPTION_WORD("error", "P%", "none",
                "grow modes, derivatives and trained shapes until no load of training and test "
                "errs by more than P per cent; exit code 3 where --rank-max does not allow it",
                .take = take_error, .wants = "an error such as 5%"),
    OPTION_COUNT("rank-max", "100; 40 with --touch-stepped",
                 "of --error and --touch: the most that the rank may grow to, with what follows",
                 AT(rank_max), CONFIG_RANGE(2, THRUM_RANK_MAX)),
    OPTION_NUMBER("train-time", "s", "0.5", "of each of these runs", AT(train_time),
                  CONFIG_ABOVE(0)),
    OPTION_NUMBER("train-dt", "s", "0.003", "time step of these runs", AT(train_dt),
                  CONFIG_ABOVE(0)),
    OPTION_PAIR("train-damping", "0",
                "Rayleigh damping of these runs: A of the mass, B of the stiffness",
                .unit = "1/s, s", CONFIG_FROM(0), .wants = "A, or A and B, none negative",
                AT(train_damping)),
    OPTION_TEXT("keep-runs", "DIR", "none",
                "keep these runs in this folder, and take those that are there already: a training "
                "that was stopped goes on with the runs that it had finished",
                .path = CONFIG_PATH_ALWAYS, AT(keep_runs)),
    OPTION_GROUP(job_options,
                 "a training in independent jobs, a run of --train or --test each, with "
                 "--keep-runs DIR",
                 AT(jobs)),

    OPTION_HEADING("other programs"),
    OPTION_TEXT("import-basis", "FILE.U", NULL,
                "take VegaFEM's basis in place of modes and derivatives; it is turned until it is "
                "mass-orthonormal and diagonalises the stiffness",
                .path = CONFIG_PATH_ALWAYS, AT(import_basis)),
    OPTION_TEXT("import-cubic", "FILE.cub", NULL, "and VegaFEM's polynomial of that basis with it",
                .path = CONFIG_PATH_ALWAYS, AT(import_cubic)),
    OPTION_TEXT("export-modes", "FILE.vtu", NULL, "write the linear modes for ParaView as well",
                .path = CONFIG_PATH_ALWAYS, AT(export_modes)),

    OPTION_HEADING("the work"),
    OPTION_COUNT("threads", "1", "threads of the linear algebra", AT(options.threads),
                 CONFIG_RANGE(1, CONFIG_THREADS_MAX)),
    OPTION_FLAG("dry-run",
                "say what memory and about what time it would take, and stop; exit code 3 when it "
                "would not fit",
                AT(dry_run)),
    OPTION_COUNT("memory", "what the machine has left", "refuse what would take more", .unit = "MB",
                 .take = take_memory, CONFIG_RANGE(1, MEGABYTES_MAX)),
    OPTION_FLAG("reproducible", "store no times in the file: two runs then give the same bytes",
                AT(reproducible)),
    OPTION_FILE(precompute_request),
    OPTION_JSON(precompute_request),
    OPTION_QUIET(precompute_request),
    OPTION_HELP_TWICE,
    OPTION_END,
};

const config_command command_precompute = {
    .name = "precompute",
    .summary = "from a tetrahedral mesh to a reduced model file",
    .usage = "MESH -o NAME.npz [--fix SPEC] [OPTIONS]",
    .about =
        "Makes a reduced model of a tetrahedral mesh: linear modes, modal derivatives, basis, and "
        "the exact polynomial of its strain energy.\n\n"
        "MESH is a file of Vega (.veg), Gmsh (.msh), TetGen (.node and .ele), Medit (.mesh), VTK "
        "(.vtk, .vtu) or Abaqus (.inp), or a generated beam, beam:NXxNYxNZ@LXxLYxLZ: cells, then "
        "metres (before --scale), and perhaps ,hex for hexahedra, ,split=5 for five tetrahedra a "
        "cell, or ,split=6 for six that are the same in every cell, and ,parts=2 for the regions "
        "part1 and part2 of half the length each; or "
        "a model file, whose mesh, materials and held vertices it then "
        "takes; or the name of a model that comes with Thrum (beam, basket, "
        "bridge, horse, tower, heart), whose material, fixed set, modes and rank are then the "
        "defaults; or VegaFEM's polynomial alone (.cub), which makes a model without a mesh.",
    .options = options,
    .often = "output fix young poisson density unit modes rank handles",
    .examples = "precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' -o beam.npz\n"
                "precompute part.msh --scale 1e-3 --young 2e6 --poisson 0.45 --density 1100 "
                "--fix clamp --fix 'z<0.002:z' --modes 12 --rank 30 -o part.npz\n"
                "precompute deck.inp --unit mm-t-s --fix clamp --material STEEL:2.1e11,0.3,7850 "
                "-o deck.npz\n"
                "precompute part.msh --fix clamp --modes 20 --rank 30 --dry-run\n"
                "precompute beam:20x3x3@1x0.15x0.15 --fix 'x<0.001' --handles tip -o pull.npz\n"
                "precompute horse --young 1e6 -o soft-horse.npz\n"
                "precompute horse --touch -o horse.npz\n"
                "precompute bridge --rank 30 --train square:0,0,-72000@load "
                "--test gravity:3,0,-9.81 -o bridge.npz\n"
                "precompute bridge --train square:0,0,-72000@load --test gravity:3,0,-9.81 "
                "--error 5% -o bridge.npz\n"
                "precompute tower --rank 40 --train base-motion:sine:3,0,0,f=1.5 "
                "--train 'start:mode:1,0.3' -o tower.npz\n"
                "precompute bridge --modes 20 --rank 100 --cubature -o bridge100.npz\n"
                "precompute beam:20x4x4@1x0.2x0.2 --fix 'x<0.001' --modes 8 --rank 20 --cubature "
                "--law neo-hookean -o rubber.npz\n"
                "precompute beam.veg --fix beam.bou --import-basis beam.U --import-cubic beam.cub "
                "-o beam.npz\n"
                "precompute bridge.veg --fix bridge.bou --threads 2 --json -o bridge.npz",
    .exits = "0 done, 1 refused, 2 usage, 3 made but flagged, or --dry-run: it would not fit",
};

/* Jobs are the runs of a training, which are kept. */
static int check_jobs(const precompute_request *request) {
  const job_request *jobs = &request->jobs;
  if (job_request_given(jobs) &&
      (request->train_count + request->test_count == 0 || request->keep_runs == NULL))
    return config_usage("precompute", "--list-jobs, --job and --collect are of a training: they go "
                                      "with --train or --test, and --keep-runs DIR");
  return job_request_check(jobs, "precompute");
}

const char *precompute_request_alone(const precompute_request *request) {
  return request->import_basis         ? "--import-basis"
         : request->options.cubature   ? "--cubature"
         : request->spring_count > 0   ? "--spring"
         : request->handle_count > 0   ? "--handles"
         : request->actuator_count > 0 ? "--actuator"
         : request->train_count > 0    ? "--train"
                                       : NULL;
}

int precompute_options_read(int argc, char **argv, precompute_request *request) {
  // the request begins with zeros, where these defaults are others
  request->reading.scale = 1;
  request->train_time = 0.5;
  request->error = NAN;
  request->train_dt = 0.003;
  request->material = (thrum_material){NAN, NAN, NAN};
  request->options = thrum_default_precompute_options();
  CONFIG_TRY(config_options_read_one(&command_precompute, "mesh", argc, argv, request,
                                     &request->mesh_name));

  // some options need others or exclude them
  CONFIG_TRY(check_jobs(request));
  if (request->output == NULL && !request->dry_run && !request->jobs.list &&
      request->jobs.number == 0)
    return config_usage("precompute", "no output given: say -o NAME.npz");
  if (!isnan(request->error) && request->train_count == 0)
    return config_usage("precompute", "--error goes with --train");
  if (request->by_share && request->train_count == 0)
    return config_usage("precompute", "--by-share goes with --train");
  if (request->rank_max == 0)
    request->rank_max =
        request->touch_stepped && !request->condense ? TOUCH_STEPPED_RANK_MAX : RANK_MAX;

  // training and tests have the usual quadrature alone
  if (request->train_count + request->test_count > 0 && request->options.quadrature_order > 0)
    return config_usage("precompute", "--quadrature-order goes without --train and --test");

  // its error is that of the whole model, and its runs are as long as a run of simulate may be
  if (request->train_count + request->test_count > 0 && request->condense)
    return config_usage(
        "precompute",
        "--train and --test judge the whole model, which --condense does not write: leave "
        "one out, or condense when stepping (simulate --condense)");
  if (request->train_time / request->train_dt > TRAIN_STEPS_MOST)
    return config_usage("precompute", "--train-time %g is more than %g steps of --train-dt",
                        request->train_time, TRAIN_STEPS_MOST);
  if (request->train_count + request->test_count > 0 && request->import_basis)
    return config_usage("precompute", "--train and --test go without --import-basis");
  request->touch = request->touch || request->touch_stepped;
  if (request->touch && (request->train_count + request->test_count > 0 || request->import_basis))
    return config_usage("precompute", "--touch goes without --train, --test and --import-basis");
  if (request->options.parameters &&
      (request->condense || request->options.single || request->options.cubature ||
       request->import_basis || request->touch || request->train_count + request->test_count > 0))
    return config_usage("precompute",
                        "--parameters goes without --condense, --precision single, --cubature, "
                        "--import-basis, --touch, --train and --test");
  if (request->actuator_count > 0 &&
      (request->condense || request->options.cubature || request->options.parameters ||
       request->import_basis || request->touch || request->train_count + request->test_count > 0))
    return config_usage("precompute",
                        "--actuator goes without --condense, --cubature, --parameters, "
                        "--import-basis, --touch, --train and --test");
  if (request->condense && request->import_basis)
    return config_usage("precompute",
                        "--condense needs linear modes, which --import-basis has not");

  // points stand in the place of coefficients, and a law of its own needs them
  if (request->options.law != THRUM_LAW_STVK && !request->options.cubature)
    return config_usage("precompute", "--law %s needs --cubature: a polynomial cannot hold it",
                        law_names[request->options.law]);
  if (!isinf(request->options.cubature_yield) && request->options.law == THRUM_LAW_STVK &&
      !region_materials_need_points(request->materials, request->material_count) &&
      !mesh_of_model_is_named(request->mesh_name))
    return config_usage("precompute", "--yield needs --law corotational or neo-hookean, whose "
                                      "points flow");

  // options of points are of no use to a polynomial, and the other way round
  if ((request->cubature_given || request->options.cubature_refine > 0) &&
      !request->options.cubature)
    return config_usage("precompute", "--cubature-error, --cubature-points, --cubature-range and "
                                      "--cubature-refine go with --cubature");
  if (request->options.cubature_refine > 0 && !isinf(request->options.cubature_yield))
    return config_usage("precompute", "--cubature-refine goes without --yield: what flows is the "
                                      "strain of a place, which learned points do not have");
  if (request->options.cubature &&
      (request->condense || request->options.single || request->import_cubic))
    return config_usage("precompute", "--cubature has no polynomial: it goes without --condense, "
                                      "--precision single and --import-cubic");
  if (request->spring_count > 0 && (request->options.cubature || request->import_cubic))
    return config_usage("precompute", "--spring goes without --cubature and --import-cubic, which "
                                      "have no place for what is not of the material");

  // an imported basis takes the place of modes, and its polynomial cannot come alone
  if (request->import_cubic && !request->import_basis)
    return config_usage("precompute", "--import-cubic goes with --import-basis");
  if (request->import_basis && (request->modes_given || request->rank_given ||
                                request->export_modes || request->handle_count > 0))
    return config_usage("precompute", "--import-basis goes without --modes, --rank, --handles "
                                      "and --export-modes");
  return COMMAND_DONE;
}
