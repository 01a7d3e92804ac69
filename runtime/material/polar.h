/* The rotation of a deformation. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_POLAR_H
#define THRUM_RUNTIME_MATERIAL_POLAR_H

/* turned = R - 1 of the proper rotation R nearest to F = 1 + G, G the `gradient`, also where F is
 * singular or turned inside out; R^T F is then symmetric with at most one negative eigenvalue, its
 * smallest. Where several are equally near it is one of them. Of small G it is exact to rounding
 * beside G. What is not finite gives what is not finite. Any thread. */
void thrum_polar_rotation(double gradient[3][3], double turned[3][3]);

#endif
