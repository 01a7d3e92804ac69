/* Reads STL files, ASCII (solid, facet normal, outer loop, three vertex lines) and binary (80
 * bytes, a count, and 50 bytes a facet: normal, three corners, an attribute, little-endian floats).
 * A file whose size is just that of its count is binary, whatever its first word. Normals and
 * attributes are passed over; corners at just the same place become one vertex. Format: 3D Systems,
 * Stereolithography Interface Specification, 1989. Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "io/text.h"
#include "mesh/formats/surface_read.h"
#include "mesh/point_hash.h"
#include "mesh/surface_mesh.h"

enum { HEADER = 84, FACET = 50 };

typedef struct stl_reader {
  thrum_text text;
  thrum_surface_builder builder;
  thrum_point_hash places;
} stl_reader;

/* Finds the vertex at a place; a new one is added when there is none yet. */
static thrum_status find_vertex(stl_reader *r, const double position[3], int32_t *vertex) {
  thrum_surface_mesh *made = &r->builder.made;
  const int64_t count = made->vertex_count;
  THRUM_TRY(
      thrum_point_hash_find(&r->places, made->vertices, count, position, vertex, r->text.error));
  if (*vertex == count)
    return thrum_surface_add_vertex(&r->builder, position);
  made->merged++;
  return THRUM_OK;
}

static thrum_status expect_word(stl_reader *r, const char *wanted) {
  thrum_word word = {"", 0};

  // words may stand on any number of lines
  while (!thrum_text_more(&r->text))
    if (!thrum_text_next_line(&r->text))
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                             "the file ends before '%s'; is it cut short?", wanted);

  thrum_text_word(&r->text, &word);
  if (thrum_text_equals(word, wanted))
    return THRUM_OK;
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected '%s', found '%s'", wanted,
                         thrum_text_excerpt(word).text);
}

/* Reads a facet up to `endfacet`, after the word `facet`. */
static thrum_status read_facet(stl_reader *r) {
  const int64_t line = r->text.line;
  int32_t corners[3] = {0};
  double position[3] = {0};

  THRUM_TRY(expect_word(r, "normal"));

  // the normal follows from the corners, and some programs write nan for it
  thrum_text_next_line(&r->text);
  THRUM_TRY(expect_word(r, "outer"));
  THRUM_TRY(expect_word(r, "loop"));

  // corners at the same place become one vertex
  for (int c = 0; c < 3; c++) {
    THRUM_TRY(expect_word(r, "vertex"));
    THRUM_TRY(thrum_text_position(&r->text, position));
    THRUM_TRY(thrum_text_finish(&r->text, "the vertex"));
    THRUM_TRY(find_vertex(r, position, &corners[c]));
  }

  THRUM_TRY(expect_word(r, "endloop"));
  THRUM_TRY(expect_word(r, "endfacet"));
  return thrum_surface_add_triangle(&r->builder, corners, line);
}

/* Reads an ASCII file; all its solids together are one surface. */
static thrum_status read_text(stl_reader *r) {
  thrum_word word = {"", 0};
  bool inside = false;

  while (thrum_text_next_line(&r->text)) {
    thrum_text_word(&r->text, &word);
    thrum_status status = THRUM_OK;

    // facets stand between solid and endsolid, of which a file may have several
    if (thrum_text_equals(word, "solid")) // the next one also ends one that has no end
      inside = true;
    else if (inside && thrum_text_equals(word, "endsolid"))
      inside = false;
    else if (inside && thrum_text_equals(word, "facet"))
      status = read_facet(r);
    else
      status = thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected '%s', found '%s'",
                               inside ? "facet" : "solid", thrum_text_excerpt(word).text);

    if (status < 0)
      return status;
  }

  // facets after the cut would be missing without notice
  if (inside)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "the file ends before 'endsolid'; is it cut short?");
  return THRUM_OK;
}

static uint32_t get32(const unsigned char *p) {
  return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static thrum_status read_binary(stl_reader *r, const unsigned char *data, uint32_t count) {
  r->builder.made.binary = true;
  for (uint32_t n = 0; n < count; n++) {
    const unsigned char *facet = data + HEADER + (size_t)n * FACET;
    int32_t corners[3] = {0};

    // the normal in front of the corners follows from them
    for (int c = 0; c < 3; c++) {
      double position[3];
      for (int axis = 0; axis < 3; axis++) {
        const uint32_t bits = get32(facet + 12 + 12 * c + 4 * axis);
        float value;
        memcpy(&value, &bits, sizeof value);
        position[axis] = (double)value;
        if (!isfinite(position[axis]))
          return thrum_text_fail(&r->text, THRUM_BAD_VALUE,
                                 "facet %lu has a corner that is not a finite number",
                                 (unsigned long)n + 1);
      }

      THRUM_TRY(find_vertex(r, position, &corners[c]));
    }

    THRUM_TRY(thrum_surface_add_triangle(&r->builder, corners, (int64_t)n + 1));
  }
  return THRUM_OK;
}

static bool begins_with_solid(const unsigned char *data, size_t size) {
  const size_t mark = size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
  size_t at = mark;
  while (at < size && (data[at] == ' ' || (data[at] >= '\t' && data[at] <= '\r')))
    at++;
  return size - at >= 5 && thrum_text_equals((thrum_word){(const char *)data + at, 5}, "solid");
}

static thrum_status read_stl(stl_reader *r, const unsigned char *data, size_t size) {
  const uint32_t count = size >= HEADER ? get32(data + HEADER - 4) : 0;
  const uint64_t binary = HEADER + (uint64_t)count * FACET;

  // some binary files begin with 'solid' too, so the size is asked first
  if (size >= HEADER && size == binary)
    return read_binary(r, data, count);
  if (begins_with_solid(data, size))
    return read_text(r);

  // a file that is neither is probably cut short
  if (size < HEADER)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "neither 'solid' nor the 84 bytes that begin a binary .stl");
  return thrum_text_fail(
      &r->text, THRUM_BAD_FORMAT,
      "a binary .stl of %lu facets has %llu bytes, this file has %llu: is it cut "
      "short?",
      (unsigned long)count, (unsigned long long)binary, (unsigned long long)size);
}

thrum_status thrum_surface_parse_stl(const char *name, const void *data, size_t size,
                                     thrum_surface_mesh *surface, thrum_error *error) {
  stl_reader r = {.builder = {.error = error}};
  thrum_status status = thrum_text_view(name, data, size, 0, 0, &r.text, error);
  THRUM_THEN(status, read_stl(&r, data, size));
  if (status >= 0 && r.builder.made.triangle_count == 0)
    status = thrum_text_fail(&r.text, THRUM_MISSING, "there are no facets in the file");

  thrum_point_hash_free(&r.places);
  return thrum_surface_mesh_deliver(status, &r.builder.made, surface);
}
