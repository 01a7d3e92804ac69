/* Options of `thrum tradeoff`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/tradeoff_options.h"
#include "config/message.h"
#include "config/parse.h"
#include "driver/load_option.h"
#include "mesh/formats/mesh_read.h"

#define FPS_DEFAULT 60
#define ERROR_DEFAULT 0.05

static void print_help(void) {
  fputs(
      "usage: thrum tradeoff MODEL|MESH -o DIR --load LOAD [--error P%|--budget T] [OPTIONS]\n\n"
      "Steps a load with the full-order body of the model's mesh and with reduced models over "
      "rank,\n"
      "precision, integrator, time step and tolerance; says what each costs and how far it is off; "
      "and picks "
      "a\n"
      "setting. Writes to DIR: tradeoff.html, tradeoff.csv, and the setting as options files that\n"
      "`thrum precompute` and `thrum simulate` take.\n\n"
      "  -o, --output DIR        the folder; made when it is not there\n"
      "      --fix SPEC          of a MESH, as of precompute; repeatable: what is held\n"
      "      --young E, --poisson NU, --density RHO\n"
      "                          of a MESH: in place of its own materials [Pa], [], [kg/m^3]\n"
      "      --load LOAD         as of simulate; repeatable; of beam, basket, bridge, horse, "
      "tower\n"
      "                          and heart there is a default\n"
      "      --error P%          pick the cheapest setting whose displacement error against the\n"
      "                          full order is at most P per cent (default 5%)\n"
      "      --budget T          pick the most accurate one that takes at most T of processor\n"
      "                          time for a frame, such as 2ms or 500us\n"
      "      --fps N             frames a second of --budget (default 60)\n"
      "      --time S            to simulate [s] (default 1; with --quick 0.5)\n"
      "      --ranks LIST        ranks, each of half as many modes; 0 is the model's own basis\n"
      "                          (default 0,6,10,20,30; with --quick 0,10)\n"
      "      --dts LIST          time steps [s] (default 0.001,0.002,0.003,0.005,0.01,0.016667;\n"
      "                          with --quick 0.003,0.01,0.016667)\n"
      "      --tolerances LIST   of the implicit solves (default 1e-10,1e-6,1e-3; with --quick\n"
      "                          1e-6)\n"
      "      --integrators LIST  of imexv, newmark, energy\n"
      "      --precisions LIST   of the coefficients of the bases that are made: double, single\n"
      "                          (default double,single; with --quick double)\n"
      "      --damping A[,B]     Rayleigh damping (default 0)\n"
      "      --full-dt S         time step of the full order (default 0.001; with --quick 0.002)\n"
      "      --quick             a coarse answer in under a minute, on models of some thousand\n"
      "                          tetrahedra\n"
      "      --threads N         (default 1)\n"
      "      --json              print one JSON object instead of the table\n"
      "  -q, --quiet             no progress\n"
      "  -h, --help              this text\n\n"
      "examples:\n"
      "  thrum tradeoff beam -o trade --error 5% --quick\n"
      "  thrum tradeoff beam.npz -o trade --load 'square:0,0,-40@tip' --budget 500us --threads 4\n"
      "  thrum tradeoff beam:12x3x3@1x0.1x0.1 -o trade --fix 'x<0.001' --load square:0,0,-9@tip\n"
      "  thrum simulate beam -o run --options trade/simulate.json --load square:0,0,-33@load\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 done, but no setting does what was asked\n",
      stdout);
}

static int take_load(const config_given *given, void *request) {
  tradeoff_request *r = request;
  return cli_load_take(given, r->loads, &r->load_count);
}

/* Numbers with commas between, in the table's range; those of ranks are whole. */
static int take_list(const config_given *given, double *values, int64_t *count) {
  char list[256];
  snprintf(list, sizeof list, "%s", given->text);
  *count = 0;
  if (strlen(given->text) >= sizeof list)
    return config_given_wrong(given);
  for (char *at = list; at != NULL;) {
    char *comma = strchr(at, ',');
    if (comma != NULL)
      *comma = 0;
    double value;
    if (*count == TRADEOFF_LIST_MAX || !config_parse_number(at, &value) ||
        !(value >= given->option->least && value <= given->option->most))
      return config_given_wrong(given);
    values[(*count)++] = value;
    at = comma != NULL ? comma + 1 : NULL;
  }
  return COMMAND_DONE;
}

