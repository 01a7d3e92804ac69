/* Cutting warped elements around their centres, see warped_solids.h.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/warped_solids.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/mesh_grow.h"
#include "platform/allocate.h"

/* How much of its volume an element may lose or gain by the plain cut, which takes a quarter of the
 * tetrahedra. */
static const double VOLUME_CHANGE = 0.01;

enum { CORNERS_MAX = 8, PASSES_MAX = 10 };

/* An element with its corners as places among the vertices. */
typedef struct warped_solid {
  int64_t corners[CORNERS_MAX]; /* -1 behind the last one */
  double volume;                /* of the trilinear element, negative where it is inside out */
  double plain;                 /* of the tets of the plain cut */
  bool inverted;                /* a tet of these lies inside out */
  bool forced; /* it was cut again for a neighbour, and has a tet inside out then */
  bool known;  /* all of its vertices are in the file */
} warped_solid;

/* Corners of a face or an element in ascending order; -1 behind the last one. */
typedef struct warped_key {
  int64_t corners[CORNERS_MAX];
} warped_key;

/* Different keys, ascending. */
typedef struct warped_keys {
  int64_t count;
  warped_key *keys;
} warped_keys;

typedef struct warped_cut {
  thrum_mesh_builder *b;
  const char *name;
  bool marks_volume;    /* elements that only change their volume are cut again too */
  warped_solid *solids; /* one for each cut of the builder */
  bool *again;          /* of each: it is cut around its centre */
  warped_keys bent;     /* faces that change much, as often as elements have them */
  warped_keys faces;    /* that are cut in four */
  warped_keys elements; /* that have a centre */
  int64_t first;        /* the vertices before new ones */
  double cones;         /* six times the volume of all new tets */
} warped_cut;

static const double *vertex(const warped_cut *w, int64_t v) {
  return w->b->positions + 3 * v;
}

static double triple(const double *origin, const double *a, const double *b, const double *c) {
  double edges[3][3];
  thrum_subtract3(a, origin, edges[0]);
  thrum_subtract3(b, origin, edges[1]);
  thrum_subtract3(c, origin, edges[2]);
  return thrum_triple3(edges[0], edges[1], edges[2]);
}

/* The corners of a face, counterclockwise from outside, without those that come again next to each
 * other; returns how many there are, 0 where the face has no area. */
static int face_corners(const warped_solid *solid, int kind, int f, int64_t corners[4]) {
  const int *face = thrum_solid_shapes[kind].face[f];
  int count = 0;
  for (int c = 0; c < 4 && face[c] >= 0; c++)
    if (count == 0 || solid->corners[face[c]] != corners[count - 1])
      corners[count++] = solid->corners[face[c]];
  if (count > 1 && corners[count - 1] == corners[0])
    count--;
  const bool folded = count == 4 && (corners[0] == corners[2] || corners[1] == corners[3]);
  return count < 3 || folded ? 0 : count;
}

/* --- which elements are warped -----------------------------------------------------------------
 */

/* Six times the volume between a point and the bilinear or flat face. */
static double cone_volume(const warped_cut *w, const double *top, const int64_t *corners,
                          int count) {
  double sum = 0;
  for (int c = 0; c < (count == 4 ? 4 : 1); c++)
    sum += triple(top, vertex(w, corners[c]), vertex(w, corners[(c + 1) % count]),
                  vertex(w, corners[(c + 2) % count]));
  return count == 4 ? sum / 2 : sum;
}

