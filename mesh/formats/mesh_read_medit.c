/* Reads Medit .mesh files in ASCII: Vertices, Tetrahedra of four and of ten nodes (TetrahedraP2, as
 * Gmsh writes them), Hexahedra, Prisms and Pyramids, and the marked Vertices, Edges, Triangles and
 * Quadrilaterals as groups. A file is one stream of words: a keyword, a count, and as many records,
 * each ended by a reference. References of solids are regions; those of the rest are the groups
 * vertices_N, edges_N, triangles_N, quadrilaterals_N, and of several regions tetrahedra_N. Other
 * keywords are passed over. Cost: linear in the file.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "io/text.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/mesh.h"
#include "mesh/mesh_builder.h"

typedef struct medit_reader {
  thrum_text text;
  thrum_mesh_builder builder;
  bool seen[16]; /* the keywords that came, in the order of KINDS */
} medit_reader;

/* A keyword whose records are `nodes` vertices and a reference. */
typedef struct medit_kind {
  const char *keyword;
  int nodes;        /* 0: the record is a vertex */
  const char *list; /* first part of the names of its groups; NULL: a solid */
  thrum_solid solid;
  bool quadratic;
} medit_kind;

static const medit_kind KINDS[] = {{"Vertices", 0, "vertices", THRUM_SOLID_TET, false},
                                   {"Edges", 2, "edges", THRUM_SOLID_TET, false},
                                   {"EdgesP2", 3, "edges", THRUM_SOLID_TET, false},
                                   {"Triangles", 3, "triangles", THRUM_SOLID_TET, false},
                                   {"TrianglesP2", 6, "triangles", THRUM_SOLID_TET, false},
                                   {"Quadrilaterals", 4, "quadrilaterals", THRUM_SOLID_TET, false},
                                   {"Tetrahedra", 4, NULL, THRUM_SOLID_TET, false},
                                   {"TetrahedraP2", 10, NULL, THRUM_SOLID_TET, true},
                                   {"Pyramids", 5, NULL, THRUM_SOLID_PYRAMID, false},
                                   {"Prisms", 6, NULL, THRUM_SOLID_WEDGE, false},
                                   {"Hexahedra", 8, NULL, THRUM_SOLID_HEXAHEDRON, false}};
enum { KIND_COUNT = sizeof KINDS / sizeof *KINDS };

static thrum_status integer(medit_reader *r, const char *what, int64_t low, int64_t high,
                            int64_t *value) {
  THRUM_TRY(thrum_text_need_word(&r->text, what));
  return thrum_text_integer(&r->text, what, low, high, value);
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
    THRUM_TRY(thrum_text_need_word(&r->text, axes[c]));
    THRUM_TRY(thrum_text_number(&r->text, axes[c], &position[c]));
  }
  THRUM_TRY(reference(r, &ref));
  THRUM_TRY(thrum_builder_vertex(&r->builder, number, position, r->text.line));
  return ref == 0 ? THRUM_OK : thrum_builder_mark(&r->builder, "vertices", ref, &number, 1);
}

static thrum_status read_element(medit_reader *r, const medit_kind *kind) {
  int64_t vertices[10] = {0}, ref = 0;
  for (int i = 0; i < kind->nodes; i++)
    THRUM_TRY(integer(r, "a vertex", 1, INT32_MAX, &vertices[i]));
  const int64_t line = r->text.line;
  THRUM_TRY(reference(r, &ref));
  if (kind->list)
    return ref == 0 ? THRUM_OK
                    : thrum_builder_mark(&r->builder, kind->list, ref, vertices, kind->nodes);

  // the middle nodes of Gmsh's TetrahedraP2 have the order of VTK
  return thrum_builder_element(&r->builder, &(thrum_element){.kind = kind->solid,
                                                             .quadratic = kind->quadratic,
                                                             .nodes = vertices,
                                                             .key = ref,
                                                             .line = line});
}

static thrum_status read_kind(medit_reader *r, const medit_kind *kind) {
  int64_t count = 0;
  THRUM_TRY(integer(r, "a count", 0, INT32_MAX, &count));

  // vertices are numbered by their order, and a second list of solids is a file joined wrongly
  bool *seen = &r->seen[kind - KINDS];
  if (*seen && (kind->nodes == 0 || !kind->list))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "%s comes twice", kind->keyword);
  *seen = true;

  for (int64_t i = 0; i < count; i++)
    THRUM_TRY(kind->nodes == 0 ? read_vertex(r, i + 1) : read_element(r, kind));
  return THRUM_OK;
}

