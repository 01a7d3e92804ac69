/* Reads VTK legacy files (.vtk) with an UNSTRUCTURED_GRID, ASCII or binary (big-endian), of
 * versions 1 to 4 (CELLS: each cell after its length) and 5 (CELLS: OFFSETS and CONNECTIVITY).
 * Attributes of all kinds are read, to get past them: SCALARS, COLOR_SCALARS, LOOKUP_TABLE,
 * VECTORS, NORMALS, TEXTURE_COORDINATES, TENSORS, TENSORS6, GLOBAL_IDS, PEDIGREE_IDS, EDGE_FLAGS,
 * FIELD, METADATA. Format:
 * https://docs.vtk.org/en/latest/vtk_file_formats/vtk_legacy_file_format.html Cost: linear in the
 * file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/vtk_cells.h"
#include "mesh/mesh_groups.h"
#include "platform/allocate.h"

typedef struct vtk_reader {
  thrum_text text;
  bool binary;
  bool new_cells;          /* version 5: OFFSETS and CONNECTIVITY */
  thrum_cells_place place; /* of the attributes being read */
  int64_t tuples;          /* of the attributes being read */
  thrum_cells cells;
} vtk_reader;

static thrum_status integer(vtk_reader *r, const char *what, int64_t *value) {
  return thrum_text_integer(&r->text, what, 0, INT64_MAX / 64, value);
}

/* Takes bytes that follow the present line. */
static const unsigned char *take_bytes(vtk_reader *r, int64_t count, int size) {
  if (count > (r->text.stop - r->text.next) / size)
    return NULL;
  const unsigned char *bytes = (const unsigned char *)r->text.next;
  r->text.next += count * size;
  // the present line is over
  r->text.at = r->text.end;
  return bytes;
}

static thrum_status ascii_values(vtk_reader *r, bool whole, int64_t count, double *values) {
  for (int64_t i = 0; i < count; i++) {
    thrum_word word = {"", 0};
    THRUM_TRY(thrum_text_need_word(&r->text, "the last number of an array"));
    thrum_text_word(&r->text, &word);
    const size_t used = thrum_text_scan_fortran(word.text, word.text + word.length, &values[i]);
    if (used != word.length || (whole && values[i] != floor(values[i])))
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected a %snumber, found '%s'",
                             whole ? "whole " : "", thrum_text_excerpt(word).text);
  }

  // what is left of the line would be passed over with it
  return thrum_text_finish(&r->text, "the numbers of an array");
}

/* Reads `count` numbers of one bit, eight a byte, the first one the highest. */
static thrum_status read_bits(vtk_reader *r, int64_t count, double **values) {
  const unsigned char *bytes = take_bytes(r, count / 8 + (count % 8 > 0), 1);
  if (!bytes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "an array is longer than the file; is it cut short?");
  THRUM_TRY(thrum_reserve(values, count + 1, sizeof **values, "an array", r->text.error));
  for (int64_t i = 0; i < count; i++)
    (*values)[i] = bytes[i / 8] >> (7 - i % 8) & 1;
  return THRUM_OK;
}

/* Reads `count` numbers of a type, which begin behind the present line. */
static thrum_status read_values(vtk_reader *r, thrum_cells_type type, int64_t count,
                                double **values) {
  // an array that the rest of the file cannot hold must not be allocated
  const int64_t left = r->text.stop - r->text.next;
  const bool bits = type.size == THRUM_CELLS_BITS;
  if (bits && r->binary)
    return read_bits(r, count, values);
  if (count > (r->binary ? left / type.size : left / 2 + 1))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "an array is longer than the file; is it cut short?");

  double *read = NULL;
  THRUM_TRY(thrum_reserve(&read, count + 1, sizeof *read, "an array", r->text.error));

  // binary numbers begin behind the line, and text may use any line breaks
  thrum_status status = THRUM_OK;
  if (r->binary) {
    const unsigned char *bytes = take_bytes(r, count, type.size);
    for (int64_t i = 0; bytes && i < count; i++)
      read[i] = thrum_cells_number(type, bytes + i * type.size, false);
  } else {
    r->text.at = r->text.end;
    status = ascii_values(r, type.whole, count, read);
  }

  if (status < 0)
    free(read);
  else
    *values = read;
  return status;
}

