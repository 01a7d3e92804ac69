/* Options of `thrum simulate`. SPDX-License-Identifier: Apache-2.0 */
#include "cli/simulate_options.h"

#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TIME_DEFAULT 10.0
#define STEPS_MAX 1e12  /* years of computing; beyond that an option is a slip */
#define WHOLE_STEP 1e-6 /* as in thrum_load_mean: this near to a whole step is that step */

enum {
  INTEGRATOR = 256,
  DT,
  TIME,
  DAMPING,
  DAMPING_FORM,
  SPLIT,
  SAFETY,
  SPLIT_FORM,
  ADAPTIVE,
  LADDER,
  NEWMARK,
  TOLERANCE,
  ITERATIONS,
  LOAD,
  START,
  FRAMES,
  RECORD_EVERY,
  RANK,
  JSON
};

static const struct option options[] = {
    {"output", required_argument, NULL, 'o'},
    {"integrator", required_argument, NULL, INTEGRATOR},
    {"dt", required_argument, NULL, DT},
    {"time", required_argument, NULL, TIME},
    {"damping", required_argument, NULL, DAMPING},
    {"damping-form", required_argument, NULL, DAMPING_FORM},
    {"split", required_argument, NULL, SPLIT},
    {"safety", required_argument, NULL, SAFETY},
    {"split-form", required_argument, NULL, SPLIT_FORM},
    {"adaptive", required_argument, NULL, ADAPTIVE},
    {"ladder", required_argument, NULL, LADDER},
    {"newmark", required_argument, NULL, NEWMARK},
    {"tolerance", required_argument, NULL, TOLERANCE},
    {"iterations", required_argument, NULL, ITERATIONS},
    {"load", required_argument, NULL, LOAD},
    {"start", required_argument, NULL, START},
    {"frames", required_argument, NULL, FRAMES},
    {"record-every", required_argument, NULL, RECORD_EVERY},
    {"rank", required_argument, NULL, RANK},
    {"json", no_argument, NULL, JSON},
    {"quiet", no_argument, NULL, 'q'},
    {"help", no_argument, NULL, 'h'},
    {NULL, 0, NULL, 0},
};

/* Names in the order of the enums. */
static const char *const integrators[] = {"imexv", "newmark", "verlet", "midpoint", "energy"};
static const char *const damping_forms[] = {"rest", "tangent"};
static const char *const split_forms[] = {"component", "quadratic"};
static const char *const schemes[] = {"component", "quadratic", "energy", "newmark"};
static const char *const switches[] = {"off", "on"};

const char *simulate_integrator_name(thrum_integrator integrator) {
  return integrators[integrator];
}

const char *simulate_damping_form_name(thrum_damping_form form) {
  return damping_forms[form];
}

const char *simulate_split_form_name(thrum_split_form form) {
  return split_forms[form];
}

const char *simulate_scheme_name(thrum_scheme scheme) {
  return schemes[scheme];
}

