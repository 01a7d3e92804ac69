/* Options of `thrum static`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "driver/load_option.h"
#include "driver/static_full.h"

#define FACTOR_MAX 1e12

static void print_help(void) {
  fputs(
      "usage: thrum static MODEL --load LOAD [OPTIONS]\n\n"
      "Finds where a body comes to rest under a load: the equilibrium of the reduced model. The\n"
      "load grows in steps from nothing; where the body buckles or snaps through on the way,\n"
      "the factor of the load at which it does is its critical load, and the body is followed to\n"
      "the stable shape that it falls to. MODEL is a model file or one of the models that come\n"
      "with Thrum.\n\n"
      "      --load LOAD      as of `thrum simulate`, at its full strength (a sine's amplitude);\n"
      "                       when it acts plays no part; repeatable, the loads act together\n"
      "      --factor F       so many times the loads (default 1)\n"
      "      --at TARGET      show the mean displacement of a group, vertex=N or all; repeatable\n"
      "                       (default: where the loads act)\n"
      "      --stay           where the body would buckle, stay on the path, unstable\n"
      "      --tolerance T    of the residual relative to the load (default 1e-10)\n"
      "      --rank N         the lowest N coordinates only (default: all of the model)\n"
      "      --full           of the whole mesh, unreduced; MODEL may then be a mesh\n"
      "      --fix, --young, --poisson, --density\n"
      "                       of such a mesh, as of precompute\n"
      "      --move X,Y,Z@TARGET  of --full: bring a group, vertex=N or all to this displacement\n"
      "                       [m] and hold it there; repeatable\n"
      "      --solver NAME    of --full: cholesky (default), or cg, conjugate gradients\n"
      "  -o, --output FILE    write q as .npy, which `thrum simulate --start FILE` takes\n"
      "      --vtu FILE       write the deformed body for ParaView\n"
      "      --path FILE      write the path as .csv: load, energy, stiffness, displacements\n"
      "      --options FILE.json  read options from a file (docs/options.md); those given here "
      "come first\n"
      "      --json           print one JSON object instead of the table\n"
      "  -q, --quiet          no progress of a model that is made first\n"
      "  -h, --help           this text\n\n"
      "`thrum simulate --start static:LOAD` begins a run from such an equilibrium.\n\n"
      "examples:\n"
      "  thrum static beam.npz --load gravity:0,0,-9.81 -o sag.npy\n"
      "  thrum static beam.npz --load constant:-100,0,0@tip --factor 5 --path column.csv\n"
      "  thrum static bridge --load gravity:0,0,-9.81 --at load --json\n\n"
      "exit codes: 0 done, 1 refused, 2 usage, 3 found but flagged (buckled, snapped, unstable)\n",
      stdout);
}

static int take_load(const config_given *given, void *request) {
  static_request *r = request;
  return cli_load_take(given, r->loads, &r->load_count);
}

static int take_at(const config_given *given, void *request) {
  static_request *r = request;
  thrum_error error = {0};
  if (cli_target_parse(given->text, "--at", &r->targets[r->target_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->at[r->target_count++] = given->text;
  return COMMAND_DONE;
}

static int take_move(const config_given *given, void *request) {
  static_request *r = request;
  thrum_error error = {0};
  if (static_move_parse(given->text, &r->moves[r->move_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->move_count++;
  return COMMAND_DONE;
}

static const char *const solvers[] = {"cholesky", "cg", NULL};

static void choose_solver(void *request, int index) {
  ((static_request *)request)->solver = (thrum_full_solver)index;
}

static int take_stay(const config_given *given, void *request) {
  (void)given;
  ((static_request *)request)->def.stay = 1;
  return COMMAND_DONE;
}

#define FIELD(member) .field = offsetof(static_request, member)
#define WRITTEN .kind = CONFIG_TEXT, .path = CONFIG_PATH_ALWAYS

const config_option static_options_table[] = {
    {.name = "model",
     .kind = CONFIG_TEXT,
     .argument = true,
     .path = CONFIG_PATH_NAMED,
     FIELD(model_path)},
    CONFIG_OPTION_FILE(static_request),
    {.name = "load", .kind = CONFIG_TEXT, .repeats = true, .take = take_load},
    {.name = "factor", .kind = CONFIG_NUMBER, FIELD(def.factor), .most = FACTOR_MAX, .above = true},
    {.name = "at", .kind = CONFIG_TEXT, .repeats = true, .take = take_at},
    {.name = "stay", .kind = CONFIG_FLAG, .take = take_stay},
    {.name = "tolerance",
     .kind = CONFIG_NUMBER,
     FIELD(def.tolerance),
     .most = 0.01,
     .above = true,
     .wants = "a number in (0, 0.01]"},
    {.name = "rank", .kind = CONFIG_COUNT, FIELD(rank), .least = 1, .most = THRUM_RANK_MAX},
    {.name = "full", .kind = CONFIG_FLAG, FIELD(full)},
    CONFIG_OPTIONS_MESH(static_request),
    {.name = "move", .kind = CONFIG_TEXT, .repeats = true, .take = take_move},
    {.name = "solver", .kind = CONFIG_CHOICE, .names = solvers, .choose = choose_solver},
    {.name = "output", .letter = 'o', WRITTEN, FIELD(output)},
    {.name = "vtu", WRITTEN, FIELD(frame)},
    {.name = "path", WRITTEN, FIELD(path)},
    CONFIG_OPTION_JSON(static_request),
    CONFIG_OPTION_QUIET(static_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

static bool same_target(const cli_target *a, const cli_target *b) {
  return a->all == b->all && a->vertex == b->vertex && strcmp(a->group, b->group) == 0;
}

/* Where the loads act, when nobody says what to show. */
static void default_targets(static_request *request) {
  for (int64_t n = 0; n < request->load_count; n++) {
    const char *at = strchr(request->loads[n].text, '@');
    bool seen = at == NULL;
    for (int64_t k = 0; k < request->target_count && !seen; k++)
      seen = same_target(&request->targets[k], &request->loads[n].target);
    if (seen)
      continue;
    const cli_target *target = &request->loads[n].target;
    request->targets[request->target_count] = *target;
    request->at[request->target_count++] = target->all             ? "all"
                                           : target->group[0] != 0 ? target->group
                                                                   : at + 1;
  }
}

