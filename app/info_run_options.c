/* The options that a run was made with, in the words of the command (info_run.h).
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app/info_run.h"
#include "config/message.h"
#include "driver/run/simulate_report.h"
#include "io/json.h"

/* These have lines of their own. */
static bool is_told(const char *key) {
  static const char *const told[] = {"load", "start", "base_motion", "full", "dt", "time"};
  bool found = false;
  for (size_t n = 0; n < sizeof told / sizeof told[0] && !found; n++)
    found = strcmp(key, told[n]) == 0;
  return found;
}

/* The value as it stands on the command line: "0.3,0", "off", "energy". */
static void print_value(const cJSON *item) {
  char text[100];
  if (cJSON_IsArray(item)) {
    const cJSON *part = NULL;
    cJSON_ArrayForEach(part, item) {
      printf("%s%.15g", part == item->child ? " " : ",", part->valuedouble);
    }
    return;
  }

  // a text may hold anything
  if (cJSON_IsBool(item)) {
    printf(" %s", cJSON_IsTrue(item) ? "on" : "off");
    return;
  }
  if (cJSON_IsNumber(item)) {
    printf(" %.15g", item->valuedouble);
    return;
  }
  snprintf(text, sizeof text, "%s", cJSON_IsString(item) ? item->valuestring : "none");
  config_one_line(text);
  printf(" %s", text);
}

/* Prints the option of a key; a flag has no value. */
static void print_option(const cJSON *item) {
  char name[40];
  snprintf(name, sizeof name, "%s", item->string);
  for (char *c = name; *c != 0; c++)
    *c = *c == '_' ? '-' : *c;
  config_one_line(name);

  // texts are those of an option that was given several times
  const cJSON *part = NULL;
  if (cJSON_IsArray(item) && cJSON_IsString(item->child)) {
    cJSON_ArrayForEach(part, item) {
      printf(" --%s", name);
      print_value(part);
    }
    return;
  }
  printf(" --%s", name);
  if (strcmp(name, "stress") != 0)
    print_value(item);
}

/* Prints each text of a list on a line. */
static void print_texts(const cJSON *options, const char *key, const char *label) {
  const cJSON *item = NULL;
  cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(options, key)) {
    char text[300];
    snprintf(text, sizeof text, "%s", cJSON_IsString(item) ? item->valuestring : "?");
    config_one_line(text);
    printf("%-18s%s\n", label, text);
  }
}

void info_run_print_options(const cJSON *report) {
  const cJSON *options = cJSON_GetObjectItemCaseSensitive(report, "options"), *item = NULL;
  print_texts(options, "load", "load");
  print_texts(options, "start", "start");
  print_texts(options, "base_motion", "base motion");

  // what a run without options has as well is left out; numbers are compared as they are read
  const bool full = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(options, "full"));
  simulate_request usual = {0};
  simulate_request_begin(&usual);
  usual.full = full;
  usual.monitor = !full;
  cJSON *usual_options = simulate_options_json(&usual);
  char *text = json_text(usual_options);
  cJSON *defaults = text != NULL ? cJSON_Parse(text) : NULL;

  // all that is left stands on one line, which only a run with options has
  bool any = false;
  cJSON_ArrayForEach(item, options) {
    const cJSON *usually = cJSON_GetObjectItemCaseSensitive(defaults, item->string);
    if (is_told(item->string) || cJSON_Compare(item, usually, true))
      continue;
    printf("%s", any ? "" : "options          ");
    print_option(item);
    any = true;
  }
  if (any)
    puts("");
  cJSON_Delete(defaults);
  cJSON_Delete(usual_options);
  free(text);
}
