/* `thrum info` of the folder of a run: what its run.json or scene.json says of it, and what can be
 * done with it. SPDX-License-Identifier: Apache-2.0 */
#include "app/info_run.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/run_entries.h"
#include "driver/run_read.h"
#include "io/json.h"

typedef struct recorded {
  const char *path;
  bool scene;
  const cJSON *report; /* run.json or scene.json */
  const cJSON *bodies; /* of a scene */
} recorded;

/* A text of the report that is safe to print; "?" where it has none. */
static const char *text_of(const cJSON *object, const char *key, char text[300]) {
  const char *said = json_text_of(object, key);
  snprintf(text, 300, "%s", said != NULL ? said : "?");
  config_one_line(text);
  return text;
}

/* A number of the report; NaN where it has none. */
static double number_of(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
  return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

/* The same in words: whole ones to their last digit; "?" where there is none. */
static const char *figure_of(const cJSON *object, const char *key, char text[40]) {
  const double number = number_of(object, key);
  if (isnan(number))
    snprintf(text, 40, "?");
  else
    snprintf(text, 40, "%.*g", number == floor(number) ? 15 : 6, number);
  return text;
}

static bool is_full(const recorded *run) {
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(run->report, "options");
  return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(options, "full"));
}

static const char *step_key(const recorded *run) {
  return run->scene ? "dt_s" : "dt";
}

static void print_line(const char *label, const char *text) {
  printf("%-18s%s\n", label, text);
}

/* A model and what stepped it, of a run or of a body. */
static void print_stepped(const char *label, const char *name, const cJSON *object) {
  char model[300], stepped_by[300], status[300], rank[40];
  printf("%-18s%s%s%s, rank %s, by %s: %s\n", label, name, name[0] != 0 ? ": " : "",
         text_of(object, "model", model), figure_of(object, "rank", rank),
         text_of(object, "stepped_by", stepped_by), text_of(object, "status", status));
}

static void print_bodies(const recorded *run) {
  const cJSON *body = NULL;
  cJSON_ArrayForEach(body, run->bodies) {
    char name[300];
    print_stepped(body == run->bodies->child ? "bodies" : "", text_of(body, "name", name), body);
  }
}

/* Says what a run of one body was made of. */
static void print_model(const recorded *run) {
  char text[300], rank[40];
  const cJSON *placement = cJSON_GetObjectItemCaseSensitive(run->report, "placement");
  print_line("model", text_of(run->report, "model", text));
  printf("%-18s%s%s, rank %s\n", "stepped by", text_of(run->report, "stepped_by", text),
         is_full(run) ? " of the whole mesh" : "", figure_of(run->report, "rank", rank));
  if (cJSON_IsObject(placement))
    print_line("in the scene", text_of(placement, "scene", text));

  // loads and starts in the words of the command
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(run->report, "options"), *item = NULL;
  cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(options, "load")) {
    snprintf(text, sizeof text, "%s", cJSON_IsString(item) ? item->valuestring : "?");
    config_one_line(text);
    print_line("load", text);
  }
}

/* Says how the run ended, in the words of its report. */
static void print_end(const recorded *run) {
  char text[300];
  print_line("status", text_of(run->report, "status", text));
  if (json_text_of(run->report, "message") != NULL)
    print_line("", text_of(run->report, "message", text));
}

/* Says how long a run is, and what is there of it. */
static void print_length(const recorded *run) {
  char a[40], b[40], c[40], d[40];
  const cJSON *report = run->report;
  printf("%-18s%s of %s s, together %s s\n", "steps", figure_of(report, "steps", a),
         figure_of(report, step_key(run), b), figure_of(report, "simulated_s", c));
  printf("%-18s%s rows, %s frames\n", "recorded", figure_of(report, "rows", a),
         figure_of(report, "frames", b));

  // a scene has those of its bodies in their own folders
  if (!run->scene)
    printf("%-18sfirst %s, last %s, least %s, most %s J\n", "energy",
           figure_of(report, "energy_first_j", a), figure_of(report, "energy_last_j", b),
           figure_of(report, "energy_min_j", c), figure_of(report, "energy_max_j", d));
}

