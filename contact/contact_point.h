/* Kinematics of one point of the body in a step, from its three rows of U (3 x rank), private to
 * the runtime. Positions and velocities are in the world; lever arms are about the centre of mass.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_POINT_H
#define THRUM_RUNTIME_CONTACT_CONTACT_POINT_H

#include "contact/contact_private.h"

/* The rows of U of point `point` of the contact. */
const double *thrum_point_rows(const thrum_contact_run *run, int64_t point);

/* Displaces a point by coordinates x (rank), in the world: axes rows x. */
void thrum_point_shape(const thrum_contact_run *run, const double *rows, const double *x,
                       double out[3]);

/* Position of the point `rest` of the mesh in the world with q = 0 [m]. */
void thrum_point_rest(const thrum_contact_run *run, const double rest[3], double x[3]);

/* Its position at the start of the step [m]. */
void thrum_point_start(const thrum_contact_run *run, const double *rows, const double rest[3],
                       double x[3]);

/* Both the position and what coordinates d (rank) make of the rows in the world. */
void thrum_point_way(const thrum_contact_run *run, const double *rows, const double rest[3],
                     const double *d, double x[3], double out[3]);

/* From where the point really is at the start of the step to x, where its way starts [m]: 0 but for
 * a body that an impact of this step has struck. */
void thrum_point_shift(const thrum_contact_run *run, const double *rows, const double rest[3],
                       const double x[3], double shift[3]);

/* Its displacement over the step as a search has it [m]. */
void thrum_point_sought(const thrum_contact_run *run, const double *rows, const double lever[3],
                        double out[3]);

/* Lever arms of a point at x [m]: at the start of the step, and halfway through it. */
void thrum_point_lever(const thrum_contact_run *run, const double x[3], double arm[3],
                       double lever[3]);

/* The lever arm of a point with this arm, with which a rotation of the body by `turn` over the step
 * displaces it by turn x lever exactly: the mean of both ends of its arc (contact_pairs_rows.c). */
void thrum_point_mean_arm(const double turn[3], const double arm[3], double lever[3]);

/* Velocity at the start of the step [m/s]. */
void thrum_point_velocity(const thrum_contact_run *run, const double *rows, const double arm[3],
                          double velocity[3]);

/* Displacement over the step without contact and pulls [m]. */
void thrum_point_unloaded(const thrum_contact_run *run, const double *rows, const double lever[3],
                          double out[3]);

/* Both of them at once. */
void thrum_point_motion(const thrum_contact_run *run, const double *rows, const double arm[3],
                        const double lever[3], double velocity[3], double out[3]);

/* Displacement over the step where the coordinates change by d (rank) and the body as a whole moves
 * as predicted with contact and pulls [m]. */
void thrum_point_moved(const thrum_contact_run *run, const double *rows, const double lever[3],
                       const double *d, double out[3]);

/* G (3 x 3): displacement at the end of the step under a unit mean force on the point [m/N]. */
void thrum_point_response(const thrum_contact_run *run, const double *rows, const double lever[3],
                          double response[9]);

/* Adds what a mean force on the point [N] moves to the predicted displacements. */
void thrum_point_push(thrum_contact_run *run, const double *rows, const double lever[3],
                      const double force[3]);

/* Adds a mean force on the point [N] to the load of the step. */
void thrum_point_load(thrum_contact_run *run, const double *rows, const double lever[3],
                      const double force[3]);

/* The same three of a direction, which turns with the body and has no place: without what moves the
 * body as a whole along. */
void thrum_direction_moved(const thrum_contact_run *run, const double *rows, const double lever[3],
                           const double *d, double out[3]);
void thrum_direction_push(thrum_contact_run *run, const double *rows, const double lever[3],
                          const double force[3]);
void thrum_direction_load(thrum_contact_run *run, const double *rows, const double lever[3],
                          const double force[3]);

/* The same three of the shape alone, for rows that are the difference of two points of the body:
 * what moves it as a whole moves both. Their displacement is thrum_point_shape. */
void thrum_shape_response(const thrum_contact_run *run, const double *rows, double response[9]);
void thrum_shape_push(thrum_contact_run *run, const double *rows, const double force[3]);
void thrum_shape_load(thrum_contact_run *run, const double *rows, const double force[3]);

/* Distance of a point from where it was seen last [m]; `seen` becomes `at`. */
double thrum_point_since(const double at[3], double seen[3]);

#endif