/* Finds the corners of an element and both of its volumes. */
static void examine(const warped_cut *w, int64_t c) {
  const thrum_mesh_builder *b = w->b;
  const thrum_cut *cut = &b->cuts[c];
  const thrum_solid_topology *shape = &thrum_solid_shapes[cut->kind];
  warped_solid *solid = &w->solids[c];
  *solid = (warped_solid){.known = true};
  for (int n = 0; n < CORNERS_MAX; n++) {
    solid->corners[n] =
        n < shape->corners ? thrum_builder_find(b, b->cut_nodes[cut->nodes + n]) : -1;
    solid->known = solid->known && (n >= shape->corners || solid->corners[n] >= 0);
  }

  // a vertex that is not there is refused with its element later
  if (!solid->known)
    return;
  const double *top = vertex(w, solid->corners[0]);
  for (int f = 0; f < shape->faces; f++) {
    int64_t corners[4];
    const int count = face_corners(solid, cut->kind, f, corners);
    solid->volume += count > 0 ? cone_volume(w, top, corners, count) / 6 : 0;
  }

  // all tets of the plain cut are wound as the element is
  for (int64_t t = cut->tet; t < cut->tet + cut->tets; t++) {
    int64_t v[4];
    for (int n = 0; n < 4; n++)
      v[n] = thrum_builder_find(b, b->tets[4 * t + n]);
    const double volume =
        triple(vertex(w, v[0]), vertex(w, v[1]), vertex(w, v[2]), vertex(w, v[3])) / 6;
    solid->plain += volume;
    solid->inverted =
        solid->inverted || !(copysign(1, solid->volume) * volume > 1e-12 * fabs(solid->volume));
  }
}

/* --- faces and centres -------------------------------------------------------------------------
 */

static warped_key make_key(const int64_t *corners, int count) {
  warped_key key;
  for (int n = 0; n < CORNERS_MAX; n++)
    key.corners[n] = -1;

  // a few numbers are sorted by insertion
  for (int n = 0; n < count; n++) {
    int at = n;
    for (; at > 0 && key.corners[at - 1] > corners[n]; at--)
      key.corners[at] = key.corners[at - 1];
    key.corners[at] = corners[n];
  }
  return key;
}

static int compare_keys(const void *a, const void *b) {
  const warped_key *x = a, *y = b;
  for (int n = 0; n < CORNERS_MAX; n++)
    if (x->corners[n] != y->corners[n])
      return x->corners[n] < y->corners[n] ? -1 : 1;
  return 0;
}

/* Sorts keys, and keeps one of those that are alike. */
static void sort_keys(warped_keys *keys) {
  int64_t kept = 0;
  if (keys->count > 0)
    qsort(keys->keys, (size_t)keys->count, sizeof *keys->keys, compare_keys);
  for (int64_t i = 0; i < keys->count; i++)
    if (i == 0 || compare_keys(&keys->keys[i], &keys->keys[kept - 1]) != 0)
      keys->keys[kept++] = keys->keys[i];
  keys->count = kept;
}

/* The place of a key; -1: it is not there. */
static int64_t find_key(const warped_keys *keys, const warped_key *key) {
  if (keys->count == 0)
    return -1;
  const warped_key *found =
      bsearch(key, keys->keys, (size_t)keys->count, sizeof *keys->keys, compare_keys);
  return found ? found - keys->keys : -1;
}

static thrum_status add_key(warped_keys *keys, warped_key key, thrum_error *error) {
  return thrum_mesh_append(&keys->keys, &keys->count, &key, sizeof key, error);
}

/* How much of an element's volume the halves of a face leave out or add. */
static double face_change(const warped_cut *w, const warped_solid *solid,
                          const int64_t corners[4]) {
  return fabs(triple(vertex(w, corners[0]), vertex(w, corners[1]), vertex(w, corners[2]),
                     vertex(w, corners[3]))) /
         (12 * fabs(solid->volume));
}

/* Gathers faces that change the volume of an element by much, each as often as elements have it. */
static thrum_status gather_bent(warped_cut *w) {
  const thrum_mesh_builder *b = w->b;
  for (int64_t c = 0; c < b->cut_count; c++) {
    const warped_solid *solid = &w->solids[c];
    int64_t corners[4];
    for (int f = 0; solid->known && f < thrum_solid_shapes[b->cuts[c].kind].faces; f++)
      if (face_corners(solid, b->cuts[c].kind, f, corners) == 4 &&
          face_change(w, solid, corners) > VOLUME_CHANGE)
        THRUM_TRY(add_key(&w->bent, make_key(corners, 4), b->error));
  }
  if (w->bent.count > 0)
    qsort(w->bent.keys, (size_t)w->bent.count, sizeof *w->bent.keys, compare_keys);
  return THRUM_OK;
}

