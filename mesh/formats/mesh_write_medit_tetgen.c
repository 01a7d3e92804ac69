/* Writes the formats that have one number for each vertex: TetGen's .node and .ele, and Medit's
 * .mesh. Groups and regions are numbered from 1; their names are lost. Cost: linear
 * in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

static void count_materials(thrum_mesh_written *w) {
  if (w->mesh->has_material)
    w->lost.materials += w->mesh->region_count;
}

void thrum_mesh_write_node(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int32_t *marks = thrum_write_marks(out, w);
  thrum_out_text(out, "%lld 3 0 %d\n", (long long)m->vertex_count, m->group_count > 0);
  for (int64_t v = 0; v < m->vertex_count && marks; v++) {
    thrum_out_text(out, "%lld ", (long long)v + 1);
    thrum_out_vertex(out, m->vertices + 3 * v, " ");
    if (m->group_count > 0)
      thrum_out_text(out, " %d", (int)marks[v]);
    thrum_out_text(out, "\n");
  }
  free(marks);
  count_materials(w);
}

void thrum_mesh_write_ele(thrum_mesh_out *out, thrum_mesh_written *w) {
  // the first middle node of TetGen lies on the edge 23, and so on
  static const int middles[6] = {5, 3, 0, 1, 4, 2};
  const thrum_mesh *m = w->mesh;
  const bool regions = m->region_count > 1;
  thrum_out_text(out, "%lld %d %d\n", (long long)m->tet_count, m->midsides ? 10 : 4, regions);
  for (int64_t t = 0; t < m->tet_count; t++) {
    thrum_out_text(out, "%lld ", (long long)t + 1);
    int32_t node[10];
    const int count = thrum_mesh_nodes(m, t, node);
    for (int n = 0; n < count; n++)
      thrum_out_text(out, "%lld ", node[n < 4 ? n : 4 + middles[n - 4]] + 1LL);
    if (regions)
      thrum_out_text(out, "%d", (int)m->tet_region[t] + 1);
    thrum_out_text(out, "\n");
  }
}

/* The elements of a form, whose nodes have the order that they have here. */
static void put_list(thrum_mesh_out *out, const thrum_mesh *m, int form, int64_t count) {
  static const char *const keywords[THRUM_FORMS] = {
      [THRUM_FORM_TET4] = "Tetrahedra",    [THRUM_FORM_TET10] = "TetrahedraP2",
      [THRUM_FORM_WEDGE6] = "Prisms",      [THRUM_FORM_HEX8] = "Hexahedra",
      [THRUM_FORM_SHELL6] = "Prisms",      [THRUM_FORM_SHELL8] = "Hexahedra",
      [THRUM_FORM_MEAN10] = "TetrahedraP2"};
  thrum_out_text(out, "%s\n%lld\n", keywords[form], (long long)count);
  for (int64_t e = 0; e < thrum_mesh_element_count(m); e++) {
    const thrum_mesh_element element = thrum_mesh_element_at(m, e);
    if ((int)element.form != form)
      continue;
    for (int a = 0; a < element.count; a++)
      thrum_out_text(out, "%lld ", element.nodes[a] + 1LL);
    thrum_out_text(out, "%d\n", m->region_count > 1 ? (int)element.region + 1 : 0);
  }
}

void thrum_mesh_write_medit(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int32_t *marks = thrum_write_marks(out, w);

  // a vertex carries its group as its reference
  thrum_out_text(out, "MeshVersionFormatted 2\nDimension 3\nVertices\n%lld\n",
                 (long long)m->vertex_count);
  for (int64_t v = 0; v < m->vertex_count && marks; v++) {
    thrum_out_vertex(out, m->vertices + 3 * v, " ");
    thrum_out_text(out, " %d\n", (int)marks[v]);
  }
  free(marks);

  // each form has a list, whose elements carry their region as their reference
  int64_t counts[THRUM_FORMS];
  thrum_mesh_count_forms(m, counts);
  for (int form = 0; form < THRUM_FORMS; form++)
    if (counts[form] > 0)
      put_list(out, m, form, counts[form]);

  thrum_out_text(out, "End\n");
  count_materials(w);
}