static void print_table(const recorded *run) {
  const char *called = getenv("THRUM_COMMAND");
  const char *program = called != NULL && called[0] != 0 ? called : "thrum";
  char text[300];
  printf("%-18s%s, a run of %s that thrum simulate recorded\n", "run", run->path,
         run->scene ? "a scene" : "a model");
  if (run->scene) {
    print_line("scene", text_of(run->report, "scene", text));
    if (json_text_of(run->report, "title") != NULL)
      print_line("title", text_of(run->report, "title", text));
    print_bodies(run);
  } else {
    print_model(run);
  }
  print_length(run);
  print_end(run);

  // what can be done with it, as this program was called
  printf("%-18s%s view %s, which plays it\n", "next", program, run->path);
  printf("%-18s%s export %s --glb run.glb, for other programs\n", "", program, run->path);
}

/* Adds what print_stepped says, of a body of a scene or of the run of one. */
static void add_stepped(cJSON *object, const cJSON *report) {
  json_string(object, "model", json_text_of(report, "model"));
  json_string(object, "integrator", json_text_of(report, "integrator"));
  json_string(object, "stepped_by", json_text_of(report, "stepped_by"));
  json_number(object, "rank", number_of(report, "rank"));
}

static void print_json(const recorded *run) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", "done");
  json_string(object, "run", run->path);
  cJSON_AddStringToObject(object, "of", run->scene ? "scene" : "model");
  json_string(object, "run_status", json_text_of(run->report, "status"));
  json_string(object, "message", json_text_of(run->report, "message"));
  json_string(object, "version", json_text_of(run->report, "version"));
  if (run->scene) {
    json_string(object, "scene", json_text_of(run->report, "scene"));
    json_string(object, "title", json_text_of(run->report, "title"));
  } else {
    add_stepped(object, run->report);
    cJSON_AddBoolToObject(object, "full", is_full(run));
  }

  // times and sizes
  json_number(object, "dt", number_of(run->report, step_key(run)));
  json_number(object, "steps", number_of(run->report, "steps"));
  json_number(object, "simulated_s", number_of(run->report, "simulated_s"));
  json_number(object, "rows", number_of(run->report, "rows"));
  json_number(object, "frames", number_of(run->report, "frames"));

  // each body of a scene
  cJSON *bodies = run->scene ? cJSON_AddArrayToObject(object, "bodies") : NULL;
  const cJSON *body = NULL;
  cJSON_ArrayForEach(body, run->bodies) {
    cJSON *row = json_add_row(bodies);
    json_string(row, "name", json_text_of(body, "name"));
    json_string(row, "run_status", json_text_of(body, "status"));
    add_stepped(row, body);
  }
  json_print(object);
}

thrum_status info_run(const char *path, bool json, thrum_error *error) {
  recorded run = {.path = path, .scene = run_entries_finished(path, RUN_OF_SCENE)};
  recorded_path file;
  cJSON *report = NULL;
  snprintf(file, sizeof file, "%.*s/%s", RUN_PATH_MAX, path, run.scene ? SCENE_JSON : RUN_JSON);
  THRUM_TRY(json_file_read(file, &report, error));

  // another program's file of that name says nothing of a run
  const char *command = json_text_of(report, "command");
  thrum_status status = THRUM_OK;
  if (command == NULL || strcmp(command, "simulate") != 0)
    status = thrum_error_set(error, THRUM_BAD_FORMAT,
                             "%.300s: not the report of a run of thrum simulate", file);
  if (status >= 0) {
    run.report = report;
    run.bodies = cJSON_GetObjectItemCaseSensitive(report, "bodies");
    (json ? print_json : print_table)(&run);
  }
  cJSON_Delete(report);
  return status;
}
