/* The surface of a reduced model: triangles, edges, and a tree of spheres (thrum/contact_pairs.h).
 *
 * Each node has a middle c and the mean row block U_c of its vertices. A vertex v below it is at
 * X_v + U_v q, hence no further from c + U_c q than
 *
 *   max |X_v - c| + sum_i max |U_v,i - U_c,i| |q_i|,
 *
 * which costs 4 r a node, whatever the number of vertices below it. Source: James & Pai 2004,
 * BD-tree: output-sensitive collision detection for reduced deformable models,
 * doi:10.1145/1015706.1015735. Cost of making it: n log n.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_skin.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "core/base/alignment_check.h"
#include "core/base/vec3.h"

#define SKIN_MAGIC UINT64_C(0x7468726d736b3031)

/* Nodes of a tree over so many triangles, which are halved. */
static int64_t nodes_of(int64_t triangles) {
  return triangles <= THRUM_SKIN_LEAF
             ? 1
             : 1 + nodes_of(triangles / 2) + nodes_of(triangles - triangles / 2);
}

thrum_skin_view thrum_skin_view_of(const thrum_skin *skin) {
  const int64_t vertex_count = skin->vertex_count, triangle_count = skin->triangle_count;
  const int64_t node_count = skin->node_count, rank = skin->rank;
  unsigned char *at = (unsigned char *)(uintptr_t)skin + thrum_round_up(sizeof *skin);
  thrum_skin_view view;
#define X(type, name, count)                                                                       \
  view.name = (type *)(void *)at;                                                                  \
  at += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_SKIN_ARRAYS(X)
#undef X
  return view;
}

static size_t bytes_of(const thrum_skin *skin) {
  const int64_t vertex_count = skin->vertex_count, triangle_count = skin->triangle_count;
  const int64_t node_count = skin->node_count, rank = skin->rank;
  size_t size = thrum_round_up(sizeof *skin);
#define X(type, name, count) size += thrum_round_up((size_t)(count) * sizeof(type));
  THRUM_SKIN_ARRAYS(X)
#undef X
  return size;
}

static thrum_status check(const thrum_model *model, const int32_t *triangles, int64_t count,
                          thrum_error *error) {
  if (!model || !triangles || count < 1 || count > (INT64_C(1) << 28))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a skin needs a model and 1 to 2^28 triangles");
  if (!model->basis || !model->vertices || model->rank < 0)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no basis, so it has no surface: precompute it from a "
                           "mesh");
  if (!model->material || model->region_count < 1)
    return thrum_error_set(error, THRUM_MISSING,
                           "the model has no material, which says how stiff its surface is");

  // indices are read without a test later
  for (int64_t n = 0; n < 3 * count; n++)
    if (triangles[n] < 0 || triangles[n] >= model->vertex_count)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "a triangle names vertex %lld; the model has %lld",
                             (long long)triangles[n], (long long)model->vertex_count);
  return THRUM_OK;
}

static thrum_skin header_of(const thrum_model *model, int64_t triangle_count) {
  thrum_skin header = {.magic = SKIN_MAGIC,
                       .vertex_count = model->vertex_count,
                       .triangle_count = triangle_count,
                       .node_count = nodes_of(triangle_count),
                       .rank = model->rank};
  header.bytes = bytes_of(&header);
  return header;
}

thrum_status thrum_skin_size(const thrum_model *model, const int32_t *triangles,
                             int64_t triangle_count, size_t *size, thrum_error *error) {
  THRUM_TRY(check(model, triangles, triangle_count, error));
  if (!size)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "size is NULL");
  *size = (size_t)header_of(model, triangle_count).bytes;
  return THRUM_OK;
}

/* --- edges ------------------------------------------------------------------------------------ */

/* The third vertex of a triangle after edge `n`, which runs from corner n to the next. */
static int32_t third(const thrum_skin_triangle *triangle, int n) {
  return triangle->corners[(n + 2) % 3];
}

/* Finds the edges by the lists of triangles around their lower ends, which are chained through
 * `opposite` and first ends until all are known. Cost: triangles times the edges of a vertex. */
