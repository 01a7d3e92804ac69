/* Nodes of Abaqus decks: *NODE in rectangular and cylindrical coordinates, the system of *SYSTEM,
 * and the place of the *INSTANCE. A node that is given again is moved, as in Abaqus.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "core/base/vec3.h"
#include "mesh/formats/mesh_read_abaqus.h"

static const double DEGREE = THRUM_PI / 180;

thrum_status inp_find_node(inp_reader *r, int64_t number, int64_t *vertex) {
  // the map follows the nodes only where one of them is asked for
  for (; r->nodes_mapped < r->builder.vertex_count; r->nodes_mapped++)
    THRUM_TRY(thrum_number_map_add(&r->node_map, r->builder.numbers[r->nodes_mapped],
                                   r->nodes_mapped, r->error));
  *vertex = thrum_number_map_find(&r->node_map, number);
  return THRUM_OK;
}

thrum_status inp_put_node(inp_reader *r, int64_t number, const double position[3], int64_t line) {
  int64_t vertex = -1;
  if (number <= r->node_most)
    THRUM_TRY(inp_find_node(r, number, &vertex));
  else
    r->node_most = number;
  if (vertex < 0)
    return thrum_builder_vertex(&r->builder, number, position, line);

  // a node that is given again is where it was given last
  double *old = r->builder.positions + 3 * vertex;
  if (old[0] != position[0] || old[1] != position[1] || old[2] != position[2]) {
    r->repeated_node = r->repeated_nodes++ > 0 ? r->repeated_node : number;
    memcpy(old, position, 3 * sizeof *old);
  }
  return THRUM_OK;
}

thrum_status inp_check_generated(inp_reader *r, int64_t more) {
  r->generated = more > INP_GENERATED_MAX ? more : r->generated + more;
  return r->generated <= INP_GENERATED_MAX
             ? THRUM_OK
             : thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                               "keywords make more than %d nodes and elements; write the deck with "
                               "all of them",
                               INP_GENERATED_MAX);
}

void inp_leave_system(const inp_reader *r, double position[3]) {
  const inp_system *s = &r->system;
  double place[3];
  if (!s->active)
    return;
  for (int c = 0; c < 3; c++)
    place[c] = s->origin[c] + position[0] * s->axes[0][c] + position[1] * s->axes[1][c] +
               position[2] * s->axes[2][c];
  memcpy(position, place, sizeof place);
}

/* Refuses a parameter SYSTEM that is not read; *cylindrical tells what it says. */
static thrum_status read_system_kind(inp_reader *r, const inp_keyword *keyword, bool *cylindrical) {
  const thrum_word system = inp_parameter_of(keyword, "SYSTEM");
  const char kind = system.length > 0 ? system.text[0] : 'R';
  *cylindrical = kind == 'C' || kind == 'c';
  return *cylindrical || kind == 'R' || kind == 'r'
             ? THRUM_OK
             : thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                               "*NODE, SYSTEM=%s is not read, only R and C; write the nodes in x, "
                               "y, z",
                               thrum_text_excerpt(system).text);
}

thrum_status inp_read_nodes(inp_reader *r, const inp_keyword *keyword) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  const thrum_word set = inp_parameter_of(keyword, "NSET");
  int64_t list = -1;
  bool cylindrical;
  THRUM_TRY(read_system_kind(r, keyword, &cylindrical));
  if (set.length > 0)
    THRUM_TRY(inp_node_list(r, set, &list));

  // coordinates left out are 0; the normal of a shell may follow them
  while (inp_data_line(r)) {
    int64_t number = 0;
    double position[3] = {0};
    THRUM_TRY(inp_integer(r, "the number of a node", 1, &number));
    for (int c = 0; c < 3; c++)
      THRUM_TRY(inp_number(r, axes[c], &position[c]));

    // a radius and an angle in degrees stand in the place of x and y
    if (cylindrical) {
      const double radius = position[0], angle = position[1] * DEGREE;
      position[0] = radius * cos(angle);
      position[1] = radius * sin(angle);
    }
    inp_leave_system(r, position);
    THRUM_TRY(inp_put_node(r, number, position, thrum_included_line(&r->files)));
    if (list >= 0)
      THRUM_TRY(inp_add_node(r, list, number));
  }
  return THRUM_OK;
}

/* Makes a vector one of length 1; false: it has none. */
static bool normalize(double v[3]) {
  const double length = sqrt(thrum_dot3(v, v));
  for (int c = 0; c < 3 && length > 0; c++)
    v[c] /= length;
  return length > 0;
}

/* Finds the axes of a system: the first to point b, the third across the plane that point c is in;
 * without one the third is z and b is taken in the plane of x and y. */
