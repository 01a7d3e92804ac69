/* Options of `thrum response`. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_options.h"

#include <string.h>

#include "config/message.h"
#include "driver/spec/model_names.h"
#include "driver/spec/shared_options.h"
#include "thrum/response.h"

#define HERTZ_MAX 1e12
#define CHECK_ERROR 0.05 /* of the largest displacement */

static thrum_status take_load(const config_given *given, void *request) {
  response_request *r = request;
  thrum_error error = {0};
  if (response_load_parse(given->text, &r->loads[r->load_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->load_count++;
  return THRUM_OK;
}

static thrum_status take_base(const config_given *given, void *request) {
  response_request *r = request;
  thrum_error error = {0};
  if (response_base_parse(given->text, &r->loads[r->load_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->load_count++;
  return THRUM_OK;
}

static thrum_status take_at(const config_given *given, void *request) {
  response_request *r = request;
  thrum_error error = {0};
  if (load_target_parse(given->text, "--at", &r->targets[r->target_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->at[r->target_count++] = given->text;
  return THRUM_OK;
}

static thrum_status take_start(const config_given *given, void *request) {
  response_request *r = request;
  THRUM_TRY(config_given_count(given, &r->starts[r->start_count]));
  r->start_count++;
  return THRUM_OK;
}

/* auto, or a number. */
static thrum_status take_harmonics(const config_given *given, void *request) {
  response_request *r = request;
  if (given->text != NULL && strcmp(given->text, "auto") == 0) {
    r->harmonics = 0;
    return THRUM_OK;
  }
  return config_given_count(given, &r->harmonics);
}

/* none, or how many coordinates are stepped. */
static thrum_status take_condense(const config_given *given, void *request) {
  response_request *r = request;
  if (given->text != NULL && strcmp(given->text, "none") == 0) {
    r->condense = 0;
    return THRUM_OK;
  }
  return config_given_count(given, &r->condense);
}

static thrum_status take_damping(const config_given *given, void *request) {
  return damping_spec_take_rayleigh(given, &((response_request *)request)->damping);
}

static thrum_status take_ratios(const config_given *given, void *request) {
  return damping_spec_take_ratios(given, &((response_request *)request)->damping);
}

static thrum_status take_quality(const config_given *given, void *request) {
  return damping_spec_take_quality(given, &((response_request *)request)->damping);
}

static thrum_status take_check_error(const config_given *given, void *request) {
  return error_option_take(given, &((response_request *)request)->check_error);
}

#define AT(member) CONFIG_AT(response_request, member)

static const config_option options[] = {
    OPTION_TEXT("model", "MODEL", NULL, "the model", .argument = true, .path = CONFIG_PATH_NAMED,
                .is_name = is_model_name_or_spec, AT(model_path)),
    OPTION_TEXT("output", "FOLDER", "nothing is written",
                "response.csv, response.json, coefficients.npy, motions.npy and a plot; thrum view "
                "shows it",
                .letter = 'o', .path = CONFIG_PATH_ALWAYS, AT(output)),

    // what drives the body, or nothing
    OPTION_COUNT("mode", NULL,
                 "the backbone of mode K: free motion without damping, by amplitude; in place of "
                 "a load",
                 .value = "K", AT(mode), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_TEXT("load", "LOAD", NULL,
                "the curve under sine:X,Y,Z@TARGET[,phase=DEGREES], a force in newtons; several "
                "swing together; constant:, gravity: and traction: are always there",
                .repeats = true, .take = take_load),
    OPTION_TEXT("base-motion", "sine:AX,AY,AZ", NULL,
                "the curve under an acceleration of what holds the body, with [,phase=DEGREES]",
                .unit = "m/s^2", .repeats = true, .take = take_base),
    OPTION_NUMBER("from", "Hz", "0.8 of the first mode; 0.5 of the backbone's",
                  "frequency at which the curve begins; a backbone ends where it leaves the range",
                  AT(from), CONFIG_RANGE(0, HERTZ_MAX), .above = true),
    OPTION_NUMBER("to", "Hz", "1.2 of the first mode; 2 of the backbone's",
                  "frequency at which it ends, also below", AT(to), CONFIG_RANGE(0, HERTZ_MAX),
                  .above = true),
    OPTION_DAMPING(.take = take_damping),
    OPTION_DAMPING_RATIO(take_ratios),
    OPTION_QUALITY(take_quality),

    // where the answer is read off, and how well it is found
    OPTION_TEXT("at", "TARGET", "where the loads act; the vertex that moves furthest",
                "show the mean displacement of a TARGET", .repeats = true, .take = take_at),
    OPTION_WORD("harmonics", "N", "auto",
                "harmonics of the motion; auto: as many as it takes for the last two to have less "
                "than 1e-6 of the kinetic energy",
                .take = take_harmonics, CONFIG_RANGE(1, THRUM_RESPONSE_HARMONICS_MAX),
                .wants = "auto, or a whole number from 1 to 64",
                .schema =
                    "{\"anyOf\":[{\"const\":\"auto\"},{\"type\":\"integer\",\"minimum\":1}]}"),
    OPTION_COUNT("periods", "1",
                 "periods of the load in one of the motion: with 2, period doublings are branch "
                 "points, and half of the harmonics lie between those of the load",
                 AT(periods), CONFIG_RANGE(1, THRUM_RESPONSE_HARMONICS_MAX)),
    OPTION_COUNT("branch", NULL,
                 "at branch point N of the curve go on along the other curve through it",
                 .value = "N", AT(branch), CONFIG_RANGE(1, 1000)),
    OPTION_FLAG("other-side", "to the other side of it", AT(other_side)),
    OPTION_WORD("condense", "N", "8 modes at most, where the basis has all their derivatives",
                "let the lowest N coordinates move and the others follow them at rest; none: all "
                "move",
                .take = take_condense, CONFIG_RANGE(1, THRUM_RANK_MAX),
                .wants = "none, or a whole number from 1",
                .schema =
                    "{\"anyOf\":[{\"const\":\"none\"},{\"type\":\"integer\",\"minimum\":1}]}"),
    OPTION_SWITCH("follower-inertia", "on",
                  "whether what follows has inertia and damping as it does; off: as in runs of "
                  "thrum simulate --condense",
                  AT(followers)),
    OPTION_NUMBER("amplitude", "m", "the longest side of the body",
                  "largest displacement at the first TARGET at which a backbone ends",
                  AT(amplitude), CONFIG_ABOVE(0)),
    OPTION_SWITCH("stability", "on", "whether each motion is stable, and where that changes",
                  AT(stability)),
    OPTION_COUNT("stability-steps", "6 a harmonic, and 48 at least",
                 "steps a period in which that is found, more where something is unstable",
                 AT(stability_steps), CONFIG_RANGE(1, 100000)),
    OPTION_NUMBER("step", NULL, "0.05",
                  "longest step along the curve, of the range of frequencies or of the largest "
                  "motion so far",
                  AT(step), CONFIG_RANGE(0, 1), .above = true),
    OPTION_COUNT("points", "2000", "of the curve, at most", AT(points_max),
                 CONFIG_RANGE(2, 1000000)),
    OPTION_NUMBER("tolerance", NULL, "1e-12", "of the residual, relative to the motion",
                  AT(tolerance), CONFIG_RANGE(0, 1e-3), .above = true),
    OPTION_COUNT("start", NULL,
                 "write the motion of this row of response.csv as point_N.npy, from which thrum "
                 "simulate --start goes on",
                 .value = "N", .repeats = true, .take = take_start, CONFIG_RANGE(1, 1000000)),

    OPTION_TEXT("start-from", "FILE.npy", NULL,
                "begin the forced curve at --from with the motion near this state, a point of "
                "--start or the end of a run of whole periods: an upper branch, or a curve that "
                "closes on itself",
                .path = CONFIG_PATH_ALWAYS, AT(start_from)),
    OPTION_COUNT(
        "check", "3, or as many as take some seconds",
        "step the unreduced mesh for a period from so many motions of the curve, and say how "
        "far it ends from where it began",
        AT(check), CONFIG_RANGE(0, 16)),
    OPTION_FLAG("no-check", "do not step the mesh", AT(no_check)),
    OPTION_WORD("check-error", "E", "5%", "by which it may miss, of its largest displacement",
                .take = take_check_error, .wants = "a number up to 1, or a percentage"),
    OPTION_FILE(response_request),
    OPTION_JSON(response_request),
    OPTION_QUIET(response_request),
    OPTION_HELP_TWICE,
    OPTION_END,
};

const config_command command_response = {
    .name = "response",
    .summary = "find periodic motions: backbone curves, frequency response, stability",
    .usage = "MODEL --load sine:X,Y,Z@TARGET [OPTIONS]\nMODEL --mode K [OPTIONS]",
    .about =
        "Finds the periodic motions of a body: under loads of one frequency, which goes from "
        "--from "
        "to --to (the frequency response), or of one mode without load and damping, by amplitude "
        "(its backbone). The curve is followed through its folds; each motion is stable or not, "
        "and folds, period doublings and Neimark-Sacker points are named. MODEL is a model file "
        "or one of the models that come with Thrum.",
    .options = options,
    .often = "output mode load from to damping-ratio at harmonics check start",
    .notes = "response.csv has a row for each motion: its frequency, energy, work and stability, "
             "and of each\n"
             "TARGET the largest displacement, then of each harmonic k and axis the amplitude [m] "
             "and the\n"
             "phase [degrees] ahead of sin(k Omega t). The load is sin(Omega t); with --periods N\n"
             "harmonic k is that of k Omega / N.\n",
    .examples =
        "response panel.npz --mode 1 -o backbone\n"
        "response panel.npz --load sine:0,0,10@load --damping-ratio 0.002 --from 20 --to 26 "
        "-o forced\n"
        "response panel.npz --load sine:0,0,10@load --damping-ratio 0.002 --periods 2 --branch 1\n"
        "response panel.npz --base-motion sine:0,0,2 --q 500 --from 26 --to 20 --json",
    .exits = "0 done, 1 refused, 2 usage, 3 found but flagged (status: lost on the way, points as "
             "many as allowed, stopped, coarse by too few harmonics, unbranched, or missed by the "
             "mesh)",
};

/* Shows the displacements where the loads act, when no target is given. */
static void default_targets(response_request *request) {
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n].spec;
    bool seen = request->loads[n].base || load->gravity;
    for (int64_t k = 0; k < request->target_count && !seen; k++)
      seen = load_target_equal(&request->targets[k], &load->target);
    if (seen)
      continue;
    request->targets[request->target_count] = load->target;
    request->at[request->target_count++] = load->target.all            ? "all"
                                           : load->target.name[0] != 0 ? load->target.name
                                                                       : request->loads[n].vertex;
  }
}

int response_options_read(int argc, char **argv, response_request *request) {
  // the request begins with zeros, where these defaults are others
  const thrum_response_def usual = thrum_default_response_def();
  request->condense = -1;
  request->amplitude = INFINITY;
  request->step = usual.step;
  request->tolerance = usual.tolerance;
  request->points_max = usual.points;
  request->stability = true;
  request->check = -1;
  request->periods = 1;
  request->check_error = CHECK_ERROR;
  request->followers = true;
  CONFIG_TRY(config_options_read_one(&command_response, "model", argc, argv, request,
                                     &request->model_path));

  if (request->no_check && request->check > 0)
    return config_usage("response", "--check and --no-check exclude each other");
  if (request->no_check)
    request->check = 0;

  // a curve is free or forced
  bool swings = false;
  for (int64_t n = 0; n < request->load_count; n++)
    swings = swings || request->loads[n].swings;
  if (request->mode == 0 && !swings)
    return config_usage("response", "which curve? --load sine:X,Y,Z@TARGET is forced, --mode K is "
                                    "free");
  if (request->mode > 0 && request->load_count > 0)
    return config_usage("response", "--mode is a free motion: leave out the loads");
  if (request->mode > 0 && damping_spec_given(&request->damping))
    return config_usage("response", "--mode is a motion without damping: leave out %s",
                        request->damping.by_quality        ? "--q"
                        : request->damping.ratio_count > 0 ? "--damping-ratio"
                                                           : "--damping");
  if (request->mode == 0 && isfinite(request->amplitude))
    return config_usage("response", "--amplitude is of a backbone, --mode K");
  if (request->from > 0 && request->from == request->to)
    return config_usage("response", "--from and --to are both %g Hz", request->to);
  if (request->start_from != NULL && (request->mode > 0 || request->from == 0))
    return config_usage("response", "--start-from is of a forced curve, and goes with --from, the "
                                    "frequency of that motion");
  if (request->mode > 0 && request->periods > 1)
    return config_usage("response", "--periods is of a load, and --mode is a free motion");
  if (request->harmonics > 0 && request->harmonics < request->periods)
    return config_usage("response",
                        "--harmonics %lld: the load alone has harmonic %lld, as many as "
                        "--periods",
                        (long long)request->harmonics, (long long)request->periods);
  if (request->other_side && request->branch == 0)
    return config_usage("response", "--other-side is of a --branch");
  if (request->start_count > 0 && request->output == NULL)
    return config_usage("response", "--start writes into a folder: name it with -o");
  request->target_given = request->target_count;
  if (request->target_count == 0)
    default_targets(request);
  return COMMAND_DONE;
}
