/* `thrum info` of the folder of a run: what its run.json or scene.json says of it, and what can be
 * done with it. SPDX-License-Identifier: Apache-2.0 */
#include "app/info_run.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/model/basis_estimate.h"
#include "driver/record/run_entries.h"
#include "driver/record/run_read.h"
#include "io/json.h"
#include "io/report.h"

typedef struct recorded {
  const char *path;
  bool scene;
  const cJSON *report; /* run.json or scene.json */
  const cJSON *bodies; /* of a scene */
  char missing[400];   /* what it cannot be played without, as a sentence; "": nothing */
} recorded;

static bool is_full(const cJSON *report) {
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(report, "options");
  return cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(options, "full"));
}

static const char *step_key(const recorded *run) {
  return run->scene ? "dt_s" : "dt";
}

static const report_line of_model[] = {
    REPORT_LINE("model", "{model|?}"),
    REPORT_LINE("stepped by", "{stepped_by|?}{options.full? of the whole mesh}, rank {rank|?}"),
    REPORT_LINE("in the scene", "{placement.scene|?}", .when = "placement"),
    {0}};

static const report_line of_scene[] = {
    REPORT_LINE("scene", "{scene|?}"),
    REPORT_LINE("title", "{title}"),
    REPORT_LINE("body", "{name|?}: {model|?}, rank {rank|?}, by {stepped_by|?}: {status|?}",
                .each = "bodies"),
    REPORT_LINE("gravity", "{gravity_m_s2:g} m/s^2", .when = "gravity_m_s2"),
    REPORT_LINE("base motion", "{base_motion}", .when = "base_motion"),
    {0}};

/* How long a run is, what is there of it, and how it ended; those of bodies are in their own
 * folders. */
static const report_line of_both[] = {
    REPORT_LINE("steps",
                "{steps|?} of {dt=null?{dt_s:g|?}|{dt:g}} s, together {simulated_s:g|?} s"),
    REPORT_LINE("recorded", "{rows|?} rows, {frames|?} frames"),
    REPORT_LINE("energy",
                "first {energy_first_j:.6g|?}, last {energy_last_j:.6g|?}, least "
                "{energy_min_j:.6g|?}, most "
                "{energy_max_j:.6g|?} J",
                .when = "!bodies"),
    REPORT_LINE("status", "{status|?}"),
    REPORT_LINE("", "{message}"),
    {0}};

/* Finds what the monitor of a run warned of; NULL where it did not look. */
static const cJSON *warnings_of(const cJSON *report) {
  const cJSON *monitor = cJSON_GetObjectItemCaseSensitive(report, "monitor");
  const cJSON *raised = cJSON_GetObjectItemCaseSensitive(monitor, "warnings");
  return cJSON_IsArray(raised) ? raised : NULL;
}

#define BODY "{body?{body}: }"

/* What speaks against believing a run, or a body of that name in it: why it ended with its status,
 * how far its basis has it wrong, what the monitor warned of. A stretch below 0 is that of a
 * tetrahedron turned inside out. */
static const report_line doubts[] = {
    REPORT_LINE("",
                BODY "{fallback_steps} step{fallback_steps#|s} needed "
                     "{options.full?to be taken as several shorter ones|a fallback beyond "
                     "quasi-Newton}",
                .when = "status=fell_back"),
    REPORT_LINE("", BODY "{shares}", .when = "status=condensed_wrong"),
    REPORT_LINE("error", BODY BASIS_ESTIMATE_WRONG " by the basis" BASIS_ESTIMATE_WITHIN),
    REPORT_LINE("warnings", BODY "{monitor.warnings}[; least stretch {monitor.least_stretch:.3g}]",
                .when = "monitor.warnings"),
    {0}};

/* The folder of a body of a scene has the body's name. */
static void name_body(const recorded *run, const cJSON *body, recorded_path folder) {
  snprintf(folder, sizeof(recorded_path), "%.*s/%.200s", RUN_PATH_MAX, run->path,
           json_text_of(body, "name"));
}

