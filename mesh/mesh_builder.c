/* Building a mesh from numbered vertices. Cost: linear in the mesh when the numbers have no gaps,
 * else n log n.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_builder.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/quadratic_tet.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

thrum_status thrum_builder_vertex(thrum_mesh_builder *b, int64_t number, const double position[3],
                                  int64_t line) {
  const int64_t v = b->vertex_count;
  if (v == INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 vertices");

  // three arrays of the same count, which the last one raises
  int64_t numbers = v, lines = v;
  THRUM_TRY(thrum_mesh_append(&b->numbers, &numbers, &number, sizeof number, b->error));
  THRUM_TRY(thrum_mesh_append(&b->vertex_lines, &lines, &line, sizeof line, b->error));
  return thrum_mesh_append(&b->positions, &b->vertex_count, position, 3 * sizeof *position,
                           b->error);
}

/* Adds a tet of an element with corners and, where it has ten nodes, middle nodes. */
static thrum_status add_tet(thrum_mesh_builder *b, const thrum_element *element, int64_t number,
                            const int64_t corners[4], const int64_t middles[6]) {
  const int64_t t = b->tet_count;

  if (t == INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 tetrahedra");
  if (t > 0 && element->quadratic != (b->middles != NULL) && b->odd_tet == 0)
    b->odd_tet = t;

  // a mesh of mixed orders is refused at the end, so its middle nodes no longer matter
  if (element->quadratic && b->odd_tet == 0) {
    THRUM_TRY(thrum_mesh_grow(&b->middles, t, 1, 6 * sizeof *b->middles, b->error));
    memcpy(b->middles + 6 * t, middles, 6 * sizeof *middles);
  }

  THRUM_TRY(thrum_mesh_grow(&b->tets, t, 1, 4 * sizeof *b->tets, b->error));
  THRUM_TRY(thrum_mesh_grow(&b->keys, t, 1, sizeof *b->keys, b->error));
  THRUM_TRY(thrum_mesh_grow(&b->lines, t, 1, sizeof *b->lines, b->error));
  THRUM_TRY(thrum_mesh_grow(&b->tet_numbers, t, 1, sizeof *b->tet_numbers, b->error));
  memcpy(b->tets + 4 * t, corners, 4 * sizeof *corners);
  b->keys[t] = element->key;
  b->lines[t] = element->line;
  b->tet_numbers[t] = number;
  b->tet_count = t + 1;
  return THRUM_OK;
}

thrum_status thrum_builder_tet(thrum_mesh_builder *b, const int64_t vertices[4], int64_t key,
                               int64_t line) {
  const thrum_element element = {.nodes = vertices, .key = key, .line = line};
  return thrum_builder_element(b, &element);
}

/* Notes a middle node on the diagonal between two corners, which is not in the file; *middle stands
 * for it. `nodes` is where those of the element are kept. */
static thrum_status add_diagonal(thrum_mesh_builder *b, const thrum_element *element, int from,
                                 int to, int64_t nodes, int64_t *middle) {
  const int64_t x = element->nodes[from], y = element->nodes[to];
  if (b->diagonal_count == INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 diagonals");
  const thrum_diagonal diagonal = {.ends = {x < y ? x : y, x < y ? y : x},
                                   .nodes = nodes,
                                   .kind = (int8_t)element->kind,
                                   .face = (int8_t)thrum_solid_diagonal(element->kind, from, to)};
  *middle = -1 - b->diagonal_count;
  return thrum_mesh_append(&b->diagonals, &b->diagonal_count, &diagonal, sizeof diagonal, b->error);
}

/* Finds the middle nodes of a tet of an element: on edges of the element its own, on diagonals new
 * ones. */
static thrum_status find_middles(thrum_mesh_builder *b, const thrum_element *element,
                                 const int tet[4], int64_t nodes, int64_t middles[6]) {
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
    const int from = tet[thrum_quadratic_edges[e][0]], to = tet[thrum_quadratic_edges[e][1]];
    const int edge = thrum_solid_edge(element->kind, from, to);
    if (edge >= 0)
      middles[e] = element->nodes[thrum_solid_shapes[element->kind].corners + edge];
    else
      THRUM_TRY(add_diagonal(b, element, from, to, nodes, &middles[e]));
  }
  return THRUM_OK;
}

/* Keeps the nodes of an element that is cut, from which nodes on its diagonals are placed. */
static thrum_status keep_nodes(thrum_mesh_builder *b, const thrum_element *element,
                               int64_t *place) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[element->kind];
  const int count = shape->corners + (element->quadratic ? shape->edges : 0);
  *place = b->cut_node_count;
  THRUM_TRY(thrum_mesh_grow(&b->cut_nodes, *place, count, sizeof *b->cut_nodes, b->error));
  memcpy(b->cut_nodes + *place, element->nodes, (size_t)count * sizeof *b->cut_nodes);
  b->cut_node_count += count;
  return THRUM_OK;
}

