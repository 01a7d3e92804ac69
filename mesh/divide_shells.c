/* The division of solid-shells, see divide_shells.h. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/divide_shells.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_shells.h"
#include "mesh/midsides.h"
#include "mesh/number_map.h"
#include "mesh/solids.h"
#include "platform/allocate.h"

#define WHAT "the elements that wedges are divided into"

enum { SIDES_MAX = 4, PART_NODES = 8, PART_TETS = THRUM_SOLID_TETS_MAX };

typedef struct division {
  thrum_mesh *mesh;
  thrum_number_map edges, faces; /* which have a node, counted from 0 */
  int64_t edge_count, face_count, parts;
  int32_t *ends;  /* of nodes on edges: 2 vertices */
  double *places; /* x 3 */
  /* of nodes on faces; ends: that of the edge across from the least vertex, and that vertex, or two
   * vertices across; see side_key */
  int32_t *face_ends;
  double *face_places;
  thrum_mesh made; /* the new elements */
  thrum_error *error;
} division;

/* The place of the least of so many numbers. */
static int least_of(int count, const int32_t *numbers) {
  int least = 0;
  for (int i = 1; i < count; i++)
    least = numbers[i] < numbers[least] ? i : least;
  return least;
}

/* A face by its least vertex and the edge across, or of four sides by two vertices across. */
static int64_t face_key(const division *d, int sides, const int32_t *corner) {
  const int least = least_of(sides, corner);
  const int32_t across = corner[(least + 2) % sides];
  if (sides == 4)
    return -1 - thrum_edge_number(corner[least], across);
  const int64_t edge =
      thrum_number_map_find(&d->edges, thrum_edge_number(corner[(least + 1) % sides], across));
  return edge << 32 | corner[least];
}

/* Numbers what has no number yet. */
static thrum_status number(thrum_number_map *map, int64_t key, int64_t *count, thrum_error *error) {
  if (thrum_number_map_find(map, key) >= 0)
    return THRUM_OK;
  return thrum_number_map_add(map, key, (*count)++, error);
}

/* Numbers edges and faces. */
static thrum_status number_all(division *d) {
  const thrum_mesh *mesh = d->mesh;
  for (int64_t s = 0; s < mesh->solid_count; s++) {
    const int sides = thrum_mesh_shell_sides(mesh, s);
    const int32_t *node = thrum_mesh_solid_at(mesh, s);
    d->parts += sides;
    for (int i = 0; i < 2 * sides; i++) {
      const int next = i - i % sides + (i + 1) % sides;
      THRUM_TRY(
          number(&d->edges, thrum_edge_number(node[i], node[next]), &d->edge_count, d->error));
    }
    for (int half = 0; half < 2; half++)
      THRUM_TRY(
          number(&d->faces, face_key(d, sides, node + half * sides), &d->face_count, d->error));
  }
  return THRUM_OK;
}

static void put_mean(const thrum_mesh *mesh, int count, const int32_t *of, double place[3]) {
  for (int axis = 0; axis < 3; axis++) {
    place[axis] = 0;
    for (int i = 0; i < count; i++)
      place[axis] += mesh->vertices[3 * (int64_t)of[i] + axis] / count;
  }
}

/* The node of an edge, or of a face, of a part. */
static int32_t edge_node(const division *d, int32_t a, int32_t b) {
  return (int32_t)(d->mesh->vertex_count +
                   thrum_number_map_find(&d->edges, thrum_edge_number(a, b)));
}

static int32_t face_node(const division *d, int sides, const int32_t *corner) {
  return (int32_t)(d->mesh->vertex_count + d->edge_count +
                   thrum_number_map_find(&d->faces, face_key(d, sides, corner)));
}

