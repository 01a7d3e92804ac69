/* Elements with rows and points, see solid_elements.h. Solid-shells after Hauptmann, Schweizerhof
 * 1998 (Int. J. Numer. Methods Eng. 42, 49-69), Klinkel, Gruttmann, Wagner 2006 (Comput. Methods
 * Appl. Mech. Eng. 195, 179-201), with the transverse shear of Dvorkin, Bathe 1984 (Eng. Comput. 1,
 * 77-88) or of Lee, Bathe 2004 (Computers & Structures 82, 945-962), and the strain across of
 * Betsch, Stein 1995 (Commun. Numer. Methods Eng. 11, 899-909); enhanced strains after Simo, Rifai
 * 1990 (Int. J. Numer. Methods Eng. 29, 1595-1638), and those of the volume after Simo, Armero,
 * Taylor 1993 (Comput. Methods Appl. Mech. Eng. 110, 359-386). Cost: one QR factor of at
 * most 48 rows an element.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/solid_elements.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/lame.h"
#include "core/base/vec3.h"
#include "precompute/fem/lapack_status.h"

#define PRODUCTS THRUM_SOLID_PRODUCTS_MAX
enum {
  STRAINS = 6, /* 11, 22, 33, 23, 13, 12 */
  VOLUME = STRAINS,
  ROW_POINTS = 16,
  ENHANCED_MAX = 12,
  COLUMNS_MAX = ENHANCED_MAX + PRODUCTS
};

/* Poisson's ratio up to which the change of volume of a tetrahedron of ten nodes is no mean. */
#define POINTWISE 0.3

/* Rows below this share of the largest are rounding. */
#define NO_ROW 1e-13

const int thrum_solid_strain_axes[STRAINS][2] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};

/* --- products of edges ------------------------------------------------------------------------ */

static int product_at(int a, int b) {
  return b * (b + 1) / 2 + a; /* a <= b */
}

void thrum_solid_edges(const int32_t *nodes, int count, const double *of, double *edges) {
  for (int a = 1; a < count; a++)
    for (int c = 0; c < 3; c++)
      edges[3 * (a - 1) + c] = of[3 * (int64_t)nodes[a] + c] - of[3 * (int64_t)nodes[0] + c];
}

void thrum_solid_multiply(int nodes, const double *v, const double *w, double *products) {
  for (int b = 0; b < nodes - 1; b++)
    for (int a = 0; a <= b; a++) {
      const double *va = v + 3 * a, *vb = v + 3 * b, *wa = w + 3 * a, *wb = w + 3 * b;
      products[product_at(a, b)] = va[0] * wb[0] + va[1] * wb[1] + va[2] * wb[2] +
                                   (wa[0] * vb[0] + wa[1] * vb[1] + wa[2] * vb[2]);
    }
}

void thrum_solid_pull(int nodes, const double *stress, const double *w, double scale,
                      double *force) {
  for (int b = 0; b < nodes - 1; b++)
    for (int a = 0; a <= b; a++) {
      const double s = scale * stress[product_at(a, b)];
      for (int c = 0; c < 3; c++) {
        force[3 * a + c] += s * w[3 * b + c];
        force[3 * b + c] += s * w[3 * a + c];
      }
    }
}

void thrum_solid_stress(int rows, int count, const double *matrix, const double *products,
                        double *result) {
  memset(result, 0, (size_t)count * sizeof *result);
  for (int r = 0; r < rows; r++) {
    const double *row = matrix + (size_t)r * (size_t)count;
    double strain = 0;
    for (int k = 0; k < count; k++)
      strain += row[k] * products[k];
    for (int k = 0; k < count; k++)
      result[k] += strain * row[k];
  }
}

/* --- rows ------------------------------------------------------------------------------------- */

/* What the rows of an element are made from. */
typedef struct solid_rows {
  thrum_solid_form form;
  int nodes, products;
  double places[THRUM_SOLID_NODES_MAX][3];
  double centre[3][3], centre_det; /* gradients and determinant there */
  double averaged;                 /* share of the change of volume that is its mean; 0: none is */
  double mean[PRODUCTS];           /* the row of its mean */
} solid_rows;

/* A point at which the strains of an element are taken. */
typedef struct row_point {
  double place[3], weight, gradients[3][3];
  double centre_share;           /* of the determinant at the centre in that here */
  double root[STRAINS][STRAINS]; /* R of the elasticity there, C = R^T R */
} row_point;