static void make_edges(thrum_skin *skin, int32_t *heads, int32_t *nexts) {
  const thrum_skin_view view = thrum_skin_view_of(skin);
  for (int64_t v = 0; v < skin->vertex_count; v++)
    heads[v] = -1;

  for (int64_t t = 0; t < skin->triangle_count; t++) {
    thrum_skin_triangle *triangle = view.triangles + t;
    for (int n = 0; n < 3; n++) {
      const int32_t a = triangle->corners[n], b = triangle->corners[(n + 1) % 3];
      const int32_t low = a < b ? a : b, high = a < b ? b : a;

      // an edge that another triangle has had, or a new one
      int32_t e = heads[low];
      while (e >= 0 && (view.edges[e].ends[1] != high || view.edges[e].opposite[1] >= 0))
        e = nexts[e];
      if (e >= 0) {
        view.edges[e].opposite[1] = third(triangle, n);
      } else {
        e = (int32_t)skin->edge_count++;
        view.edges[e] = (thrum_skin_edge){{low, high}, {third(triangle, n), -1}};
        nexts[e] = heads[low];
        heads[low] = e;
        triangle->tried |= THRUM_SKIN_EDGE << n;
      }
      triangle->edges[n] = e;
    }
  }
}

/* The neighbours of each vertex along its edges. */
static void make_rings(const thrum_skin *skin) {
  const thrum_skin_view view = thrum_skin_view_of(skin);
  for (int64_t e = 0; e < skin->edge_count; e++)
    for (int end = 0; end < 2; end++)
      view.ring_begins[view.edges[e].ends[end] + 1]++;
  for (int64_t v = 0; v < skin->vertex_count; v++)
    view.ring_begins[v + 1] += view.ring_begins[v];

  // where each ring is filled up to
  memcpy(view.heads, view.ring_begins, (size_t)skin->vertex_count * sizeof *view.heads);
  for (int64_t e = 0; e < skin->edge_count; e++)
    for (int end = 0; end < 2; end++)
      view.rings[view.heads[view.edges[e].ends[end]]++] = view.edges[e].ends[1 - end];
}

/* Each vertex is tried by the first triangle that has it. */
static void share_vertices(const thrum_skin *skin, int32_t *seen) {
  const thrum_skin_view view = thrum_skin_view_of(skin);
  for (int64_t v = 0; v < skin->vertex_count; v++)
    seen[v] = 0;
  for (int64_t t = 0; t < skin->triangle_count; t++)
    for (int n = 0; n < 3; n++) {
      int32_t *vertex = seen + view.triangles[t].corners[n];
      if (*vertex == 0)
        view.triangles[t].tried |= 1 << n;
      *vertex = 1;
    }
}

/* --- tree ------------------------------------------------------------------------------------- */

/* The sum of the corners of a triangle along an axis, by which triangles are halved. */
static double place_of(const thrum_skin_view *view, int64_t triangle, int axis) {
  const int32_t *corners = view->triangles[triangle].corners;
  double sum = 0.0;
  for (int n = 0; n < 3; n++)
    sum += view->rest[3 * (int64_t)corners[n] + axis];
  return sum;
}

static void swap(thrum_skin_triangle *a, thrum_skin_triangle *b) {
  const thrum_skin_triangle kept = *a;
  *a = *b;
  *b = kept;
}

/* Orders the triangles so that no one before `middle` lies behind one after it (Hoare's
 * selection). */
static void halve(const thrum_skin_view *view, int64_t from, int64_t to, int64_t middle, int axis) {
  while (to - from > 1) {
    const double pivot = place_of(view, from + (to - from) / 2, axis);
    int64_t i = from, j = to - 1;
    while (i <= j) {
      while (place_of(view, i, axis) < pivot)
        i++;
      while (place_of(view, j, axis) > pivot)
        j--;
      if (i <= j) {
        swap(view->triangles + i, view->triangles + j);
        i++;
        j--;
      }
    }

    // go on in the part that holds the middle
    if (middle <= j)
      to = j + 1;
    else if (middle >= i)
      from = i;
    else
      return;
  }
}

/* The box of the corners of some triangles; returns its longest axis. */
static int box_of(const thrum_skin_view *view, int64_t from, int64_t to, double middle[3]) {
  double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int64_t t = from; t < to; t++)
    for (int n = 0; n < 3; n++)
      for (int axis = 0; axis < 3; axis++) {
        const double x = view->rest[3 * (int64_t)view->triangles[t].corners[n] + axis];
        least[axis] = fmin(least[axis], x);
        most[axis] = fmax(most[axis], x);
      }

  // the node is halved along this axis
  int longest = 0;
  for (int axis = 0; axis < 3; axis++) {
    middle[axis] = 0.5 * (least[axis] + most[axis]);
    if (most[axis] - least[axis] > most[longest] - least[longest])
      longest = axis;
  }
  return longest;
}

