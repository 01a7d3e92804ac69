/* The elements of a mesh, see mesh_elements.h. Cost: constant for each.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/mesh_elements.h"

#include <string.h>

int64_t thrum_mesh_element_count(const thrum_mesh *mesh) {
  return mesh->solid_count > 0 ? mesh->solid_count : mesh->tet_count;
}

int32_t thrum_mesh_element_region(const thrum_mesh *mesh, int64_t e) {
  return mesh->tet_region[mesh->solid_count == 0 ? e : thrum_mesh_solid_tet(mesh, e)];
}

int64_t thrum_mesh_element_number(const thrum_mesh *mesh, int64_t e) {
  if (!mesh->tet_number)
    return e + 1;
  return mesh->tet_number[mesh->solid_count == 0 ? e : thrum_mesh_solid_tet(mesh, e)];
}

thrum_mesh_element thrum_mesh_element_at(const thrum_mesh *mesh, int64_t e) {
  thrum_mesh_element element = {.region = thrum_mesh_element_region(mesh, e)};
  if (mesh->solid_count == 0) {
    element.form = mesh->midsides ? THRUM_FORM_TET10 : THRUM_FORM_TET4;
    element.count = thrum_mesh_nodes(mesh, e, element.nodes);
    return element;
  }
  element.form = (thrum_solid_form)mesh->solid_form[e];
  element.count = thrum_solid_forms[element.form].nodes;
  memcpy(element.nodes, mesh->solid_nodes + mesh->solid_ends[e] - element.count,
         (size_t)element.count * sizeof *element.nodes);
  return element;
}

void thrum_mesh_count_forms(const thrum_mesh *mesh, int64_t counts[THRUM_FORMS]) {
  memset(counts, 0, THRUM_FORMS * sizeof *counts);
  if (mesh->solid_count == 0)
    counts[mesh->midsides ? THRUM_FORM_TET10 : THRUM_FORM_TET4] = mesh->tet_count;
  for (int64_t e = 0; e < mesh->solid_count; e++)
    counts[mesh->solid_form[e]]++;
}