/* Adds scale times the covariant strain of directions i and j at a place. */
static void add_strain(const solid_rows *r, const double place[3], int i, int j, double scale,
                       double row[PRODUCTS]) {
  double slopes[THRUM_SOLID_NODES_MAX][3];
  thrum_solid_shape_at(r->form, place, NULL, slopes);
  for (int b = 1; b < r->nodes; b++)
    for (int a = 1; a <= b; a++) {
      const double both = slopes[a][i] * slopes[b][j] + slopes[b][i] * slopes[a][j];
      row[product_at(a - 1, b - 1)] += scale * (a == b ? both / 4 : both / 2);
    }
}

/* The covariant strains of a solid-shell hexahedron that are tied. */
static bool tie_hexahedron(const solid_rows *r, const double x[3], int strain, double *row) {
  // shears across, from the middles of the opposite sides
  if (strain == 3 || strain == 4) {
    const int along = strain == 4 ? 1 : 0, of = 1 - along;
    for (int side = -1; side <= 1; side += 2) {
      double place[3] = {0, 0, 0};
      place[along] = side;
      add_strain(r, place, of, 2, (1 + side * x[along]) / 2, row);
    }
    return true;
  }
  if (strain != 2)
    return false;

  // the strain across, from the four edges through the thickness
  for (int a = -1; a <= 1; a += 2)
    for (int b = -1; b <= 1; b += 2) {
      const double place[3] = {a, b, 0};
      add_strain(r, place, 2, 2, (1 + a * x[0]) * (1 + b * x[1]) / 4, row);
    }
  return true;
}

/* Those of a solid-shell wedge: with c = E_st(2) - E_rt(1) - E_st(3) + E_rt(3), 1, 2 and 3 the
 * middles of the sides s = 0, r = 0 and r + s = 1, E_rt = E_rt(1) + c s, E_st = E_st(2) - c r. */
static bool tie_wedge(const solid_rows *r, const double x[3], int strain, double *row) {
  static const double middle[3][3] = {{0.5, 0, 0}, {0, 0.5, 0}, {0.5, 0.5, 0}};
  if (strain == 3 || strain == 4) {
    const double c = strain == 4 ? x[1] : -x[0];
    add_strain(r, middle[strain == 4 ? 0 : 1], strain == 4 ? 0 : 1, 2, 1, row);
    add_strain(r, middle[1], 1, 2, c, row);
    add_strain(r, middle[0], 0, 2, -c, row);
    add_strain(r, middle[2], 1, 2, -c, row);
    add_strain(r, middle[2], 0, 2, c, row);
    return true;
  }
  if (strain != 2)
    return false;
  for (int corner = 0; corner < 3; corner++) {
    const double place[3] = {corner == 1, corner == 2, 0};
    add_strain(r, place, 2, 2, corner == 0 ? 1 - x[0] - x[1] : x[corner - 1], row);
  }
  return true;
}

static void covariant(const solid_rows *r, const double x[3], int strain, double row[PRODUCTS]) {
  memset(row, 0, PRODUCTS * sizeof *row);
  if (r->form == THRUM_FORM_SHELL8 && tie_hexahedron(r, x, strain, row))
    return;
  if (r->form == THRUM_FORM_SHELL6 && tie_wedge(r, x, strain, row))
    return;
  add_strain(r, x, thrum_solid_strain_axes[strain][0], thrum_solid_strain_axes[strain][1], 1, row);
}

/* An enhanced strain: which one, or VOLUME, the three Cartesian normal ones alike, times powers of
 * the natural coordinates. */
typedef struct enhanced {
  int strain, powers[3];
} enhanced;

static const enhanced shell8_enhanced[] = {{0, {1, 0, 0}}, {1, {0, 1, 0}}, {5, {1, 0, 0}},
                                           {5, {0, 1, 0}}, {2, {0, 0, 1}}, {2, {1, 0, 1}},
                                           {2, {0, 1, 1}}};
