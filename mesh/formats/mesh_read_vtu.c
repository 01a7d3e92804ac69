/* VTK XML files (.vtu) with one UnstructuredGrid: arrays in ASCII, in base64 inline, or appended
 * raw or in base64, of either byte order, headers UInt32 or UInt64, not compressed. An array of
 * bytes is its length and then its bytes. Only what VTK writes of XML is read: elements,
 * attributes, comments, the five named entities.
 * Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
 * Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/vtk_cells.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"

/* An element: where its name and its attributes stand. */
typedef struct vtu_tag {
  const char *name;
  size_t length;
  const char *attributes, *end;
  bool closing; /* </name> */
  bool empty;   /* <name/> */
} vtu_tag;

typedef struct vtu_reader {
  const char *name;
  const char *at, *stop;
  const char *appended; /* first byte behind the '_'; NULL: none */
  bool appended_base64;
  bool little;
  int header_size; /* 4 or 8 bytes of length in front of bytes */
  bool has_piece;
  thrum_cells_place place;
  thrum_cells cells;
  thrum_error *error;
} vtu_reader;

static thrum_status fail(vtu_reader *r, thrum_status status, const char *line) {
  return thrum_error_set(r->error, status, "%.200s: %s", r->name, line);
}

/* First occurrence of a text in [from, stop); NULL when there is none. */
static const char *find(const char *from, const char *stop, const char *text) {
  const size_t length = strlen(text);
  while ((size_t)(stop - from) >= length) {
    const char *hit = memchr(from, text[0], (size_t)(stop - from) - length + 1);
    if (!hit)
      return NULL;
    if (memcmp(hit, text, length) == 0)
      return hit;
    from = hit + 1;
  }
  return NULL;
}

static bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* The next element, comments and declarations passed over; false at the end of the file. */
static bool next_tag(vtu_reader *r, vtu_tag *tag) {
  for (;;) {
    const char *open = r->at < r->stop ? memchr(r->at, '<', (size_t)(r->stop - r->at)) : NULL;
    if (!open)
      return false;
    const bool comment = r->stop - open >= 4 && memcmp(open, "<!--", 4) == 0;
    const char *close = comment ? find(open + 4, r->stop, "-->") : NULL;
    // a '>' inside quotes belongs to an attribute
    char quote = 0;
    for (const char *p = open + 1; !comment && !close && p < r->stop; p++) {
      if (quote ? *p == quote : *p == '"' || *p == '\'')
        quote = quote ? 0 : *p;
      else if (!quote && *p == '>')
        close = p;
    }
    if (!close)
      return false;
    r->at = close + (comment ? 3 : 1);
    if (comment || open[1] == '?' || open[1] == '!')
      continue;
    tag->closing = open[1] == '/';
    tag->empty = close[-1] == '/' && close - 1 > open;
    tag->name = open + 1 + tag->closing;
    tag->end = close - tag->empty;
    const char *p = tag->name;
    while (p < tag->end && !is_space(*p))
      p++;
    tag->length = (size_t)(p - tag->name);
    tag->attributes = p;
    return true;
  }
}

static bool tag_is(const vtu_tag *tag, const char *name) {
  return strlen(name) == tag->length && memcmp(tag->name, name, tag->length) == 0;
}

/* The value of an attribute; false when it is not there. */
static bool attribute(const vtu_tag *tag, const char *key, const char **value, size_t *length) {
  for (const char *p = tag->attributes; p < tag->end;) {
    while (p < tag->end && is_space(*p))
      p++;
    const char *name = p;
    while (p < tag->end && *p != '=' && !is_space(*p))
      p++;
    const size_t name_length = (size_t)(p - name);
    while (p < tag->end && *p != '"' && *p != '\'')
      p++;
    if (p == tag->end)
      return false;
    const char *start = p + 1;
    const char *end = memchr(start, *p, (size_t)(tag->end - start));
    if (!end)
      return false;
    if (strlen(key) == name_length && memcmp(key, name, name_length) == 0) {
      *value = start;
      *length = (size_t)(end - start);
      return true;
    }
    p = end + 1;
  }
  return false;
}

static bool attribute_is(const vtu_tag *tag, const char *key, const char *wanted) {
  const char *value;
  size_t length;
  return attribute(tag, key, &value, &length) && thrum_text_equals(value, length, wanted);
}

