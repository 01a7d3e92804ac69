/* The output of the mesh writers is buffered here; numbers are written so that they read back
 * exactly, and names are cleaned of the bytes that a format cannot have.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_out.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/number_text.h"
#include "mesh/mesh_elements.h"
#include "mesh/mesh_groups.h"
#include "platform/allocate.h"

enum { TEXT_MAX = 1024 };

void thrum_out_flush(thrum_mesh_out *out) {
  if (out->status >= 0 && out->used > 0)
    out->status = thrum_file_writer_put(&out->file, out->buffer, out->used, out->error);
  out->used = 0;
}

void thrum_out_bytes(thrum_mesh_out *out, const void *bytes, size_t size) {
  if (size > sizeof out->buffer - out->used)
    thrum_out_flush(out);
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
  char text[THRUM_NUMBER_TEXT];
  thrum_out_bytes(out, text, thrum_number_text(value, text));
}

void thrum_out_vertex(thrum_mesh_out *out, const double position[3], const char *separator) {
  for (int c = 0; c < 3; c++) {
    thrum_out_number(out, position[c]);
    if (c < 2)
      thrum_out_text(out, "%s", separator);
  }
}

/* Copies a name and replaces the bytes that the format cannot have in it. */
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

bool thrum_out_reserve(thrum_mesh_out *out, void *memory, int64_t count, size_t size) {
  const thrum_status status = thrum_reserve(memory, count, size, "the output", out->error);
  out->status = status < 0 ? status : out->status;
  return status >= 0;
}

void thrum_write_mark_group(const thrum_mesh *mesh, int64_t group, uint8_t *marks) {
  memset(marks, 0, (size_t)mesh->vertex_count);
  for (int64_t i = 0; i < mesh->groups[group].count; i++)
    marks[mesh->groups[group].vertices[i]] = 1;
}

void thrum_out_member(thrum_mesh_out *out, int64_t number, int *column) {
  thrum_out_text(out, "%s%lld", *column == 0 ? "" : ", ", (long long)number);
  *column = (*column + 1) % 10;
  if (*column == 0)
    thrum_out_text(out, "\n");
}

void thrum_out_end_members(thrum_mesh_out *out, int column) {
  if (column > 0)
    thrum_out_text(out, "\n");
}

void thrum_out_region_elements(thrum_mesh_out *out, const thrum_mesh *mesh, int64_t region) {
  int column = 0;
  for (int64_t e = 0; e < thrum_mesh_element_count(mesh); e++)
    if (thrum_mesh_element_region(mesh, e) == region)
      thrum_out_member(out, e + 1, &column);
  thrum_out_end_members(out, column);
}

int32_t *thrum_write_marks(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int32_t *marks = NULL, next = 1;
  if (!thrum_out_reserve(out, &marks, m->vertex_count, sizeof *marks))
    return NULL;

  // a vertex has one mark, so a group that shares vertices with an earlier one is lost
  for (int64_t g = 0; g < m->group_count; g++) {
    const thrum_group *group = &m->groups[g];

    // a region's group comes back under the number of the region
    const bool region = w->group_region[g] >= 0 && m->region_count > 1;

    bool overlaps = region;
    for (int64_t i = 0; i < group->count && !overlaps; i++)
      overlaps = marks[group->vertices[i]] != 0;

    // a group that is kept loses its name, since the format has only numbers
    w->lost.groups += overlaps && !region;
    w->lost.names += !overlaps || region;
    for (int64_t i = 0; i < group->count && !overlaps; i++)
      marks[group->vertices[i]] = next;
    next += !overlaps;
  }

  return marks;
}
