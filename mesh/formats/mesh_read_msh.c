/* Reads Gmsh .msh files, versions 2.2 and 4.1, ASCII or binary of either byte order:
 * $PhysicalNames and $Entities (mesh_read_msh_groups.c), $Nodes and $Elements
 * (mesh_read_msh_items.c); other sections are passed over. Tetrahedra (type 4) are the mesh.
 * Physical volumes are its regions; physical groups of any dimension are vertex groups. Version 2
 * writes an element once for each physical group that it is in: tets that come again are joined
 * with the first. Vertices are ordered by their tags, which may have gaps. Format: Gmsh reference
 * manual, https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format. Cost: linear in the file, n log
 * n in the nodes when they are not in order.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_read_msh.h"

static thrum_status read_format(msh_reader *r) {
  double version = 0;
  int64_t binary = 0, size = 8;
  THRUM_TRY(thrum_msh_text_line(r, "the version"));
  THRUM_TRY(thrum_text_number(&r->text, "the version", &version, r->error));
  THRUM_TRY(thrum_text_integer(&r->text, "the kind, 0 for ASCII", 0, INT64_MAX, &binary, r->error));
  THRUM_TRY(thrum_text_integer(&r->text, "the size of numbers", 0, INT64_MAX, &size, r->error));

  // other versions have other sections
  if (!(version >= 2 && version < 2.3) && version != 4.1)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "version %g is not read, only 2.2 and 4.1; convert it with: gmsh "
                           "FILE -save -format msh41 -o NEW.msh",
                           version);

  r->version = version < 3 ? 2 : 4;
  return binary != 0 ? thrum_msh_byte_order(r) : THRUM_OK;
}

/* Reads up to the line $EndNAME; right after a section that was read it must be the next one. */
static thrum_status end_section(msh_reader *r, const char *name, size_t length, bool skip) {
  while (thrum_text_next_line(&r->text)) {
    const char *line = r->text.start;
    if ((size_t)(r->text.end - line) == length + 4 && memcmp(line, "$End", 4) == 0 &&
        memcmp(line + 4, name, length) == 0)
      return THRUM_OK;

    // a section that was read must end here, otherwise its count is wrong
    if (!skip)
      return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                             "expected $End%s, found '%s'; is a count too small?",
                             thrum_text_excerpt(name, length).text,
                             thrum_text_excerpt(line, (size_t)(r->text.end - line)).text);
  }
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                         "the file ends before $End%s; is it cut short?",
                         thrum_text_excerpt(name, length).text);
}

static thrum_status read_entities(msh_reader *r) {
  if (r->version != 4)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Entities does not belong into a file of version 2");
  if (r->has_entities || r->has_elements)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Entities comes twice or after $Elements");
  r->has_entities = true;
  return thrum_msh_entities(r);
}

static thrum_status read_any_nodes(msh_reader *r, bool parametric) {
  if (r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "$Nodes comes twice");
  r->has_nodes = true;
  THRUM_TRY(thrum_msh_nodes(r, parametric));
  return thrum_builder_order(&r->builder, r->text.name);
}

static thrum_status read_nodes(msh_reader *r) {
  return read_any_nodes(r, false);
}

static thrum_status read_parametric_nodes(msh_reader *r) {
  return read_any_nodes(r, true);
}

static thrum_status read_elements(msh_reader *r) {
  if (r->has_elements || !r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "$Elements comes twice or before $Nodes");
  r->has_elements = true;
  return thrum_msh_elements(r);
}

static thrum_status read_section(msh_reader *r) {
  static const struct {
    const char *keyword;
    thrum_status (*read)(msh_reader *r);
  } sections[] = {{"$MeshFormat", read_format},
                  {"$PhysicalNames", thrum_msh_physical_names},
                  {"$Entities", read_entities},
                  {"$Nodes", read_nodes},
                  {"$ParametricNodes", read_parametric_nodes},
                  {"$Elements", read_elements}};

  // $MeshFormat comes first, and once
  const char *start = r->text.start;
  size_t length = (size_t)(r->text.end - start);
  bool format = thrum_text_equals(start, length, "$MeshFormat");
  if (*start != '$' || length < 2 || (format == (r->version != 0)))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "expected %s, found '%s'; is it a Gmsh mesh of version 2.2 or 4.1?",
                           r->version ? "a section such as $Nodes" : "$MeshFormat",
                           thrum_text_excerpt(start, length).text);

  // the parts of a partitioned mesh repeat entities under other tags
  if (thrum_text_equals(start, length, "$PartitionedEntities"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "partitioned meshes are not supported; save it unpartitioned");

  // sections that hold nothing of the mesh are passed over
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (thrum_text_equals(start, length, sections[i].keyword)) {
      THRUM_TRY(sections[i].read(r));
      return end_section(r, start + 1, length - 1, false);
    }
  return end_section(r, start + 1, length - 1, true);
}

static thrum_status read_all(msh_reader *r, thrum_mesh *mesh) {
  while (thrum_text_next_line(&r->text))
    THRUM_TRY(read_section(r));

  // a mesh needs both sections, whatever else the file has
  if ((!r->has_nodes || !r->has_elements))
    return thrum_text_fail(&r->text, THRUM_MISSING, r->error,
                           "there is no $%s section; is it a Gmsh mesh, and is it whole?",
                           !r->version    ? "MeshFormat"
                           : r->has_nodes ? "Elements"
                                          : "Nodes");

  // materials come from the user
  return thrum_builder_finish(&r->builder, r->text.name, mesh);
}

thrum_status thrum_mesh_parse_msh(const char *name, const void *data, size_t size, thrum_mesh *mesh,
                                  thrum_error *error) {
  msh_reader r = {.error = error, .builder = {.error = error, .joins_repeats = true}};
  thrum_mesh read = {0};
  THRUM_TRY(thrum_text_view(name, data, size, 0, 0, &r.text, error));
  const thrum_status status = read_all(&r, &read);
  free(r.physicals);
  free(r.entities);
  free(r.entity_physicals);
  thrum_builder_free(&r.builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