/* An attribute as a whole number; absent leaves *number. */
static thrum_status attribute_integer(vtu_reader *r, const vtu_tag *tag, const char *key,
                                      int64_t high, int64_t *number) {
  const char *value;
  size_t length;
  int64_t read = 0;
  if (!attribute(tag, key, &value, &length))
    return THRUM_OK;
  if (length == 0 || thrum_text_scan_integer(value, value + length, &read) != length || read < 0 ||
      read > high)
    return thrum_error_set(r->error, THRUM_BAD_VALUE,
                           "%.200s: %s is '%s'; expected a whole number from 0 to %lld", r->name,
                           key, thrum_text_excerpt(value, length).text, (long long)high);
  *number = read;
  return THRUM_OK;
}

/* Copies a name with its entities resolved, cut at what fits. */
static void copy_name(const char *text, size_t length, char name[THRUM_MESH_NAME_MAX + 1]) {
  static const struct {
    const char *entity;
    char character;
  } entities[] = {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}};
  size_t used = 0;
  for (size_t i = 0; i < length && used < THRUM_MESH_NAME_MAX;) {
    size_t step = 1;
    name[used] = text[i];
    for (size_t e = 0; e < sizeof entities / sizeof *entities; e++) {
      const size_t n = strlen(entities[e].entity);
      if (n <= length - i && memcmp(text + i, entities[e].entity, n) == 0) {
        name[used] = entities[e].character;
        step = n;
      }
    }
    used++;
    i += step;
  }
  name[used] = '\0';
}

static int base64_value(char c) {
  if (c >= 'A' && c <= 'Z')
    return c - 'A';
  if (c >= 'a' && c <= 'z')
    return c - 'a' + 26;
  if (c >= '0' && c <= '9')
    return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/* Decodes at most `wanted` bytes; returns how many there were. Padding may stand between, as where
 * the length was encoded alone. */
static size_t decode_base64(const char *at, const char *stop, unsigned char *bytes, size_t wanted) {
  size_t used = 0;
  uint32_t bits = 0;
  int held = 0;
  for (; at < stop && used < wanted; at++) {
    const int value = base64_value(*at);
    if (*at == '=') {
      held = 0;
      continue;
    }
    if (value < 0) {
      if (is_space(*at))
        continue;
      break;
    }
    bits = bits << 6 | (uint32_t)value;
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes[used++] = (unsigned char)(bits >> held & 0xff);
    }
  }
  return used;
}

static uint64_t header_value(const vtu_reader *r, const unsigned char *bytes) {
  const thrum_cells_type type = {4, true, false};
  if (r->header_size == 4)
    return (uint64_t)thrum_cells_number(type, bytes, r->little);
  uint64_t value = 0;
  for (int i = 0; i < 8; i++)
    value = value << 8 | bytes[r->little ? 7 - i : i];
  return value;
}

/* The bytes of an array at `at`: its length and what follows. *owned is to be freed. */
static thrum_status find_bytes(vtu_reader *r, const char *at, bool base64,
                               const unsigned char **bytes, uint64_t *count,
                               unsigned char **owned) {
  const size_t header = (size_t)r->header_size, left = (size_t)(r->stop - at);
  unsigned char first[8];
  if (!base64) {
    if (left < header)
      return fail(r, THRUM_BAD_FORMAT, "an array begins beyond the end; is it cut short?");
    *bytes = (const unsigned char *)at + header;
    *count = header_value(r, (const unsigned char *)at);
    if (*count > left - header)
      return fail(r, THRUM_BAD_FORMAT, "an array is longer than the file; is it cut short?");
    return THRUM_OK;
  }
  if (decode_base64(at, r->stop, first, header) != header)
    return fail(r, THRUM_BAD_FORMAT, "an array in base64 has no length");
  *count = header_value(r, first);
  if (*count > left)
    return fail(r, THRUM_BAD_FORMAT, "an array is longer than the file; is it cut short?");
  *owned = malloc(header + *count);
  if (!*owned)
    return fail(r, THRUM_OUT_OF_MEMORY, "not enough memory");
  if (decode_base64(at, r->stop, *owned, header + *count) != header + *count)
    return fail(r, THRUM_BAD_FORMAT, "an array in base64 is shorter than it says");
  *bytes = *owned + header;
  return THRUM_OK;
}