/* Keeps what an element was cut into. */
static thrum_status keep_cut(thrum_mesh_builder *b, thrum_solid kind, int64_t nodes,
                             int64_t first) {
  const thrum_cut cut = {nodes, first, (int8_t)kind, (int8_t)(b->tet_count - first)};
  return thrum_mesh_append(&b->cuts, &b->cut_count, &cut, sizeof cut, b->error);
}

/* Does a tet have a corner twice? So have parts of an element whose corners fall together, such as
 * a wedge that is written as a hexahedron. */
static bool is_collapsed(const int64_t corners[4]) {
  for (int i = 0; i < 4; i++)
    for (int j = i + 1; j < 4; j++)
      if (corners[i] == corners[j])
        return true;
  return false;
}

/* Keeps an element for finish. */
static thrum_status keep_element(thrum_mesh_builder *b, const thrum_element *element) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[element->kind];
  const bool quadratic = element->quadratic && !b->corners;
  const int count = shape->corners + (quadratic ? shape->edges : 0);
  const thrum_kept_element kept = {.kind = element->kind,
                                   .quadratic = quadratic,
                                   .cornered = element->quadratic && !quadratic,
                                   .nodes = b->kept_node_count,
                                   .number = element->number,
                                   .key = element->key,
                                   .line = element->line};
  THRUM_TRY(
      thrum_mesh_grow(&b->kept_nodes, b->kept_node_count, count, sizeof *b->kept_nodes, b->error));
  memcpy(b->kept_nodes + b->kept_node_count, element->nodes, (size_t)count * sizeof *b->kept_nodes);
  b->kept_node_count += count;
  return thrum_mesh_append(&b->kept, &b->kept_count, &kept, sizeof kept, b->error);
}

thrum_status thrum_builder_solid(thrum_mesh_builder *b, int64_t place) {
  const thrum_kept_element *kept = &b->kept[place];
  const int64_t *nodes = b->kept_nodes + kept->nodes;
  const thrum_element element = {.kind = kept->kind, .key = kept->key, .line = kept->line};
  const int64_t number = kept->number > 0 ? kept->number : ++b->element_count;
  int tets[THRUM_SOLID_MIDDLE_TETS_MAX][4];

  // all nodes are corners of a tet
  const int count = kept->quadratic ? thrum_solid_cut_middles(kept->kind, nodes, tets)
                                    : thrum_solid_cut(kept->kind, nodes, tets);
  for (int t = 0; t < count; t++) {
    int64_t corners[4];
    const int64_t none[6] = {0};
    for (int c = 0; c < 4; c++)
      corners[c] = nodes[tets[t][c]];
    THRUM_TRY(thrum_mesh_grow(&b->tet_solids, b->tet_count, 1, sizeof *b->tet_solids, b->error));
    b->tet_solids[b->tet_count] = place;
    THRUM_TRY(add_tet(b, &element, number, corners, none));
  }
  b->cornered_tets += kept->cornered ? count : 0;
  return THRUM_OK;
}

