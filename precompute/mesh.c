/* The mesh itself: choice of the reader, checks and cleaning, groups, volume and hash.
 *
 * A tet counts as flat below 1e-12 of its longest edge cubed: coordinates that are coplanar on
 * paper miss zero by their rounding alone, about 1e-16 of (distance from the origin)/(edge), so
 * bodies up to 10^3 edges from the origin are caught; the worst slivers of real meshes lie at
 * 1e-6 and above. Cost: linear in the mesh, and n log n in the size of a group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/mesh.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "precompute/mesh_build.h"

static const double FLAT = 1e-12;

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

thrum_status thrum_mesh_read(const char *name, double scale, thrum_mesh *mesh, thrum_error *error) {
  thrum_mesh read = {0};
  thrum_status status;
  if (strncmp(name, "beam:", 5) == 0) {
    status = thrum_mesh_beam(name, &read, error);
    scale = 1;
  } else if (has_suffix(name, ".veg")) {
    status = thrum_mesh_read_veg(name, &read, error);
  } else if (has_suffix(name, ".msh")) {
    status = thrum_mesh_read_msh(name, &read, error);
  } else {
    status = thrum_error_set(error, THRUM_UNSUPPORTED,
                             "%.200s: unknown kind of mesh; give a .veg or .msh file or a "
                             "generator such as beam:20x3x3@1x0.15x0.15",
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

/* Where a message points: "file:line" of tet t as far as it is known. */
typedef struct place {
  char text[200];
} place;

static place tet_place(const thrum_mesh *mesh, const char *name, int64_t t) {
  place where;
  size_t length = strlen(name);
  const char *shown = length > 150 ? name + length - 150 : name;
  if (mesh->tet_line && mesh->tet_line[t] > 0)
    snprintf(where.text, sizeof where.text, "%s%s:%lld", length > 150 ? "..." : "", shown,
             (long long)mesh->tet_line[t]);
  else
    snprintf(where.text, sizeof where.text, "%s%s", length > 150 ? "..." : "", shown);
  return where;
}

/* What the file calls vertex v, before any was dropped. */
static int64_t number_of(const thrum_mesh *mesh, int32_t v) {
  return mesh->file_number ? mesh->file_number[v] : (int64_t)v + 1;
}

static thrum_status scale_vertices(thrum_mesh *mesh, const char *name, double scale,
                                   thrum_error *error) {
  if (!isfinite(scale) || scale <= 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the scale is %g; it turns lengths into metres and must be above 0",
                           scale);
  for (int64_t i = 0; i < 3 * mesh->vertex_count; i++) {
    if (!isfinite(mesh->vertices[i]) || !isfinite(scale * mesh->vertices[i]))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%.200s: vertex %lld is not at a finite place (scale %g)", name,
                             (long long)number_of(mesh, (int32_t)(i / 3)), scale);
    mesh->vertices[i] *= scale;
  }
  return THRUM_OK;
}

static thrum_status check_tet_vertices(const thrum_mesh *mesh, const char *name,
                                       thrum_error *error) {
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    const int32_t *v = mesh->tets + 4 * t;
    for (int a = 0; a < 4; a++)
      if (v[a] < 0 || v[a] >= mesh->vertex_count)
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "%s: tet %lld names vertex %lld, but there are %lld vertices",
                               tet_place(mesh, name, t).text, (long long)t + 1, (long long)v[a] + 1,
                               (long long)mesh->vertex_count);
    for (int a = 0; a < 4; a++)
      for (int b = a + 1; b < 4; b++)
        if (v[a] == v[b])
          return thrum_error_set(
              error, THRUM_BAD_VALUE, "%s: tet %lld has vertex %lld twice; remove or mend it",
              tet_place(mesh, name, t).text, (long long)t + 1, (long long)number_of(mesh, v[a]));
    if (mesh->tet_region[t] < 0 || mesh->tet_region[t] >= mesh->region_count)
      return thrum_error_set(error, THRUM_BAD_VALUE, "%s: tet %lld is in no region",
                             tet_place(mesh, name, t).text, (long long)t + 1);
  }
  return THRUM_OK;
}

/* Edges of tet t from its first vertex, divided by its longest edge, which is returned. */
static double unit_edges(const thrum_mesh *mesh, int64_t t, double edges[3][3]) {
  const int32_t *v = mesh->tets + 4 * t;
  double longest = 0;
  for (int a = 0; a < 4; a++)
    for (int b = a + 1; b < 4; b++) {
      double length = 0;
      for (int c = 0; c < 3; c++) {
        double d = mesh->vertices[3 * (int64_t)v[b] + c] - mesh->vertices[3 * (int64_t)v[a] + c];
        length = hypot(length, d);
        if (a == 0)
          edges[b - 1][c] = d;
      }
      longest = length > longest ? length : longest;
    }
  for (int i = 0; i < 9; i++)
    edges[i / 3][i % 3] /= longest > 0 ? longest : 1;
  return longest;
}