static const enhanced hexahedron_enhanced[] = {
    {0, {1, 0, 0}}, {1, {0, 1, 0}},      {2, {0, 0, 1}},      {5, {1, 0, 0}},
    {5, {0, 1, 0}}, {4, {1, 0, 0}},      {4, {0, 0, 1}},      {3, {0, 1, 0}},
    {3, {0, 0, 1}}, {VOLUME, {1, 1, 0}}, {VOLUME, {0, 1, 1}}, {VOLUME, {1, 0, 1}}};
static const enhanced shell6_enhanced[] = {{2, {0, 0, 1}}};
static const enhanced wedge_enhanced[] = {{2, {0, 0, 1}}, {3, {0, 0, 1}}, {4, {0, 0, 1}}};

static const struct {
  const enhanced *list;
  int count;
} enhanced_of[THRUM_FORMS] = {
    [THRUM_FORM_WEDGE6] = {wedge_enhanced, 3},
    [THRUM_FORM_HEX8] = {hexahedron_enhanced, 12},
    [THRUM_FORM_SHELL6] = {shell6_enhanced, 1},
    [THRUM_FORM_SHELL8] = {shell8_enhanced, 7},
};

/* How covariant strains turn into Cartesian ones, shears doubled, by the gradients of the natural
 * coordinates. */
static void turn_of(double gradients[3][3], double turn[STRAINS][STRAINS]) {
  for (int to = 0; to < STRAINS; to++)
    for (int from = 0; from < STRAINS; from++) {
      const int c = thrum_solid_strain_axes[to][0], d = thrum_solid_strain_axes[to][1];
      const int i = thrum_solid_strain_axes[from][0], j = thrum_solid_strain_axes[from][1];
      double sum = gradients[i][c] * gradients[j][d];
      if (i != j)
        sum += gradients[j][c] * gradients[i][d];
      turn[to][from] = to < 3 ? sum : 2 * sum;
    }
}

/* left times right */
static void multiply(double left[STRAINS][STRAINS], double right[STRAINS][STRAINS], double scale,
                     double result[STRAINS][STRAINS]) {
  for (int i = 0; i < STRAINS; i++)
    for (int j = 0; j < STRAINS; j++) {
      result[i][j] = 0;
      for (int k = 0; k < STRAINS; k++)
        result[i][j] += scale * left[i][k] * right[k][j];
    }
}

/* The row of the change of volume, tr E, at a point. */
static void dilatation(const solid_rows *r, row_point *at, double trace[PRODUCTS]) {
  double turn[STRAINS][STRAINS], row[PRODUCTS];
  turn_of(at->gradients, turn);
  memset(trace, 0, PRODUCTS * sizeof *trace);
  for (int k = 0; k < STRAINS; k++) {
    const double share = turn[0][k] + turn[1][k] + turn[2][k];
    covariant(r, at->place, k, row);
    for (int p = 0; p < r->products; p++)
      trace[p] += share * row[p];
  }
}

/* The rows of strains at one point of weight w, and beside them the columns of the enhanced ones,
 * into a column-major matrix: enhanced first. */
static void fill_point(solid_rows *r, row_point *at, int first, int height, double *matrix) {
  double turn[STRAINS][STRAINS], weighted[STRAINS][STRAINS], row[STRAINS][PRODUCTS];
  const enhanced *list = enhanced_of[r->form].list;
  const int count = enhanced_of[r->form].count;
  const double share = sqrt(at->weight) * at->centre_share;
  turn_of(at->gradients, turn);
  multiply(at->root, turn, sqrt(at->weight), weighted);
  for (int k = 0; k < STRAINS; k++)
    covariant(r, at->place, k, row[k]);
  for (int p = 0; p < r->products; p++)
    for (int i = 0; i < STRAINS; i++) {
      double sum = 0;
      for (int k = 0; k < STRAINS; k++)
        sum += weighted[i][k] * row[k][p];
      matrix[(count + p) * height + first + i] = sum;
    }

  // the mean dilatation in the place of that of the point
  double trace[PRODUCTS];
  if (r->averaged > 0)
    dilatation(r, at, trace);
  for (int p = 0; p < r->products && r->averaged > 0; p++)
    for (int i = 0; i < STRAINS; i++)
      matrix[(count + p) * height + first + i] +=
          sqrt(at->weight) * (at->root[i][0] + at->root[i][1] + at->root[i][2]) * r->averaged *
          (r->mean[p] - trace[p]) / 3;

  // enhanced ones are turned by the centre, so that constant strains do no work on them
  turn_of(r->centre, turn);
  multiply(at->root, turn, share, weighted);
  for (int e = 0; e < count; e++) {
    double value = 1;
    for (int d = 0; d < 3; d++)
      value *= list[e].powers[d] ? at->place[d] : 1;
    for (int i = 0; i < STRAINS; i++) {
      const double *root = at->root[i];
      matrix[e * height + first + i] =
          value * (list[e].strain == VOLUME ? share * (root[0] + root[1] + root[2])
                                            : weighted[i][list[e].strain]);
    }
  }
}

