/* How a step treats one mode; private to libthrum, see mode_factor.c.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_MODE_FACTOR_H
#define THRUM_CORE_SCHEMES_MODE_FACTOR_H

/* The eigenvalue of a step of a linear mode. */
typedef struct thrum_mode_factor {
  double real, imaginary; /* imaginary NaN: there are two real ones, and `real` is the larger */
} thrum_mode_factor;

/* The a and b of the energy a D b / h that damping takes out of a mode in a step. */
typedef struct thrum_damped_part {
  double a, b;
} thrum_damped_part;

/* How a mode moves under a force R and a mean load f in a step:
 * q' - q = s [momentum h p + load h^2 (f - R)], s = 1 / (1 + damping h d + stiffness h^2 omega^2).
 */
typedef struct thrum_mode_answer {
  double momentum, load, damping, stiffness;
} thrum_mode_answer;

/* How a mode is stepped, all 1 where its frequency is not matched. */
typedef struct thrum_matched_step {
  double stretch; /* lambda, its time step over dt, */
  double inverse; /* and 1/lambda */
  double speed;   /* nu, its velocity in the middle of the step over (q' - q)/dt */
} thrum_matched_step;

/* The eigenvalue of Newmark's rule for z = h omega. */
thrum_mode_factor thrum_newmark_factor(double z, double beta, double gamma);

#endif
