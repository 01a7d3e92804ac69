/* Plastic flow at a point, design 19: the deformation F = F_e F_p has an elastic part, which the
 * law answers to, and a plastic one, of no change of volume, which stays. The functions are pure,
 * for any thread, and their bits are the same on every machine.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_PLASTIC_FLOW_H
#define THRUM_RUNTIME_MATERIAL_PLASTIC_FLOW_H

#include <stdbool.h>

#include "runtime/material/material_law.h"
#include "thrum/state.h"

/* Lets a point flow for the time dt [s]: flowed = F_p^-1 - 1 afterwards, from `plastic`, the same
 * before, and from the gradient of F_e, `share` (1 or less) of what the rule asks for. False, and
 * nothing written, where the strain is within the yield. */
bool thrum_plastic_flow(const thrum_plastic *material, double dt, double elastic[3][3],
                        double plastic[3][3], double share, double flowed[3][3]);

/* A point that may flow. */
typedef struct thrum_plastic_point {
  const thrum_plastic *material;
  double dt;    /* [s] */
  double share; /* 1, or less of what the rule asks for */
  /* The strain energy of the point where F_p^-1 - 1 is `plastic` [J]. */
  double (*energy)(const void *context, double plastic[3][3]);
  const void *context;
} thrum_plastic_point;

/* Lets a point with this gradient of F_e flow as far as its bound and its energy allow: `plastic`,
 * F_p^-1 - 1, becomes that after the flow, and *taken grows by the energy that the flow took [J],
 * never a negative one. False, and nothing changed, where nothing flows. */
bool thrum_plastic_settle(const thrum_plastic_point *point, double elastic[3][3],
                          double plastic[3][3], double *taken);

/* elastic = F_e - 1 of F = 1 + gradient and F_p^-1 = 1 + plastic. */
void thrum_elastic_gradient(double gradient[3][3], double plastic[3][3], double elastic[3][3]);

/* matrix = matrix (1 + plastic)^T: a derivative by F from one by F_e. */
void thrum_draw_back(double plastic[3][3], double matrix[3][3]);

/* thrum_law_stress of a point that has flowed: its energy, and the derivative by F with F_p held.
 */
double thrum_flowed_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                           double plastic[3][3], double stress[3][3]);

/* The norm of the logarithms of the principal stretches of F_p. */
double thrum_plastic_strain(double plastic[3][3]);

#endif
