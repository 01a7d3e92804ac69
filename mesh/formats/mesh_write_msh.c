/* Writes Gmsh's .msh, versions 2.2 and 4.1, ASCII or binary (little-endian). A group is a
 * physical group of points, a region a physical volume that carries the name of the group of just
 * its vertices; one region without such a name is in no physical group. Cost: linear in the mesh.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_out.h"
#include "mesh/formats/mesh_write.h"

enum { TYPE_POINT = 15, TYPE_TET = 4, TYPE_TET_10 = 11 };

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

/* The nodes of a tet in Gmsh's order, which has the middle nodes of edges 23 and 13 the other way
 * round; returns how many. */
static int tet_nodes(const thrum_mesh *mesh, int64_t t, int32_t nodes[10]) {
  const int count = thrum_mesh_nodes(mesh, t, nodes);
  if (count == 10) {
    const int32_t swap = nodes[8];
    nodes[8] = nodes[9];
    nodes[9] = swap;
  }
  return count;
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
                          int64_t entity, const int32_t *vertices) {
  const int nodes = type == TYPE_TET ? 4 : type == TYPE_TET_10 ? 10 : 1;

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
  const int64_t count = point_count(w, &groups) + m->tet_count;
  thrum_out_text(out, "%s$EndNodes\n$Elements\n%lld\n", out->binary ? "\n" : "", (long long)count);
  for (int64_t g = 0; g < m->group_count; g++)
    for (int64_t i = 0; i < m->groups[g].count && w->group_region[g] < 0; i++)
      put_element_2(out, ++number, TYPE_POINT, g + 1, g + 1, &m->groups[g].vertices[i]);
  for (int64_t t = 0; t < m->tet_count; t++) {
    int32_t nodes[10];
    const int type = tet_nodes(m, t, nodes) == 10 ? TYPE_TET_10 : TYPE_TET;
    put_element_2(out, ++number, type, region_tag(w, m->tet_region[t]), m->tet_region[t] + 1LL,
                  nodes);
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

/* Returns the end of the run of tets that are in the region of tet t. */
static int64_t run_end(const thrum_mesh *m, int64_t t) {
  const int32_t region = m->tet_region[t];
  while (t < m->tet_count && m->tet_region[t] == region)
    t++;
  return t;
}

static void put_elements_4(thrum_mesh_out *out, thrum_mesh_written *w) {
  const thrum_mesh *m = w->mesh;
  int64_t groups, number = 0, blocks = 0;
  const int64_t count = point_count(w, &groups) + m->tet_count;

  // blocks are counted first, since the header stands before them
  for (int64_t t = 0; t < m->tet_count; t = run_end(m, t))
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

  // a block has one region; a block for each run keeps the tets in their order
  for (int64_t t = 0; t < m->tet_count;) {
    const int64_t end = run_end(m, t);
    put_block_4(out, 3, m->tet_region[t] + 1LL, m->midsides ? TYPE_TET_10 : TYPE_TET, end - t);
    for (; t < end; t++) {
      put_whole(out, (uint64_t)++number, 8);
      int32_t nodes[10];
      const int nodes_count = tet_nodes(m, t, nodes);
      for (int a = 0; a < nodes_count; a++)
        put_whole(out, (uint64_t)nodes[a] + 1, 8);
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