/* Mean rows of the corners below a node, and how far each corner is from them. */
static void fill_node(const thrum_skin *skin, const thrum_skin_view *view, int64_t index) {
  thrum_skin_node *node = view->nodes + index;
  const int64_t r = skin->rank;
  double *mean = view->node_rows + 3 * index * r, *spread = view->spreads + index * r;
  const double share = 1.0 / (3.0 * node->count);
  for (int64_t t = node->first; t < node->first + node->count; t++)
    for (int n = 0; n < 3; n++) {
      const double *rows = view->rows + 3 * (int64_t)view->triangles[t].corners[n] * r;
      for (int64_t i = 0; i < 3 * r; i++)
        mean[i] += share * rows[i];
    }

  // the sphere at rest, and how much it can grow under a unit of each coordinate
  for (int64_t t = node->first; t < node->first + node->count; t++)
    for (int n = 0; n < 3; n++) {
      const int64_t v = view->triangles[t].corners[n];
      double arm[3];
      thrum_subtract3(view->rest + 3 * v, node->middle, arm);
      node->radius = fmax(node->radius, sqrt(thrum_dot3(arm, arm)));
      for (int64_t i = 0; i < r; i++) {
        const double *rows = view->rows + 3 * v * r + i, *of = mean + i;
        const double off[3] = {rows[0] - of[0], rows[r] - of[r], rows[2 * r] - of[2 * r]};
        spread[i] = fmax(spread[i], sqrt(thrum_dot3(off, off)));
      }
    }
}

/* Makes the node `index` over some triangles; nodes of a half follow their parent at once. */
static void make_node(const thrum_skin *skin, const thrum_skin_view *view, int64_t index,
                      int64_t from, int64_t to) {
  thrum_skin_node *node = view->nodes + index;
  *node = (thrum_skin_node){.first = (int32_t)from, .count = (int32_t)(to - from), -1, -1};
  const int axis = box_of(view, from, to, node->middle);
  if (to - from <= THRUM_SKIN_LEAF) {
    fill_node(skin, view, index);
    return;
  }

  // both halves below the same number of triangles, which bounds the depth
  const int64_t middle = from + (to - from) / 2;
  halve(view, from, to, middle, axis);
  node->left = (int32_t)(index + 1);
  node->right = (int32_t)(index + 1 + nodes_of(middle - from));
  make_node(skin, view, node->left, from, middle);
  make_node(skin, view, node->right, middle, to);
  fill_node(skin, view, index);
}

/* --- init ------------------------------------------------------------------------------------- */

static void fill_areas(const thrum_skin *skin, const thrum_skin_view *view) {
  for (int64_t t = 0; t < skin->triangle_count; t++) {
    const int32_t *corners = view->triangles[t].corners;
    double e[3], f[3], normal[3];
    thrum_subtract3(view->rest + 3 * (int64_t)corners[1], view->rest + 3 * (int64_t)corners[0], e);
    thrum_subtract3(view->rest + 3 * (int64_t)corners[2], view->rest + 3 * (int64_t)corners[0], f);
    thrum_cross3(e, f, normal);
    for (int n = 0; n < 3; n++)
      view->areas[corners[n]] += sqrt(thrum_dot3(normal, normal)) / 6.0;
  }
}

static void fill_extents(const thrum_skin *skin, const thrum_skin_view *view) {
  const int64_t r = skin->rank;
  for (int64_t v = 0; v < skin->vertex_count; v++)
    for (int64_t i = 0; i < r; i++) {
      const double *rows = view->rows + 3 * v * r + i;
      const double u[3] = {rows[0], rows[r], rows[2 * r]};
      view->extents[i] = fmax(view->extents[i], sqrt(thrum_dot3(u, u)));
    }
}

/* Where the third vertex of a triangle is seen from an edge: the share of the edge at its foot, and
 * its distance from it [m], at rest. */
static double height_of(const thrum_skin_view *view, const thrum_skin_edge *edge, int32_t vertex,
                        double *share) {
  double along[3], way[3], across[3];
  const double *first = view->rest + 3 * (int64_t)edge->ends[0];
  thrum_subtract3(view->rest + 3 * (int64_t)edge->ends[1], first, along);
  thrum_subtract3(view->rest + 3 * (int64_t)vertex, first, way);
  thrum_cross3(along, way, across);
  const double square = thrum_dot3(along, along);
  *share = thrum_dot3(way, along) / square;
  return sqrt(thrum_dot3(across, across) / square);
}

