/* Reads Gmsh .msh files, versions 2.2 and 4.1, in ASCII (groups, nodes and elements in
 * mesh_read_msh_groups.c, _nodes.c and _elements.c; binary sections in mesh_read_msh_binary.c):
 * $PhysicalNames, $Entities, $Nodes, $Elements; other sections are passed over. Tetrahedra (type 4)
 * are the mesh. Physical volumes are its regions; physical groups of any dimension are vertex
 * groups. Version 2 writes an element once for each physical group that it is in: tets that come
 * again are joined with the first. Vertices are ordered by their tags, which may have gaps. Cost:
 * linear in the file, n log n in the nodes when they are not in order.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/formats/mesh_read_msh.h"
#include "mesh/mesh_groups.h"
#include "mesh/tet_repeats.h"

static thrum_status read_format(msh_reader *r) {
  THRUM_TRY(thrum_msh_line(r, "the version"));

  double version = 0;
  int64_t binary = 0, size = 8;
  THRUM_TRY(thrum_text_number(&r->text, "the version", &version, r->error));
  THRUM_TRY(thrum_msh_integer(r, "the kind, 0 for ASCII", 0, &binary));
  THRUM_TRY(thrum_msh_integer(r, "the size of numbers", 0, &size));

  // other versions have other sections
  if (!(version >= 2 && version < 2.3) && version != 4.1)
    return thrum_text_fail(&r->text, THRUM_UNSUPPORTED, r->error,
                           "version %g is not read, only 2.2 and 4.1; convert it with: gmsh "
                           "FILE -save -format msh41 -o NEW.msh",
                           version);

  r->version = version < 3 ? 2 : 4;
  return binary != 0 ? thrum_msh_binary_format(r) : THRUM_OK;
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
  return r->binary ? thrum_msh_binary_entities(r) : thrum_msh_text_entities(r);
}

static thrum_status read_any_nodes(msh_reader *r, bool parametric) {
  if (r->has_nodes)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error, "$Nodes comes twice");
  r->has_nodes = true;
  THRUM_TRY(r->binary ? thrum_msh_binary_nodes(r) : thrum_msh_text_nodes(r, parametric));
  return thrum_msh_index_nodes(r);
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
  return r->binary ? thrum_msh_binary_elements(r) : thrum_msh_text_elements(r);
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

/* Keeps the first of repeated tets; their vertices are in all of their physical groups already. */
static thrum_status join_repeats(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  int64_t *earlier = thrum_mesh_tet_repeats(m), kept = 0;
  if (!earlier)
    return thrum_msh_no_memory(r);

  // the tets that are kept move up, with their lines and regions
  for (int64_t t = 0; t < m->tet_count; t++) {
    if (earlier[t] >= 0)
      continue;
    memmove(m->tets + 4 * kept, m->tets + 4 * t, 4 * sizeof *m->tets);
    m->tet_line[kept] = m->tet_line[t];
    m->tet_region[kept++] = m->tet_region[t];
  }

  m->tet_count = kept;
  free(earlier);
  return THRUM_OK;
}

/* Numbers the regions: the physical volumes that tets are in, and one region for tets in none. */
static thrum_status number_regions(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  int32_t *region = malloc((size_t)(r->physical_count + 1) * sizeof *region);
  if (!region)
    return thrum_msh_no_memory(r);

  // mark the physical volumes that have tets; entry 0 stands for tets in none
  for (int64_t i = 0; i <= r->physical_count; i++)
    region[i] = -1;
  for (int64_t t = 0; t < m->tet_count; t++)
    region[m->tet_region[t] + 1] = 0;

  // regions are numbered in the order of the physical groups
  for (int64_t i = 0; i <= r->physical_count; i++)
    if (region[i] == 0)
      region[i] = (int32_t)m->region_count++;

  for (int64_t t = 0; t < m->tet_count; t++)
    m->tet_region[t] = region[m->tet_region[t] + 1];
  free(region);

  // materials come from the user, but each region has a place for one
  m->region_count = m->region_count > 0 ? m->region_count : 1;
  m->materials = calloc((size_t)m->region_count, sizeof *m->materials);
  return m->materials ? THRUM_OK : thrum_msh_no_memory(r);
}

static thrum_status take_nodes(msh_reader *r) {
  thrum_mesh *m = &r->mesh;
  m->vertices = malloc(((size_t)r->node_count + 1) * 3 * sizeof *m->vertices);
  m->file_number = malloc(((size_t)r->node_count + 1) * sizeof *m->file_number);
  if (!m->vertices || !m->file_number)
    return thrum_msh_no_memory(r);

  m->vertex_count = m->file_vertex_count = r->node_count;
  for (int64_t i = 0; i < r->node_count; i++) {
    memcpy(m->vertices + 3 * i, r->nodes[i].position, 3 * sizeof(double));
    m->file_number[i] = r->nodes[i].tag;
  }
  return THRUM_OK;
}

static thrum_status add_groups(msh_reader *r) {
  for (int64_t i = 0; i < r->physical_count; i++) {
    const msh_physical *p = &r->physicals[i];
    char made[64];
    snprintf(made, sizeof made, "physical_%d_%lld", p->dimension, (long long)p->tag);
    THRUM_TRY(
        thrum_mesh_add_group(&r->mesh, p->name ? p->name : made, p->vertices, p->count, r->error));
  }
  return THRUM_OK;
}

static thrum_status read_all(msh_reader *r) {
  while (thrum_text_next_line(&r->text))
    THRUM_TRY(read_section(r));

  // a mesh needs both sections, whatever else the file has
  if ((!r->has_nodes || !r->has_elements))
    return thrum_text_fail(&r->text, THRUM_MISSING, r->error,
                           "there is no $%s section; is it a Gmsh mesh, and is it whole?",
                           !r->version    ? "MeshFormat"
                           : r->has_nodes ? "Elements"
                                          : "Nodes");

  // repeats are joined before the regions are numbered, so that they count once
  THRUM_TRY(join_repeats(r));
  THRUM_TRY(number_regions(r));
  THRUM_TRY(take_nodes(r));
  return add_groups(r);
}

thrum_status thrum_mesh_parse_msh(const char *name, const void *data, size_t size, thrum_mesh *mesh,
                                  thrum_error *error) {
  msh_reader r = {.error = error};
  THRUM_TRY(thrum_text_view(name, data, size, 0, 0, &r.text, error));

  r.physicals = malloc(THRUM_MESH_GROUPS_MAX * sizeof *r.physicals);
  thrum_status status = r.physicals ? read_all(&r) : thrum_msh_no_memory(&r);

  for (int64_t i = 0; i < r.physical_count; i++) {
    free(r.physicals[i].name);
    free(r.physicals[i].vertices);
  }
  free(r.physicals);
  free(r.entities);
  free(r.entity_physicals);
  free(r.nodes);
  free(r.table);
  thrum_text_close(&r.text);

  // the caller's mesh changes only when all went well
  if (status >= 0)
    *mesh = r.mesh;
  else
    thrum_mesh_free(&r.mesh);
  return status;
}
