/* The Newton methods of contact have this in common: the step and the search along it. Private to
 * the runtime.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H
#define THRUM_RUNTIME_CONTACT_CONTACT_NEWTON_H

#include <stdbool.h>
#include <stdint.h>

/* Rows of matrices and of B are so long: a multiple of four, so that no lane is left over. */
#define THRUM_NEWTON_STRIDE(m) (((m) + 3) / 4 * 4)

/* The columns of a row: those of one body, or of two, of which the second lie further on. Counts
 * are multiples of four, so that no lane is left over; the second may be 0. */
typedef struct thrum_newton_columns {
  int64_t first[2], count[2];
} thrum_newton_columns;

/* matrix += B^T change B, of which the upper triangle counts; its rows are `stride` long. ways: the
 * columns of B that are not 0, three rows of all of them; change: 3 x 3, symmetric; pushed: room of
 * the size of ways. */
void thrum_newton_add(const thrum_newton_columns *at, const double *ways, const double change[9],
                      double *pushed, int64_t stride, double *matrix);

/* Solves matrix step = -gradient (m) for a symmetric positive matrix, of which the upper triangle
 * counts and is overwritten; false where it has no Cholesky factor, or the step is not finite. */
bool thrum_newton_step(int64_t m, double *matrix, const double *gradient, double *step);

/* The lower triangle with root root^T = weight, of an inverse inertia; false where it has none. */
bool thrum_newton_root(const double weight[9], double root[9]);

/* A solve in m coordinates z for the minimum of |z|^2 / 2 + sum phi_i(B_i z), phi_i convex. The
 * caller has filled z; the rest is scratch. */
typedef struct thrum_newton_system {
  int64_t m;
  double *z, *gradient, *step; /* m */
  double *matrix;              /* m rows, THRUM_NEWTON_STRIDE(m) long */
} thrum_newton_system;

/* What a solve asks of its rows; `of` is the caller's, which has the system. */
typedef struct thrum_newton_laws {
  void (*linearise)(void *of); /* fills gradient and matrix at z */
  double (*ways)(void *of);    /* how far the rows go in the step; returns the longest way */
  double (*fall)(const void *of, double share,
                 double slope);         /* the slope less the forces times the ways there */
  void (*take)(void *of, double share); /* moves the rows by a share of their ways */
  void (*go_on)(void *of);              /* rows go on from the forces that they have */
} thrum_newton_laws;

/* Makes steps until rows that have just gone on from their forces move no more than
 * the tolerance; *settled: they do so. False where the matrix has no factor. */
bool thrum_newton_minimise(const thrum_newton_system *system, const thrum_newton_laws *laws,
                           void *of, double tolerance, bool *settled);

/* The slope of a function along a step at a share of the step, from 0 to 1. */
typedef double (*thrum_newton_slope)(const void *of, double share);

/* The share of a step to take of a convex function that falls by `start` < 0 where the step begins:
 * the whole, or one near the minimum along it. */
double thrum_newton_search(thrum_newton_slope slope_at, const void *of, double start);

#endif
