/* Building a mesh from numbered vertices. Cost: linear in the mesh when the numbers have no gaps,
 * else n log n.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_builder.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "mesh/midsides.h"
#include "mesh/tet_repeats.h"
#include "platform/allocate.h"
#include "runtime/base/quadratic_tet.h"

/* How far middle nodes of straight edges may be off the middle, in edges: digits of a file. */
static const double STRAIGHT = 1e-5;

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
  const thrum_solid_shape *shape = &thrum_solid_shapes[element->kind];
  const int count = shape->corners + shape->edges;
  *place = b->cut_node_count;
  THRUM_TRY(thrum_mesh_grow(&b->cut_nodes, *place, count, sizeof *b->cut_nodes, b->error));
  memcpy(b->cut_nodes + *place, element->nodes, (size_t)count * sizeof *b->cut_nodes);
  b->cut_node_count += count;
  return THRUM_OK;
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

thrum_status thrum_builder_element(thrum_mesh_builder *b, const thrum_element *element) {
  const bool cut = element->kind != THRUM_SOLID_TET;
  int tets[THRUM_SOLID_TETS_MAX][4];
  int64_t nodes = 0;
  const int64_t before = b->tet_count;
  const int64_t number = element->number > 0 ? element->number : b->element_count + 1;
  b->element_count++;

  // diagonals are placed when all vertices are known
  if (cut && element->quadratic)
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
  b->cut_elements[element->kind] += cut;
  b->cut_tets += cut ? b->tet_count - before : 0;
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

/* ":LINE" for a message; nothing where the line is not known. */
static const char *place(int64_t line, char text[32]) {
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
                             place(b->vertex_lines[v], where), (long long)b->numbers[v]);
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

static thrum_status take_vertices(thrum_mesh_builder *b, thrum_mesh *mesh) {
  mesh->vertex_count = mesh->file_vertex_count = b->vertex_count;
  mesh->vertices = b->positions;
  b->positions = NULL;

  // numbers from 1 without gaps go without saying
  if (b->vertex_count == 0 ||
      (b->numbers[0] == 1 && b->numbers[b->vertex_count - 1] == b->vertex_count))
    return THRUM_OK;

  THRUM_TRY(thrum_reserve(&mesh->file_number, b->vertex_count, sizeof *mesh->file_number,
                          "the mesh", b->error));
  memcpy(mesh->file_number, b->numbers, (size_t)b->vertex_count * sizeof *b->numbers);
  return THRUM_OK;
}

/* Whether elements were cut, which messages then name in the place of tets. */
static const char *tet_word(const thrum_mesh_builder *b) {
  return b->cut_tets > 0 ? "element" : "tet";
}

static thrum_status missing_vertex(thrum_mesh_builder *b, const char *name, int64_t t,
                                   int64_t number) {
  char where[32];
  return thrum_error_set(b->error, THRUM_BAD_VALUE,
                         "%.200s%s: %s %lld names vertex %lld, which is not in the file; its "
                         "vertices are %lld to %lld",
                         name, place(b->lines[t], where), tet_word(b), (long long)b->tet_numbers[t],
                         (long long)number, b->vertex_count > 0 ? (long long)b->numbers[0] : 0LL,
                         b->vertex_count > 0 ? (long long)b->numbers[b->vertex_count - 1] : -1LL);
}

/* Looks up the vertices that tets name, `nodes` a tet; those of diagonals follow the vertices. The
 * caller frees *places. */
static thrum_status find_places(thrum_mesh_builder *b, const char *name, const int64_t *numbers,
                                int nodes, int32_t **places) {
  THRUM_TRY(thrum_reserve(places, nodes * b->tet_count, sizeof **places, "the mesh", b->error));
  for (int64_t i = 0; i < nodes * b->tet_count; i++) {
    const int64_t v = numbers[i] < 0 ? b->vertex_count + b->diagonals[-1 - numbers[i]].place
                                     : thrum_builder_find(b, numbers[i]);
    if (v < 0)
      return missing_vertex(b, name, i / nodes, numbers[i]);
    if (v >= INT32_MAX / 3)
      return thrum_error_set(b->error, THRUM_UNSUPPORTED, "%.200s: more than 2^31 components",
                             name);
    (*places)[i] = (int32_t)v;
  }
  return THRUM_OK;
}

/* --- the diagonals of elements that were cut ---------------------------------------------------
 */

typedef struct diagonal_key {
  int64_t ends[2], from;
} diagonal_key;

static int compare_diagonals(const void *a, const void *b) {
  const diagonal_key *x = a, *y = b;
  if (x->ends[0] != y->ends[0])
    return x->ends[0] < y->ends[0] ? -1 : 1;
  if (x->ends[1] != y->ends[1])
    return x->ends[1] < y->ends[1] ? -1 : 1;
  return (x->from > y->from) - (x->from < y->from);
}

/* Gives diagonals with the same ends one place; *count is how many different ones there are, and
 * firsts, diagonal_count long, has the first diagonal at each place. */
static thrum_status join_diagonals(thrum_mesh_builder *b, int64_t *firsts, int64_t *count) {
  const size_t all = (size_t)b->diagonal_count;
  diagonal_key *order = NULL;
  THRUM_TRY(thrum_reserve(&order, all + 1, sizeof *order, "the mesh", b->error));
  for (size_t d = 0; d < all; d++)
    order[d] = (diagonal_key){{b->diagonals[d].ends[0], b->diagonals[d].ends[1]}, (int64_t)d};
  qsort(order, all, sizeof *order, compare_diagonals);

  // both neighbours at a face have the same diagonal
  *count = 0;
  for (size_t d = 0; d < all; d++) {
    const diagonal_key *key = &order[d];
    if (d == 0 || memcmp(key->ends, order[d - 1].ends, sizeof key->ends) != 0)
      firsts[(*count)++] = key->from;
    b->diagonals[key->from].place = (int32_t)(*count - 1);
  }
  free(order);
  return THRUM_OK;
}

/* Places the node of a diagonal: between straight edges in its middle, so that the tets there are
 * straight too; between others where the shape functions of the whole element have the centre of
 * the face or of the element, which for both is the sum of the middle nodes around it, by 1/2 or
 * 1/4, less that of the corners by 1/4. What a face gets depends on its nodes alone. */
static void place_diagonal(const thrum_mesh_builder *b, const thrum_mesh *mesh,
                           const thrum_diagonal *diagonal, int32_t ends[2], double position[3]) {
  const thrum_solid_shape *shape = &thrum_solid_shapes[diagonal->kind];
  const int64_t *nodes = b->cut_nodes + diagonal->nodes;
  const double share = diagonal->face >= 0 ? 0.5 : 0.25;
  double centre[3] = {0, 0, 0};
  bool curved = false;

  // what the tets of the element name was found; where its corners fall together they name less
  for (int e = 0; e < shape->edges; e++) {
    if (!thrum_solid_around(diagonal->kind, diagonal->face, e))
      continue;
    const int64_t from = thrum_builder_find(b, nodes[shape->edge[e][0]]);
    const int64_t to = thrum_builder_find(b, nodes[shape->edge[e][1]]);
    const int64_t middle = thrum_builder_find(b, nodes[shape->corners + e]);
    if (from < 0 || to < 0 || middle < 0)
      continue;

    // each corner of a face ends two of its edges, and of an element three
    const double *p = mesh->vertices + 3 * from, *q = mesh->vertices + 3 * to;
    const double *m = mesh->vertices + 3 * middle;
    double bulge = 0, length = 0;
    for (int axis = 0; axis < 3; axis++) {
      centre[axis] += share * m[axis] - (p[axis] + q[axis]) / (diagonal->face >= 0 ? 8 : 12);
      bulge = fmax(bulge, fabs(m[axis] - (p[axis] + q[axis]) / 2));
      length = fmax(length, fabs(q[axis] - p[axis]));
    }
    curved = curved || bulge > STRAIGHT * length;
  }

  for (int end = 0; end < 2; end++)
    ends[end] = (int32_t)thrum_builder_find(b, diagonal->ends[end]);
  for (int axis = 0; axis < 3; axis++)
    position[axis] = curved ? centre[axis]
                            : (mesh->vertices[3 * (int64_t)ends[0] + axis] +
                               mesh->vertices[3 * (int64_t)ends[1] + axis]) /
                                  2;
}

/* Appends the nodes on diagonals to the mesh, which has its groups already. */
static thrum_status append_diagonals(thrum_mesh_builder *b, const int64_t *firsts, int64_t count,
                                     thrum_mesh *mesh) {
  thrum_scope scope = thrum_scope_begin("the mesh", b->error);
  int32_t *ends = thrum_scope_allocate(&scope, count, 2 * sizeof *ends);
  double *positions = thrum_scope_allocate(&scope, count, 3 * sizeof *positions);
  thrum_status status = scope.status;
  for (int64_t d = 0; d < count && status >= 0; d++)
    place_diagonal(b, mesh, &b->diagonals[firsts[d]], ends + 2 * d, positions + 3 * d);
  THRUM_THEN(status, thrum_midsides_append(mesh, ends, positions, count, b->error));
  thrum_scope_free(&scope);
  return status;
}

static thrum_status take_tets(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  char where[32];
  if (b->flat_number > 0)
    return thrum_error_set(b->error, THRUM_BAD_VALUE,
                           "%.200s%s: element %lld has no volume: its corners fall together", name,
                           place(b->flat_line, where), (long long)b->flat_number);
  if (b->odd_tet > 0)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED,
                           "%.200s%s: %s %lld %s, where those before it %s; all elements of a mesh "
                           "must be of one order",
                           name, place(b->lines[b->odd_tet], where), tet_word(b),
                           (long long)b->tet_numbers[b->odd_tet],
                           b->middles ? "has no middle nodes" : "has middle nodes",
                           b->middles ? "have some" : "have none");

  // numbers of the file become places, and the lines go over to the mesh
  THRUM_TRY(find_places(b, name, b->tets, 4, &mesh->tets));
  if (b->middles)
    THRUM_TRY(find_places(b, name, b->middles, 6, &mesh->midsides));
  mesh->tet_count = b->tet_count;
  mesh->tet_line = b->lines;
  b->lines = NULL;

  // elements that are counted from 1 need no numbers
  int64_t t = 0;
  while (t < b->tet_count && b->tet_numbers[t] == t + 1)
    t++;
  if (t < b->tet_count) {
    mesh->tet_number = b->tet_numbers;
    b->tet_numbers = NULL;
  }
  return THRUM_OK;
}

