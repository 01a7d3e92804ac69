/* Writes Vega's .veg. Its sets consist of elements: a group is written as the set of the tets that
 * lie in it, if they have all of its vertices. Regions are written with their materials; without
 * materials they are sets. Cost: linear in the mesh, for every set.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>

#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"

static const char BAD[] = ",#*";

static bool lies_in(const thrum_mesh *m, int64_t t, const uint8_t *mark) {
  const int32_t *v = m->tets + 4 * t;
  return mark[v[0]] && mark[v[1]] && mark[v[2]] && mark[v[3]];
}

/* Writes a group as the tets in it; returns false when they do not have all of its vertices. */
static bool put_group(thrum_mesh_out *out, thrum_mesh_written *w, int64_t g, uint8_t *mark) {
  const thrum_mesh *m = w->mesh;

  // the vertices are marked, so that each tet is checked in constant time
  thrum_write_mark_group(m, g, mark);

  // a set holds elements, so only a group that tets cover can be written as one
  int64_t covered = 0;
  int column = 0;
  for (int64_t t = 0; t < m->tet_count; t++) {
    if (!lies_in(m, t, mark))
      continue;
    for (int a = 0; a < 4; a++) {
      uint8_t *seen = &mark[m->tets[4 * t + a]];
      covered += *seen == 1;
      *seen = 2;
    }
  }

  if (covered < m->groups[g].count)
    return false;

  char name[256];
  thrum_out_text(out, "\n*SET %s\n", thrum_write_group_name(w, g, BAD, name));
  for (int64_t t = 0; t < m->tet_count; t++)
    if (lies_in(m, t, mark))
      thrum_out_member(out, t + 1, &column);
  thrum_out_end_members(out, column);
  return true;
}

/* Writes the set of a region's tets and its material; one region of all tets needs no set. */
static void put_region(thrum_mesh_out *out, thrum_mesh_written *w, int64_t region) {
  const thrum_mesh *m = w->mesh;
  const int64_t group = w->region_group[region];
  char name[256] = "allElements";

  // all tets together are the set allElements, which always exists
  if (m->region_count > 1 || group >= 0) {
    thrum_write_region_name(w, region, BAD, name);
    thrum_out_text(out, "\n*SET %s\n", name);
    thrum_out_region_elements(out, m, region);
  }

  // a region of the file joins a set with a material, so it needs one
  if (!m->has_material)
    return;

  const thrum_material *material = &m->materials[region];
  thrum_out_text(out, "\n*MATERIAL material_%lld\nENU, ", (long long)region + 1);
  thrum_out_number(out, material->density);
  thrum_out_text(out, ", ");
  thrum_out_number(out, material->young);
  thrum_out_text(out, ", ");
  thrum_out_number(out, material->poisson);
  thrum_out_text(out, "\n\n*REGION\n%s, material_%lld\n", name, (long long)region + 1);
}

void thrum_mesh_write_veg(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  uint8_t *mark = NULL;
  if (!thrum_out_reserve(out, &mark, m->vertex_count, 1))
    return;

  thrum_out_text(out, "*VERTICES\n%lld 3 0 0\n", (long long)m->vertex_count);
  for (int64_t v = 0; v < m->vertex_count; v++) {
    thrum_out_text(out, "%lld ", (long long)v + 1);
    thrum_out_vertex(out, m->vertices + 3 * v, " ");
    thrum_out_text(out, "\n");
  }

  thrum_out_text(out, "\n*ELEMENTS\nTET\n%lld 4 0\n", (long long)m->tet_count);
  for (int64_t t = 0; t < m->tet_count; t++) {
    const int32_t *v = m->tets + 4 * t;
    thrum_out_text(out, "%lld %lld %lld %lld %lld\n", (long long)t + 1, v[0] + 1LL, v[1] + 1LL,
                   v[2] + 1LL, v[3] + 1LL);
  }

  // a group that stands for a region is written with the region
  for (int64_t i = 0; i < m->region_count; i++)
    put_region(out, w, i);
  for (int64_t g = 0; g < m->group_count; g++)
    if (w->group_region[g] < 0)
      w->lost.groups += !put_group(out, w, g, mark);

  // regions without materials come back as sets, which is a loss to report
  if (!m->has_material && m->region_count > 1)
    w->lost.regions += m->region_count;
  free(mark);
}
