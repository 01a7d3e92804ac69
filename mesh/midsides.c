/* Middle nodes of edges, by a hash table of the edges. Cost: linear in the mesh; about 60 bytes a
 * tet.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/midsides.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "platform/allocate.h"

/* An edge by its ends, the lower vertex first; middle -1 marks a free slot. */
typedef struct edge_slot {
  int32_t low, high, middle;
} edge_slot;

typedef struct edge_table {
  edge_slot *slots;
  uint64_t slot_count; /* a power of two */
  int64_t used;
} edge_table;

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the middle nodes");
}

static bool table_resize(edge_table *table, uint64_t slot_count) {
  edge_table larger = {malloc(slot_count * sizeof *larger.slots), slot_count, table->used};
  if (!larger.slots)
    return false;
  for (uint64_t i = 0; i < slot_count; i++)
    larger.slots[i].middle = -1;

  // every edge finds its place anew
  for (uint64_t i = 0; i < table->slot_count; i++) {
    const edge_slot edge = table->slots[i];
    if (edge.middle < 0)
      continue;
    uint64_t slot =
        ((uint64_t)(uint32_t)edge.low << 32 | (uint32_t)edge.high) * UINT64_C(0x9e3779b97f4a7c15) >>
        24;
    for (slot &= slot_count - 1; larger.slots[slot].middle >= 0;)
      slot = (slot + 1) & (slot_count - 1);
    larger.slots[slot] = edge;
  }
  free(table->slots);
  *table = larger;
  return true;
}

/* The slot of an edge, which is added without a middle node where it is new; NULL: no memory. */
static edge_slot *find_edge(edge_table *table, int32_t a, int32_t b) {
  // the table stays at most half full, so that searches in it are short
  if (2 * (uint64_t)(table->used + 1) > table->slot_count &&
      !table_resize(table, table->slot_count > 0 ? 2 * table->slot_count : 64))
    return NULL;

  const int32_t low = a < b ? a : b, high = a < b ? b : a;
  uint64_t slot =
      ((uint64_t)(uint32_t)low << 32 | (uint32_t)high) * UINT64_C(0x9e3779b97f4a7c15) >> 24;
  for (slot &= table->slot_count - 1; table->slots[slot].middle >= 0;
       slot = (slot + 1) & (table->slot_count - 1))
    if (table->slots[slot].low == low && table->slots[slot].high == high)
      return &table->slots[slot];
  table->slots[slot].low = low;
  table->slots[slot].high = high;
  return &table->slots[slot];
}

/* The ends of edge e of tet t. */
static const int32_t *corner_of(const thrum_mesh *mesh, int64_t t, int e, int end) {
  return mesh->tets + 4 * t + thrum_quadratic_edges[e][end];
}

/* --- making -------------------------------------------------------------------------------------
 */

thrum_status thrum_midsides_number(const thrum_mesh *mesh, int32_t *midsides, int64_t *count,
                                   thrum_error *error) {
  edge_table table = {0};
  thrum_status status = THRUM_OK;

  // the first tetrahedron that meets an edge numbers it
  for (int64_t i = 0; i < 6 * mesh->tet_count && status >= 0; i++) {
    const int64_t t = i / 6;
    const int e = (int)(i % 6);
    edge_slot *edge = find_edge(&table, *corner_of(mesh, t, e, 0), *corner_of(mesh, t, e, 1));
    if (!edge) {
      status = no_memory(error);
    } else if (edge->middle < 0 && mesh->vertex_count + table.used >= INT32_MAX / 3) {
      status = thrum_error_set(error, THRUM_UNSUPPORTED,
                               "the mesh would have more than 2^31 components with middle nodes");
    } else {
      if (edge->middle < 0)
        edge->middle = (int32_t)(mesh->vertex_count + table.used++);
      midsides[i] = edge->middle;
    }
  }
  *count = table.used;
  free(table.slots);
  return status;
}

