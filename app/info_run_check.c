/* Whether the report of a run holds what a run can have, before anything of it is told
 * (info_run.h). SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/info_run.h"
#include "config/message.h"
#include "driver/run/simulate_options.h"
#include "driver/scene/scene_spec.h"
#include "io/json.h"

#define COUNT_MOST (SIMULATE_STEPS_MAX + 1) /* of rows and frames: one a step, and the first */
#define TIME_ROUNDING 1e-9                  /* of steps times dt, relative */

/* A number of a report: whole ones, or any from `least` on; above: not that itself. */
typedef struct range {
  const char *key;
  double least, most;
  bool whole, above;
} range;

#define ANY -INFINITY, INFINITY, false, false

/* Both kinds of reports; keys that one has none of are absent. */
static const range of_report[] = {
    {"rank", 1, THRUM_RANK_MAX, true, false},
    {"dt", 0, INFINITY, false, true},
    {"dt_s", 0, INFINITY, false, true},
    {"steps", 0, SIMULATE_STEPS_MAX, true, false},
    {"simulated_s", 0, INFINITY, false, false},
    {"rows", 0, COUNT_MOST, true, false},
    {"frames", 0, COUNT_MOST, true, false},
    {"fallback_steps", 0, SIMULATE_STEPS_MAX, true, false},
    {"energy_first_j", ANY},
    {"energy_last_j", ANY},
    {"energy_min_j", ANY},
    {"energy_max_j", ANY},
};
static const range of_monitor[] = {{"least_stretch", ANY}};
static const range of_condensed[] = {
    {"inertia_share", 0, INFINITY, false, false},
    {"energy_defect", 0, INFINITY, false, false},
    {"vibration_share", 0, INFINITY, false, false},
    {"impact_share", 0, INFINITY, false, false},
};

/* "a whole number from 0 to 1e+12" */
static const char *wants(const range *figure, char text[80]) {
  char least[32] = "", most[32] = "";
  if (isfinite(figure->least))
    snprintf(least, sizeof least, " %s %g", figure->above ? "above" : "from", figure->least);
  if (isfinite(figure->most))
    snprintf(most, sizeof most, " to %g", figure->most);
  snprintf(text, 80, "a %snumber%s%s", figure->whole ? "whole " : "finite ", least, most);
  return text;
}

static bool is_right(const range *figure, const cJSON *item) {
  const double value = item->valuedouble;
  return cJSON_IsNumber(item) && isfinite(value) && value >= figure->least &&
         value <= figure->most && !(figure->above && value == figure->least) &&
         !(figure->whole && value != floor(value));
}

/* Refuses an item with what stands there. */
static thrum_status refuse(const char *file, const cJSON *item, const char *wanted,
                           thrum_error *error) {
  char value[48];
  char *text = cJSON_PrintUnformatted(item);
  const bool infinite = cJSON_IsNumber(item) && !isfinite(item->valuedouble);
  snprintf(value, sizeof value, "%s", infinite ? "infinite" : text != NULL ? text : "?");
  cJSON_free(text);
  config_one_line(value);
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "%.200s: \"%.40s\" is %s, and a run has %s there: the file was changed, "
                         "simulate again",
                         file, item->string, value, wanted);
}

/* A number that a run has none of is null, or missing in the report of another version. */
static thrum_status check_figures(const char *file, const cJSON *object, const range *figures,
                                  size_t count, thrum_error *error) {
  char text[80];
  for (size_t n = 0; n < count; n++) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, figures[n].key);
    if (item != NULL && !cJSON_IsNull(item) && !is_right(&figures[n], item))
      return refuse(file, item, wants(&figures[n], text), error);
  }
  return THRUM_OK;
}

#define CHECK(object, figures)                                                                     \
  check_figures(file, object, figures, sizeof(figures) / sizeof *(figures), error)

/* Numbers that follow from each other, where both are there. */
static thrum_status check_times(const char *file, const cJSON *report, thrum_error *error) {
  const cJSON *time = cJSON_GetObjectItemCaseSensitive(report, "simulated_s");
  const cJSON *rows = cJSON_GetObjectItemCaseSensitive(report, "rows");
  const double steps = json_number_of(report, "steps");
  const double dt = fmax(json_number_of(report, "dt"), json_number_of(report, "dt_s"));
  if (cJSON_IsNumber(time) && fabs(time->valuedouble - steps * dt) > TIME_ROUNDING * steps * dt)
    return refuse(file, time, "its steps times their length", error);
  if (cJSON_IsNumber(rows) && rows->valuedouble > steps + 1)
    return refuse(file, rows, "a row a step and the first at most", error);
  return THRUM_OK;
}

/* The options go by their names. */
static thrum_status check_options(const char *file, const cJSON *report, thrum_error *error) {
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(report, "options");
  if (options == NULL || cJSON_IsNull(options) || cJSON_IsObject(options))
    return THRUM_OK;
  return refuse(file, options, "an object of its options", error);
}

/* The bodies of a scene, which have folders of their names in that of the run. */
static thrum_status check_bodies(const char *file, const cJSON *report, thrum_error *error) {
  const cJSON *bodies = cJSON_GetObjectItemCaseSensitive(report, "bodies"), *body = NULL;
  if (cJSON_GetArraySize(bodies) < 1 || !cJSON_IsArray(bodies))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: it lists no bodies; is it the scene.json of a run?", file);
  cJSON_ArrayForEach(body, bodies) {
    const char *name = json_text_of(body, "name");
    if (name == NULL || !scene_spec_is_name(name))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.300s: the name of a body is none of a folder in the run: it may "
                             "have letters, digits, '-', '_' and '.'",
                             file);
    THRUM_TRY(CHECK(body, of_report));
  }
  return THRUM_OK;
}

thrum_status info_run_check(const char *file, const cJSON *report, bool scene, thrum_error *error) {
  // another program's file of that name says nothing of a run
  const char *command = json_text_of(report, "command");
  if (command == NULL || strcmp(command, "simulate") != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "%.300s: not the report of a run of thrum simulate", file);

  THRUM_TRY(CHECK(report, of_report));
  THRUM_TRY(CHECK(cJSON_GetObjectItemCaseSensitive(report, "monitor"), of_monitor));
  THRUM_TRY(CHECK(cJSON_GetObjectItemCaseSensitive(report, "condensed"), of_condensed));
  THRUM_TRY(check_times(file, report, error));
  THRUM_TRY(check_options(file, report, error));
  return scene ? check_bodies(file, report, error) : THRUM_OK;
}