/* Reads the report of a body of a scene; NULL where it has none that can be told. The caller
 * deletes it. */
static cJSON *report_of_body(const recorded *run, const cJSON *body) {
  recorded_path folder;
  char file[sizeof folder + sizeof RUN_JSON + 1];
  cJSON *report = NULL;
  name_body(run, body, folder);
  snprintf(file, sizeof file, "%s/%s", folder, RUN_JSON);
  if (json_file_read(file, &report, NULL) < 0 || info_run_check(file, report, false, NULL) >= 0)
    return report;
  cJSON_Delete(report);
  return NULL;
}

/* Finds out what is missing for the run, or for a body of a scene, to be played. */
static void find_missing(recorded *run) {
  thrum_error error = {0};
  thrum_status status = run->scene ? THRUM_OK : recorded_run_check(run->path, &error);
  const cJSON *body = NULL;

  // each body of a scene is a run of its own
  cJSON_ArrayForEach(body, run->bodies) {
    recorded_path folder;
    name_body(run, body, folder);
    if (status >= 0 && run->scene)
      status = recorded_run_check(folder, &error);
  }
  if (status < 0)
    snprintf(run->missing, sizeof run->missing, "%s", error.message);
}

/* The shares of a condensed run that speak against believing it: those above 0, with commas. */
static void add_shares(cJSON *more, const cJSON *report) {
  static const char *const keys[] = {"inertia_share", "energy_defect", "vibration_share",
                                     "impact_share"};
  static const char *const words[] = {
      "of the kinetic energy in what follows", "of the strain energy wrong",
      "of the motion is vibration left out", "of it off after impacts"};
  const cJSON *condensed = cJSON_GetObjectItemCaseSensitive(report, "condensed");
  cJSON *shares = cJSON_AddArrayToObject(more, "shares");
  for (int n = 0; n < 4; n++) {
    char text[120];
    const double share = json_number_of(condensed, keys[n]);
    snprintf(text, sizeof text, "%.2g %% %s", 100 * share, words[n]);
    if (share > 0)
      json_add_string(shares, text);
  }
}

static void print_doubts_of(const char *body, const cJSON *report) {
  cJSON *more = cJSON_CreateObject();
  json_string(more, "body", body);
  add_shares(more, report);
  report_print(report, more, REPORT_LABEL_WIDE, doubts);
  cJSON_Delete(more);
}

/* Says what speaks against believing a run. */
static void print_doubts(const recorded *run) {
  if (!run->scene)
    print_doubts_of(NULL, run->report);

  // bodies of scenes have their own in the reports of their folders
  const cJSON *body = NULL;
  cJSON_ArrayForEach(body, run->bodies) {
    cJSON *report = report_of_body(run, body);
    const char *name = json_text_of(body, "name");
    print_doubts_of(name != NULL ? name : "?", report);
    cJSON_Delete(report);
  }
}

static void print_table(const recorded *run) {
  const char *called = getenv("THRUM_COMMAND");
  const char *program = called != NULL && called[0] != 0 ? called : "thrum";

  // what was stepped, for how long, and how it ended
  printf("%-18s%s, a run of %s that thrum simulate recorded\n", "run", run->path,
         run->scene ? "a scene" : "a model");
  report_print(run->report, NULL, REPORT_LABEL_WIDE, run->scene ? of_scene : of_model);
  if (!run->scene)
    info_run_print_options(run->report);
  report_print(run->report, NULL, REPORT_LABEL_WIDE, of_both);
  print_doubts(run);

  // what can be done with it, as this program was called
  if (run->missing[0] != 0) {
    printf("%-18s%s\n", "missing", run->missing);
    return;
  }
  printf("%-18s%s view %s, which plays it\n", "next", program, run->path);
  printf("%-18s%s export %s --glb run.glb, for other programs\n", "", program, run->path);
  printf("%-18s%s compare %s OTHER, which says how far another run is from it\n", "", program,
         run->path);
}

