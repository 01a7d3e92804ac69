/* Loads as the command line names them: KIND:X,Y,Z[@TARGET][,key=value...].
 *
 * The pieces are taken from the right, because a group's name may hold commas and '@' itself: first
 * the key=value pairs, then all that follows the first '@' is the target.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/load_spec.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "mesh/vertex_places.h"
#include "platform/allocate.h"
#include "precompute/model/load_share.h"
#include "precompute/model/traction.h"
#include "thrum/thrum.h"

typedef struct load_kind {
  const char *name;
  thrum_load_shape shape;
  double duration; /* of the window when until= is not given [s] */
} load_kind;

/* The windows of an impulse and of a square are those of the thesis' experiments. */
static const load_kind kinds[] = {
    {"impulse", THRUM_LOAD_CONSTANT, 0.003},    {"square", THRUM_LOAD_CONSTANT, 0.3},
    {"sine", THRUM_LOAD_SINE, INFINITY},        {"constant", THRUM_LOAD_CONSTANT, INFINITY},
    {"gravity", THRUM_LOAD_CONSTANT, INFINITY}, {"traction", THRUM_LOAD_CONSTANT, INFINITY},
    {"ramp", THRUM_LOAD_RAMP, INFINITY},
};
enum { KIND_COUNT = sizeof kinds / sizeof kinds[0] };
enum { GROUPS_LOOKED_AT = 64 }; /* for one whose name is near */

/* The rows of thrum/fields.h that are keys, with their places in a course. */
#define KEY_INDEX(where, kind, name, ...) KEY_INDEX_##where(name)
#define KEY_INDEX_BOTH(name) KEY_##name,
#define KEY_INDEX_CODE(name)
#define KEY_PLACE(where, kind, name, ...) KEY_PLACE_##where(name)
#define KEY_PLACE_BOTH(name) {#name, offsetof(thrum_load, name)},
#define KEY_PLACE_CODE(name)
#define KEY_WORD(where, kind, name, ...) KEY_WORD_##where(name)
#define KEY_WORD_BOTH(name) #name ", "
#define KEY_WORD_CODE(name)
enum { THRUM_COURSE_FIELDS(KEY_INDEX) KEY_COUNT };
static const struct {
  const char *name;
  size_t place;
} keys[KEY_COUNT] = {THRUM_COURSE_FIELDS(KEY_PLACE)};
static const char key_words[] = THRUM_COURSE_FIELDS(KEY_WORD) "f for frequency";

typedef struct key_values {
  bool given[KEY_COUNT];
  double value[KEY_COUNT];
} key_values;

/* The key of a name; KEY_COUNT: there is none. */
static int key_of(const char *name, size_t length) {
  int key = 0;
  if (length == 1 && name[0] == 'f')
    return KEY_frequency;
  while (key < KEY_COUNT &&
         (strlen(keys[key].name) != length || strncmp(keys[key].name, name, length) != 0))
    key++;
  return key;
}

/* Cuts the pairs off the end of `body`. */
static thrum_status take_keys(char *body, const char *said, key_values *values,
                              thrum_error *error) {
  for (char *comma = strrchr(body, ','); comma != NULL; comma = strrchr(body, ',')) {
    char *equals = strchr(comma, '=');
    if (equals == NULL)
      return THRUM_OK;

    // which of the known keys stands before the equals sign
    const size_t length = (size_t)(equals - comma) - 1;
    const int key = key_of(comma + 1, length);
    if (key == KEY_COUNT) {
      // a piece such as "-40@vertex=12" is the end of the vector and the target, no pair
      if (memchr(comma, '@', length + 1) != NULL || length == 0)
        return THRUM_OK;
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s: unknown key '%.*s' (%s)", said,
                             (int)length, comma + 1, key_words);
    }

    // each key once, and with a number
    if (values->given[key]) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s: '%.*s' is given twice", said,
                             (int)length, comma + 1);
    }
    if (!config_parse_number(equals + 1, &values->value[key])) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s: '%s' is not a number", said,
                             equals + 1);
    }

    // taken: the text now ends before the pair
    values->given[key] = true;
    *comma = 0;
  }
  return THRUM_OK;
}

