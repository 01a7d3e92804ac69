/* Writing meshes: the choice of the writer, and the output that they share. Cost: linear in the
 * mesh, times the number of regions for their names.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_write.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "mesh/mesh_build.h"

enum { TEXT_MAX = 1024 };

static void flush_out(thrum_mesh_out *out) {
  if (out->status >= 0 && out->used > 0)
    out->status = thrum_file_writer_put(&out->file, out->buffer, out->used, out->error);
  out->used = 0;
}

void thrum_out_bytes(thrum_mesh_out *out, const void *bytes, size_t size) {
  if (size > sizeof out->buffer - out->used)
    flush_out(out);
  if (size <= sizeof out->buffer) {
    memcpy(out->buffer + out->used, bytes, size);
    out->used += size;
  } else if (out->status >= 0) {
    out->status = thrum_file_writer_put(&out->file, bytes, size, out->error);
  }
}

void thrum_out_text(thrum_mesh_out *out, const char *format, ...) {
  char text[TEXT_MAX];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (length > 0)
    thrum_out_bytes(out, text, (size_t)length < sizeof text ? (size_t)length : sizeof text - 1);
}

void thrum_out_number(thrum_mesh_out *out, double value) {
  char text[40];
  for (int digits = 15; digits <= 17; digits++) {
    snprintf(text, sizeof text, "%.*g", digits, value);
    if (strtod(text, NULL) == value)
      break;
  }
  // whatever mark the locale puts between the digits
  size_t kept = 0;
  bool foreign = false;
  for (const char *p = text; *p; p++) {
    const bool own = (*p >= '0' && *p <= '9') || *p == '-' || *p == '+' || *p == '.' || *p == 'e';
    if (own || !foreign)
      text[kept++] = own ? *p : '.';
    foreign = !own;
  }
  thrum_out_bytes(out, text, kept);
}

void thrum_out_vertex(thrum_mesh_out *out, const double position[3], const char *separator) {
  for (int c = 0; c < 3; c++) {
    thrum_out_number(out, position[c]);
    if (c < 2)
      thrum_out_text(out, "%s", separator);
  }
}

/* A copy of a name without the bytes that the format cannot have in it. */
static const char *clean_name(thrum_mesh_written *w, const char *name, const char *bad,
                              char text[256]) {
  size_t length = strlen(name);
  length = length > THRUM_MESH_NAME_MAX ? THRUM_MESH_NAME_MAX : length;
  bool changed = false;
  for (size_t i = 0; i < length; i++) {
    const bool edge = name[i] == ' ' && (i == 0 || i + 1 == length);
    text[i] = edge || strchr(bad, name[i]) ? '_' : name[i];
    changed = changed || text[i] != name[i];
  }
  text[length] = '\0';
  w->lost.names += changed;
  return text;
}

const char *thrum_write_group_name(thrum_mesh_written *w, int64_t group, const char *bad,
                                   char text[256]) {
  return clean_name(w, w->mesh->groups[group].name, bad, text);
}

const char *thrum_write_region_name(thrum_mesh_written *w, int64_t region, const char *bad,
                                    char text[256]) {
  if (w->region_group[region] >= 0)
    return thrum_write_group_name(w, w->region_group[region], bad, text);
  snprintf(text, 256, "region_%lld", (long long)region + 1);
  return text;
}

int32_t *thrum_write_marks(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int32_t *marks = calloc((size_t)m->vertex_count + 1, sizeof *marks);
  int32_t next = 1;
  if (!marks) {
    out->status = thrum_error_set(out->error, THRUM_OUT_OF_MEMORY, "not enough memory");
    return NULL;
  }
  for (int64_t g = 0; g < m->group_count; g++) {
    const thrum_group *group = &m->groups[g];
    // a region's group comes back under the number of the region
    const bool region = w->group_region[g] >= 0 && m->region_count > 1;
    bool overlaps = region;
    for (int64_t i = 0; i < group->count && !overlaps; i++)
      overlaps = marks[group->vertices[i]] != 0;
    w->lost.groups += overlaps && !region;
    w->lost.names += !overlaps || region;
    for (int64_t i = 0; i < group->count && !overlaps; i++)
      marks[group->vertices[i]] = next;
    next += !overlaps;
  }
  return marks;
}

/* The group that has just the vertices of a region. */
static int64_t find_region_group(const thrum_mesh *mesh, int64_t region, uint8_t *in_region) {
  memset(in_region, 0, (size_t)mesh->vertex_count);
  int64_t count = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++)
    for (int a = 0; a < 4 && mesh->tet_region[t] == region; a++) {
      const int32_t v = mesh->tets[4 * t + a];
      count += !in_region[v];
      in_region[v] = 1;
    }
  for (int64_t g = 0; g < mesh->group_count; g++) {
    const thrum_group *group = &mesh->groups[g];
    int64_t i = 0;
    while (group->count == count && i < count && in_region[group->vertices[i]])
      i++;
    if (i == count && group->count == count)
      return g;
  }
  return -1;
}

