/* Options of `thrum bench step`, `batch` and `kernels`. SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <string.h>

#include "app/bench_options.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/spec/shared_options.h"

static thrum_status take_ranks(const config_given *given, void *request) {
  bench_request *r = request;
  r->ranks_given = true;
  return config_given_counts(given, BENCH_RANKS_MAX, r->ranks, &r->rank_count);
}

static thrum_status take_kernel(const config_given *given, void *request) {
  for (int id = 0; thrum_kernel_name((thrum_kernel_id)id); id++) {
    if (strcmp(given->text, thrum_kernel_name((thrum_kernel_id)id)) != 0)
      continue;
    if (!thrum_kernel_usable((thrum_kernel_id)id))
      return config_given_refuse(given, "--kernel %s: this machine or build does not have it",
                                 given->text);
    ((bench_request *)request)->kernel = (thrum_kernel_id)id;
    return THRUM_OK;
  }
  return config_given_wrong(given);
}

static thrum_status take_no_machine(const config_given *given, void *request) {
  (void)given;
  ((bench_request *)request)->machine = false;
  return THRUM_OK;
}

static thrum_status take_single(const config_given *given, void *request) {
  (void)given;
  ((bench_request *)request)->single = 1;
  return THRUM_OK;
}

static thrum_status take_full(const config_given *given, void *request) {
  (void)given;
  ((bench_request *)request)->full = true;
  return THRUM_OK;
}

#define AT(member) CONFIG_AT(bench_request, member)
#define RANK_OPTION(otherwise)                                                                     \
  OPTION_TEXT("rank", "R,R,...", otherwise, "ranks of the beam", .take = take_ranks,               \
              CONFIG_RANGE(1, THRUM_RANK_MAX), .wants = "ranks from 1 to 512, as in 15,30")
#define BATCHES_OPTION(otherwise)                                                                  \
  OPTION_COUNT("batches", otherwise, "samples", AT(batches), CONFIG_RANGE(1, 1e6))

static const config_option step_options[] = {
    OPTION_INTEGRATOR(bench_request, step.def.integrator),
    OPTION_DT(bench_request, step.def.dt),
    OPTION_COUNT("implicit", NULL,
                 "choose the time step so that exactly N modes are implicit for imexv (the others "
                 "take the same step)",
                 AT(step.implicit_wanted), CONFIG_RANGE(0, 1e6)),
    OPTION_NUMBER("swing", "m", "0.4", "amplitude of the first mode", AT(step.swing),
                  CONFIG_ABOVE(0)),
    OPTION_COUNT("steps", "about 5 ms of them", "steps of a batch", AT(step.steps),
                 CONFIG_RANGE(1, 1e6)),
    OPTION_END,
};

static const config_option common_options[] = {
    OPTION_TEXT("kernel", "NAME", "best", "of the passes over the coefficients",
                .take = take_kernel, .wants = "reference, avx2, avx512, neon, wasm or best"),
    OPTION_FLAG("no-machine", "do not measure the machine's own rates", .take = take_no_machine),
    OPTION_TEXT("output", "FOLDER", NULL, "also write a table and a plot into the folder",
                .letter = 'o', AT(folder)),
    OPTION_JSON(bench_request),
    OPTION_QUIET(bench_request),
    OPTION_HELP,
    OPTION_END,
};

static const config_option step_table[] = {
    RANK_OPTION("5,10,15,20,30,45,60"),
    BATCHES_OPTION("40"),
    OPTION_GROUP(step_options, "", .field = 0),
    OPTION_GROUP(common_options, "", .field = 0),
    OPTION_END,
};

static const config_option batch_table[] = {
    RANK_OPTION("30"),
    BATCHES_OPTION("10"),
    OPTION_COUNT("bodies", "300", "how many bodies", AT(bodies), CONFIG_RANGE(1, 1e6)),
    OPTION_GROUP(step_options, "", .field = 0),
    OPTION_GROUP(common_options, "", .field = 0),
    OPTION_END,
};

static const config_option accelerator_table[] = {
    RANK_OPTION("10,20,30"),
    BATCHES_OPTION("5"),
    OPTION_COUNT("bodies", "4096", "how many bodies", AT(bodies), CONFIG_RANGE(1, 1e8)),
    OPTION_COUNT("device", "0", "which device, in the order of clinfo -l", AT(device),
                 CONFIG_RANGE(0, 1000)),
    OPTION_FLAG("single", "single precision throughout", .take = take_single),
    OPTION_FLAG(
        "full",
        "the whole mesh in place of a crowd, by the midpoint rule, beside the same steps by "
        "one core",
        .take = take_full),
    OPTION_GROUP(step_options, "", .field = 0),
    OPTION_GROUP(common_options, "", .field = 0),
    OPTION_END,
};

static const config_option kernels_table[] = {
    RANK_OPTION("5,10,15,20,30,45,60"),
    BATCHES_OPTION("40"),
    OPTION_COUNT("implicit", "3", "|I| of the last two passes", AT(step.implicit_wanted),
                 CONFIG_RANGE(0, 1e6)),
    OPTION_GROUP(common_options, "", .field = 0),
    OPTION_END,
};

#define MODEL_ABOUT                                                                                \
  "\n\nMODEL is a model file; without one the body is beam:20x3x3@1x0.15x0.15,split=6, held at "   \
  "one end, "                                                                                      \
  "at each rank."

const config_command command_bench_step = {
    .name = "bench step",
    .summary = "a step of a body that swings",
    .usage = "[MODEL] [OPTIONS]",
    .about = "Microseconds of a step of a body that swings, on one core. Every batch of steps "
             "begins at the same snapshot." MODEL_ABOUT,
    .options = step_table,
    .examples = "bench step --rank 30 --implicit 3\n"
                "bench step --rank 15,30,60 --kernel avx2 --json",
};

const config_command command_bench_batch = {
    .name = "bench batch",
    .summary = "many bodies of one model stepped together",
    .usage = "[MODEL] [OPTIONS]",
    .about = "Microseconds of the processor for a step of one of many bodies that swing, one by "
             "one and together, on one core, both ways in turns." MODEL_ABOUT,
    .options = batch_table,
    .examples = "bench batch --bodies 300 --rank 30\n"
                "bench batch --rank 15,30,60 --kernel avx2 --json",
};

const config_command command_bench_accelerator = {
    .name = "bench accelerator",
    .summary = "a crowd of bodies on a device of OpenCL",
    .usage = "[MODEL] [OPTIONS]",
    .about = "Steps in a second of bodies that swing, all together on one device, by energy, "
             "midpoint or verlet; how much of the device's own rate of arithmetic that is; and by "
             "how much they end elsewhere than by thrum_step." MODEL_ABOUT,
    .options = accelerator_table,
    .examples = "bench accelerator --bodies 10000 --rank 20\n"
                "bench accelerator --device 1 --integrator midpoint --json\n"
                "bench accelerator horse.npz --full",
};

const config_command command_bench_kernels = {
    .name = "bench kernels",
    .summary = "the passes over the coefficients",
    .usage = "[MODEL] [OPTIONS]",
    .about = "Microseconds of each pass over the coefficients, on one core." MODEL_ABOUT,
    .options = kernels_table,
    .notes = "the passes:\n"
             "  V                the energy at q\n"
             "  R and V          the internal force and the energy\n"
             "  T                the tangent stiffness, rank x rank\n"
             "  T v              the tangent stiffness times a vector\n"
             "  V at held q_E    V with all but |I| modes held, a quartic in those\n"
             "  T_II             its tangent stiffness\n",
    .examples = "bench kernels --rank 30\n"
                "bench kernels --rank 15,30,60 --kernel avx2 --json",
};

int bench_options_read(const config_command *about, int argc, char **argv, bench_request *request) {
  const char *command = about->name;
  static const int64_t usual[] = {5, 10, 15, 20, 30, 45, 60};
  *request = (bench_request){.command = command, .batches = 40, .machine = true};
  request->step.def = thrum_default_state_def();
  const thrum_integrator usual_integrator = request->step.def.integrator;
  request->step.def.integrator = (thrum_integrator)-1; // shows that none was named
  request->step.implicit_wanted = -1;
  request->step.swing = 0.4;
  request->bodies = 300;
  memcpy(request->ranks, usual, sizeof usual);
  request->rank_count = sizeof usual / sizeof usual[0];
  if (strcmp(command, "bench batch") == 0) {
    request->ranks[0] = 30;
    request->rank_count = 1;
    request->batches = 10;
  }

  if (strcmp(command, "bench accelerator") == 0) {
    static const int64_t ranks[] = {10, 20, 30};
    memcpy(request->ranks, ranks, sizeof ranks);
    request->rank_count = 3;
    request->batches = 5;
    request->bodies = 4096;
  }

  // a model has its own rank, and --implicit sets the time step
  CONFIG_TRY(config_options_read(about, argc, argv, request));
  if (optind + 1 < argc)
    return config_usage(command, "one MODEL at most, not also '%s'", argv[optind + 1]);
  if (optind < argc)
    request->model_path = argv[optind];

  // a number of implicit modes is asked of the integrator that has them
  if (request->step.def.integrator == (thrum_integrator)-1)
    request->step.def.integrator =
        request->step.implicit_wanted >= 0 ? THRUM_INTEGRATOR_IMEXV : usual_integrator;

  // a crowd's coefficients are a matrix (accelerator/crowd.c)
  for (int64_t n = 0; n < request->rank_count; n++)
    if (strcmp(command, "bench accelerator") == 0 && !request->full && request->ranks[n] > 128)
      return config_usage(command, "--rank %lld: a crowd takes ranks up to 128",
                          (long long)request->ranks[n]);

  // options that exclude each other
  if (request->ranks_given && request->model_path)
    return config_usage(command, "--rank is of the beam; a model file has its own rank");
  if (request->step.implicit_wanted >= 0 && strcmp(command, "bench kernels") != 0 &&
      request->step.def.dt != thrum_default_state_def().dt)
    return config_usage(command, "--implicit chooses the time step; give it without --dt");
  return COMMAND_DONE;
}
