/* Forces of one row: the spring along the normal and Coulomb friction across it. Private to the
 * runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_LAW_H
#define THRUM_RUNTIME_CONTACT_CONTACT_LAW_H

#include "contact/contact_private.h"

/* Normal force [N] of a row whose gap at the end of the step would be `gap_free` [m] without it,
 * and whose spring holds `stored` [J]. */
double thrum_contact_normal(const thrum_contact_row *row, double gap_free, double stored);

/* By how much that force, which is given, falls as `gap_free` rises [N/m]; not below 0. */
double thrum_contact_normal_rate(const thrum_contact_row *row, double gap_free, double stored,
                                 double force);

/* Friction [N] of a row with this normal force [N], whose displacement across the normal would be
 * `displacement` [m] without it. */
void thrum_contact_friction(const thrum_contact_row *row, double normal,
                            const double displacement[3], double friction[3]);

/* Energy of a spring of stiffness k [N/m] at this gap [J]. */
static inline double thrum_contact_energy(double stiffness, double gap) {
  return gap < 0.0 ? 0.5 * stiffness * gap * gap : 0.0;
}

#endif
