/* The rows of thrum/fields.h as a table. SPDX-License-Identifier: Apache-2.0 */
#include "scene/scene_fields.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "core/base/def.h"
#include "thrum/scene.h"

/* The parts of a body's def, with the state's def among them, for whom has so many bytes of both.
 */
typedef struct body_parts {
  unsigned char *at;
  size_t size, state;
} body_parts;

/* What both have; the cookies are those of `to`. */
static void copy_body(body_parts to, body_parts from) {
  const size_t head = offsetof(thrum_scene_body_def, state);
  const size_t to_tail = to.size - head - to.state, from_tail = from.size - head - from.state;
  memcpy(to.at, from.at, head);
  memcpy(to.at + head, from.at + head, to.state < from.state ? to.state : from.state);
  memcpy(to.at + head + to.state, from.at + head + from.state,
         to_tail < from_tail ? to_tail : from_tail);
  memcpy(to.at, &(uint32_t){(uint32_t)to.size}, sizeof(uint32_t));
  memcpy(to.at + head, &(uint32_t){(uint32_t)to.state}, sizeof(uint32_t));
}

static bool are_sizes(size_t size, size_t state) {
  return state >= THRUM_DEF_LEAST && state <= size &&
         size - state >= offsetof(thrum_scene_body_def, state) &&
         size - state <= sizeof(thrum_scene_body_def) - sizeof(thrum_state_def) &&
         state <= sizeof(thrum_state_def);
}

void thrum_scene_body_def_init(thrum_scene_body_def *def, size_t size, size_t state_size) {
  thrum_scene_body_def defaults = {.cookie = sizeof defaults,
                                   .state = thrum_default_state_def(),
                                   THRUM_BODY_FIELDS(THRUM_VALUE)};
  if (are_sizes(size, state_size))
    copy_body((body_parts){(void *)def, size, state_size},
              (body_parts){(void *)&defaults, sizeof defaults, sizeof defaults.state});
}

const thrum_scene_body_def *scene_body_def_whole(const thrum_scene_body_def *def,
                                                 thrum_scene_body_def *whole) {
  if (def == NULL || def->cookie == sizeof *def)
    return def;

  // a def that is none is refused as such
  *whole = thrum_default_scene_body_def();
  if (def->cookie < offsetof(thrum_scene_body_def, state) + sizeof(uint32_t) ||
      !are_sizes(def->cookie, def->state.cookie))
    return NULL;
  copy_body((body_parts){(void *)whole, sizeof *whole, sizeof whole->state},
            (body_parts){(void *)(uintptr_t)def, def->cookie, def->state.cookie});
  return whole;
}

