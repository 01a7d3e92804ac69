/* Orthotropic constants and their directions, see elastic.h. Lekhnitskii 1963, Theory of elasticity
 * of an anisotropic elastic body. SPDX-License-Identifier: Apache-2.0 */
#include "mesh/elastic.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "mesh/mesh_groups.h"
#include "mesh/solids.h"
#include "platform/allocate.h"

/* Directions within this angle [rad] of each other are parallel. */
#define PARALLEL 1e-6

static const int axes_of[THRUM_STRAINS][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};

/* The upper factor of a positive matrix, R^T R; false where it is not positive. */
static bool factor(double matrix[3][3], double root[3][3]) {
  memset(root, 0, 9 * sizeof(double));
  for (int i = 0; i < 3; i++)
    for (int j = i; j < 3; j++) {
      double sum = matrix[i][j];
      for (int k = 0; k < i; k++)
        sum -= root[k][i] * root[k][j];
      if (i == j && !(sum > 1e-12 * matrix[i][i] && isfinite(sum)))
        return false;
      root[i][j] = i == j ? sqrt(sum) : sum / root[i][i];
    }
  return true;
}

/* The inverse of a positive matrix by its cofactors. */
static void invert(double matrix[3][3], double inverse[3][3]) {
  double cross[3][3];
  for (int i = 0; i < 3; i++)
    thrum_cross3(matrix[(i + 1) % 3], matrix[(i + 2) % 3], cross[i]);
  const double det = thrum_dot3(matrix[0], cross[0]);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      inverse[i][j] = cross[j][i] / det;
}

bool thrum_elastic_root(const double *row, thrum_elastic_matrix root) {
  static const int other[3][2] = {{0, 1}, {0, 2}, {1, 2}};
  const double *young = row + THRUM_ELASTIC_YOUNG, *shear = row + THRUM_ELASTIC_SHEAR;
  double compliance[3][3], normal[3][3], part[3][3];
  for (int i = 0; i < 3; i++) {
    if (!(young[i] > 0 && isfinite(1 / young[i]) && shear[i] > 0 && isfinite(shear[i])))
      return false;
    compliance[i][i] = 1 / young[i];
  }
  for (int k = 0; k < 3; k++) {
    const int i = other[k][0], j = other[k][1];
    compliance[i][j] = compliance[j][i] = -row[THRUM_ELASTIC_POISSON + k] / young[i];
  }
  if (!factor(compliance, part))
    return false;
  invert(compliance, normal);
  if (!factor(normal, part))
    return false;

  // shears 23, 13, 12
  memset(root, 0, sizeof(thrum_elastic_matrix));
  for (int i = 0; i < 3; i++)
    memcpy(root[i], part[i], sizeof part[i]);
  for (int k = 0; k < 3; k++)
    root[3 + k][3 + k] = sqrt(shear[2 - k]);
  return true;
}

bool thrum_elastic_axes(const double *row, const double *normal, double axes[3][3]) {
  const double *first = row + THRUM_ELASTIC_FIRST, *second = row + THRUM_ELASTIC_SECOND;
  double along[3], across[3], up[3];
  memcpy(up, normal ? normal : first, sizeof up);
  if (!normal)
    thrum_cross3(first, second, up);
  const double length = sqrt(thrum_dot3(first, first));
  const double other = normal ? 1 : sqrt(thrum_dot3(second, second));
  const double height = sqrt(thrum_dot3(up, up));
  if (!(height > PARALLEL * (normal ? 1 : length * other)) || !(length > 0) || !isfinite(length))
    return false;
  for (int c = 0; c < 3; c++)
    up[c] /= height;

  // direction 1 without what stands on the plane
  const double rise = thrum_dot3(first, up);
  for (int c = 0; c < 3; c++)
    along[c] = first[c] - rise * up[c];
  const double flat = sqrt(thrum_dot3(along, along));
  if (!(flat > PARALLEL * length))
    return false;
  for (int c = 0; c < 3; c++)
    along[c] /= flat;
  thrum_cross3(up, along, across);

  const double cosine = cos(row[THRUM_ELASTIC_ANGLE]), sine = sin(row[THRUM_ELASTIC_ANGLE]);
  for (int c = 0; c < 3; c++) {
    axes[0][c] = cosine * along[c] + sine * across[c];
    axes[1][c] = cosine * across[c] - sine * along[c];
    axes[2][c] = up[c];
  }
  return true;
}

void thrum_elastic_turn(thrum_elastic_matrix root, double axes[3][3], thrum_elastic_matrix turned) {
  thrum_elastic_matrix turn;

  // strains along the directions by those of space, shears doubled
  for (int to = 0; to < THRUM_STRAINS; to++)
    for (int from = 0; from < THRUM_STRAINS; from++) {
      const int a = axes_of[to][0], b = axes_of[to][1], c = axes_of[from][0], d = axes_of[from][1];
      const double both = axes[a][c] * axes[b][d] + axes[a][d] * axes[b][c];
      turn[to][from] = (to < 3 ? 1 : 2) * both / 2;
    }
  for (int i = 0; i < THRUM_STRAINS; i++)
    for (int j = 0; j < THRUM_STRAINS; j++) {
      turned[i][j] = 0;
      for (int k = i; k < THRUM_STRAINS; k++)
        turned[i][j] += root[i][k] * turn[k][j];
    }
}

