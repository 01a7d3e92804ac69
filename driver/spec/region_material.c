/* The material of one region of a mesh. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/region_material.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driver/spec/region_elastic.h"
#include "io/text.h"
#include "mesh/mesh_groups.h"
#include "platform/allocate.h"

/* The range is that of --young and --density. */
static const double LEAST = 1e-30, MOST = 1e30;

/* Reads up to `most` numbers with commas between them, from *at on, which moves behind the comma
 * after the last; returns how many. */
static int scan_numbers(const char **at, const char *end, int most, double *numbers) {
  int count = 0;
  while (count < most && *at < end) {
    const size_t used = thrum_text_scan_number(*at, end, &numbers[count]);
    if (used == 0 || ((*at)[used] != ',' && *at + used != end))
      break;
    *at += used + ((*at)[used] == ',');
    count++;
  }
  return count;
}

/* Reads the law and the yield from `at` on to the end; false where that is neither. */
static bool scan_law(const char *at, const char *end, region_material *material) {
  const char *comma = memchr(at, ',', (size_t)(end - at));
  const char *behind = comma ? comma + 1 : end;
  material->has_law = thrum_law_find(at, (size_t)((comma ? comma : end) - at), &material->law.law);
  if (!material->has_law || !comma)
    return material->has_law;
  return scan_numbers(&behind, end, 1, &material->law.yield) == 1 && behind == end &&
         end[-1] != ',';
}

/* Parses a text, into which the result points; THRUM_BAD_FORMAT or THRUM_BAD_VALUE. */
static thrum_status parse_region(const char *text, region_material *material, thrum_error *error) {
  // a name may hold colons, what is behind it does not
  const char *colon = strrchr(text, ':'), *end = text + strlen(text);
  const char *at = colon ? colon + 1 : end;
  double numbers[3] = {0};
  region_material made = {.region = text, .length = colon ? (size_t)(colon - text) : 0};
  if (made.length > 0 && region_elastic_is(at, end)) {
    region_elastic elastic;
    THRUM_TRY(region_elastic_parse(text, at, end, &elastic, error));
    made.elastic = at;
    *material = made;
    return THRUM_OK;
  }
  const int count = scan_numbers(&at, end, 3, numbers);
  const bool whole = at == end ? count == 3 && end[-1] != ','
                               : (count == 0 || count == 3) && scan_law(at, end, &made);
  if (made.length == 0 || !whole)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.100s' is no material of a region; write REGION:E,NU,RHO, such as "
                           "steel:2.1e11,0.3,7850, or REGION:LAW, such as rubber:neo-hookean, or "
                           "REGION:LAW,YIELD",
                           text);

  // NaN is in no range
  if (count == 3 &&
      (!(numbers[0] >= LEAST && numbers[0] <= MOST) || !(numbers[1] > -1 && numbers[1] < 0.5) ||
       !(numbers[2] >= LEAST && numbers[2] <= MOST)))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.100s': E and RHO are above 0, in Pa and kg/m^3, and NU is between "
                           "-1 and 0.5",
                           text);
  const bool yields = made.has_law && memchr(at, ',', (size_t)(end - at));
  if (yields && made.law.law == THRUM_LAW_STVK)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "'%.100s': stvk has no yield; corotational and neo-hookean have", text);
  if (yields && !(made.law.yield > 0 && made.law.yield <= MOST))
    return thrum_error_set(error, THRUM_BAD_VALUE, "'%.100s': YIELD is a strain, above 0", text);

  made.values = (thrum_material){numbers[0], numbers[1], numbers[2]};
  *material = made;
  return THRUM_OK;
}

thrum_status region_material_check(const char *text, thrum_error *error) {
  region_material material;
  return parse_region(text, &material, error);
}

thrum_status region_material_option_check(const config_given *given) {
  thrum_error error = {0};
  return region_material_check(given->text, &error) < 0
             ? config_given_refuse(given, "%s", error.message)
             : THRUM_OK;
}

/* Whether all regions are called by their numbers. */
static bool are_numbered(const thrum_mesh *mesh) {
  bool numbered = true;
  char number[24];
  for (int64_t i = 0; i < mesh->region_count && numbered; i++) {
    snprintf(number, sizeof number, "%lld", (long long)i + 1);
    numbered = strcmp(thrum_mesh_region_text(mesh, i).text, number) == 0;
  }
  return numbered;
}

/* Refuses a name that no region has, with those that there are, as far as the line has room. */
static thrum_status unknown_region(const thrum_mesh *mesh, const region_material *material,
                                   thrum_error *error) {
  char list[200] = "";
  size_t length = 0;
  if (are_numbered(mesh) && mesh->region_count > 1)
    return thrum_error_set_field(
        error, "--material", THRUM_MISSING, ": '%s' is no region; regions are 1 to %lld",
        thrum_text_excerpt((thrum_word){material->region, material->length}).text,
        (long long)mesh->region_count);
  for (int64_t i = 0; i < mesh->region_count; i++) {
    const thrum_region_text name = thrum_mesh_region_text(mesh, i);
    if (length + strlen(name.text) + 8 > sizeof list) {
      memcpy(list + length, ", ...", 6);
      break;
    }
    length +=
        (size_t)snprintf(list + length, sizeof list - length, "%s%s", i > 0 ? ", " : "", name.text);
  }
  return thrum_error_set_field(
      error, "--material", THRUM_MISSING, ": '%s' is no region; %s %s",
      thrum_text_excerpt((thrum_word){material->region, material->length}).text,
      mesh->region_count == 1 ? "the only region is" : "the regions are", list);
}

