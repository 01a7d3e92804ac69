/* Nodes that keywords of Abaqus decks make from others: *NGEN along a line, a parabola or an arc,
 * *NFILL between two sets, *NCOPY by a shift, a turn or a reflection.
 *
 * A parabola through ends a, b and the point c in its middle is, with s from 0 to 1,
 *
 *     x = (1 - s)(1 - 2s) a + 4 s (1 - s) c + s (2s - 1) b .
 *
 * Cost: linear in what is made, which is bounded by INP_GENERATED_MAX.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "mesh/formats/mesh_read_abaqus.h"

/* The place of a node that must be there. */
static thrum_status place_of(inp_reader *r, int64_t number, double place[3]) {
  int64_t vertex = -1;
  THRUM_TRY(inp_find_node(r, number, &vertex));
  if (vertex < 0)
    return thrum_text_fail(inp_text(r), THRUM_MISSING,
                           "node %lld is not above this line, from which others are to be made",
                           (long long)number);
  memcpy(place, r->builder.positions + 3 * vertex, 3 * sizeof *place);
  return THRUM_OK;
}

/* The number of a node that is made; it must be one that a node can have. */
static thrum_status check_number(inp_reader *r, int64_t number) {
  return number >= 1 && number <= INT64_MAX / 4
             ? THRUM_OK
             : thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                               "a node that is made would have the number %lld", (long long)number);
}

/* --- *NGEN -------------------------------------------------------------------------------------
 */

/* A curve from one node to another. */
typedef struct inp_curve {
  char kind; /* 'S' straight, 'P' parabola, 'C' arc of a circle */
  double ends[2][3], extra[3];
  double axis[2][3]; /* of the arc */
  double degrees;
} inp_curve;

/* Finds the axis and the angle of the arc about `extra` from one end to the other. */
static thrum_status find_arc(inp_reader *r, const double normal[3], inp_curve *curve) {
  double arms[2][3], across[3];
  for (int end = 0; end < 2; end++)
    thrum_subtract3(curve->ends[end], curve->extra, arms[end]);
  thrum_cross3(arms[0], arms[1], across);
  const double sine = sqrt(thrum_dot3(across, across)), cosine = thrum_dot3(arms[0], arms[1]);
  const bool given = thrum_dot3(normal, normal) > 0;

  // a normal tells the way round, which may be the longer one; without it the arc is below 180
  if (!given && !(sine > 1e-9 * fabs(cosine)))
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                           "an arc of 180 degrees or more needs the normal of its plane");
  double degrees = atan2(sine, cosine) * (180 / THRUM_PI);
  if (given && thrum_dot3(normal, across) < 0)
    degrees = 360 - degrees;
  if (given && !(sine > 1e-9 * fabs(cosine)))
    degrees = cosine < 0 ? 180 : 360;

  for (int c = 0; c < 3; c++) {
    curve->axis[0][c] = curve->extra[c];
    curve->axis[1][c] = curve->extra[c] + (given ? normal[c] : across[c]);
  }
  curve->degrees = degrees;
  return THRUM_OK;
}

/* A point of the curve at the share s of its way. */
static void point_of(inp_curve *curve, double s, double point[3]) {
  const bool bent = curve->kind == 'P';
  const double first = bent ? (1 - s) * (1 - 2 * s) : 1 - s;
  const double middle = bent ? 4 * s * (1 - s) : 0, last = bent ? s * (2 * s - 1) : s;
  for (int c = 0; c < 3; c++)
    point[c] = first * curve->ends[0][c] + middle * curve->extra[c] + last * curve->ends[1][c];
  if (curve->kind != 'C')
    return;
  memcpy(point, curve->ends[0], 3 * sizeof *point);
  inp_turn(curve->axis[0], curve->axis[1], s * curve->degrees, point);
}

/* Reads the extra point of a curve, a node or coordinates, and the normal behind it. */
static thrum_status read_extra(inp_reader *r, inp_curve *curve) {
  int64_t node = 0;
  double values[6] = {0};
  THRUM_TRY(inp_integer_or(r, "the node of the extra point", 1, &node));
  for (int i = 0; i < 6; i++)
    THRUM_TRY(inp_number(r, "a number of the extra point or the normal", &values[i]));

  // the normal turns with the system, and is not moved with it
  double *normal = values + 3, origin[3] = {0};
  memcpy(curve->extra, values, sizeof curve->extra);
  inp_leave_system(r, curve->extra);
  inp_leave_system(r, normal);
  inp_leave_system(r, origin);
  thrum_subtract3(normal, origin, normal);
  if (node > 0)
    THRUM_TRY(place_of(r, node, curve->extra));
  return curve->kind == 'C' ? find_arc(r, normal, curve) : THRUM_OK;
}

