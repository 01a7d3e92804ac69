/* Writes meshes as VTK's XML files (.vtu). Cell data: `region`, and with materials `young`,
 * `poisson`, `density`; point data: 0 and 1 for each group. Cost: linear in the mesh, for every
 * group.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "io/vtu_grid.h"
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

enum { CELL_ARRAYS = 4 };

/* The values of one group or of one property of the material at a time. */
typedef struct made_values {
  const thrum_mesh *mesh;
  void *values; /* room for a byte a vertex and a double an element */
} made_values;

static const void *make_values(void *context, int64_t index) {
  const made_values *made = context;
  const thrum_mesh *m = made->mesh;
  if (index < m->group_count) {
    // marks of the group's vertices
    thrum_write_mark_group(m, index, made->values);
    return made->values;
  }

  // behind the groups stands `region`, then the material
  double *values = made->values;
  int32_t *regions = made->values;
  const int64_t property = index - m->group_count - 1;
  for (int64_t e = 0; e < thrum_mesh_element_count(m); e++) {
    const int32_t region = thrum_mesh_element_region(m, e);
    const thrum_material *material = &m->materials[region];
    if (property < 0)
      regions[e] = region;
    else
      values[e] = property == 0   ? material->young
                  : property == 1 ? material->poisson
                                  : material->density;
  }
  return values;
}

void thrum_mesh_write_vtu(thrum_mesh_out *out, thrum_mesh_written *w) {
  static const char *const properties[] = {"young", "poisson", "density"};
  const thrum_mesh *m = w->mesh;
  made_values made = {.mesh = m};
  int64_t count = 0;
  const int64_t elements = thrum_mesh_element_count(m);
  const int64_t most = m->vertex_count + elements * (int64_t)sizeof(double);
  vtu_array *arrays = NULL;
  if (!thrum_out_reserve(out, &arrays, m->group_count + CELL_ARRAYS, sizeof *arrays) ||
      !thrum_out_reserve(out, &made.values, most, 1))
    goto cleanup;

  // groups on the points, regions and materials on the cells
  for (int64_t g = 0; g < m->group_count; g++)
    arrays[count++] = (vtu_array){m->groups[g].name, VTU_UINT8, 1, false, NULL};
  arrays[count++] = (vtu_array){"region", VTU_INT32, 1, true, NULL};
  for (int n = 0; n < 3 && m->has_material; n++)
    arrays[count++] = (vtu_array){properties[n], VTU_FLOAT64, 1, true, NULL};

  const vtu_grid grid = {.point_count = m->vertex_count,
                         .tet_count = m->tet_count,
                         .points = m->vertices,
                         .tets = m->tets,
                         .midsides = m->midsides,
                         .solid_count = m->solid_count,
                         .solid_form = m->solid_form,
                         .solid_ends = m->solid_ends,
                         .solid_nodes = m->solid_nodes,
                         .arrays = arrays,
                         .array_count = count,
                         .ascii = w->options.ascii,
                         .make_values = make_values,
                         .context = &made};

  // the grid goes past the buffer, straight to the stream
  thrum_out_flush(out);
  if (out->status >= 0)
    vtu_grid_write(out->file.stream, &grid);

cleanup:
  free(arrays);
  free(made.values);
}