static thrum_status binary_array(vtu_reader *r, const char *at, bool base64, thrum_cells_type type,
                                 thrum_cells_array *array) {
  const unsigned char *bytes = NULL;
  unsigned char *owned = NULL;
  uint64_t size = 0;
  thrum_status status = find_bytes(r, at, base64, &bytes, &size, &owned);
  if (status >= 0) {
    array->count = (int64_t)(size / (uint64_t)type.size);
    array->values = malloc(((size_t)array->count + 1) * sizeof *array->values);
    if (!array->values)
      status = fail(r, THRUM_OUT_OF_MEMORY, "not enough memory");
  }
  for (int64_t i = 0; status >= 0 && i < array->count; i++)
    array->values[i] = thrum_cells_number(type, bytes + i * type.size, r->little);
  free(owned);
  return status;
}

/* Numbers up to the next element. */
static thrum_status ascii_array(vtu_reader *r, thrum_cells_array *array) {
  int64_t capacity = 0;
  const char *p = r->at;
  while (p < r->stop && *p != '<') {
    if (is_space(*p)) {
      p++;
      continue;
    }
    double *values = thrum_mesh_grow(array->values, &capacity, array->count + 1, sizeof *values);
    if (!values)
      return fail(r, THRUM_OUT_OF_MEMORY, "not enough memory");
    array->values = values;
    const char *end = p;
    while (end < r->stop && !is_space(*end) && *end != '<')
      end++;
    const size_t used = thrum_text_scan_number(p, end, &values[array->count]);
    if (used == 0 || p + used != end)
      return thrum_error_set(r->error, THRUM_BAD_FORMAT,
                             "%.200s: array '%s': expected a number, found '%s'", r->name,
                             thrum_text_excerpt(array->name, strlen(array->name)).text,
                             thrum_text_excerpt(p, (size_t)(end - p)).text);
    array->count++;
    p = end;
  }
  r->at = p;
  return THRUM_OK;
}

static thrum_status array_values(vtu_reader *r, const vtu_tag *tag, thrum_cells_type type,
                                 thrum_cells_array *array) {
  int64_t offset = 0;
  if (attribute_is(tag, "format", "appended")) {
    thrum_status status = attribute_integer(r, tag, "offset", INT64_MAX, &offset);
    if (status < 0)
      return status;
    if (!r->appended || offset > r->stop - r->appended)
      return fail(r, THRUM_BAD_FORMAT,
                  "an array lies beyond the appended data; is the file cut short?");
    return binary_array(r, r->appended + offset, r->appended_base64, type, array);
  }
  if (tag->empty)
    return THRUM_OK;
  if (attribute_is(tag, "format", "binary"))
    return binary_array(r, r->at, true, type, array);
  return ascii_array(r, array);
}

/* Which part of the grid an array is. */
static thrum_cells_place array_place(const vtu_reader *r, const char *name) {
  if (r->place != THRUM_CELLS_CONNECTIVITY)
    return r->place;
  return strcmp(name, "connectivity") == 0 ? THRUM_CELLS_CONNECTIVITY
         : strcmp(name, "offsets") == 0    ? THRUM_CELLS_OFFSETS
         : strcmp(name, "types") == 0      ? THRUM_CELLS_TYPES
                                           : THRUM_CELLS_OTHER;
}

static thrum_status read_array(vtu_reader *r, const vtu_tag *tag) {
  thrum_cells_array array = {.columns = 1};
  const char *text;
  size_t length;
  if (attribute(tag, "Name", &text, &length))
    copy_name(text, length, array.name);
  array.place = array_place(r, array.name);
  if (array.place == THRUM_CELLS_OTHER)
    return THRUM_OK;
  thrum_cells_type type = {0};
  if (attribute(tag, "type", &text, &length))
    type = thrum_cells_type_of(text, length);
  if (type.size == 0)
    // such as String, which no part of a mesh is
    return array.place == THRUM_CELLS_POINT_DATA || array.place == THRUM_CELLS_CELL_DATA
               ? THRUM_OK
               : fail(r, THRUM_UNSUPPORTED, "an array of the grid has a type that is not read");
  array.whole = type.whole;
  thrum_status status = attribute_integer(r, tag, "NumberOfComponents", 1000000, &array.columns);
  if (status >= 0)
    status = array_values(r, tag, type, &array);
  if (status < 0) {
    free(array.values);
    return status;
  }
  return thrum_cells_take(&r->cells, &array, r->error);
}

