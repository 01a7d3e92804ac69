/* What the coordinates of a model are. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/model_coordinates.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "driver/model/model_meta.h"
#include "io/json.h"

#define PAIR_SHOWN 0.1 /* of a coordinate: a smaller share is not worth its place in a line */

static const char *const kind_names[THRUM_COORDINATE_KINDS] = {"mode", "derivative", "handle",
                                                               "trained"};

static void add_pairs(cJSON *row, const thrum_coordinate *coordinate) {
  cJSON *pairs = cJSON_AddArrayToObject(row, "pairs");
  for (int n = 0; n < THRUM_COORDINATE_PAIRS && coordinate->pair_shares[n] > 0; n++) {
    const double modes[2] = {(double)coordinate->pairs[n][0], (double)coordinate->pairs[n][1]};
    cJSON *pair = json_add_row(pairs);
    json_numbers(pair, "modes", modes, 2);
    json_number(pair, "share", coordinate->pair_shares[n]);
  }
}

void model_coordinates_add(cJSON *object, const precompute_outcome *outcome) {
  const thrum_precomputed *result = outcome->result;
  const touch_outcome *touch = &outcome->touch;
  if (result->coordinates == NULL)
    return;
  cJSON *list = cJSON_AddArrayToObject(object, "coordinates");
  for (int64_t i = 0; i < result->model.rank; i++) {
    const thrum_coordinate *coordinate = &result->coordinates[i];
    cJSON *row = json_add_row(list);

    // touch modes that are stepped come into the basis as trained shapes do
    const bool touched = coordinate->kind == THRUM_COORDINATE_TRAINED && touch->shapes > 0;
    cJSON_AddStringToObject(row, "kind", touched ? "touch" : kind_names[coordinate->kind]);
    if (coordinate->kind == THRUM_COORDINATE_MODE)
      json_number(row, "mode", (double)coordinate->mode);
    json_number(row, "share", coordinate->share);
    if (coordinate->kind == THRUM_COORDINATE_DERIVATIVE)
      add_pairs(row, coordinate);
  }

  // those that follow stand behind the others
  for (int64_t i = 0; i < touch->followers.count; i++) {
    cJSON *row = json_add_row(list);
    cJSON_AddStringToObject(row, "kind", "touch");
    json_number(row, "share", 1);
  }
}

static bool is_kind(const cJSON *row, const char *kind) {
  const char *text = json_text_of(row, "kind");
  return text != NULL && strcmp(text, kind) == 0;
}

/* Does the second go on where the first is: the next mode, or one more of a kind without a number?
 */
static bool goes_on(const cJSON *first, const cJSON *second) {
  const char *kind = json_text_of(first, "kind");
  if (kind == NULL || !is_kind(second, kind) || is_kind(first, "derivative"))
    return false;
  return !is_kind(first, "mode") ||
         json_number_of(second, "mode") == json_number_of(first, "mode") + 1;
}

static void print_pairs(const cJSON *row) {
  const cJSON *pair = NULL;
  bool first = true;
  printf("derivatives of modes");
  cJSON_ArrayForEach(pair, cJSON_GetObjectItemCaseSensitive(row, "pairs")) {
    const cJSON *modes = cJSON_GetObjectItemCaseSensitive(pair, "modes");
    const cJSON *i = cJSON_GetArrayItem(modes, 0), *j = cJSON_GetArrayItem(modes, 1);
    const double share = json_number_of(pair, "share");
    if (!cJSON_IsNumber(i) || !cJSON_IsNumber(j) || (!first && !(share >= PAIR_SHOWN)))
      break;
    printf("%s %.0f and %.0f (%.0f %%)", first ? "" : ",", i->valuedouble, j->valuedouble,
           100 * share);
    first = false;
  }
  puts("");
}

/* The name of a run of `count` coordinates that begins with this one. */
static void print_kind(const cJSON *row, int64_t count) {
  const double mode = json_number_of(row, "mode");
  if (is_kind(row, "derivative"))
    print_pairs(row);
  else if (is_kind(row, "mode") && count > 1)
    printf("linear modes %.0f to %.0f\n", mode, mode + (double)count - 1);
  else if (is_kind(row, "mode"))
    printf("linear mode %.0f\n", mode);
  else if (is_kind(row, "handle"))
    puts("of handles: static answers and their derivatives");
  else if (is_kind(row, "trained"))
    puts(count > 1 ? "trained shapes" : "a trained shape");
  else
    puts(count > 1 ? "touch modes" : "a touch mode");
}

void model_coordinates_print(const cJSON *meta, const double *hertz, int64_t rank) {
  const cJSON *list = model_meta_find(meta, NULL, "coordinates");
  if (!cJSON_IsArray(list) || cJSON_GetArraySize(list) != rank)
    return;
  const cJSON *row = list->child;
  for (int64_t n = 0; row != NULL;) {
    const cJSON *last = row;
    int64_t count = 1;
    for (; last->next != NULL && goes_on(last, last->next); last = last->next)
      count++;

    char numbers[48];
    snprintf(numbers, sizeof numbers, count > 1 ? "%" PRId64 " to %" PRId64 : "%" PRId64, n + 1,
             n + count);
    printf("%-18s%-9s%9.5g Hz  ", n == 0 ? "coordinates" : "", numbers, hertz[n]);
    print_kind(row, count);
    n += count;
    row = last->next;
  }
}
