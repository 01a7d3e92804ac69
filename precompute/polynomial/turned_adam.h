/* Descent by noisy slopes of a function of a matrix: Adam (Kingma & Ba 2015, arXiv:1412.6980) in
 * the eigenvectors of mean products of slopes, which is SOAP (Vyas et al. 2024, arXiv:2409.11321).
 *
 * Adam scales each number by the size of its own slopes. Where numbers depend on each other, as the
 * coordinates of a body and the components of a gradient do, that says little; in the eigenvectors
 * of the mean of slope^T slope, and of slope slope^T of the rows of a group, they do not.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_TURNED_ADAM_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_TURNED_ADAM_H

#include <stdint.h>

#include "platform/allocate.h"
#include "thrum/status.h"

enum { THRUM_GROUP_ROWS = 9 };

/* Row k of group p is row k groups + p. */
typedef struct thrum_turned_adam {
  int64_t groups, columns, done; /* done: steps */
  float rate;                    /* what a number moves by in a step at most, about */
  float least;                   /* slope below which nothing moves */
  float *mean, *square;          /* rows x columns: of the turned slopes, and of their squares */
  float *turned;                 /* rows x columns: scratch */
  float *product;                /* columns x columns: mean of slope^T slope */
  float *turn;                   /* columns x columns: its eigenvectors, as columns */
  float *next, *change;          /* columns x columns: scratch */
  float *factors;                /* columns: scratch */
  float *group_product;          /* groups x 9 x 9: means of slope slope^T, */
  float *group_turn;             /* groups x 9 x 9: and their eigenvectors, as columns */
  float *rows;                   /* 9 x columns: scratch */
  double kept_mean, kept_square;
} thrum_turned_adam;

/* The arrays come from `memory`, whose status tells whether there was enough. */
thrum_turned_adam thrum_turned_adam_begin(int64_t groups, int64_t columns, float rate,
                                          thrum_scope *memory);

/* x (9 groups x columns) moves down the slope at it, by `share` of the rate. */
thrum_status thrum_turned_adam_step(thrum_turned_adam *adam, const float *slope, double share,
                                    float *x, thrum_error *error);

#endif
