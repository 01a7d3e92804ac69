/* Reads Medit .mesh files in ASCII: Vertices and Tetrahedra, and the marked Vertices, Edges,
 * Triangles and Quadrilaterals as groups. A file is one stream of words: a keyword, a count, and as
 * many records, each ended by a reference. References of tetrahedra other than 0 are regions;
 * those of the rest are the groups vertices_N, edges_N, triangles_N, quadrilaterals_N, and of
 * several regions tetrahedra_N. Other keywords are passed over. Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_builder.h"
#include "mesh/mesh_groups.h"

typedef struct medit_reader {
  thrum_text text;
  thrum_mesh_builder builder;
  bool has_vertices, has_tets;
  thrum_error *error;
} medit_reader;

/* A keyword whose records are `corners` vertices and a reference. */
typedef struct medit_kind {
  const char *keyword;
  int corners;
  const char *list; /* first part of the names of its groups; NULL: passed over or refused */
} medit_kind;

static const medit_kind KINDS[] = {{"Vertices", 0, "vertices"},
                                   {"Edges", 2, "edges"},
                                   {"Triangles", 3, "triangles"},
                                   {"Quadrilaterals", 4, "quadrilaterals"},
                                   {"Tetrahedra", 4, "tetrahedra"},
                                   {"Hexahedra", 8, NULL},
                                   {"Prisms", 6, NULL},
                                   {"Pyramids", 5, NULL},
                                   {"TetrahedraP2", 10, NULL}};

static thrum_status integer(medit_reader *r, const char *what, int64_t low, int64_t high,
                            int64_t *value) {
  THRUM_TRY(thrum_text_need_word(&r->text, what, r->error));
  return thrum_text_integer(&r->text, what, low, high, value, r->error);
}

/* Reads a reference, which is always a whole number. */
static thrum_status reference(medit_reader *r, int64_t *value) {
  return integer(r, "a reference", INT32_MIN, INT32_MAX, value);
}

static thrum_status read_vertex(medit_reader *r, int64_t number) {
  static const char *const axes[] = {"the x coordinate", "the y coordinate", "the z coordinate"};
  double position[3] = {0};
  int64_t ref = 0;
  for (int c = 0; c < 3; c++) {
    THRUM_TRY(thrum_text_need_word(&r->text, axes[c], r->error));
    THRUM_TRY(thrum_text_number(&r->text, axes[c], &position[c], r->error));
  }
  THRUM_TRY(reference(r, &ref));
  THRUM_TRY(thrum_builder_vertex(&r->builder, number, position, r->text.line));
  return ref == 0 ? THRUM_OK : thrum_builder_mark(&r->builder, "vertices", ref, &number, 1);
}

static thrum_status read_element(medit_reader *r, const medit_kind *kind) {
  int64_t vertices[8] = {0}, ref = 0;
  for (int i = 0; i < kind->corners; i++)
    THRUM_TRY(integer(r, "a vertex", 1, INT32_MAX, &vertices[i]));
  const int64_t line = r->text.line;
  THRUM_TRY(reference(r, &ref));
  const bool tet = strcmp(kind->keyword, "Tetrahedra") == 0;
  if (tet)
    return thrum_builder_tet(&r->builder, vertices, ref, line);
  return ref == 0 ? THRUM_OK
                  : thrum_builder_mark(&r->builder, kind->list, ref, vertices, kind->corners);
}

static thrum_status read_kind(medit_reader *r, const medit_kind *kind) {
  int64_t count = 0;
  THRUM_TRY(integer(r, "a count", 0, INT32_MAX, &count));

  // solids that are no tets are refused unless there are none of them
  if (!kind->list)
    return count == 0 ? THRUM_OK
                      : thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                                        "%s are not supported; the body must be meshed with "
                                        "Tetrahedra alone",
                                        kind->keyword);

  // vertices are numbered by their order, so a second list of them would be ambiguous
  bool *seen = kind->corners == 0                         ? &r->has_vertices
               : strcmp(kind->keyword, "Tetrahedra") == 0 ? &r->has_tets
                                                          : NULL;
  if (seen && *seen)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "%s comes twice", kind->keyword);
  if (seen)
    *seen = true;

  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(kind->corners == 0 ? read_vertex(r, i + 1) : read_element(r, kind));
  return THRUM_OK;
}

