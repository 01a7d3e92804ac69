/* A curve of periodic motions, as it is found and kept. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_CURVE_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_CURVE_H

#include "driver/model/model_hash.h"
#include "driver/response/response_options.h"
#include "thrum/response.h"

/* One motion: what the library says of it, without its arrays and with the frequency of the load.
 */
typedef struct response_row {
  thrum_response_point point;
  double multiplier[2]; /* the largest; NaN: not looked at */
} response_row;

typedef struct response_curve {
  const response_request *request;
  model_hash hash;                             /* of the file of the model: the caller's to set */
  const thrum_model *loaded, *stepped, *shape; /* shape shows what stepped moves */
  void *memory;                                /* of the stepped model */
  int64_t harmonics;
  double *rates;         /* D of the coordinates that are stepped [1/s] */
  double *loads[3];      /* mean, cosine and sine, rank of the shape each */
  double from, to;       /* [Hz] */
  double *seen;          /* targets x 3 x rank of the shape: displacement by coordinate */
  int64_t pairs;         /* i <= j of the coordinates that move; 0: none follow */
  double *follow;        /* pairs x those that follow: what each has of x_i x_j */
  double *sight;         /* targets x 3 x (moving + pairs + 3): displacement by both and the load */
  double *waves;         /* cosines and sines at the samples of a period */
  double *series;        /* behind them, targets x 3 x 2 (2 H + 1): of what is seen of a motion, */
  double *moving;        /* and what moves at a sample, its products and the parts of the load */
  char vertex[40];       /* the target of a body whose targets are not named */
  const char *const *at; /* names of the targets */
  int64_t target_count;

  response_row *rows;
  int64_t count, room;
  double *coefficients; /* rows x (2 H + 1) x rank */
  double *harmonic;     /* rows x targets x 3 x (2 H + 1): mean, then cosines, then sines [m] */
  double *peak;         /* rows x targets: largest displacement [m] */
  thrum_response_report report;
  thrum_normal_form form;      /* of a backbone's mode; omega 0: there is none */
  thrum_normal_form_pair pair; /* of it and a mode near 1:1, 1:2 or 1:3; count 0: there is none */
  int64_t pair_modes[2];       /* the lower one first */
  int32_t pair_ratio;
  int32_t pair_order;
  /* Displacements of the furthest vertex of the mode, of each of the two, at which orders 3 and 5,
   * then 5 and 7 are a hundredth of the frequency apart [m]; NaN: they are not both there. */
  double form_amplitudes[2], pair_amplitudes[2];
  thrum_error failure; /* of keeping rows */
  double seconds;
} response_curve;

/* Makes ready what the request asks for, of the loaded model, which stays the caller's;
 * response_curve_close frees, whatever came back. */
thrum_status response_curve_open(const response_request *request, const thrum_model *loaded,
                                 response_curve *curve, thrum_error *error);
void response_curve_close(response_curve *curve);

/* Follows the curve; what was found is kept. */
thrum_status response_curve_find(response_curve *curve, thrum_error *error);

/* Amplitude [m] and phase [rad] of harmonic k >= 1 of a target along an axis, in a row. */
double response_curve_amplitude(const response_curve *curve, int64_t row, int64_t target, int axis,
                                int64_t k, double *phase);

/* Mean, cosines and sines up to 2 H, (4 H + 1) x rank of the shape, of all coordinates in a row:
 * what follows is quadratic in what moves. */
void response_curve_shape(const response_curve *curve, int64_t row, double *out);

/* q and p (rank of the shape each) of a row where the load's sine begins. */
void response_curve_state(const response_curve *curve, int64_t row, double *q, double *p);

#endif
