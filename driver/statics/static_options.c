/* Options of `thrum static`. SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "driver/spec/shared_options.h"
#include "driver/statics/static_options.h"

#define FACTOR_MAX 1e12

static thrum_status take_actuate(const config_given *given, void *request) {
  static_request *r = request;
  return actuate_option_take(given, r->actuates, &r->actuate_count);
}

static thrum_status take_load(const config_given *given, void *request) {
  static_request *r = request;
  return load_option_take(given, r->loads, &r->load_count);
}

static thrum_status take_at(const config_given *given, void *request) {
  static_request *r = request;
  thrum_error error = {0};
  if (load_target_parse(given->text, "--at", &r->targets[r->target_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->at[r->target_count++] = given->text;
  return THRUM_OK;
}

const char *const static_move_names[STATIC_MOVE_KINDS] = {"move", "rotate", "follow", "moment"};
static const char *const move_wants[STATIC_MOVE_KINDS] = {
    "metres that a group is brought to", "an axis times the degrees that a group is turned by",
    "newtons that turn with a group", "newton metres that turn with a group"};

/* X,Y,Z@TARGET */
static thrum_status parse_move(const char *text, static_move_kind kind, static_move *move,
                               thrum_error *error) {
  static_move parsed = {.kind = kind, .text = text};
  const char *option = static_move_names[kind];
  char vector[128], said[LOAD_TEXT_MAX];
  const char *at = strchr(text, '@');
  const size_t length = at != NULL ? (size_t)(at - text) : sizeof vector;
  if (length < sizeof vector) {
    memcpy(vector, text, length);
    vector[length] = 0;
  }

  // the target is named as those of loads are
  if (length >= sizeof vector || !config_parse_vector3(vector, parsed.by))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "--%s '%.200s': it is X,Y,Z@TARGET, %s",
                           option, text, move_wants[kind]);
  snprintf(said, sizeof said, "--%s '%.200s'", option, text);
  THRUM_TRY(load_target_parse(at + 1, said, &parsed.target, error));
  *move = parsed;
  return THRUM_OK;
}