/* Keeps the first of repeated tets, with its key; the vertices of the others are in all of their
 * groups already. */
static thrum_status join_repeats(thrum_mesh_builder *b, thrum_mesh *mesh) {
  int64_t *earlier = NULL, kept = 0;
  const thrum_status status = thrum_mesh_tet_repeats(mesh, &earlier, b->error);

  // tets are moved in place, so that those that are kept stay in their order
  for (int64_t t = 0; t < mesh->tet_count && status >= 0; t++) {
    if (earlier[t] >= 0)
      continue;
    memmove(mesh->tets + 4 * kept, mesh->tets + 4 * t, 4 * sizeof *mesh->tets);
    if (mesh->midsides)
      memmove(mesh->midsides + 6 * kept, mesh->midsides + 6 * t, 6 * sizeof *mesh->midsides);
    mesh->tet_line[kept] = mesh->tet_line[t];
    if (mesh->tet_number)
      mesh->tet_number[kept] = mesh->tet_number[t];
    b->keys[kept++] = b->keys[t];
  }
  mesh->tet_count = b->tet_count = kept;
  free(earlier);
  return status;
}

static int compare_keys(const void *a, const void *b) {
  const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

int64_t thrum_builder_region(const thrum_mesh_builder *b, const thrum_mesh *mesh, int64_t key) {
  const int64_t *found = bsearch(&key, b->region_keys, (size_t)mesh->region_count,
                                 sizeof *b->region_keys, compare_keys);
  return found - b->region_keys;
}

/* A region for each key, ascending. */
static thrum_status number_regions(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  const size_t count = (size_t)b->tet_count + 1;
  THRUM_TRY(thrum_reserve(&b->region_keys, count, sizeof *b->region_keys, "the mesh", b->error));
  THRUM_TRY(
      thrum_reserve(&mesh->tet_region, count, sizeof *mesh->tet_region, "the mesh", b->error));

  int64_t kept = 0;
  // most tets have the key of the one before
  for (int64_t t = 0; t < b->tet_count; t++)
    if (t == 0 || b->keys[t] != b->keys[t - 1])
      b->region_keys[kept++] = b->keys[t];

  qsort(b->region_keys, (size_t)kept, sizeof *b->region_keys, compare_keys);
  int64_t regions = 0;
  for (int64_t i = 0; i < kept; i++)
    if (i == 0 || b->region_keys[i] != b->region_keys[regions - 1])
      b->region_keys[regions++] = b->region_keys[i];

  if (regions > THRUM_MESH_GROUPS_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "%.200s: more than %d regions", name,
                           THRUM_MESH_GROUPS_MAX);

  mesh->region_count = regions > 0 ? regions : 1;
  for (int64_t t = 0; t < b->tet_count; t++)
    mesh->tet_region[t] = (int32_t)thrum_builder_region(b, mesh, b->keys[t]);
  return thrum_reserve(&mesh->materials, mesh->region_count, sizeof *mesh->materials, "the mesh",
                       b->error);
}

static thrum_status take_list(thrum_mesh_builder *b, const char *name, const thrum_named_list *list,
                              thrum_mesh *mesh) {
  int32_t *vertices = NULL;
  THRUM_TRY(thrum_reserve(&vertices, list->count + 1, sizeof *vertices, "the mesh", b->error));

  // numbers of the file become places in the mesh
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < list->count && status >= 0; i++) {
    const int64_t v = thrum_builder_find(b, list->numbers[i]);
    vertices[i] = (int32_t)v;
    if (v < 0)
      status = thrum_error_set(b->error, THRUM_BAD_VALUE,
                               "%.150s: group '%.80s' names vertex %lld, which is not in the file",
                               name, list->name, (long long)list->numbers[i]);
  }

  THRUM_THEN(status, thrum_mesh_add_group(mesh, list->name, vertices, list->count, b->error));
  free(vertices);
  return status;
}