static double triple(double e[3][3]) {
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

double thrum_mesh_tet_volume(const thrum_mesh *mesh, int64_t t) {
  const int32_t *v = mesh->tets + 4 * t;
  double edges[3][3];
  for (int b = 1; b < 4; b++)
    for (int c = 0; c < 3; c++)
      edges[b - 1][c] =
          mesh->vertices[3 * (int64_t)v[b] + c] - mesh->vertices[3 * (int64_t)v[0] + c];
  return triple(edges) / 6;
}

static thrum_status fix_winding(thrum_mesh *mesh, const char *name, thrum_error *error) {
  int64_t inverted = 0, first = -1;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    double edges[3][3];
    double longest = unit_edges(mesh, t, edges);
    double shape = triple(edges) / 6;
    const int32_t *v = mesh->tets + 4 * t;
    if (!(fabs(shape) > FLAT))
      return thrum_error_set(
          error, THRUM_BAD_VALUE,
          "%s: tet %lld (vertices %lld %lld %lld %lld) has no volume; remove or mend it",
          tet_place(mesh, name, t).text, (long long)t + 1, (long long)number_of(mesh, v[0]),
          (long long)number_of(mesh, v[1]), (long long)number_of(mesh, v[2]),
          (long long)number_of(mesh, v[3]));
    // far outside, products of lengths leave the range of doubles
    if (!(longest > 1e-30 && longest < 1e30))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%s: tet %lld has an edge of %g m; check the scale",
                             tet_place(mesh, name, t).text, (long long)t + 1, longest);
    if (shape < 0) {
      first = inverted == 0 ? t : first;
      inverted++;
    }
  }
  if (inverted == 0)
    return THRUM_OK;
  if (inverted < mesh->tet_count)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "%s: tet %lld is the first of %lld inverted ones, while %lld are not; "
                           "all must be wound the same way",
                           tet_place(mesh, name, first).text, (long long)first + 1,
                           (long long)inverted, (long long)(mesh->tet_count - inverted));
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t *v = mesh->tets + 4 * t, swap = v[2];
    v[2] = v[3];
    v[3] = swap;
  }
  mesh->flipped_tets = inverted;
  return THRUM_OK;
}

/* Renumbers a group in place; an emptied one is removed by the caller. */
static void renumber_group(thrum_group *group, const int32_t *map) {
  int64_t kept = 0;
  for (int64_t i = 0; i < group->count; i++)
    if (map[group->vertices[i]] >= 0)
      group->vertices[kept++] = map[group->vertices[i]];
  group->count = kept;
}

static void renumber(thrum_mesh *mesh, const int32_t *map, int32_t kept) {
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    if (map[v] >= 0)
      memmove(mesh->vertices + 3 * (int64_t)map[v], mesh->vertices + 3 * v, 3 * sizeof(double));
  mesh->vertex_count = kept;
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    mesh->tets[i] = map[mesh->tets[i]];
  int64_t groups = 0;
  for (int64_t g = 0; g < mesh->group_count; g++) {
    thrum_group group = mesh->groups[g];
    renumber_group(&group, map);
    if (group.count > 0) {
      mesh->groups[groups++] = group;
    } else {
      free(group.name);
      free(group.vertices);
    }
  }
  mesh->group_count = groups;
}

static thrum_status drop_vertices(thrum_mesh *mesh, thrum_error *error) {
  int32_t *map = malloc((size_t)mesh->vertex_count * sizeof *map);
  if (!map)
    return no_memory(error);
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    map[v] = -1;
  for (int64_t i = 0; i < 4 * mesh->tet_count; i++)
    map[mesh->tets[i]] = 0;
  int32_t kept = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    if (map[v] == 0)
      map[v] = kept++;
  mesh->file_vertex_count = mesh->vertex_count;
  mesh->dropped_vertices = mesh->vertex_count - kept;
  if (mesh->dropped_vertices == 0) {
    free(map);
    return THRUM_OK;
  }
  renumber(mesh, map, kept);
  mesh->file_vertex = map;
  return THRUM_OK;
}

thrum_status thrum_mesh_clean(thrum_mesh *mesh, const char *name, double scale,
                              thrum_error *error) {
  if (mesh->tet_count == 0)
    return thrum_error_set(error, THRUM_MISSING, "%.200s: the mesh holds no tetrahedra", name);
  if (mesh->vertex_count > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%.200s: more than 2^31 - 1 vertices", name);
  thrum_status status = scale_vertices(mesh, name, scale, error);
  if (status >= 0)
    status = check_tet_vertices(mesh, name, error);
  if (status >= 0)
    status = fix_winding(mesh, name, error);
  if (status >= 0)
    status = drop_vertices(mesh, error);
  return status;
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