/* Places of the new nodes of one face of an element, and between which others they are. */
static void place_side(division *d, int sides, const int32_t *corner) {
  for (int i = 0; i < sides; i++) {
    const int32_t pair[2] = {corner[i], corner[(i + 1) % sides]};
    const int64_t edge = edge_node(d, pair[0], pair[1]) - d->mesh->vertex_count;
    memcpy(d->ends + 2 * edge, pair, sizeof pair);
    put_mean(d->mesh, 2, pair, d->places + 3 * edge);
  }

  // a node of an edge is in a group where both vertices are, so two ends stand for three or four
  const int64_t face = face_node(d, sides, corner) - d->mesh->vertex_count - d->edge_count;
  d->face_ends[2 * face] = edge_node(d, corner[0], corner[1]);
  d->face_ends[2 * face + 1] = sides == 3 ? corner[2] : edge_node(d, corner[2], corner[3]);
  put_mean(d->mesh, sides, corner, d->face_places + 3 * face);
}

/* One part of an element, at its corner i, and the tets of that. */
static void put_part(division *d, int64_t s, int i, int64_t part, int64_t *tets) {
  const thrum_mesh *mesh = d->mesh;
  thrum_mesh *made = &d->made;
  const int sides = thrum_mesh_shell_sides(mesh, s);
  int32_t *to = made->solid_nodes + PART_NODES * part;
  for (int half = 0; half < 2; half++) {
    const int32_t *corner = thrum_mesh_solid_at(mesh, s) + half * sides;
    const int32_t next = corner[(i + 1) % sides], before = corner[(i + sides - 1) % sides];
    const int32_t four[4] = {corner[i], edge_node(d, corner[i], next), face_node(d, sides, corner),
                             edge_node(d, before, corner[i])};
    memcpy(to + half * 4, four, sizeof four);
  }

  int64_t numbers[PART_NODES];
  int cut[PART_TETS][4];
  for (int n = 0; n < PART_NODES; n++)
    numbers[n] = to[n];
  const int count = thrum_solid_cut(THRUM_SOLID_HEXAHEDRON, numbers, cut);
  const int64_t from = thrum_mesh_solid_tet(mesh, s);
  for (int t = 0; t < count; t++, ++*tets) {
    for (int c = 0; c < 4; c++)
      made->tets[4 * *tets + c] = to[cut[t][c]];
    made->tet_region[*tets] = mesh->tet_region[from];
    if (made->tet_line)
      made->tet_line[*tets] = mesh->tet_line[from];
    if (made->tet_number)
      made->tet_number[*tets] = mesh->tet_number[from];
  }
  made->solid_form[part] = THRUM_FORM_SHELL8;
  made->solid_ends[part] = (int32_t)(PART_NODES * (part + 1));
  made->solid_tet_ends[part] = (int32_t)*tets;
}

/* Memory of the nodes and the elements. */
static thrum_status reserve_all(division *d) {
  thrum_mesh *made = &d->made;
  const int64_t tets = PART_TETS * d->parts;
  THRUM_TRY(thrum_reserve(&d->ends, d->edge_count, 2 * sizeof *d->ends, WHAT, d->error));
  THRUM_TRY(thrum_reserve(&d->places, d->edge_count, 3 * sizeof *d->places, WHAT, d->error));
  THRUM_TRY(thrum_reserve(&d->face_ends, d->face_count, 2 * sizeof *d->face_ends, WHAT, d->error));
  THRUM_TRY(
      thrum_reserve(&d->face_places, d->face_count, 3 * sizeof *d->face_places, WHAT, d->error));
  THRUM_TRY(thrum_reserve(&made->solid_form, d->parts, 1, WHAT, d->error));
  THRUM_TRY(thrum_reserve(&made->solid_ends, d->parts, sizeof(int32_t), WHAT, d->error));
  THRUM_TRY(thrum_reserve(&made->solid_tet_ends, d->parts, sizeof(int32_t), WHAT, d->error));
  THRUM_TRY(
      thrum_reserve(&made->solid_nodes, d->parts, PART_NODES * sizeof(int32_t), WHAT, d->error));
  THRUM_TRY(thrum_reserve(&made->tets, tets, 4 * sizeof(int32_t), WHAT, d->error));
  THRUM_TRY(thrum_reserve(&made->tet_region, tets, sizeof(int32_t), WHAT, d->error));
  if (d->mesh->tet_line)
    THRUM_TRY(thrum_reserve(&made->tet_line, tets, sizeof(int64_t), WHAT, d->error));
  if (d->mesh->tet_number)
    THRUM_TRY(thrum_reserve(&made->tet_number, tets, sizeof(int64_t), WHAT, d->error));
  return THRUM_OK;
}