static thrum_status read_piece(vtu_reader *r, const vtu_tag *tag) {
  if (r->has_piece)
    return fail(r, THRUM_UNSUPPORTED,
                "there are several pieces; save the grid as one (ParaView: Merge Blocks)");
  r->has_piece = true;
  thrum_status status =
      attribute_integer(r, tag, "NumberOfPoints", INT32_MAX, &r->cells.point_count);
  if (status >= 0)
    status = attribute_integer(r, tag, "NumberOfCells", INT64_MAX / 64, &r->cells.cell_count);
  return status;
}

static thrum_status read_file_tag(vtu_reader *r, const vtu_tag *tag) {
  if (!attribute_is(tag, "type", "UnstructuredGrid"))
    return fail(r, THRUM_UNSUPPORTED, "is no UnstructuredGrid, so it has no tetrahedra to read");
  const char *text;
  size_t length;
  if (attribute(tag, "compressor", &text, &length) && length > 0)
    return fail(r, THRUM_UNSUPPORTED,
                "is compressed, which is not read; save it with Compressor Type None");
  r->little = !attribute_is(tag, "byte_order", "BigEndian");
  r->header_size = attribute_is(tag, "header_type", "UInt64") ? 8 : 4;
  return THRUM_OK;
}

/* What stands behind the grid ends the XML: the bytes of appended arrays. */
static thrum_status find_appended(vtu_reader *r, const char *start) {
  const char *open = find(start, r->stop, "<AppendedData");
  if (!open)
    return THRUM_OK;
  vtu_reader at = *r;
  vtu_tag tag;
  at.at = open;
  if (!next_tag(&at, &tag))
    return fail(r, THRUM_BAD_FORMAT, "the appended data is cut short");
  r->appended_base64 = !attribute_is(&tag, "encoding", "raw");
  const char *mark = memchr(at.at, '_', (size_t)(r->stop - at.at));
  if (!mark)
    return fail(r, THRUM_BAD_FORMAT, "the appended data has no '_' to count from");
  r->appended = mark + 1;
  return THRUM_OK;
}

/* Which arrays follow an element of the grid. */
static thrum_cells_place place_of(const vtu_tag *tag, thrum_cells_place before) {
  static const struct {
    const char *name;
    thrum_cells_place place;
  } places[] = {{"Points", THRUM_CELLS_POINTS},
                {"Cells", THRUM_CELLS_CONNECTIVITY},
                {"PointData", THRUM_CELLS_POINT_DATA},
                {"CellData", THRUM_CELLS_CELL_DATA},
                {"FieldData", THRUM_CELLS_OTHER}};
  for (size_t i = 0; i < sizeof places / sizeof *places; i++)
    if (tag_is(tag, places[i].name))
      return tag->closing ? THRUM_CELLS_OTHER : places[i].place;
  return before;
}

static thrum_status read_all(vtu_reader *r) {
  vtu_tag tag;
  thrum_status status = THRUM_OK;
  bool is_vtk = false;
  while (status >= 0 && next_tag(r, &tag)) {
    r->place = place_of(&tag, r->place);
    if (tag_is(&tag, "AppendedData"))
      break;
    if (tag.closing)
      continue;
    if (tag_is(&tag, "VTKFile")) {
      is_vtk = true;
      status = read_file_tag(r, &tag);
      if (status >= 0)
        status = find_appended(r, r->at);
    } else if (tag_is(&tag, "Piece")) {
      status = read_piece(r, &tag);
    } else if (tag_is(&tag, "DataArray") && is_vtk) {
      status = read_array(r, &tag);
    }
  }
  if (status >= 0 && !is_vtk)
    status = fail(r, THRUM_BAD_FORMAT, "there is no <VTKFile>; is it a VTK XML file?");
  return status;
}

thrum_status thrum_mesh_parse_vtu(const char *name, const void *data, size_t size, thrum_mesh *mesh,
                                  thrum_error *error) {
  const char *first = size > 0 ? data : "";
  vtu_reader r = {.name = name,
                  .at = first,
                  .stop = first + size,
                  .header_size = 4,
                  .place = THRUM_CELLS_OTHER,
                  .error = error};
  thrum_status status = read_all(&r);
  if (status >= 0)
    status = thrum_cells_mesh(&r.cells, name, mesh, error);
  thrum_cells_free(&r.cells);
  return status;
}
