/* The mesh itself: choice of the reader, groups, volume and hash. Cost: linear in the mesh, and
 * n log n in the size of a group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh.h"

#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "mesh/mesh_build.h"

void thrum_mesh_free(thrum_mesh *mesh) {
  for (int64_t g = 0; g < mesh->group_count; g++) {
    free(mesh->groups[g].name);
    free(mesh->groups[g].vertices);
  }
  free(mesh->groups);
  free(mesh->vertices);
  free(mesh->tets);
  free(mesh->tet_region);
  free(mesh->materials);
  free(mesh->file_vertex);
  free(mesh->file_number);
  free(mesh->tet_line);
  *mesh = (thrum_mesh){0};
}

void *thrum_mesh_grow(void *array, int64_t *capacity, int64_t needed, size_t size) {
  if (needed <= *capacity)
    return array;
  int64_t room = *capacity < 32 ? 64 : *capacity;
  while (room < needed) {
    if (room > INT64_MAX / 2)
      return NULL;
    room *= 2;
  }
  if ((uint64_t)room > SIZE_MAX / 2 / size)
    return NULL;
  void *moved = realloc(array, (size_t)room * size);
  if (moved)
    *capacity = room;
  return moved;
}

const char *thrum_mesh_name_fault(const char *name, size_t length) {
  if (length == 0)
    return "a name is empty";
  if (length > THRUM_MESH_NAME_MAX)
    return "a name is longer than 255 bytes";
  // printable UTF-8, as names end up in JSON and on terminals
  for (size_t i = 0; i < length;) {
    unsigned char lead = (unsigned char)name[i++];
    if (lead < 0x20 || lead == 0x7f)
      return "a name holds a control character";
    size_t more = lead < 0x80                   ? 0
                  : lead >= 0xc2 && lead < 0xe0 ? 1
                  : lead >= 0xe0 && lead < 0xf0 ? 2
                  : lead >= 0xf0 && lead < 0xf5 ? 3
                                                : SIZE_MAX;
    if (more > length - i)
      return "a name is not UTF-8";
    for (; more > 0; more--)
      if (((unsigned char)name[i++] & 0xc0) != 0x80)
        return "a name is not UTF-8";
  }
  return NULL;
}

static int compare_vertices(const void *a, const void *b) {
  int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
  return (x > y) - (x < y);
}

static int64_t sort_unique(int32_t *vertices, int64_t count) {
  qsort(vertices, (size_t)count, sizeof *vertices, compare_vertices);
  int64_t kept = 0;
  for (int64_t i = 0; i < count; i++)
    if (kept == 0 || vertices[i] != vertices[kept - 1])
      vertices[kept++] = vertices[i];
  return kept;
}

static thrum_group *find_group(thrum_mesh *mesh, const char *name) {
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, name) == 0)
      return &mesh->groups[g];
  return NULL;
}

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory for the mesh");
}

thrum_status thrum_mesh_add_group(thrum_mesh *mesh, const char *name, const int32_t *vertices,
                                  int64_t count, thrum_error *error) {
  if (count == 0)
    return THRUM_OK;
  thrum_group *group = find_group(mesh, name);
  if (group) {
    int64_t capacity = group->count;
    int32_t *grown =
        thrum_mesh_grow(group->vertices, &capacity, group->count + count, sizeof *vertices);
    if (!grown)
      return no_memory(error);
    group->vertices = grown;
    memcpy(group->vertices + group->count, vertices, (size_t)count * sizeof *vertices);
    group->count = sort_unique(group->vertices, group->count + count);
    return THRUM_OK;
  }
  if (mesh->group_count == THRUM_MESH_GROUPS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "more than %d groups", THRUM_MESH_GROUPS_MAX);
  char *copy = malloc(strlen(name) + 1);
  int32_t *list = malloc((size_t)count * sizeof *list);
  thrum_group *groups =
      realloc(mesh->groups, (size_t)(mesh->group_count + 1) * sizeof *mesh->groups);
  if (groups)
    mesh->groups = groups;
  if (!copy || !list || !groups) {
    free(copy);
    free(list);
    return no_memory(error);
  }
  memcpy(copy, name, strlen(name) + 1);
  memcpy(list, vertices, (size_t)count * sizeof *list);
  groups[mesh->group_count++] =
      (thrum_group){.name = copy, .count = sort_unique(list, count), .vertices = list};
  return THRUM_OK;
}

thrum_status thrum_mesh_add_region_group(thrum_mesh *mesh, int32_t region, const char *name,
                                         thrum_error *error) {
  int32_t *vertices = malloc(((size_t)mesh->tet_count * 4 + 1) * sizeof *vertices);
  if (!vertices)
    return no_memory(error);
  int64_t count = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    if (mesh->tet_region[t] == region) {
      memcpy(vertices + count, mesh->tets + 4 * t, 4 * sizeof *vertices);
      count += 4;
    }
  thrum_status status = thrum_mesh_add_group(mesh, name, vertices, count, error);
  free(vertices);
  return status;
}

/* The vertices of a tet in ascending order. */
static void sorted_tet(const int32_t *tet, int32_t sorted[4]) {
  memcpy(sorted, tet, 4 * sizeof *tet);
  for (int i = 1; i < 4; i++)
    for (int j = i; j > 0 && sorted[j] < sorted[j - 1]; j--) {
      int32_t swap = sorted[j];
      sorted[j] = sorted[j - 1];
      sorted[j - 1] = swap;
    }
}

