/* Vertices by where they are at rest. Cost: linear in the vertices.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/vertex_places.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "io/text.h"
#include "platform/allocate.h"

#define NEAR "near:"
enum { TERMS_MAX = 32, SHOWN_MAX = 100 };

/* How many bytes of a text a message shows. */
static int shown(size_t length) {
  return length < SHOWN_MAX ? (int)length : SHOWN_MAX;
}

/* One comparison such as x<=0.01. */
typedef struct place_term {
  int axis;
  bool less, equal;
  double bound;
} place_term;

static const char *skip_blanks(const char *at, const char *end) {
  while (at < end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r'))
    at++;
  return at;
}

/* Reads a finite number at *at and moves past it and what is blank behind it. */
static bool read_number(const char **at, const char *end, double *value) {
  const char *p = skip_blanks(*at, end);
  const size_t used = thrum_text_scan_number(p, end, value);
  *at = skip_blanks(p + used, end);
  return used > 0 && fabs(*value) < 1e300;
}

/* Reads one comparison at *at and moves past it; false when there is none. */
static bool read_term(const char **at, const char *end, place_term *term) {
  const char *p = skip_blanks(*at, end);
  if (p == end || *p < 'x' || *p > 'z')
    return false;
  term->axis = *p - 'x';

  // an axis, < or >, perhaps =, and a number
  p = skip_blanks(p + 1, end);
  if (p == end || (*p != '<' && *p != '>'))
    return false;
  term->less = *p++ == '<';
  term->equal = p < end && *p == '=';
  *at = p + term->equal;
  return read_number(at, end, &term->bound);
}

static bool holds(const place_term *term, const double *position) {
  const double x = position[term->axis];
  if (term->equal && x == term->bound)
    return true;
  return term->less ? x < term->bound : x > term->bound;
}

/* Reads terms that are joined by &; their number, 0 where they are none. */
static int read_terms(const char *at, const char *end, place_term terms[TERMS_MAX]) {
  for (int count = 0; count < TERMS_MAX && read_term(&at, end, &terms[count]); count++) {
    if (at == end)
      return count + 1;
    if (*at++ != '&')
      return 0;
  }
  return 0;
}

/* The three numbers behind near: */
static bool read_point(const char *at, const char *end, double point[3]) {
  for (int axis = 0; axis < 3; axis++) {
    if (!read_number(&at, end, &point[axis]))
      return false;
    if (axis < 2 && (at == end || *at++ != ','))
      return false;
  }
  return at == end;
}

/* The box around vertices. */
typedef struct extent {
  double low[3], high[3];
} extent;

static extent extent_of(const double *vertices, int64_t vertex_count) {
  extent box;
  thrum_box3(vertices, vertex_count, box.low, box.high);
  return box;
}

/* Refuses a text by what it does, and says how far the vertices extend. */
static thrum_status refuse_by_extent(const extent *box, const char *text, size_t length,
                                     const char *does, thrum_error *error) {
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "'%.*s' %s, which extends from %g to %g in x, %g to %g in y and %g to %g "
                         "in z [m]",
                         shown(length), text, does, box->low[0], box->high[0], box->low[1],
                         box->high[1], box->low[2], box->high[2]);
}

/* Marks the vertex nearest to a point. A point further away than the vertices are from each other
 * was given in another unit or for another mesh. */
static thrum_status mark_nearest(const double *vertices, int64_t vertex_count, const char *text,
                                 size_t length, const double point[3], uint8_t *marks,
                                 thrum_error *error) {
  double least = INFINITY;
  int64_t nearest = -1;
  for (int64_t v = 0; v < vertex_count; v++) {
    const double *x = vertices + 3 * v;
    const double away = hypot(hypot(x[0] - point[0], x[1] - point[1]), x[2] - point[2]);
    if (away < least) {
      least = away;
      nearest = v;
    }
  }
  for (int64_t v = 0; v < vertex_count; v++)
    marks[v] = v == nearest;

  const extent box = extent_of(vertices, vertex_count);
  const double diagonal =
      hypot(hypot(box.high[0] - box.low[0], box.high[1] - box.low[1]), box.high[2] - box.low[2]);
  return vertex_count == 0 || least <= diagonal
             ? THRUM_OK
             : refuse_by_extent(&box, text, length, "is far from all vertices of the mesh", error);
}

bool thrum_vertex_places_meant(const char *text) {
  return strpbrk(text, "<>") != NULL || strncmp(text, NEAR, sizeof NEAR - 1) == 0;
}

thrum_status thrum_vertex_places_mark(const double *vertices, int64_t vertex_count,
                                      const char *text, size_t length, uint8_t *marks,
                                      thrum_error *error) {
  const char *end = text + length;
  const size_t head = sizeof NEAR - 1;
  if (length >= head && strncmp(text, NEAR, head) == 0) {
    double point[3];
    if (!read_point(text + head, end, point))
      return thrum_error_set(error, THRUM_BAD_FORMAT,
                             "'%.*s' is no point; write its coordinates in metres, such as "
                             "'near:1,0,0.5'",
                             shown(length), text);
    return mark_nearest(vertices, vertex_count, text, length, point, marks, error);
  }

  place_term terms[TERMS_MAX];
  const int count = read_terms(text, end, terms);
  if (count == 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "'%.*s' is no predicate; write comparisons in metres joined by &, "
                           "such as 'x<0.01&z>=0'; --fix alone takes 'x<0.01:yz' too",
                           shown(length), text);

  // all of them must hold
  for (int64_t v = 0; v < vertex_count; v++) {
    marks[v] = 1;
    for (int t = 0; t < count; t++)
      marks[v] = marks[v] && holds(&terms[t], vertices + 3 * v);
  }
  return THRUM_OK;
}

thrum_status thrum_vertex_places_none(const double *vertices, int64_t vertex_count,
                                      const char *text, thrum_error *error) {
  const extent box = extent_of(vertices, vertex_count);
  return refuse_by_extent(&box, text, strlen(text), "names no vertex of the mesh", error);
}

thrum_status thrum_vertex_places_list(const double *vertices, int64_t vertex_count,
                                      const char *text, int32_t **list, int64_t *count,
                                      thrum_error *error) {
  uint8_t *marks = NULL;
  int32_t *found = NULL;
  int64_t marked = 0;
  thrum_status status =
      thrum_reserve(&marks, vertex_count + 1, sizeof *marks, "the vertices of a place", error);
  THRUM_THEN(status, thrum_reserve(&found, vertex_count + 1, sizeof *found,
                                   "the vertices of a place", error));
  THRUM_THEN(status,
             thrum_vertex_places_mark(vertices, vertex_count, text, strlen(text), marks, error));
  for (int64_t v = 0; v < vertex_count && status >= 0; v++)
    if (marks[v])
      found[marked++] = (int32_t)v;
  free(marks);
  if (status >= 0 && marked == 0)
    status = thrum_vertex_places_none(vertices, vertex_count, text, error);
  if (status < 0) {
    free(found);
    return status;
  }
  *list = found;
  *count = marked;
  return THRUM_OK;
}
