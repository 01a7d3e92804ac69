/* The generator beam:NXxNYxNZ@LXxLYxLZ: a box of NX x NY x NZ cells, each cut into the six Kuhn
 * tets around its diagonal (Kuhn 1960, Some combinatorial lemmas in topology,
 * doi:10.1147/rd.45.0518). Every other cell along an axis is the mirror image of its neighbours, so
 * that they fit, and so that a square section of an even number of cells has the symmetry of the
 * square: it bends alike in all directions. With ",split=6" all cells are the same. With ",split=5"
 * each is cut into five, one of them in the middle, and neighbours are mirror images. With ",hex"
 * cells are hexahedra, whose shape are six tets that are mirrored. With ",parts=N" behind that its
 * length has N regions of equal length, part1 to partN. Default rubber-like material.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "mesh/mesh.h"
#include "mesh/mesh_beam.h"
#include "mesh/mesh_groups.h"
#include "mesh/solids.h"
#include "platform/allocate.h"

/* 200 million tets take 5 GB here and far more later on */
enum { TETS_MAX = 200000000 };

typedef struct beam {
  int64_t cells[3];
  double lengths[3];
  int split;      /* tets a cell, 5 or 6 */
  bool mirrored;  /* six that are mirror images in neighbours; else the same in every cell */
  bool hexahedra; /* cells stay whole */
  int64_t parts;  /* regions along x */
} beam;

static thrum_status bad_spec(const char *spec, thrum_error *error) {
  return thrum_error_set(
      error, THRUM_BAD_FORMAT,
      "'%.100s' is no beam; write beam:NXxNYxNZ@LXxLYxLZ, cells and metres, "
      "such as beam:20x3x3@1x0.15x0.15, and perhaps ,hex or ,split=5, and ,parts=2",
      spec);
}

/* Does the word stand here? Goes behind it. */
static bool take_word(const char **at, const char *word) {
  const size_t length = strlen(word);
  if (strncmp(*at, word, length) != 0)
    return false;
  *at += length;
  return true;
}

static thrum_status parse_spec(const char *spec, beam *b, thrum_error *error) {
  const char *at = spec + strlen("beam:"), *end = spec + strlen(spec);
  for (int a = 0; a < 6; a++) {
    size_t used = a < 3 ? thrum_text_scan_integer(at, end, &b->cells[a])
                        : thrum_text_scan_number(at, end, &b->lengths[a - 3]);
    at += used;
    const char expected = a == 2 ? '@' : 'x';
    if (used == 0 || (a < 5 && *at != expected))
      return bad_spec(spec, error);
    at += a < 5;
  }

  // how cells are cut, and into how many regions
  const bool all_same = take_word(&at, ",split=6");
  b->split = !all_same && take_word(&at, ",split=5") ? 5 : 6;
  b->hexahedra = !all_same && b->split == 6 && take_word(&at, ",hex");
  b->mirrored = !all_same && b->split == 6;
  b->parts = 1;
  if (take_word(&at, ",parts="))
    at += thrum_text_scan_integer(at, end, &b->parts);
  if (at > spec && at[-1] == '=')
    return bad_spec(spec, error);
  if (at != end || b->parts < 1 || (b->parts > 1 && b->parts > b->cells[0]))
    return bad_spec(spec, error);

  double tets = b->split;
  for (int a = 0; a < 3; a++) {
    if (b->cells[a] < 1 || !(b->lengths[a] > 0))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "'%.100s': a beam has at least one cell and a length above 0 along "
                             "each axis",
                             spec);
    if (!(b->lengths[a] > 1e-30 && b->lengths[a] < 1e30))
      return thrum_error_set(
          error, THRUM_BAD_VALUE,
          "'%.100s': a length of %g m is out of range; it must lie between 1e-30 "
          "and 1e30 m",
          spec, b->lengths[a]);

    tets *= (double)b->cells[a];
  }

  if (tets > TETS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "'%.100s' would have %.3g tets; at most %d are made", spec, tets,
                           TETS_MAX);

  return THRUM_OK;
}

static int32_t vertex_at(const beam *b, int64_t i, int64_t j, int64_t k) {
  return (int32_t)((i * (b->cells[1] + 1) + j) * (b->cells[2] + 1) + k);
}

/* length * part / whole in lowest terms, so that halves, thirds and the like round once. */
static double share(double length, int64_t part, int64_t whole) {
  int64_t a = part < 0 ? -part : part, b = whole;
  while (b != 0) {
    int64_t rest = a % b;
    a = b;
    b = rest;
  }
  return length * (double)(part / a) / (double)(whole / a);
}

