/* The ten-node tetrahedron, see quadratic_tet.h.
 *
 * Rules: 14 points of degree 5 by Walkington 2000, Quadrature on simplices of arbitrary dimension;
 * 11 points of degree 4, found by Gauss-Newton steps from random starts, as by Xiao & Gimbutas
 * 2010, A numerical algorithm for the construction of efficient quadrature rules in two and higher
 * dimensions, doi:10.1016/j.camwa.2009.10.027. The tests integrate all monomials with them.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "core/base/quadratic_tet.h"

#include <math.h>

#include "core/base/vec3.h"

#define BENT 1e-5 /* of an edge: its middle node is off its middle */

const int thrum_quadratic_edges[THRUM_QUADRATIC_EDGES][2] = {{0, 1}, {1, 2}, {2, 0},
                                                             {0, 3}, {1, 3}, {2, 3}};

/* Degree 4; the points lie without symmetry. */
static const thrum_quadratic_point STRAIGHT[11] = {
    {{0.8461933132464668935, 0.0518837053787694128, 0.0249315675679425972, 0.0769914138068210964},
     0.0271559513111256872},
    {{0.4721364720630756517, 0.0923720177182894995, 0.3448178310274109260, 0.0906736791912239227},
     0.1322893705379096914},
    {{0.0782295875508676461, 0.8190617865355985891, 0.0473835959216262652, 0.0553250299919074994},
     0.0339110530149334008},
    {{0.4395098636923671831, 0.3828735627207532459, 0.0872537842185304189, 0.0903627893683491519},
     0.1225419610949778053},
    {{0.0987463611742481174, 0.1015427739274114686, 0.7347036860077633535, 0.0650071788905770604},
     0.0673829996884583263},
    {{0.1085319705709206396, 0.0861869509206767546, 0.4366057394921221001, 0.3686753390162805055},
     0.1313386655237651876},
    {{0.1115621235443911234, 0.4526351404550220119, 0.3523359428134566387, 0.0834667931871302258},
     0.1320146891695440086},
    {{0.3996720761884729736, 0.0960963613164583245, 0.0958339847927472388, 0.4083975777023214629},
     0.1346145288477052962},
    {{0.0245296286144169757, 0.3573359698190208316, 0.2743190740158222619, 0.3438153275507399306},
     0.0414519770021255318},
    {{0.1138965431227702896, 0.4453295682611677287, 0.0692209381906056878, 0.3715529504254562937},
     0.1123468820822594508},
    {{0.0739074357372461768, 0.0920962304900539162, 0.0923206501340991315, 0.7416756836386007754},
     0.0649519217271956135},
};

/* Degree 5: two orbits of four points around the corners, one of six around the edges. */
static const thrum_quadratic_point CURVED[14] = {
    {{0.06734224221009817, 0.31088591926330060, 0.31088591926330060, 0.31088591926330060},
     0.11268792571801585},
    {{0.31088591926330060, 0.06734224221009817, 0.31088591926330060, 0.31088591926330060},
     0.11268792571801585},
    {{0.31088591926330060, 0.31088591926330060, 0.06734224221009817, 0.31088591926330060},
     0.11268792571801585},
    {{0.31088591926330060, 0.31088591926330060, 0.31088591926330060, 0.06734224221009817},
     0.11268792571801585},
    {{0.72179424906732632, 0.09273525031089122, 0.09273525031089122, 0.09273525031089122},
     0.07349304311636194},
    {{0.09273525031089122, 0.72179424906732632, 0.09273525031089122, 0.09273525031089122},
     0.07349304311636194},
    {{0.09273525031089122, 0.09273525031089122, 0.72179424906732632, 0.09273525031089122},
     0.07349304311636194},
    {{0.09273525031089122, 0.09273525031089122, 0.09273525031089122, 0.72179424906732632},
     0.07349304311636194},
    {{0.04550370412564964, 0.04550370412564964, 0.45449629587435035, 0.45449629587435035},
     0.04254602077708146},
    {{0.04550370412564964, 0.45449629587435035, 0.04550370412564964, 0.45449629587435035},
     0.04254602077708146},
    {{0.04550370412564964, 0.45449629587435035, 0.45449629587435035, 0.04550370412564964},
     0.04254602077708146},
    {{0.45449629587435035, 0.04550370412564964, 0.04550370412564964, 0.45449629587435035},
     0.04254602077708146},
    {{0.45449629587435035, 0.04550370412564964, 0.45449629587435035, 0.04550370412564964},
     0.04254602077708146},
    {{0.45449629587435035, 0.45449629587435035, 0.04550370412564964, 0.04550370412564964},
     0.04254602077708146}};