/* The row says which kind it is. */
static thrum_status take_move(const config_given *given, void *request) {
  static_request *r = request;
  const static_move_kind kind = (static_move_kind)given->option->set;
  thrum_error error = {0};
  if (parse_move(given->text, kind, &r->moves[r->move_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->move_count++;
  return THRUM_OK;
}

static thrum_status take_accepted(const config_given *given, void *request) {
  return error_option_take(given, &((static_request *)request)->basis.accepted);
}

#define AT(member) CONFIG_AT(static_request, member)
#define WRITTEN(member) .path = CONFIG_PATH_ALWAYS, AT(member)
#define MOVED(kind) .take = take_move, .set = kind

static const config_option options[] = {
    OPTION_TEXT("model", "MODEL", NULL, "the model", .argument = true, .path = CONFIG_PATH_NAMED,
                .is_name = is_model_name_or_spec, AT(model_path)),
    OPTION_LOAD(take_load, NULL,
                "as of thrum simulate, at its full strength (a sine's amplitude); when it acts "
                "plays no part; the loads act together"),

    OPTION_ACTUATE(take_actuate,
                   "the level of an actuator, as of thrum simulate, at its full strength; the "
                   "levels grow with the load, so that the path is one in pressure"),

    // how far the load goes, and where the answer is read off
    OPTION_NUMBER("factor", NULL, "1", "so many times the loads", AT(def.factor),
                  CONFIG_RANGE(0, FACTOR_MAX), .above = true),
    OPTION_TEXT("at", "TARGET", "where the loads act", "show the mean displacement of a TARGET",
                .repeats = true, .take = take_at),
    OPTION_FLAG("stay", "where the body would buckle, stay on the path, unstable", AT(def.stay)),
    OPTION_NUMBER("tolerance", NULL, "1e-10", "of the residual relative to the load",
                  AT(def.tolerance), CONFIG_RANGE(0, 0.01), .above = true),
    OPTION_COUNT(
        "rank", "all of the model",
        "all coordinates of the model: fewer are refused, for a body whose coordinates are cut off "
        "is too stiff; precompute it at that rank",
        AT(rank), CONFIG_RANGE(1, THRUM_RANK_MAX)),

    OPTION_TEXT(
        "from", "FILE.npy", "at rest",
        "go on from this equilibrium, q of -o or the field of --displacements, to the loads "
        "given here; the factor then counts from 0 to 1 on that way",
        .path = CONFIG_PATH_ALWAYS, AT(from)),
    OPTION_SWITCH(
        "monitor", "on",
        "warn of compression beyond what the model can be believed for, of a basis that cannot "
        "bend so far, and of a moved body that has a shape of less energy; changes no result",
        AT(monitor)),
    OPTION_ACCEPT_ERROR("accept-error", take_accepted),
    OPTION_JUDGE(static_request, basis),

    OPTION_HEADING("the full order"),
    OPTION_FLAG("full", "of the whole mesh, unreduced; MODEL may then be a mesh", AT(full)),
    OPTION_GROUP(mesh_options, "", AT(mesh_def)),
    OPTION_TEXT("move", "X,Y,Z@TARGET", NULL,
                "bring a TARGET to this displacement and hold it there", .unit = "m",
                .repeats = true, MOVED(STATIC_MOVE)),
    OPTION_TEXT(
        "rotate", "X,Y,Z@TARGET", NULL,
        "turn a group as a rigid whole about the mean of its vertices, by axis times angle, "
        "and hold it there; the mean stays, or goes where --move says",
        .unit = "degrees", .repeats = true, MOVED(STATIC_ROTATE)),
    OPTION_TEXT("moment", "X,Y,Z@TARGET", NULL, "a moment on a group that turns with it",
                .unit = "N m", .repeats = true, MOVED(STATIC_MOMENT)),
    OPTION_TEXT("follow", "X,Y,Z@TARGET", NULL,
                "a force on a group, shared equally, that turns with it", .unit = "N",
                .repeats = true, MOVED(STATIC_FOLLOW)),
    OPTION_CHOICE("linear-solver", full_solver_names, "cholesky",
                  "how its linear systems are solved; cg is conjugate gradients", AT(solver)),
    OPTION_CHOICE("quadrature", full_quadrature_names, "exact",
                  "points at which forces of ten-node tetrahedra are taken: those that are exact, "
                  "or four, as other programs take them",
                  AT(quadrature)),
    OPTION_FULL_LAW(static_request),

    OPTION_HEADING("what is written"),
    OPTION_TEXT("output", "FILE.npy", NULL, "q, which thrum simulate --start FILE.npy takes",
                .letter = 'o', WRITTEN(output)),
    OPTION_TEXT("displacements", "FILE.npy", NULL,
                "the displacements of all vertices, which --from takes", .unit = "m",
                WRITTEN(field)),
    OPTION_TEXT("vtu", "FILE.vtu", NULL, "the deformed body for ParaView", WRITTEN(frame)),
    OPTION_TEXT("path", "FILE.csv", NULL,
                "the path: load, energy, stiffness, displacements; of the mesh with --full",
                WRITTEN(path)),

    OPTION_TEXT("reactions", "FILE.csv", NULL, "the force that holds each held or moved vertex",
                .unit = "N", WRITTEN(reactions)),

    OPTION_FILE(static_request),
    OPTION_JSON(static_request),
    OPTION_QUIET(static_request),
    OPTION_HELP_TWICE,
    OPTION_END,
};

const config_command command_static = {
    .name = "static",
    .summary = "find where a body comes to rest under a load",
    .usage = "MODEL --load LOAD [OPTIONS]",
    .about =
        "Finds where a body comes to rest under a load: the equilibrium of the reduced model. The "
        "load grows in steps from nothing; where the body buckles or snaps through on the way, "
        "the factor of the load at which it does is its critical load, and the body is followed "
        "to the stable shape that it falls to. MODEL is a model file or one of the models that "
        "come with Thrum.",
    .options = options,
    .often = "load factor at full move vtu",
    .notes = "thrum simulate --start static:LOAD begins a run from such an equilibrium.\n",
    .examples = "static beam.npz --load gravity:0,0,-9.81 -o sag.npy\n"
                "static beam.npz --load constant:-100,0,0@tip --factor 5 --path column.csv\n"
                "static beam.npz --full --moment 0,-20,0@tip --displacements bent.npy\n"
                "static bridge --load gravity:0,0,-9.81 --at load --json",
    .exits = "0 done, 1 refused, 2 usage, 3 found but flagged (buckled, snapped, unstable, higher, "
             "lost, inverted, basis_wrong)",
};

/* Shows the displacements where the loads act, when no target is given. */
static void default_targets(static_request *request) {
  for (int64_t n = 0; n < request->load_count; n++) {
    // gravity has no target, and a target is shown once
    const char *at = strchr(request->loads[n].text, '@');
    bool seen = at == NULL;
    for (int64_t k = 0; k < request->target_count && !seen; k++)
      seen = load_target_equal(&request->targets[k], &request->loads[n].target);
    if (seen)
      continue;

    // it is named as the user named it
    const load_target *target = &request->loads[n].target;
    request->targets[request->target_count] = *target;
    request->at[request->target_count++] = target->all            ? "all"
                                           : target->name[0] != 0 ? target->name
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
  if (request->field != NULL && !ends_with(request->field, ".npy"))
    return config_usage("static", "--displacements wants the name of an .npy file, not '%s'",
                        request->field);
  if (request->frame != NULL && !ends_with(request->frame, ".vtu"))
    return config_usage("static", "--vtu wants the name of a .vtu file, not '%s'", request->frame);
  if (request->reactions != NULL && !ends_with(request->reactions, ".csv"))
    return config_usage("static", "--reactions wants the name of a .csv file, not '%s'",
                        request->reactions);
  if (request->path != NULL && !ends_with(request->path, ".csv"))
    return config_usage("static", "--path wants the name of a .csv file, not '%s'", request->path);
  return COMMAND_DONE;
}

int static_options_read(int argc, char **argv, static_request *request) {
  // the request begins with zeros, where these defaults are others
  request->def = thrum_default_equilibrium_def();
  request->mesh_def = mesh_model_def_default();
  request->monitor = true;
  request->basis.accepted = BASIS_ACCEPTED;
  CONFIG_TRY(
      config_options_read_one(&command_static, "model", argc, argv, request, &request->model_path));
  CONFIG_TRY(mesh_model_full_check("static", request->model_path, &request->mesh_def, request->full,
                                   request->law_given));

  // some options belong to the full order, others to reduced models
  if (request->move_count > 0 && !request->full)
    return config_usage("static", "--%s goes with --full: a model's basis %s",
                        static_move_names[request->moves[0].kind],
                        request->moves[0].kind <= STATIC_ROTATE
                            ? "holds still what is held"
                            : "does not know how a group turns");
  if (request->law_given && !request->full)
    return config_usage("static", "--law goes with --full: a model has its own (precompute --law)");
  if (request->full && request->def.stay)
    return config_usage("static", "--stay is of a reduced model; leave it out with --full");

  // something must act on the body; the targets of its loads are shown unless others are named
  if (request->load_count == 0 && request->move_count == 0 && request->actuate_count == 0)
    return config_usage("static", "under which load? such as --load gravity:0,0,-9.81");
  if (request->target_count == 0)
    default_targets(request);

  // of a model only q needs more than the mesh, and two modes that a search for less energy takes
  request->mesh_def.whole = request->full && request->output == NULL && request->from == NULL;
  return check_names(request);
}
