/* `thrum compare`: how far two finished runs are apart, of a model or of the bodies of a scene.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app/cmd.h"
#include "config/message.h"
#include "config/options.h"
#include "core/base/pi.h"
#include "driver/record/run_compare.h"
#include "driver/scene/scene_read.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/report.h"
#include "platform/allocate.h"

#define DEGREES (180 / THRUM_PI)

typedef struct compare_request {
  const char *paths[2];
  bool json;
} compare_request;

static const config_option options[] = {
    OPTION_JSON(compare_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_compare = {
    .name = "compare",
    .summary = "how far two runs are apart, of a model or of a scene",
    .usage = "RUN OTHER [OPTIONS]",
    .about =
        "Says how far two runs of thrum simulate are apart: where the vertices of each body are, "
        "at the times that both recorded, and the energy. RUN and OTHER are the folders of runs of "
        "a model, or of scenes, whose bodies are taken together by their names; distances are "
        "measured by how far OTHER moves. Runs with another --dt say what the step does, those "
        "with another integrator, model of the same mesh or \"coupled\" what these do.",
    .options = options,
    .notes =
        "Of an integrator of order two, the run with half of the step is in error by about a third "
        "of\nwhat it is apart from the run with the whole step.\n",
    .examples = "simulate spin.json -o whole\n"
                "simulate spin.json -o half --dt 0.001\n"
                "compare whole half",
};

/* The runs of one side: of the bodies of a scene, or one without a name. */
typedef struct compare_side {
  const char *path;
  recorded_scene scene;
  recorded_run run;
  const recorded_run *runs;
  const char *const *names; /* NULL: the run of a model */
  int64_t count;
} compare_side;

/* A body that both runs have. */
typedef struct compared_body {
  const char *name; /* "" of the run of a model */
  const char *stepped_by[2];
  bool full[2];        /* the whole mesh was stepped */
  double load_work[2]; /* [J] */
  run_difference found;
} compared_body;

typedef struct comparison {
  compare_side sides[2];
  compared_body *bodies;
  int64_t count;
  int64_t alone; /* bodies that one run has alone */
} comparison;

/* Reads the run in a folder, of a scene or of a model. */
static thrum_status read_side(const char *path, compare_side *side, thrum_error *error) {
  side->path = path;

  // the run of a scene has one of each body
  if (is_scene_folder(path)) {
    THRUM_TRY(recorded_scene_read(path, &side->scene, error));
    side->runs = side->scene.runs;
    side->names = side->scene.names;
    side->count = side->scene.count;
    return THRUM_OK;
  }

  // that of a model is the only one of its side
  if (!is_run_folder(path))
    return thrum_error_set(error, THRUM_MISSING,
                           "%.200s is no folder of a finished run: name one that thrum simulate "
                           "wrote",
                           path);
  THRUM_TRY(recorded_run_read(path, NULL, &side->run, error));
  side->runs = &side->run;
  side->count = 1;
  return THRUM_OK;
}

/* The run of the body of this name; NULL: there is none. */
static const recorded_run *find_body(const compare_side *side, const char *name) {
  for (int64_t n = 0; n < side->count; n++)
    if (side->names == NULL || strcmp(side->names[n], name) == 0)
      return &side->runs[n];
  return NULL;
}

/* Compares the bodies that both sides have, in the order of the first. */
static thrum_status compare_bodies(comparison *of, thrum_error *error) {
  const compare_side *left = &of->sides[0], *right = &of->sides[1];
  THRUM_TRY(thrum_reserve(&of->bodies, left->count, sizeof *of->bodies, "the bodies", error));

  // those that have a namesake
  for (int64_t n = 0; n < left->count; n++) {
    const char *name = left->names != NULL ? left->names[n] : "";
    const recorded_run *run = &left->runs[n], *other = find_body(right, name);
    if (other == NULL)
      continue;

    compared_body *body = &of->bodies[of->count];
    *body = (compared_body){.name = name,
                            .stepped_by = {run->stepped_by, other->stepped_by},
                            .full = {run->full, other->full},
                            .load_work = {run->load_work, other->load_work}};
    const thrum_status status = run_compare(run, other, &body->found, error);
    if (status < 0)
      return config_error_in(error, status, "%.200s and %.200s%s%.60s", left->path, right->path,
                             name[0] != 0 ? ", body " : "", name);
    of->count++;
  }

  // the others are counted, and without a pair there is nothing to say
  of->alone = left->count + right->count - 2 * of->count;
  if (of->count > 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE, "%.200s and %.200s have no body of the same name",
                         left->path, right->path);
}

static thrum_status compare(const compare_request *request, comparison *of, thrum_error *error) {
  for (int n = 0; n < 2; n++)
    THRUM_TRY(read_side(request->paths[n], &of->sides[n], error));
  if ((of->sides[0].names == NULL) != (of->sides[1].names == NULL))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "%.200s is the run of a %s and %.200s that of a %s: compare a body of "
                           "the scene by its folder in the run",
                           of->sides[0].path, of->sides[0].names != NULL ? "scene" : "model",
                           of->sides[1].path, of->sides[1].names != NULL ? "scene" : "model");
  return compare_bodies(of, error);
}