/* Adds what print_stepped says, of a body of a scene or of the run of one. */
static void add_stepped(cJSON *object, const cJSON *report) {
  json_string(object, "model", json_text_of(report, "model"));
  json_string(object, "integrator", json_text_of(report, "integrator"));
  json_string(object, "stepped_by", json_text_of(report, "stepped_by"));
  json_number(object, "rank", json_number_of(report, "rank"));
}

/* Adds what the monitor warned of; null where it did not look. */
static void add_warnings(cJSON *object, const cJSON *report) {
  const cJSON *raised = warnings_of(report);
  const cJSON *monitor = cJSON_GetObjectItemCaseSensitive(report, "monitor");
  cJSON_AddItemToObject(object, "warnings",
                        raised != NULL ? cJSON_Duplicate(raised, true) : cJSON_CreateNull());
  json_number(object, "least_stretch", json_number_of(monitor, "least_stretch"));
  json_number(object, "error_share",
              json_number_of(cJSON_GetObjectItemCaseSensitive(report, "error_estimate"), "share"));
  json_number(object, "fallback_steps", json_number_of(report, "fallback_steps"));
}

/* Adds the energies of a run or of a body. */
static void add_energy(cJSON *object, const cJSON *report) {
  static const char *const keys[] = {"energy_first_j", "energy_last_j", "energy_min_j",
                                     "energy_max_j"};
  for (size_t n = 0; n < sizeof keys / sizeof keys[0]; n++)
    json_number(object, keys[n], json_number_of(report, keys[n]));
}

/* Adds the options as the report has them; null where it has none. */
static void add_options(cJSON *object, const cJSON *report) {
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(report, "options");
  cJSON_AddItemToObject(object, "options",
                        options != NULL ? cJSON_Duplicate(options, true) : cJSON_CreateNull());
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
    cJSON_AddBoolToObject(object, "full", is_full(run->report));
    add_warnings(object, run->report);
    add_energy(object, run->report);
    add_options(object, run->report);
  }

  // times and sizes
  json_number(object, "dt", json_number_of(run->report, step_key(run)));
  json_number(object, "steps", json_number_of(run->report, "steps"));
  json_number(object, "simulated_s", json_number_of(run->report, "simulated_s"));
  json_number(object, "rows", json_number_of(run->report, "rows"));
  json_number(object, "frames", json_number_of(run->report, "frames"));

  // each body of a scene
  cJSON *bodies = run->scene ? cJSON_AddArrayToObject(object, "bodies") : NULL;
  const cJSON *body = NULL;
  cJSON_ArrayForEach(body, run->bodies) {
    cJSON *row = json_add_row(bodies);
    json_string(row, "name", json_text_of(body, "name"));
    json_string(row, "run_status", json_text_of(body, "status"));
    add_stepped(row, body);
    cJSON *report = report_of_body(run, body);
    add_warnings(row, report);
    add_energy(row, report);
    add_options(row, report);
    cJSON_Delete(report);
  }

  // whether it can be played
  json_string(object, "missing", run->missing[0] != 0 ? run->missing : NULL);
  json_print(object);
}

thrum_status info_run(const char *path, bool json, thrum_error *error) {
  recorded run = {.path = path, .scene = run_entries_finished(path, RUN_OF_SCENE)};
  recorded_path file;
  cJSON *report = NULL;
  snprintf(file, sizeof file, "%.*s/%s", RUN_PATH_MAX, path, run.scene ? SCENE_JSON : RUN_JSON);
  THRUM_TRY(json_file_read(file, &report, error));
  const thrum_status status = info_run_check(file, report, run.scene, error);
  if (status >= 0) {
    run.report = report;
    run.bodies = run.scene ? cJSON_GetObjectItemCaseSensitive(report, "bodies") : NULL;
    find_missing(&run);
    (json ? print_json : print_table)(&run);
  }
  cJSON_Delete(report);
  return status;
}