/* Do both faces of an edge lie in one at rest? normal: of the first of them. */
static bool is_in_flat_face(const thrum_skin_view *view, const thrum_skin_edge *edge,
                            double normal[3]) {
  if (edge->opposite[1] < 0)
    return false;
  const double *x[4];
  const int32_t vertices[4] = {edge->ends[0], edge->ends[1], edge->opposite[0], edge->opposite[1]};
  for (int n = 0; n < 4; n++)
    x[n] = view->rest + 3 * (int64_t)vertices[n];
  double across[2][3];
  const bool flat =
      thrum_faces_are_flat(x[0], x[1], x + 2, THRUM_SKIN_FLATTER * THRUM_SKIN_FLAT, across);

  const double length = sqrt(thrum_dot3(across[0], across[0]));
  for (int axis = 0; axis < 3; axis++)
    normal[axis] = across[0][axis] / length;
  return flat;
}

/* The bends of an edge that lies in a flat face: where its third vertices go along the normal,
 * against the edge at their feet, over their distances from it. */
static void bend_at(const thrum_skin *skin, const thrum_skin_view *view,
                    const thrum_skin_edge *edge, const double normal[3]) {
  const int64_t r = skin->rank;
  double heights[2], shares[2];
  for (int n = 0; n < 2; n++)
    heights[n] = height_of(view, edge, edge->opposite[n], shares + n);
  for (int64_t i = 0; i < r; i++) {
    double angle = 0.0, moved[4];
    const int32_t vertices[4] = {edge->ends[0], edge->ends[1], edge->opposite[0],
                                 edge->opposite[1]};
    for (int n = 0; n < 4; n++) {
      const double *rows = view->rows + 3 * (int64_t)vertices[n] * r + i;
      moved[n] = normal[0] * rows[0] + normal[1] * rows[r] + normal[2] * rows[2 * r];
    }
    for (int n = 0; n < 2; n++)
      angle += (moved[2 + n] - (1.0 - shares[n]) * moved[0] - shares[n] * moved[1]) / heights[n];
    view->bends[i] = fmax(view->bends[i], fabs(angle));
  }
}

/* Which edges lie in flat faces at rest, and how far the coordinates bend these. */
static void fill_bends(const thrum_skin *skin, const thrum_skin_view *view) {
  for (int64_t t = 0; t < skin->triangle_count; t++)
    for (int n = 0; n < 3; n++) {
      thrum_skin_triangle *triangle = view->triangles + t;
      const thrum_skin_edge *edge = view->edges + triangle->edges[n];
      double normal[3];
      if (!(triangle->tried & (THRUM_SKIN_EDGE << n)) || !is_in_flat_face(view, edge, normal))
        continue;
      triangle->tried |= THRUM_SKIN_IN_FACE << n;
      bend_at(skin, view, edge, normal);
    }
}

/* By how much the ends of edges move against each other, over the least height of a face of them.
 */
static void fill_tilts(const thrum_skin *skin, const thrum_skin_view *view) {
  const int64_t r = skin->rank;
  for (int64_t t = 0; t < skin->triangle_count; t++) {
    const thrum_skin_triangle *triangle = view->triangles + t;
    double least = INFINITY, share;

    // its least height, which the largest motion of an edge turns it by at most
    for (int n = 0; n < 3; n++)
      least = fmin(least,
                   height_of(view, view->edges + triangle->edges[n], third(triangle, n), &share));
    for (int n = 0; n < 3; n++) {
      const double *a = view->rows + 3 * (int64_t)triangle->corners[n] * r;
      const double *b = view->rows + 3 * (int64_t)triangle->corners[(n + 1) % 3] * r;
      for (int64_t i = 0; i < r; i++) {
        const double u[3] = {a[i] - b[i], a[r + i] - b[r + i], a[2 * r + i] - b[2 * r + i]};
        view->tilts[i] = fmax(view->tilts[i], sqrt(thrum_dot3(u, u)) / least);
      }
    }
  }
}

/* A checksum of a block by its words (Fowler, Noll & Vo: FNV-1a). */
static uint64_t seal_of(const void *memory, size_t size) {
  uint64_t sum = UINT64_C(14695981039346656037), word;
  for (size_t at = 0; at + sizeof word <= size; at += sizeof word) {
    memcpy(&word, (const unsigned char *)memory + at, sizeof word);
    sum = (sum ^ word) * UINT64_C(1099511628211);
    sum ^= sum >> 32;
  }
  return sum;
}