static int hex_digit(char c) {
  return c >= '0' && c <= '9'   ? c - '0'
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
                                : -1;
}

/* Decodes a name, in which VTK writes characters that would break a word as %XX; long names are
 * cut. */
static void copy_name(thrum_word from, char name[THRUM_MESH_NAME_MAX + 1]) {
  const char *word = from.text;
  size_t used = 0;
  for (size_t i = 0; i < from.length && used < THRUM_MESH_NAME_MAX; i++) {
    const bool code = word[i] == '%' && from.length - i > 2 && hex_digit(word[i + 1]) >= 0 &&
                      hex_digit(word[i + 2]) >= 0;
    name[used++] = code ? (char)(16 * hex_digit(word[i + 1]) + hex_digit(word[i + 2])) : word[i];
    i += code ? 2 : 0;
  }
  name[used] = '\0';
}

/* Reads numbers and keeps them as an array of the grid. */
static thrum_status take_array(vtk_reader *r, thrum_cells_place place, thrum_word name,
                               thrum_cells_type type, int64_t columns, int64_t count) {
  thrum_cells_array array = {.place = place, .columns = columns, .count = count};
  array.whole = type.whole;
  copy_name(name, array.name);
  THRUM_TRY(read_values(r, type, count, &array.values));
  return thrum_cells_take(&r->cells, &array, r->text.error);
}

/* The same of an attribute, which has a row for each point or cell. */
static thrum_status take_tuples(vtk_reader *r, thrum_word name, thrum_cells_type type,
                                int64_t columns) {
  // the product of tuples and columns must not overflow
  if (r->tuples > INT64_MAX / 64 / columns)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "an array is longer than the file; is it cut short?");
  return take_array(r, r->place, name, type, columns, columns * r->tuples);
}

static thrum_status read_type(vtk_reader *r, thrum_cells_type *type) {
  thrum_word word = {"", 0};
  thrum_text_word(&r->text, &word);
  *type = thrum_cells_type_of(word);
  if (thrum_text_equals(word, "bit"))
    *type = (thrum_cells_type){THRUM_CELLS_BITS, true, false};
  if (type->size == 0)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "numbers of type '%s' are not read; save the file without this array",
                           thrum_text_excerpt(word).text);
  return THRUM_OK;
}

static thrum_status read_points(vtk_reader *r) {
  thrum_cells_type type;
  THRUM_TRY(integer(r, "the number of points", &r->cells.point_count));
  if (r->cells.point_count > INT32_MAX)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, "more than 2^31 - 1 points");
  THRUM_TRY(read_type(r, &type));
  return take_array(r, THRUM_CELLS_POINTS, thrum_word_of(""), type, 3, 3 * r->cells.point_count);
}

/* Reads `length point point ...` of each cell into the connectivity and the ends of the cells. */
static thrum_status read_old_cells(vtk_reader *r, int64_t count, int64_t size) {
  static const thrum_cells_type index = {4, true, true};
  double *list = NULL, *ends = NULL;

  // each cell has at least its length, so a smaller size is damage
  if (size < count)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "CELLS has a size below its count");
  THRUM_TRY(read_values(r, index, size, &list));
  thrum_status status = thrum_reserve(&ends, count, sizeof *ends, "an array", r->text.error);

  // in place, the length of each cell becomes its end, as VTK's newer format has it
  int64_t at = 0, kept = 0;
  for (int64_t c = 0; c < count && status >= 0; c++) {
    if (at >= size || !(list[at] >= 0 && list[at] <= (double)(size - at - 1))) {
      status = thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                               "CELLS has a cell that goes beyond the size given");
      break;
    }
    const int64_t length = (int64_t)list[at++];
    memmove(list + kept, list + at, (size_t)length * sizeof *list);
    at += length;
    kept += length;
    ends[c] = (double)kept;
  }
  if (status >= 0 && at < size)
    status = thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                             "CELLS has %lld numbers more than its cells", (long long)(size - at));

  // the grid takes the arrays over, also when it fails
  const thrum_cells_array arrays[] = {
      {.place = THRUM_CELLS_CONNECTIVITY, .whole = true, .count = kept, .values = list},
      {.place = THRUM_CELLS_OFFSETS, .whole = true, .count = count, .values = ends}};
  for (int i = 0; i < 2; i++)
    if (status >= 0)
      status = thrum_cells_take(&r->cells, &arrays[i], r->text.error);
    else
      free(arrays[i].values);
  return status;
}

