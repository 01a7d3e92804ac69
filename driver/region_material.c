/* The material of one region of a mesh. SPDX-License-Identifier: Apache-2.0 */
#include "driver/region_material.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/mesh_groups.h"
#include "platform/allocate.h"

/* As the ranges of --young and --density. */
static const double LEAST = 1e-30, MOST = 1e30;

/* Parses a text, into which the result points; THRUM_BAD_FORMAT or THRUM_BAD_VALUE. */
static thrum_status parse_region(const char *text, region_material *material, thrum_error *error) {
  // a name may hold colons, the numbers do not
  const char *colon = strrchr(text, ':'), *end = text + strlen(text);
  double numbers[3];
  const char *at = colon ? colon + 1 : end;
  int count = 0;
  while (count < 3) {
    const size_t used = thrum_text_scan_number(at, end, &numbers[count]);
    if (used == 0 || at[used] != (count < 2 ? ',' : '\0'))
      break;
    at += used + 1;
    count++;
  }
  if (!colon || colon == text || count < 3)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.100s' is no material of a region; write REGION:E,NU,RHO, such as "
                           "steel:2.1e11,0.3,7850",
                           text);

  // NaN is in no range
  if (!(numbers[0] >= LEAST && numbers[0] <= MOST) || !(numbers[1] > -1 && numbers[1] < 0.5) ||
      !(numbers[2] >= LEAST && numbers[2] <= MOST))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.100s': E and RHO are above 0, in Pa and kg/m^3, and NU is between "
                           "-1 and 0.5",
                           text);

  *material = (region_material){text, (size_t)(colon - text), {numbers[0], numbers[1], numbers[2]}};
  return THRUM_OK;
}

thrum_status region_material_option_check(const config_given *given) {
  region_material material;
  thrum_error error = {0};
  return parse_region(given->text, &material, &error) < 0
             ? config_given_refuse(given, "%s", error.message)
             : THRUM_OK;
}

/* Refuses a name that no region has, with those that there are, as far as the line has room. */
static thrum_status unknown_region(const thrum_mesh *mesh, const region_material *material,
                                   thrum_error *error) {
  char list[200] = "";
  size_t length = 0;
  for (int64_t i = 0; i < mesh->region_count; i++) {
    const thrum_region_text name = thrum_mesh_region_text(mesh, i);
    if (length + strlen(name.text) + 8 > sizeof list) {
      memcpy(list + length, ", ...", 6);
      break;
    }
    length +=
        (size_t)snprintf(list + length, sizeof list - length, "%s%s", i > 0 ? ", " : "", name.text);
  }
  return thrum_error_set(error, THRUM_MISSING, "--material: '%s' is no region; the regions are %s",
                         thrum_text_excerpt((thrum_word){material->region, material->length}).text,
                         list);
}

/* Applies one text; named[i] tells regions that had theirs. */
static thrum_status apply(const char *text, thrum_mesh *mesh, bool *named, thrum_error *error) {
  region_material material;
  THRUM_TRY(parse_region(text, &material, error));
  for (int64_t i = 0; i < mesh->region_count; i++) {
    const thrum_region_text name = thrum_mesh_region_text(mesh, i);
    if (strlen(name.text) != material.length ||
        memcmp(name.text, material.region, material.length) != 0)
      continue;

    // two materials for one region contradict each other
    if (named[i])
      return thrum_error_set(error, THRUM_BAD_VALUE, "--material: region '%.100s' comes twice",
                             name.text);
    named[i] = true;
    mesh->materials[i] = material.values;
    return THRUM_OK;
  }
  return unknown_region(mesh, &material, error);
}

thrum_status region_materials_apply(const char *const *texts, int64_t count, thrum_mesh *mesh,
                                    int64_t *lacking, thrum_error *error) {
  bool *named = NULL;
  THRUM_TRY(thrum_reserve(&named, mesh->region_count, sizeof *named, "the materials", error));
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0; n++)
    status = apply(texts[n], mesh, named, error);

  *lacking = 0;
  while (*lacking < mesh->region_count && named[*lacking])
    ++*lacking;
  if (*lacking == mesh->region_count)
    *lacking = -1;
  free(named);
  return status;
}
