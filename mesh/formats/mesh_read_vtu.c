/* Reads VTK XML files (.vtu) with one UnstructuredGrid of one piece, versions to 2: arrays in
 * ASCII, in base64 inline, or appended raw or in base64, of either byte order, headers UInt32 or
 * UInt64, as they are or compressed by zlib. An array of bytes is its length and then its bytes; a
 * compressed one is the number of its blocks, the size of a block and of a shorter last one before
 * compression, the size of each after it, and then the blocks. The XML is read by expat up to
 * <AppendedData>, behind which the bytes of raw arrays are no XML. A word that the format does not
 * have, an array of another length than its points or cells, and a fraction in whole numbers are
 * refused.
 *
 * Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
 *
 * Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <expat.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/vtk_cells.h"
#include "mesh/mesh_groups.h"
#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

enum { PIECE_OF_FILE = 1 << 24 /* bytes that expat gets at once; its lengths are ints */ };
enum { PER_BYTE = 8 /* points or cells of a compressed file for each of its bytes, at most */ };

/* An array of the grid whose numbers are still to be read. */
typedef struct vtu_array {
  thrum_cells_array array;
  thrum_cells_type type;
  int64_t line; /* of its element */
  bool base64;
  bool bits; /* eight numbers a byte, unless they are words */
  bool appended;
  int64_t offset; /* in the appended bytes */
} vtu_array;

typedef struct vtu_reader {
  const char *name;
  const char *first, *stop; /* the whole file */
  XML_Parser parser;
  thrum_status status; /* of the first failure in a handler */
  bool has_file, has_piece, big, compressed;
  int header_size; /* 4 or 8 bytes of length in front of bytes */
  thrum_cells_place place;
  vtu_array open; /* the array whose element is open */
  int64_t nested; /* elements inside it that are open; without any, its text goes to `text` */
  char *text;
  int64_t text_size;
  vtu_array *waiting; /* appended arrays, in the order of their elements */
  int64_t waiting_count;
  const char *appended; /* first byte behind the '_'; NULL: none */
  bool appended_base64;
  thrum_cells cells;
  thrum_error *error;
} vtu_reader;

static thrum_status fail_at(vtu_reader *r, int64_t line, thrum_status status, const char *message) {
  return thrum_error_set(r->error, status, "%.200s:%lld: %s", r->name, (long long)line, message);
}

static int64_t line_now(const vtu_reader *r) {
  return (int64_t)XML_GetCurrentLineNumber(r->parser);
}

static thrum_status fail(vtu_reader *r, thrum_status status, const char *message) {
  return fail_at(r, line_now(r), status, message);
}

static bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r';
}

/* Returns the value of an attribute, or NULL when it is not there. Expat gives names and values in
 * turn. */
static const char *attribute(const char **attributes, const char *key) {
  for (; *attributes; attributes += 2)
    if (strcmp(attributes[0], key) == 0)
      return attributes[1];
  return NULL;
}

static bool attribute_is(const char **attributes, const char *key, const char *wanted) {
  const char *value = attribute(attributes, key);
  return value && thrum_text_equals(thrum_word_of(value), wanted);
}

/* Tells in *second which of two words an attribute is; it is unchanged when the attribute is not
 * there, and any other word is refused. */
static thrum_status attribute_choice(vtu_reader *r, const char **attributes, const char *key,
                                     const char *first_word, const char *second_word,
                                     bool *second) {
  const char *value = attribute(attributes, key);
  const bool is_second = attribute_is(attributes, key, second_word);
  if (value && !is_second && !attribute_is(attributes, key, first_word))
    return thrum_error_set(r->error, THRUM_UNSUPPORTED,
                           "%.200s:%lld: %s is '%s'; expected %s or %s", r->name,
                           (long long)line_now(r), key,
                           thrum_text_excerpt(thrum_word_of(value)).text, first_word, second_word);
  *second = value ? is_second : *second;
  return THRUM_OK;
}