/* The course over time from the kind and the pairs. */
static thrum_status make_course(const load_kind *kind, const key_values *values, const char *said,
                                thrum_load *course, thrum_error *error) {
  // keys that are not given have the defaults of their rows, and the end that of the kind
  *course = (thrum_load){THRUM_COURSE_FIELDS(THRUM_VALUE)};
  course->shape = kind->shape;
  for (int key = 0; key < KEY_COUNT; key++)
    if (values->given[key])
      *(double *)(void *)((char *)course + keys[key].place) = values->value[key];
  if (!values->given[KEY_until])
    course->until = course->from + kind->duration;

  // a frequency belongs to a sine, and a sine needs one
  const bool sine = kind->shape == THRUM_LOAD_SINE;
  if (sine && !(course->frequency > 0)) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s: a sine needs its frequency in Hz, such as f=1", said);
  }
  if (!sine && values->given[KEY_frequency]) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s: only a sine has a frequency f",
                           said);
  }

  if (kind->shape == THRUM_LOAD_RAMP && !isfinite(course->until)) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s: a ramp needs its end in s, such as until=1", said);
  }

  // the window begins in the run and has a length
  if (!(course->from >= 0) || !(course->until > course->from)) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s: the load must begin at 0 s or later and end after that "
                           "(from %g s until %g s)",
                           said, course->from, course->until);
  }
  return THRUM_OK;
}

thrum_status load_target_parse(const char *text, const char *said, load_target *target,
                               thrum_error *error) {
  static const char vertex_key[] = "vertex=";
  load_target parsed = {.all = strcmp(text, "all") == 0};

  // vertex=N counts from 1; any other text is a place or the name of a group
  if (!parsed.all && strncmp(text, vertex_key, sizeof vertex_key - 1) == 0) {
    if (!config_parse_integer(text + sizeof vertex_key - 1, &parsed.vertex) || parsed.vertex < 1) {
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "%.200s: vertex= takes the number of one vertex, from 1", said);
    }
  } else if (!parsed.all) {
    if (text[0] == 0 || strlen(text) >= sizeof parsed.name)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "%.200s: say where: GROUP, vertex=N, near:X,Y,Z, a predicate such as "
                             "'x>0.9', or all",
                             said);
    snprintf(parsed.name, sizeof parsed.name, "%s", text);
    parsed.place = thrum_vertex_places_meant(text);
  }

  *target = parsed;
  return THRUM_OK;
}

/* The vector and the target, from a body without its pairs. */
static thrum_status parse_body(char *body, const load_kind *kind, load_spec *load,
                               thrum_error *error) {
  char *at = strchr(body, '@');
  if (at != NULL)
    *at = 0;

  // the vector's unit depends on the kind
  if (!config_parse_vector3(body, load->vector)) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "--load '%s': '%s' is not x,y,z (%s)",
                           load->text, body,
                           load->gravity    ? "m/s^2"
                           : load->traction ? "Pa"
                                            : "N");
  }

  // gravity acts everywhere, every other load needs its place
  if (load->gravity && at != NULL) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--load '%s': gravity acts on the whole body, leave out '@%s'",
                           load->text, at + 1);
  }
  if (!load->gravity && (at == NULL || at[1] == 0)) {
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "--load '%s': say where it acts: %s:%s@GROUP, @vertex=N, @near:X,Y,Z or @all", load->text,
        kind->name, body);
  }
  if (at == NULL)
    return THRUM_OK;

  // the target's own messages begin with the load
  char said[LOAD_TEXT_MAX + 16];
  snprintf(said, sizeof said, "--load '%s'", load->text);
  return load_target_parse(at + 1, said, &load->target, error);
}

/* The kind that the text begins with, NULL: none. */
static const load_kind *kind_of(const char *text, size_t *name_length) {
  *name_length = strcspn(text, ":");
  for (int n = 0; n < KIND_COUNT && text[*name_length] != 0; n++)
    if (strlen(kinds[n].name) == *name_length && strncmp(kinds[n].name, text, *name_length) == 0)
      return &kinds[n];
  return NULL;
}

bool load_spec_begins(const char *text) {
  size_t name_length = 0;
  return kind_of(text, &name_length) != NULL;
}