/* Is a face one of these, of one element alone? What it changes no neighbour makes up for. */
static bool is_outer(const warped_cut *w, const warped_key *key) {
  const int64_t at = find_key(&w->bent, key);
  return at >= 0 && (at == 0 || compare_keys(key, &w->bent.keys[at - 1]) != 0) &&
         (at + 1 == w->bent.count || compare_keys(key, &w->bent.keys[at + 1]) != 0);
}

/* Must an element be cut again: for a part inside out, or for the volume that it or the body would
 * lose? */
static bool is_warped(const warped_cut *w, int64_t c) {
  const warped_solid *solid = &w->solids[c];
  int64_t corners[4];
  bool outer = false;
  if (!solid->known || solid->inverted || solid->forced || !w->marks_volume)
    return solid->known && (solid->inverted || solid->forced);
  for (int f = 0; w->bent.count > 0 && f < thrum_solid_shapes[w->b->cuts[c].kind].faces; f++) {
    if (face_corners(solid, w->b->cuts[c].kind, f, corners) != 4)
      continue;
    const warped_key key = make_key(corners, 4);
    outer = outer || is_outer(w, &key);
  }
  return outer || fabs(solid->plain - solid->volume) > VOLUME_CHANGE * fabs(solid->volume);
}

/* Gathers the faces of warped elements that are not flat, and then the elements at them. Flat faces
 * stay as they are, so that they change no neighbour. */
static thrum_status gather(warped_cut *w) {
  const thrum_mesh_builder *b = w->b;
  int64_t corners[4];
  w->faces.count = w->elements.count = 0;
  for (int64_t c = 0; c < b->cut_count; c++) {
    w->again[c] = is_warped(w, c);
    for (int f = 0; w->again[c] && f < thrum_solid_shapes[b->cuts[c].kind].faces; f++)
      if (face_corners(&w->solids[c], b->cuts[c].kind, f, corners) == 4 &&
          face_change(w, &w->solids[c], corners) > 1e-7)
        THRUM_TRY(add_key(&w->faces, make_key(corners, 4), b->error));
  }
  sort_keys(&w->faces);

  // neighbours have the same centre on the face that they share
  for (int64_t c = 0; c < b->cut_count; c++) {
    const warped_solid *solid = &w->solids[c];
    for (int f = 0; solid->known && f < thrum_solid_shapes[b->cuts[c].kind].faces; f++) {
      if (face_corners(solid, b->cuts[c].kind, f, corners) != 4)
        continue;
      const warped_key key = make_key(corners, 4);
      w->again[c] = w->again[c] || find_key(&w->faces, &key) >= 0;
    }
    if (w->again[c])
      THRUM_TRY(add_key(&w->elements,
                        make_key(solid->corners, thrum_solid_shapes[b->cuts[c].kind].corners),
                        b->error));
  }
  sort_keys(&w->elements);
  return THRUM_OK;
}

/* Refuses a tetrahedron of the file that has half of a face which is cut in four. */
static thrum_status check_tets(warped_cut *w) {
  static const int faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  const thrum_mesh_builder *b = w->b;
  warped_keys halves = {0};
  thrum_status status = THRUM_OK;
  for (int64_t i = 0; i < w->faces.count; i++)
    for (int f = 0; f < 4 && status >= 0; f++) {
      int64_t corners[3];
      for (int n = 0; n < 3; n++)
        corners[n] = w->faces.keys[i].corners[faces[f][n]];
      status = add_key(&halves, make_key(corners, 3), b->error);
    }
  sort_keys(&halves);

  // cuts are in the order of their tets, and what lies between is of the file
  for (int64_t t = 0, c = 0; t < b->tet_count && status >= 0; t++) {
    while (c < b->cut_count && t >= b->cuts[c].tet + b->cuts[c].tets)
      c++;
    if (c < b->cut_count && t >= b->cuts[c].tet)
      continue;
    for (int f = 0; f < 4 && status >= 0; f++) {
      int64_t corners[3];
      for (int n = 0; n < 3; n++)
        corners[n] = thrum_builder_find(b, b->tets[4 * t + faces[f][n]]);
      const warped_key key = make_key(corners, 3);
      if (find_key(&halves, &key) >= 0)
        status = thrum_error_set(
            b->error, THRUM_UNSUPPORTED,
            "%.150s: tetrahedron %lld lies at a warped face of a hexahedron, wedge or pyramid, "
            "which must be cut in four: mesh the body with tetrahedra alone",
            w->name, (long long)b->tet_numbers[t]);
    }
  }
  free(halves.keys);
  return status;
}