static bool ends_with(const char *text, const char *end) {
  const size_t length = strlen(text), wanted = strlen(end);
  return length > wanted && strcmp(text + length - wanted, end) == 0;
}

static int check_names(const static_request *request) {
  if (request->output != NULL && !ends_with(request->output, ".npy"))
    return config_usage("static", "-o wants the name of an .npy file, not '%s'", request->output);
  if (request->frame != NULL && !ends_with(request->frame, ".vtu"))
    return config_usage("static", "--vtu wants the name of a .vtu file, not '%s'", request->frame);
  if (request->path != NULL && !ends_with(request->path, ".csv"))
    return config_usage("static", "--path wants the name of a .csv file, not '%s'", request->path);
  return COMMAND_DONE;
}

int static_options_read(int argc, char **argv, static_request *request) {
  request->def = thrum_default_equilibrium_def();
  request->mesh_def = cli_default_mesh_def();
  int code = config_options_read("static", static_options_table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  code = config_one_argument("static", "model", argc, argv, &request->model_path);
  if (code != COMMAND_DONE)
    return code;
  code = cli_mesh_full_check("static", request->model_path, &request->mesh_def, request->full);
  if (code != COMMAND_DONE)
    return code;
  if (request->move_count > 0 && !request->full)
    return config_usage("static",
                        "--move goes with --full: a model's basis holds still what is held");
  if (request->full && (request->def.stay || request->path != NULL))
    return config_usage("static", "--%s is of a reduced model; leave it out with --full",
                        request->def.stay ? "stay" : "path");
  if (request->load_count == 0 && request->move_count == 0)
    return config_usage("static", "under which load? such as --load gravity:0,0,-9.81");
  if (request->target_count == 0)
    default_targets(request);
  return check_names(request);
}