void thrum_scene_solid_def_init(thrum_scene_solid_def *def, size_t size) {
  const thrum_scene_solid_def defaults = {.cookie = sizeof(thrum_scene_solid_def),
                                          THRUM_SOLID_FIELDS(THRUM_VALUE)};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

void thrum_scene_wind_def_init(thrum_scene_wind_def *def, size_t size) {
  const thrum_scene_wind_def defaults = {.cookie = sizeof(thrum_scene_wind_def),
                                         THRUM_WIND_FIELDS(THRUM_VALUE)};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

void thrum_scene_load_def_init(thrum_scene_load_def *def, size_t size) {
  const thrum_scene_load_def defaults = {
      .cookie = sizeof(thrum_scene_load_def),
      THRUM_LOAD_FIELDS(THRUM_VALUE).course = {THRUM_COURSE_FIELDS(THRUM_VALUE)}};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

void thrum_scene_link_def_init(thrum_scene_link_def *def, size_t size) {
  const thrum_scene_link_def defaults = {
      .cookie = sizeof(thrum_scene_link_def), .other = -1, THRUM_LINK_FIELDS(THRUM_VALUE)};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

#define KIND_NUMBER(value) .kind = THRUM_FIELD_DOUBLE, .width = 1
#define KIND_PAIR(value) .kind = THRUM_FIELD_DOUBLE, .width = 2
#define KIND_VECTOR(value) .kind = THRUM_FIELD_DOUBLE, .width = 3
#define KIND_SPIN(value) .kind = THRUM_FIELD_DOUBLE, .width = 3
#define KIND_ROTATION(value) .kind = THRUM_FIELD_DOUBLE, .width = 4
#define KIND_AXES(value) .kind = THRUM_FIELD_DOUBLE, .width = 9
#define KIND_COLOUR(value) .kind = THRUM_FIELD_FLOAT, .width = 3
#define KIND_COUNT(value) .kind = THRUM_FIELD_INT64, .width = 1
#define KIND_WHOLE(value) .kind = THRUM_FIELD_INT32, .width = 1
#define KIND_FLAG(value) .kind = THRUM_FIELD_FLAG, .width = 1
#define KIND_OBSTACLE_SHAPE(value)                                                                 \
  .kind = THRUM_FIELD_CHOICE, .width = 1, .names = THRUM_NAMES_OBSTACLE_SHAPE
#define KIND_SOLID_SHAPE(value)                                                                    \
  .kind = THRUM_FIELD_CHOICE, .width = 1, .names = THRUM_NAMES_SOLID_SHAPE
#define KIND_LINK_KIND(value) .kind = THRUM_FIELD_CHOICE, .width = 1, .names = THRUM_NAMES_LINK_KIND
#define KIND_LOAD_SHAPE(value)                                                                     \
  .kind = THRUM_FIELD_CHOICE, .width = 1, .names = THRUM_NAMES_LOAD_SHAPE
#define KIND_LOAD_KIND(value) .kind = THRUM_FIELD_CHOICE, .width = 1, .names = THRUM_NAMES_LOAD_KIND
#define COUNTED(value) .count_offset = offsetof(TYPE, THRUM_FIRST value)
#define KIND_DOUBLES(value) .kind = THRUM_FIELD_DOUBLES, .width = THRUM_SECOND value, COUNTED(value)
#define KIND_PLACES(value) .kind = THRUM_FIELD_DOUBLES, .width = THRUM_SECOND value, COUNTED(value)
#define KIND_INTS(value) .kind = THRUM_FIELD_INTS, .width = THRUM_SECOND value, COUNTED(value)
#define KIND_GRID(value) .kind = THRUM_FIELD_GRID, .width = 1, COUNTED(value)

#define RANGE_ANY .least = -INFINITY, .most = INFINITY
#define RANGE_ABOVE_0 .most = INFINITY, .above = 1
#define RANGE_FROM_0 .most = INFINITY
#define RANGE_SHARE .most = 1
#define RANGE_RANK .least = 1, .most = THRUM_RANK_MAX
#define RANGE_SIDES .least = 3, .most = 1024
#define RANGE_SMALL .most = 1e-2, .above = 1

#define KEY_BOTH 1
#define KEY_CODE 0

/* Texts for readers, which what has to be small leaves out. */
#ifdef THRUM_WITHOUT_TEXTS
#define TEXTS(of_unit, text, words)
#else
#define TEXTS(of_unit, text, words) .unit = of_unit, .about = text, .otherwise = words,
#endif

#define FIELD(where, of, member, ...) FIELD_AT(where, of, member, member, __VA_ARGS__)
#define COURSE_FIELD(where, of, member, ...) FIELD_AT(where, of, member, course.member, __VA_ARGS__)
#define FIELD_AT(where, of, member, place, of_unit, value, without, range, text)                   \
  {.name = #member,                                                                                \
   TEXTS(of_unit, text, THRUM_WORDS(of, value, without)) KIND_##of(value),                         \
   RANGE_##range,                                                                                  \
   .key = KEY_##where,                                                                             \
   .offset = offsetof(TYPE, place)},

#define TYPE thrum_scene_body_def
static const thrum_field of_body[] = {THRUM_BODY_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_obstacle
static const thrum_field of_obstacle[] = {THRUM_OBSTACLE_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_scene_solid_def
static const thrum_field of_solid[] = {THRUM_SOLID_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_scene_link_def
static const thrum_field of_link[] = {THRUM_LINK_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_scene_wind_def
static const thrum_field of_wind[] = {THRUM_WIND_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_contact_pairs_def
static const thrum_field of_pairs[] = {THRUM_PAIRS_FIELDS(FIELD)};
#undef TYPE
#define TYPE thrum_scene_load_def
static const thrum_field of_load[] = {THRUM_LOAD_FIELDS(FIELD) THRUM_COURSE_FIELDS(COURSE_FIELD)};
#undef TYPE

/* Each record with its rows, the size of its def, and what makes that. */
static const struct {
  const thrum_field *fields;
  int64_t count;
  size_t size;
  const char *maker;
} records[] = {
#define RECORD(table, type, maker)                                                                 \
  { table, sizeof table / sizeof *table, sizeof(type), maker }
    [THRUM_SCENE_RECORD_BODY] =
        RECORD(of_body, thrum_scene_body_def, "thrum_default_scene_body_def"),
    [THRUM_SCENE_RECORD_OBSTACLE] = RECORD(of_obstacle, thrum_obstacle, "thrum_default_obstacle"),
    [THRUM_SCENE_RECORD_SOLID] =
        RECORD(of_solid, thrum_scene_solid_def, "thrum_default_scene_solid_def"),
    [THRUM_SCENE_RECORD_LINK] =
        RECORD(of_link, thrum_scene_link_def, "thrum_default_scene_link_def"),
    [THRUM_SCENE_RECORD_PAIRS] =
        RECORD(of_pairs, thrum_contact_pairs_def, "thrum_default_contact_pairs_def"),
    [THRUM_SCENE_RECORD_WIND] =
        RECORD(of_wind, thrum_scene_wind_def, "thrum_default_scene_wind_def"),
    [THRUM_SCENE_RECORD_LOAD] =
        RECORD(of_load, thrum_scene_load_def, "thrum_default_scene_load_def"),
#undef RECORD
};

static bool is_record(thrum_scene_record record) {
  return (int)record >= 0 && (size_t)record < sizeof records / sizeof *records;
}

const thrum_field *thrum_scene_fields(thrum_scene_record record, int64_t *count) {
  *count = is_record(record) ? records[record].count : 0;
  return is_record(record) ? records[record].fields : NULL;
}

size_t thrum_scene_record_size(thrum_scene_record record) {
  return is_record(record) ? records[record].size : 0;
}

void thrum_scene_record_default(thrum_scene_record record, void *def) {
  switch (record) {
  case THRUM_SCENE_RECORD_BODY:
    *(thrum_scene_body_def *)def = thrum_default_scene_body_def();
    break;
  case THRUM_SCENE_RECORD_OBSTACLE:
    *(thrum_obstacle *)def = thrum_default_obstacle();
    break;
  case THRUM_SCENE_RECORD_SOLID:
    *(thrum_scene_solid_def *)def = thrum_default_scene_solid_def();
    break;
  case THRUM_SCENE_RECORD_LINK:
    *(thrum_scene_link_def *)def = thrum_default_scene_link_def();
    break;
  case THRUM_SCENE_RECORD_PAIRS:
    *(thrum_contact_pairs_def *)def = thrum_default_contact_pairs_def();
    break;
  case THRUM_SCENE_RECORD_WIND:
    *(thrum_scene_wind_def *)def = thrum_default_scene_wind_def();
    break;
  case THRUM_SCENE_RECORD_LOAD:
    *(thrum_scene_load_def *)def = thrum_default_scene_load_def();
    break;
  }
}

/* Number n of a member that holds numbers. */
static double number_of(const thrum_field *field, const void *def, int32_t n) {
  const char *at = (const char *)def + field->offset;
  switch (field->kind) {
  case THRUM_FIELD_DOUBLE:
    return ((const double *)(const void *)at)[n];
  case THRUM_FIELD_FLOAT:
    return (double)((const float *)(const void *)at)[n];
  case THRUM_FIELD_INT64:
    return (double)*(const int64_t *)(const void *)at;
  default:
    return *(const int32_t *)(const void *)at;
  }
}

static bool is_in_range(const thrum_field *field, double value) {
  return isfinite(value) && value <= field->most &&
         (field->above ? value > field->least : value >= field->least);
}

/* "0 to 1", "above 0" */
static const char *range_words(const thrum_field *field, char words[64]) {
  if (isinf(field->least))
    snprintf(words, 64, "finite");
  else if (isinf(field->most))
    snprintf(words, 64, "finite and %s %g", field->above ? "above" : "at least", field->least);
  else
    snprintf(words, 64, "%s%g to %g", field->above ? "above " : "", field->least, field->most);
  return words;
}

thrum_status scene_fields_check(thrum_scene_record record, const void *def, thrum_error *error) {
  union {
    thrum_scene_body_def body;
    thrum_scene_link_def link;
    thrum_scene_solid_def solid;
    thrum_contact_pairs_def pairs;
    thrum_scene_wind_def wind;
    thrum_scene_load_def load;
    thrum_obstacle obstacle;
  } defaults;
  int64_t count;
  const thrum_field *fields = thrum_scene_fields(record, &count);
  thrum_scene_record_default(record, &defaults);

  // every def begins with its cookie, which is its size
  if (def == NULL || *(const uint32_t *)def != records[record].size)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF, "the def was not made by %s",
                           records[record].maker);

  // arrays have checks of their own
  for (const thrum_field *field = fields; field < fields + count; field++)
    for (int32_t n = 0; field->kind < THRUM_FIELD_CHOICE && n < field->width; n++) {
      const double value = number_of(field, def, n), without = number_of(field, &defaults, n);
      char words[64];
      if (is_in_range(field, value) || value == without || (isnan(value) && isnan(without)))
        continue;
      return thrum_error_set_field(error, field->name, THRUM_BAD_VALUE, " is %g; it must be %s",
                                   value, range_words(field, words));
    }
  return THRUM_OK;
}