static thrum_status match_regions(thrum_mesh_written *w, thrum_error *error) {
  const thrum_mesh *m = w->mesh;
  uint8_t *in_region = malloc((size_t)m->vertex_count + 1);
  w->region_group = malloc(((size_t)m->region_count + 1) * sizeof *w->region_group);
  w->group_region = malloc(((size_t)m->group_count + 1) * sizeof *w->group_region);
  thrum_status status = THRUM_OK;
  if (!in_region || !w->region_group || !w->group_region)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory");
  for (int64_t g = 0; g < m->group_count && status >= 0; g++)
    w->group_region[g] = -1;
  for (int64_t i = 0; i < m->region_count && status >= 0; i++) {
    int64_t g = find_region_group(m, i, in_region);
    // a group names one region only
    if (g >= 0 && w->group_region[g] >= 0)
      g = -1;
    w->region_group[i] = g;
    if (g >= 0)
      w->group_region[g] = i;
  }
  free(in_region);
  return status;
}

static bool has_suffix(const char *name, const char *suffix) {
  const size_t n = strlen(name), m = strlen(suffix);
  for (size_t i = 0; n > m && i < m; i++) {
    const char c = name[n - m + i];
    if ((c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c) != suffix[i])
      return false;
  }
  return n > m;
}

/* Writes one file up to its commit. */
static thrum_status write_file(const char *path, thrum_mesh_writer *writer, thrum_mesh_written *w,
                               thrum_mesh_out **result, thrum_error *error) {
  thrum_mesh_out *out = calloc(1, sizeof *out);
  if (!out)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory");
  out->error = error;
  out->status = thrum_file_writer_open(path, &out->file, error);
  if (out->status >= 0) {
    writer(out, w);
    flush_out(out);
  }
  *result = out;
  return out->status;
}

/* One file, or TetGen's two, which are both made before either takes its place. */
static thrum_status write_files(const char *const *paths, thrum_mesh_writer *const *writers,
                                int count, thrum_mesh_written *w, thrum_error *error) {
  thrum_mesh_out *outs[2] = {NULL, NULL};
  thrum_status status = match_regions(w, error);
  for (int i = 0; i < count && status >= 0; i++)
    status = write_file(paths[i], writers[i], w, &outs[i], error);
  for (int i = 0; i < count && status >= 0; i++)
    status = thrum_file_writer_finish(&outs[i]->file, error);
  for (int i = 0; i < count && status >= 0; i++)
    status = thrum_file_writer_commit(&outs[i]->file, error);
  for (int i = 0; i < count; i++) {
    if (outs[i])
      thrum_file_writer_abandon(&outs[i]->file);
    free(outs[i]);
  }
  free(w->region_group);
  free(w->group_region);
  return status;
}

static thrum_status write_tetgen(const char *path, thrum_mesh_written *w, thrum_error *error) {
  const size_t stem = strlen(path) - (has_suffix(path, ".ele") ? 4 : 5);
  char *names[2] = {malloc(stem + 6), malloc(stem + 5)};
  thrum_status status = THRUM_OUT_OF_MEMORY;
  if (names[0] && names[1]) {
    for (int i = 0; i < 2; i++) {
      memcpy(names[i], path, stem);
      strcpy(names[i] + stem, i == 0 ? ".node" : ".ele");
    }
    const char *const paths[2] = {names[0], names[1]};
    thrum_mesh_writer *const writers[2] = {thrum_mesh_write_node, thrum_mesh_write_ele};
    status = write_files(paths, writers, 2, w, error);
  } else {
    thrum_error_set(error, status, "not enough memory");
  }
  free(names[0]);
  free(names[1]);
  return status;
}

thrum_status thrum_mesh_write(const char *path, const thrum_mesh *mesh,
                              const thrum_mesh_write_options *options, thrum_mesh_lost *lost,
                              thrum_error *error) {
  static const struct {
    const char *suffix;
    thrum_mesh_writer *write;
  } writers[] = {{".veg", thrum_mesh_write_veg},    {".msh", thrum_mesh_write_msh},
                 {".mesh", thrum_mesh_write_medit}, {".vtk", thrum_mesh_write_vtk},
                 {".vtu", thrum_mesh_write_vtu},    {".inp", thrum_mesh_write_abaqus}};
  thrum_mesh_written w = {.mesh = mesh, .options = *options};
  thrum_status status = THRUM_UNSUPPORTED;
  if (has_suffix(path, ".node") || has_suffix(path, ".ele")) {
    status = write_tetgen(path, &w, error);
  } else {
    size_t i = 0;
    const size_t count = sizeof writers / sizeof *writers;
    while (i < count && !has_suffix(path, writers[i].suffix))
      i++;
    if (i == count)
      return thrum_error_set(error, status,
                             "%.200s: unknown kind of mesh; name a .veg, .msh, .node, .ele, .mesh, "
                             ".vtk, .vtu or .inp file",
                             path);
    status = write_files(&path, &writers[i].write, 1, &w, error);
  }
  if (status >= 0)
    *lost = w.lost;
  return status;
}