static int take_ranks(const config_given *given, void *request) {
  tradeoff_request *r = request;
  const int code = take_list(given, r->ranks, &r->rank_count);
  for (int64_t n = 0; n < r->rank_count && code == COMMAND_DONE; n++)
    if (r->ranks[n] != floor(r->ranks[n]) || r->ranks[n] == 1)
      return config_given_wrong(given);
  return code;
}

static int take_dts(const config_given *given, void *request) {
  tradeoff_request *r = request;
  return take_list(given, r->dts, &r->dt_count);
}

static int take_tolerances(const config_given *given, void *request) {
  tradeoff_request *r = request;
  return take_list(given, r->tolerances, &r->tolerance_count);
}

static int take_integrators(const config_given *given, void *request) {
  tradeoff_request *r = request;
  char list[64];
  snprintf(list, sizeof list, "%s", given->text);
  memset(r->integrators, 0, sizeof r->integrators);
  if (strlen(given->text) >= sizeof list)
    return config_given_wrong(given);
  for (char *at = list; at != NULL;) {
    char *comma = strchr(at, ',');
    int index = 0;
    if (comma != NULL)
      *comma = 0;
    while (index < EXPERIMENT_INTEGRATOR_COUNT &&
           strcmp(at, experiment_integrator_names[index]) != 0)
      index++;
    if (index == EXPERIMENT_INTEGRATOR_COUNT)
      return config_given_wrong(given);
    r->integrators[index] = true;
    at = comma != NULL ? comma + 1 : NULL;
  }
  return COMMAND_DONE;
}

static int take_precisions(const config_given *given, void *request) {
  static const char *const lists[] = {"double", "single", "double,single", "single,double", NULL};
  tradeoff_request *r = request;
  const int index = config_name_index(given->text, lists);
  if (index < 0)
    return config_given_wrong(given);
  r->precisions[0] = index != 1;
  r->precisions[1] = index != 0;
  return COMMAND_DONE;
}

/* A number and one of these endings, which scale it; no ending is the first's. */
static bool scaled(const char *text, const char *const *endings, const double *scales,
                   double *value) {
  const size_t length = strlen(text);
  char number[64];
  double scale = scales[0];
  size_t cut = length;
  for (int n = 0; endings[n] != NULL; n++) {
    const size_t size = strlen(endings[n]);
    if (size < length && strcmp(text + length - size, endings[n]) == 0 && length - size < cut) {
      cut = length - size;
      scale = scales[n];
    }
  }
  if (cut >= sizeof number)
    return false;
  memcpy(number, text, cut);
  number[cut] = 0;
  double parsed;
  if (!config_parse_number(number, &parsed) || !(parsed > 0))
    return false;
  *value = scale * parsed;
  return true;
}

static int take_error(const config_given *given, void *request) {
  static const char *const endings[] = {"", "%", NULL};
  static const double scales[] = {1, 0.01};
  tradeoff_request *r = request;
  return scaled(given->text, endings, scales, &r->error) && r->error <= 1
             ? COMMAND_DONE
             : config_given_wrong(given);
}

static int take_budget(const config_given *given, void *request) {
  static const char *const endings[] = {"s", "ms", "us", NULL};
  static const double scales[] = {1, 1e-3, 1e-6};
  tradeoff_request *r = request;
  return scaled(given->text, endings, scales, &r->budget) ? COMMAND_DONE
                                                          : config_given_wrong(given);
}

static int take_damping(const config_given *given, void *request) {
  return config_given_pair(given, ((tradeoff_request *)request)->damping);
}

#define FIELD(member) .field = offsetof(tradeoff_request, member)
#define SECONDS .kind = CONFIG_NUMBER, .most = INFINITY, .above = true, .wants = "seconds above 0"