/* Makes the nodes of one line of *NGEN. */
static thrum_status generate_line(inp_reader *r, char kind, int64_t list) {
  inp_curve curve = {.kind = kind};
  int64_t numbers[2] = {0, 0}, step = 1;
  for (int end = 0; end < 2; end++) {
    THRUM_TRY(inp_integer(r, "the number of an end node", 1, &numbers[end]));
    THRUM_TRY(place_of(r, numbers[end], curve.ends[end]));
  }
  THRUM_TRY(inp_integer_or(r, "the step of the numbers", INT64_MIN, &step));
  if (kind != 'S')
    THRUM_TRY(read_extra(r, &curve));
  THRUM_TRY(inp_finish(r, "the line of nodes"));

  // the way from one number to the other must be a whole number of steps, in either direction
  const int64_t way = numbers[1] - numbers[0];
  step = step > 0 && way < 0 ? -step : step;
  if (step == 0 || step == INT64_MIN || way % step != 0 || way / step < 0)
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                           "steps of %lld do not lead from node %lld to node %lld", (long long)step,
                           (long long)numbers[0], (long long)numbers[1]);
  const int64_t steps = way / step;
  THRUM_TRY(inp_check_generated(r, steps));

  for (int64_t i = 0; i <= steps; i++) {
    double point[3];
    const int64_t number = numbers[0] + i * step;
    point_of(&curve, (double)i / (double)(steps > 0 ? steps : 1), point);
    if (i > 0 && i < steps)
      THRUM_TRY(inp_put_node(r, number, point, thrum_included_line(&r->files)));
    if (list >= 0)
      THRUM_TRY(inp_add_node(r, list, number));
  }
  return THRUM_OK;
}

/* Refuses a parameter that is not read, with the way out. */
static thrum_status refuse_parameter(inp_reader *r, const inp_keyword *keyword, const char *key) {
  if (!inp_has_parameter(keyword, key))
    return THRUM_OK;
  return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                         "*%s with %s is not read; write the deck with all of its nodes",
                         thrum_text_excerpt(keyword->name).text, key);
}

thrum_status inp_generate_nodes(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word set = inp_parameter_of(keyword, "NSET");
  const thrum_word line = inp_parameter_of(keyword, "LINE");
  const thrum_word system = inp_parameter_of(keyword, "SYSTEM");
  const char kind = inp_is(line, "P") ? 'P' : inp_is(line, "C") ? 'C' : 'S';
  int64_t list = -1;
  if (line.length > 0 && kind == 'S')
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE, "*NGEN knows LINE=P and LINE=C, not '%s'",
                           thrum_text_excerpt(line).text);
  if (system.length > 0 && !inp_is(system, "RC"))
    THRUM_TRY(refuse_parameter(r, keyword, "SYSTEM"));
  if (set.length > 0)
    THRUM_TRY(inp_node_list(r, set, &list));
  while (inp_data_line(r))
    THRUM_TRY(generate_line(r, kind, list));
  return THRUM_OK;
}

/* --- *NFILL ------------------------------------------------------------------------------------
 */

/* Makes the nodes between one node and another, which are `intervals` apart. */
static thrum_status fill_between(inp_reader *r, int64_t first, int64_t last, int64_t intervals,
                                 int64_t step, int64_t list) {
  double ends[2][3];
  THRUM_TRY(check_number(r, first));
  THRUM_TRY(place_of(r, first, ends[0]));
  THRUM_TRY(place_of(r, last, ends[1]));
  THRUM_TRY(inp_check_generated(r, intervals));
  for (int64_t i = 0; i <= intervals; i++) {
    const int64_t number = i < intervals ? first + i * step : last;
    const double s = (double)i / (double)intervals;
    double point[3];
    for (int c = 0; c < 3; c++)
      point[c] = (1 - s) * ends[0][c] + s * ends[1][c];

    // the ends are there already
    THRUM_TRY(check_number(r, number));
    if (i > 0 && i < intervals)
      THRUM_TRY(inp_put_node(r, number, point, thrum_included_line(&r->files)));
    if (list >= 0)
      THRUM_TRY(inp_add_node(r, list, number));
  }
  return THRUM_OK;
}

