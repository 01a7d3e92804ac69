/* Reads decks of Abaqus and CalculiX (.inp), as far as they describe a body.
 *
 * Nodes: *NODE (R, C), *SYSTEM, *NGEN, *NFILL, *NCOPY. Elements: *ELEMENT (C3D4, C3D10, and C3D5,
 * C3D6, C3D8, C3D15, C3D20, which are cut into tets), *ELGEN, *ELCOPY. Sets: *NSET, *ELSET, with
 * GENERATE. *MATERIAL with *ELASTIC and *DENSITY, *SOLID SECTION. *INCLUDE, and INPUT= of all
 * these. Keywords, parameters and names in any case; ** comments; what other keywords mean stands
 * in mesh_read_abaqus_materials.c. Node sets and the nodes of element sets, those of surface
 * elements too, are groups; solid sections are the regions, or else the sets
 * (mesh_read_abaqus_sets.c). The element set allElements is no group. A file holds one part, and
 * one *INSTANCE of it, which is put where that says; nodes and sets of an *ASSEMBLY that belong to
 * no instance, such as reference points, are passed over. Cost: linear in the file and in what its
 * keywords make.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "mesh/formats/mesh_read_abaqus.h"

/* Parts, instances and the assembly, whose numbers of nodes are each its own. */
static thrum_status enter_or_leave(inp_reader *r, const inp_keyword *keyword) {
  const thrum_word name = keyword->name;
  if (inp_is(name, "PART") && ++r->part_count > 1)
    return thrum_text_fail(inp_text(r), THRUM_BAD_FORMAT,
                           "there are several parts; save each as a file of its own");
  if (inp_is(name, "ASSEMBLY") || inp_is(name, "END ASSEMBLY"))
    r->in_assembly = inp_is(name, "ASSEMBLY");
  if (inp_is(name, "END INSTANCE"))
    r->in_instance = false;
  if (inp_is(name, "STEP"))
    r->in_step = true;

  // a system of nodes ends with the part that it stands in
  if (inp_is(name, "PART") || inp_is(name, "END PART") || inp_is(name, "END INSTANCE"))
    r->system.active = false;
  return THRUM_OK;
}

static thrum_status obey(inp_reader *r, const inp_keyword *keyword) {
  static const struct {
    const char *name;
    inp_read *read;
    bool makes; /* nodes or elements */
  } keywords[] = {
      {"NODE", inp_read_nodes, true},         {"SYSTEM", inp_read_system, true},
      {"NGEN", inp_generate_nodes, true},     {"NFILL", inp_fill_nodes, true},
      {"NCOPY", inp_copy_nodes, true},        {"ELEMENT", inp_read_elements, true},
      {"ELGEN", inp_generate_elements, true}, {"ELCOPY", inp_copy_elements, true},
      {"NSET", inp_read_node_set, false},     {"ELSET", inp_read_element_set, false},
      {"MATERIAL", inp_read_material, false}, {"ELASTIC", inp_read_property, false},
      {"DENSITY", inp_read_property, false},  {"SOLID SECTION", inp_read_section, false},
      {"INSTANCE", inp_read_instance, false}, {"ORIENTATION", inp_read_orientation, false}};

  // nodes and elements of the assembly alone are reference points and the like
  r->beside_body = r->in_assembly && !r->in_instance && !inp_has_parameter(keyword, "INSTANCE");
  for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++) {
    if (!inp_is(keyword->name, keywords[i].name))
      continue;
    const bool property = keywords[i].read == inp_read_property;
    r->in_material = property ? r->in_material : keywords[i].read == inp_read_material;
    if (keywords[i].makes && r->beside_body)
      return THRUM_OK;
    THRUM_TRY(inp_open_input(r, keyword));
    return keywords[i].read(r, keyword);
  }
  THRUM_TRY(enter_or_leave(r, keyword));
  return inp_pass_over(r, keyword);
}

/* Reads all keywords and their lines. */
static thrum_status read_keywords(inp_reader *r) {
  while (inp_next_line(r)) {
    inp_keyword keyword;
    if (*inp_text(r)->start != '*')
      return thrum_text_fail(
          inp_text(r), THRUM_BAD_FORMAT,
          "expected a keyword such as *NODE, found '%s'; is it an Abaqus input file?",
          thrum_text_excerpt(thrum_text_line(inp_text(r))).text);

    inp_read_keyword(r, &keyword);
    THRUM_TRY(obey(r, &keyword));
    // data lines of other keywords are passed over
    while (inp_data_line(r))
      continue;
  }
  return r->broken;
}

static thrum_status read_all(inp_reader *r, thrum_mesh *mesh) {
  THRUM_TRY(read_keywords(r));
  if (r->builder.vertex_count == 0 || r->solid_count == 0)
    return thrum_text_fail(inp_text(r), THRUM_MISSING, "there is no %s; is the file whole?",
                           r->builder.vertex_count == 0 ? "*NODE" : "*ELEMENT of type C3D4");

  // sections and sets may name elements that came later
  int64_t index;
  THRUM_TRY(inp_find_element(r, 0, &index));
  THRUM_TRY(inp_find_regions(r, mesh));
  THRUM_TRY(inp_build_elements(r));
  THRUM_TRY(inp_set_groups(r, mesh));
  THRUM_TRY(inp_place_instance(r));
  THRUM_TRY(thrum_builder_finish(&r->builder, r->files.files[0].path, mesh));
  THRUM_TRY(inp_region_materials(r, mesh));
  inp_note_remarks(r, mesh);
  return THRUM_OK;
}

thrum_status thrum_mesh_parse_abaqus(const thrum_mesh_source *source, thrum_mesh *mesh,
                                     thrum_error *error) {
  inp_reader r = {
      .builder = {.error = error, .corners = source->corners, .keep_solids = source->solids},
      .error = error};
  thrum_mesh read = {0};
  thrum_status status = thrum_included_begin(&r.files, source, 0, ',', error);
  THRUM_THEN(status, read_all(&r, &read));

  // a file that could not be taken in is the reason of all that followed
  if (r.broken < 0) {
    status = r.broken;
    if (error)
      *error = r.failure;
  }

  // what the reader gathered on the way
  for (int64_t s = 0; s < r.set_count; s++)
    free(r.sets[s].elements);
  free(r.sets);
  free(r.elements);
  free(r.nodes);
  free(r.unsorted);
  free(r.lists);
  free(r.materials);
  free(r.sections);
  free(r.orientations);
  thrum_number_map_free(&r.node_map);
  thrum_number_map_free(&r.element_map);
  thrum_builder_free(&r.builder);
  thrum_included_end(&r.files);
  return thrum_mesh_deliver(status, &read, mesh);
}
