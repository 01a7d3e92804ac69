/* Green's strain and principal stretches. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_PRINCIPAL_H
#define THRUM_RUNTIME_MATERIAL_PRINCIPAL_H

/* green = (F^T F - 1)/2 of F = 1 + G, row-major, from G without what cancels. */
void thrum_green_strain(double gradient[3][3], double green[3][3]);

/* grown = s - 1 of the three principal stretches s of a Green strain, in no order, to rounding
 * beside themselves; axes: their unit vectors at rest, as columns. Stretches are not negative: of
 * an inverted F they are those of its mirror image. */
void thrum_principal_stretches(double green[3][3], double grown[3], double axes[3][3]);

/* tensor = sum of value v v^T over the axes v, the columns: that of these principal values. */
void thrum_principal_tensor(const double value[3], double axes[3][3], double tensor[3][3]);

#endif
