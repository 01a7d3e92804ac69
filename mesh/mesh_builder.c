/* Building a mesh from numbered vertices. Cost: linear in the mesh when the numbers have no gaps,
 * else n log n.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_builder.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "mesh/tet_repeats.h"

static thrum_status no_memory(thrum_mesh_builder *b) {
  return thrum_error_set(b->error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
}

thrum_status thrum_builder_vertex(thrum_mesh_builder *b, int64_t number, const double position[3],
                                  int64_t line) {
  const int64_t v = b->vertex_count;
  if (v == INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 vertices");
  if (!thrum_mesh_grow(&b->positions, &b->position_capacity, v + 1, 3 * sizeof *b->positions) ||
      !thrum_mesh_grow(&b->numbers, &b->number_capacity, v + 1, sizeof *b->numbers) ||
      !thrum_mesh_grow(&b->vertex_lines, &b->vertex_line_capacity, v + 1, sizeof line))
    return no_memory(b);
  memcpy(b->positions + 3 * v, position, 3 * sizeof *position);
  b->numbers[v] = number;
  b->vertex_lines[v] = line;
  b->vertex_count = v + 1;
  return THRUM_OK;
}

static thrum_status add_tet(thrum_mesh_builder *b, const int64_t vertices[4], int64_t key,
                            int64_t line) {
  const int64_t t = b->tet_count;

  if (t == INT32_MAX)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "more than 2^31 - 1 tetrahedra");

  if (!thrum_mesh_grow(&b->tets, &b->tet_capacity, t + 1, 4 * sizeof *b->tets) ||
      !thrum_mesh_grow(&b->keys, &b->key_capacity, t + 1, sizeof key) ||
      !thrum_mesh_grow(&b->lines, &b->line_capacity, t + 1, sizeof line))
    return no_memory(b);
  memcpy(b->tets + 4 * t, vertices, 4 * sizeof *vertices);
  b->keys[t] = key;
  b->lines[t] = line;
  b->tet_count = t + 1;
  return THRUM_OK;
}

thrum_status thrum_builder_tet(thrum_mesh_builder *b, const int64_t vertices[4], int64_t key,
                               int64_t line) {
  if (b->middles && b->odd_tet == 0)
    b->odd_tet = b->tet_count;
  return add_tet(b, vertices, key, line);
}

thrum_status thrum_builder_quadratic_tet(thrum_mesh_builder *b, const int64_t vertices[10],
                                         int64_t key, int64_t line) {
  const int64_t t = b->tet_count;
  if (t > 0 && !b->middles && b->odd_tet == 0)
    b->odd_tet = t;

  // a mesh of mixed orders is refused at the end, so its middle nodes no longer matter
  if (b->odd_tet == 0) {
    if (!thrum_mesh_grow(&b->middles, &b->middle_capacity, t + 1, 6 * sizeof *b->middles))
      return no_memory(b);
    memcpy(b->middles + 6 * t, vertices + 4, 6 * sizeof *vertices);
  }
  return add_tet(b, vertices, key, line);
}

static char *copy_name(const char *name, size_t length) {
  char *copy = malloc(length + 1);
  if (copy) {
    memcpy(copy, name, length);
    copy[length] = '\0';
  }
  return copy;
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

  if (!thrum_mesh_grow(&b->lists, &b->list_capacity, b->list_count + 1, sizeof *b->lists))
    return no_memory(b);
  char *copy = copy_name(name, length);
  if (!copy)
    return no_memory(b);
  *index = b->last_list = b->list_count++;
  b->lists[*index] = (thrum_named_list){.name = copy};
  return THRUM_OK;
}

thrum_status thrum_builder_rename(thrum_mesh_builder *b, int64_t list, const char *name,
                                  size_t length) {
  char *copy = copy_name(name, length);
  if (!copy)
    return no_memory(b);
  free(b->lists[list].name);
  b->lists[list].name = copy;
  return THRUM_OK;
}

thrum_status thrum_builder_add(thrum_mesh_builder *b, int64_t list, int64_t vertex) {
  thrum_named_list *l = &b->lists[list];
  if (!thrum_mesh_grow(&l->numbers, &l->capacity, l->count + 1, sizeof vertex))
    return no_memory(b);
  l->numbers[l->count++] = vertex;
  return THRUM_OK;
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

  const size_t count = (size_t)b->vertex_count;
  numbered *order = malloc(count * sizeof *order);
  double *positions = malloc(count * 3 * sizeof *positions);
  int64_t *lines = malloc(count * sizeof *lines);
  if (!order || !positions || !lines) {
    free(order);
    free(positions);
    free(lines);
    return no_memory(b);
  }

  // equal numbers keep their order, so that the later one is named as the repeat
  for (v = 0; v < b->vertex_count; v++)
    order[v] = (numbered){b->numbers[v], v};
  qsort(order, count, sizeof *order, compare_numbered);

  for (v = 0; v < b->vertex_count; v++) {
    memcpy(positions + 3 * v, b->positions + 3 * order[v].from, 3 * sizeof *positions);
    lines[v] = b->vertex_lines[order[v].from];
    b->numbers[v] = order[v].number;
  }

  free(order);
  free(b->positions);
  free(b->vertex_lines);
  b->positions = positions;
  b->vertex_lines = lines;
  return THRUM_OK;
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

  mesh->file_number = malloc((size_t)b->vertex_count * sizeof *mesh->file_number);
  if (!mesh->file_number)
    return no_memory(b);
  memcpy(mesh->file_number, b->numbers, (size_t)b->vertex_count * sizeof *b->numbers);
  return THRUM_OK;
}

static thrum_status missing_vertex(thrum_mesh_builder *b, const char *name, int64_t t,
                                   int64_t number) {
  char where[32];
  return thrum_error_set(b->error, THRUM_BAD_VALUE,
                         "%.200s%s: tet %lld names vertex %lld, which is not in the file; its "
                         "vertices are %lld to %lld",
                         name, place(b->lines[t], where), (long long)t + 1, (long long)number,
                         b->vertex_count > 0 ? (long long)b->numbers[0] : 0LL,
                         b->vertex_count > 0 ? (long long)b->numbers[b->vertex_count - 1] : -1LL);
}

/* Looks up the vertices that tets name, `nodes` a tet; the caller frees *places. */
static thrum_status find_places(thrum_mesh_builder *b, const char *name, const int64_t *numbers,
                                int nodes, int32_t **places) {
  *places = malloc(((size_t)b->tet_count + 1) * (size_t)nodes * sizeof **places);
  if (!*places)
    return no_memory(b);
  for (int64_t i = 0; i < nodes * b->tet_count; i++) {
    const int64_t v = thrum_builder_find(b, numbers[i]);
    if (v < 0)
      return missing_vertex(b, name, i / nodes, numbers[i]);
    (*places)[i] = (int32_t)v;
  }
  return THRUM_OK;
}

