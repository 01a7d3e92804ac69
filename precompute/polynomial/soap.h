/* SOAP (Vyas et al. 2024, arXiv:2409.11321), a descent by noisy slopes of a function of a matrix:
 * Adam (Kingma & Ba 2015, arXiv:1412.6980) in the eigenvectors of mean products of slopes.
 *
 * Adam scales each number by the size of its own slopes, which is right where numbers do not depend
 * on each other. Coordinates of a body and components of a gradient do; along the eigenvectors of
 * the mean of slope^T slope, and of slope slope^T of the rows of a group, they hardly do.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PRECOMPUTE_POLYNOMIAL_SOAP_H
#define THRUM_PRECOMPUTE_POLYNOMIAL_SOAP_H

#include <stdint.h>

#include "platform/allocate.h"
#include "thrum/status.h"

enum { THRUM_GROUP_ROWS = 9 };

/* Row k of group p is row k groups + p. */
typedef struct thrum_soap {
  int64_t groups, columns, done; /* done: steps */
  float rate;                    /* what a number moves by in a step at most, about */
  float least;                   /* slope below which nothing moves */
  float *mean, *square; /* rows x columns: of slopes in the eigenvectors, and of their squares */
  float *projected;     /* rows x columns: scratch */
  float *product;       /* columns x columns: mean of slope^T slope */
  float *vectors;       /* columns x columns: its eigenvectors, as columns */
  float *next, *change; /* columns x columns: scratch */
  float *factors;       /* columns: scratch */
  float *group_product; /* groups x 9 x 9: means of slope slope^T, */
  float *group_vectors; /* groups x 9 x 9: and their eigenvectors, as columns */
  float *rows;          /* 9 x columns: scratch */
  double kept_mean, kept_square;
} thrum_soap;

/* The arrays come from `memory`, whose status tells whether there was enough. */
thrum_soap thrum_soap_begin(int64_t groups, int64_t columns, float rate, thrum_scope *memory);

/* x (9 groups x columns) moves down the slope at it, by `share` of the rate. */
thrum_status thrum_soap_step(thrum_soap *soap, const float *slope, double share, float *x,
                             thrum_error *error);

#endif