const thrum_quadratic_point *thrum_quadratic_rule(bool curved, int *count) {
  *count = curved ? 14 : 11;
  return curved ? CURVED : STRAIGHT;
}

/* Degree 2: one orbit around the corners, (5 + 3 sqrt 5)/20 and (5 - sqrt 5)/20. */
static const thrum_quadratic_point FOUR[4] = {
    {{0.58541019662496845, 0.13819660112501052, 0.13819660112501052, 0.13819660112501052}, 0.25},
    {{0.13819660112501052, 0.58541019662496845, 0.13819660112501052, 0.13819660112501052}, 0.25},
    {{0.13819660112501052, 0.13819660112501052, 0.58541019662496845, 0.13819660112501052}, 0.25},
    {{0.13819660112501052, 0.13819660112501052, 0.13819660112501052, 0.58541019662496845}, 0.25}};

const thrum_quadratic_point *thrum_quadratic_rule_of_four(int *count) {
  *count = 4;
  return FOUR;
}

void thrum_quadratic_shape(const double place[4], double shape[THRUM_QUADRATIC_NODES]) {
  for (int a = 0; a < 4; a++)
    shape[a] = place[a] * (2 * place[a] - 1);
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++)
    shape[4 + e] = 4 * place[thrum_quadratic_edges[e][0]] * place[thrum_quadratic_edges[e][1]];
}

void thrum_quadratic_slopes(const double place[4], double slopes[THRUM_QUADRATIC_NODES][3]) {
  for (int k = 0; k < 3; k++) {
    // l_0 falls as any other coordinate rises
    for (int a = 0; a < 4; a++) {
      const double slope = a == 0 ? -1 : a == k + 1;
      slopes[a][k] = (4 * place[a] - 1) * slope;
    }

    for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
      const int a = thrum_quadratic_edges[e][0], b = thrum_quadratic_edges[e][1];
      const double slope_a = a == 0 ? -1 : a == k + 1, slope_b = b == 0 ? -1 : b == k + 1;
      slopes[4 + e][k] = 4 * (place[a] * slope_b + place[b] * slope_a);
    }
  }
}

double thrum_quadratic_map(double nodes[THRUM_QUADRATIC_NODES][3],
                           double slopes[THRUM_QUADRATIC_NODES][3], double gradients[9]) {
  // edges of the map, from differences to node 0, so that a body far from the origin keeps digits
  double edge[3][3] = {{0}};
  for (int a = 1; a < THRUM_QUADRATIC_NODES; a++)
    for (int k = 0; k < 3; k++)
      for (int axis = 0; axis < 3; axis++)
        edge[k][axis] += slopes[a][k] * (nodes[a][axis] - nodes[0][axis]);

  // rows of the inverse are cross products over the determinant
  double cofactor[9];
  for (int k = 0; k < 3; k++)
    thrum_cross3(edge[(k + 1) % 3], edge[(k + 2) % 3], cofactor + 3 * k);
  const double determinant = thrum_dot3(edge[0], cofactor);
  for (int n = 0; n < 9 && determinant > 0; n++)
    gradients[n] = cofactor[n] / determinant;
  return determinant;
}

double thrum_quadratic_volume(double nodes[THRUM_QUADRATIC_NODES][3]) {
  double volume = 0, slopes[THRUM_QUADRATIC_NODES][3], gradients[9];
  int points;
  const thrum_quadratic_point *rule = thrum_quadratic_rule(true, &points);
  for (int p = 0; p < points; p++) {
    thrum_quadratic_slopes(rule[p].place, slopes);
    volume += rule[p].weight * thrum_quadratic_map(nodes, slopes, gradients) / 6;
  }
  return volume;
}

bool thrum_quadratic_is_curved(double nodes[THRUM_QUADRATIC_NODES][3]) {
  for (int e = 0; e < THRUM_QUADRATIC_EDGES; e++) {
    const double *from = nodes[thrum_quadratic_edges[e][0]];
    const double *to = nodes[thrum_quadratic_edges[e][1]];
    double length = 0, off = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double d = nodes[4 + e][axis] - (from[axis] + to[axis]) / 2;
      length += (to[axis] - from[axis]) * (to[axis] - from[axis]);
      off += d * d;
    }
    if (off > BENT * BENT * length)
      return true;
  }
  return false;
}
