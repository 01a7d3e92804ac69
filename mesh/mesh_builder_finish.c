/* The end of building a mesh: what tets and lists name is looked up, elements that were cut get the
 * nodes of their diagonals, keys become regions and lists groups. Cost: linear in the mesh when the
 * numbers have no gaps, else n log n.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"
#include "mesh/midsides.h"
#include "mesh/tet_repeats.h"
#include "mesh/warped_solids.h"
#include "platform/allocate.h"

/* How far middle nodes of straight edges may be off the middle, in edges: digits of a file. */
static const double STRAIGHT = 1e-5;

/* How far the centre of a face may be off its diagonal, in edges, before the node there leaves the
 * diagonal for it: flat halves are cheaper, and this keeps the volume to about a thousandth. */
static const double FLAT = 1e-3;

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
                         name, thrum_builder_place(b->lines[t], where), tet_word(b),
                         (long long)b->tet_numbers[t], (long long)number,
                         b->vertex_count > 0 ? (long long)b->numbers[0] : 0LL,
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

/* Places the node of a diagonal: on a flat face between straight edges in its middle, so that the
 * tets there are straight too; on others where the shape functions of the whole element have the
 * centre of the face or of the element, which for both is the sum of the middle nodes around it, by
 * 1/2 or 1/4, less that of the corners by 1/4. What a face gets depends on its nodes alone. */
static void place_diagonal(const thrum_mesh_builder *b, const thrum_mesh *mesh,
                           const thrum_diagonal *diagonal, int32_t ends[2], double position[3]) {
  const thrum_solid_topology *shape = &thrum_solid_shapes[diagonal->kind];
  const int64_t *nodes = b->cut_nodes + diagonal->nodes;
  const double share = diagonal->face >= 0 ? 0.5 : 0.25;
  double centre[3] = {0, 0, 0};
  bool curved = false;
  double longest = 0;

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
    longest = fmax(longest, length);
  }

  for (int end = 0; end < 2; end++)
    ends[end] = (int32_t)thrum_builder_find(b, diagonal->ends[end]);
  for (int axis = 0; axis < 3; axis++) {
    position[axis] = (mesh->vertices[3 * (int64_t)ends[0] + axis] +
                      mesh->vertices[3 * (int64_t)ends[1] + axis]) /
                     2;

    // the halves of a twisted face have its volume only with its centre on their common edge
    curved =
        curved || (diagonal->face >= 0 && fabs(centre[axis] - position[axis]) > FLAT * longest);
  }
  if (curved)
    memcpy(position, centre, sizeof centre);
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
                           thrum_builder_place(b->flat_line, where), (long long)b->flat_number);
  if (b->odd_tet > 0)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED,
                           "%.200s%s: %s %lld %s, where those before it %s; all elements of a mesh "
                           "must be of one order",
                           name, thrum_builder_place(b->lines[b->odd_tet], where), tet_word(b),
                           (long long)b->tet_numbers[b->odd_tet],
                           b->middles ? "has no middle nodes" : "has middle nodes",
                           b->middles ? "have some" : "have none");

  // numbers of the file become places, and the lines go over to the mesh
  THRUM_TRY(find_places(b, name, b->tets, 4, &mesh->tets));
  if (b->middles)
    THRUM_TRY(find_places(b, name, b->middles, 6, &mesh->midsides));
  mesh->tet_count = b->tet_count;
  mesh->cornered_tets = b->cornered_tets;
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
    if (b->tet_solids)
      b->tet_solids[kept] = b->tet_solids[t];
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
  if (mesh->cut_elements == 0)
    return;

  // warped elements have more tets, and what the cut does to the volume is said where it shows
  char more[100] = "";
  length = 0;
  if (b->centred_elements > 0)
    length = (size_t)snprintf(more, sizeof more, ", %lld of them around their centres",
                              (long long)b->centred_elements);
  if (fabs(b->cut_change) > 1e-5)
    snprintf(more + length, sizeof more - length, "; their volume is %.2g %% %s by that",
             fabs(100 * b->cut_change), b->cut_change < 0 ? "smaller" : "larger");
  mesh->cut_note = thrum_mesh_add_note(mesh, "%s were cut into %lld tetrahedra of %s nodes%s", list,
                                       (long long)b->cut_tets, b->middles ? "ten" : "four", more);
}

/* --- solids ---------------------------------------------------------------------------------- */