/* --- the new cut -------------------------------------------------------------------------------
 */

/* Adds a vertex at the mean of corners, which joins the lists later. */
static thrum_status add_centre(warped_cut *w, const warped_key *key) {
  thrum_mesh_builder *b = w->b;
  double sum[3] = {0, 0, 0};
  int count = 0;
  for (; count < CORNERS_MAX && key->corners[count] >= 0; count++)
    for (int axis = 0; axis < 3; axis++)
      sum[axis] += vertex(w, key->corners[count])[axis];
  for (int axis = 0; axis < 3; axis++)
    sum[axis] /= count;
  return thrum_builder_vertex(b, b->numbers[b->vertex_count - 1] + 1, sum, 0);
}

static thrum_status add_centres(warped_cut *w) {
  thrum_mesh_builder *b = w->b;
  const int64_t more = w->faces.count + w->elements.count;
  if (b->numbers[b->vertex_count - 1] > INT64_MAX - more)
    return thrum_error_set(b->error, THRUM_UNSUPPORTED, "%.200s: numbers of vertices are too large",
                           w->name);
  w->first = b->vertex_count;
  for (int64_t i = 0; i < w->faces.count; i++)
    THRUM_TRY(add_centre(w, &w->faces.keys[i]));
  for (int64_t i = 0; i < w->elements.count; i++)
    THRUM_TRY(add_centre(w, &w->elements.keys[i]));
  return THRUM_OK;
}

/* The vertices join the lists that hold all corners of what they are the centre of. */
static thrum_status join_lists(warped_cut *w) {
  thrum_mesh_builder *b = w->b;
  bool *held = NULL;
  thrum_status status = thrum_reserve(&held, w->first + 1, sizeof *held, "the mesh", b->error);
  for (int64_t l = 0; l < b->list_count && status >= 0; l++) {
    memset(held, 0, (size_t)w->first * sizeof *held);
    const int64_t count = b->lists[l].count;
    for (int64_t i = 0; i < count; i++) {
      const int64_t v = thrum_builder_find(b, b->lists[l].numbers[i]);
      if (v >= 0 && v < w->first)
        held[v] = true;
    }

    // faces come first, and elements behind them
    for (int64_t i = 0; i < w->faces.count + w->elements.count && status >= 0; i++) {
      const warped_key *key =
          i < w->faces.count ? &w->faces.keys[i] : &w->elements.keys[i - w->faces.count];
      bool all = true;
      for (int n = 0; n < CORNERS_MAX && key->corners[n] >= 0; n++)
        all = all && held[key->corners[n]];
      if (all)
        status = thrum_builder_add(b, l, b->numbers[w->first + i]);
    }
  }
  free(held);
  return status;
}

/* New tets, as the builder keeps them. */
typedef struct warped_tets {
  int64_t count;
  int64_t *tets, *keys, *lines, *numbers;
} warped_tets;

static thrum_status add_tet(warped_cut *w, warped_tets *to, const int64_t numbers[4], int64_t t) {
  thrum_mesh_builder *b = w->b;
  THRUM_TRY(thrum_mesh_grow(&to->tets, to->count, 1, 4 * sizeof *to->tets, b->error));
  THRUM_TRY(thrum_mesh_grow(&to->keys, to->count, 1, sizeof *to->keys, b->error));
  THRUM_TRY(thrum_mesh_grow(&to->lines, to->count, 1, sizeof *to->lines, b->error));
  THRUM_TRY(thrum_mesh_grow(&to->numbers, to->count, 1, sizeof *to->numbers, b->error));
  memcpy(to->tets + 4 * to->count, numbers, 4 * sizeof *numbers);
  to->keys[to->count] = b->keys[t];
  to->lines[to->count] = b->lines[t];
  to->numbers[to->count] = b->tet_numbers[t];
  to->count++;
  return THRUM_OK;
}

