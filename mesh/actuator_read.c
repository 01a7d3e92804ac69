/* NAME=SPEC of an actuator, see actuator.h. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/actuator.h"
#include "mesh/mesh_groups.h"
#include "mesh/vertex_places.h"
#include "platform/allocate.h"

enum { NAME_MAX = 60, TEXT_MAX = 4000, NUMBERS_MAX = 6 };

#define OUTSIDE 101325.0 /* usual pressure outside of a gas [Pa] */

/* A spec that is read from the left, and the text that it becomes. */
typedef struct reader {
  const thrum_mesh *mesh;
  const uint8_t *fixed;
  const char *text, *at; /* all of it, and what is left */
  char made[TEXT_MAX];
  size_t length;
  thrum_error *error;
} reader;

void thrum_actuator_free(thrum_actuator *actuator) {
  free(actuator->text);
  thrum_actuator_free_surface(&actuator->surface);
  free(actuator->guides);
  free(actuator->places);
  *actuator = (thrum_actuator){0};
}

static thrum_status refuse(const reader *r, thrum_status status, const char *why) {
  return thrum_error_set(r->error, status, "'%.100s': %s", r->text, why);
}

static void put(reader *r, const char *text, size_t length) {
  const size_t room = sizeof r->made - 1 - r->length;
  length = length < room ? length : room;
  memcpy(r->made + r->length, text, length);
  r->length += length;
  r->made[r->length] = 0;
}

/* Takes the next word up to a comma; false at the end. */
static bool take_word(reader *r, thrum_word *word) {
  if (*r->at == 0)
    return false;
  const size_t length = strcspn(r->at, ",");
  *word = (thrum_word){r->at, length};
  r->at += length + (r->at[length] == ',');
  return true;
}

static bool is(thrum_word word, const char *text) {
  return word.length == strlen(text) && memcmp(word.text, text, word.length) == 0;
}

static bool begins(thrum_word word, const char *text) {
  return word.length > strlen(text) && memcmp(word.text, text, strlen(text)) == 0;
}

static bool number_of(thrum_word word, double *value) {
  return word.length > 0 &&
         thrum_text_scan_number(word.text, word.text + word.length, value) == word.length &&
         isfinite(*value);
}

/* `count` numbers, the rest of the spec. */
static thrum_status take_numbers(reader *r, int count, const char *wanted, double *numbers) {
  thrum_word word;
  for (int n = 0; n < count; n++)
    if (!take_word(r, &word) || !number_of(word, &numbers[n]))
      return refuse(r, THRUM_BAD_FORMAT, wanted);
  return *r->at == 0 ? THRUM_OK : refuse(r, THRUM_BAD_FORMAT, wanted);
}

/* --- chambers --------------------------------------------------------------------------------- */

static thrum_status read_surface(reader *r, bool pressure, bool gas, thrum_actuator *a) {
  thrum_word name, word;
  bool caps = false;
  char group[THRUM_MESH_NAME_MAX + 1];
  if (!take_word(r, &name) || name.length > THRUM_MESH_NAME_MAX)
    return refuse(r, THRUM_BAD_FORMAT, "a group of vertices is wanted, such as chamber:inside");
  memcpy(group, name.text, name.length);
  group[name.length] = 0;
  a->outside = gas ? OUTSIDE : 0;
  while (take_word(r, &word)) {
    if (!pressure && is(word, "cap"))
      caps = true;
    else if (!gas || !begins(word, "outside=") ||
             !number_of((thrum_word){word.text + 8, word.length - 8}, &a->outside) ||
             !(a->outside >= 0))
      return refuse(r, THRUM_BAD_FORMAT,
                    pressure ? "a pressure has a group alone"
                    : gas ? "behind the group of a gas come cap and outside=PA, a pressure of 0 or "
                            "more"
                          : "behind the group of a chamber comes cap");
  }
  const thrum_group *found = thrum_mesh_find_group(r->mesh, group);
  if (!found)
    return thrum_error_set(r->error, THRUM_MISSING, "'%.100s': the mesh has no group '%.100s'",
                           r->text, group);
  put(r, name.text, strlen(name.text));
  return thrum_actuator_find_surface(r->mesh, r->fixed, found, caps, pressure, r->text, &a->surface,
                                     r->error);
}

/* --- strains ---------------------------------------------------------------------------------- */

