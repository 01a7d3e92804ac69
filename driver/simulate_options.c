/* Options of `thrum simulate`. SPDX-License-Identifier: Apache-2.0 */
#include "driver/simulate_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "driver/load_option.h"

#define TIME_DEFAULT 10.0

/* Names in the order of the enums. */
#define X(name, value, text) text,
const char *const simulate_integrators[] = {THRUM_INTEGRATOR_LIST(X) NULL};
const char *const simulate_damping_forms[] = {THRUM_DAMPING_FORM_LIST(X) NULL};
const char *const simulate_split_forms[] = {THRUM_SPLIT_FORM_LIST(X) NULL};
#undef X
static const char *const solvers[] = {"cholesky", "cg", NULL};
static const char *const frames_in[] = {"base", "ground", NULL};

static void choose_integrator(void *request, int index) {
  ((simulate_request *)request)->def.integrator = (thrum_integrator)index;
  ((simulate_request *)request)->integrator_named = true;
}

static void choose_damping_form(void *request, int index) {
  ((simulate_request *)request)->def.damping_form = (thrum_damping_form)index;
}

static void choose_split_form(void *request, int index) {
  ((simulate_request *)request)->def.split_form = (thrum_split_form)index;
}

static void choose_monitor(void *request, int index) {
  ((simulate_request *)request)->monitor = index != 0;
}

static void choose_adaptive(void *request, int index) {
  ((simulate_request *)request)->def.adaptive = index;
}

static void choose_fallback(void *request, int index) {
  ((simulate_request *)request)->def.fallback = index;
}

static int take_damping(const config_given *given, void *request) {
  thrum_state_def *def = &((simulate_request *)request)->def;
  double pair[2] = {0, 0};
  const int code = config_given_pair(given, pair);
  if (code == COMMAND_DONE) {
    def->damping_alpha = pair[0];
    def->damping_beta = pair[1];
  }
  return code;
}

static int take_newmark(const config_given *given, void *request) {
  thrum_state_def *def = &((simulate_request *)request)->def;
  double pair[2] = {0, NAN};
  const int code = config_given_pair(given, pair);
  if (code != COMMAND_DONE)
    return code;
  // both must be there
  if (!(pair[1] <= 1))
    return config_given_wrong(given);
  def->newmark_beta = pair[0];
  def->newmark_gamma = pair[1];
  return COMMAND_DONE;
}

static int take_split(const config_given *given, void *request) {
  thrum_state_def *def = &((simulate_request *)request)->def;
  int64_t count = 0;
  if (strcmp(given->text, "cfl") == 0) {
    def->split_rule = THRUM_SPLIT_CFL;
  } else if (strcmp(given->text, "sampling") == 0) {
    def->split_rule = THRUM_SPLIT_SAMPLING;
  } else if (config_parse_integer(given->text, &count) && count >= 0 && count <= THRUM_RANK_MAX) {
    def->split_rule = THRUM_SPLIT_COUNT;
    def->explicit_count = (int32_t)count;
  } else {
    return config_given_wrong(given);
  }
  return COMMAND_DONE;
}

static int take_frames(const config_given *given, void *request) {
  static const char every[] = "every-";
  simulate_request *r = request;
  r->frames_rate = 0;
  r->frames_every = 0;
  if (strncmp(given->text, every, sizeof every - 1) == 0) {
    if (config_parse_integer(given->text + sizeof every - 1, &r->frames_every) &&
        r->frames_every > 0)
      return COMMAND_DONE;
  } else if (config_parse_number(given->text, &r->frames_rate) && r->frames_rate > 0) {
    return COMMAND_DONE;
  }
  return config_given_wrong(given);
}

static int take_iterations(const config_given *given, void *request) {
  int64_t count = 0;
  const int code = config_given_count(given, &count);
  if (code == COMMAND_DONE)
    ((simulate_request *)request)->def.iterations_max = (int32_t)count;
  return code;
}

static int take_load(const config_given *given, void *request) {
  simulate_request *r = request;
  return cli_load_take(given, r->loads, &r->load_count);
}

