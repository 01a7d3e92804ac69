/* Writes Gmsh's .msh, versions 2.2 and 4.1, ASCII or binary (little-endian). A group is a
 * physical group of points, a region a physical volume that carries the name of the group of just
 * its vertices; one region without such a name is in no physical group. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_read_msh.h"
#include "mesh/formats/mesh_write.h"
#include "mesh/mesh_elements.h"

enum { TYPE_POINT = 15 };

/* Gmsh's types of the forms of solids. */
static const int solid_types[THRUM_FORMS] = {4, 11, 6, 18, 5, 17, 6, 5, 11};

/* Writes a whole number as text with a blank behind, or as bytes, the lowest first. */
static void put_whole(thrum_mesh_out *out, uint64_t value, size_t size) {
  unsigned char bytes[8];
  if (!out->binary) {
    thrum_out_text(out, "%llu ", (unsigned long long)value);
    return;
  }
  for (size_t i = 0; i < size; i++)
    bytes[i] = (unsigned char)(value >> 8 * i & 0xff);
  thrum_out_bytes(out, bytes, size);
}

static void put_real(thrum_mesh_out *out, double value) {
  union {
    double value;
    uint64_t bits;
  } number = {value};
  if (out->binary) {
    put_whole(out, number.bits, 8);
  } else {
    thrum_out_number(out, value);
    thrum_out_text(out, " ");
  }
}

static void end_line(thrum_mesh_out *out) {
  if (!out->binary)
    thrum_out_text(out, "\n");
}

/* Element e with its nodes in Gmsh's order. */
static thrum_mesh_element element_at(const thrum_mesh *mesh, int64_t e) {
  const thrum_mesh_element from = thrum_mesh_element_at(mesh, e);
  thrum_mesh_element element = from;
  const thrum_solid kind = thrum_solid_forms[from.form].kind;
  const int corners = thrum_solid_shapes[kind].corners;
  for (int m = 0; m < from.count - corners; m++)
    element.nodes[thrum_msh_middles[kind][m]] = from.nodes[corners + m];
  return element;
}

/* Returns the physical volume of a region, 0 for none. */
static int64_t region_tag(const thrum_mesh_written *w, int64_t region) {
  return w->mesh->region_count > 1 || w->region_group[region] >= 0 ? region + 1 : 0;
}

static void put_names(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  char name[256];
  int64_t count = 0;

  // the count stands in front of the names
  for (int64_t g = 0; g < m->group_count; g++)
    count += w->group_region[g] < 0;
  for (int64_t i = 0; i < m->region_count; i++)
    count += region_tag(w, i) != 0;

  if (count == 0)
    return;

  // groups are physical points, and regions are physical volumes
  thrum_out_text(out, "$PhysicalNames\n%lld\n", (long long)count);
  for (int64_t g = 0; g < m->group_count; g++)
    if (w->group_region[g] < 0)
      thrum_out_text(out, "0 %lld \"%s\"\n", (long long)g + 1,
                     thrum_write_group_name(w, g, "\"", name));
  for (int64_t i = 0; i < m->region_count; i++)
    if (region_tag(w, i) != 0)
      thrum_out_text(out, "3 %lld \"%s\"\n", (long long)region_tag(w, i),
                     thrum_write_region_name(w, i, "\"", name));

  thrum_out_text(out, "$EndPhysicalNames\n");
}

/* Counts the points of all groups, and the groups. */
static int64_t point_count(const thrum_mesh_written *w, int64_t *groups) {
  int64_t points = 0;
  *groups = 0;
  for (int64_t g = 0; g < w->mesh->group_count; g++)
    if (w->group_region[g] < 0) {
      points += w->mesh->groups[g].count;
      ++*groups;
    }
  return points;
}

