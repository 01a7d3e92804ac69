/* `thrum bench contact`: options and output; the measurement is bench/measure_contact.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>

#include "app/bench_command.h"
#include "app/bench_speed.h"
#include "bench/measure_contact.h"
#include "bench/measured_model.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/model/display_surface.h"
#include "io/json.h"
#include "platform/thread_team.h"
#include "precompute/build_info.h"

#define WIDTH 18 /* of the name of a scene */

typedef struct request {
  bench_contact bench;
  int64_t rank, threads;
  bool json;
} request;

#define AT(member) CONFIG_AT(request, member)

static const config_option options[] = {
    OPTION_COUNT("bodies", "100", "bodies of a scene", AT(bench.bodies), CONFIG_RANGE(1, 1e5)),
    OPTION_COUNT("pairs", "10", "pairs of bodies that lie on each other in the last scene",
                 AT(bench.pairs), CONFIG_RANGE(0, 1e5)),
    OPTION_COUNT("rank", "20", "reduced coordinates of the block", AT(rank),
                 CONFIG_RANGE(1, THRUM_RANK_MAX)),
    OPTION_NUMBER("dt", "s", "0.002", "time step", AT(bench.dt), CONFIG_ABOVE(0)),
    OPTION_COUNT("steps", "100", "steps that are timed", AT(bench.steps), CONFIG_RANGE(1, 1e6)),
    OPTION_COUNT("threads", "1", "threads that the bodies of a scene are shared among", AT(threads),
                 CONFIG_RANGE(1, THRUM_TEAM_MAX)),
    OPTION_JSON(request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_bench_contact = {
    .name = "bench contact",
    .summary = "many bodies with contact between them and without",
    .usage = "[MODEL] [OPTIONS]",
    .about = "Microseconds of a step of all bodies of a scene, three scenes in turns: bodies that "
             "fall and cannot touch each other, bodies that could and are apart, and bodies of "
             "which some lie in pairs on each other.\n\nMODEL is the model file of a free body; "
             "without one it is beam:14x14x10@0.3x0.3x0.2, with 954 vertices on its surface.",
    .options = options,
    .examples = "bench contact\n"
                "bench contact --bodies 20 --pairs 10 --threads 2 --json",
};

static const char *const keys[BENCH_CONTACT_SCENES] = {"without_us", "apart_us", "touching_us"};

static cJSON *report(const request *asked) {
  const bench_contact *bench = &asked->bench;
  cJSON *object = cJSON_CreateObject();
  json_string(object, "processor", bench_processor());
  json_string(object, "compiler", thrum_build_compiler());
  json_number(object, "bodies", (double)bench->bodies);
  json_number(object, "pairs", (double)bench->pairs);
  json_number(object, "rank", (double)bench->model->rank);
  json_number(object, "triangles", (double)bench->triangle_count);
  json_number(object, "threads", bench->threads);
  json_number(object, "h", bench->dt);
  json_number(object, "steps", (double)bench->steps);

  // each scene by its minimum and its median
  for (int n = 0; n < BENCH_CONTACT_SCENES; n++)
    bench_row_time(object, keys[n], &bench->time[n]);
  json_number(object, "touches", bench->touches);
  json_number(object, "sweeps", bench->sweeps);
  return object;
}

static const report_line head[] = {
    REPORT_LINE("", "{processor}; {compiler}"),
    REPORT_LINE("",
                "{bodies} bodies of rank {rank} with {triangles} triangles, h = {h:g} s, {steps} "
                "steps, {threads} thread{threads#|s}"),
    REPORT_LINE("", ""),
    REPORT_LINE("", "                    minimum    median [[us]]"),
    {0},
};
static const report_line lines[] = {
#define SCENE(label, key) REPORT_LINE(label, "{" key ":11.1f} {" key "_median:9.1f}")
    SCENE("  without contact", "without_us"),
    SCENE("  apart", "apart_us"),
    SCENE("  touching", "touching_us"),
#undef SCENE
    REPORT_LINE("  on each other",
                "  {pairs} pairs, at {touches:.1f} places, {sweeps:.1f} sweeps a step"),
    {0},
};

/* The measurement with a model. */
static thrum_status measure(request *asked, const thrum_model *model, thrum_error *error) {
  display_surface surface = {0};
  THRUM_TRY(display_surface_make(model, &surface, error));
  display_surface_corners(&surface, surface.triangles);
  asked->bench.model = model;
  asked->bench.triangles = surface.triangles;
  asked->bench.triangle_count = surface.triangle_count;
  asked->bench.threads = (int32_t)asked->threads;
  const thrum_status status = bench_contact_run(&asked->bench, error);
  if (status >= 0)
    bench_report_end(report(asked), asked->json, head, WIDTH, lines);
  display_surface_free(&surface);
  return status;
}

int bench_contact_command(int argc, char **argv) {
  request asked = {
      .bench = {.bodies = 100, .pairs = 10, .dt = 0.002, .steps = 100}, .rank = 20, .threads = 1};
  CONFIG_TRY(config_options_read(&command_bench_contact, argc, argv, &asked));
  if (optind + 1 < argc)
    return config_usage("bench contact", "'%s' is not expected", argv[optind + 1]);

  // the model that is named, or the block
  thrum_error error = {.status = THRUM_OK};
  thrum_status status = THRUM_OK;
  if (optind < argc) {
    const thrum_model *given = NULL;
    status = thrum_model_load(argv[optind], &given, &error);
    THRUM_THEN(status, measure(&asked, given, &error));
    thrum_model_destroy(given);
  } else {
    thrum_model *block = NULL;
    status = bench_model_block(asked.rank, &block, &error);
    THRUM_THEN(status, measure(&asked, block, &error));
    bench_model_free(block);
  }
  return config_end(status, false, &error);
}