/* A region as the texts so far have it. */
typedef struct region_given {
  bool named, moduli;
  thrum_region_law law;
} region_given;

/* Gives a region elasticity with directions. */
static thrum_status apply_elastic(const char *text, const region_material *material,
                                  thrum_mesh *mesh, int64_t region, thrum_error *error) {
  region_elastic elastic;
  THRUM_TRY(region_elastic_parse(text, material->elastic, text + strlen(text), &elastic, error));
  THRUM_TRY(thrum_mesh_set_elastic(mesh, region, elastic.rows, elastic.count, error));
  mesh->materials[region].density = elastic.density;
  return THRUM_OK;
}

/* Applies one text. */
static thrum_status apply(const char *text, thrum_mesh *mesh, region_given *given,
                          thrum_error *error) {
  region_material material;
  THRUM_TRY(parse_region(text, &material, error));
  for (int64_t i = 0; i < mesh->region_count; i++) {
    const thrum_region_text name = thrum_mesh_region_text(mesh, i);
    if (strlen(name.text) != material.length ||
        memcmp(name.text, material.region, material.length) != 0)
      continue;

    // two materials for one region contradict each other
    if (given[i].named)
      return thrum_error_set_field(error, "--material", THRUM_BAD_VALUE,
                                   ": region '%.100s' comes twice", name.text);
    given[i].named = true;
    given[i].moduli = material.values.young > 0 || material.elastic;
    if (material.elastic)
      THRUM_TRY(apply_elastic(text, &material, mesh, i, error));
    else if (given[i].moduli) {
      mesh->materials[i] = material.values;
      THRUM_TRY(thrum_mesh_set_elastic(mesh, i, NULL, 0, error));
    }
    if (material.has_law)
      given[i].law = material.law;
    return THRUM_OK;
  }
  return unknown_region(mesh, &material, error);
}

/* Whether one of the texts has a law, or one but Saint Venant-Kirchhoff's. */
static bool have_laws(const char *const *texts, int64_t count, bool other) {
  for (int64_t n = 0; n < count; n++) {
    region_material material;
    if (parse_region(texts[n], &material, NULL) >= 0 && material.has_law &&
        (!other || material.law.law != THRUM_LAW_STVK))
      return true;
  }
  return false;
}

bool region_materials_have_laws(const char *const *texts, int64_t count) {
  return have_laws(texts, count, false);
}

bool region_materials_need_points(const char *const *texts, int64_t count) {
  return have_laws(texts, count, true);
}

bool region_materials_flow(const char *const *texts, int64_t count) {
  bool flow = false;
  region_material material;
  for (int64_t n = 0; n < count && !flow; n++)
    flow = parse_region(texts[n], &material, NULL) >= 0 && material.law.yield > 0;
  return flow;
}

/* Whether all regions have one law, and none a yield of its own. */
static bool are_one(const region_given *given, int64_t count) {
  for (int64_t i = 0; i < count; i++)
    if (given[i].law.law != given[0].law.law || given[i].law.yield > 0)
      return false;
  return true;
}

/* Leaves the laws in the mesh where they are several. */
static thrum_status keep_laws(const region_given *given, thrum_mesh *mesh, thrum_law *law,
                              thrum_error *error) {
  free(mesh->laws);
  mesh->laws = NULL;
  if (are_one(given, mesh->region_count)) {
    *law = given[0].law.law;
    return THRUM_OK;
  }
  THRUM_TRY(thrum_reserve(&mesh->laws, mesh->region_count, sizeof *mesh->laws, "the laws", error));
  for (int64_t i = 0; i < mesh->region_count; i++)
    mesh->laws[i] = given[i].law;
  *law = THRUM_LAW_BY_REGION;
  return THRUM_OK;
}

thrum_status region_materials_apply(const char *const *texts, int64_t count, thrum_mesh *mesh,
                                    thrum_law *law, int64_t *lacking, thrum_error *error) {
  region_given *given = NULL;
  THRUM_TRY(thrum_reserve(&given, mesh->region_count, sizeof *given, "the materials", error));
  for (int64_t i = 0; i < mesh->region_count; i++)
    given[i].law = mesh->laws ? mesh->laws[i] : (thrum_region_law){.law = *law};

  // the texts, one after the other
  thrum_status status = THRUM_OK;
  for (int64_t n = 0; n < count && status >= 0; n++)
    status = apply(texts[n], mesh, given, error);
  THRUM_THEN(status, keep_laws(given, mesh, law, error));

  // the first region whose moduli none of them has
  *lacking = 0;
  while (*lacking < mesh->region_count && given[*lacking].moduli)
    ++*lacking;
  if (*lacking == mesh->region_count)
    *lacking = -1;
  free(given);
  return status;
}