/* Tells which elements were cut. */
static void note_cuts(const thrum_mesh_builder *b, thrum_mesh *mesh) {
  char list[160] = "";
  size_t length = 0;
  for (int kind = 0; kind < THRUM_SOLID_KINDS; kind++) {
    mesh->cut_elements += b->cut_elements[kind];
    if (b->cut_elements[kind] > 0)
      length +=
          (size_t)snprintf(list + length, sizeof list - length, "%s%lld %s", length > 0 ? ", " : "",
                           (long long)b->cut_elements[kind], thrum_solid_shapes[kind].name);
  }
  if (mesh->cut_elements > 0)
    thrum_mesh_add_note(mesh, "%s were cut into %lld tetrahedra of %s nodes", list,
                        (long long)b->cut_tets, b->middles ? "ten" : "four");
}

static thrum_status finish(thrum_mesh_builder *b, const char *name, int64_t *firsts,
                           thrum_mesh *mesh) {
  int64_t diagonals = 0;
  THRUM_TRY(thrum_builder_order(b, name));
  THRUM_TRY(join_diagonals(b, firsts, &diagonals));
  THRUM_TRY(take_tets(b, name, mesh));
  THRUM_TRY(take_vertices(b, mesh));
  if (b->joins_repeats)
    THRUM_TRY(join_repeats(b, mesh));
  THRUM_TRY(number_regions(b, name, mesh));
  for (int64_t i = 0; i < b->list_count; i++)
    THRUM_TRY(take_list(b, name, &b->lists[i], mesh));

  // the groups are there, so that new nodes can join them
  if (diagonals > 0)
    THRUM_TRY(append_diagonals(b, firsts, diagonals, mesh));
  note_cuts(b, mesh);
  return THRUM_OK;
}

thrum_status thrum_builder_finish(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  int64_t *firsts = NULL;
  thrum_status status =
      thrum_reserve(&firsts, b->diagonal_count, sizeof *firsts, "the mesh", b->error);
  THRUM_THEN(status, finish(b, name, firsts, mesh));
  free(firsts);
  return status;
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
  free(b->region_keys);
  *b = (thrum_mesh_builder){0};
}
