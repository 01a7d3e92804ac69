/* Elasticity with directions told. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/elastic_report.h"

#include <stdio.h>

#include "core/base/pi.h"
#include "io/json.h"
#include "mesh/elastic.h"

static bool is_of(const double *row, int64_t region) {
  return row[THRUM_ELASTIC_REGION] >= (double)region && row[THRUM_ELASTIC_REGION] <= (double)region;
}

static double degrees_of(const double *row) {
  return row[THRUM_ELASTIC_ANGLE] * 180 / THRUM_PI;
}

void elastic_json(cJSON *material, const double *rows, int64_t count, int64_t region) {
  cJSON *layers = NULL;
  for (int64_t n = 0; n < count; n++) {
    const double *row = rows + THRUM_ELASTIC_NUMBERS * n;
    if (!is_of(row, region))
      continue;
    if (!layers)
      layers = cJSON_AddArrayToObject(material, "elastic");
    cJSON *layer = json_add_row(layers);
    json_numbers(layer, "young_pa", row + THRUM_ELASTIC_YOUNG, 3);
    json_numbers(layer, "poisson", row + THRUM_ELASTIC_POISSON, 3);
    json_numbers(layer, "shear_pa", row + THRUM_ELASTIC_SHEAR, 3);
    json_numbers(layer, "direction", row + THRUM_ELASTIC_FIRST, 3);
    if (row[THRUM_ELASTIC_THICKNESS] > 0) {
      json_number(layer, "angle_degrees", degrees_of(row));
      json_number(layer, "thickness_share", row[THRUM_ELASTIC_THICKNESS]);
    } else {
      json_numbers(layer, "other_direction", row + THRUM_ELASTIC_SECOND, 3);
    }
  }
}

bool elastic_print(const double *rows, int64_t count, int64_t region) {
  int64_t begin = 0, end = 0;
  while (begin < count && !is_of(rows + THRUM_ELASTIC_NUMBERS * begin, region))
    begin++;
  end = begin;
  while (end < count && is_of(rows + THRUM_ELASTIC_NUMBERS * end, region))
    end++;
  if (begin == end)
    return false;
  const double *row = rows + THRUM_ELASTIC_NUMBERS * begin;
  const double *young = row + THRUM_ELASTIC_YOUNG, *nu = row + THRUM_ELASTIC_POISSON;
  const double *shear = row + THRUM_ELASTIC_SHEAR, *along = row + THRUM_ELASTIC_FIRST;
  printf("E = %g, %g, %g Pa, nu 12, 13, 23 = %g, %g, %g, G 12, 13, 23 = %g, %g, %g Pa, direction "
         "1 along %g, %g, %g",
         young[0], young[1], young[2], nu[0], nu[1], nu[2], shear[0], shear[1], shear[2], along[0],
         along[1], along[2]);
  for (int64_t n = begin; n < end && row[THRUM_ELASTIC_THICKNESS] > 0; n++)
    printf("%s%.10g", n == begin ? ", layers " : "/", degrees_of(rows + THRUM_ELASTIC_NUMBERS * n));
  return true;
}