static const config_option table[] = {
    {.name = "output", .letter = 'o', .kind = CONFIG_TEXT, FIELD(output)},
    CONFIG_OPTIONS_MESH(tradeoff_request),
    {.name = "load", .kind = CONFIG_TEXT, .take = take_load, .repeats = true},
    {.name = "error", .kind = CONFIG_WORD, .take = take_error, .wants = "an error such as 1%"},
    {.name = "budget", .kind = CONFIG_WORD, .take = take_budget, .wants = "a time such as 2ms"},
    {.name = "fps", .kind = CONFIG_NUMBER, FIELD(fps), .most = INFINITY, .above = true},
    {.name = "time", SECONDS, FIELD(time)},
    {.name = "ranks",
     .kind = CONFIG_TEXT,
     .take = take_ranks,
     .most = THRUM_RANK_MAX,
     .wants = "0 or ranks from 2 with commas between"},
    {.name = "dts",
     .kind = CONFIG_TEXT,
     .take = take_dts,
     .least = 1e-6,
     .most = 1,
     .wants = "time steps from 1e-6 to 1 s with commas between"},
    {.name = "tolerances",
     .kind = CONFIG_TEXT,
     .take = take_tolerances,
     .least = 1e-15,
     .most = 0.01,
     .wants = "numbers in (0, 0.01] with commas between"},
    {.name = "integrators",
     .kind = CONFIG_TEXT,
     .take = take_integrators,
     .wants = "imexv, newmark, energy with commas between"},
    {.name = "precisions",
     .kind = CONFIG_TEXT,
     .take = take_precisions,
     .wants = "double, single or double,single"},
    {.name = "damping", .kind = CONFIG_PAIR, .take = take_damping},
    {.name = "full-dt", SECONDS, FIELD(full_dt)},
    {.name = "quick", .kind = CONFIG_FLAG, FIELD(quick)},
    {.name = "threads", .kind = CONFIG_COUNT, FIELD(threads), .least = 1, .most = 256},
    CONFIG_OPTION_JSON(tradeoff_request),
    CONFIG_OPTION_QUIET(tradeoff_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

static void default_list(const double *values, int64_t count, double *list, int64_t *list_count) {
  if (*list_count > 0)
    return;
  memcpy(list, values, (size_t)count * sizeof *values);
  *list_count = count;
}

int tradeoff_options_read(int argc, char **argv, tradeoff_request *r) {
  static const double ranks[] = {0, 6, 10, 20, 30}, quick_ranks[] = {0, 10};
  static const double dts[] = {0.001, 0.002, 0.003, 0.005, 0.01, 1. / 60};
  static const double quick_dts[] = {0.003, 0.01, 1. / 60};
  static const double tolerances[] = {1e-10, 1e-6, 1e-3}, quick_tolerances[] = {1e-6};
  r->mesh_def = cli_default_mesh_def();
  r->error = r->budget = NAN;
  r->fps = FPS_DEFAULT;
  r->threads = 1;
  for (int n = 0; n < EXPERIMENT_INTEGRATOR_COUNT; n++)
    r->integrators[n] = true;
  int code = config_options_read("tradeoff", table, argc, argv, r);
  if (code != COMMAND_DONE)
    return code;
  code = config_one_argument("tradeoff", "model", argc, argv, &r->model_path);
  if (code != COMMAND_DONE)
    return code;
  code = cli_mesh_def_check("tradeoff", &r->mesh_def, thrum_mesh_is_named(r->model_path));
  if (code != COMMAND_DONE)
    return code;
  if (r->output == NULL || r->output[0] == 0)
    return config_usage("tradeoff", "where to? name a folder with -o DIR");
  if (isnan(r->error) && isnan(r->budget))
    r->error = ERROR_DEFAULT;
  // a coarse answer needs no more than one
  if (!r->precisions[0] && !r->precisions[1]) {
    r->precisions[0] = true;
    r->precisions[1] = !r->quick;
  }
  r->time = r->time > 0 ? r->time : r->quick ? 0.5 : 1;
  r->full_dt = r->full_dt > 0 ? r->full_dt : r->quick ? 0.002 : 0.001;
  default_list(r->quick ? quick_ranks : ranks, r->quick ? 2 : 5, r->ranks, &r->rank_count);
  default_list(r->quick ? quick_dts : dts, r->quick ? 3 : 6, r->dts, &r->dt_count);
  default_list(r->quick ? quick_tolerances : tolerances, r->quick ? 1 : 3, r->tolerances,
               &r->tolerance_count);
  return COMMAND_DONE;
}