/* Has an element a node twice? */
static bool has_repeat(const int64_t *nodes, int count) {
  for (int i = 0; i < count; i++)
    for (int j = i + 1; j < count; j++)
      if (nodes[i] == nodes[j])
        return true;
  return false;
}

/* Can the elements be solids as they are? Plain tetrahedra need none, and pyramids, elements whose
 * nodes fall together and meshes of mixed orders are left to the cut. */
static bool are_solids(const thrum_mesh_builder *b) {
  bool others = false;
  for (int64_t i = 0; i < b->kept_count; i++) {
    const thrum_kept_element *e = &b->kept[i];
    const thrum_solid_topology *shape = &thrum_solid_shapes[e->kind];
    if (e->kind == THRUM_SOLID_PYRAMID || e->quadratic != b->kept[0].quadratic ||
        has_repeat(b->kept_nodes + e->nodes, shape->corners + (e->quadratic ? shape->edges : 0)))
      return false;
    others = others || e->kind != THRUM_SOLID_TET;
  }
  return others;
}

/* Makes tets of the elements that were kept, as those of solids or as elements themselves. */
static thrum_status release_elements(thrum_mesh_builder *b) {
  const bool solids = are_solids(b);
  b->keep_solids = false;
  for (int64_t i = 0; i < b->kept_count; i++) {
    const thrum_kept_element *e = &b->kept[i];
    const thrum_element element = {.kind = e->kind,
                                   .quadratic = e->quadratic || e->cornered,
                                   .nodes = b->kept_nodes + e->nodes,
                                   .number = e->number,
                                   .key = e->key,
                                   .line = e->line};
    THRUM_TRY(solids ? thrum_builder_solid(b, i) : thrum_builder_element(b, &element));
  }
  return THRUM_OK;
}

/* Gives the mesh its solids; those that came twice are there once, as their tets are. */
static thrum_status take_solids(thrum_mesh_builder *b, thrum_mesh *mesh) {
  if (!b->tet_solids)
    return THRUM_OK;
  if (b->kept_node_count > INT32_MAX || mesh->tet_count > INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 nodes of elements");
  const char *what = "the mesh";
  THRUM_TRY(thrum_reserve(&mesh->solid_form, b->kept_count, 1, what, b->error));
  THRUM_TRY(thrum_reserve(&mesh->solid_ends, b->kept_count, sizeof(int32_t), what, b->error));
  THRUM_TRY(thrum_reserve(&mesh->solid_tet_ends, b->kept_count, sizeof(int32_t), what, b->error));
  THRUM_TRY(thrum_reserve(&mesh->solid_nodes, b->kept_node_count, sizeof(int32_t), what, b->error));

  // the tets of one stand together
  int32_t end = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    if (t > 0 && b->tet_solids[t] == b->tet_solids[t - 1]) {
      mesh->solid_tet_ends[mesh->solid_count - 1]++;
      continue;
    }
    const thrum_kept_element *e = &b->kept[b->tet_solids[t]];
    const thrum_solid_form form = thrum_solid_form_of(e->kind, e->quadratic);
    for (int n = 0; n < thrum_solid_forms[form].nodes; n++)
      mesh->solid_nodes[end++] = (int32_t)thrum_builder_find(b, b->kept_nodes[e->nodes + n]);
    mesh->solid_form[mesh->solid_count] = (uint8_t)form;
    mesh->solid_ends[mesh->solid_count] = end;
    mesh->solid_tet_ends[mesh->solid_count++] = (int32_t)t + 1;
  }
  return THRUM_OK;
}

static thrum_status finish(thrum_mesh_builder *b, const char *name, int64_t *firsts,
                           thrum_mesh *mesh) {
  int64_t diagonals = 0;
  THRUM_TRY(thrum_builder_order(b, name));
  THRUM_TRY(thrum_builder_recut(b, name));
  THRUM_TRY(join_diagonals(b, firsts, &diagonals));
  THRUM_TRY(take_tets(b, name, mesh));
  THRUM_TRY(take_vertices(b, mesh));
  if (b->joins_repeats)
    THRUM_TRY(join_repeats(b, mesh));
  THRUM_TRY(take_solids(b, mesh));
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
  if (b->keep_solids)
    THRUM_TRY(release_elements(b));
  thrum_status status =
      thrum_reserve(&firsts, b->diagonal_count, sizeof *firsts, "the mesh", b->error);
  THRUM_THEN(status, finish(b, name, firsts, mesh));
  free(firsts);
  return status;
}