/* The region of a name, or of a number from 1; -1 for all. */
static thrum_status read_region(reader *r, thrum_actuator *a) {
  thrum_word word;
  int64_t number = 0;
  char made[32];
  if (!take_word(r, &word))
    return refuse(r, THRUM_BAD_FORMAT, "a region is wanted, such as swell:2, or all");
  a->region = -2;
  for (int64_t g = 0; g < r->mesh->region_count && r->mesh->region_names; g++)
    if (r->mesh->region_names[g] && is(word, r->mesh->region_names[g]))
      a->region = (int32_t)g;
  if (a->region < -1 && is(word, "all"))
    a->region = -1;
  if (a->region < -1 &&
      thrum_text_scan_integer(word.text, word.text + word.length, &number) == word.length &&
      number >= 1 && number <= r->mesh->region_count)
    a->region = (int32_t)(number - 1);
  if (a->region < -1)
    return thrum_error_set(
        r->error, THRUM_MISSING,
        "'%.100s': '%.*s' is no region of the mesh, which has %lld: give a name, "
        "a number from 1, or all",
        r->text, (int)(word.length < 60 ? word.length : 60), word.text,
        (long long)r->mesh->region_count);

  // one without elements cannot act
  bool some = a->region < 0 || r->mesh->solid_count > 0;
  for (int64_t t = 0; t < r->mesh->tet_count && !some; t++)
    some = r->mesh->tet_region[t] == a->region;
  if (!some)
    return refuse(r, THRUM_INVALID_ARGUMENT, "the region has no tetrahedra");
  if (r->mesh->solid_count > 0)
    return refuse(r, THRUM_UNSUPPORTED,
                  "regions that strain are those of tetrahedra: give --element tet, which cuts the "
                  "elements");
  if (a->region < 0)
    snprintf(made, sizeof made, "all");
  else
    snprintf(made, sizeof made, "%ld", (long)a->region + 1);
  put(r, made, strlen(made));
  if (*r->at != 0) {
    put(r, ",", 1);
    put(r, r->at, strlen(r->at));
  }
  return THRUM_OK;
}

static thrum_status read_strain(reader *r, int numbers, thrum_actuator *a) {
  double value[NUMBERS_MAX];
  THRUM_TRY(read_region(r, a));
  if (numbers == 0) {
    for (int c = 0; c < 3; c++)
      a->strain[c][c] = 1;
    return *r->at == 0 ? THRUM_OK : refuse(r, THRUM_BAD_FORMAT, "a region alone swells");
  }
  if (numbers == 3) {
    THRUM_TRY(take_numbers(r, 3, "a muscle is REGION,dx,dy,dz", value));
    const double square = value[0] * value[0] + value[1] * value[1] + value[2] * value[2];
    if (!(square > 0) || !isfinite(square))
      return refuse(r, THRUM_BAD_VALUE, "the direction of a muscle is not that of a vector");
    for (int c = 0; c < 3; c++)
      for (int d = 0; d < 3; d++)
        a->strain[c][d] = -value[c] * value[d] / square;
    return THRUM_OK;
  }
  THRUM_TRY(take_numbers(r, 6, "a strain is REGION,exx,eyy,ezz,eyz,exz,exy", value));
  bool some = false;
  for (int n = 0; n < 6; n++) {
    static const int rows[] = {0, 1, 2, 1, 0, 0}, columns[] = {0, 1, 2, 2, 2, 1};
    a->strain[rows[n]][columns[n]] = a->strain[columns[n]][rows[n]] = value[n];
    some = some || value[n] != 0;
  }
  return some ? THRUM_OK : refuse(r, THRUM_BAD_VALUE, "a strain of zero does nothing");
}

/* --- tendons ---------------------------------------------------------------------------------- */

/* The vertex of a number in the file. */
static thrum_status find_vertex(const reader *r, thrum_word word, int32_t *vertex) {
  int64_t number = 0;
  if (word.length == 0 ||
      thrum_text_scan_integer(word.text, word.text + word.length, &number) != word.length)
    return refuse(r, THRUM_BAD_FORMAT, "vertex=N is the number of a vertex");
  *vertex = (int32_t)thrum_mesh_vertex_of(r->mesh, number);
  return *vertex >= 0
             ? THRUM_OK
             : thrum_error_set(r->error, THRUM_INVALID_ARGUMENT,
                               "'%.100s': the mesh has no vertex %lld that an element uses",
                               r->text, (long long)number);
}

/* A guide that begins with this word, which a comma may part. */
static thrum_status read_guide(reader *r, thrum_word word, thrum_actuator *a) {
  const int64_t n = a->guide_count++;
  char made[100];
  int32_t vertex = -1;
  if (begins(word, "vertex=")) {
    THRUM_TRY(find_vertex(r, (thrum_word){word.text + 7, word.length - 7}, &vertex));
  } else {
    const bool near = begins(word, "near:");
    double at[3];
    thrum_word next = {word.text + (near ? 5 : 3), word.length - (near ? 5 : 3)};
    bool good = near || begins(word, "at:");
    for (int axis = 0; axis < 3 && good; axis++) {
      good = (axis == 0 || take_word(r, &next)) && number_of(next, &at[axis]) &&
             fabs(at[axis]) <= THRUM_PLACE_MAX;
    }
    if (!good)
      return refuse(r, THRUM_BAD_FORMAT,
                    "a tendon goes through vertex=N, near:X,Y,Z and at:X,Y,Z, with commas between");
    snprintf(made, sizeof made, "near:%.17g,%.17g,%.17g", at[0], at[1], at[2]);
    memcpy(a->places + 3 * n, at, sizeof at);
    if (near) {
      int32_t *list = NULL;
      int64_t count = 0;
      THRUM_TRY(thrum_vertex_places_list(r->mesh->vertices, r->mesh->vertex_count, made, &list,
                                         &count, r->error));
      vertex = list[0];
      free(list);
    } else {
      snprintf(made, sizeof made, "at:%.17g,%.17g,%.17g", at[0], at[1], at[2]);
    }
  }
  if (vertex >= 0) {
    snprintf(made, sizeof made, "vertex=%ld", (long)vertex + 1);
    memcpy(a->places + 3 * n, r->mesh->vertices + 3 * (int64_t)vertex, 3 * sizeof(double));
  }
  a->guides[n] = vertex;
  put(r, n > 0 ? "," : "", n > 0);
  put(r, made, strlen(made));
  return THRUM_OK;
}