thrum_status thrum_builder_element(thrum_mesh_builder *b, const thrum_element *given) {
  if (b->keep_solids)
    return keep_element(b, given);
  const bool cornered = b->corners && given->quadratic;
  thrum_element by_corners = *given;
  by_corners.quadratic = given->quadratic && !cornered;
  const thrum_element *element = &by_corners;
  const bool cut = element->kind != THRUM_SOLID_TET;
  int tets[THRUM_SOLID_TETS_MAX][4];
  int64_t nodes = 0;
  const int64_t before = b->tet_count;
  const int64_t number = element->number > 0 ? element->number : b->element_count + 1;
  b->element_count++;

  // diagonals are placed, and warped elements cut again, when all vertices are known
  if (cut)
    THRUM_TRY(keep_nodes(b, element, &nodes));
  const int count = thrum_solid_cut(element->kind, element->nodes, tets);
  for (int t = 0; t < count; t++) {
    int64_t corners[4], middles[6] = {0};
    for (int c = 0; c < 4; c++)
      corners[c] = element->nodes[tets[t][c]];
    if (cut && is_collapsed(corners))
      continue;
    if (element->quadratic)
      THRUM_TRY(find_middles(b, element, tets[t], nodes, middles));
    THRUM_TRY(add_tet(b, element, number, corners, middles));
  }

  // an element that collapses altogether would be a hole in the body, and is refused by finish
  if (b->tet_count == before && b->flat_number == 0) {
    b->flat_number = number;
    b->flat_line = element->line;
  }
  if (cut && b->tet_count > before)
    THRUM_TRY(keep_cut(b, element->kind, nodes, before));
  b->cut_elements[element->kind] += cut;
  b->cut_tets += cut ? b->tet_count - before : 0;
  b->cornered_tets += cornered ? b->tet_count - before : 0;
  return THRUM_OK;
}

thrum_status thrum_builder_list(thrum_mesh_builder *b, const char *name, size_t length,
                                int64_t *index) {
  // a list of that name
  for (int64_t step = 0; step < b->list_count; step++) {
    // the one found last comes first: what belongs to a list stands together
    const int64_t i = (b->last_list + step) % b->list_count;
    if (strlen(b->lists[i].name) == length && memcmp(b->lists[i].name, name, length) == 0) {
      *index = b->last_list = i;
      return THRUM_OK;
    }
  }

  // a new one must have a name that options can carry
  const char *fault = thrum_mesh_name_fault(name, length);
  if (fault)
    return thrum_error_set(b->error, THRUM_BAD_FORMAT, "%s", fault);
  if (b->list_count == THRUM_MESH_GROUPS_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than %d groups",
                           THRUM_MESH_GROUPS_MAX);

  // the list is counted only once it has its name
  THRUM_TRY(thrum_mesh_grow(&b->lists, b->list_count, 1, sizeof *b->lists, b->error));
  b->lists[b->list_count] = (thrum_named_list){0};
  THRUM_TRY(thrum_mesh_keep_text(name, length, &b->lists[b->list_count].name, b->error));
  *index = b->last_list = b->list_count++;
  return THRUM_OK;
}

thrum_status thrum_builder_rename(thrum_mesh_builder *b, int64_t list, const char *name,
                                  size_t length) {
  return thrum_mesh_keep_text(name, length, &b->lists[list].name, b->error);
}

thrum_status thrum_builder_add(thrum_mesh_builder *b, int64_t list, int64_t vertex) {
  thrum_named_list *l = &b->lists[list];
  return thrum_mesh_append(&l->numbers, &l->count, &vertex, sizeof vertex, b->error);
}

thrum_status thrum_builder_mark(thrum_mesh_builder *b, const char *prefix, int64_t number,
                                const int64_t *vertices, int count) {
  char name[64];
  int64_t index = 0;
  snprintf(name, sizeof name, "%s_%lld", prefix, (long long)number);
  THRUM_TRY(thrum_builder_list(b, name, strlen(name), &index));
  for (int i = 0; i < count; i++)
    THRUM_TRY(thrum_builder_add(b, index, vertices[i]));
  return THRUM_OK;
}

typedef struct numbered {
  int64_t number, from;
} numbered;

static int compare_numbered(const void *a, const void *b) {
  const numbered *x = a, *y = b;
  if (x->number != y->number)
    return x->number < y->number ? -1 : 1;
  return (x->from > y->from) - (x->from < y->from);
}

