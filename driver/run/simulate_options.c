/* Options of `thrum simulate`. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/simulate_options.h"

#include <math.h>

#include "config/message.h"
#include "driver/spec/model_names.h"
#include "driver/spec/shared_options.h"
#include "thrum/scene.h"

#define TIME_DEFAULT 10.0
#define STEP_ROUNDING 1e-9 /* of the time of a run: a step so much longer is no longer */

static thrum_status take_load(const config_given *given, void *request) {
  simulate_request *r = request;
  return load_option_take(given, r->loads, &r->load_count);
}

static thrum_status take_actuate(const config_given *given, void *request) {
  simulate_request *r = request;
  return actuate_option_take(given, r->actuates, &r->actuate_count);
}

static thrum_status take_start(const config_given *given, void *request) {
  simulate_request *r = request;
  thrum_error error = {0};
  if (start_spec_parse(given->text, &r->starts[r->start_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->start_count++;
  return THRUM_OK;
}

static thrum_status take_probe(const config_given *given, void *request) {
  simulate_request *r = request;
  thrum_error error = {0};
  probe_spec *probe = &r->probes[r->probe_count];
  *probe = (probe_spec){.name = given->text};
  if (load_target_parse(given->text, "--probe", &probe->target, &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  for (int64_t n = 0; n < r->probe_count; n++)
    if (load_target_equal(&r->probes[n].target, &probe->target))
      return THRUM_OK;
  r->probe_count++;
  return THRUM_OK;
}

static thrum_status take_base_motion(const config_given *given, void *request) {
  simulate_request *r = request;
  thrum_error error = {0};
  if (base_motion_parse(given->text, &r->base_motions[r->base_motion_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->base_motion_count++;
  return THRUM_OK;
}

static thrum_status take_frames(const config_given *given, void *request) {
  simulate_request *r = request;
  return frames_option_take(given, &r->frames_rate, &r->frames_every);
}

static thrum_status take_accepted(const config_given *given, void *request) {
  return error_option_take(given, &((simulate_request *)request)->basis.accepted);
}

static thrum_status take_against_mesh(const config_given *given, void *request) {
  static const char *const endings[] = {"", "s", "min", NULL};
  static const double scales[] = {1, 1, 60};
  return scaled_option_take(given, endings, scales, &((simulate_request *)request)->against_mesh);
}

static thrum_status take_ratios(const config_given *given, void *request) {
  return damping_spec_take_ratios(given, &((simulate_request *)request)->modal);
}

static thrum_status take_quality(const config_given *given, void *request) {
  return damping_spec_take_quality(given, &((simulate_request *)request)->modal);
}

static const char *const frames_in[] = {"base", "ground", NULL};

#define AGAINST_FILES "against_mesh.csv and a plot"
#define AT(member) CONFIG_AT(simulate_request, member)

static const config_option options[] = {
    OPTION_TEXT("model", "MODEL", NULL, "the model", .argument = true, .path = CONFIG_PATH_NAMED,
                .is_name = is_model_name_or_spec, AT(model_path)),
    OPTION_TEXT("output", "RUN", NULL,
                "the folder; new, empty, or an earlier run, which is replaced", .letter = 'o',
                .path = CONFIG_PATH_ALWAYS, AT(run_path)),

    // the motion: how long, under what, from where
    OPTION_DT(simulate_request, def.dt),
    OPTION_TIME(simulate_request, time, "10"),
    OPTION_LOAD(take_load, "none", "a load over time, such as impulse:0,0,-10@tip; see below"),
    OPTION_ACTUATE(take_actuate,
                   "the level of an actuator over time, with the kinds and keys of --load: "
                   "constant:LEVEL, ramp:LEVEL,until=S, sine:LEVEL,f=HZ, square:LEVEL, such as "
                   "air=ramp:2e4,until=1; several of one actuator add up"),
    OPTION_TEXT("base-motion", "BASE_MOTION", "none",
                "a motion of what holds the body, see below; several add up",
                .path = CONFIG_PATH_NAMED, .is_name = is_model_name_or_spec, .repeats = true,
                .take = take_base_motion),
    OPTION_TEXT("start", "START", "at rest",
                "mode:K,METRES: basis vector K, its furthest vertex displaced by METRES, released "
                "at rest; static:LOAD: the equilibrium under a LOAD, which is then gone; FILE.npy: "
                "q, or 2 rows q and p, such as RUN/end.npy; the starts add up",
                .path = CONFIG_PATH_NAMED, .is_name = is_model_name_or_spec, .repeats = true,
                .take = take_start),
    OPTION_VECTOR("spin", "degrees/s", "0,0,0",
                  "angular velocity at the start of a body that nothing holds; spin and shape act "
                  "on each other, and all is seen from the axes of the body",
                  AT(spin)),
    OPTION_COUNT(
        "rank", "all of the model",
        "step the lowest N coordinates and let the others follow them at rest, as --condense does",
        AT(rank), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_COUNT("condense", "none",
                 "step the lowest N coordinates and let the others follow them at rest: many times "
                 "cheaper, without their vibration",
                 AT(condense), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_HEADING("what is written"),
    OPTION_COUNT("record-every", "1", "steps between rows of energy.csv and q.npy",
                 AT(record_every), CONFIG_RANGE(1, 1e12)),
    OPTION_TEXT("probe", "TARGET", "where the loads act",
                "follow the mean displacement of a TARGET, in probes.csv and a plot",
                .repeats = true, .take = take_probe),
    OPTION_FRAMES(take_frames),
    OPTION_CHOICE(
        "frames-in", frames_in, "base",
        "whether frames are seen from the base that --base-motion moves or from the ground",
        AT(ground)),
    OPTION_FLAG("stress", "von Mises stress at nodes and centres: its peak, and in the frames",
                AT(stress)),
    OPTION_SWITCH("monitor", "on",
                  "warn of compression, inversion and of what the model cannot show; changes no "
                  "result",
                  AT(monitor), .given = offsetof(simulate_request, monitor_given)),
    OPTION_ACCEPT_ERROR("accept-error", take_accepted),
    OPTION_JUDGE(simulate_request, basis),
    OPTION_WORD("against-mesh", "T", "none",
                "step the whole mesh beside the model for T of your time, such as 60s or 5min, or "
                "to the end of the run, and say how far the model is wrong: " AGAINST_FILES,
                .take = take_against_mesh, .wants = "a time such as 60s"),

    OPTION_GROUP(solver_options, "the integrators", AT(def)),
    OPTION_DAMPING_RATIO(take_ratios),
    OPTION_QUALITY(take_quality),
    OPTION_HEADING("plastic flow"),
    OPTION_GROUP(plastic_options, "", AT(def.plastic)),
    OPTION_HEADING("the full order"),
    OPTION_FLAG("full",
                "step the whole mesh, unreduced (energy, newmark, midpoint, verlet; default "
                "energy): what the model is to be measured against; MODEL may then be a mesh",
                AT(full)),
    OPTION_GROUP(mesh_options, "", AT(mesh_def)),
    OPTION_CHOICE("linear-solver", full_solver_names, "cholesky",
                  "how its linear systems are solved; cg is conjugate gradients", AT(solver)),
    OPTION_CHOICE("quadrature", full_quadrature_names, "exact",
                  "points at which forces of ten-node tetrahedra are taken: those that are exact, "
                  "or four, as other programs take them",
                  AT(quadrature)),
    OPTION_FULL_LAW(simulate_request),

    OPTION_HEADING("besides"),
    OPTION_FILE(simulate_request),
    OPTION_COUNT("threads", "1", "of the steps of a SCENE.json; the results are the same",
                 AT(threads), CONFIG_RANGE(1, THRUM_SCENE_WORKERS_MAX)),
    OPTION_JSON(simulate_request),
    OPTION_QUIET(simulate_request),
    OPTION_HELP_TWICE,
    OPTION_END,
};

const config_command command_simulate = {
    .name = "simulate",
    .summary = "step a model and write what happened",
    .usage =
        "MODEL -o RUN [OPTIONS]\nSCENE.json -o RUN [--time X] [--dt X] [--threads N] [--json] [-q]",
    .about =
        "Steps a model file and writes what happened into the folder RUN: run.json (options and "
        "figures), energy.csv, q.npy, end.npy (q and p at the end), plots of the energy and of "
        "what "
        "moves where the loads act, where gnuplot "
        "is installed, and on request frames for ParaView.\n\n"
        "MODEL is a model file, or a name (beam, basket, bridge, horse, tower, heart) of a model "
        "that is precomputed once and cached. A SCENE.json names bodies, what acts on them and "
        "what is written (docs/scenes.md); RUN then has a folder for each body.",
    .options = options,
    .often = "output time dt load start probe damping integrator frames stress against-mesh",
    .notes = LOAD_NOTES
    "\nBASE_MOTION is FILE.csv, a line for each time: t,ax,ay,az, seconds and accelerations of "
    "the\n"
    "base in m/s^2, linear in between; under a first line of names t,x,y,z positions in m. Or\n"
    "sine:AX,AY,AZ,f=HZ[,from=S][,until=S]. Displacements are then relative to the base.\n",
    .examples =
        "simulate beam.npz -o swing --time 3 --start mode:1,0.02\n"
        "simulate beam.npz -o swing --load impulse:0,0,-1000@tip --damping 0.3\n"
        "simulate horse -o swing --load square:0,0,-10000@load --frames 30 --stress\n"
        "simulate tower -o swing --base-motion sine:5,0,0,f=2,until=5 --frames 60\n"
        "simulate beam.npz -o swing --load gravity:0,0,-9.81 --integrator newmark --frames 60\n"
        "simulate scene.json -o swing",
    .exits = "0 done, 1 refused, 2 usage, 3 ran but flagged (status in run.json says why)",
};

int64_t simulate_step_count(double time, double dt) {
  const int64_t steps = thrum_step_count(time, dt);
  if (steps > (int64_t)SIMULATE_STEPS_MAX)
    return 0;
  return steps < 1 ? 1 : steps;
}

bool simulate_step_is_longer(double time, double dt) {
  return dt > time * (1 + STEP_ROUNDING);
}

/* Why the full order has no such integrator; NULL: it has. */
static const char *why_not_full(thrum_integrator integrator) {
  switch (integrator) {
  case THRUM_INTEGRATOR_IMEXV:
    return "splits the modes of a reduced model";
  case THRUM_INTEGRATOR_FOX_GOODWIN:
    return "chooses beta by the modes of a reduced model";
  case THRUM_INTEGRATOR_BACKWARD_EULER:
  case THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER:
  case THRUM_INTEGRATOR_RK4:
    return "steps reduced models only";
  case THRUM_INTEGRATOR_MANIFOLD:
    return "steps condensed models";

  // these stand here by name, so that the compiler asks about a new one
  case THRUM_INTEGRATOR_NEWMARK:
  case THRUM_INTEGRATOR_VERLET:
  case THRUM_INTEGRATOR_MIDPOINT:
  case THRUM_INTEGRATOR_ENERGY:
    break;
  }
  return NULL;
}

/* The first option of plastic flow that is given; NULL: none. */
static const char *plastic_option(const thrum_plastic *plastic) {
  return !isinf(plastic->yield)     ? "--yield"
         : !isinf(plastic->creep)   ? "--creep"
         : !isinf(plastic->largest) ? "--largest-plastic-strain"
                                    : NULL;
}

/* Whether plastic flow can be had as it is asked for. Models say themselves which of them flow. */
static int check_plastic(const simulate_request *request) {
  const char *plastic = plastic_option(&request->def.plastic);
  if (request->against_mesh > 0 && is_scene_name(request->model_path))
    return config_usage("simulate", "--against-mesh is of a model: a scene has no mesh of its own");
  if (request->actuate_count > 0 &&
      (request->against_mesh > 0 || simulate_spins(request) || is_scene_name(request->model_path)))
    return config_usage("simulate", "--actuate goes without --against-mesh and --spin; bodies of a "
                                    "scene have the key \"actuate\"");
  if (plastic && request->stress)
    return config_usage(
        "simulate", "--stress is of a material that does not flow; leave it out with %s", plastic);
  return COMMAND_DONE;
}

/* Whether the full order can do what is asked for.
 * COMMAND_DONE, or the exit code after its line has been printed. */
static int check_full(simulate_request *request) {
  thrum_state_def *def = &request->def;
  if (!request->full && request->law_given)
    return config_usage("simulate", "--law goes with --full: a model has its own (precompute "
                                    "--law)");

  if (!request->full)
    return COMMAND_DONE;

  if (request->against_mesh > 0)
    return config_usage("simulate", "--against-mesh is of a reduced model; leave it out with "
                                    "--full");

  // the full order has no split and no modes
  const char *reason = why_not_full(def->integrator);
  if (reason)
    return config_usage("simulate", "--full: %s %s; take energy, newmark, midpoint or verlet",
                        thrum_integrator_name(def->integrator), reason);

  // damping and measures that are made of the reduced polynomial are refused as well
  if (def->damping_form == THRUM_DAMPING_TANGENT)
    return config_usage("simulate", "--full takes --damping-form rest only");
  if (damping_spec_given(&request->modal))
    return config_usage(
        "simulate",
        "--full has no modes that %s could damp; take --damping A, twice the ratio and "
        "the angular frequency of the mode that swings",
        request->modal.by_quality ? "--q" : "--damping-ratio");
  if (request->condense > 0 || request->rank > 0)
    return config_usage("simulate", "--%s is of a reduced model; leave it out with --full",
                        request->condense > 0 ? "condense" : "rank");
  if (request->monitor_given && request->monitor)
    return config_usage("simulate", "--monitor is of a reduced model; leave it out with --full");
  request->monitor = false;
  return COMMAND_DONE;
}

bool simulate_spins(const simulate_request *request) {
  return request->spin[0] != 0 || request->spin[1] != 0 || request->spin[2] != 0;
}

/* Whether a body can spin and do what else is asked for. */
static int check_spin(const simulate_request *request) {
  if (!simulate_spins(request))
    return COMMAND_DONE;
  if (request->full)
    return config_usage("simulate", "--spin is of a reduced model; leave it out with --full");
  if (request->def.integrator != THRUM_INTEGRATOR_ENERGY ||
      request->def.damping_form != THRUM_DAMPING_REST)
    return config_usage("simulate", "--spin takes --integrator energy and --damping-form rest");
  if (request->against_mesh > 0)
    return config_usage("simulate", "--against-mesh steps a mesh, which does not spin: leave it "
                                    "out with --spin");
  if (request->condense > 0)
    return config_usage("simulate", "--spin steps all coordinates; leave --condense out");
  if (request->load_count > 0 || request->base_motion_count > 0)
    return config_usage("simulate",
                        "--spin goes without --load and --base-motion: a body that turns has loads "
                        "in a scene, \"coupled\": true");
  return COMMAND_DONE;
}

/* Checks that take several options together. */
static int finish(simulate_request *request) {
  if (request->run_path == NULL)
    return config_usage("simulate", "where to? name the run's folder with -o RUN");

  if (request->threads > 1 && !is_scene_name(request->model_path))
    return config_usage("simulate", "--threads is of a scene: one body is stepped by one thread");

  // the mesh beside a model is damped as the mesh is
  if (damping_spec_given(&request->modal) &&
      (request->against_mesh > 0 || is_scene_name(request->model_path)))
    return config_usage(
        "simulate",
        "%s is of the modes of one model; take --damping A, twice the ratio and the "
        "angular frequency of the mode that swings",
        request->modal.by_quality ? "--q" : "--damping-ratio");

  // an option without effect would let a user believe that another integrator stepped
  const char *idle = split_option_without_effect(&request->def);
  if (idle != NULL)
    return config_usage("simulate", "%s is of imexv, and %s steps; add --integrator imexv", idle,
                        thrum_integrator_name(request->def.integrator));

  // the length of the run, of which a step is no more than the whole; a scene has a time of its own
  if (!is_scene_name(request->model_path) &&
      simulate_step_is_longer(request->time, request->def.dt))
    return config_usage("simulate",
                        "--dt %g is longer than the whole run, --time %g: take a shorter step",
                        request->def.dt, request->time);
  request->steps = simulate_step_count(request->time, request->def.dt);
  if (request->steps == 0)
    return config_usage("simulate", "--time %g at --dt %g is more than %g steps", request->time,
                        request->def.dt, SIMULATE_STEPS_MAX);
  CONFIG_TRY(mesh_model_full_check("simulate", request->model_path, &request->mesh_def,
                                   request->full, request->law_given));
  if (request->actuate_count > 0)
    request->basis.unless = "the mesh that would be asked has no actuators";
  CONFIG_TRY(check_spin(request));
  CONFIG_TRY(check_full(request));
  return check_plastic(request);
}

void simulate_request_begin(simulate_request *request) {
  request->def = thrum_default_state_def();
  request->mesh_def = mesh_model_def_default();
  request->time = TIME_DEFAULT;
  request->record_every = 1;
  request->threads = 1;
  request->monitor = true;
  request->basis.accepted = BASIS_ACCEPTED;
}

int simulate_options_read(int argc, char **argv, simulate_request *request) {
  simulate_request_begin(request);
  CONFIG_TRY(config_options_read_one(&command_simulate, "model", argc, argv, request,
                                     &request->model_path));
  return finish(request);
}

int64_t simulate_frame_step(const simulate_request *request, int64_t index) {
  if (request->frames_every > 0)
    return index <= request->steps / request->frames_every ? index * request->frames_every
                                                           : INT64_MAX;
  // more frames than steps: one a step
  const double stride = 1.0 / (request->frames_rate * request->def.dt);
  const double step = stride > 1 ? floor((double)index * stride + 0.5) : (double)index;
  return step <= (double)request->steps ? (int64_t)step : INT64_MAX;
}