/* Reads one line of *NFILL: two sets, the intervals between them, and the step of the numbers. */
static thrum_status fill_line(inp_reader *r, int64_t list) {
  int64_t *nodes[2] = {NULL, NULL}, counts[2] = {0, 0}, intervals = 1, step = 1;
  thrum_status status = THRUM_OK;
  for (int end = 0; end < 2 && status >= 0; end++)
    status = inp_set_nodes(r, inp_word(r), &nodes[end], &counts[end]);
  THRUM_THEN(status, inp_integer(r, "the number of intervals", 1, &intervals));
  THRUM_THEN(status, inp_integer_or(r, "the step of the numbers", -INT32_MAX, &step));
  THRUM_THEN(status, inp_finish(r, "the step of the numbers"));
  if (status >= 0 && (intervals > INP_GENERATED_MAX || step > INT32_MAX || step == 0))
    status = thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                             "%lld intervals in steps of %lld are no nodes to make",
                             (long long)intervals, (long long)step);

  // what one set has more than the other has no partner
  for (int64_t i = 0; i < counts[0] && i < counts[1] && status >= 0; i++)
    status = fill_between(r, nodes[0][i], nodes[1][i], intervals, step, list);
  free(nodes[0]);
  free(nodes[1]);
  return status;
}

thrum_status inp_fill_nodes(inp_reader *r, const inp_keyword *keyword) {
  static const char *const refused[] = {"BIAS", "SINGULAR", "TWO STEP"};
  const thrum_word set = inp_parameter_of(keyword, "NSET");
  int64_t list = -1;
  for (size_t i = 0; i < sizeof refused / sizeof *refused; i++)
    THRUM_TRY(refuse_parameter(r, keyword, refused[i]));
  if (set.length > 0)
    THRUM_TRY(inp_node_list(r, set, &list));
  while (inp_data_line(r))
    THRUM_TRY(fill_line(r, list));
  return THRUM_OK;
}

/* --- *NCOPY ------------------------------------------------------------------------------------
 */

/* How nodes are copied. */
typedef struct inp_motion {
  bool shifts;        /* else reflects */
  int points;         /* that the reflection is at: 1 a point, 2 a line, 3 a plane */
  double move[3];     /* of a shift, before the turn */
  double place[3][3]; /* the points of the reflection; the first two also the axis of the turn */
  double degrees;
} inp_motion;

static thrum_status read_points(inp_reader *r, double *values, int count) {
  for (int i = 0; i < count && inp_more(r); i++)
    THRUM_TRY(inp_number(r, "a number of the copy's place", &values[i]));
  return inp_finish(r, "the copy's place");
}

/* Reads the lines of a motion, which may be left out where they say nothing. */
static thrum_status read_motion(inp_reader *r, inp_motion *motion) {
  double values[9] = {0};
  if (!motion->shifts) {
    if (inp_data_line(r))
      THRUM_TRY(read_points(r, values, motion->points == 1 ? 3 : 6));
    if (motion->points == 3 && inp_data_line(r))
      THRUM_TRY(read_points(r, values + 6, 3));
    memcpy(motion->place, values, sizeof motion->place);
    return THRUM_OK;
  }

  if (inp_data_line(r))
    THRUM_TRY(read_points(r, motion->move, 3));
  if (inp_data_line(r))
    THRUM_TRY(read_points(r, values, 7));
  memcpy(motion->place, values, 6 * sizeof *values);
  motion->degrees = values[6];
  return THRUM_OK;
}

/* Reflects a place at a point, a line or a plane: x' = 2 p - x, with p the point of it that is
 * nearest to x. */
static thrum_status reflect(inp_reader *r, inp_motion *motion, double x[3]) {
  double first[3], second[3], arm[3], nearest[3] = {0, 0, 0}, along[3];
  thrum_subtract3(motion->place[1], motion->place[0], first);
  thrum_subtract3(motion->place[2], motion->place[0], second);
  thrum_subtract3(x, motion->place[0], arm);

  // the nearest point of a line lies along it, of a plane not along its normal
  memcpy(along, first, sizeof along);
  if (motion->points == 3)
    thrum_cross3(first, second, along);
  const double square = thrum_dot3(along, along);
  if (motion->points > 1 && !(square > 0))
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                           "the points of a reflection lie on top of each other or on one line");
  const double share = motion->points > 1 ? thrum_dot3(along, arm) / square : 0;
  for (int c = 0; c < 3; c++) {
    nearest[c] = motion->points == 3 ? arm[c] - share * along[c] : share * along[c];
    x[c] = motion->place[0][c] + 2 * nearest[c] - arm[c];
  }
  return THRUM_OK;
}

