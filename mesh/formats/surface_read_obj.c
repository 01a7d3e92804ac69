/* Reads Wavefront .obj: v (x y z, then a weight or a colour, passed over) and f (i, i/j, i//k or
 * i/j/k; negative ones count back from the last vertex). Polygons become fans from their first
 * corner. A line that ends in \ continues in the next; # begins a comment. Statements that only
 * describe the look of the surface are passed over, free-form curves and surfaces are refused.
 * Format: Wavefront, Advanced Visualizer Manual, appendix B1. Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "io/text.h"
#include "mesh/formats/surface_read.h"
#include "mesh/mesh_grow.h"
#include "mesh/surface_mesh.h"

typedef struct obj_reader {
  thrum_text text;
  thrum_surface_builder builder;
  bool goes_on; /* the line ended in \ */
  bool pending; /* the present line is a statement that has not been read yet */
  int64_t *corners;
  int64_t corner_count;
} obj_reader;

/* Statements that describe the look of a surface or name its parts. */
static const char *const passed_over[] = {"vt",         "vn",  "vp",     "g",        "o",
                                          "s",          "mg",  "usemtl", "mtllib",   "maplib",
                                          "usemap",     "lod", "bevel",  "c_interp", "d_interp",
                                          "shadow_obj", "l",   "p",      "trace_obj"};
static const char *const curved[] = {"cstype", "deg",  "bmat",  "step", "curv", "curv2",
                                     "surf",   "parm", "trim",  "scrv", "hole", "sp",
                                     "end",    "con",  "ctech", "stech"};

/* Takes a \ off the end of the line. */
static void begin_line(obj_reader *r) {
  thrum_text *text = &r->text;
  r->goes_on = text->end > text->at && text->end[-1] == '\\';
  if (r->goes_on)
    text->end--;
}

static bool next_statement(obj_reader *r) {
  if (r->pending) {
    r->pending = false;
    return true;
  }
  if (!thrum_text_next_line(&r->text))
    return false;
  begin_line(r);
  return true;
}

/* Tells whether the statement has another word, on this line or on one that continues it. */
static bool more(obj_reader *r) {
  while (!thrum_text_more(&r->text)) {
    const int64_t line = r->text.line;
    if (!r->goes_on || r->pending || !thrum_text_next_line(&r->text))
      return false;

    // a blank line in between ends the statement
    r->pending = r->text.line > line + 1;
    begin_line(r);

    if (r->pending)
      return false;
  }
  return true;
}

static bool is_among(thrum_word word, const char *const *names, size_t count) {
  for (size_t i = 0; i < count; i++)
    if (thrum_text_equals(word, names[i]))
      return true;
  return false;
}

static thrum_status read_vertex(obj_reader *r) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  double position[3] = {0}, unused = 0;

  // the coordinates may continue on the next line
  for (int c = 0; c < 3; c++) {
    more(r);
    THRUM_TRY(r->pending ? thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                                           "the vertex before this line ends before %s", axes[c])
                         : thrum_text_number(&r->text, axes[c], &position[c]));
  }

  // some programs append a weight, a colour, or both
  for (int n = 0; n < 4 && more(r); n++)
    THRUM_TRY(thrum_text_number(&r->text, "a weight or a colour", &unused));

  if (more(r))
    THRUM_TRY(thrum_text_finish(&r->text, "the vertex"));
  return thrum_surface_add_vertex(&r->builder, position);
}

/* Scans one of the three numbers of a corner; an empty one is 0. Returns false when it is no
 * number. */
static bool scan_index(const char **at, const char *end, int64_t *index) {
  *index = 0;
  if (*at < end && **at != '/') {
    const size_t used = thrum_text_scan_integer(*at, end, index);
    if (used == 0 || *index == 0)
      return false;
    *at += used;
  }
  return true;
}

