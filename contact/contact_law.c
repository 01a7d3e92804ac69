/* The laws of one touch (docs/contact.md): a penalty spring by its discrete gradient, and friction.
 *
 * With gap g at the start of the step, g' at its end, depth d = max(-g, 0), phi = 1/2 k d^2,
 *
 *   spring       L = -(phi(g') - phi(g)) / (g' - g) + c/h (d' - d), not below 0
 *   given back   L (g' - g) <= what is stored, where g' > g
 *   restitution  L > 0 only while g' is below the ceiling g + h/2 (v + v_out)
 *
 * L is the least of the three. Each falls as g' rises, and g' = g_free + G L rises with L, so the
 * force is unique; with two or one roots of quadratics it is closed. Work on the body is L (g' - g)
 * and never more than phi falls by: the midpoint rule's energy for any k h^2.
 *
 *   friction     F = -mu L (t - P) / |t - P|, P the point nearest to t on the way from 0 to h/2
 * v_t,
 *
 * or less where t = P: so F t <= 0 always, and a body that F can stop stops, v' = 2 t/h - v_t = 0.
 * Source of the discrete gradient: Gonzalez 2000, doi:10.1016/S0045-7825(00)00189-4.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "contact/contact_law.h"

#include <math.h>

#include "contact/contact_private.h"

#define ROUNDING 1e-9 /* of a force, within which a bound of it counts as reached */

/* The root of a x^2 + b x - c = 0 that is not below 0, for a > 0 and c >= 0. */
static double positive_root(double a, double b, double c) {
  const double root = sqrt(b * b + 4.0 * a * c);
  return b > 0.0 ? 2.0 * c / (b + root) : (root - b) / (2.0 * a);
}

/* The spring from outside, g > 0, to a free gap below 0. */
static double force_entering(const thrum_contact_row *row, double unloaded) {
  const double g = row->gap, k = row->stiffness, c = row->damping, along = row->along;
  // L (g - g') = 1/2 k g'^2 - c g' (g - g') with g' = unloaded + along L
  const double a = along * (0.5 * k * along + 1.0 + c * along);
  const double b =
      k * unloaded * along - (g - unloaded) - c * along * (g - unloaded) + c * unloaded * along;
  const double constant = 0.5 * k * unloaded * unloaded - c * unloaded * (g - unloaded);
  // b < 0 < constant: the lesser root has g' <= 0
  const double root = sqrt(fmax(b * b - 4.0 * a * constant, 0.0));
  return 2.0 * constant / (root - b);
}

/* The spring from inside. */
static double force_inside(const thrum_contact_row *row, double unloaded) {
  const double g = row->gap, k = row->stiffness, c = row->damping, along = row->along;
  const double stay =
      (-0.5 * k * (g + unloaded) - c * (unloaded - g)) / (1.0 + along * (0.5 * k + c));
  if (unloaded + along * stay <= 0.0)
    return fmax(stay, 0.0);
  // it leaves: (L - c g)(g' - g) = 1/2 k g^2
  const double rise = unloaded - g - c * along * g;
  return fmax(positive_root(along, rise, 0.5 * k * g * g + c * g * (unloaded - g)), 0.0);
}

double thrum_contact_normal(const thrum_contact_row *row, double gap_free, double stored) {
  const double along = row->along, g = row->gap;
  if (g >= 0.0 && gap_free >= 0.0)
    return 0.0;
  double force = g > 0.0 ? force_entering(row, gap_free) : force_inside(row, gap_free);
  const double reached = gap_free + along * force;
  if (reached > g && force * (reached - g) > stored)
    force = positive_root(along, gap_free - g, stored);
  const double most = (row->ceiling - gap_free) / along;
  force = fmin(force, fmax(most, 0.0));
  return isfinite(force) ? force : 0.0;
}

double thrum_contact_normal_rate(const thrum_contact_row *row, double gap_free, double stored,
                                 double force) {
  const double g = row->gap, k = row->stiffness, c = row->damping, along = row->along;
  const double reached = gap_free + along * force, rises = reached - g;
  if (!(force > 0.0))
    return 0.0;

  // at its ceiling the gap stays, whatever the force is
  if (force * (1.0 + ROUNDING) >= (row->ceiling - gap_free) / along)
    return 1.0 / along;

  // how the force of the law that counts falls with the gap, then with what the force gives way by
  double rate;
  if (rises > 0.0 && force * rises * (1.0 + ROUNDING) >= stored)
    rate = force / rises;
  else if (g > 0.0)
    rate = c - k * reached * (g - 0.5 * reached) / (rises * rises);
  else if (reached <= 0.0)
    rate = 0.5 * k + c;
  else
    rate = (force - c * g) / rises;
  return rate / (1.0 + along * rate);
}

void thrum_contact_friction(const thrum_contact_row *row, double normal, const double unloaded[3],
                            double friction[3]) {
  const double length = thrum_dot3(row->slide, row->slide);
  double at = length > 0.0 ? thrum_dot3(unloaded, row->slide) / length : 0.0;
  at = fmin(fmax(at, 0.0), 1.0);
  double off[3];
  for (int axis = 0; axis < 3; axis++)
    off[axis] = unloaded[axis] - at * row->slide[axis];
  const double distance = sqrt(thrum_dot3(off, off)), most = row->friction * normal;
  const double scale = distance > row->across * most ? most / distance : 1.0 / row->across;
  for (int axis = 0; axis < 3; axis++)
    friction[axis] = distance > 0.0 && isfinite(scale) ? -scale * off[axis] : 0.0;
}