/* Reads an attribute as a whole number; *number is unchanged when it is not there. */
static thrum_status attribute_integer(vtu_reader *r, const char **attributes, const char *key,
                                      int64_t high, int64_t *number) {
  const char *value = attribute(attributes, key);
  int64_t read = 0;
  if (!value)
    return THRUM_OK;

  const size_t length = strlen(value);
  if (length == 0 || thrum_text_scan_integer(value, value + length, &read) != length || read < 0 ||
      read > high)
    return thrum_error_set(r->error, THRUM_BAD_VALUE,
                           "%.200s:%lld: %s is '%s'; expected a whole number from 0 to %lld",
                           r->name, (long long)line_now(r), key,
                           thrum_text_excerpt(thrum_word_of(value)).text, (long long)high);
  *number = read;
  return THRUM_OK;
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

/* Decodes at most `wanted` bytes and returns how many there were. Padding may stand inside, since
 * the length may be encoded alone. */
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

    // white space may stand anywhere, but any other character ends the text
    if (value < 0) {
      if (is_space(*at))
        continue;
      break;
    }

    // four characters of six bits each make three bytes
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
    return (uint64_t)thrum_cells_number(type, bytes, !r->big);
  uint64_t value = 0;
  for (int i = 0; i < 8; i++)
    value = value << 8 | bytes[!r->big ? 7 - i : i];
  return value;
}

static thrum_status array_cut_short(vtu_reader *r, const vtu_array *a) {
  return fail_at(r, a->line, THRUM_BAD_FORMAT,
                 "an array is longer than the file; is it cut short?");
}

/* Finds the first `count` bytes in [at, stop), which are raw or in base64. The caller frees *owned,
 * which is NULL or from an earlier call. */
static thrum_status take_bytes(vtu_reader *r, const vtu_array *a, const char *at, const char *stop,
                               uint64_t count, const unsigned char **bytes, unsigned char **owned) {
  // bytes are never more than their text, so that nothing is allocated for a length that cannot be
  if (count > (uint64_t)(stop - at))
    return array_cut_short(r, a);
  *bytes = (const unsigned char *)at;
  if (!a->base64)
    return THRUM_OK;

  free(*owned);
  THRUM_TRY(thrum_reserve(owned, (int64_t)count, 1, "an array", r->error));
  *bytes = *owned;
  return decode_base64(at, stop, *owned, (size_t)count) == count ? THRUM_OK : array_cut_short(r, a);
}

/* No byte of zlib's becomes more than this. */
enum { ZLIB_RATIO = 1032 };

/* Corners of a solid, at most; times that lines and planes go through a point; and columns of data,
 * those of a tensor. */
enum { SOLID_CORNERS = 216, POINT_CELLS = 16, DATA_COLUMNS = 9 };

/* Bytes that the points and cells of the grid can need in an array. */
static double bytes_needed(const vtu_reader *r, const vtu_array *a) {
  const double points = (double)r->cells.point_count, cells = (double)r->cells.cell_count;
  const double size = a->type.size;
  switch (a->array.place) {
  case THRUM_CELLS_POINTS:
    return size * 3 * points;
  case THRUM_CELLS_CONNECTIVITY:
    return size * (SOLID_CORNERS * cells + POINT_CELLS * points);
  case THRUM_CELLS_POINT_DATA:
    return size * DATA_COLUMNS * points;
  case THRUM_CELLS_CELL_DATA:
    return size * DATA_COLUMNS * cells;
  default:
    return size * cells;
  }
}