static int take_start(const config_given *given, void *request) {
  simulate_request *r = request;
  thrum_error error = {0};
  if (cli_start_parse(given->text, &r->starts[r->start_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->start_count++;
  return COMMAND_DONE;
}

static int take_base_motion(const config_given *given, void *request) {
  simulate_request *r = request;
  thrum_error error = {0};
  if (cli_base_motion_parse(given->text, &r->base_motions[r->base_motion_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->base_motion_count++;
  return COMMAND_DONE;
}

static void choose_solver(void *request, int index) {
  ((simulate_request *)request)->solver = (thrum_full_solver)index;
}

static void choose_ground(void *request, int index) {
  ((simulate_request *)request)->ground = index != 0;
}

#define FIELD(member) .field = offsetof(simulate_request, member)
#define POSITIVE .most = INFINITY, .above = true

static void print_help(void) {
  fputs(
      "usage: thrum simulate MODEL -o RUN [OPTIONS]\n"
      "       thrum simulate SCENE.json -o RUN [--time S] [--dt S] [--json] [-q]\n\n"
      "Steps a model file and writes what happened into the folder RUN: run.json (options and\n"
      "figures), energy.csv, q.npy, end.npy (q and p at the end), an energy plot where gnuplot is\n"
      "installed, and on request frames for ParaView.\n\n"
      "MODEL is a model file, or a name (beam, basket, bridge, horse, tower, heart) of a model "
      "that\n"
      "is precomputed once and cached. A SCENE.json names bodies, what acts on them and what is\n"
      "written (docs/scenes.md); RUN then has a folder for each body.\n\n"
      "  -o, --output RUN       the folder; new, empty, or an earlier run, which is replaced\n"
      "      --integrator NAME  imexv (default), newmark, verlet, midpoint or energy\n"
      "      --dt S             time step [s] (default 0.003)\n"
      "      --time S           time to simulate [s] (default 10)\n"
      "      --load LOAD        a load; repeatable, see below\n"
      "      --base-motion BASE_MOTION      a motion of what holds the body; repeatable, see "
      "below\n"
      "      --start START      mode:K,METRES: basis vector K, its furthest vertex displaced by\n"
      "                         METRES, released at rest; static:LOAD: the equilibrium under a\n"
      "                         LOAD, which is then gone; FILE.npy: q, or 2 rows q and p, such\n"
      "                         as RUN/end.npy; repeatable, the starts add up (default: at rest)\n"
      "      --damping A[,B]    Rayleigh damping: A [1/s] of mass, B [s] of stiffness (default 0)\n"
      "      --damping-form F   rest (default): of the stiffness at rest; tangent: of the present\n"
      "      --rank N           step the lowest N coordinates only (default: all of the model)\n"
      "      --record-every N   steps between rows of energy.csv and q.npy (default 1)\n"
      "      --frames FPS       write frames.pvd and .vtu files, FPS a second of simulated time;\n"
      "                         every-N: one each N steps\n"
      "      --frames-in WHERE  base (default): as seen from the base that --base-motion moves; "
      "ground\n"
      "      --stress           von Mises stress in all tetrahedra: its peak, and in the frames\n"
      "      --monitor on|off   warn of compression, inversion and displacement beyond what the\n"
      "                         model can be believed for (default on; changes no result)\n"
      "      --options FILE.json  read options from a file (docs/options.md); those given here "
      "come first\n"
      "      --full             step the whole mesh, unreduced (energy, newmark, midpoint, "
      "verlet;\n"
      "                         default energy): what the model is to be\n"
      "                         measured against; MODEL may then be a mesh\n"
      "      --fix SPEC, --young E, --poisson NU, --density RHO\n"
      "                         of such a mesh, as of precompute\n"
      "      --solver NAME      of --full: cholesky (default), or cg, conjugate gradients\n"
      "      --json             print one JSON object instead of the table\n"
      "  -q, --quiet            no progress\n"
      "  -h, --help             this text\n\n",
      stdout);
  // two strings: C99 promises 4095 bytes of one
  fputs(
      "of the integrators:\n"
      "      --split RULE       imexv: cfl (default), explicit where dt omega <= 2 c; sampling,\n"
      "                         where dt f < 1; or the number of explicit modes\n"
      "      --safety C         imexv: c of cfl, in (0, 1] (default 0.5)\n"
      "      --split-form FORM  imexv: component (default), or quadratic: no iterations, for "
      "small\n"
      "                         steps or amplitudes\n"
      "      --adaptive on|off  imexv: watch stability and energy, and adapt to them (default on)\n"
      "      --fallback on|off    imexv, newmark, energy: what to do when a step cannot be "
      "solved:\n"
      "                         one that conserves energy, then shorter ones (default on)\n"
      "      --newmark B,G      newmark: beta and gamma (default 0.25,0.5)\n"
      "      --tolerance T      implicit solves: relative (default 1e-10)\n"
      "      --iterations N     implicit solves: at most N iterations (default 50)\n\n"
      "LOAD is KIND:X,Y,Z@TARGET[,from=S][,until=S], a force in newtons:\n"
      "  impulse   for 0.003 s, or until=        square    for 0.3 s, or until=\n"
      "  constant  for ever, or until=           sine      needs f=HZ; for ever, or until=\n"
      "  gravity   gravity:X,Y,Z, an acceleration in m/s^2; no TARGET\n"
      "  traction  traction:X,Y,Z@GROUP, a force an area in Pa on the surface there\n"
      "TARGET is a group, vertex=N (from 1, as in lists of fixed vertices), or all. The force is\n"
      "the total: the vertices of a group share it equally, held ones included.\n\n"
      "BASE_MOTION is FILE.csv, a line for each time: t,ax,ay,az, seconds and accelerations of the "
      "base\n"
      "in m/s^2, linear in between; under a first line of names t,x,y,z positions in m. Or\n"
      "sine:AX,AY,AZ,f=HZ[,from=S][,until=S]. Displacements are then relative to the base.\n\n"
      "examples:\n"
      "  thrum simulate beam.npz -o run --time 3 --start mode:1,0.02\n"
      "  thrum simulate beam.npz -o run --load impulse:0,0,-40@tip --damping 0.3\n"
      "  thrum simulate horse -o run --load square:0,0,-50@load --frames 30 --stress\n"
      "  thrum simulate tower -o run --base-motion sine:0.5,0,0,f=2,until=5 --frames 60\n"
      "  thrum simulate beam.npz -o run --load gravity:0,0,-9.81 --integrator newmark --frames "
      "60\n"
      "  thrum simulate scene.json -o run\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 ran but flagged (status in run.json says why)\n",
      stdout);
}

const config_option simulate_options_table[] = {
    {.name = "model",
     .kind = CONFIG_TEXT,
     .argument = true,
     .path = CONFIG_PATH_NAMED,
     FIELD(model_path)},
    CONFIG_OPTION_FILE(simulate_request),
    {.name = "output",
     .letter = 'o',
     .kind = CONFIG_TEXT,
     .path = CONFIG_PATH_ALWAYS,
     FIELD(run_path)},
    {.name = "integrator",
     .kind = CONFIG_CHOICE,
     .names = simulate_integrators,
     .choose = choose_integrator},
    {.name = "dt",
     .kind = CONFIG_NUMBER,
     FIELD(def.dt),
     POSITIVE,
     .wants = "a time step above 0 s"},
    {.name = "time", .kind = CONFIG_NUMBER, FIELD(time), POSITIVE, .wants = "a time above 0 s"},
    {.name = "load", .kind = CONFIG_TEXT, .repeats = true, .take = take_load},
    {.name = "base-motion",
     .kind = CONFIG_TEXT,
     .path = CONFIG_PATH_NAMED,
     .repeats = true,
     .take = take_base_motion},
    {.name = "start",
     .kind = CONFIG_TEXT,
     .path = CONFIG_PATH_NAMED,
     .repeats = true,
     .take = take_start},
    {.name = "damping",
     .kind = CONFIG_PAIR,
     .take = take_damping,
     .wants = "A or A,B, none negative"},
    {.name = "damping-form",
     .kind = CONFIG_CHOICE,
     .names = simulate_damping_forms,
     .choose = choose_damping_form},
    {.name = "rank", .kind = CONFIG_COUNT, FIELD(rank), .least = 1, .most = THRUM_RANK_MAX},
    {.name = "record-every", .kind = CONFIG_COUNT, FIELD(record_every), .least = 1, .most = 1e12},
    {.name = "frames",
     .kind = CONFIG_WORD,
     .take = take_frames,
     .wants = "frames a second such as 60, or every-N steps"},
    {.name = "frames-in", .kind = CONFIG_CHOICE, .names = frames_in, .choose = choose_ground},
    {.name = "split",
     .kind = CONFIG_WORD,
     .take = take_split,
     .wants = "cfl, sampling or the number of explicit modes"},
    {.name = "safety",
     .kind = CONFIG_NUMBER,
     FIELD(def.split_safety),
     .most = 1,
     .above = true,
     .wants = "a number in (0, 1]"},
    {.name = "split-form",
     .kind = CONFIG_CHOICE,
     .names = simulate_split_forms,
     .choose = choose_split_form},
    {.name = "adaptive",
     .kind = CONFIG_CHOICE,
     .names = config_switches,
     .choose = choose_adaptive},
    {.name = "fallback",
     .kind = CONFIG_CHOICE,
     .names = config_switches,
     .choose = choose_fallback},
    {.name = "newmark",
     .kind = CONFIG_PAIR,
     .take = take_newmark,
     .wants = "BETA,GAMMA with BETA >= 0 and GAMMA in [0, 1]"},
    {.name = "tolerance",
     .kind = CONFIG_NUMBER,
     FIELD(def.tolerance),
     .most = 0.01,
     .above = true,
     .wants = "a number in (0, 0.01]"},
    {.name = "iterations", .kind = CONFIG_COUNT, .take = take_iterations, .least = 1, .most = 1e6},
    {.name = "full", .kind = CONFIG_FLAG, FIELD(full)},
    CONFIG_OPTIONS_MESH(simulate_request),
    {.name = "solver", .kind = CONFIG_CHOICE, .names = solvers, .choose = choose_solver},
    {.name = "stress", .kind = CONFIG_FLAG, FIELD(stress)},
    {.name = "monitor", .kind = CONFIG_CHOICE, .names = config_switches, .choose = choose_monitor},
    CONFIG_OPTION_JSON(simulate_request),
    CONFIG_OPTION_QUIET(simulate_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

int64_t simulate_step_count(double time, double dt) {
  const int64_t steps = thrum_step_count(time, dt);
  if (steps > (int64_t)SIMULATE_STEPS_MAX)
    return 0;
  return steps < 1 ? 1 : steps;
}

/* Whether the full order can do what is asked for; picks its integrator where none is named.
 * COMMAND_DONE, or the exit code after its line has been printed. */
static int check_full(simulate_request *request) {
  thrum_state_def *def = &request->def;
  if (!request->full)
    return COMMAND_DONE;
  if (!request->integrator_named)
    def->integrator = THRUM_INTEGRATOR_ENERGY;
  if (def->integrator == THRUM_INTEGRATOR_IMEXV)
    return config_usage("simulate",
                        "--full: imexv splits the modes of a reduced model; take energy, "
                        "newmark, midpoint or verlet");
  if (def->damping_form == THRUM_DAMPING_TANGENT)
    return config_usage("simulate", "--full takes --damping-form rest only");
  if (request->stress)
    return config_usage("simulate", "--stress is of a reduced model; leave it out with --full");
  request->monitor = false;
  return COMMAND_DONE;
}

/* What cannot be seen option by option. */
static int finish(int argc, char **argv, simulate_request *request) {
  const int code = config_one_argument("simulate", "model", argc, argv, &request->model_path);
  if (code != COMMAND_DONE)
    return code;
  if (request->run_path == NULL)
    return config_usage("simulate", "where to? name the run's folder with -o RUN");
  request->steps = simulate_step_count(request->time, request->def.dt);
  if (request->steps == 0)
    return config_usage("simulate", "--time %g at --dt %g is more than %g steps", request->time,
                        request->def.dt, SIMULATE_STEPS_MAX);
  const int found =
      cli_mesh_full_check("simulate", request->model_path, &request->mesh_def, request->full);

  return found == COMMAND_DONE ? check_full(request) : found;
}

int simulate_options_read(int argc, char **argv, simulate_request *request) {
  request->def = thrum_default_state_def();
  request->mesh_def = cli_default_mesh_def();
  request->time = TIME_DEFAULT;
  request->record_every = 1;
  request->monitor = true;
  const int code = config_options_read("simulate", simulate_options_table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  return finish(argc, argv, request);
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