thrum_status load_spec_parse(const char *text, load_spec *load, thrum_error *error) {
  char body[LOAD_TEXT_MAX];
  size_t name_length = 0;
  const load_kind *kind = kind_of(text, &name_length);
  if (kind == NULL) {
    const char *names[KIND_COUNT];
    for (int n = 0; n < KIND_COUNT; n++)
      names[n] = kinds[n].name;
    snprintf(body, sizeof body, "%.*s", (int)name_length, text);
    const char *nearest = config_nearest(body, names, KIND_COUNT);
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--load '%.200s': it begins with impulse:, square:, sine:, constant:, "
                           "ramp:, gravity: or traction:%s%s%s",
                           text, nearest != NULL ? "; did you mean " : "",
                           nearest != NULL ? nearest : "", nearest != NULL ? ":?" : "");
  }

  // the text is cut up in a copy
  if (strlen(text) >= sizeof body) {
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "--load '%.60s...': longer than %d bytes",
                           text, LOAD_TEXT_MAX - 1);
  }
  snprintf(body, sizeof body, "%s", text + name_length + 1);
  load_spec parsed = {.text = text,
                      .gravity = strcmp(kind->name, "gravity") == 0,
                      .traction = strcmp(kind->name, "traction") == 0};

  // pairs first: they are at the end, and a group's name may hold commas itself
  char said[LOAD_TEXT_MAX + 16];
  snprintf(said, sizeof said, "--load '%s'", text);
  key_values values = {0};
  THRUM_TRY(take_keys(body, said, &values, error));
  THRUM_TRY(parse_body(body, kind, &parsed, error));
  THRUM_TRY(make_course(kind, &values, said, &parsed.course, error));
  *load = parsed;
  return THRUM_OK;
}

void load_course_numbers(const thrum_load *course, double numbers[LOAD_COURSE_NUMBERS]) {
#define NUMBER(where, kind, name, ...) (double)course->name,
  const double all[LOAD_COURSE_NUMBERS] = {THRUM_COURSE_FIELDS(NUMBER)};
#undef NUMBER
  memcpy(numbers, all, sizeof all);
}

thrum_status load_course_take(const char *kind, char *body, const char *said, thrum_load *course,
                              thrum_error *error) {
  size_t name_length = 0;
  key_values values = {0};
  THRUM_TRY(take_keys(body, said, &values, error));
  return make_course(kind_of(kind, &name_length), &values, said, course, error);
}

thrum_status load_course_parse(const char *text, const char *said, double *strength,
                               thrum_load *course, thrum_error *error) {
  char body[LOAD_TEXT_MAX];
  size_t name_length = 0;
  const load_kind *kind = kind_of(text, &name_length);
  if (kind == NULL || strcmp(kind->name, "gravity") == 0 || strcmp(kind->name, "traction") == 0 ||
      strlen(text) >= sizeof body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%.200s: wanted is constant:LEVEL, ramp:LEVEL,until=S, sine:LEVEL,f=HZ, "
                           "square:LEVEL or impulse:LEVEL",
                           said);
  snprintf(body, sizeof body, "%s", text + name_length + 1);
  double level = 0;
  thrum_load parsed;
  THRUM_TRY(load_course_take(text, body, said, &parsed, error));
  if (!config_parse_number(body, &level))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%.200s: '%.60s' is not a number", said,
                           body);
  *course = parsed;
  *strength = level;
  return THRUM_OK;
}

/* "a, b, c" of the model's groups, cut short with "..." */
static void list_groups(const thrum_model *model, char *list, size_t size) {
  size_t used = 0;
  list[0] = 0;
  for (int64_t n = 0; n < model->group_count; n++) {
    const char *name = thrum_model_group_name(model, n);
    if (name == NULL || used + strlen(name) + 6 > size) {
      snprintf(list + used, size - used, "%s...", n > 0 ? ", " : "");
      return;
    }
    used += (size_t)snprintf(list + used, size - used, "%s%s", n > 0 ? ", " : "", name);
  }
}

bool load_target_equal(const load_target *a, const load_target *b) {
  return a->all == b->all && a->vertex == b->vertex && strcmp(a->name, b->name) == 0;
}

static thrum_status find_vertex(const thrum_model *model, int64_t number, load_vertices *found,
                                thrum_error *error) {
  if (number > model->vertex_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the model has vertices 1 to %lld",
                           (long long)model->vertex_count);
  THRUM_TRY(thrum_reserve(&found->owned, 1, sizeof *found->owned, "the vertex of a load", error));
  found->owned[0] = (int32_t)(number - 1);
  found->count = 1;
  return THRUM_OK;
}

/* Names the group that was meant, where one is near. */
static void near_group(const thrum_model *model, const char *name, char *text, size_t size) {
  const char *names[GROUPS_LOOKED_AT];
  int64_t count = 0;
  for (int64_t n = 0; n < model->group_count && n < GROUPS_LOOKED_AT; n++) {
    names[count] = thrum_model_group_name(model, n);
    count += names[count] != NULL;
  }
  const char *nearest = config_nearest(name, names, count);
  if (nearest != NULL)
    snprintf(text, size, ", did you mean '%.40s'?", nearest);
}

