/* Quadrature rules of any degree for ten-node tetrahedra, see quadrature.h.
 *
 * 24 points of degree 6: Keast 1986, Moderate-degree tetrahedral quadrature formulas,
 * doi:10.1016/0045-7825(86)90059-9. Beyond, products of Gauss-Jacobi rules on the cube that is
 * folded into a tetrahedron (Stroud 1971, Approximate calculation of multiple integrals, 2.4),
 *   l_1 = x, l_2 = (1 - x) y, l_3 = (1 - x) (1 - y) z, dV ~ (1 - x)^2 (1 - y) dx dy dz,
 * with nodes and weights from the eigenvectors of the Jacobi matrix (Golub, Welsch 1969,
 * doi:10.1090/S0025-5718-69-99647-1).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/quadrature.h"

#include <lapacke.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"

enum { NODES_MAX = THRUM_QUADRATURE_ORDER_MAX / 2 + 1 };

// an orbit of points: all different orders of four barycentric coordinates, and the weight of each
typedef struct orbit {
  double place[4], weight;
} orbit;

static const orbit SIX[4] = {
    {{0.356191386222544953, 0.214602871259151684, 0.214602871259151684, 0.214602871259151684},
     0.0399227502581678706},
    {{0.877978124396165982, 0.0406739585346113397, 0.0406739585346113397, 0.0406739585346113397},
     0.0100772110553206572},
    {{0.0329863295731730594, 0.322337890142275646, 0.322337890142275646, 0.322337890142275646},
     0.0553571815436543906},
    {{0.603005664791649076, 0.269672331458315867, 0.0636610018750175299, 0.0636610018750175299},
     0.0482142857142857143},
};

static bool is_there(const thrum_quadratic_point *points, int count, const double place[4]) {
  for (int p = 0; p < count; p++)
    if (memcmp(points[p].place, place, sizeof points[p].place) == 0)
      return true;
  return false;
}

// all points of an orbit
static void unfold(const orbit *o, thrum_quadratic_point *points, int *count) {
  const int before = *count;
  for (int code = 0; code < 256; code++) {
    const int at[4] = {code & 3, code >> 2 & 3, code >> 4 & 3, code >> 6 & 3};
    if ((1 << at[0] | 1 << at[1] | 1 << at[2] | 1 << at[3]) != 15)
      continue;
    thrum_quadratic_point point = {.weight = o->weight};
    for (int a = 0; a < 4; a++)
      point.place[a] = o->place[at[a]];
    if (!is_there(points + before, *count - before, point.place))
      points[(*count)++] = point;
  }
}

// the rule of n nodes for the weight (1 - x)^power on [0, 1]; the weights add up to 1
static thrum_status gauss_jacobi(int n, double power, double node[NODES_MAX],
                                 double weight[NODES_MAX], thrum_error *error) {
  double off[NODES_MAX] = {0}, vectors[NODES_MAX * NODES_MAX];

  // the recurrence of Jacobi's polynomials with alpha = power, beta = 0, on [-1, 1]
  for (int k = 0; k < n; k++) {
    const double sum = 2 * k + power;
    node[k] = sum > 0 ? -power * power / (sum * (sum + 2)) : -power / (power + 2);
    const double next = sum + 2, i = k + 1;
    off[k] = 2 / next * sqrt(i * i * (i + power) * (i + power) / ((next + 1) * (next - 1)));
  }

  const lapack_int info = LAPACKE_dsteqr(LAPACK_COL_MAJOR, 'I', n, node, off, vectors, n);
  THRUM_TRY(thrum_lapack_status(info, THRUM_NOT_CONVERGED, "the quadrature rule", error));
  for (int k = 0; k < n; k++) {
    node[k] = (1 + node[k]) / 2;
    weight[k] = vectors[k * n] * vectors[k * n];
  }
  return THRUM_OK;
}

// n^3 points of the folded cube
static thrum_status fold_cube(int n, thrum_quadratic_point *points, thrum_error *error) {
  // the folding shrinks the cube by (1 - x)^2 (1 - y), which are the weights of Jacobi
  double node[3][NODES_MAX], weight[3][NODES_MAX];
  for (int axis = 0; axis < 3; axis++)
    THRUM_TRY(gauss_jacobi(n, 2 - axis, node[axis], weight[axis], error));

  for (int p = 0; p < n * n * n; p++) {
    const int i = p / (n * n), j = p / n % n, k = p % n;
    const double x = node[0][i], y = node[1][j], z = node[2][k];
    double *l = points[p].place;
    l[1] = x;
    l[2] = (1 - x) * y;
    l[3] = (1 - x) * (1 - y) * z;
    l[0] = (1 - x) * (1 - y) * (1 - z);
    points[p].weight = weight[0][i] * weight[1][j] * weight[2][k];
  }
  return THRUM_OK;
}

thrum_status thrum_quadrature(int order, bool curved, thrum_quadratic_point **points, int *count,
                              thrum_error *error) {
  if (order != 0 && order != 2 &&
      (order < THRUM_QUADRATURE_ORDER_MIN || order > THRUM_QUADRATURE_ORDER_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the order of the quadrature is %d; it must lie between %d and %d",
                           order, THRUM_QUADRATURE_ORDER_MIN, THRUM_QUADRATURE_ORDER_MAX);

  // the rules that are tabulated for elements in general
  const thrum_quadratic_point *table = NULL;
  if (order == 2)
    table = thrum_quadratic_rule_of_four(count);
  else if (order <= 5)
    table = thrum_quadratic_rule(order == 0 ? curved : order == 5, count);

  const int n = order / 2 + 1, most = table ? *count : order == 6 ? 24 : n * n * n;
  thrum_quadratic_point *made = NULL;
  THRUM_TRY(thrum_reserve(&made, most, sizeof *made, "the quadrature rule", error));

  thrum_status status = THRUM_OK;
  *count = table ? most : 0;
  if (table) {
    memcpy(made, table, sizeof *made * (size_t)most);
  } else if (order == 6) {
    for (size_t o = 0; o < sizeof SIX / sizeof *SIX; o++)
      unfold(&SIX[o], made, count);
  } else {
    status = fold_cube(n, made, error);
    *count = most;
  }

  if (status < 0)
    free(made);
  else
    *points = made;
  return status;
}