/* Blows up the blocks behind the header of a compressed array; the caller frees *owned. */
static thrum_status inflate_blocks(vtu_reader *r, const vtu_array *a, const unsigned char *header,
                                   uint64_t blocks, const unsigned char *packed, uint64_t left,
                                   uint64_t *count, unsigned char **owned) {
  const size_t word = (size_t)r->header_size;
  const uint64_t whole = header_value(r, header + word), last = header_value(r, header + 2 * word);
  const uint64_t most = ZLIB_RATIO * left, end = last > 0 ? last : whole;

  // a short array may be less than one block
  if (end > most || last > whole || (blocks > 1 && whole > most / (blocks - 1)))
    return fail_at(r, a->line, THRUM_BAD_FORMAT, "a compressed array has impossible sizes");
  *count = (blocks - 1) * whole + end;

  // what is too long is refused before it is blown up
  if ((double)*count > bytes_needed(r, a))
    return thrum_error_set(r->error, THRUM_BAD_FORMAT,
                           "%.200s:%lld: array '%s' has %llu bytes, more than %lld points and %lld "
                           "cells need",
                           r->name, (long long)a->line,
                           thrum_text_excerpt(thrum_word_of(a->array.name)).text,
                           (unsigned long long)*count, (long long)r->cells.point_count,
                           (long long)r->cells.cell_count);
  THRUM_TRY(thrum_reserve(owned, (int64_t)*count, 1, "an array", r->error));

  // each block must become as long as the header says
  uint64_t done = 0;
  for (uint64_t n = 0; n < blocks; n++) {
    const uint64_t size = header_value(r, header + (3 + n) * word);
    const uint64_t expected = n + 1 < blocks ? whole : end;
    uLongf length = (uLongf)expected;
    if (size > left || uncompress(*owned + done, &length, packed, (uLong)size) != Z_OK ||
        length != expected)
      return fail_at(r, a->line, THRUM_BAD_FORMAT, "a compressed array is damaged");
    packed += size;
    left -= size;
    done += expected;
  }
  return THRUM_OK;
}

/* Finds the bytes of a compressed array; the caller frees *owned. */
static thrum_status find_compressed(vtu_reader *r, const vtu_array *a, const char *at,
                                    const char *stop, const unsigned char **bytes, uint64_t *count,
                                    unsigned char **owned) {
  const uint64_t word = (uint64_t)r->header_size, left = (uint64_t)(stop - at);
  unsigned char *packed = NULL;
  const unsigned char *header = NULL;
  uint64_t sum = 0;

  // the number of blocks alone, then the header with the size of each, then all of it
  thrum_status status = take_bytes(r, a, at, stop, word, &header, &packed);
  const uint64_t blocks = status >= 0 ? header_value(r, header) : 0;
  if (status >= 0 && blocks == 0) {
    *count = 0;
    free(packed);
    return THRUM_OK;
  }
  if (status >= 0 && blocks > left / word)
    status = array_cut_short(r, a);
  THRUM_THEN(status, take_bytes(r, a, at, stop, (3 + blocks) * word, &header, &packed));
  for (uint64_t n = 0; n < blocks && status >= 0; n++) {
    const uint64_t size = header_value(r, header + (3 + n) * word);
    sum += size;
    if (size > left || sum > left)
      status = array_cut_short(r, a);
  }
  const uint64_t begin = (3 + blocks) * word;
  THRUM_THEN(status, take_bytes(r, a, at, stop, begin + sum, &header, &packed));
  THRUM_THEN(status, inflate_blocks(r, a, header, blocks, header + begin, sum, count, owned));
  free(packed);
  *bytes = *owned;
  return status;
}

/* Finds the bytes of an array in [at, stop), behind their length. The caller frees *owned. */
static thrum_status find_bytes(vtu_reader *r, const vtu_array *a, const char *at, const char *stop,
                               const unsigned char **bytes, uint64_t *count,
                               unsigned char **owned) {
  const uint64_t word = (uint64_t)r->header_size;
  if (r->compressed)
    return find_compressed(r, a, at, stop, bytes, count, owned);

  // the length alone comes first
  THRUM_TRY(take_bytes(r, a, at, stop, word, bytes, owned));
  *count = header_value(r, *bytes);
  if (*count > (uint64_t)(stop - at))
    return array_cut_short(r, a);
  THRUM_TRY(take_bytes(r, a, at, stop, word + *count, bytes, owned));
  *bytes += word;
  return THRUM_OK;
}

/* Numbers that an array of data has. */
static int64_t numbers_expected(const vtu_reader *r, const vtu_array *a) {
  return a->array.columns *
         (a->array.place == THRUM_CELLS_POINT_DATA ? r->cells.point_count : r->cells.cell_count);
}