/* Tells the ends of the edge of each middle node, and the place between them. */
static void place_middles(const thrum_mesh *mesh, const int32_t *midsides, int32_t *ends,
                          double *places) {
  for (int64_t i = 0; i < 6 * mesh->tet_count; i++) {
    const int32_t a = *corner_of(mesh, i / 6, (int)(i % 6), 0);
    const int32_t b = *corner_of(mesh, i / 6, (int)(i % 6), 1);
    const int64_t edge = midsides[i] - mesh->vertex_count;
    for (int axis = 0; axis < 3; axis++)
      places[3 * edge + axis] =
          (mesh->vertices[3 * (int64_t)a + axis] + mesh->vertices[3 * (int64_t)b + axis]) / 2;
    ends[2 * edge] = a;
    ends[2 * edge + 1] = b;
  }
}

/* Adds the middle nodes of edges with both ends in a group; *list is the group's new vertices. */
static thrum_status grow_group(const thrum_mesh *mesh, const thrum_group *group,
                               const int32_t *ends, int64_t edges, uint8_t *marked, int32_t **list,
                               int64_t *count, thrum_error *error) {
  // the vertices of the group are marked, and edges between two of them counted
  memset(marked, 0, (size_t)mesh->vertex_count);
  for (int64_t i = 0; i < group->count; i++)
    marked[group->vertices[i]] = 1;
  *count = group->count;
  for (int64_t e = 0; e < edges; e++)
    *count += marked[ends[2 * e]] && marked[ends[2 * e + 1]];

  // the old vertices, and behind them the new ones
  THRUM_TRY(thrum_reserve(list, *count, sizeof **list, "the middle nodes", error));
  memcpy(*list, group->vertices, (size_t)group->count * sizeof **list);
  int64_t next = group->count;
  for (int64_t e = 0; e < edges; e++)
    if (marked[ends[2 * e]] && marked[ends[2 * e + 1]])
      (*list)[next++] = (int32_t)(mesh->vertex_count + e);
  return THRUM_OK;
}

thrum_status thrum_midsides_append(thrum_mesh *mesh, const int32_t *ends, const double *places,
                                   int64_t count, thrum_error *error) {
  const size_t groups = (size_t)mesh->group_count, old_count = (size_t)mesh->vertex_count;

  // room for what grows; the mesh is changed at the end alone
  thrum_scope scope = thrum_scope_begin("the middle nodes", error);
  int32_t **lists = thrum_scope_allocate(&scope, mesh->group_count, sizeof *lists);
  int64_t *counts = thrum_scope_allocate(&scope, mesh->group_count, sizeof *counts);
  uint8_t *marked = thrum_scope_allocate(&scope, mesh->vertex_count, 1);
  double *vertices = NULL, *springs = NULL;
  thrum_status status = scope.status;
  THRUM_THEN(status, thrum_reserve(&vertices, mesh->vertex_count + count, 3 * sizeof *vertices,
                                   "the middle nodes", error));
  if (mesh->springs)
    THRUM_THEN(status, thrum_reserve(&springs, mesh->vertex_count + count, 3 * sizeof *springs,
                                     "the middle nodes", error));
  for (size_t g = 0; g < groups && status >= 0; g++)
    status = grow_group(mesh, &mesh->groups[g], ends, count, marked, &lists[g], &counts[g], error);

  // old arrays and new ones change places, and what is left over is freed
  if (status >= 0) {
    memcpy(vertices, mesh->vertices, old_count * 3 * sizeof *vertices);
    memcpy(vertices + 3 * old_count, places, (size_t)count * 3 * sizeof *vertices);
    double *old = mesh->vertices;
    mesh->vertices = vertices;
    vertices = old;
    if (springs) {
      memcpy(springs, mesh->springs, old_count * 3 * sizeof *springs);
      old = mesh->springs;
      mesh->springs = springs;
      springs = old;
    }
    mesh->vertex_count += count;
    mesh->made_midsides = count;
    for (size_t g = 0; g < groups; g++) {
      int32_t *list = mesh->groups[g].vertices;
      mesh->groups[g].vertices = lists[g];
      mesh->groups[g].count = counts[g];
      lists[g] = list;
    }
  }

  for (size_t g = 0; lists && g < groups; g++)
    free(lists[g]);
  thrum_scope_free(&scope);
  free(vertices);
  free(springs);
  return status;
}