static bool find_axes(const double b[3], const double c[3], bool has_plane, inp_system *system) {
  double *x = system->axes[0], *y = system->axes[1], *z = system->axes[2], in_plane[3];
  for (int axis = 0; axis < 3; axis++) {
    x[axis] = b[axis] - system->origin[axis];
    in_plane[axis] = c[axis] - system->origin[axis];
  }
  z[0] = z[1] = 0;
  z[2] = 1;
  if (has_plane)
    thrum_cross3(x, in_plane, z);
  else
    x[2] = 0;
  if (!normalize(x) || !normalize(z))
    return false;
  thrum_cross3(z, x, y);
  return true;
}

thrum_status inp_read_system(inp_reader *r, const inp_keyword *keyword) {
  double values[9] = {0};
  int counts[2] = {0, 0};
  (void)keyword;

  // points a and b on the first line, and c on the second
  for (int line = 0; line < 2 && inp_data_line(r); line++) {
    for (; counts[line] < (line == 0 ? 6 : 3) && inp_more(r); counts[line]++)
      THRUM_TRY(
          inp_number(r, "a coordinate of a point of the system", &values[6 * line + counts[line]]));
    THRUM_TRY(inp_finish(r, "the points of the system"));
  }

  // without points the coordinates are global again
  r->system = (inp_system){.active = counts[0] > 0, .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  memcpy(r->system.origin, values, sizeof r->system.origin);
  if (counts[0] <= 3)
    return THRUM_OK;
  return find_axes(values + 3, values + 6, counts[1] > 0, &r->system)
             ? THRUM_OK
             : thrum_text_fail(inp_text(r), THRUM_BAD_VALUE,
                               "the points of the *SYSTEM on line %lld lie on one line",
                               (long long)keyword->line);
}

thrum_status inp_read_instance(inp_reader *r, const inp_keyword *keyword) {
  inp_instance *instance = &r->instance;
  const thrum_word name = inp_parameter_of(keyword, "NAME");
  double values[7] = {0};
  if (++r->instance_count > 1)
    return thrum_text_fail(
        inp_text(r), THRUM_UNSUPPORTED,
        "'%s' is a second instance beside '%s': a mesh is one body, so save each instance as a "
        "file of its own",
        thrum_text_excerpt(name).text, thrum_text_excerpt(instance->name).text);
  if (inp_has_parameter(keyword, "LIBRARY") || inp_has_parameter(keyword, "INSTANCE"))
    return thrum_text_fail(inp_text(r), THRUM_UNSUPPORTED,
                           "the *INSTANCE comes from the results of another analysis; write the "
                           "deck with its nodes and elements");
  instance->name = name;
  r->in_instance = true;

  // both lines may be missing, and numbers at their ends
  for (int line = 0; line < 2 && inp_data_line(r); line++) {
    int count = 0;
    for (; count < (line == 0 ? 3 : 7) && inp_more(r); count++)
      THRUM_TRY(inp_number(r, "a number of the instance's place", &values[count]));
    THRUM_TRY(inp_finish(r, "the instance's place"));
    if (line == 1 && count < 7)
      return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                             "a rotation is two points of its axis and an angle, seven numbers");
    memcpy(line == 0 ? instance->move : instance->axis[0], values,
           (line == 0 ? 3 : 6) * sizeof *values);
    instance->degrees = line == 1 ? values[6] : 0;
  }
  return THRUM_OK;
}

/* By Rodrigues' formula: x' = a + R (x - a) for the turn R about the axis from the point a. */
bool inp_turn(const double from[3], const double to[3], double degrees, double point[3]) {
  double along[3], arm[3], across[3];
  for (int c = 0; c < 3; c++) {
    along[c] = to[c] - from[c];
    arm[c] = point[c] - from[c];
  }
  if (degrees == 0)
    return true;
  if (!normalize(along))
    return false;
  thrum_cross3(along, arm, across);
  const double cosine = cos(degrees * DEGREE), sine = sin(degrees * DEGREE);
  const double share = thrum_dot3(along, arm) * (1 - cosine);
  for (int c = 0; c < 3; c++)
    point[c] = from[c] + cosine * arm[c] + sine * across[c] + share * along[c];
  return true;
}

thrum_status inp_place_instance(inp_reader *r) {
  inp_instance *at = &r->instance;

  // Abaqus moves first and turns then, about an axis that does not move
  for (int64_t v = 0; v < r->builder.vertex_count; v++) {
    double *x = r->builder.positions + 3 * v;
    for (int c = 0; c < 3; c++)
      x[c] += at->move[c];
    if (!inp_turn(at->axis[0], at->axis[1], at->degrees, x))
      return thrum_error_set(r->error, THRUM_BAD_VALUE,
                             "%.200s: the instance turns about an axis between equal points",
                             r->files.files[0].path);
  }
  return THRUM_OK;
}
