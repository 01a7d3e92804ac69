/* Options of `thrum identify`. SPDX-License-Identifier: Apache-2.0 */
#include "driver/identify/identify_options.h"

#include <getopt.h>
#include <string.h>

#include "config/message.h"
#include "driver/spec/model_names.h"
#include "driver/spec/shared_options.h"
#include "thrum/model.h"

static thrum_status take_start(const config_given *given, void *request) {
  identify_request *r = request;
  thrum_error error = {0};
  if (start_spec_parse(given->text, &r->starts[r->start_count], &error) < 0)
    return config_given_refuse(given, "%s", error.message);
  r->start_count++;
  return THRUM_OK;
}

/* A list of what is fitted, with commas between. */
static thrum_status take_parameters(const config_given *given, void *request) {
  identify_request *r = request;
  r->young = r->poisson = r->density = false;
  r->ratio = r->alpha = r->beta = r->start = false;
  const struct {
    const char *name;
    bool *wanted;
  } known[] = {{"E", &r->young},         {"nu", &r->poisson},
               {"density", &r->density}, {"damping-ratio", &r->ratio},
               {"alpha", &r->alpha},     {"beta", &r->beta},
               {"start", &r->start}};
  bool any = false;
  for (const char *at = given->text; at != NULL && *at != 0;) {
    const size_t length = strcspn(at, ",");
    bool found = false;
    for (size_t n = 0; n < sizeof known / sizeof known[0]; n++)
      if (strlen(known[n].name) == length && strncmp(at, known[n].name, length) == 0)
        any = found = *known[n].wanted = true;
    if (!found)
      return config_given_wrong(given);
    at += length + (at[length] == ',' ? 1 : 0);
  }
  r->parameters = given->text;
  return any ? THRUM_OK : config_given_wrong(given);
}

static thrum_status take_damping(const config_given *given, void *request) {
  return damping_spec_take_rayleigh(given, &((identify_request *)request)->damping);
}

static thrum_status take_ratios(const config_given *given, void *request) {
  return damping_spec_take_ratios(given, &((identify_request *)request)->damping);
}

#define AT(member) CONFIG_AT(identify_request, member)

static const config_option options[] = {
    OPTION_TEXT("output", "FOLDER", "nothing is written", "identify.json, fit.csv and a plot",
                .letter = 'o', .path = CONFIG_PATH_ALWAYS, AT(output)),

    // what is fitted, and from where
    OPTION_WORD(
        "parameters", "LIST", "E,damping-ratio",
        "what is fitted: E, nu and density of each region, damping-ratio, alpha, beta of "
        "--damping, "
        "start",
        .take = take_parameters,
        .wants =
            "some of E, nu, density, damping-ratio, alpha, beta and start, with commas between",
        .schema = "{\"type\":\"string\"}"),
    OPTION_COUNT("ratios", "1",
                 "damping ratios that are fitted: of so many modes, the last one that of all "
                 "beyond",
                 AT(ratio_count), CONFIG_RANGE(1, DAMPING_RATIOS_MAX)),
    OPTION_COUNT("start-modes", "3", "of a start that is fitted: the lowest coordinates, q and p",
                 AT(start_modes), CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_TEXT("start", "START", "at rest",
                "the motion at time 0: mode:K,AMPLITUDE, static:LOAD with the model's own moduli, "
                "or a file .npy; several add up",
                .repeats = true, .take = take_start),
    OPTION_DAMPING(.take = take_damping),
    OPTION_DAMPING_RATIO(take_ratios),

    // how
    OPTION_NUMBER("dt", "s", "1000 steps in a period of the first mode, and each row in a step",
                  "time step", AT(dt), CONFIG_ABOVE(0)),
    OPTION_COUNT("iterations", "40", "of the fit, in each of its windows at most", AT(iterations),
                 CONFIG_RANGE(1, 10000)),
    OPTION_FILE(identify_request),
    OPTION_JSON(identify_request),
    OPTION_QUIET(identify_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_identify = {
    .name = "identify",
    .summary = "find moduli, damping and start from a recorded motion",
    .usage = "MODEL RECORDING.csv [OPTIONS]",
    .about =
        "Fits a model to a recorded free motion, such as a ring-down, by least squares: Young's "
        "modulus, Poisson's ratio and density of each region, damping ratios, Rayleigh damping, "
        "and "
        "the start. Each comes with an interval of confidence. RECORDING.csv begins with a line of "
        "names: time_s, and "
        "TARGET.x_m, TARGET.y_m or TARGET.z_m for the mean displacement of a TARGET [m], as the "
        "probes.csv of thrum simulate has them; other columns are passed over.",
    .options = options,
    .notes = "The fit begins with the first two periods and takes in twice as many each time. "
             "Intervals are those\n"
             "of 95 % where the errors of the rows are independent and alike. A free motion shows "
             "E over the\n"
             "density: fit both only where one of several regions is known.\n",
    .examples = "identify beam.npz ringdown.csv --start static:constant:0,0,-40@tip -o fit\n"
                "identify beam.npz ringdown.csv --parameters E,damping-ratio,start --ratios 2",
    .exits = "0 done, 1 refused, 2 usage, 3 fitted but flagged (not converged, poor, a misfit, or "
             "a parameter does not show)",
};

int identify_options_read(int argc, char **argv, identify_request *request) {
  request->young = request->ratio = true;
  request->parameters = "E,damping-ratio";
  request->ratio_count = 1;
  request->start_modes = 3;
  request->iterations = 40;
  CONFIG_TRY(config_options_read(&command_identify, argc, argv, request));
  if (argc - optind != 2)
    return config_usage("identify", "a model and a recording are needed: thrum identify MODEL "
                                    "RECORDING.csv");
  request->model_path = argv[optind];
  request->recording_path = argv[optind + 1];
  return COMMAND_DONE;
}