static void fill_vertices(const beam *b, double *vertices) {
  const double *l = b->lengths;
  const int64_t *n = b->cells;
  // symmetric about the axis to the last bit
  for (int64_t i = 0; i <= n[0]; i++)
    for (int64_t j = 0; j <= n[1]; j++)
      for (int64_t k = 0; k <= n[2]; k++) {
        *vertices++ = share(l[0], i, n[0]);
        *vertices++ = share(l[1], 2 * j - n[1], 2 * n[1]);
        *vertices++ = share(l[2], 2 * k - n[2], 2 * n[2]);
      }
}

/* The tet of one order of the axes: from corner to corner of the cell, one axis at a time. Where
 * cells are mirrored every other one along an axis goes from its upper side down. */
static void fill_tet(const beam *b, const int64_t cell[3], const int order[3], bool odd,
                     int32_t *tet) {
  int64_t corner[3];
  bool down[3];
  for (int a = 0; a < 3; a++) {
    down[a] = b->mirrored && cell[a] % 2 != 0;
    corner[a] = cell[a] + down[a];
    odd ^= down[a];
  }

  // one step along each axis
  tet[0] = vertex_at(b, corner[0], corner[1], corner[2]);
  for (int a = 0; a < 3; a++) {
    corner[order[a]] += down[order[a]] ? -1 : 1;
    tet[a + 1] = vertex_at(b, corner[0], corner[1], corner[2]);
  }

  // an odd order is wound the other way, and so is a mirror image
  if (odd) {
    int32_t swap = tet[2];
    tet[2] = tet[3];
    tet[3] = swap;
  }
}

/* The five tets of a cell: at every other corner one with the three corners next to it, and one of
 * these four corners' neighbours in the middle. In odd cells the corners are the other four. */