int64_t *thrum_mesh_tet_repeats(const thrum_mesh *mesh) {
  uint64_t slots = 16;
  while (slots < 2 * (uint64_t)mesh->tet_count)
    slots *= 2;
  int64_t *table = malloc(slots * sizeof *table);
  int64_t *earlier = malloc(((size_t)mesh->tet_count + 1) * sizeof *earlier);
  if (!table || !earlier) {
    free(table);
    free(earlier);
    return NULL;
  }
  for (uint64_t i = 0; i < slots; i++)
    table[i] = -1;
  // open addressing over the sorted vertices
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t key[4], other[4];
    sorted_tet(mesh->tets + 4 * t, key);
    uint64_t hash = 0;
    for (int a = 0; a < 4; a++)
      hash = (hash ^ (uint32_t)key[a]) * UINT64_C(0x9e3779b97f4a7c15);
    uint64_t slot = hash >> 20 & (slots - 1);
    earlier[t] = -1;
    for (; table[slot] >= 0; slot = (slot + 1) & (slots - 1)) {
      sorted_tet(mesh->tets + 4 * table[slot], other);
      if (memcmp(key, other, sizeof key) == 0) {
        earlier[t] = table[slot];
        break;
      }
    }
    if (earlier[t] < 0)
      table[slot] = t;
  }
  free(table);
  return earlier;
}

static bool has_suffix(const char *name, const char *suffix) {
  size_t n = strlen(name), m = strlen(suffix);
  if (n <= m)
    return false;
  for (size_t i = 0; i < m; i++) {
    char c = name[n - m + i];
    if ((c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c) != suffix[i])
      return false;
  }
  return true;
}

static const struct {
  const char *suffix;
  thrum_mesh_parser *parse;
} PARSERS[] = {{".veg", thrum_mesh_parse_veg},    {".msh", thrum_mesh_parse_msh},
               {".mesh", thrum_mesh_parse_medit}, {".vtk", thrum_mesh_parse_vtk},
               {".vtu", thrum_mesh_parse_vtu},    {".inp", thrum_mesh_parse_abaqus}};

static thrum_mesh_parser *find_parser(const char *name) {
  for (size_t i = 0; i < sizeof PARSERS / sizeof *PARSERS; i++)
    if (has_suffix(name, PARSERS[i].suffix))
      return PARSERS[i].parse;
  return NULL;
}

static thrum_status read_file(const char *path, thrum_mesh_parser *parse, thrum_mesh *mesh,
                              thrum_error *error) {
  void *data = NULL;
  size_t size = 0;
  thrum_status status = thrum_file_read(path, &data, &size, error);
  if (status >= 0)
    status = parse(path, data, size, mesh, error);
  free(data);
  return status;
}

