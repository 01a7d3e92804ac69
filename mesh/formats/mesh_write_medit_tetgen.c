/* Writes the formats that have one number for each vertex: TetGen's .node and .ele, and Medit's
 * .mesh. Groups and regions are numbered from 1; their names are lost. Cost: linear
 * in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"

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

/* Writes the nodes of a tet, from 1; `middles` are the edges in the order of the format. */
static void write_nodes(thrum_mesh_out *out, const thrum_mesh *mesh, int64_t t,
                        const int middles[6]) {
  int32_t node[10];
  const int count = thrum_mesh_nodes(mesh, t, node);
  for (int n = 0; n < count; n++)
    thrum_out_text(out, "%lld ", node[n < 4 ? n : 4 + middles[n - 4]] + 1LL);
}

void thrum_mesh_write_ele(thrum_mesh_out *out, thrum_mesh_written *w) {
  // the first middle node of TetGen lies on the edge 23, and so on
  static const int middles[6] = {5, 3, 0, 1, 4, 2};
  const thrum_mesh *m = w->mesh;
  const bool regions = m->region_count > 1;
  thrum_out_text(out, "%lld %d %d\n", (long long)m->tet_count, m->midsides ? 10 : 4, regions);
  for (int64_t t = 0; t < m->tet_count; t++) {
    thrum_out_text(out, "%lld ", (long long)t + 1);
    write_nodes(out, m, t, middles);
    if (regions)
      thrum_out_text(out, "%d", (int)m->tet_region[t] + 1);
    thrum_out_text(out, "\n");
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

  // a tet carries its region as its reference; ten nodes have the order that they have here
  static const int middles[6] = {0, 1, 2, 3, 4, 5};
  thrum_out_text(out, "%s\n%lld\n", m->midsides ? "TetrahedraP2" : "Tetrahedra",
                 (long long)m->tet_count);
  for (int64_t t = 0; t < m->tet_count; t++) {
    write_nodes(out, m, t, middles);
    thrum_out_text(out, "%d\n", m->region_count > 1 ? (int)m->tet_region[t] + 1 : 0);
  }

  thrum_out_text(out, "End\n");
  count_materials(w);
}