/* Passes over the numbers of an unknown keyword, up to the next keyword. */
static void skip_numbers(medit_reader *r) {
  const char *word;
  size_t length;
  for (;;) {
    while (!thrum_text_more(&r->text))
      if (!thrum_text_next_line(&r->text))
        return;
    const char c = *r->text.at;
    if ((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))
      return;
    thrum_text_word(&r->text, &word, &length);
  }
}

/* Reads one keyword and its records; *more is false at the end. */
static thrum_status read_keyword(medit_reader *r, bool *more) {
  const char *word = "";
  size_t length = 0;

  // a file may end without End
  while (!thrum_text_word(&r->text, &word, &length))
    if (!thrum_text_next_line(&r->text)) {
      *more = false;
      return THRUM_OK;
    }

  // most keywords differ only in the number of vertices of a record
  for (size_t i = 0; i < sizeof KINDS / sizeof *KINDS; i++)
    if (thrum_text_equals(word, length, KINDS[i].keyword))
      return read_kind(r, &KINDS[i]);

  // a flat mesh has no volume to simulate
  int64_t dimension = 0;
  if (thrum_text_equals(word, length, "Dimension")) {
    THRUM_TRY(integer(r, "the dimension", 2, 3, &dimension));
    if (dimension != 3)
      return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                             "the mesh is flat; a body needs Dimension 3");
    return THRUM_OK;
  }

  if (thrum_text_equals(word, length, "End")) {
    *more = false;
    return THRUM_OK;
  }

  // numbers of unknown keywords are passed over, a number where a keyword belongs is not
  if (!((*word >= 'A' && *word <= 'Z') || (*word >= 'a' && *word <= 'z')))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "expected a keyword such as Tetrahedra, found '%s'; is a count wrong?",
                           thrum_text_excerpt(word, length).text);
  skip_numbers(r);
  return THRUM_OK;
}

static thrum_status read_header(medit_reader *r) {
  const char *word = "";
  size_t length = 0;
  if (thrum_text_next_line(&r->text))
    thrum_text_word(&r->text, &word, &length);

  // the first word tells a Medit mesh from other files that end in .mesh
  if (length == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "there is no MeshVersionFormatted; is it a Medit mesh in ASCII?");
  if (!thrum_text_equals(word, length, "MeshVersionFormatted"))
    return thrum_text_fail(
        &r->text, THRUM_BAD_FORMAT, r->error,
        "expected MeshVersionFormatted, found '%s'; is it a Medit mesh in ASCII?",
        thrum_text_excerpt(word, length).text);

  int64_t version = 0;
  return integer(r, "the version", 0, 4, &version);
}

static thrum_status read_all(medit_reader *r, thrum_mesh *mesh) {
  bool more = true;
  THRUM_TRY(read_header(r));
  while (more)
    THRUM_TRY(read_keyword(r, &more));

  // a file without either list is no volume mesh or was cut short
  if (!r->has_vertices || !r->has_tets)
    return thrum_text_fail(&r->text, THRUM_MISSING, r->error, "there are no %s; is the file whole?",
                           r->has_vertices ? "Tetrahedra" : "Vertices");

  THRUM_TRY(thrum_builder_finish(&r->builder, r->text.name, mesh));
  return thrum_builder_region_groups(&r->builder, "tetrahedra", false, mesh);
}

thrum_status thrum_mesh_parse_medit(const char *name, const void *data, size_t size,
                                    thrum_mesh *mesh, thrum_error *error) {
  medit_reader r = {.error = error, .builder = {.error = error}};
  thrum_mesh read = {0};
  THRUM_TRY(thrum_text_view(name, data, size, '#', 0, &r.text, error));
  const thrum_status status = read_all(&r, &read);
  thrum_builder_free(&r.builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