/* Passes over the numbers of an unknown keyword, up to the next keyword. */
static void skip_numbers(medit_reader *r) {
  thrum_word word = {"", 0};
  for (;;) {
    while (!thrum_text_more(&r->text))
      if (!thrum_text_next_line(&r->text))
        return;
    const char c = *r->text.at;
    if ((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'))
      return;
    thrum_text_word(&r->text, &word);
  }
}

/* Is a keyword that of solids, or of their faces or order of nodes, which is none of KINDS? */
static bool is_other_solid(thrum_word word) {
  static const char *const solids[] = {"TetrahedraP", "TetrahedraQ", "HexahedraP",
                                       "HexahedraQ",  "PrismsP",     "PrismsQ",
                                       "PyramidsP",   "PyramidsQ",   "Polyhedr"};
  for (size_t i = 0; i < sizeof solids / sizeof *solids; i++) {
    const size_t length = strlen(solids[i]);
    if (word.length > length && thrum_text_equals((thrum_word){word.text, length}, solids[i]))
      return true;
  }
  return false;
}

/* Reads one keyword and its records; *more is false at the end. */
static thrum_status read_keyword(medit_reader *r, bool *more) {
  thrum_word word = {"", 0};

  // a file may end without End
  while (!thrum_text_word(&r->text, &word))
    if (!thrum_text_next_line(&r->text)) {
      *more = false;
      return THRUM_OK;
    }

  // most keywords differ only in the number of vertices of a record
  for (int i = 0; i < KIND_COUNT; i++)
    if (thrum_text_equals(word, KINDS[i].keyword))
      return read_kind(r, &KINDS[i]);

  // a flat mesh has no volume to simulate
  int64_t dimension = 0;
  if (thrum_text_equals(word, "Dimension")) {
    THRUM_TRY(integer(r, "the dimension", 2, 3, &dimension));
    if (dimension != 3)
      return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                             "the mesh is flat; a body needs Dimension 3");
    return THRUM_OK;
  }

  if (thrum_text_equals(word, "End")) {
    *more = false;
    return THRUM_OK;
  }

  // a part of the body may be in another file
  if (thrum_text_equals(word, "IncludeFile"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "IncludeFile is not read; save the mesh as one file");

  // solids of another order would be a hole in the body
  if (is_other_solid(word))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "%s is not read; save the mesh with Tetrahedra, TetrahedraP2, Pyramids, "
                           "Prisms or Hexahedra, or in another format",
                           thrum_text_excerpt(word).text);

  // numbers of unknown keywords are passed over, a number where a keyword belongs is not
  const char c = *word.text;
  if (!((c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z')))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "expected a keyword such as Tetrahedra, found '%s'; is a count wrong, "
                           "or has a record more nodes than its keyword says?",
                           thrum_text_excerpt(word).text);
  skip_numbers(r);
  return THRUM_OK;
}

static thrum_status read_header(medit_reader *r) {
  thrum_word word = {"", 0};
  if (thrum_text_next_line(&r->text))
    thrum_text_word(&r->text, &word);

  // the first word tells a Medit mesh from other files that end in .mesh
  if (word.length == 0)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "there is no MeshVersionFormatted; is it a Medit mesh in ASCII?");
  if (!thrum_text_equals(word, "MeshVersionFormatted"))
    return thrum_text_fail(
        &r->text, THRUM_BAD_FORMAT,
        "expected MeshVersionFormatted, found '%s'; is it a Medit mesh in ASCII?",
        thrum_text_excerpt(word).text);

  int64_t version = 0;
  return integer(r, "the version", 0, 4, &version);
}

static thrum_status read_all(medit_reader *r, thrum_mesh *mesh) {
  bool more = true;
  THRUM_TRY(read_header(r));
  while (more)
    THRUM_TRY(read_keyword(r, &more));

  // a file without either list is no volume mesh or was cut short
  bool solids = false;
  for (int i = 0; i < KIND_COUNT; i++)
    solids = solids || (r->seen[i] && !KINDS[i].list);
  if (!r->seen[0] || !solids)
    return thrum_text_fail(&r->text, THRUM_MISSING, "there are no %s; is the file whole?",
                           r->seen[0] ? "Tetrahedra" : "Vertices");

  THRUM_TRY(thrum_builder_finish(&r->builder, r->text.name, mesh));
  THRUM_TRY(thrum_builder_name_regions(&r->builder, mesh));
  return thrum_builder_region_groups(&r->builder, "tetrahedra", false, mesh);
}

thrum_status thrum_mesh_parse_medit(const thrum_mesh_source *source, thrum_mesh *mesh,
                                    thrum_error *error) {
  medit_reader r = {
      .builder = {.error = error, .corners = source->corners, .keep_solids = source->solids}};
  thrum_mesh read = {0};
  THRUM_TRY(thrum_text_view(source->name, source->data, source->size, '#', 0, &r.text, error));
  r.text.fortran = true;
  const thrum_status status = read_all(&r, &read);
  thrum_builder_free(&r.builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