static thrum_status read_bytes(vtu_reader *r, vtu_array *a, const char *at, const char *stop) {
  const unsigned char *bytes = NULL;
  unsigned char *owned = NULL;
  uint64_t size = 0;
  thrum_status status = find_bytes(r, a, at, stop, &bytes, &size, &owned);
  if (status >= 0 && size % (uint64_t)a->type.size != 0)
    status = fail_at(r, a->line, THRUM_BAD_FORMAT, "an array ends within a number");
  a->array.count = (int64_t)(size / (uint64_t)a->type.size);

  // the last byte of bits is filled up, so that the points or cells tell how many there are
  const int64_t bits = a->bits ? numbers_expected(r, a) : 0;
  if (a->bits && a->array.count == (bits + 7) / 8)
    a->array.count = bits;
  THRUM_THEN(status,
             thrum_reserve(&a->array.values, a->array.count, sizeof(double), "an array", r->error));

  // all types become double, which holds every index exactly
  for (int64_t i = 0; i < a->array.count && status >= 0; i++)
    a->array.values[i] = a->bits ? (bytes[i / 8] >> (7 - i % 8) & 1)
                                 : thrum_cells_number(a->type, bytes + i * a->type.size, !r->big);
  free(owned);
  return status;
}

static thrum_status read_numbers(vtu_reader *r, vtu_array *a, const char *at, const char *stop) {
  int64_t line = a->line;
  for (const char *p = at; p < stop;) {
    if (is_space(*p)) {
      line += *p++ == '\n';
      continue;
    }

    // memory follows the numbers that are there, not the count that the file claims
    THRUM_TRY(thrum_mesh_grow(&a->array.values, a->array.count, 1, sizeof(double), r->error));

    // a word must be a number up to its end, so that damage is not read as two numbers
    const char *end = p;
    while (end < stop && !is_space(*end))
      end++;
    const size_t used = thrum_text_scan_number(p, end, &a->array.values[a->array.count]);
    const double value = a->array.values[a->array.count];
    if (used == 0 || p + used != end || (a->type.whole && value != floor(value)))
      return thrum_error_set(r->error, THRUM_BAD_FORMAT,
                             "%.200s:%lld: array '%s': expected a %snumber, found '%s'", r->name,
                             (long long)line, thrum_text_excerpt(thrum_word_of(a->array.name)).text,
                             a->type.whole ? "whole " : "",
                             thrum_text_excerpt((thrum_word){p, (size_t)(end - p)}).text);
    a->array.count++;
    p = end;
  }
  return THRUM_OK;
}

/* Checks that data has its numbers for each point or cell. */
static thrum_status check_length(vtu_reader *r, const vtu_array *a) {
  const bool of_points = a->array.place == THRUM_CELLS_POINT_DATA;
  if (!of_points && a->array.place != THRUM_CELLS_CELL_DATA)
    return THRUM_OK;
  const int64_t rows = of_points ? r->cells.point_count : r->cells.cell_count;
  if (a->array.count == numbers_expected(r, a))
    return THRUM_OK;
  return thrum_error_set(r->error, THRUM_BAD_SHAPE,
                         "%.200s:%lld: array '%s' has %lld numbers, which is not %lld for each of "
                         "the %lld %s",
                         r->name, (long long)a->line,
                         thrum_text_excerpt(thrum_word_of(a->array.name)).text,
                         (long long)a->array.count, (long long)a->array.columns, (long long)rows,
                         of_points ? "points" : "cells");
}

/* Hands an array that was read to the grid; frees it when reading failed. */
static thrum_status keep_array(vtu_reader *r, vtu_array *a, thrum_status status) {
  THRUM_THEN(status, check_length(r, a));
  if (status < 0) {
    free(a->array.values);
    return status;
  }
  return thrum_cells_take(&r->cells, &a->array, r->error);
}

static thrum_cells_place array_place(const vtu_reader *r, const char *name) {
  if (r->place != THRUM_CELLS_CONNECTIVITY)
    return r->place;
  return strcmp(name, "connectivity") == 0 ? THRUM_CELLS_CONNECTIVITY
         : strcmp(name, "offsets") == 0    ? THRUM_CELLS_OFFSETS
         : strcmp(name, "types") == 0      ? THRUM_CELLS_TYPES
                                           : THRUM_CELLS_OTHER;
}

