/* Finds what --fix names: places (vertex_places.h), files of vertex numbers, groups.
 *
 * Nothing is written to the caller's bytes until the whole spec is understood. Cost: linear in the
 * mesh and in the list.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "core/base/quadratic_tet.h"
#include "io/text.h"
#include "mesh/divide_shells.h"
#include "mesh/mesh.h"
#include "mesh/mesh_fix.h"
#include "mesh/mesh_groups.h"
#include "mesh/vertex_places.h"
#include "platform/allocate.h"

enum { ALL_AXES = 7 };

static bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Splits `:xyz` off the end of [spec, *end); bits of the components, all of them without it. */
static uint8_t split_components(const char *spec, const char **end) {
  const char *p = *end;
  uint8_t axes = 0;
  while (p > spec && p[-1] >= 'x' && p[-1] <= 'z') {
    p--;
    axes |= (uint8_t)(1 << (*p - 'x'));
  }
  while (p > spec && is_blank(p[-1]))
    p--;
  if (axes == 0 || p == spec || p[-1] != ':')
    return ALL_AXES;
  *end = p - 1;
  while (*end > spec && is_blank((*end)[-1]))
    (*end)--;
  return axes;
}

static const char *skip_blanks(const char *at, const char *end) {
  while (at < end && is_blank(*at))
    at++;
  return at;
}

static int64_t file_vertices(const thrum_mesh *mesh) {
  return mesh->file_vertex_count > 0 ? mesh->file_vertex_count : mesh->vertex_count;
}

