/* The triple product of the edges of a tet.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_MESH_TRIPLE_PRODUCT_H
#define THRUM_MESH_TRIPLE_PRODUCT_H

/* Six times the signed volume that three edges from one vertex span. */
static inline double thrum_mesh_triple(double e[3][3]) {
  return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
         e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
         e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

#endif