/* Reads the cells of version 5, where the count is that of the offsets, one more than the cells. */
static thrum_status read_new_cells(vtk_reader *r, int64_t offsets, int64_t size) {
  static const char *const names[] = {"OFFSETS", "CONNECTIVITY"};
  for (int i = 0; i < 2; i++) {
    thrum_word word = {"", 0};
    thrum_cells_type type;
    THRUM_TRY(thrum_text_need_line(&r->text, names[i]));

    // the order of the two arrays is fixed
    thrum_text_word(&r->text, &word);
    if (!thrum_text_equals(word, names[i]))
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected %s, found '%s'", names[i],
                             thrum_text_excerpt(word).text);

    THRUM_TRY(read_type(r, &type));
    THRUM_TRY(take_array(r, i == 0 ? THRUM_CELLS_OFFSETS : THRUM_CELLS_CONNECTIVITY,
                         thrum_word_of(""), type, 1, i == 0 ? offsets : size));
  }

  // offsets are beginnings and begin with 0, but the grid wants the ends alone
  thrum_cells_array *ends = &r->cells.arrays[r->cells.array_count - 2];
  if (ends->count > 0) {
    if (ends->values[0] != 0)
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "OFFSETS must begin with 0");
    ends->count--;
    memmove(ends->values, ends->values + 1, (size_t)ends->count * sizeof *ends->values);
  }
  return THRUM_OK;
}

static thrum_status read_cells(vtk_reader *r) {
  int64_t count = 0, size = 0;
  THRUM_TRY(integer(r, "the number of cells", &count));
  THRUM_TRY(integer(r, "the size of the cells", &size));
  return r->new_cells ? read_new_cells(r, count, size) : read_old_cells(r, count, size);
}

static thrum_status read_cell_types(vtk_reader *r) {
  static const thrum_cells_type index = {4, true, true};
  THRUM_TRY(integer(r, "the number of cells", &r->cells.cell_count));
  return take_array(r, THRUM_CELLS_TYPES, thrum_word_of(""), index, 1, r->cells.cell_count);
}

/* Reads `SCALARS name type [columns]`, which `LOOKUP_TABLE name` may follow. */
static thrum_status read_scalars(vtk_reader *r) {
  thrum_word name = {"", 0}, word;
  int64_t columns = 1;
  thrum_cells_type type;
  thrum_text_word(&r->text, &name);
  THRUM_TRY(read_type(r, &type));
  if (thrum_text_more(&r->text))
    THRUM_TRY(thrum_text_integer(&r->text, "the number of columns", 1, 9, &columns));

  // the lookup table is optional, so another line is put back
  const thrum_text before = r->text;
  if (!thrum_text_next_line(&r->text) || !thrum_text_word(&r->text, &word) ||
      !thrum_text_equals(word, "LOOKUP_TABLE"))
    r->text = before;

  return take_tuples(r, name, type, columns);
}

/* Passes over METADATA, which ends with an empty line. */
static thrum_status skip_metadata(vtk_reader *r) {
  thrum_text *text = &r->text;
  while (text->next < text->stop) {
    const char *end = memchr(text->next, '\n', (size_t)(text->stop - text->next));
    const bool empty = text->next == end || (*text->next == '\r' && text->next + 1 == end);
    text->next = end ? end + 1 : text->stop;
    text->line++;
    if (empty)
      break;
  }
  text->at = text->end;
  return THRUM_OK;
}

/* Reads `LOOKUP_TABLE name size`: colours of four numbers, which are bytes or from 0 to 1. */
static thrum_status read_lookup_table(vtk_reader *r) {
  static const thrum_cells_type byte = {1, false, false};
  thrum_word name = {"", 0};
  int64_t size = 0;
  thrum_text_word(&r->text, &name);
  THRUM_TRY(integer(r, "the size of the table", &size));
  return take_array(r, THRUM_CELLS_OTHER, name, byte, 4, 4 * size);
}