void thrum_elastic_stiffness(thrum_elastic_matrix root, thrum_elastic_matrix stiffness) {
  for (int i = 0; i < THRUM_STRAINS; i++)
    for (int j = 0; j < THRUM_STRAINS; j++) {
      stiffness[i][j] = 0;
      for (int k = 0; k < THRUM_STRAINS; k++)
        stiffness[i][j] += root[k][i] * root[k][j];
    }
}

bool thrum_elastic_constants(thrum_elastic_matrix stiffness, double *row) {
  double normal[3][3], part[3][3], compliance[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      normal[i][j] = stiffness[i][j];
  if (!factor(normal, part))
    return false;
  invert(normal, compliance);
  for (int i = 0; i < 3; i++) {
    row[THRUM_ELASTIC_YOUNG + i] = 1 / compliance[i][i];
    row[THRUM_ELASTIC_SHEAR + i] = stiffness[5 - i][5 - i];
  }
  row[THRUM_ELASTIC_POISSON] = -compliance[0][1] / compliance[0][0];
  row[THRUM_ELASTIC_POISSON + 1] = -compliance[0][2] / compliance[0][0];
  row[THRUM_ELASTIC_POISSON + 2] = -compliance[1][2] / compliance[1][1];
  thrum_elastic_matrix root;
  return thrum_elastic_root(row, root);
}

/* --- of a mesh -------------------------------------------------------------------------------- */

/* The isotropic moduli that are the mean over all directions. */
static void take_mean(const double *row, thrum_material *material) {
  thrum_elastic_matrix root, c;
  thrum_elastic_root(row, root);
  thrum_elastic_stiffness(root, c);
  const double normal = c[0][0] + c[1][1] + c[2][2], mixed = c[0][1] + c[0][2] + c[1][2];
  const double bulk = (normal + 2 * mixed) / 9;
  const double shear = (normal - mixed + 3 * (c[3][3] + c[4][4] + c[5][5])) / 15;
  material->young = 9 * bulk * shear / (3 * bulk + shear);
  material->poisson = (3 * bulk - 2 * shear) / (2 * (3 * bulk + shear));
}

int64_t thrum_mesh_elastic_begin(const thrum_mesh *mesh, int64_t region) {
  int64_t n = 0;
  while (n < mesh->elastic_count &&
         mesh->elastic[THRUM_ELASTIC_NUMBERS * n + THRUM_ELASTIC_REGION] < (double)region)
    n++;
  return n;
}

bool thrum_mesh_has_layers(const thrum_mesh *mesh) {
  for (int64_t n = 0; n < mesh->elastic_count; n++)
    if (mesh->elastic[THRUM_ELASTIC_NUMBERS * n + THRUM_ELASTIC_THICKNESS] > 0)
      return true;
  return false;
}

static thrum_status check_rows(const thrum_mesh *mesh, int64_t region, const double *rows,
                               int64_t count, thrum_error *error) {
  for (int64_t n = 0; n < count; n++) {
    const double *row = rows + THRUM_ELASTIC_NUMBERS * n;
    const double *first = row + THRUM_ELASTIC_FIRST;
    thrum_elastic_matrix root;
    double axes[3][3];
    if (!thrum_elastic_root(row, root))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the elastic constants of region '%.100s' have no positive energy: "
                             "moduli are above 0, and Poisson's ratios small enough, such as "
                             "NU12^2 < E1/E2",
                             thrum_mesh_region_text(mesh, region).text);
    if (row[THRUM_ELASTIC_THICKNESS] > 0 ? !(thrum_dot3(first, first) > 0)
                                         : !thrum_elastic_axes(row, NULL, axes))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the directions of region '%.100s' are parallel, or have no length",
                             thrum_mesh_region_text(mesh, region).text);
  }
  return THRUM_OK;
}