/* Brings the vertices into the order of their numbers. */
static thrum_status sort_vertices(thrum_mesh_builder *b) {
  int64_t v = 1;
  while (v < b->vertex_count && b->numbers[v - 1] < b->numbers[v])
    v++;
  if (v >= b->vertex_count)
    return THRUM_OK;

  const int64_t count = b->vertex_count;
  thrum_scope scope = thrum_scope_begin("the mesh", b->error);
  numbered *order = thrum_scope_allocate(&scope, count, sizeof *order);
  double *positions = thrum_scope_allocate(&scope, count, 3 * sizeof *positions);
  int64_t *lines = thrum_scope_allocate(&scope, count, sizeof *lines);

  // equal numbers keep their order, so that the later one is named as the repeat
  for (v = 0; v < count && scope.status >= 0; v++)
    order[v] = (numbered){b->numbers[v], v};
  if (scope.status >= 0)
    qsort(order, (size_t)count, sizeof *order, compare_numbered);

  for (v = 0; v < count && scope.status >= 0; v++) {
    memcpy(positions + 3 * v, b->positions + 3 * order[v].from, 3 * sizeof *positions);
    lines[v] = b->vertex_lines[order[v].from];
    b->numbers[v] = order[v].number;
  }

  // the arrays themselves stay, since the mesh takes them over
  if (scope.status >= 0) {
    memcpy(b->positions, positions, (size_t)count * 3 * sizeof *positions);
    memcpy(b->vertex_lines, lines, (size_t)count * sizeof *lines);
  }
  thrum_scope_free(&scope);
  return scope.status;
}

const char *thrum_builder_place(int64_t line, char text[32]) {
  text[0] = '\0';
  if (line > 0)
    snprintf(text, 32, ":%lld", (long long)line);
  return text;
}

thrum_status thrum_builder_order(thrum_mesh_builder *b, const char *name) {
  char where[32];
  THRUM_TRY(sort_vertices(b));
  for (int64_t v = 1; v < b->vertex_count; v++)
    if (b->numbers[v - 1] == b->numbers[v])
      return thrum_error_set(b->error, THRUM_BAD_FORMAT, "%.200s%s: vertex %lld comes twice", name,
                             thrum_builder_place(b->vertex_lines[v], where),
                             (long long)b->numbers[v]);
  return THRUM_OK;
}

int64_t thrum_builder_find(const thrum_mesh_builder *b, int64_t number) {
  int64_t low = 0, high = b->vertex_count;
  if (high == 0 || number < b->numbers[0] || number > b->numbers[high - 1])
    return -1;
  // without gaps the number tells the place
  if (b->numbers[high - 1] - b->numbers[0] == high - 1)
    return number - b->numbers[0];
  while (low < high) {
    const int64_t middle = low + (high - low) / 2;
    if (b->numbers[middle] < number)
      low = middle + 1;
    else
      high = middle;
  }
  return low < b->vertex_count && b->numbers[low] == number ? low : -1;
}

thrum_status thrum_builder_name_regions(const thrum_mesh_builder *b, thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && b->tet_count > 0; i++) {
    char name[32];
    snprintf(name, sizeof name, "%lld", (long long)b->region_keys[i]);
    THRUM_TRY(thrum_mesh_name_region(mesh, i, name, strlen(name), b->error));
  }
  return THRUM_OK;
}

thrum_status thrum_builder_region_groups(const thrum_mesh_builder *b, const char *prefix, bool zero,
                                         thrum_mesh *mesh) {
  for (int64_t i = 0; i < mesh->region_count && mesh->region_count > 1; i++) {
    char name[64];
    if (b->region_keys[i] == 0 && !zero)
      continue;
    snprintf(name, sizeof name, "%s_%lld", prefix, (long long)b->region_keys[i]);
    THRUM_TRY(thrum_mesh_add_region_group(mesh, (int32_t)i, name, b->error));
  }
  return THRUM_OK;
}

void thrum_builder_free(thrum_mesh_builder *b) {
  for (int64_t i = 0; i < b->list_count; i++) {
    free(b->lists[i].name);
    free(b->lists[i].numbers);
  }

  // what thrum_builder_finish has given to the mesh is NULL here
  free(b->lists);
  free(b->positions);
  free(b->numbers);
  free(b->vertex_lines);
  free(b->tets);
  free(b->middles);
  free(b->keys);
  free(b->lines);
  free(b->tet_numbers);
  free(b->diagonals);
  free(b->cut_nodes);
  free(b->cuts);
  free(b->region_keys);
  free(b->kept);
  free(b->kept_nodes);
  free(b->tet_solids);
  *b = (thrum_mesh_builder){0};
}