static void fill_five(const beam *b, const int64_t cell[3], int32_t *tets) {
  static const int shapes[5][4] = {
      {0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
  const bool odd = (cell[0] + cell[1] + cell[2]) % 2 != 0;
  for (int t = 0; t < 5; t++)
    for (int a = 0; a < 4; a++) {
      // bits of a corner are its steps along the axes; the mirror image has the other x
      const int corner = shapes[t][a] ^ (odd ? 1 : 0);
      const int place = odd && a >= 2 ? 5 - a : a; // and is wound the other way
      tets[4 * t + place] = vertex_at(b, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                                      cell[2] + (corner >> 2));
    }
}

static void fill_tets(const beam *b, int32_t *tets) {
  static const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                   {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  static const bool odd[6] = {false, true, true, false, false, true};
  for (int64_t i = 0; i < b->cells[0]; i++)
    for (int64_t j = 0; j < b->cells[1]; j++)
      for (int64_t k = 0; k < b->cells[2]; k++) {
        const int64_t cell[3] = {i, j, k};
        if (b->split == 5)
          fill_five(b, cell, tets);
        for (int o = 0; o < 6 && b->split == 6; o++)
          fill_tet(b, cell, orders[o], odd[o], tets + 4 * (int64_t)o);
        tets += 4 * (int64_t)b->split;
      }
}

/* Regions of equal length, and their names and materials: the soft one of the examples. */
static thrum_status fill_parts(const beam *b, thrum_mesh *mesh, const char *spec,
                               thrum_error *error) {
  const int64_t slice = b->split * b->cells[1] * b->cells[2];
  THRUM_TRY(thrum_reserve(&mesh->materials, b->parts, sizeof *mesh->materials, spec, error));
  for (int64_t p = 0; p < b->parts; p++)
    mesh->materials[p] = (thrum_material){.young = 5e6, .poisson = 0.4, .density = 1000};
  for (int64_t t = 0; t < mesh->tet_count; t++)
    mesh->tet_region[t] = (int32_t)(t / slice * b->parts / b->cells[0]);
  if (b->parts == 1)
    return THRUM_OK;

  THRUM_TRY(thrum_reserve(&mesh->region_names, b->parts, sizeof *mesh->region_names, spec, error));
  for (int64_t p = 0; p < b->parts; p++) {
    char *name = NULL;
    THRUM_TRY(thrum_reserve(&name, 32, sizeof *name, spec, error));
    snprintf(name, 32, "part%lld", (long long)p + 1);
    mesh->region_names[p] = name;
  }
  return THRUM_OK;
}

/* Each cell as a hexahedron, its lower four corners first (Abaqus, VTK). */
static thrum_status fill_hexahedra(const beam *b, thrum_mesh *mesh, const char *spec,
                                   thrum_error *error) {
  static const int corners[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                    {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  const int64_t count = b->cells[0] * b->cells[1] * b->cells[2];
  THRUM_TRY(thrum_reserve(&mesh->solid_form, count, sizeof *mesh->solid_form, spec, error));
  THRUM_TRY(thrum_reserve(&mesh->solid_ends, count, sizeof *mesh->solid_ends, spec, error));
  THRUM_TRY(thrum_reserve(&mesh->solid_tet_ends, count, sizeof *mesh->solid_tet_ends, spec, error));
  THRUM_TRY(thrum_reserve(&mesh->solid_nodes, count, 8 * sizeof *mesh->solid_nodes, spec, error));
  mesh->solid_count = count;
  int32_t *node = mesh->solid_nodes;
  int64_t n = 0;
  for (int64_t i = 0; i < b->cells[0]; i++)
    for (int64_t j = 0; j < b->cells[1]; j++)
      for (int64_t k = 0; k < b->cells[2]; k++, n++) {
        mesh->solid_form[n] = THRUM_FORM_HEX8;
        mesh->solid_ends[n] = (int32_t)(8 * (n + 1));
        mesh->solid_tet_ends[n] = (int32_t)(b->split * (n + 1));
        for (int c = 0; c < 8; c++)
          *node++ = vertex_at(b, i + corners[c][0], j + corners[c][1], k + corners[c][2]);
      }
  return THRUM_OK;
}

/* Vertices whose grid position lies within [low, high] on each axis, as a group. */
static thrum_status add_box(thrum_mesh *mesh, const beam *b, const char *name, const int64_t low[3],
                            const int64_t high[3], int32_t *list, thrum_error *error) {
  int64_t count = 0;
  for (int64_t i = low[0]; i <= high[0]; i++)
    for (int64_t j = low[1]; j <= high[1]; j++)
      for (int64_t k = low[2]; k <= high[2]; k++)
        list[count++] = vertex_at(b, i, j, k);
  return thrum_mesh_add_group(mesh, name, list, count, error);
}

static thrum_status add_groups(thrum_mesh *mesh, const beam *b, thrum_error *error) {
  static const char *const names[6] = {"left", "right", "front", "back", "bottom", "top"};
  int32_t *list = NULL;
  THRUM_TRY(thrum_reserve(&list, mesh->vertex_count, sizeof *list, "the beam", error));

  // the faces of the box
  const int64_t *n = b->cells;
  thrum_status status = THRUM_OK;
  for (int face = 0; face < 6 && status >= 0; face++) {
    int64_t low[3] = {0, 0, 0}, high[3] = {n[0], n[1], n[2]};
    if (face % 2 == 0)
      high[face / 2] = 0;
    else
      low[face / 2] = n[face / 2];
    status = add_box(mesh, b, names[face], low, high, list, error);
  }

  // the one, two or four vertices around the centre of the right face
  if (status >= 0) {
    int64_t low[3] = {n[0], n[1] / 2, n[2] / 2};
    int64_t high[3] = {n[0], (n[1] + 1) / 2, (n[2] + 1) / 2};
    status = add_box(mesh, b, "tip", low, high, list, error);
  }

  free(list);
  return status;
}

thrum_status thrum_mesh_beam_cells(const char *spec, int64_t cells[3], thrum_error *error) {
  beam b;
  if (strncmp(spec, "beam:", 5) != 0)
    return bad_spec(spec, error);
  THRUM_TRY(parse_spec(spec, &b, error));
  memcpy(cells, b.cells, sizeof b.cells);
  return THRUM_OK;
}

thrum_status thrum_mesh_beam(const char *spec, thrum_mesh *mesh, thrum_error *error) {
  if (strncmp(spec, "beam:", 5) != 0)
    return bad_spec(spec, error);
  beam b;
  THRUM_TRY(parse_spec(spec, &b, error));

  thrum_mesh m = {0};
  m.vertex_count = (b.cells[0] + 1) * (b.cells[1] + 1) * (b.cells[2] + 1);
  m.file_vertex_count = m.vertex_count;
  m.tet_count = b.split * b.cells[0] * b.cells[1] * b.cells[2];
  m.region_count = b.parts;
  m.has_material = true;

  thrum_status status =
      thrum_reserve(&m.vertices, m.vertex_count, 3 * sizeof *m.vertices, spec, error);
  THRUM_THEN(status, thrum_reserve(&m.tets, m.tet_count, 4 * sizeof *m.tets, spec, error));
  THRUM_THEN(status, thrum_reserve(&m.tet_region, m.tet_count, sizeof *m.tet_region, spec, error));
  THRUM_THEN(status, fill_parts(&b, &m, spec, error));
  if (status >= 0) {
    fill_vertices(&b, m.vertices);
    fill_tets(&b, m.tets);
    status = add_groups(&m, &b, error);
  }
  if (b.hexahedra)
    THRUM_THEN(status, fill_hexahedra(&b, &m, spec, error));
  return thrum_mesh_deliver(status, &m, mesh);
}