void simulate_help(void) {
  fputs(
      "usage: thrum simulate MODEL -o RUN [OPTIONS]\n\n"
      "Steps a model file and writes what happened into the folder RUN: run.json (options and\n"
      "figures), energy.csv, q.npy, end.npy (q and p at the end), an energy plot where gnuplot is\n"
      "installed, and on request frames for ParaView.\n\n"
      "MODEL is a model file, or a name (beam, basket, bridge, horse, tower, heart) of a model "
      "that\n"
      "is precomputed once and cached.\n\n"
      "  -o, --output RUN       the folder; new, empty, or an earlier run, which is replaced\n"
      "      --integrator NAME  imexv (default), newmark, verlet, midpoint or energy\n"
      "      --dt S             time step [s] (default 0.003)\n"
      "      --time S           time to simulate [s] (default 10)\n"
      "      --load LOAD        a load; repeatable, see below\n"
      "      --start START      mode:K,METRES: basis vector K, its furthest vertex displaced by\n"
      "                         METRES, released at rest; or FILE.npy: q, or 2 rows q and p, such\n"
      "                         as RUN/end.npy; repeatable, the starts add up (default: at rest)\n"
      "      --damping A[,B]    Rayleigh damping: A [1/s] of mass, B [s] of stiffness (default 0)\n"
      "      --damping-form F   rest (default): of the stiffness at rest; tangent: of the present\n"
      "      --rank N           step the lowest N coordinates only (default: all of the model)\n"
      "      --record-every N   steps between rows of energy.csv and q.npy (default 1)\n"
      "      --frames FPS       write frames.pvd and .vtu files, FPS a second of simulated time;\n"
      "                         every-N: one each N steps\n"
      "      --json             print one JSON object instead of the table\n"
      "  -q, --quiet            no progress\n"
      "  -h, --help             this text\n\n"
      "of the integrators:\n"
      "      --split RULE       imexv: cfl (default), explicit where dt omega <= 2 c; sampling,\n"
      "                         where dt f < 1; or the number of explicit modes\n"
      "      --safety C         imexv: c of cfl, in (0, 1] (default 0.5)\n"
      "      --split-form FORM  imexv: component (default), or quadratic: no iterations, for "
      "small\n"
      "                         steps or amplitudes\n"
      "      --adaptive on|off  imexv: watch stability and energy, and adapt to them (default on)\n"
      "      --ladder on|off    imexv, newmark, energy: what to do when a step cannot be solved:\n"
      "                         one that conserves energy, then shorter ones (default on)\n"
      "      --newmark B,G      newmark: beta and gamma (default 0.25,0.5)\n"
      "      --tolerance T      implicit solves: relative (default 1e-10)\n"
      "      --iterations N     implicit solves: at most N iterations (default 50)\n\n"
      "LOAD is KIND:X,Y,Z@TARGET[,from=S][,until=S], a force in newtons:\n"
      "  impulse   for 0.003 s, or until=        square    for 0.3 s, or until=\n"
      "  constant  for ever, or until=           sine      needs f=HZ; for ever, or until=\n"
      "  gravity   gravity:X,Y,Z, an acceleration in m/s^2; no TARGET\n"
      "TARGET is a group, vertex=N (from 1, as in lists of fixed vertices), or all. The force is\n"
      "the total: the vertices of a group share it equally, held ones included.\n\n"
      "examples:\n"
      "  thrum simulate beam.npz -o run --time 3 --start mode:1,0.02\n"
      "  thrum simulate beam.npz -o run --load impulse:0,0,-40@tip --damping 0.3\n"
      "  thrum simulate horse -o run --load square:0,0,-50@load --frames 30\n"
      "  thrum simulate beam.npz -o run --load gravity:0,0,-9.81 --integrator newmark --frames "
      "60\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 ran but flagged (status in run.json says why)\n",
      stdout);
}

static int usage(const char *option, const char *wants, const char *text) {
  return cli_usage("simulate", "--%s wants %s, not '%s'", option, wants, text);
}

static int number_option(const char *name, const char *text, const char *wants, double least,
                         bool least_allowed, double most, double *value) {
  double parsed = 0;
  if (!cli_parse_number(text, &parsed) || parsed > most ||
      !(least_allowed ? parsed >= least : parsed > least))
    return usage(name, wants, text);
  *value = parsed;
  return CLI_DONE;
}

static int count_option(const char *name, const char *text, int64_t least, int64_t most,
                        int64_t *value) {
  int64_t parsed = 0;
  if (!cli_parse_integer(text, &parsed) || parsed < least || parsed > most) {
    return cli_usage("simulate", "--%s wants a whole number from %lld to %lld, not '%s'", name,
                     (long long)least, (long long)most, text);
  }
  *value = parsed;
  return CLI_DONE;
}

