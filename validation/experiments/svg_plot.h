/* Curves as inline SVG. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_SVG_PLOT_H
#define THRUM_VALIDATION_EXPERIMENTS_SVG_PLOT_H

#include <stdint.h>

#include "io/string_builder.h"

#define EXPERIMENT_PLOT_SERIES_MAX 8

typedef struct experiment_series {
  const char *label; /* NULL: not in the legend */
  const char *color;
  const double *x; /* count each, x ascending; what is not finite is left out */
  const double *y;
  int64_t count;
  int marks; /* 0: a line; 1: and a dot at each point; 2: the dots alone */
} experiment_series;

typedef struct experiment_plot {
  const char *title;
  const char *x_label;
  const char *y_label;
  int width, height; /* of the whole picture, in pixels */
  bool log_x, log_y; /* values not above 0 are left out */
  bool from_zero;    /* the y axis begins at 0 */
  int64_t series_count;
  experiment_series series[EXPERIMENT_PLOT_SERIES_MAX];
} experiment_plot;

/* Adds the picture. Long curves are thinned to their least and largest value a pixel or two. */
void experiment_plot_add(experiment_text *text, const experiment_plot *plot);

#endif