/* Writes one element of version 2.2; in binary it has a header of its own. */
static void put_element_2(thrum_mesh_out *out, int64_t number, int type, int64_t physical,
                          int64_t entity, const int32_t *vertices, int nodes) {
  // a header is the type, the number of elements and the number of tags
  if (out->binary) {
    put_whole(out, (uint64_t)type, 4);
    put_whole(out, 1, 4);
    put_whole(out, 2, 4);
  }

  put_whole(out, (uint64_t)number, 4);
  if (!out->binary)
    thrum_out_text(out, "%d 2 ", type);
  put_whole(out, (uint64_t)physical, 4);
  put_whole(out, (uint64_t)entity, 4);
  for (int a = 0; a < nodes; a++)
    put_whole(out, (uint64_t)vertices[a] + 1, 4);
  end_line(out);
}

static void put_body_2(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int64_t groups, number = 0;

  // nodes are numbered from 1 in the order of the mesh
  thrum_out_text(out, "$Nodes\n%lld\n", (long long)m->vertex_count);
  for (int64_t v = 0; v < m->vertex_count; v++) {
    put_whole(out, (uint64_t)v + 1, 4);
    for (int c = 0; c < 3; c++)
      put_real(out, m->vertices[3 * v + c]);
    end_line(out);
  }

  // a physical group consists of elements, so each of its vertices is an element of one node
  const int64_t count = point_count(w, &groups) + thrum_mesh_element_count(m);
  thrum_out_text(out, "%s$EndNodes\n$Elements\n%lld\n", out->binary ? "\n" : "", (long long)count);
  for (int64_t g = 0; g < m->group_count; g++)
    for (int64_t i = 0; i < m->groups[g].count && w->group_region[g] < 0; i++)
      put_element_2(out, ++number, TYPE_POINT, g + 1, g + 1, &m->groups[g].vertices[i], 1);
  for (int64_t e = 0; e < thrum_mesh_element_count(m); e++) {
    const thrum_mesh_element element = element_at(m, e);
    put_element_2(out, ++number, solid_types[element.form], region_tag(w, element.region),
                  element.region + 1LL, element.nodes, element.count);
  }

  thrum_out_text(out, "%s$EndElements\n", out->binary ? "\n" : "");
}

/* Writes `tag box physicals` of the point of a group or the volume of a region. */
static void put_entity(thrum_mesh_out *out, int64_t tag, const double *box, int numbers,
                       int64_t physical) {
  put_whole(out, (uint64_t)tag, 4);
  for (int i = 0; i < numbers; i++)
    put_real(out, box[i]);
  put_whole(out, physical != 0, 8);
  if (physical != 0)
    put_whole(out, (uint64_t)physical, 4);

  // volumes would name their bounding surfaces, of which there are none
  if (numbers == 6)
    put_whole(out, 0, 8);

  end_line(out);
}

static void put_entities(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int64_t groups;
  double box[6] = {0};
  point_count(w, &groups);

  // readers use the box only for display, so all volumes have the box of the body
  for (int64_t i = 0; i < 3 * m->vertex_count; i++) {
    const double x = m->vertices[i];
    box[i % 3] = i < 3 || x < box[i % 3] ? x : box[i % 3];
    box[3 + i % 3] = i < 3 || x > box[3 + i % 3] ? x : box[3 + i % 3];
  }

  // there is a point for each group and a volume for each region, but no curves or surfaces
  thrum_out_text(out, "$Entities\n");
  put_whole(out, (uint64_t)groups, 8);
  put_whole(out, 0, 8);
  put_whole(out, 0, 8);
  put_whole(out, (uint64_t)m->region_count, 8);
  end_line(out);

  // a point entity needs a place, and the first vertex of its group is one
  for (int64_t g = 0; g < m->group_count; g++)
    if (w->group_region[g] < 0)
      put_entity(out, g + 1, m->vertices + 3 * (int64_t)m->groups[g].vertices[0], 3, g + 1);
  for (int64_t i = 0; i < m->region_count; i++)
    put_entity(out, i + 1, box, 6, region_tag(w, i));

  thrum_out_text(out, "%s$EndEntities\n", out->binary ? "\n" : "");
}

static void put_header_4(thrum_mesh_out *out, int64_t blocks, int64_t items) {
  put_whole(out, (uint64_t)blocks, 8);
  put_whole(out, (uint64_t)items, 8);
  put_whole(out, 1, 8);
  put_whole(out, (uint64_t)items, 8);
  end_line(out);
}