/* "A" or "A,B", where the second keeps its value when it is not given and may be left out. */
static int pair_option(const char *name, const char *text, const char *wants, bool both,
                       double pair[2]) {
  char first[64];
  double parsed[2] = {pair[0], pair[1]};
  const size_t length = strcspn(text, ",");
  if (length >= sizeof first || (both && text[length] == 0))
    return usage(name, wants, text);
  memcpy(first, text, length);
  first[length] = 0;
  if (!cli_parse_number(first, &parsed[0]) ||
      (text[length] == ',' && !cli_parse_number(text + length + 1, &parsed[1])) ||
      !(parsed[0] >= 0) || !(parsed[1] >= 0))
    return usage(name, wants, text);
  pair[0] = parsed[0];
  pair[1] = parsed[1];
  return CLI_DONE;
}

static int damping_option(const char *text, thrum_state_def *def) {
  double pair[2] = {0, 0};
  const int code = pair_option("damping", text, "A or A,B, none negative", false, pair);
  if (code == CLI_DONE) {
    def->damping_alpha = pair[0];
    def->damping_beta = pair[1];
  }
  return code;
}

static int newmark_option(const char *text, thrum_state_def *def) {
  static const char wants[] = "BETA,GAMMA with BETA >= 0 and GAMMA in [0, 1]";
  double pair[2] = {0, 0};
  const int code = pair_option("newmark", text, wants, true, pair);
  if (code != CLI_DONE)
    return code;
  if (pair[1] > 1)
    return usage("newmark", wants, text);
  def->newmark_beta = pair[0];
  def->newmark_gamma = pair[1];
  return CLI_DONE;
}

/* Finds `text` in a list; its place, or -1. */
static int name_index(const char *text, const char *const *names, int count) {
  for (int n = 0; n < count; n++) {
    if (strcmp(text, names[n]) == 0)
      return n;
  }
  return -1;
}

static int integrator_option(const char *text, thrum_state_def *def) {
  const int count = sizeof integrators / sizeof integrators[0];
  const int index = name_index(text, integrators, count);
  if (index < 0)
    return usage("integrator", "imexv, newmark, verlet, midpoint or energy", text);
  def->integrator = (thrum_integrator)index;
  return CLI_DONE;
}

static int damping_form_option(const char *text, thrum_state_def *def) {
  const int index = name_index(text, damping_forms, 2);
  if (index < 0)
    return usage("damping-form", "rest or tangent", text);
  def->damping_form = (thrum_damping_form)index;
  return CLI_DONE;
}

static int split_form_option(const char *text, thrum_state_def *def) {
  const int index = name_index(text, split_forms, 2);
  if (index < 0)
    return usage("split-form", "component or quadratic", text);
  def->split_form = (thrum_split_form)index;
  return CLI_DONE;
}

static int switch_option(const char *name, const char *text, int32_t *value) {
  const int index = name_index(text, switches, 2);
  if (index < 0)
    return usage(name, "on or off", text);
  *value = index;
  return CLI_DONE;
}

static int split_option(const char *text, thrum_state_def *def) {
  int64_t count = 0;
  if (strcmp(text, "cfl") == 0) {
    def->split_rule = THRUM_SPLIT_CFL;
  } else if (strcmp(text, "sampling") == 0) {
    def->split_rule = THRUM_SPLIT_SAMPLING;
  } else if (cli_parse_integer(text, &count) && count >= 0 && count <= THRUM_RANK_MAX) {
    def->split_rule = THRUM_SPLIT_COUNT;
    def->explicit_count = (int32_t)count;
  } else {
    return usage("split", "cfl, sampling or the number of explicit modes", text);
  }
  return CLI_DONE;
}

static int frames_option(const char *text, simulate_request *request) {
  static const char every[] = "every-";
  request->frames_rate = 0;
  request->frames_every = 0;
  if (strncmp(text, every, sizeof every - 1) == 0) {
    if (cli_parse_integer(text + sizeof every - 1, &request->frames_every) &&
        request->frames_every > 0)
      return CLI_DONE;
  } else if (cli_parse_number(text, &request->frames_rate) && request->frames_rate > 0) {
    return CLI_DONE;
  }
  return usage("frames", "frames a second such as 60, or every-N steps", text);
}