/* Reads `COLOR_SCALARS name columns`, whose numbers are bytes or from 0 to 1. */
static thrum_status read_colors(vtk_reader *r) {
  static const thrum_cells_type byte = {1, false, false};
  thrum_word name = {"", 0};
  int64_t columns = 1;
  thrum_text_word(&r->text, &name);
  THRUM_TRY(thrum_text_integer(&r->text, "the number of columns", 1, 4, &columns));

  // a colour is no region, whatever its name
  const thrum_cells_place place = r->place;
  r->place = THRUM_CELLS_OTHER;
  const thrum_status status = take_tuples(r, name, byte, columns);
  r->place = place;
  return status;
}

/* Reads `TEXTURE_COORDINATES name columns type`. */
static thrum_status read_texture(vtk_reader *r) {
  thrum_word name = {"", 0};
  int64_t columns = 1;
  thrum_cells_type type;
  thrum_text_word(&r->text, &name);
  THRUM_TRY(thrum_text_integer(&r->text, "the number of columns", 1, 3, &columns));
  THRUM_TRY(read_type(r, &type));
  return take_tuples(r, name, type, columns);
}

/* Reads `FIELD name count` and its arrays `name columns tuples type`. */
static thrum_status read_field(vtk_reader *r) {
  thrum_word name = {"", 0};
  int64_t count = 0;
  thrum_text_word(&r->text, &name);

  THRUM_TRY(integer(r, "the number of arrays", &count));
  for (int64_t i = 0; i < count; i++) {
    // metadata may stand between the arrays
    int64_t columns = 0, tuples = 0;
    thrum_cells_type type;
    for (;;) {
      THRUM_TRY(thrum_text_need_line(&r->text, "the last array"));
      thrum_text_word(&r->text, &name);
      if (!thrum_text_equals(name, "METADATA"))
        break;
      THRUM_TRY(skip_metadata(r));
    }

    // attributes that are no group or region are read too, to get past them
    THRUM_TRY(thrum_text_integer(&r->text, "the number of columns", 0, 1000000, &columns));
    THRUM_TRY(thrum_text_integer(&r->text, "the number of tuples", 0, INT32_MAX, &tuples));
    THRUM_TRY(read_type(r, &type));
    if (r->place != THRUM_CELLS_OTHER && tuples > 0 && tuples != r->tuples)
      return thrum_text_fail(
          &r->text, THRUM_BAD_SHAPE, "array '%s' has %lld rows where the section says %lld",
          thrum_text_excerpt(name).text, (long long)tuples, (long long)r->tuples);
    THRUM_TRY(take_array(r, r->place, name, type, columns, columns * tuples));
  }
  return THRUM_OK;
}

/* Reads VECTORS, NORMALS and the like: `name type` and a fixed number of columns. */
static thrum_status read_vectors(vtk_reader *r, int64_t columns) {
  thrum_word name = {"", 0};
  thrum_cells_type type;
  thrum_text_word(&r->text, &name);
  THRUM_TRY(read_type(r, &type));
  return take_tuples(r, name, type, columns);
}

static thrum_status read_threes(vtk_reader *r) {
  return read_vectors(r, 3);
}

static thrum_status read_tensors(vtk_reader *r) {
  return read_vectors(r, 9);
}

static thrum_status read_sixes(vtk_reader *r) {
  return read_vectors(r, 6);
}

/* Reads ids and flags, which are no regions. */
static thrum_status read_numbers(vtk_reader *r) {
  const thrum_cells_place place = r->place;
  r->place = THRUM_CELLS_OTHER;
  const thrum_status status = read_vectors(r, 1);
  r->place = place;
  return status;
}

/* Reads how many rows the attributes below have: one for each point or cell. */
static thrum_status read_tuples(vtk_reader *r, const char *keyword, int64_t items,
                                const char *what) {
  THRUM_TRY(integer(r, "the number of tuples", &r->tuples));
  return r->tuples == items || items == 0
             ? THRUM_OK
             : thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                               "%s has %lld rows, but there are %lld %s", keyword,
                               (long long)r->tuples, (long long)items, what);
}