/* The root of an isotropic elasticity, upper triangular. */
static void isotropic_root(double lambda, double mu, double root[STRAINS][STRAINS]) {
  memset(root, 0, STRAINS * sizeof root[0]);
  double rest[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      rest[i][j] = lambda + (i == j ? 2 * mu : 0);

  // Cholesky's factor of the normal part, whose transpose is stored
  for (int i = 0; i < 3; i++) {
    for (int j = i; j < 3; j++) {
      double sum = rest[i][j];
      for (int k = 0; k < i; k++)
        sum -= root[k][i] * root[k][j];
      root[i][j] = i == j ? sqrt(sum) : sum / root[i][i];
    }
  }
  for (int i = 3; i < STRAINS; i++)
    root[i][i] = sqrt(mu);
}

/* Eliminates the enhanced columns and keeps the independent rows of the rest; `rows` has room for
 * products x products. */
static thrum_status reduce_rows(const solid_rows *r, int height, double *matrix, double *rows,
                                int *count, thrum_error *error) {
  const int m = enhanced_of[r->form].count, columns = m + r->products;
  lapack_int pivot[COLUMNS_MAX] = {0};
  double tau[COLUMNS_MAX];
  for (int e = 0; e < m; e++)
    pivot[e] = 1;
  THRUM_TRY(thrum_lapack_status(
      LAPACKE_dgeqp3(LAPACK_COL_MAJOR, height, columns, matrix, height, pivot, tau), THRUM_SINGULAR,
      "the strains of an element have no QR factor", error));

  // the triangle below and behind the enhanced columns
  *count = 0;
  memset(rows, 0, (size_t)(r->products * r->products) * sizeof *rows);
  for (int k = m; k < columns && k < height; k++) {
    if (!(fabs(matrix[k * height + k]) > NO_ROW * fabs(matrix[m * height + m])))
      break;
    for (int j = k; j < columns; j++)
      rows[(k - m) * r->products + pivot[j] - 1 - m] = matrix[j * height + k];
    ++*count;
  }
  return THRUM_OK;
}

/* The enhanced parameters that make the energy least, less their sign, for each product: into the
 * first rows of the columns behind the enhanced ones. */
static thrum_status fit_enhanced(const solid_rows *r, int height, double *matrix,
                                 thrum_error *error) {
  const int m = enhanced_of[r->form].count;
  if (m == 0)
    return THRUM_OK;
  return thrum_lapack_status(LAPACKE_dgels(LAPACK_COL_MAJOR, 'N', height, m, r->products, matrix,
                                           height, matrix + m * height, height),
                             THRUM_SINGULAR, "the enhanced strains of an element have no QR factor",
                             error);
}

static void centre_of(thrum_solid_form form, double place[3]) {
  static const double centres[THRUM_SOLID_KINDS][3] = {
      [THRUM_SOLID_TET] = {0.25, 0.25, 0.25}, [THRUM_SOLID_WEDGE] = {1.0 / 3, 1.0 / 3, 0}};
  memcpy(place, centres[thrum_solid_forms[form].kind], 3 * sizeof *place);
}

/* --- elements --------------------------------------------------------------------------------- */

typedef struct solid_making {
  const thrum_solid_elements *e;
  const thrum_mesh *mesh; /* NULL: places are as they were */
  const double *lambda, *mu;
  double *scratch; /* products x products */
  double *matrix;  /* the strains of an element, of the most layers */
  thrum_error *error;
} solid_making;

static thrum_status inside_out(const solid_making *m, int64_t s, double det) {
  const int64_t t = thrum_solid_tet(m->e, s);
  return thrum_error_set(m->error, THRUM_BAD_VALUE,
                         "%s is turned inside out at a point: the map of its nodes has determinant "
                         "%g m^3 there, which must be positive; mend it, or cut it by --element "
                         "tet",
                         thrum_mesh_tet_text(m->mesh, t).text, det);
}

static void places_of(const solid_making *m, int64_t s, double (*places)[3]) {
  const int32_t *nodes = thrum_solid_nodes(m->e, s);
  for (int n = 0; n < thrum_solid_node_count(m->e, s); n++)
    memcpy(places[n], m->e->vertices + 3 * (int64_t)nodes[n], sizeof places[n]);
}

/* Weights and gradients at the points. */
static thrum_status measure(const solid_making *m, int64_t s) {
  const thrum_solid_elements *e = m->e;
  thrum_solid_table *table = &e->tables[e->form[s]];
  double places[THRUM_SOLID_NODES_MAX][3], jacobian[3][3], gradients[3][3];
  places_of(m, s, places);
  e->volume[s] = 0;
  for (int p = 0; p < table->points; p++) {
    const int64_t point = e->point_begin[s] + p;
    const double det = thrum_solid_map(table->nodes, places, table->slopes[p], jacobian, gradients);
    if (!(det > 0) || !isfinite(1 / det))
      return inside_out(m, s, det);
    memcpy(e->gradient + 9 * point, gradients, sizeof gradients);
    e->weight[point] = det * table->weight[p];
    e->volume[s] += e->weight[point];
  }
  return THRUM_OK;
}

/* R of an element at a place with this map, in a layer of its region. */
static thrum_status take_root(const solid_making *m, int64_t s, int layer, double jacobian[3][3],
                              thrum_elastic_matrix root) {
  const thrum_solid_elements *e = m->e;
  const int32_t region = e->region[s];
  if (thrum_solid_layers(e, region) == 0) {
    isotropic_root(m->lambda[region], m->mu[region], root);
    return THRUM_OK;
  }

  // the normal of a sheet stands on both directions in it
  const double *row = e->elastic + THRUM_ELASTIC_NUMBERS * (e->elastic_begin[region] + layer);
  double normal[3], axes[3][3];
  thrum_elastic_matrix own;
  thrum_cross3(jacobian[0], jacobian[1], normal);
  const double length = sqrt(thrum_dot3(normal, normal));
  for (int c = 0; c < 3; c++)
    normal[c] /= length;
  const bool sheet = row[THRUM_ELASTIC_THICKNESS] > 0;
  if (!thrum_elastic_root(row, own) || !thrum_elastic_axes(row, sheet ? normal : NULL, axes))
    return thrum_error_set(m->error, THRUM_BAD_VALUE,
                           "the material of region %d has no direction 1 in element %lld: it "
                           "stands on the sheet there, or its constants have no positive energy",
                           (int)region + 1, (long long)s + 1);
  thrum_elastic_turn(own, axes, root);
  return THRUM_OK;
}

/* Puts a point of an element, which is through its thickness, into a layer of it; returns the share
 * of the layer. */
static double put_in_layer(const thrum_solid_elements *e, int64_t s, int layer, double place[3]) {
  const int layers = thrum_solid_layers(e, e->region[s]);
  double sum = 0, below = 0, own = 0;
  for (int l = 0; l < layers; l++) {
    const double *row = e->elastic + THRUM_ELASTIC_NUMBERS * (e->elastic_begin[e->region[s]] + l);
    sum += row[THRUM_ELASTIC_THICKNESS];
    below += l < layer ? row[THRUM_ELASTIC_THICKNESS] : 0;
    own = l == layer ? row[THRUM_ELASTIC_THICKNESS] : own;
  }
  if (layers < 2)
    return 1;
  place[2] = (2 * below + own * (1 + place[2])) / sum - 1;
  return own / sum;
}

/* A point of an element at a place, of this weight in natural coordinates. */
static thrum_status take_point(const solid_making *m, int64_t s, solid_rows *r, int layer,
                               const double place[3], double weight, row_point *at) {
  double slopes[THRUM_SOLID_NODES_MAX][3], jacobian[3][3];
  memcpy(at->place, place, sizeof at->place);
  thrum_solid_shape_at(r->form, place, NULL, slopes);
  const double det = thrum_solid_map(r->nodes, r->places, slopes, jacobian, at->gradients);
  if (!(det > 0) || !isfinite(1 / det))
    return inside_out(m, s, det);
  at->weight = det * weight;
  at->centre_share = r->centre_det * weight / at->weight;
  return take_root(m, s, layer, jacobian, at->root);
}

/* How much of the change of volume is the mean of the element: what is left of it at each point
 * resists as a material of POINTWISE does, (1 - share)^2 K = K_0, so that nothing is too soft. */
static double averaged_share(double lambda, double mu) {
  const thrum_lame usual = thrum_lame_of(2 * (1 + POINTWISE), POINTWISE);
  const double most = usual.lambda + 2.0 / 3, bulk = lambda / mu + 2.0 / 3;
  return bulk > most ? 1 - sqrt(most / bulk) : 0;
}

/* Strains of an element at all points of all layers, times the root of the elasticity and of the
 * weight: column-major, the enhanced ones first. */
static thrum_status fill_matrix(const solid_making *m, int64_t s, solid_rows *r, int *height) {
  const thrum_solid_elements *e = m->e;
  const thrum_solid_table *table = &e->tables[e->form[s]];
  const int layers = thrum_solid_layers(e, e->region[s]);
  *height = STRAINS * table->points * (layers > 0 ? layers : 1);
  *r = (solid_rows){.form = (thrum_solid_form)e->form[s],
                    .nodes = table->nodes,
                    .products = thrum_solid_products(table->nodes)};
  places_of(m, s, r->places);

  // the map at the centre
  double centre[3], slopes[THRUM_SOLID_NODES_MAX][3], jacobian[3][3];
  centre_of(r->form, centre);
  thrum_solid_shape_at(r->form, centre, NULL, slopes);
  r->centre_det = thrum_solid_map(r->nodes, r->places, slopes, jacobian, r->centre);
  if (!(r->centre_det > 0) || !isfinite(1 / r->centre_det))
    return inside_out(m, s, r->centre_det);

  // the mean over the points of an element of one layer
  r->averaged = r->form == THRUM_FORM_MEAN10
                    ? averaged_share(m->lambda[e->region[s]], m->mu[e->region[s]])
                    : 0;
  for (int n = 0; n < table->points && r->averaged > 0; n++) {
    double trace[PRODUCTS];
    row_point at;
    THRUM_TRY(take_point(m, s, r, 0, table->place[n], table->weight[n], &at));
    dilatation(r, &at, trace);
    for (int p = 0; p < r->products; p++)
      r->mean[p] += trace[p] * at.weight / e->volume[s];
  }

  for (int first = 0, n = 0; first < *height; first += STRAINS, n++) {
    const int layer = n / table->points, p = n % table->points;
    double place[3];
    row_point at;
    memcpy(place, table->place[p], sizeof place);
    const double share = put_in_layer(e, s, layer, place);
    THRUM_TRY(take_point(m, s, r, layer, place, share * table->weight[p], &at));
    fill_point(r, &at, first, *height, m->matrix);
  }
  return THRUM_OK;
}

/* The rows of an element into the scratch. */
static thrum_status make_rows(const solid_making *m, int64_t s, int *count) {
  const thrum_solid_elements *e = m->e;
  solid_rows r;
  int height = 0;
  *count = 0;
  if (m->lambda[e->region[s]] == 0 && m->mu[e->region[s]] == 0)
    return THRUM_OK;
  THRUM_TRY(fill_matrix(m, s, &r, &height));
  return reduce_rows(&r, height, m->matrix, m->scratch, count, m->error);
}

/* Room for the strains of any element. */
static thrum_status reserve_matrix(solid_making *m) {
  const thrum_solid_elements *e = m->e;
  int64_t layers = 1;
  for (int64_t s = 0; s < e->count; s++)
    if (thrum_solid_layers(e, e->region[s]) > layers)
      layers = thrum_solid_layers(e, e->region[s]);
  return thrum_reserve(&m->matrix, (int64_t)STRAINS * ROW_POINTS * COLUMNS_MAX * layers,
                       sizeof *m->matrix, "the elements", m->error);
}

/* The rows of all elements, one element after the other. */
static thrum_status make_all_rows(solid_making *m) {
  const thrum_solid_elements *e = m->e;
  for (int64_t s = 0; s < e->count; s++) {
    int count = 0;
    const int products = thrum_solid_products(thrum_solid_node_count(e, s));
    if (thrum_solid_has_rows(e, s)) {
      m->scratch = e->rows + e->row_begin[s];
      THRUM_TRY(make_rows(m, s, &count));
    }
    e->row_begin[s + 1] = e->row_begin[s] + count * products;
  }
  return THRUM_OK;
}

static thrum_status measure_all(solid_making *m, thrum_solid_elements *e, thrum_scope *memory) {
  int64_t room = 0;
  for (int64_t s = 0; s < e->count; s++) {
    THRUM_TRY(measure(m, s));
    const int products = thrum_solid_products(thrum_solid_node_count(e, s));
    room += thrum_solid_has_rows(e, s) ? products * products : 0;
  }

  // as many rows as there may be at most; what is not used is never touched
  e->rows = thrum_scope_allocate(memory, room, sizeof *e->rows);
  THRUM_TRY(memory->status);
  thrum_status status = reserve_matrix(m);
  THRUM_THEN(status, make_all_rows(m));
  free(m->matrix);
  return status;
}

/* The layers of each region and, where directions are fixed in space, its C. */
static thrum_status take_elastic(const thrum_mesh *mesh, thrum_solid_elements *e,
                                 thrum_scope *memory, thrum_error *error) {
  if (mesh->elastic_count == 0)
    return THRUM_OK;
  const int64_t regions = mesh->region_count;
  e->elastic = mesh->elastic;
  e->elastic_begin = thrum_scope_allocate(memory, regions + 1, sizeof *e->elastic_begin);
  e->stiffness =
      thrum_scope_allocate(memory, 2 * STRAINS * STRAINS * regions, sizeof *e->stiffness);
  THRUM_TRY(memory->status);
  for (int64_t i = 0; i <= regions; i++)
    e->elastic_begin[i] = thrum_mesh_elastic_begin(mesh, i);
  for (int32_t i = 0; i < regions; i++) {
    thrum_elastic_matrix own, root, stiffness;
    double axes[3][3];
    if (!thrum_solid_stiffness(e, i))
      continue;
    const double *row = e->elastic + THRUM_ELASTIC_NUMBERS * e->elastic_begin[i];
    if (!thrum_elastic_root(row, own) || !thrum_elastic_axes(row, NULL, axes))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "the elastic constants of region %d have no positive energy, or its "
                             "directions are parallel",
                             (int)i + 1);
    thrum_elastic_turn(own, axes, root);
    thrum_elastic_stiffness(root, stiffness);
    memcpy(e->stiffness + 2 * STRAINS * STRAINS * i, stiffness, sizeof stiffness);
    memcpy(e->stiffness + 2 * STRAINS * STRAINS * i + STRAINS * STRAINS, root, sizeof root);
  }
  return THRUM_OK;
}

