/* Plastic flow, design (19.4): with the principal stretches s and axes v of F_e and the deviator
 * d = dev(s - 1), where |d| is beyond the yield,
 *   F_p^-1 becomes F_p^-1 sum exp(-x d) v v^T,  x = (1 - exp(-creep dt)) (1 - yield/|d|).
 * As the deviator has no trace, the volume stays. The flow rule is that of O'Brien, Bargteil &
 * Hodgins 2002, doi:10.1145/566654.566579, with the rate of Mueller & Gross 2004, for a product of
 * deformations (Irving, Teran & Fedkiw 2004, doi:10.1145/1028523.1028541).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/material/plastic_flow.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "core/base/vec3.h"
#include "runtime/material/elementary.h"
#include "runtime/material/principal.h"

#define MODERATE 1e2 /* entries up to which a flow loses no principal stretch */

enum {
  HALVINGS_MAX = 12, // of what flows, until it takes energy
  BOUND_MAX = 64,    // the same until it stays within its bound, beyond which nothing is left
  STEP_MOST = 100    // logarithm of what flows in a step: more is beyond the range of numbers
};

static void stretches_of(double gradient[3][3], double grown[3], double axes[3][3]) {
  double green[3][3];
  thrum_green_strain(gradient, green);
  thrum_principal_stretches(green, grown, axes);
}

/* No smaller than the norm of the principal strains s - 1 = 2 e/(1 + s), and with it of their
 * deviator: the norm of Green's strain bounds its eigenvalues e = (s^2 - 1)/2. Most points are told
 * by it to be within the yield, without their axes. */
static double strain_bound(double green[3][3]) {
  const double size = sqrt(thrum_dot3(green[0], green[0]) + thrum_dot3(green[1], green[1]) +
                           thrum_dot3(green[2], green[2]));
  return 2 * size / (1 + sqrt(fmax(1 - 2 * size, 0)));
}

bool thrum_plastic_flow(const thrum_plastic *material, double dt, double elastic[3][3],
                        double plastic[3][3], double share, double flowed[3][3]) {
  double deviator[3], axes[3][3], green[3][3];
  thrum_green_strain(elastic, green);
  if (strain_bound(green) <= material->yield)
    return false;
  thrum_principal_stretches(green, deviator, axes);
  const double mean = (deviator[0] + deviator[1] + deviator[2]) / 3;
  for (int k = 0; k < 3; k++)
    deviator[k] -= mean;

  // NaN does not flow
  const double size = sqrt(thrum_dot3(deviator, deviator));
  if (!(size > material->yield))
    return false;
  const double asked =
      -thrum_exponential_growth(-material->creep * dt) * (1 - material->yield / size);
  const double rate = fmin(asked, STEP_MOST / size);

  // what F_p^-1 is multiplied by, less 1
  double along[3], factor[3][3];
  for (int k = 0; k < 3; k++)
    along[k] = thrum_exponential_growth(-share * rate * deviator[k]);
  thrum_principal_tensor(along, axes, factor);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      flowed[i][j] = plastic[i][j] + factor[i][j] + plastic[i][0] * factor[0][j] +
                     plastic[i][1] * factor[1][j] + plastic[i][2] * factor[2][j];
  return true;
}

void thrum_elastic_gradient(double gradient[3][3], double plastic[3][3], double elastic[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      elastic[i][j] = gradient[i][j] + plastic[i][j] + gradient[i][0] * plastic[0][j] +
                      gradient[i][1] * plastic[1][j] + gradient[i][2] * plastic[2][j];
}

void thrum_draw_back(double plastic[3][3], double matrix[3][3]) {
  for (int i = 0; i < 3; i++) {
    const double row[3] = {matrix[i][0], matrix[i][1], matrix[i][2]};
    for (int j = 0; j < 3; j++)
      matrix[i][j] += thrum_dot3(row, plastic[j]);
  }
}

double thrum_flowed_stress(thrum_law law, double lambda, double mu, double gradient[3][3],
                           double plastic[3][3], double stress[3][3]) {
  double elastic[3][3];
  thrum_elastic_gradient(gradient, plastic, elastic);
  const double energy = thrum_law_stress(law, lambda, mu, elastic, stress);
  thrum_draw_back(plastic, stress);
  return energy;
}

double thrum_plastic_strain(double plastic[3][3]) {
  double grown[3], axes[3][3];
  stretches_of(plastic, grown, axes);

  // those of the inverse have logarithms of the other sign; a flat point has none
  for (int k = 0; k < 3; k++)
    grown[k] = grown[k] > -1 ? grown[k] - thrum_beyond_logarithm(grown[k]) : INFINITY;
  return sqrt(thrum_dot3(grown, grown));
}

/* Are all entries so small that no principal stretch is lost beside them? */
static bool is_moderate(double flowed[3][3]) {
  double largest = 0;
  for (int n = 0; n < 9; n++)
    largest = fmax(largest, fabs(flowed[n / 3][n % 3]));
  return largest < MODERATE;
}

/* The flow that stays within the bound, from `*share` of what the rule asks for on, and where it
 * takes the point; false where there is none. */
static bool flow_within(const thrum_plastic_point *point, double elastic[3][3], double before[3][3],
                        double *share, double flowed[3][3]) {
  const thrum_plastic *material = point->material;
  if (!thrum_plastic_flow(material, point->dt, elastic, before, *share, flowed))
    return false;

  if (isinf(material->largest) && is_moderate(flowed))
    return true;

  // a strain that is beyond it may become less; without a bound it is finite
  const double most = fmin(fmax(material->largest, thrum_plastic_strain(before)), DBL_MAX);
  for (int k = 0; k < BOUND_MAX && thrum_plastic_strain(flowed) > most; k++) {
    *share *= 0.5;
    thrum_plastic_flow(material, point->dt, elastic, before, *share, flowed);
  }
  return thrum_plastic_strain(flowed) <= most;
}

bool thrum_plastic_settle(const thrum_plastic_point *point, double elastic[3][3],
                          double plastic[3][3], double *taken) {
  double flowed[3][3], energy = 0, share = point->share;

  // less of it where the energy would rise
  for (int k = 0; k < HALVINGS_MAX; k++, share *= 0.5) {
    if (!flow_within(point, elastic, plastic, &share, flowed))
      return false;

    // most points are within the yield, so the energy before it is taken where there is a flow
    if (k == 0)
      energy = point->energy(point->context, plastic);
    const double after = point->energy(point->context, flowed);
    if (after <= energy) {
      *taken += energy - after;
      memcpy(plastic, flowed, sizeof flowed);
      return true;
    }
  }
  return false;
}
