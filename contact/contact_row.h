/* Rows of a step, those of points on obstacles and those between bodies alike: how a row starts,
 * what a sweep does to it, and what it did in the step that was made. Private to the runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_ROW_H
#define THRUM_RUNTIME_CONTACT_CONTACT_ROW_H

#include <math.h>

#include "contact/contact_private.h"

#define THRUM_SOON 1.1    /* steps: what strikes so soon is struck with what strikes in this one */
#define THRUM_RESTING 2.0 /* times what the load adds as a body lies down: less is no impact */
#define THRUM_ROUNDING 1e-10 /* share of the energy flow of contact that rounding may add */
#define THRUM_HARDER                                                                               \
  1e3 /* times the stiffness of a surface, where a touch gives back less than it takes */

#define THRUM_ENERGY_MOST                                                                          \
  1e280 /* [J] of a touch: sums over 2^24 of them and 2^62 steps are finite */

/* --- one row ---------------------------------------------------------------------------------- */

/* Does it press, by a law that gives back less than it takes? */
static inline bool thrum_contact_row_takes(const thrum_contact_row *row) {
  return row->touch.force > 0.0 && (row->restitution < 1.0 || row->friction > 0.0);
}

/* Its force [N], on the body or on the first of two bodies. */
void thrum_contact_row_force(const thrum_contact_row *row, double force[3]);

/* Fills `along` and `across` from the response and the normal. */
void thrum_contact_row_respond(thrum_contact_row *row);

/* Fills the approach speed, and the displacement that friction aims at, in a step of h [s]:
 * velocity [m/s] and displacement without contact [m] are relative to what the point touches.
 * settling: 1 / omega_1 of the softer of what touches [s]. */
void thrum_contact_row_approach(thrum_contact_row *row, double h, double settling,
                                const double velocity[3], const double unloaded[3]);

/* The speed of an approach up to which it is no impact [m/s], where the load adds `gained` in a
 * step of h [s]: what it adds in a step, or while the bodies lie down. A body that is put on the
 * ground swings on its own elasticity at up to g / omega_1, however short a step is. */
static inline double thrum_contact_resting(double gained, double h, double settling) {
  return THRUM_RESTING * gained * fmax(settling / h, 1.0);
}

/* Is an approach at `speed` along the normal an impact, where a step without contact moves by `way`
 * along it? */
static inline bool thrum_contact_strikes(double speed, double way, double h, double settling) {
  return -speed > thrum_contact_resting(2.0 * (speed - way / h), h, settling);
}

/* Solves the row for its forces, as those of all other rows are. at: displacement of the point
 * relative to what it touches, as predicted now [m]; overwritten. change: of its force [N]. */
void thrum_contact_row_solve(thrum_contact_row *row, double at[3], double change[3]);

/* Fills the work, what friction did, and the gap after a step in which the point moved so [m]. */
void thrum_contact_row_measure(thrum_contact_row *row, const double moved[3]);

/* Is an energy so far from the end of the finite numbers that sums of it over all touches and steps
 * stay finite? False of NaN. */
static inline bool thrum_contact_energy_counts(double energy) {
  return fabs(energy) <= THRUM_ENERGY_MOST;
}

/* The same of all energies of a row in the step that was made, after thrum_contact_row_measure. */
bool thrum_contact_row_counts(const thrum_contact_row *row);

/* --- all rows of a step ----------------------------------------------------------------------- */

/* Rows that lie `stride` bytes apart. */
typedef struct thrum_row_list {
  void *first;
  int64_t count;
  size_t stride;
} thrum_row_list;

static inline thrum_contact_row *thrum_row_at(const thrum_row_list *list, int64_t n) {
  return (thrum_contact_row *)(void *)((unsigned char *)list->first + (size_t)n * list->stride);
}

/* The rows of a body on obstacles. */
static inline thrum_row_list thrum_rows_of(const thrum_contact_run *run) {
  return (thrum_row_list){run->view.rows, run->contact->row_count, sizeof(thrum_contact_row)};
}

/* Share of their depth by which springs are deeper than the forces of the last step account for,
 * because something held them back. It is taken over all rows together, as points may share a force
 * in many ways. */
double thrum_rows_excess(const thrum_row_list *list);

/* The gap up to which the row's spring pushes in a step of h [s]: as fast as restitution says, or
 * out of an excess of depth, of which `share` is thrum_rows_excess, but no faster than the force
 * that presses the body on can stop. */
double thrum_contact_row_ceiling(const thrum_contact_row *row, double h, double share);

/* The sum of the forces times the displacements of their points without contact [J]. */
double thrum_rows_flow(const thrum_row_list *list);

/* The energy that the springs hold [J]. */
double thrum_rows_stored(const thrum_row_list *list);

/* Updates the energy that springs hold after the step: all together no more than they took, and
 * each no more than phi. Points that move as one share a force in many ways and the solver finds
 * one of them, so one spring may hold the energy that another took. Returns the sum [J]. */
double thrum_rows_keep_stored(const thrum_row_list *list);

/* Takes a loss below 0 [J] out of the springs, which hold `stored` [J], each by the same share, as
 * far as that goes; returns what they hold then [J]. */
double thrum_rows_cover_loss(const thrum_row_list *list, double stored, double loss);

#endif
