/* Results for machines: one JSON object on one line of standard output.
 *
 * cJSON's own numbers may lose the last digits, so numbers go in as text: the shortest of 15 to 17
 * digits that reads back as the same double. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/cli.h"

static cJSON *number_item(double value) {
  char text[40];
  if (!isfinite(value))
    return cJSON_CreateNull();
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, sizeof text, "%.*g", digits, value);
    if (strtod(text, NULL) == value)
      break;
  }
  return cJSON_CreateRaw(text);
}

void cli_json_number(cJSON *object, const char *key, double value) {
  cJSON_AddItemToObject(object, key, number_item(value));
}

void cli_json_numbers(cJSON *object, const char *key, const double *values, int64_t count) {
  cJSON *array = cJSON_AddArrayToObject(object, key);
  for (int64_t n = 0; n < count; n++)
    cJSON_AddItemToArray(array, number_item(values[n]));
}

char *cli_json_text(const cJSON *object) {
  return cJSON_PrintUnformatted(object);
}

void cli_json_print(cJSON *object) {
  char *text = cli_json_text(object);
  if (text != NULL) {
    puts(text);
    free(text);
  } else {
    fputs("thrum: out of memory while printing the result\n", stderr);
  }
  cJSON_Delete(object);
}