thrum_status thrum_mesh_set_elastic(thrum_mesh *mesh, int64_t region, const double *rows,
                                    int64_t count, thrum_error *error) {
  const size_t size = THRUM_ELASTIC_NUMBERS * sizeof(double);
  double *made = NULL;
  THRUM_TRY(check_rows(mesh, region, rows, count, error));
  const int64_t begin = thrum_mesh_elastic_begin(mesh, region);
  const int64_t end = thrum_mesh_elastic_begin(mesh, region + 1);
  const int64_t behind = mesh->elastic_count - end, all = begin + count + behind;
  if (all > 0)
    THRUM_TRY(thrum_reserve(&made, all, size, "the materials", error));

  // the rows of regions before, of this one, and of those behind
  if (begin > 0)
    memcpy(made, mesh->elastic, (size_t)begin * size);
  for (int64_t n = 0; n < count; n++) {
    double *row = made + THRUM_ELASTIC_NUMBERS * (begin + n);
    memcpy(row, rows + THRUM_ELASTIC_NUMBERS * n, size);
    row[THRUM_ELASTIC_REGION] = (double)region;
  }
  if (behind > 0)
    memcpy(made + THRUM_ELASTIC_NUMBERS * (begin + count),
           mesh->elastic + THRUM_ELASTIC_NUMBERS * end, (size_t)behind * size);
  free(mesh->elastic);
  mesh->elastic = made;
  mesh->elastic_count = all;
  if (count > 0)
    take_mean(rows, &mesh->materials[region]);
  return THRUM_OK;
}

/* The tets of solid tetrahedra and what is known of each, which the mesh gets. */
typedef struct tet_arrays {
  int32_t *tets, *region;
  int64_t *line, *number;
} tet_arrays;

static thrum_status cut_tets(thrum_mesh *mesh, tet_arrays *made, int64_t room, thrum_error *error) {
  static const char what[] = "the elements";
  const thrum_solid_form form = mesh->midsides ? THRUM_FORM_TET10 : THRUM_FORM_TET4;
  const int nodes = thrum_solid_forms[form].nodes;
  THRUM_TRY(thrum_reserve(&mesh->solid_form, mesh->tet_count, 1, what, error));
  THRUM_TRY(thrum_reserve(&mesh->solid_ends, mesh->tet_count, sizeof(int32_t), what, error));
  THRUM_TRY(thrum_reserve(&mesh->solid_tet_ends, mesh->tet_count, sizeof(int32_t), what, error));
  THRUM_TRY(
      thrum_reserve(&mesh->solid_nodes, nodes * mesh->tet_count, sizeof(int32_t), what, error));
  THRUM_TRY(thrum_reserve(&made->tets, 4 * room, sizeof(int32_t), what, error));
  THRUM_TRY(thrum_reserve(&made->region, room, sizeof(int32_t), what, error));
  if (mesh->tet_line)
    THRUM_TRY(thrum_reserve(&made->line, room, sizeof(int64_t), what, error));
  THRUM_TRY(thrum_reserve(&made->number, room, sizeof(int64_t), what, error));

  // a tetrahedron is its own shape, one of ten nodes is cut into eight
  int64_t end = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t node[10];
    int64_t numbers[10];
    int cut[THRUM_SOLID_MIDDLE_TETS_MAX][4];
    for (int n = 0; n < thrum_mesh_nodes(mesh, t, node); n++)
      numbers[n] = node[n];
    const int parts = mesh->midsides ? thrum_solid_cut_middles(THRUM_SOLID_TET, numbers, cut)
                                     : thrum_solid_cut(THRUM_SOLID_TET, numbers, cut);
    for (int p = 0; p < parts; p++, end++) {
      for (int c = 0; c < 4; c++)
        made->tets[4 * end + c] = node[cut[p][c]];
      made->region[end] = mesh->tet_region[t];
      if (made->line)
        made->line[end] = mesh->tet_line[t];
      made->number[end] = mesh->tet_number ? mesh->tet_number[t] : t + 1;
    }
    memcpy(mesh->solid_nodes + nodes * t, node, (size_t)nodes * sizeof *node);
    mesh->solid_form[t] = (uint8_t)form;
    mesh->solid_ends[t] = (int32_t)(nodes * (t + 1));
    mesh->solid_tet_ends[t] = (int32_t)end;
  }
  mesh->solid_count = mesh->tet_count;
  mesh->tet_count = end;
  return THRUM_OK;
}

thrum_status thrum_mesh_make_solids(thrum_mesh *mesh, thrum_error *error) {
  enum { PARTS = 8 };
  if (mesh->solid_count > 0 || mesh->tet_count == 0)
    return THRUM_OK;
  const int64_t room = mesh->tet_count * (mesh->midsides ? PARTS : 1);
  if (room > INT32_MAX || 10 * mesh->tet_count > INT32_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "more than 2^31 - 1 nodes of elements");
  tet_arrays made = {0};
  const thrum_status status = cut_tets(mesh, &made, room, error);
  if (status < 0) {
    thrum_mesh_drop_solids(mesh);
    free(made.tets);
    free(made.region);
    free(made.line);
    free(made.number);
    return status;
  }
  free(mesh->tets);
  free(mesh->midsides);
  free(mesh->tet_region);
  free(mesh->tet_line);
  free(mesh->tet_number);
  mesh->midsides = NULL;
  mesh->made_midsides = 0;
  mesh->tets = made.tets;
  mesh->tet_region = made.region;
  mesh->tet_line = made.line;
  mesh->tet_number = made.number;
  return THRUM_OK;
}