static thrum_status take_tets(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  char where[32];
  if (b->odd_tet > 0)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED,
                           "%.200s%s: tet %lld has %d nodes, where those before it have %d; all "
                           "tets of a mesh must be of one order",
                           name, place(b->lines[b->odd_tet], where), (long long)b->odd_tet + 1,
                           b->middles ? 4 : 10, b->middles ? 10 : 4);

  // numbers of the file become places, and the lines go over to the mesh
  THRUM_TRY(find_places(b, name, b->tets, 4, &mesh->tets));
  if (b->middles)
    THRUM_TRY(find_places(b, name, b->middles, 6, &mesh->midsides));
  mesh->tet_count = b->tet_count;
  mesh->tet_line = b->lines;
  b->lines = NULL;
  mesh->cornered_tets = b->cornered_tets;
  return THRUM_OK;
}

/* Keeps the first of repeated tets, with its key; the vertices of the others are in all of their
 * groups already. */
static thrum_status join_repeats(thrum_mesh_builder *b, thrum_mesh *mesh) {
  int64_t *earlier = thrum_mesh_tet_repeats(mesh), kept = 0;
  if (!earlier)
    return no_memory(b);

  // in place, so that what is kept stays in its order
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    if (earlier[t] >= 0)
      continue;
    memmove(mesh->tets + 4 * kept, mesh->tets + 4 * t, 4 * sizeof *mesh->tets);
    if (mesh->midsides)
      memmove(mesh->midsides + 6 * kept, mesh->midsides + 6 * t, 6 * sizeof *mesh->midsides);
    mesh->tet_line[kept] = mesh->tet_line[t];
    b->keys[kept++] = b->keys[t];
  }
  mesh->tet_count = b->tet_count = kept;
  free(earlier);
  return THRUM_OK;
}

static int compare_keys(const void *a, const void *b) {
  const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
  return (x > y) - (x < y);
}

/* A region for each key, ascending. */
static thrum_status number_regions(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  const size_t count = (size_t)b->tet_count + 1;
  b->region_keys = malloc(count * sizeof *b->region_keys);
  mesh->tet_region = malloc(count * sizeof *mesh->tet_region);
  if (!b->region_keys || !mesh->tet_region)
    return no_memory(b);

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

  for (int64_t t = 0; t < b->tet_count; t++) {
    const int64_t *found =
        bsearch(&b->keys[t], b->region_keys, (size_t)regions, sizeof *b->region_keys, compare_keys);
    mesh->tet_region[t] = (int32_t)(found - b->region_keys);
  }

  mesh->region_count = regions > 0 ? regions : 1;
  mesh->materials = calloc((size_t)mesh->region_count, sizeof *mesh->materials);
  return mesh->materials ? THRUM_OK : no_memory(b);
}

static thrum_status take_list(thrum_mesh_builder *b, const char *name, const thrum_named_list *list,
                              thrum_mesh *mesh) {
  int32_t *vertices = malloc(((size_t)list->count + 1) * sizeof *vertices);
  if (!vertices)
    return no_memory(b);

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

thrum_status thrum_builder_finish(thrum_mesh_builder *b, const char *name, thrum_mesh *mesh) {
  THRUM_TRY(thrum_builder_order(b, name));
  THRUM_TRY(take_vertices(b, mesh));
  THRUM_TRY(take_tets(b, name, mesh));
  if (b->joins_repeats)
    THRUM_TRY(join_repeats(b, mesh));
  THRUM_TRY(number_regions(b, name, mesh));
  for (int64_t i = 0; i < b->list_count; i++)
    THRUM_TRY(take_list(b, name, &b->lists[i], mesh));
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
  free(b->lists);
  free(b->positions);
  free(b->numbers);
  free(b->vertex_lines);
  free(b->tets);
  free(b->middles);
  free(b->keys);
  free(b->lines);
  free(b->region_keys);
  *b = (thrum_mesh_builder){0};
}