thrum_status thrum_midsides_add(thrum_mesh *mesh, thrum_error *error) {
  int64_t edges = 0;
  int32_t *ends = NULL;
  double *places = NULL;

  // the edges are counted first, and then there is room for their nodes
  int32_t *midsides = NULL;
  thrum_status status =
      thrum_reserve(&midsides, mesh->tet_count, 6 * sizeof *midsides, "the middle nodes", error);
  THRUM_THEN(status, thrum_midsides_number(mesh, midsides, &edges, error));
  THRUM_THEN(status, thrum_reserve(&ends, edges, 2 * sizeof *ends, "the middle nodes", error));
  THRUM_THEN(status, thrum_reserve(&places, edges, 3 * sizeof *places, "the middle nodes", error));
  if (status >= 0) {
    place_middles(mesh, midsides, ends, places);
    status = thrum_midsides_append(mesh, ends, places, edges, error);
  }

  // the elements name their new nodes once these are there
  if (status >= 0) {
    mesh->midsides = midsides;
    midsides = NULL;
  }
  free(midsides);
  free(ends);
  free(places);
  return status;
}

void thrum_midsides_undo(thrum_mesh *mesh) {
  mesh->vertex_count -= mesh->made_midsides;
  mesh->made_midsides = 0;
  free(mesh->midsides);
  mesh->midsides = NULL;

  // groups are ascending, and what was made is last
  for (int64_t g = 0; g < mesh->group_count; g++) {
    thrum_group *group = &mesh->groups[g];
    while (group->count > 0 && group->vertices[group->count - 1] >= mesh->vertex_count)
      group->count--;
  }
}

void thrum_midsides_drop(thrum_mesh *mesh) {
  if (!mesh->midsides)
    return;
  free(mesh->midsides);
  mesh->midsides = NULL;
  mesh->made_midsides = 0;
  mesh->cornered_tets = mesh->tet_count;
}

void thrum_midsides_flip(int32_t *midsides) {
  // edges 12 and 13 change places, and so do 20 and 03
  static const int pairs[2][2] = {{1, 4}, {2, 3}};
  for (int p = 0; p < 2; p++) {
    const int32_t swap = midsides[pairs[p][0]];
    midsides[pairs[p][0]] = midsides[pairs[p][1]];
    midsides[pairs[p][1]] = swap;
  }
}

/* --- checking -----------------------------------------------------------------------------------
 */

static thrum_status edge_fault(const thrum_mesh *mesh, int64_t t, int e, const char *what,
                               thrum_midside_fault *fault) {
  fault->tet = t;
  snprintf(fault->text, sizeof fault->text, "has vertex %lld between %lld and %lld, %s",
           (long long)thrum_mesh_number(mesh, mesh->midsides[6 * t + e]),
           (long long)thrum_mesh_number(mesh, *corner_of(mesh, t, e, 0)),
           (long long)thrum_mesh_number(mesh, *corner_of(mesh, t, e, 1)), what);
  return THRUM_BAD_VALUE;
}

/* Finds for each vertex whether it is a corner, the middle of one edge, or nothing yet. */
static thrum_status check_edges(const thrum_mesh *mesh, uint8_t *corner, int32_t *ends,
                                edge_table *table, thrum_midside_fault *fault, thrum_error *error) {
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    corner[mesh->tets[i]] = 1;
  for (int64_t v = 0; v < 2 * mesh->vertex_count; v++)
    ends[v] = -1;

  for (int64_t i = 0; i < 6 * mesh->tet_count; i++) {
    const int64_t t = i / 6;
    const int e = (int)(i % 6);
    const int32_t middle = mesh->midsides[i];
    if (corner[middle])
      return edge_fault(mesh, t, e, "where that is a corner of a tet", fault);

    // the first tet of an edge says what its middle node is
    edge_slot *edge = find_edge(table, *corner_of(mesh, t, e, 0), *corner_of(mesh, t, e, 1));
    if (!edge)
      return no_memory(error);
    if (edge->middle < 0) {
      edge->middle = middle;
      table->used++;
    }
    if (edge->middle != middle)
      return edge_fault(mesh, t, e, "where another tet at this edge has another one", fault);

    // and a middle node knows one edge
    int32_t *own = ends + 2 * (int64_t)middle;
    if (own[0] < 0) {
      own[0] = edge->low;
      own[1] = edge->high;
    }
    if (own[0] != edge->low || own[1] != edge->high)
      return edge_fault(mesh, t, e, "where it lies on another edge as well", fault);
  }
  return THRUM_OK;
}