/* Adds the cone of an element's centre over a triangle; *good is false where it is inside out. */
static thrum_status add_cone(warped_cut *w, warped_tets *to, int64_t c, const int64_t v[4],
                             bool *good) {
  const double volume = triple(vertex(w, v[0]), vertex(w, v[1]), vertex(w, v[2]), vertex(w, v[3]));
  int64_t numbers[4];
  for (int n = 0; n < 4; n++)
    numbers[n] = w->b->numbers[v[n]];
  w->cones += fabs(volume);
  *good = *good && copysign(1, w->solids[c].volume) * volume > 1e-12 * fabs(w->solids[c].volume);
  return add_tet(w, to, numbers, w->b->cuts[c].tet);
}

/* Cuts an element around its centre: four triangles on faces that are cut so, else those of the
 * diagonal from the corner of the smallest number, as all elements have it. */
static thrum_status cut_again(warped_cut *w, warped_tets *to, int64_t c, bool *good) {
  const warped_solid *solid = &w->solids[c];
  const thrum_solid_topology *shape = &thrum_solid_shapes[w->b->cuts[c].kind];
  const warped_key own = make_key(solid->corners, shape->corners);
  const int64_t centre = w->first + w->faces.count + find_key(&w->elements, &own);
  for (int f = 0; f < shape->faces; f++) {
    int64_t corners[4];
    const int count = face_corners(solid, w->b->cuts[c].kind, f, corners);
    const warped_key key = make_key(corners, count);
    const int64_t four = count == 4 ? find_key(&w->faces, &key) : -1;

    // the smallest place has the smallest number
    int first = 0;
    for (int n = 1; n < count; n++)
      first = corners[n] < corners[first] ? n : first;
    for (int n = 0; four >= 0 && n < 4; n++)
      THRUM_TRY(add_cone(
          w, to, c, (int64_t[4]){centre, w->first + four, corners[n], corners[(n + 1) % 4]}, good));
    for (int n = 1; four < 0 && n + 1 < count; n++)
      THRUM_TRY(add_cone(w, to, c,
                         (int64_t[4]){centre, corners[first], corners[(first + n) % count],
                                      corners[(first + n + 1) % count]},
                         good));
  }
  return THRUM_OK;
}

/* Makes the tets anew; *bad is the first element that has one inside out, -1: none has. Elements
 * that were cut again for a neighbour alone are forced then, and *more tells that there are any. */
static thrum_status make_tets(warped_cut *w, warped_tets *to, int64_t *bad, bool *more) {
  const thrum_mesh_builder *b = w->b;
  *bad = -1;
  w->cones = 0;
  for (int64_t t = 0, c = 0; t < b->tet_count;) {
    while (c < b->cut_count && t >= b->cuts[c].tet + b->cuts[c].tets)
      c++;
    bool good = true;
    if (c == b->cut_count || t < b->cuts[c].tet || !w->again[c]) {
      THRUM_TRY(add_tet(w, to, b->tets + 4 * t, t));
      t++;
      continue;
    }
    THRUM_TRY(cut_again(w, to, c, &good));
    if (!good && !is_warped(w, c))
      *more = w->solids[c].forced = true;
    *bad = good || *bad >= 0 ? *bad : c;
    t = b->cuts[c].tet + b->cuts[c].tets;
  }
  return THRUM_OK;
}