/* Old elements and new ones change places. */
static void swap_elements(division *d) {
  thrum_mesh *mesh = d->mesh, *made = &d->made;
  const thrum_mesh old = *mesh;
  mesh->tet_count = made->tet_count;
  mesh->solid_count = made->solid_count;
#define SWAP(member) (mesh->member = made->member, made->member = old.member)
  SWAP(tets);
  SWAP(tet_region);
  SWAP(tet_line);
  SWAP(tet_number);
  SWAP(solid_form);
  SWAP(solid_ends);
  SWAP(solid_nodes);
  SWAP(solid_tet_ends);
#undef SWAP
}

static thrum_status divide(division *d, bool *divided) {
  thrum_mesh *mesh = d->mesh;
  bool sheet = false;
  THRUM_TRY(thrum_mesh_is_sheet(mesh, &sheet, d->error));
  if (!sheet)
    return THRUM_OK;
  THRUM_TRY(number_all(d));
  if (mesh->vertex_count + d->edge_count + d->face_count >= INT32_MAX / 3)
    return THRUM_OK;
  THRUM_TRY(reserve_all(d));
  int64_t parts = 0, tets = 0;
  for (int64_t s = 0; s < mesh->solid_count; s++) {
    const int sides = thrum_mesh_shell_sides(mesh, s);
    for (int half = 0; half < 2; half++)
      place_side(d, sides, thrum_mesh_solid_at(mesh, s) + half * sides);
    for (int i = 0; i < sides; i++)
      put_part(d, s, i, parts++, &tets);
  }
  d->made.solid_count = parts;
  d->made.tet_count = tets;

  // nodes on faces join groups by those on edges, which are there then
  const int64_t old = mesh->vertex_count;
  THRUM_TRY(thrum_midsides_append(mesh, d->ends, d->places, d->edge_count, d->error));
  const thrum_status status =
      thrum_midsides_append(mesh, d->face_ends, d->face_places, d->face_count, d->error);
  if (status < 0) {
    thrum_midsides_undo(mesh);
    return status;
  }
  mesh->made_midsides = mesh->vertex_count - old;
  swap_elements(d);
  *divided = true;
  return THRUM_OK;
}

thrum_status thrum_mesh_divide_shells(thrum_mesh *mesh, bool *divided, thrum_error *error) {
  *divided = false;
  division d = {.mesh = mesh, .error = error};
  const thrum_status status = divide(&d, divided);
  thrum_number_map_free(&d.edges);
  thrum_number_map_free(&d.faces);
  free(d.ends);
  free(d.places);
  free(d.face_ends);
  free(d.face_places);
  thrum_mesh_free(&d.made);
  return status;
}

/* A part has a vertex first in each half, and nodes that were made behind it. */
void thrum_mesh_mark_divided(const thrum_mesh *mesh, uint8_t *marks) {
  enum { GIVEN = 1, ALL = 2 };
  const int64_t first = mesh->vertex_count - mesh->made_midsides;
  for (int64_t v = first; v < mesh->vertex_count; v++)
    marks[v] |= ALL;

  // one vertex of its edge or face that is not marked is enough
  for (int64_t n = 0; n < 2 * mesh->solid_count; n++) {
    const int32_t *four = mesh->solid_nodes + 4 * n;
    for (int c = 1; c < 4 && !(marks[four[0]] & GIVEN); c++)
      marks[four[c]] &= GIVEN;
  }
  for (int64_t v = first; v < mesh->vertex_count; v++)
    marks[v] = marks[v] != 0;
}
