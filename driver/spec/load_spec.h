/* Loads as the command line names them: KIND:X,Y,Z[@TARGET][,key=value...].
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_LOAD_SPEC_H
#define THRUM_DRIVER_SPEC_LOAD_SPEC_H

#include <stdbool.h>
#include <stdint.h>

#include "thrum/thrum.h"

#define LOAD_TEXT_MAX 512

/* Vertices of a model: all, vertex=N, a place (mesh/vertex_places.h) or a group. */
typedef struct load_target {
  bool all;
  int64_t vertex;           /* 1-based; 0: another kind */
  bool place;               /* `name` is a place, not a group */
  char name[LOAD_TEXT_MAX]; /* of the group, or the place */
} load_target;

/* The vertices that were found. */
typedef struct load_vertices {
  const int32_t *list; /* count, ascending; NULL: all of the model */
  int64_t count;
  int32_t *owned; /* what of the list was made for it */
} load_vertices;

/* The numbers of a course, whose bits tell it from others. */
#define LOAD_COURSE_ONE(...) +1
enum { LOAD_COURSE_NUMBERS = THRUM_COURSE_FIELDS(LOAD_COURSE_ONE) };
void load_course_numbers(const thrum_load *course, double numbers[LOAD_COURSE_NUMBERS]);

/* One parsed load. `text` is borrowed from argv. */
typedef struct load_spec {
  const char *text;
  bool gravity;       /* vector is an acceleration [m/s^2] on the whole body, not a force [N] */
  bool traction;      /* vector is a force an area [Pa] on the surface of the target */
  double vector[3];   /* the total over the target */
  load_target target; /* none of gravity */
  thrum_load course;
} load_spec;

/* Parses a target. `said` is the option that it stands in, for the message. *target is untouched on
 * failure, a mistake of usage. */
thrum_status load_target_parse(const char *text, const char *said, load_target *target,
                               thrum_error *error);

/* Do both name the same? */
bool load_target_equal(const load_target *a, const load_target *b);

/* Finds the vertices of a target in the model, which must stay; load_vertices_free frees. */
thrum_status load_target_find(const thrum_model *model, const load_target *target,
                              load_vertices *found, thrum_error *error);
void load_vertices_free(load_vertices *found);

/* The only vertex of a target (0-based); -1: it has more, or is not in the model. */
int64_t load_target_only(const thrum_model *model, const load_target *target);

/* The same as a list of its own, also of all vertices, for functions to which no list means another
 * thing. The caller frees *list. */
thrum_status load_target_list(const thrum_model *model, const load_target *target, int32_t **list,
                              int64_t *count, thrum_error *error);

/* Does the text begin as a load does? */
bool load_spec_begins(const char *text);

/* Parses a load; a failure is a mistake of usage. *load is untouched then. */
thrum_status load_spec_parse(const char *text, load_spec *load, thrum_error *error);

/* Cuts the pairs [,key=value...] off the end of `body` and makes the course of a load that begins
 * as `kind` does ("sine:"); as load_course_parse. */
thrum_status load_course_take(const char *kind, char *body, const char *said, thrum_load *course,
                              thrum_error *error);

/* Parses a strength with its course over time, KIND:STRENGTH[,key=value...], in the same words.
 * `said` begins the message of a failure, which is a mistake of usage. */
thrum_status load_course_parse(const char *text, const char *said, double *strength,
                               thrum_load *course, thrum_error *error);

/* reduced (rank) = U^T of the load at its full strength, zero where all of its vertices are held.
 * Fails when the model has no such group or vertex, or no basis. */
thrum_status load_spec_reduce(const thrum_model *model, const load_spec *load, double *reduced,
                              thrum_error *error);

/* forces (3 vertex_count) [N] += the load at its full strength, gravity too. */
thrum_status load_spec_fill(const thrum_model *model, const load_spec *load, double *forces,
                            thrum_error *error);

#endif