static bool is_data(const vtu_array *a) {
  return a->array.place == THRUM_CELLS_POINT_DATA || a->array.place == THRUM_CELLS_CELL_DATA;
}

/* Begins a <DataArray>; appended arrays wait for the bytes behind the grid, others for their text.
 */
static thrum_status begin_array(vtu_reader *r, const char **attributes) {
  vtu_array a = {.array = {.columns = 1}, .line = line_now(r)};
  const char *name = attribute(attributes, "Name"), *type = attribute(attributes, "type");
  if (name)
    strncat(a.array.name, name, THRUM_MESH_NAME_MAX);
  a.array.place = array_place(r, a.array.name);
  if (a.array.place == THRUM_CELLS_OTHER)
    return THRUM_OK;

  // an array such as one of String is no part of a mesh, so it may stand beside the grid
  a.bits = type && strcmp(type, "Bit") == 0;
  if (type)
    a.type = thrum_cells_type_of(thrum_word_of(a.bits ? "UInt8" : type));
  if (a.type.size == 0)
    return is_data(&a)
               ? THRUM_OK
               : fail(r, THRUM_UNSUPPORTED, "an array of the grid has a type that is not read");
  a.array.whole = a.type.whole;
  THRUM_TRY(attribute_integer(r, attributes, "NumberOfComponents", 1000000, &a.array.columns));
  if (a.array.place == THRUM_CELLS_POINTS && attribute(attributes, "NumberOfComponents") &&
      a.array.columns != 3)
    return fail(r, THRUM_UNSUPPORTED, "points must have three coordinates (NumberOfComponents)");

  // regions, materials and groups have one number each, so what is larger than a tensor is not read
  if (is_data(&a) && a.array.columns > DATA_COLUMNS)
    return THRUM_OK;

  // the bytes of appended arrays come at the end of the file
  if (attribute_is(attributes, "format", "appended")) {
    if (!attribute(attributes, "offset"))
      return fail(r, THRUM_BAD_FORMAT, "an appended array has no offset");
    THRUM_TRY(attribute_integer(r, attributes, "offset", INT64_MAX, &a.offset));
    a.appended = true;
    return thrum_mesh_append(&r->waiting, &r->waiting_count, &a, sizeof a, r->error);
  }

  // the text of the element holds the numbers, as words or in base64
  THRUM_TRY(attribute_choice(r, attributes, "format", "ascii", "binary", &a.base64));
  r->open = a;
  r->nested = 0;
  r->text_size = 0;
  return THRUM_OK;
}

static thrum_status end_array(vtu_reader *r) {
  vtu_array a = r->open;
  r->open = (vtu_array){.line = 0};
  if (a.line == 0)
    return THRUM_OK;

  const char *text = r->text ? r->text : "", *stop = text + r->text_size;
  // an element without any text is an array without numbers
  if (r->text_size == 0)
    return keep_array(r, &a, THRUM_OK);
  return keep_array(r, &a,
                    a.base64 ? read_bytes(r, &a, text, stop) : read_numbers(r, &a, text, stop));
}

static thrum_status read_piece(vtu_reader *r, const char **attributes) {
  if (r->has_piece)
    return fail(r, THRUM_UNSUPPORTED,
                "there are several pieces; save the grid as one (ParaView: Merge Blocks)");
  r->has_piece = true;
  THRUM_TRY(attribute_integer(r, attributes, "NumberOfPoints", INT32_MAX, &r->cells.point_count));
  THRUM_TRY(
      attribute_integer(r, attributes, "NumberOfCells", INT64_C(1) << 40, &r->cells.cell_count));

  // constant arrays shrink to a thousandth, but the numbers of corners differ
  const int64_t most = PER_BYTE * (r->stop - r->first);
  if (r->compressed && (r->cells.point_count > most || r->cells.cell_count > most))
    return fail(r, THRUM_BAD_FORMAT, "names more points or cells than a file of its size can hold");
  return THRUM_OK;
}