static thrum_status read_tendon(reader *r, thrum_actuator *a) {
  thrum_word word;
  THRUM_TRY(thrum_reserve(&a->guides, THRUM_GUIDES_MAX, sizeof *a->guides, "the tendon", r->error));
  THRUM_TRY(
      thrum_reserve(&a->places, 3 * THRUM_GUIDES_MAX, sizeof *a->places, "the tendon", r->error));
  bool moves = false;
  while (take_word(r, &word)) {
    if (a->guide_count == THRUM_GUIDES_MAX)
      return refuse(r, THRUM_INVALID_ARGUMENT, "a tendon goes through 64 points at most");
    THRUM_TRY(read_guide(r, word, a));
    const int64_t n = a->guide_count - 1;
    moves = moves || (a->guides[n] >= 0 && r->fixed[a->guides[n]] != 7);
    double square = 0;
    for (int axis = 0; axis < 3 && n > 0; axis++)
      square += pow(a->places[3 * n + axis] - a->places[3 * n - 3 + axis], 2);
    if (n > 0 && !(square > 0))
      return refuse(r, THRUM_BAD_VALUE,
                    "two points of a tendon, one behind the other, are the same");
  }
  if (a->guide_count < 2)
    return refuse(r, THRUM_INVALID_ARGUMENT, "a tendon goes through two points at least");
  return moves ? THRUM_OK
               : refuse(r, THRUM_INVALID_ARGUMENT, "nothing that the tendon goes through moves");
}

/* --- all of it -------------------------------------------------------------------------------- */

static thrum_status read_kind(reader *r, thrum_word kind, thrum_actuator *a) {
  if (is(kind, "tendon")) {
    a->kind = THRUM_ACTUATOR_TENDON;
    return read_tendon(r, a);
  }
  if (is(kind, "chamber") || is(kind, "gas") || is(kind, "pressure")) {
    a->kind = is(kind, "gas") ? THRUM_ACTUATOR_GAS : THRUM_ACTUATOR_PRESSURE;
    return read_surface(r, is(kind, "pressure"), is(kind, "gas"), a);
  }
  a->kind = THRUM_ACTUATOR_STRAIN;
  const int numbers = is(kind, "swell")         ? 0
                      : is(kind, "muscle")      ? 3
                      : is(kind, "eigenstrain") ? 6
                                                : -1;
  return numbers >= 0 ? read_strain(r, numbers, a)
                      : refuse(r, THRUM_BAD_FORMAT,
                               "an actuator is NAME=chamber:, pressure:, gas:, muscle:, swell:, "
                               "eigenstrain: or tendon: and what it acts on");
}

static bool is_name(const char *text, size_t length) {
  bool good = length > 0 && length <= NAME_MAX;
  for (size_t n = 0; n < length && good; n++)
    good = (text[n] >= 'a' && text[n] <= 'z') || (text[n] >= 'A' && text[n] <= 'Z') ||
           (text[n] >= '0' && text[n] <= '9') || text[n] == '_' || text[n] == '-' || text[n] == '.';
  return good;
}

thrum_status thrum_actuator_read(const thrum_mesh *mesh, const uint8_t *fixed, const char *text,
                                 thrum_actuator *actuator, thrum_error *error) {
  reader r = {.mesh = mesh, .fixed = fixed, .text = text, .error = error};
  *actuator = (thrum_actuator){0};
  const size_t name = strcspn(text, "=");
  if (!is_name(text, name) || text[name] != '=')
    return refuse(&r, THRUM_BAD_FORMAT,
                  "an actuator is NAME=SPEC, its name of letters, digits, _, - and .");
  if (strlen(text) >= TEXT_MAX / 2)
    return refuse(&r, THRUM_BAD_FORMAT, "it is longer than any actuator");
  const thrum_word kind = {text + name + 1, strcspn(text + name + 1, ":")};
  if (kind.text[kind.length] != ':')
    return refuse(&r, THRUM_BAD_FORMAT, "behind = comes what it is, such as chamber:inside");
  r.at = kind.text + kind.length + 1;
  put(&r, text, (size_t)(r.at - text));
  thrum_status status = read_kind(&r, kind, actuator);
  THRUM_THEN(status, thrum_mesh_keep_text(r.made, r.length, &actuator->text, error));
  if (status < 0)
    thrum_actuator_free(actuator);
  return status;
}