/* The determinant of the map of an element at a point. */
static double determinant_at(double nodes[10][3], const double place[4]) {
  double slopes[10][3], gradients[9];
  thrum_quadratic_slopes(place, slopes);
  return thrum_quadratic_map(nodes, slopes, gradients);
}

/* Refuses the map of an element that folds over at a point of its rule, at a corner or at a middle
 * node. A middle node at just a quarter of its edge makes a determinant of 0 at the corner, which
 * elements at the tip of a crack want, and rounding may make it negative. */
static thrum_status check_shape(const thrum_mesh *mesh, int64_t t, const int32_t node[10],
                                double nodes[10][3], thrum_midside_fault *fault) {
  int points;
  const thrum_quadratic_point *rule = thrum_quadratic_rule(true, &points);
  double largest = 0;
  fault->tet = t;
  for (int p = 0; p < points; p++) {
    const double determinant = determinant_at(nodes, rule[p].place);
    largest = determinant > largest ? determinant : largest;
    if (determinant > 0)
      continue;
    snprintf(fault->text, sizeof fault->text,
             "is turned inside out by its middle nodes (they are too far from the middle of their "
             "edges, or in another order than that of the format)");
    return THRUM_BAD_VALUE;
  }

  // a middle node beyond the quarter of its edge folds the element near the corner alone
  for (int a = 0; a < 10; a++) {
    double place[4] = {0};
    if (a < 4)
      place[a] = 1;
    for (int end = 0; end < 2 && a >= 4; end++)
      place[thrum_quadratic_edges[a - 4][end]] = 0.5;
    if (determinant_at(nodes, place) >= -1e-9 * largest)
      continue;
    snprintf(fault->text, sizeof fault->text,
             "is turned inside out at vertex %lld: its middle nodes must lie "
             "between a quarter and three quarters of their edges, and not far beside them",
             (long long)thrum_mesh_number(mesh, node[a]));
    return THRUM_BAD_VALUE;
  }
  return THRUM_OK;
}

/* Refuses an element whose map folds over. */
static thrum_status check_shapes(const thrum_mesh *mesh, thrum_midside_fault *fault) {
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t node[10];
    double nodes[10][3];
    thrum_mesh_nodes(mesh, t, node);
    for (int a = 0; a < 10; a++)
      memcpy(nodes[a], mesh->vertices + 3 * (int64_t)node[a], sizeof nodes[a]);

    // with straight edges the map is that of the corners, which was checked
    if (thrum_quadratic_is_curved(nodes))
      THRUM_TRY(check_shape(mesh, t, node, nodes, fault));
  }
  return THRUM_OK;
}

thrum_status thrum_midsides_check(const thrum_mesh *mesh, thrum_midside_fault *fault,
                                  thrum_error *error) {
  edge_table table = {0};
  thrum_scope scope = thrum_scope_begin("the middle nodes", error);
  uint8_t *corner = thrum_scope_allocate(&scope, mesh->vertex_count, 1);
  int32_t *ends = thrum_scope_allocate(&scope, mesh->vertex_count, 2 * sizeof *ends);
  thrum_status status = scope.status;
  THRUM_THEN(status, check_edges(mesh, corner, ends, &table, fault, error));
  thrum_scope_free(&scope);
  free(table.slots);
  return status >= 0 ? check_shapes(mesh, fault) : status;
}