static thrum_status read_file_element(vtu_reader *r, const char **attributes) {
  r->has_file = true;
  if (attribute_is(attributes, "type", "PUnstructuredGrid"))
    return fail(r, THRUM_UNSUPPORTED,
                "names the files of a parallel grid; save the grid as one .vtu file");
  if (!attribute_is(attributes, "type", "UnstructuredGrid"))
    return fail(r, THRUM_UNSUPPORTED, "is no UnstructuredGrid, so it has no tetrahedra to read");
  const char *compressor = attribute(attributes, "compressor");
  r->compressed = compressor && compressor[0];
  if (r->compressed && !attribute_is(attributes, "compressor", "vtkZLibDataCompressor"))
    return fail(r, THRUM_UNSUPPORTED,
                "is compressed in a way that is not read; save it with Compressor Type ZLib or "
                "None");

  // VTK's own reader refuses the versions beyond 2 as well
  const char *version = attribute(attributes, "version");
  double number = 0;
  if (version)
    thrum_text_scan_number(version, version + strlen(version), &number);
  if (number >= 3)
    return thrum_error_set(r->error, THRUM_UNSUPPORTED,
                           "%.200s:%lld: is of version %s, which is not known; versions to 2 are "
                           "read",
                           r->name, (long long)line_now(r),
                           thrum_text_excerpt(thrum_word_of(version)).text);

  // a word that is not known could mean other bytes
  bool wide = false;
  THRUM_TRY(attribute_choice(r, attributes, "byte_order", "LittleEndian", "BigEndian", &r->big));
  THRUM_TRY(attribute_choice(r, attributes, "header_type", "UInt32", "UInt64", &wide));
  r->header_size = wide ? 8 : 4;
  return THRUM_OK;
}

/* Finds the bytes of the appended arrays, which follow the '_' of <AppendedData> and are no XML. */
static thrum_status find_appended(vtu_reader *r, const char **attributes) {
  const char *behind =
      r->first + XML_GetCurrentByteIndex(r->parser) + XML_GetCurrentByteCount(r->parser);
  const char *mark = behind < r->stop ? memchr(behind, '_', (size_t)(r->stop - behind)) : NULL;
  r->appended_base64 = true;
  THRUM_TRY(attribute_choice(r, attributes, "encoding", "raw", "base64", &r->appended_base64));
  if (!mark)
    return fail(r, THRUM_BAD_FORMAT, "the appended data has no '_' to count from");
  r->appended = mark + 1;
  XML_StopParser(r->parser, XML_FALSE);
  return THRUM_OK;
}

/* Returns the part of the grid that an element holds, or NULL if it holds no arrays. */
static const thrum_cells_place *place_of(const char *element) {
  static const struct {
    const char *name;
    thrum_cells_place place;
  } places[] = {{"Points", THRUM_CELLS_POINTS},
                {"Cells", THRUM_CELLS_CONNECTIVITY},
                {"PointData", THRUM_CELLS_POINT_DATA},
                {"CellData", THRUM_CELLS_CELL_DATA},
                {"FieldData", THRUM_CELLS_OTHER}};
  for (size_t i = 0; i < sizeof places / sizeof *places; i++)
    if (strcmp(element, places[i].name) == 0)
      return &places[i].place;
  return NULL;
}

/* Keeps the failure of a handler and ends the parse. */
static void note(vtu_reader *r, thrum_status status) {
  if (status >= 0)
    return;
  r->status = status;
  XML_StopParser(r->parser, XML_FALSE);
}

static void XMLCALL begin_element(void *reader, const char *element, const char **attributes) {
  vtu_reader *r = reader;
  if (r->status < 0)
    return;

  // elements inside an array, such as InformationKey, hold none of its numbers
  if (r->open.line > 0) {
    r->nested++;
    return;
  }
  const thrum_cells_place *place = place_of(element);
  if (place)
    r->place = *place;

  // other elements hold nothing of the mesh
  if (strcmp(element, "VTKFile") == 0)
    note(r, read_file_element(r, attributes));
  else if (strcmp(element, "Piece") == 0)
    note(r, read_piece(r, attributes));
  else if (strcmp(element, "DataArray") == 0 && r->has_file)
    note(r, begin_array(r, attributes));
  else if (strcmp(element, "AppendedData") == 0)
    note(r, find_appended(r, attributes));
}