/* Reads what a *NCOPY does from its parameters. */
static thrum_status find_motion(inp_reader *r, const inp_keyword *keyword, inp_motion *motion) {
  const thrum_word reflection = inp_parameter_of(keyword, "REFLECT");
  motion->shifts = inp_has_parameter(keyword, "SHIFT");
  motion->points = inp_is(reflection, "POINT")    ? 1
                   : inp_is(reflection, "LINE")   ? 2
                   : inp_is(reflection, "MIRROR") ? 3
                                                  : 0;
  THRUM_TRY(refuse_parameter(r, keyword, "POLE"));
  if (motion->shifts == (motion->points > 0))
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "*NCOPY needs SHIFT or REFLECT=LINE, MIRROR or POINT");

  // whether the shift is in that system or the global one is not said by the format
  return r->system.active
             ? thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                               "*NCOPY is not read below *SYSTEM; put *SYSTEM without data before")
             : THRUM_OK;
}

/* Makes one copy of the nodes, each moved from where the last copy is. */
static thrum_status copy_once(inp_reader *r, const int64_t *nodes, int64_t count, int64_t shift,
                              int64_t step, inp_motion *motion, int64_t list) {
  THRUM_TRY(inp_check_generated(r, count));
  for (int64_t i = 0; i < count; i++) {
    double place[3];
    THRUM_TRY(check_number(r, nodes[i]));
    const int64_t number = nodes[i] + shift + step;
    THRUM_TRY(place_of(r, nodes[i] + shift, place));
    if (motion->shifts) {
      for (int c = 0; c < 3; c++)
        place[c] += motion->move[c];
      if (!inp_turn(motion->place[0], motion->place[1], motion->degrees, place))
        return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                               "*NCOPY turns about an axis between equal points");
    } else {
      THRUM_TRY(reflect(r, motion, place));
    }
    THRUM_TRY(check_number(r, number));
    THRUM_TRY(inp_put_node(r, number, place, thrum_included_line(&r->files)));
    if (list >= 0)
      THRUM_TRY(inp_add_node(r, list, number));
  }
  return THRUM_OK;
}

/* Reads a whole number among the parameters of a keyword. */
static thrum_status parameter_number(inp_reader *r, const inp_keyword *keyword, const char *key,
                                     int64_t *value) {
  const thrum_word word = inp_parameter_of(keyword, key);
  if (!word.text)
    return THRUM_OK;
  thrum_text one = *inp_text(r);
  one.at = word.text;
  one.end = word.text + word.length;
  return thrum_text_integer(&one, key, -INT32_MAX, INT32_MAX, value);
}

thrum_status inp_copy_nodes(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word new_set = inp_parameter_of(keyword, "NEW SET");
  inp_motion motion = {0};
  int64_t *nodes = NULL, count = 0, step = 0, times = 1, list = -1;
  THRUM_TRY(parameter_number(r, keyword, "CHANGE NUMBER", &step));
  THRUM_TRY(parameter_number(r, keyword, "MULTIPLE", &times));
  THRUM_TRY(find_motion(r, keyword, &motion));
  if (step == 0 || times < 1)
    return thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                           "*NCOPY needs CHANGE NUMBER=N, not 0, and MULTIPLE of at least 1");
  if (new_set.length > 0)
    THRUM_TRY(inp_node_list(r, new_set, &list));

  // the list of nodes is a copy, so that the new ones may join the set that they come from
  thrum_status status = inp_set_nodes(r, inp_parameter_of(keyword, "OLD SET"), &nodes, &count);
  THRUM_THEN(status, read_motion(r, &motion));

  // too many are refused before they are made
  if (status >= 0 && motion.shifts && (double)times * (double)count > INP_GENERATED_MAX)
    status = inp_check_generated(r, INP_GENERATED_MAX + 1);
  for (int64_t n = 0; n < (motion.shifts ? times : 1) && count > 0 && status >= 0; n++)
    status = copy_once(r, nodes, count, n * step, step, &motion, list);
  free(nodes);
  return status;
}