/* First position whose number is not below `number`. */
static int64_t position_from(const thrum_mesh *mesh, int64_t number) {
  int64_t low = 0, high = file_vertices(mesh);
  while (low < high) {
    int64_t middle = low + (high - low) / 2;
    if (thrum_mesh_number(mesh, middle) < number)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/* Marks the vertices that the file numbers first..last. Ones that cleaning dropped are passed over:
 * they are not part of the body. */
static thrum_status mark_range(const thrum_mesh *mesh, const thrum_text *text, int64_t first,
                               int64_t last, uint8_t *marks) {
  // both ends must be vertices of the file
  int64_t count = file_vertices(mesh);
  for (int end = 0; end < 2; end++) {
    int64_t number = end ? last : first, at = position_from(mesh, number);
    if (at == count || thrum_mesh_number(mesh, at) != number)
      return thrum_text_fail(text, THRUM_BAD_VALUE,
                             "vertex %lld is not in the mesh, which has %lld, from %lld to %lld",
                             (long long)number, (long long)count,
                             (long long)thrum_mesh_number(mesh, 0),
                             (long long)thrum_mesh_number(mesh, count - 1));
  }

  if (first > last)
    return thrum_text_fail(text, THRUM_BAD_VALUE, "the range %lld:%lld runs backwards",
                           (long long)first, (long long)last);

  for (int64_t at = position_from(mesh, first); at < count && thrum_mesh_number(mesh, at) <= last;
       at++) {
    int64_t v = mesh->file_vertex ? mesh->file_vertex[at] : at;
    if (v >= 0)
      marks[v] = 1;
  }
  return THRUM_OK;
}

/* A number or a range a:b, blanks around the colon allowed. */
static thrum_status mark_entry(const thrum_mesh *mesh, thrum_text *text, uint8_t *marks) {
  int64_t bounds[2] = {0, 0};
  const char *word = text->at;

  // a number ends where another word could begin
  for (int i = 0; i < 2; i++) {
    while (text->at < text->end && is_blank(*text->at))
      text->at++;
    size_t used = thrum_text_scan_integer(text->at, text->end, &bounds[i]);
    text->at += used;
    bool stops =
        text->at == text->end || is_blank(*text->at) || *text->at == ',' || *text->at == ':';
    if (used == 0 || !stops)
      return thrum_text_fail(
          text, THRUM_BAD_FORMAT, "expected a vertex number or a range a:b, found '%s'",
          thrum_text_excerpt((thrum_word){word, (size_t)(text->end - word)}).text);

    // without a colon it is a range of one
    if (i == 0 && !thrum_text_take(text, ':')) {
      bounds[1] = bounds[0];
      break;
    }
  }

  return mark_range(mesh, text, bounds[0], bounds[1], marks);
}

/* A list has the numbers of a linear mesh: middle nodes that were made since between two of its
 * vertices are held with them, as in groups. */
static void mark_made_midsides(const thrum_mesh *mesh, uint8_t *marks) {
  const int64_t first = mesh->vertex_count - mesh->made_midsides;
  if (mesh->made_midsides == 0)
    return;
  if (mesh->midsides == NULL) {
    thrum_mesh_mark_divided(mesh, marks);
    return;
  }
  for (int64_t t = 0; t < mesh->tet_count; t++)
    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
      const int32_t middle = mesh->midsides[6 * t + e];
      const int32_t *corners = mesh->tets + 4 * t;
      const int *ends = thrum_quadratic_edges[e];
      if (middle >= first && marks[corners[ends[0]]] && marks[corners[ends[1]]])
        marks[middle] = 1;
    }
}

/* *empty tells a list without any number, which is how Vega's files say that a body is free. */
static thrum_status mark_file(const thrum_mesh *mesh, const char *path, uint8_t *marks, bool *empty,
                              thrum_error *error) {
  thrum_text text;
  thrum_status status = thrum_text_open(path, '#', ',', &text, error);
  if (status < 0)
    return status;
  *empty = true;
  while (status >= 0 && thrum_text_next_line(&text))
    while (status >= 0 && thrum_text_more(&text)) {
      status = mark_entry(mesh, &text, marks);
      *empty = false;
    }
  thrum_text_close(&text);
  if (status >= 0)
    mark_made_midsides(mesh, marks);
  return status;
}

/* "no such thing; the groups are a, b, ..." as far as the line has room. */
static thrum_status unknown_name(const thrum_mesh *mesh, const char *name, thrum_error *error) {
  if (mesh->group_count == 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "'%.100s' is neither a file nor a group, and the mesh has no groups; "
                           "use a predicate such as 'x<0.01'",
                           name);

  // the groups, as many as the line holds
  char list[200] = "";
  size_t length = 0;
  for (int64_t g = 0; g < mesh->group_count; g++) {
    const char *group = mesh->groups[g].name;
    size_t more = strlen(group) + 2;
    if (length + more + 5 > sizeof list) {
      memcpy(list + length, ", ...", 6);
      break;
    }
    length += (size_t)snprintf(list + length, sizeof list - length, "%s%s", g ? ", " : "", group);
  }

  return thrum_error_set(error, THRUM_MISSING,
                         "'%.100s' is neither a file nor a group; the groups are %s", name, list);
}

static bool is_file(const char *path) {
  struct stat about;
  return stat(path, &about) == 0 && !S_ISDIR(about.st_mode);
}

static thrum_status mark_name(const thrum_mesh *mesh, const char *name, uint8_t *marks, bool *empty,
                              thrum_error *error) {
  if (is_file(name))
    return mark_file(mesh, name, marks, empty, error);
  const thrum_group *group = thrum_mesh_find_group(mesh, name);
  if (!group)
    return unknown_name(mesh, name, error);
  for (int64_t i = 0; i < group->count; i++)
    marks[group->vertices[i]] = 1;
  return THRUM_OK;
}

/* `text` is the spec without blanks around it. */
static thrum_status mark(const thrum_mesh *mesh, char *text, uint8_t *marks, uint8_t *axes,
                         bool *empty, thrum_error *error) {
  const bool place = thrum_vertex_places_meant(text);
  // a name that happens to end like components is still that name
  if (!place && (is_file(text) || thrum_mesh_find_group(mesh, text))) {
    *axes = ALL_AXES;
    return mark_name(mesh, text, marks, empty, error);
  }
  const char *end = text + strlen(text);
  *axes = split_components(text, &end);
  if (place)
    return thrum_vertex_places_mark(mesh->vertices, mesh->vertex_count, text, (size_t)(end - text),
                                    marks, error);
  text[end - text] = '\0';
  return mark_name(mesh, text, marks, empty, error);
}

/* A copy without blanks around it; other blanks and control characters become spaces, which keeps
 * messages on one line and terminals as they are. NULL when out of memory. */
static char *copy_spec(const char *spec, thrum_scope *scope) {
  const char *stop = spec + strlen(spec);
  spec = skip_blanks(spec, stop);
  while (stop > spec && is_blank(stop[-1]))
    stop--;
  char *text = thrum_scope_allocate(scope, stop - spec + 1, 1);
  for (size_t i = 0; text && i < (size_t)(stop - spec); i++)
    text[i] = (unsigned char)spec[i] < ' ' || spec[i] == 0x7f ? ' ' : spec[i];
  return text;
}

static thrum_status mark_all(const thrum_mesh *mesh, char *text, uint8_t *marks, uint8_t *axes,
                             int64_t *named, thrum_error *error) {
  if (!*text)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "what to fix is empty; name a group, a file or "
                           "a predicate such as 'x<0.01'");
  // mark may cut the components off
  char shown[101];
  snprintf(shown, sizeof shown, "%s", text);
  bool empty = false;
  THRUM_TRY(mark(mesh, text, marks, axes, &empty, error));
  *named = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    *named += marks[v];
  if (*named == 0 && !empty)
    return thrum_vertex_places_none(mesh->vertices, mesh->vertex_count, shown, error);
  return THRUM_OK;
}

thrum_status thrum_mesh_fix(const thrum_mesh *mesh, const char *spec, uint8_t *fixed,
                            int64_t *count, thrum_error *error) {
  thrum_scope scope = thrum_scope_begin("what is fixed", error);
  char *text = copy_spec(spec, &scope);
  uint8_t *marks = thrum_scope_allocate(&scope, mesh->vertex_count, 1);
  uint8_t axes = ALL_AXES;
  int64_t named = 0;

  // the marks of all parts of the spec
  thrum_status status = scope.status;
  THRUM_THEN(status, mark_all(mesh, text, marks, &axes, &named, error));

  // what was held before stays held
  if (status >= 0) {
    for (int64_t v = 0; v < mesh->vertex_count; v++)
      fixed[v] |= marks[v] ? axes : 0;
    *count = named;
  }

  thrum_scope_free(&scope);
  return status;
}
