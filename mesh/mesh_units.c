/* Systems of units. All of their units are powers of ten of those of SI, and powers up to 10^22 are
 * doubles, so that a number is rounded once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_units.h"

#include <string.h>

#include "mesh/elastic.h"

typedef struct named_power {
  const char *name;
  int power; /* of ten, of the unit of SI */
} named_power;

static const named_power LENGTHS[] = {{"m", 0}, {"cm", -2}, {"mm", -3}, {"um", -6}};
static const named_power MASSES[] = {{"kg", 0}, {"g", -3}, {"t", 3}};
static const named_power TIMES[] = {{"s", 0}, {"ms", -3}};

static bool find_power(const named_power *list, size_t count, const char *name, size_t length,
                       int *power) {
  for (size_t i = 0; i < count; i++)
    if (strlen(list[i].name) == length && memcmp(list[i].name, name, length) == 0) {
      *power = list[i].power;
      return true;
    }
  return false;
}

static double power_of_ten(int power) {
  double value = 1;
  for (int i = 0; i < (power < 0 ? -power : power); i++)
    value *= 10;
  return power < 0 ? 1 / value : value;
}

thrum_status thrum_mesh_unit_read(const char *text, thrum_mesh_unit *unit, thrum_error *error) {
  int length = 0, mass = 0, time = 0;
  const char *first = strchr(text, '-'), *second = first ? strchr(first + 1, '-') : NULL;
  if (!second ||
      !find_power(LENGTHS, sizeof LENGTHS / sizeof *LENGTHS, text, (size_t)(first - text),
                  &length) ||
      !find_power(MASSES, sizeof MASSES / sizeof *MASSES, first + 1, (size_t)(second - first - 1),
                  &mass) ||
      !find_power(TIMES, sizeof TIMES / sizeof *TIMES, second + 1, strlen(second + 1), &time))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.40s' is no unit; write LENGTH-MASS-TIME of m, cm, mm, um; kg, g, t; "
                           "s, ms, such as mm-t-s",
                           text);

  // a pascal is a kilogram by metre and second squared
  *unit = (thrum_mesh_unit){power_of_ten(length), power_of_ten(mass - length - 2 * time),
                            power_of_ten(mass - 3 * length)};
  return THRUM_OK;
}

void thrum_mesh_unit_materials(const thrum_mesh_unit *unit, thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && mesh->has_material; i++) {
    mesh->materials[i].young *= unit->stress;
    mesh->materials[i].density *= unit->density;
  }
  for (int64_t n = 0; n < mesh->elastic_count; n++)
    for (int k = 0; k < 3; k++) {
      mesh->elastic[THRUM_ELASTIC_NUMBERS * n + THRUM_ELASTIC_YOUNG + k] *= unit->stress;
      mesh->elastic[THRUM_ELASTIC_NUMBERS * n + THRUM_ELASTIC_SHEAR + k] *= unit->stress;
    }
}