/* Either file of TetGen's pair names both. */
static thrum_status read_tetgen(const char *path, thrum_mesh *mesh, thrum_error *error) {
  const size_t length = strlen(path), stem = length - (has_suffix(path, ".ele") ? 4 : 5);
  char *names[2] = {malloc(stem + 6), malloc(stem + 5)};
  void *data[2] = {NULL, NULL};
  size_t size[2] = {0, 0};
  thrum_status status = THRUM_OK;
  if (!names[0] || !names[1])
    status = no_memory(error);
  for (int i = 0; i < 2 && status >= 0; i++) {
    memcpy(names[i], path, stem);
    strcpy(names[i] + stem, i == 0 ? ".node" : ".ele");
    // the one that was given keeps its capitals
    const bool given = has_suffix(path, i == 0 ? ".node" : ".ele");
    status = thrum_file_read(given ? path : names[i], &data[i], &size[i], error);
  }
  if (status >= 0)
    status = thrum_mesh_parse_tetgen(names[0], data[0], size[0], names[1], data[1], size[1], mesh,
                                     error);
  for (int i = 0; i < 2; i++) {
    free(names[i]);
    free(data[i]);
  }
  return status;
}

bool thrum_mesh_is_named(const char *name) {
  return strncmp(name, "beam:", 5) == 0 || find_parser(name) || has_suffix(name, ".node") ||
         has_suffix(name, ".ele");
}

thrum_status thrum_mesh_read(const char *name, double scale, thrum_mesh *mesh, thrum_error *error) {
  thrum_mesh read = {0};
  thrum_mesh_parser *parse = find_parser(name);
  thrum_status status;
  if (name[0] == '\0') {
    status = thrum_error_set(error, THRUM_IO, "the name of the mesh is empty");
  } else if (strncmp(name, "beam:", 5) == 0) {
    status = thrum_mesh_beam(name, &read, error);
  } else if (parse) {
    status = read_file(name, parse, &read, error);
  } else if (has_suffix(name, ".node") || has_suffix(name, ".ele")) {
    status = read_tetgen(name, &read, error);
  } else {
    status = thrum_error_set(error, THRUM_UNSUPPORTED,
                             "%.200s: unknown kind of mesh; give a .veg, .msh, .node, .ele, .mesh, "
                             ".vtk, .vtu or .inp file, or a generator such as "
                             "beam:20x3x3@1x0.15x0.15",
                             name);
  }
  if (status >= 0)
    status = thrum_mesh_clean(&read, name, scale, error);
  if (status < 0) {
    thrum_mesh_free(&read);
    return status;
  }
  *mesh = read;
  return THRUM_OK;
}

double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t) {
  const int32_t *v = mesh->tets + 4 * t;
  double edges[3][3];
  for (int b = 1; b < 4; b++)
    for (int c = 0; c < 3; c++)
      edges[b - 1][c] =
          mesh->vertices[3 * (int64_t)v[b] + c] - mesh->vertices[3 * (int64_t)v[0] + c];
  return thrum_mesh_triple(edges) / 6;
}

/* FNV-1a over the eight bytes of a number, lowest first, on any machine. */
static uint64_t hash_number(uint64_t hash, uint64_t number) {
  for (int i = 0; i < 8; i++) {
    hash ^= number >> 8 * i & 0xff;
    hash *= UINT64_C(1099511628211);
  }
  return hash;
}

uint64_t thrum_mesh_hash(const thrum_mesh *mesh) {
  uint64_t hash = UINT64_C(14695981039346656037);
  hash = hash_number(hash, (uint64_t)mesh->vertex_count);
  hash = hash_number(hash, (uint64_t)mesh->tet_count);
  for (int64_t i = 0; i < 3 * mesh->vertex_count; i++) {
    uint64_t bits;
    memcpy(&bits, &mesh->vertices[i], sizeof bits);
    hash = hash_number(hash, bits);
  }
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    hash = hash_number(hash, (uint64_t)mesh->tets[i]);
  for (int64_t t = 0; t < mesh->tet_count; t++)
    hash = hash_number(hash, (uint64_t)mesh->tet_region[t]);
  return hash;
}