/* Layers are those of solid-shells, which have a thickness. */
static thrum_status check_layers(const thrum_solid_elements *e, thrum_error *error) {
  for (int64_t s = 0; s < e->count; s++)
    if (thrum_solid_layers(e, e->region[s]) > 0 && !thrum_solid_stiffness(e, e->region[s]) &&
        e->form[s] != THRUM_FORM_SHELL6 && e->form[s] != THRUM_FORM_SHELL8)
      return thrum_error_set(error, THRUM_UNSUPPORTED,
                             "region %d is a laminate, and its elements are %s: layers are those "
                             "of solid-shells (thrum mesh --thickness, or --element shell)",
                             (int)e->region[s] + 1, thrum_solid_forms[e->form[s]].name);
  return THRUM_OK;
}

thrum_status thrum_solid_elements_make(const thrum_mesh *mesh, const double *lambda,
                                       const double *mu, thrum_scope *memory,
                                       thrum_solid_elements *made, thrum_error *error) {
  const int64_t count = mesh->solid_count;
  thrum_solid_elements *e = made;
  *e = (thrum_solid_elements){.count = count,
                              .vertices = mesh->vertices,
                              .form = mesh->solid_form,
                              .ends = mesh->solid_ends,
                              .nodes = mesh->solid_nodes,
                              .tet_ends = mesh->solid_tet_ends};
  e->region = thrum_scope_allocate(memory, count, sizeof *e->region);
  e->tables = thrum_scope_allocate(memory, THRUM_FORMS, sizeof *e->tables);
  e->point_begin = thrum_scope_allocate(memory, count + 1, sizeof *e->point_begin);
  e->row_begin = thrum_scope_allocate(memory, count + 1, sizeof *e->row_begin);
  e->volume = thrum_scope_allocate(memory, count, sizeof *e->volume);
  THRUM_TRY(memory->status);

  for (int form = 0; form < THRUM_FORMS; form++)
    thrum_solid_table_make((thrum_solid_form)form, &e->tables[form]);
  for (int64_t s = 0; s < count; s++) {
    e->region[s] = mesh->tet_region[thrum_solid_tet(e, s)];
    e->point_begin[s + 1] = e->point_begin[s] + e->tables[e->form[s]].points;
  }
  THRUM_TRY(take_elastic(mesh, e, memory, error));
  THRUM_TRY(check_layers(e, error));
  e->weight = thrum_scope_allocate(memory, e->point_begin[count], sizeof *e->weight);
  e->gradient = thrum_scope_allocate(memory, 9 * e->point_begin[count], sizeof *e->gradient);
  THRUM_TRY(memory->status);
  solid_making m = {.e = e, .mesh = mesh, .lambda = lambda, .mu = mu, .error = error};
  return measure_all(&m, e, memory);
}