static void put_block_4(thrum_mesh_out *out, int dimension, int64_t entity, int type,
                        int64_t count) {
  put_whole(out, (uint64_t)dimension, 4);
  put_whole(out, (uint64_t)entity, 4);
  put_whole(out, (uint64_t)type, 4);
  put_whole(out, (uint64_t)count, 8);
  end_line(out);
}

static void put_nodes_4(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;

  // all nodes are in one block, which has all tags before all positions
  thrum_out_text(out, "$Nodes\n");
  put_header_4(out, 1, m->vertex_count);
  put_block_4(out, 3, 1, 0, m->vertex_count);

  for (int64_t v = 0; v < m->vertex_count; v++) {
    put_whole(out, (uint64_t)v + 1, 8);
    end_line(out);
  }

  for (int64_t v = 0; v < m->vertex_count; v++) {
    for (int c = 0; c < 3; c++)
      put_real(out, m->vertices[3 * v + c]);
    end_line(out);
  }

  thrum_out_text(out, "%s$EndNodes\n", out->binary ? "\n" : "");
}

/* Returns the end of the run of elements that have the region and the type of element e. */
static int64_t run_end(const thrum_mesh *m, int64_t e) {
  const thrum_mesh_element first = thrum_mesh_element_at(m, e);
  for (; e < thrum_mesh_element_count(m); e++) {
    const thrum_mesh_element next = thrum_mesh_element_at(m, e);
    if (next.region != first.region || solid_types[next.form] != solid_types[first.form])
      break;
  }
  return e;
}

static void put_elements_4(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int64_t groups, number = 0, blocks = 0;
  const int64_t elements = thrum_mesh_element_count(m);
  const int64_t count = point_count(w, &groups) + elements;

  // blocks are counted first, since the header stands before them
  for (int64_t e = 0; e < elements; e = run_end(m, e))
    blocks++;

  thrum_out_text(out, "$Elements\n");
  put_header_4(out, groups + blocks, count);

  // each vertex of a group is an element of one node
  for (int64_t g = 0; g < m->group_count; g++) {
    if (w->group_region[g] >= 0)
      continue;
    put_block_4(out, 0, g + 1, TYPE_POINT, m->groups[g].count);
    for (int64_t i = 0; i < m->groups[g].count; i++) {
      put_whole(out, (uint64_t)++number, 8);
      put_whole(out, (uint64_t)m->groups[g].vertices[i] + 1, 8);
      end_line(out);
    }
  }

  // a block has one region and type; a block for each run keeps the elements in their order
  for (int64_t e = 0; e < elements;) {
    const int64_t end = run_end(m, e);
    const thrum_mesh_element first = thrum_mesh_element_at(m, e);
    put_block_4(out, 3, first.region + 1LL, solid_types[first.form], end - e);
    for (; e < end; e++) {
      const thrum_mesh_element element = element_at(m, e);
      put_whole(out, (uint64_t)++number, 8);
      for (int a = 0; a < element.count; a++)
        put_whole(out, (uint64_t)element.nodes[a] + 1, 8);
      end_line(out);
    }
  }

  thrum_out_text(out, "%s$EndElements\n", out->binary ? "\n" : "");
}

void thrum_mesh_write_msh(thrum_mesh_out *out, thrum_mesh_written *w) {
  const bool old = w->options.msh_version == 22;
  out->binary = w->options.binary;
  thrum_out_text(out, "$MeshFormat\n%s %d 8\n", old ? "2.2" : "4.1", out->binary);

  // a number 1 tells readers the order of the bytes
  if (out->binary) {
    put_whole(out, 1, 4);
    thrum_out_text(out, "\n");
  }

  thrum_out_text(out, "$EndMeshFormat\n");

  // version 4 refers to physical groups through entities
  put_names(out, w);
  if (old) {
    put_body_2(out, w);
  } else {
    put_entities(out, w);
    put_nodes_4(out, w);
    put_elements_4(out, w);
  }

  if (w->mesh->has_material)
    w->lost.materials += w->mesh->region_count;
}