thrum_status thrum_skin_init(void *memory, size_t memory_size, const thrum_model *model,
                             const int32_t *triangles, int64_t triangle_count, thrum_skin **made,
                             thrum_error *error) {
  size_t size;
  THRUM_TRY(thrum_skin_size(model, triangles, triangle_count, &size, error));
  if (!memory || !made)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "memory or skin is NULL");
  THRUM_TRY(thrum_alignment_check("skin", memory, memory_size, size, error));
  memset(memory, 0, size);
  thrum_skin *skin = memory;
  *skin = header_of(model, triangle_count);

  // the vertices and their rows as the model has them
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const size_t vertices = (size_t)skin->vertex_count, r = (size_t)skin->rank;
  memcpy(view.rest, model->vertices, 3 * vertices * sizeof *view.rest);
  memcpy(view.rows, model->basis, 3 * vertices * r * sizeof *view.rows);
  for (int64_t n = 0; n < model->region_count; n++)
    skin->young = fmax(skin->young, model->material[3 * n]);
  skin->diagonal = thrum_box3_diagonal(view.rest, skin->vertex_count);
  for (int64_t t = 0; t < triangle_count; t++)
    memcpy(view.triangles[t].corners, triangles + 3 * t, 3 * sizeof *triangles);

  // edges and who tries what, then the tree, which orders the triangles
  make_edges(skin, view.heads, view.nexts);
  make_rings(skin);
  share_vertices(skin, view.heads);
  make_node(skin, &view, 0, 0, triangle_count);
  for (int64_t n = 0; n < 3 * skin->vertex_count; n++)
    skin->half[n % 3] = fmax(skin->half[n % 3], fabs(view.rest[n] - view.nodes[0].middle[n % 3]));
  fill_areas(skin, &view);
  fill_extents(skin, &view);
  fill_bends(skin, &view);
  fill_tilts(skin, &view);
  skin->seal = seal_of(memory, size);
  *made = skin;
  return THRUM_OK;
}

/* How far the vertices of a solid may be from its origin [m]: distances to fourth powers are
 * finite. */

/* The surface of a solid as a model without coordinates, stiffer than all bodies. */
static thrum_status solid_model(const double *vertices, int64_t vertex_count, thrum_model *model,
                                double material[3], thrum_error *error) {
  if (!vertices || vertex_count < 3 || vertex_count > INT32_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a solid needs 3 to 2^31 vertices");
  for (int64_t n = 0; n < 3 * vertex_count; n++)
    if (!(fabs(vertices[n]) <= THRUM_PLACE_MAX))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "vertex %lld of a solid is not within 1e30 m of its origin",
                             (long long)n / 3);
  material[0] = INFINITY;
  *model = (thrum_model){.vertex_count = vertex_count,
                         .vertices = (double *)(uintptr_t)vertices,
                         .basis = (double *)(uintptr_t)vertices,
                         .material = material,
                         .region_count = 1};
  return THRUM_OK;
}

thrum_status thrum_skin_solid_size(const double *vertices, int64_t vertex_count,
                                   const int32_t *triangles, int64_t triangle_count, size_t *size,
                                   thrum_error *error) {
  thrum_model model;
  double material[3] = {0};
  THRUM_TRY(solid_model(vertices, vertex_count, &model, material, error));
  return thrum_skin_size(&model, triangles, triangle_count, size, error);
}

thrum_status thrum_skin_solid_init(void *memory, size_t memory_size, const double *vertices,
                                   int64_t vertex_count, const int32_t *triangles,
                                   int64_t triangle_count, thrum_skin **skin, thrum_error *error) {
  thrum_model model;
  double material[3] = {0};
  THRUM_TRY(solid_model(vertices, vertex_count, &model, material, error));
  return thrum_skin_init(memory, memory_size, &model, triangles, triangle_count, skin, error);
}

int64_t thrum_skin_vertex_count(const thrum_skin *skin) {
  return skin ? skin->vertex_count : 0;
}

int64_t thrum_skin_node_count(const thrum_skin *skin) {
  return skin ? skin->node_count : 0;
}

double thrum_skin_diagonal(const thrum_skin *skin) {
  return skin ? skin->diagonal : 0.0;
}