thrum_status thrum_solid_elements_renew(thrum_solid_elements *made, const double *lambda,
                                        const double *mu, thrum_error *error) {
  solid_making m = {.e = made, .lambda = lambda, .mu = mu, .error = error};
  thrum_status status = reserve_matrix(&m);
  THRUM_THEN(status, make_all_rows(&m));
  free(m.matrix);
  return status;
}

/* The same with room for the strains: what the enhanced parameters give is taken off the strains at
 * the points of the table, in the outer layers. */
static thrum_status stress_matrix(const solid_making *m, int64_t s, double *matrix) {
  const thrum_solid_elements *e = m->e;
  const thrum_solid_table *table = &e->tables[e->form[s]];
  const int enhanced_count = enhanced_of[e->form[s]].count;
  const int layers = thrum_solid_layers(e, e->region[s]);
  solid_rows r;
  int height = 0;
  THRUM_TRY(fill_matrix(m, s, &r, &height));
  THRUM_TRY(fit_enhanced(&r, height, m->matrix, m->error));
  const double *fit = m->matrix + enhanced_count * height;

  for (int p = 0; p < table->points; p++) {
    double strains[STRAINS * COLUMNS_MAX], *behind = strains + enhanced_count * STRAINS;
    const int layer = layers > 0 && table->place[p][2] > 0 ? layers - 1 : 0;
    row_point at;
    THRUM_TRY(take_point(m, s, &r, layer, table->place[p], 1, &at));
    at.weight = 1;
    fill_point(&r, &at, 0, STRAINS, strains);
    for (int k = 0; k < STRAINS; k++)
      for (int c = 0; c < r.products; c++) {
        double sum = 0;
        for (int i = 0; i < STRAINS; i++) {
          double strain = behind[c * STRAINS + i];
          for (int n = 0; n < enhanced_count; n++)
            strain -= strains[n * STRAINS + i] * fit[c * height + n];
          sum += at.root[i][k] * strain;
        }
        matrix[(STRAINS * p + k) * r.products + c] = sum;
      }
  }
  return THRUM_OK;
}

thrum_status thrum_solid_stress_matrix(const thrum_solid_elements *e, int64_t s,
                                       const double *lambda, const double *mu, double *matrix,
                                       thrum_error *error) {
  solid_making m = {.e = e, .lambda = lambda, .mu = mu, .error = error};
  thrum_status status = reserve_matrix(&m);
  THRUM_THEN(status, stress_matrix(&m, s, matrix));
  free(m.matrix);
  return status;
}

void thrum_solid_gradients(const thrum_solid_elements *e, int64_t s, int p,
                           double gradients[THRUM_SOLID_NODES_MAX][3]) {
  const thrum_solid_table *table = &e->tables[e->form[s]];
  const double *g = e->gradient + 9 * (e->point_begin[s] + p);
  for (int n = 0; n < table->nodes; n++)
    for (int c = 0; c < 3; c++)
      gradients[n][c] = table->slopes[p][n][0] * g[c] + table->slopes[p][n][1] * g[3 + c] +
                        table->slopes[p][n][2] * g[6 + c];
}
