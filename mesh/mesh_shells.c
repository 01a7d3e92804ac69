/* Thin elements, see mesh_shells.h. Cost: linear in the solids. SPDX-License-Identifier: Apache-2.0
 */
#include "mesh/mesh_shells.h"

#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/number_map.h"

/* The corner of a hexahedron on each side along its three directions. */
static const int corner_of[2][2][2] = {{{0, 4}, {3, 7}}, {{1, 5}, {2, 6}}};

static double distance(const thrum_mesh *mesh, int32_t from, int32_t to) {
  double edge[3];
  thrum_subtract3(mesh->vertices + 3 * (int64_t)to, mesh->vertices + 3 * (int64_t)from, edge);
  return sqrt(thrum_dot3(edge, edge));
}

/* The mean lengths of a hexahedron along its three directions. */
static void hexahedron_lengths(const thrum_mesh *mesh, const int32_t *nodes, double lengths[3]) {
  memset(lengths, 0, 3 * sizeof *lengths);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++) {
      lengths[0] += distance(mesh, nodes[corner_of[0][i][j]], nodes[corner_of[1][i][j]]) / 4;
      lengths[1] += distance(mesh, nodes[corner_of[i][0][j]], nodes[corner_of[i][1][j]]) / 4;
      lengths[2] += distance(mesh, nodes[corner_of[i][j][0]], nodes[corner_of[i][j][1]]) / 4;
    }
}

/* Turns a hexahedron so that direction `axis` becomes its last one; the winding stays. */
static void turn_hexahedron(int32_t *nodes, int axis) {
  int32_t old[8];
  memcpy(old, nodes, sizeof old);
  for (int i = 0; i < 2; i++)
    for (int j = 0; j < 2; j++)
      for (int k = 0; k < 2; k++)
        nodes[corner_of[i][j][k]] = axis == 0 ? old[corner_of[k][i][j]] : old[corner_of[j][k][i]];
}

/* Is a hexahedron thin? Then its thickness comes last. */
static bool take_hexahedron(const thrum_mesh *mesh, int32_t *nodes, double thin) {
  double lengths[3];
  hexahedron_lengths(mesh, nodes, lengths);
  int axis = 2;
  for (int d = 0; d < 2; d++)
    axis = lengths[d] < (1 - 1e-9) * lengths[axis] ? d : axis;
  if (!(lengths[axis] < thin * fmin(lengths[(axis + 1) % 3], lengths[(axis + 2) % 3])))
    return false;
  if (axis < 2)
    turn_hexahedron(nodes, axis);
  return true;
}

static bool is_thin_wedge(const thrum_mesh *mesh, const int32_t *nodes, double thin) {
  double thickness = 0, side = 0;
  for (int c = 0; c < 3; c++) {
    thickness += distance(mesh, nodes[c], nodes[c + 3]) / 3;
    for (int half = 0; half < 2; half++)
      side += distance(mesh, nodes[3 * half + c], nodes[3 * half + (c + 1) % 3]) / 6;
  }
  return thickness < thin * side;
}

int64_t thrum_mesh_choose_shells(thrum_mesh *mesh, double thin) {
  int64_t thin_ones = 0;
  for (int64_t s = 0, first = 0; s < mesh->solid_count; first = mesh->solid_ends[s++]) {
    int32_t *nodes = mesh->solid_nodes + first;
    uint8_t *form = &mesh->solid_form[s];
    if (*form == THRUM_FORM_HEX8 && take_hexahedron(mesh, nodes, thin))
      *form = THRUM_FORM_SHELL8;
    else if (*form == THRUM_FORM_WEDGE6 && is_thin_wedge(mesh, nodes, thin))
      *form = THRUM_FORM_SHELL6;
    thin_ones += *form == THRUM_FORM_SHELL8 || *form == THRUM_FORM_SHELL6;
  }
  return thin_ones;
}

static bool is_shell(const thrum_mesh *mesh, int64_t s) {
  return mesh->solid_form[s] == THRUM_FORM_SHELL8 || mesh->solid_form[s] == THRUM_FORM_SHELL6;
}

/* Adds the edges of both faces of a solid-shell. */
static thrum_status add_edges(const thrum_mesh *mesh, int64_t s, thrum_number_map *along,
                              thrum_error *error) {
  const int32_t *node = thrum_mesh_solid_at(mesh, s);
  const int sides = thrum_mesh_shell_sides(mesh, s);
  for (int n = 0; n < 2 * sides; n++) {
    const int next = n - n % sides + (n + 1) % sides;
    const int64_t edge = thrum_edge_number(node[n], node[next]);
    if (thrum_number_map_find(along, edge) < 0)
      THRUM_TRY(thrum_number_map_add(along, edge, 0, error));
  }
  return THRUM_OK;
}

thrum_status thrum_mesh_is_sheet(const thrum_mesh *mesh, bool *sheet, thrum_error *error) {
  bool is = true;
  for (int64_t s = 0; s < mesh->solid_count; s++)
    is = is && is_shell(mesh, s);

  // all edges along faces first, and then those across
  thrum_number_map along = {0};
  thrum_status status = THRUM_OK;
  for (int64_t s = 0; s < mesh->solid_count && is && status >= 0; s++)
    status = add_edges(mesh, s, &along, error);
  for (int64_t s = 0; s < mesh->solid_count && is && status >= 0; s++) {
    const int32_t *node = thrum_mesh_solid_at(mesh, s);
    for (int n = 0, sides = thrum_mesh_shell_sides(mesh, s); n < sides; n++)
      is = is && thrum_number_map_find(&along, thrum_edge_number(node[n], node[n + sides])) < 0;
  }
  thrum_number_map_free(&along);
  if (status >= 0)
    *sheet = is;
  return status;
}