static thrum_status find_group(const thrum_model *model, const char *name, load_vertices *found,
                               thrum_error *error) {
  if (thrum_model_group(model, name, &found->list, &found->count, NULL) >= 0)
    return THRUM_OK;
  char list[160], meant[80] = "";
  list_groups(model, list, sizeof list);
  near_group(model, name, meant, sizeof meant);
  return thrum_error_set(
      error, THRUM_MISSING, "no group '%.60s'%s (one vertex is vertex=N or near:X,Y,Z); %s%s", name,
      meant, list[0] != 0 ? "the model's groups: " : "the model has no groups: use vertex=N or all",
      list);
}

thrum_status load_target_find(const thrum_model *model, const load_target *target,
                              load_vertices *found, thrum_error *error) {
  *found = (load_vertices){0};
  thrum_status status = THRUM_OK;
  if (target->all)
    found->count = model->vertex_count;
  else if (target->vertex > 0)
    status = find_vertex(model, target->vertex, found, error);
  else if (target->place)
    status = thrum_vertex_places_list(model->vertices, model->vertex_count, target->name,
                                      &found->owned, &found->count, error);
  else
    status = find_group(model, target->name, found, error);
  if (found->owned != NULL)
    found->list = found->owned;
  if (status < 0)
    load_vertices_free(found);
  return status;
}

void load_vertices_free(load_vertices *found) {
  free(found->owned);
  *found = (load_vertices){0};
}

thrum_status load_target_list(const thrum_model *model, const load_target *target, int32_t **list,
                              int64_t *count, thrum_error *error) {
  load_vertices found;
  int32_t *made = NULL;
  THRUM_TRY(load_target_find(model, target, &found, error));
  const thrum_status status =
      thrum_reserve(&made, found.count + 1, sizeof *made, "a list of vertices", error);

  // one after the other where all are meant
  for (int64_t n = 0; n < found.count && status >= 0; n++)
    made[n] = found.list != NULL ? found.list[n] : (int32_t)n;
  if (status >= 0) {
    *list = made;
    *count = found.count;
  }
  load_vertices_free(&found);
  return status;
}

static thrum_status reduce_traction(const thrum_model *model, const int32_t *vertices,
                                    int64_t count, const double traction[3], double *reduced,
                                    thrum_error *error) {
  double *forces = NULL;
  THRUM_TRY(thrum_reserve(&forces, 3 * model->vertex_count, sizeof *forces, "the surface", error));
  thrum_status status = thrum_traction_fill(model, vertices, count, traction, forces, NULL, error);
  THRUM_THEN(status, thrum_load_add_field(model, forces, reduced, error));
  free(forces);
  return status;
}

static thrum_status reduce_target(const thrum_model *model, const load_spec *load, double *reduced,
                                  thrum_error *error) {
  load_vertices at;
  if (model->basis == NULL) {
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so no force can act on its vertices");
  }

  // a traction is integrated over the surface, a force is shared by the vertices
  THRUM_TRY(load_target_find(model, &load->target, &at, error));
  const thrum_status status =
      load->traction
          ? reduce_traction(model, at.list, at.count, load->vector, reduced, error)
          : thrum_load_add_shared(model, at.list, at.count, load->vector, reduced, error);
  load_vertices_free(&at);
  return status;
}

thrum_status load_spec_reduce(const thrum_model *model, const load_spec *load, double *reduced,
                              thrum_error *error) {
  memset(reduced, 0, (size_t)model->rank * sizeof *reduced);

  // gravity needs the whole mass matrix, every other load its target
  const thrum_status status = load->gravity
                                  ? thrum_load_add_gravity(model, load->vector, reduced, error)
                                  : reduce_target(model, load, reduced, error);
  return config_error_in(error, status, "--load '%.100s'", load->text);
}

thrum_status load_spec_fill(const thrum_model *model, const load_spec *load, double *forces,
                            thrum_error *error) {
  load_vertices at;
  if (load->gravity)
    return thrum_load_fill_gravity(model, load->vector, forces, error);

  // the same loads as above, as a field on the mesh
  THRUM_TRY(load_target_find(model, &load->target, &at, error));
  const thrum_status status =
      load->traction
          ? thrum_traction_fill(model, at.list, at.count, load->vector, forces, NULL, error)
          : thrum_load_fill(model, at.list, at.count, load->vector, forces, error);
  load_vertices_free(&at);
  return status;
}

int64_t load_target_only(const thrum_model *model, const load_target *target) {
  load_vertices at = {0};
  if (model->vertices == NULL || load_target_find(model, target, &at, NULL) < 0)
    return -1;
  const int64_t only = at.count == 1 && at.list != NULL ? at.list[0] : -1;
  load_vertices_free(&at);
  return only;
}