/* Reads the vertex of a corner, from 1; texture and normal behind slashes are passed over. */
static thrum_status read_corner(obj_reader *r, int64_t *corner) {
  thrum_word word = {"", 0};
  thrum_text_word(&r->text, &word);
  const char *at = word.text, *end = at + word.length;

  // texture coordinate and normal are checked, so that a wrong file is noticed
  int64_t index[3] = {0};
  bool good = scan_index(&at, end, &index[0]) && index[0] != 0;
  for (int n = 1; n < 3 && good && at < end; n++)
    good = *at++ == '/' && scan_index(&at, end, &index[n]);

  if (!good || at != end)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "expected a corner such as 7, 7/1 or 7//2, counted from 1, found '%s'",
                           thrum_text_excerpt(word).text);

  // a negative index counts back from the last vertex so far
  const int64_t count = r->builder.made.vertex_count;
  const int64_t vertex = index[0] < 0 ? count + 1 + index[0] : index[0];

  // a vertex may still follow, but none stands before the first
  if (vertex < 1 || vertex > INT32_MAX - 1)
    return thrum_text_fail(&r->text, THRUM_BAD_VALUE,
                           "a corner names vertex %lld, and there are %lld up to here",
                           (long long)index[0], (long long)count);

  *corner = vertex;
  return THRUM_OK;
}

static thrum_status read_face(obj_reader *r) {
  const int64_t line = r->text.line;

  // a face has any number of corners
  for (r->corner_count = 0; more(r); r->corner_count++) {
    THRUM_TRY(thrum_mesh_grow(&r->corners, r->corner_count, 1, sizeof *r->corners, r->text.error));
    THRUM_TRY(read_corner(r, &r->corners[r->corner_count]));
  }

  // lines and points have statements of their own
  if (r->corner_count < 3)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "the face%s has %lld corners; it needs three or more",
                           r->pending ? " before this line" : "", (long long)r->corner_count);

  // a polygon becomes a fan of triangles around its first corner
  r->builder.made.polygons += r->corner_count > 3;
  for (int64_t n = 2; n < r->corner_count; n++) {
    const int32_t triangle[3] = {(int32_t)(r->corners[0] - 1), (int32_t)(r->corners[n - 1] - 1),
                                 (int32_t)(r->corners[n] - 1)};
    THRUM_TRY(thrum_surface_add_triangle(&r->builder, triangle, line));
  }
  return THRUM_OK;
}

static thrum_status read_statement(obj_reader *r) {
  thrum_word word = {"", 0};
  if (!more(r))
    return THRUM_OK;
  thrum_text_word(&r->text, &word);

  if (thrum_text_equals(word, "v"))
    return read_vertex(r);
  if (thrum_text_equals(word, "f") || thrum_text_equals(word, "fo"))
    return read_face(r);

  // statements of free-form surfaces are refused, since their triangles are not in the file
  if (is_among(word, curved, sizeof curved / sizeof *curved))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "'%s' belongs to a free-form surface; export the surface as polygons",
                           thrum_text_excerpt(word).text);
  if (!is_among(word, passed_over, sizeof passed_over / sizeof *passed_over))
    return thrum_text_fail(
        &r->text, THRUM_BAD_FORMAT,
        "expected a statement such as v or f, found '%s'; is it a Wavefront .obj?",
        thrum_text_excerpt(word).text);

  // a statement that is passed over may continue on further lines
  while (more(r))
    thrum_text_word(&r->text, &word);
  return THRUM_OK;
}

/* A face may come before its vertices, so what it names is judged at the end. */
static thrum_status check_indices(obj_reader *r) {
  const thrum_surface_mesh *made = &r->builder.made;
  if (made->triangle_count == 0)
    return thrum_text_fail(&r->text, THRUM_MISSING, "there are no faces (f) in the file");

  for (int64_t n = 0; n < 3 * made->triangle_count; n++) {
    if (made->triangles[n] < made->vertex_count)
      continue;
    r->text.line = made->triangle_line[n / 3];
    return thrum_text_fail(&r->text, THRUM_BAD_VALUE,
                           "a corner names vertex %lld, and the file has %lld",
                           (long long)made->triangles[n] + 1, (long long)made->vertex_count);
  }
  return THRUM_OK;
}

thrum_status thrum_surface_parse_obj(const char *name, const void *data, size_t size,
                                     thrum_surface_mesh *surface, thrum_error *error) {
  obj_reader r = {.builder = {.error = error}};
  thrum_status status = thrum_text_view(name, data, size, '#', 0, &r.text, error);
  while (status >= 0 && next_statement(&r))
    status = read_statement(&r);
  THRUM_THEN(status, check_indices(&r));

  free(r.corners);
  return thrum_surface_mesh_deliver(status, &r.builder.made, surface);
}
