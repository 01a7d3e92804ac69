/* Reads Gmsh .msh files, versions 2.2 and 4.1, ASCII or binary of either byte order:
 * $PhysicalNames and $Entities (mesh_read_msh_groups.c), $Nodes and $Elements
 * (mesh_read_msh_items.c); other sections are passed over. Tetrahedra (types 4 and 11) are the
 * mesh; hexahedra, wedges and pyramids of order 1 and 2 are cut into them.
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
#include "mesh/mesh_groups.h"

static thrum_status read_format(msh_reader *r) {
  double version = 0;
  int64_t binary = 0, size = 8;
  THRUM_TRY(thrum_msh_text_line(r, "the version"));
  THRUM_TRY(thrum_text_number(&r->text, "the version", &version));
  THRUM_TRY(thrum_text_integer(&r->text, "the kind, 0 for ASCII", 0, INT64_MAX, &binary));
  THRUM_TRY(thrum_text_integer(&r->text, "the size of numbers", 0, INT64_MAX, &size));

  // other versions have other sections
  if (!(version >= 2 && version < 2.3) && version != 4.1)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "version %g is not read, only 2.2 and 4.1; convert it with: gmsh "
                           "FILE -save -format msh41 -o NEW.msh",
                           version);

  r->version = version < 3 ? 2 : 4;
  return binary != 0 ? thrum_msh_byte_order(r) : THRUM_OK;
}

static thrum_status cut_short(msh_reader *r, thrum_word name) {
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                         "the file ends before $End%s; is it cut short?",
                         thrum_text_excerpt(name).text);
}

/* Reads the line $EndNAME right after a section that was read; otherwise its count is wrong. */
static thrum_status end_section(msh_reader *r, thrum_word name) {
  if (!thrum_text_next_line(&r->text))
    return cut_short(r, name);
  const thrum_word line = thrum_text_line(&r->text);
  if (line.length == name.length + 4 && memcmp(line.text, "$End", 4) == 0 &&
      memcmp(line.text + 4, name.text, name.length) == 0)
    return THRUM_OK;
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                         "expected $End%s, found '%s'; is a count too small?",
                         thrum_text_excerpt(name).text, thrum_text_excerpt(line).text);
}

/* Passes over a section that holds nothing of the mesh. Behind bytes Gmsh 2.2 writes $EndNAME
 * without a line of its own, so the word is sought and not the line. */
static thrum_status skip_section(msh_reader *r, thrum_word name) {
  thrum_text *text = &r->text;
  for (const char *at = text->next; text->stop - at >= (ptrdiff_t)name.length + 4; at++) {
    text->line += *at == '\n';
    const char *behind = at + name.length + 4;
    if (*at != '$' || memcmp(at, "$End", 4) != 0 || memcmp(at + 4, name.text, name.length) != 0 ||
        (behind<text->stop && * behind> ' '))
      continue;

    // the text goes on in front of the word, which is then read as a line
    text->next = at;
    return end_section(r, name);
  }
  return cut_short(r, name);
}

static thrum_status read_entities(msh_reader *r) {
  if (r->version != 4)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "$Entities does not belong into a file of version 2");
  if (r->has_entities || r->has_elements)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "$Entities comes twice or after $Elements");
  r->has_entities = true;
  return thrum_msh_entities(r);
}

static thrum_status read_any_nodes(msh_reader *r, bool parametric) {
  if (r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "$Nodes comes twice");
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
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "$Elements comes twice or before $Nodes");
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
  const thrum_word line = thrum_text_line(&r->text);
  const bool format = thrum_text_equals(line, "$MeshFormat");
  if (r->version == 0 && (thrum_text_equals(line, "$NOD") || thrum_text_equals(line, "$ELM")))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "version 1 is not read, only 2.2 and 4.1; convert it with: gmsh FILE "
                           "-save -format msh41 -o NEW.msh");
  if (*line.text != '$' || line.length < 2 || (format == (r->version != 0)))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "expected %s, found '%s'; is it a Gmsh mesh of version 2.2 or 4.1?",
                           r->version ? "a section such as $Nodes" : "$MeshFormat",
                           thrum_text_excerpt(line).text);

  // the parts of a partitioned mesh repeat entities under other tags
  if (thrum_text_equals(line, "$PartitionedEntities"))
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED,
                           "partitioned meshes are not supported; save it unpartitioned");

  // sections that hold nothing of the mesh are passed over
  const thrum_word name = {line.text + 1, line.length - 1};
  for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
    if (thrum_text_equals(line, sections[i].keyword)) {
      THRUM_TRY(sections[i].read(r));
      return end_section(r, name);
    }
  return skip_section(r, name);
}

static thrum_status read_all(msh_reader *r, thrum_mesh *mesh) {
  while (thrum_text_next_line(&r->text))
    THRUM_TRY(read_section(r));

  // a mesh needs both sections, whatever else the file has
  if ((!r->has_nodes || !r->has_elements))
    return thrum_text_fail(&r->text, THRUM_MISSING,
                           "there is no $%s section; is it a Gmsh mesh, and is it whole?",
                           !r->version    ? "MeshFormat"
                           : r->has_nodes ? "Elements"
                                          : "Nodes");

  // materials come from the user, who calls the regions by their physical groups
  THRUM_TRY(thrum_builder_finish(&r->builder, r->text.name, mesh));
  for (int64_t i = 0; i < mesh->region_count && r->builder.tet_count > 0; i++) {
    const int64_t key = r->builder.region_keys[i];
    if (key == MSH_NO_PHYSICAL)
      continue;
    const char *named = r->builder.lists[r->physicals[key].list].name;
    THRUM_TRY(thrum_mesh_name_region(mesh, i, named, strlen(named), r->text.error));
  }
  return THRUM_OK;
}

thrum_status thrum_mesh_parse_msh(const thrum_mesh_source *source, thrum_mesh *mesh,
                                  thrum_error *error) {
  msh_reader r = {.builder = {.error = error,
                              .corners = source->corners,
                              .joins_repeats = true,
                              .keep_solids = source->solids}};
  thrum_mesh read = {0};
  THRUM_TRY(thrum_text_view(source->name, source->data, source->size, 0, 0, &r.text, error));
  const thrum_status status = read_all(&r, &read);
  free(r.physicals);
  free(r.entities);
  free(r.entity_physicals);
  thrum_builder_free(&r.builder);
  return thrum_mesh_deliver(status, &read, mesh);
}