/* The builder takes new tets over. */
static void take_tets(warped_cut *w, warped_tets *from) {
  thrum_mesh_builder *b = w->b;
  for (int64_t c = 0; c < b->cut_count; c++)
    b->centred_elements += w->again[c];
  b->cut_tets += from->count - b->tet_count;
  b->cornered_tets += b->cornered_tets > 0 ? from->count - b->tet_count : 0;
  b->tet_count = from->count;
  const warped_tets old = {0, b->tets, b->keys, b->lines, b->tet_numbers};
  b->tets = from->tets;
  b->keys = from->keys;
  b->lines = from->lines;
  b->tet_numbers = from->numbers;
  *from = old;
}

/* Refuses an element that no cut leaves right side out. */
static thrum_status refuse(const warped_cut *w, int64_t c) {
  const int64_t t = w->b->cuts[c].tet;
  char line[32];
  return thrum_error_set(w->b->error, THRUM_BAD_VALUE,
                         "%.150s%s: element %lld is too warped to be cut into tetrahedra, or its "
                         "nodes are in another order than that of the format; mesh it with "
                         "tetrahedra, or mend it",
                         w->name, thrum_builder_place(w->b->lines[t], line),
                         (long long)w->b->tet_numbers[t]);
}

/* Cuts again what is marked; *bad and *more as in make_tets, and the builder is as it was then. */
static thrum_status try_once(warped_cut *w, int64_t *bad, bool *more) {
  thrum_mesh_builder *b = w->b;
  warped_tets tets = {0};
  *bad = -1;
  *more = false;
  THRUM_TRY(gather(w));
  if (w->elements.count == 0)
    return THRUM_OK;
  thrum_status status = check_tets(w);
  THRUM_THEN(status, add_centres(w));
  THRUM_THEN(status, make_tets(w, &tets, bad, more));
  if (status >= 0 && *bad >= 0)
    b->vertex_count = w->first;
  else if (status >= 0)
    take_tets(w, &tets);
  if (status >= 0 && *bad < 0)
    status = join_lists(w);
  free(tets.tets);
  free(tets.keys);
  free(tets.lines);
  free(tets.numbers);
  return status;
}

/* The same, and again with all faces of neighbours that would have a part inside out. */
static thrum_status try_cut(warped_cut *w, int64_t *bad) {
  bool more = true;
  for (int64_t c = 0; c < w->b->cut_count; c++)
    w->solids[c].forced = false;
  for (int pass = 0; more && pass < PASSES_MAX; pass++)
    THRUM_TRY(try_once(w, bad, &more));
  return THRUM_OK;
}

/* What the cut makes of the volume of all elements, once it is done. */
static void sum_volumes(const warped_cut *w) {
  double whole = 0, kept = w->cones / 6;
  for (int64_t c = 0; c < w->b->cut_count; c++) {
    whole += fabs(w->solids[c].volume);
    kept += w->again[c] ? 0 : fabs(w->solids[c].plain);
  }
  w->b->cut_change = whole > 0 ? kept / whole - 1 : 0;
}

static thrum_status recut(warped_cut *w) {
  int64_t bad = -1;
  for (int64_t c = 0; c < w->b->cut_count; c++)
    examine(w, c);
  THRUM_TRY(gather_bent(w));

  // an element that cannot be cut around its centre may still have been sound before
  THRUM_TRY(try_cut(w, &bad));
  if (bad >= 0) {
    w->marks_volume = false;
    THRUM_TRY(try_cut(w, &bad));
  }
  if (bad >= 0)
    return refuse(w, bad);
  sum_volumes(w);
  return THRUM_OK;
}

thrum_status thrum_builder_recut(thrum_mesh_builder *b, const char *name) {
  warped_cut w = {.b = b, .name = name, .marks_volume = true};
  if (b->cut_count == 0 || b->middles || b->odd_tet > 0)
    return THRUM_OK;
  thrum_status status =
      thrum_reserve(&w.solids, b->cut_count, sizeof *w.solids, "the mesh", b->error);
  THRUM_THEN(status, thrum_reserve(&w.again, b->cut_count, sizeof *w.again, "the mesh", b->error));
  THRUM_THEN(status, recut(&w));
  free(w.solids);
  free(w.again);
  free(w.bent.keys);
  free(w.faces.keys);
  free(w.elements.keys);
  return status;
}