static void XMLCALL end_element(void *reader, const char *element) {
  vtu_reader *r = reader;
  if (r->status < 0)
    return;
  if (r->nested > 0) {
    r->nested--;
    return;
  }
  if (place_of(element))
    r->place = THRUM_CELLS_OTHER;
  if (strcmp(element, "DataArray") == 0)
    note(r, end_array(r));
}

static void XMLCALL take_text(void *reader, const char *text, int length) {
  vtu_reader *r = reader;
  if (r->status < 0 || r->open.line == 0 || r->nested > 0 || length <= 0)
    return;

  // expat gives the text of an element in pieces
  note(r, thrum_mesh_grow(&r->text, r->text_size, length, 1, r->error));
  if (r->status < 0)
    return;
  memcpy(r->text + r->text_size, text, (size_t)length);
  r->text_size += length;
}

/* Feeds the file to expat. A file that ends early is no error here, since a message about the
 * missing part of the grid says more. */
static thrum_status parse_xml(vtu_reader *r) {
  enum XML_Status parsed = XML_STATUS_OK;
  for (const char *at = r->first; at < r->stop && parsed == XML_STATUS_OK;) {
    const ptrdiff_t left = r->stop - at;
    const int size = left < PIECE_OF_FILE ? (int)left : PIECE_OF_FILE;
    parsed = XML_Parse(r->parser, at, size, XML_FALSE);
    at += size;
  }
  if (r->status < 0)
    return r->status;

  const enum XML_Error code = XML_GetErrorCode(r->parser);
  if (parsed == XML_STATUS_ERROR && code == XML_ERROR_NO_MEMORY)
    return thrum_error_set(r->error, THRUM_OUT_OF_MEMORY, "not enough memory");
  if (!r->has_file)
    return thrum_error_set(r->error, THRUM_BAD_FORMAT,
                           "%.200s: there is no <VTKFile>; is it a VTK XML file?", r->name);
  // the parser was stopped where the appended data begins
  if (parsed == XML_STATUS_ERROR && code != XML_ERROR_ABORTED)
    return thrum_error_set(r->error, THRUM_BAD_FORMAT, "%.200s:%lld: is no well-formed XML: %s",
                           r->name, (long long)line_now(r), XML_ErrorString(code));
  // the numbers of an array that the end of the file cuts short are checked as well
  return end_array(r);
}

static thrum_status read_waiting(vtu_reader *r) {
  for (int64_t i = 0; i < r->waiting_count; i++) {
    vtu_array *a = &r->waiting[i];
    if (!r->appended || a->offset > r->stop - r->appended)
      return fail_at(r, a->line, THRUM_BAD_FORMAT,
                     "an array lies beyond the appended data; is the file cut short?");
    a->base64 = r->appended_base64;
    THRUM_TRY(keep_array(r, a, read_bytes(r, a, r->appended + a->offset, r->stop)));
  }
  return THRUM_OK;
}

thrum_status thrum_mesh_parse_vtu(const thrum_mesh_source *source, thrum_mesh *mesh,
                                  thrum_error *error) {
  const char *first = source->size > 0 ? source->data : "";
  vtu_reader r = {.name = source->name,
                  .first = first,
                  .stop = first + source->size,
                  .parser = XML_ParserCreate(NULL),
                  .header_size = 4,
                  .place = THRUM_CELLS_OTHER,
                  .error = error};
  if (!r.parser)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "not enough memory");
  XML_SetUserData(r.parser, &r);
  XML_SetElementHandler(r.parser, begin_element, end_element);
  XML_SetCharacterDataHandler(r.parser, take_text);

  // appended arrays can be read only when the XML has told where they begin
  thrum_status status = parse_xml(&r);
  THRUM_THEN(status, read_waiting(&r));
  THRUM_THEN(status, thrum_cells_mesh(&r.cells, source, mesh, error));

  thrum_cells_free(&r.cells);
  free(r.waiting);
  free(r.text);
  XML_ParserFree(r.parser);
  return status;
}