/* One number over another; NaN where there is nothing to measure by. */
static double share(double part, double whole) {
  return whole > 0 ? part / whole : NAN;
}

static cJSON *make_report(const comparison *of) {
  cJSON *object = json_report("compare", "done");
  json_string(object, "run", of->sides[0].path);
  json_string(object, "other", of->sides[1].path);
  json_number(object, "bodies_alone", (double)of->alone);
  cJSON *bodies = cJSON_AddArrayToObject(object, "bodies");
  for (int64_t n = 0; n < of->count; n++) {
    const compared_body *body = &of->bodies[n];
    const run_difference *found = &body->found;
    cJSON *row = json_add_row(bodies);
    json_string(row, "name", body->name[0] != 0 ? body->name : NULL);
    json_string(row, "stepped_by", body->stepped_by[0]);
    json_string(row, "other_stepped_by", body->stepped_by[1]);
    cJSON_AddBoolToObject(row, "full", body->full[0]);
    cJSON_AddBoolToObject(row, "other_full", body->full[1]);
    json_number(row, "load_work_j", body->load_work[0]);
    json_number(row, "other_load_work_j", body->load_work[1]);

    // which moments
    json_number(row, "moments", (double)found->moments);
    json_number(row, "first_s", found->first);
    json_number(row, "last_s", found->last);

    // where the vertices are; none is the furthest away where none is away
    const bool any = found->vertex >= 0;
    json_number(row, "apart_m", found->apart);
    json_number(row, "moved_m", found->moved);
    json_number(row, "apart_share", share(found->apart, found->moved));
    json_number(row, "end_m", found->at_end);
    json_number(row, "largest_m", found->largest);
    json_number(row, "largest_vertex", any ? (double)(found->vertex + 1) : NAN);
    json_number(row, "largest_s", any ? found->time : NAN);
    json_number(row, "shape_m", found->shape);
    json_number(row, "turn_deg", DEGREES * found->turn);
    json_number(row, "energy_j", found->energy);
    json_number(row, "energy_share", share(found->energy, found->energy_most));
  }
  return object;
}

static const report_line lines[] = {
    REPORT_LINE("compared",
                "{run} with {other}, at {bodies.0.moments} times from {bodies.0.first_s:g} to "
                "{bodies.0.last_s:g} s"),
    REPORT_LINE("body",
                "   apart m  share of way      end m  largest m    shape m   turn deg   energy J"),
    REPORT_LINE(
        "{name|body}",
        "{apart_m:10.4g} {apart_share:11.3g%|            -} {end_m:10.4g} {largest_m:10.4g} "
        "{shape_m:10.4g} {turn_deg:10.3g} "
        "{energy_j:10.3g}",
        .each = "bodies"),

    // what the two were stepped by, where that is not the same; bodies of scenes are never stepped
    // whole
    REPORT_LINE("stepped by", "{name?{name}: }{stepped_by}, and {other_stepped_by}",
                .each = "stepped_apart"),
    REPORT_LINE("whole mesh",
                "a run of --full has rows of what the basis of its model has of the motion: what "
                "that lacks "
                "is in no "
                "distance",
                .when = "full"),
    REPORT_LINE("loads",
                "gave {bodies.0.load_work_j:.4g} and {bodies.0.other_load_work_j:.4g} J; of a blow "
                "a basis takes less than the mesh",
                .when = "full"),
    REPORT_LINE("alone", "{bodies_alone} bod{bodies_alone#y is|ies are} in one of the runs only",
                .when = "bodies_alone"),
    {0}};

static void print_report(const comparison *of, bool json) {
  cJSON *report = make_report(of);
  if (json) {
    json_print(report);
    return;
  }

  // bodies that two integrators stepped, and runs of which one stepped the whole mesh
  cJSON *more = cJSON_CreateObject(), *apart = cJSON_AddArrayToObject(more, "stepped_apart");
  const cJSON *body = NULL;
  cJSON_ArrayForEach(body, cJSON_GetObjectItemCaseSensitive(report, "bodies")) {
    if (strcmp(json_text_of(body, "stepped_by"), json_text_of(body, "other_stepped_by")) != 0)
      cJSON_AddItemToArray(apart, cJSON_Duplicate(body, true));
  }
  cJSON_AddBoolToObject(more, "full", of->bodies[0].full[0] || of->bodies[0].full[1]);
  report_end(report, more, REPORT_LABEL, lines);
}

int cmd_compare(int argc, char **argv) {
  compare_request request = {0};

  // two folders and no more
  CONFIG_TRY(config_options_read(&command_compare, argc, argv, &request));
  if (argc - optind != 2)
    return config_usage("compare", "give the folders of two runs, RUN OTHER");
  request.paths[0] = argv[optind];
  request.paths[1] = argv[optind + 1];

  // the table or the object comes once all bodies are compared
  thrum_error error = {0};
  comparison of = {0};
  const thrum_status status = compare(&request, &of, &error);
  if (status >= 0)
    print_report(&of, request.json);

  for (int n = 0; n < 2; n++) {
    recorded_scene_free(&of.sides[n].scene);
    recorded_run_free(&of.sides[n].run);
  }
  free(of.bodies);
  return config_end(status, false, &error);
}