static int spec_option(int option, const char *text, simulate_request *request) {
  thrum_error error = {0};
  thrum_status status;
  if (option == LOAD) {
    status = cli_load_parse(text, &request->loads[request->load_count], &error);
    request->load_count += status == THRUM_OK;
  } else {
    status = cli_start_parse(text, &request->starts[request->start_count], &error);
    request->start_count += status == THRUM_OK;
  }
  return status == THRUM_OK ? CLI_DONE : cli_usage("simulate", "%s", error.message);
}

static int iterations_option(const char *text, thrum_state_def *def) {
  int64_t count = 0;
  const int code = count_option("iterations", text, 1, 1000000, &count);
  if (code == CLI_DONE)
    def->iterations_max = (int32_t)count;
  return code;
}

/* One option that getopt_long recognised. */
static int apply_option(int option, simulate_request *request) {
  thrum_state_def *def = &request->def;
  switch (option) {
  case 'o':
    request->run_path = optarg;
    return CLI_DONE;
  case INTEGRATOR:
    return integrator_option(optarg, def);
  case DT:
    return number_option("dt", optarg, "a time step above 0 s", 0, false, INFINITY, &def->dt);
  case TIME:
    return number_option("time", optarg, "a time above 0 s", 0, false, INFINITY, &request->time);
  case DAMPING:
    return damping_option(optarg, def);
  case DAMPING_FORM:
    return damping_form_option(optarg, def);
  case SPLIT:
    return split_option(optarg, def);
  case SAFETY:
    return number_option("safety", optarg, "a number in (0, 1]", 0, false, 1, &def->split_safety);
  case SPLIT_FORM:
    return split_form_option(optarg, def);
  case ADAPTIVE:
    return switch_option("adaptive", optarg, &def->adaptive);
  case LADDER:
    return switch_option("ladder", optarg, &def->ladder);
  case NEWMARK:
    return newmark_option(optarg, def);
  case TOLERANCE:
    return number_option("tolerance", optarg, "a number in (0, 0.01]", 0, false, 0.01,
                         &def->tolerance);
  case ITERATIONS:
    return iterations_option(optarg, def);
  case LOAD:
  case START:
    return spec_option(option, optarg, request);
  case FRAMES:
    return frames_option(optarg, request);
  case RECORD_EVERY:
    return count_option("record-every", optarg, 1, INT64_C(1000000000000), &request->record_every);
  case RANK:
    return count_option("rank", optarg, 1, THRUM_RANK_MAX, &request->rank);
  case JSON:
    request->json = true;
    return CLI_DONE;
  case 'q':
    request->quiet = true;
    return CLI_DONE;
  default:
    request->help = true;
    return CLI_DONE;
  }
}

/* What cannot be seen option by option. */
static int finish(int argc, char **argv, simulate_request *request) {
  if (optind >= argc)
    return cli_usage("simulate", "which model? thrum simulate MODEL -o RUN");
  if (argc - optind > 1)
    return cli_usage("simulate", "one model at a time; '%s' is too much", argv[optind + 1]);
  request->model_path = argv[optind];
  if (request->run_path == NULL)
    return cli_usage("simulate", "where to? name the run's folder with -o RUN");
  // a time within a millionth of a step is a whole number of them, any other is rounded up
  const double steps = ceil(request->time / request->def.dt - WHOLE_STEP);
  if (!(steps <= STEPS_MAX)) {
    return cli_usage("simulate", "--time %g at --dt %g is more than %g steps", request->time,
                     request->def.dt, STEPS_MAX);
  }
  request->steps = steps < 1 ? 1 : (int64_t)steps;
  return CLI_DONE;
}

int simulate_options_read(int argc, char **argv, simulate_request *request) {
  request->def = thrum_default_state_def();
  request->time = TIME_DEFAULT;
  request->record_every = 1;
  opterr = 0;
  optind = 1;
  for (int option = getopt_long(argc, argv, ":o:qh", options, NULL); option != -1;
       option = getopt_long(argc, argv, ":o:qh", options, NULL)) {
    if (option == '?' || option == ':')
      return cli_usage_option("simulate", argv, options);
    const int code = apply_option(option, request);
    if (code != CLI_DONE || request->help)
      return code;
  }
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