/* Reads the head of the data on points or cells, where groups and regions may be found. */
static thrum_status read_point_data(vtk_reader *r) {
  r->place = THRUM_CELLS_POINT_DATA;
  return read_tuples(r, "POINT_DATA", r->cells.point_count, "points");
}

static thrum_status read_cell_data(vtk_reader *r) {
  r->place = THRUM_CELLS_CELL_DATA;
  return read_tuples(r, "CELL_DATA", r->cells.cell_count, "cells");
}

static thrum_status read_section(vtk_reader *r) {
  static const struct {
    const char *keyword;
    thrum_status (*read)(vtk_reader *r);
  } sections[] = {{"POINTS", read_points},
                  {"CELLS", read_cells},
                  {"CELL_TYPES", read_cell_types},
                  {"POINT_DATA", read_point_data},
                  {"CELL_DATA", read_cell_data},
                  {"FIELD", read_field},
                  {"SCALARS", read_scalars},
                  {"COLOR_SCALARS", read_colors},
                  {"LOOKUP_TABLE", read_lookup_table},
                  {"VECTORS", read_threes},
                  {"NORMALS", read_threes},
                  {"TEXTURE_COORDINATES", read_texture},
                  {"TENSORS", read_tensors},
                  {"TENSORS6", read_sixes},
                  {"GLOBAL_IDS", read_numbers},
                  {"PEDIGREE_IDS", read_numbers},
                  {"EDGE_FLAGS", read_numbers},
                  {"METADATA", skip_metadata}};

  // the grid itself, and the data on its points and cells
  thrum_word word = {"", 0};
  thrum_text_word(&r->text, &word);
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (thrum_text_equals(word, sections[i].keyword))
      return sections[i].read(r);

  return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                         "expected a section such as POINTS or CELLS, found '%s'",
                         thrum_text_excerpt(word).text);
}

/* Reads the first four lines: the version, a title, ASCII or BINARY, the kind of the data set. */
static thrum_status read_header(vtk_reader *r) {
  static const char start[] = "# vtk DataFile Version ";
  THRUM_TRY(thrum_text_need_line(&r->text, "the version"));

  // the first line is fixed, except for the version
  const size_t length = (size_t)(r->text.end - r->text.start);
  if (length < sizeof start || memcmp(r->text.start, start, sizeof start - 1) != 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "expected '# vtk DataFile Version'; is it a VTK legacy file?");

  // the cells are written in another way from version 5 on
  r->new_cells = length > sizeof start && r->text.start[sizeof start - 1] >= '5' &&
                 r->text.start[sizeof start] == '.';

  // an empty title is a blank line, which the scanner skips
  for (int i = 0; i < 2; i++) {
    THRUM_TRY(thrum_text_need_line(&r->text, "ASCII or BINARY"));
    r->binary = thrum_text_equals(thrum_text_line(&r->text), "BINARY");
    if (r->binary || thrum_text_equals(thrum_text_line(&r->text), "ASCII"))
      break;
    if (i == 1)
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected ASCII or BINARY");
  }

  THRUM_TRY(thrum_text_need_line(&r->text, "DATASET"));

  // other kinds of data sets have no tetrahedra
  thrum_word word = {"", 0}, kind = {"", 0};
  thrum_text_word(&r->text, &word);
  thrum_text_word(&r->text, &kind);
  if (!thrum_text_equals(word, "DATASET") || !thrum_text_equals(kind, "UNSTRUCTURED_GRID"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "expected DATASET UNSTRUCTURED_GRID, found '%s'; save the body as an "
                           "unstructured grid",
                           thrum_text_excerpt(thrum_text_line(&r->text)).text);
  return THRUM_OK;
}

thrum_status thrum_mesh_parse_vtk(const thrum_mesh_source *source, thrum_mesh *mesh,
                                  thrum_error *error) {
  vtk_reader r = {.place = THRUM_CELLS_OTHER};
  thrum_status status =
      thrum_text_view(source->name, source->data, source->size, 0, 0, &r.text, error);
  THRUM_THEN(status, read_header(&r));
  while (status >= 0 && thrum_text_next_line(&r.text))
    status = read_section(&r);
  THRUM_THEN(status, thrum_cells_mesh(&r.cells, source, mesh, error));
  thrum_cells_free(&r.cells);
  return status;
}
