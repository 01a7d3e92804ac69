/* A body as a picture: its surface lit and coloured by how far it has moved, over the outline of
 * itself at rest. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_PICTURES_RENDER_H
#define THRUM_VALIDATION_PICTURES_RENDER_H

#include <stdint.h>

#include "thrum/status.h"

/* A picture in memory; zeroed it is empty, experiment_image_free when done. */
typedef struct experiment_image {
  int width, height;
  uint8_t *pixels; /* height x width x 3, red, green, blue, from the top left */
} experiment_image;

/* A white picture. */
thrum_status experiment_image_make(int width, int height, experiment_image *image,
                                   thrum_error *error);
void experiment_image_free(experiment_image *image);

/* A closed surface in two places. */
typedef struct experiment_solid {
  int64_t vertex_count;
  const double *rest;  /* vertex_count x 3 [m] */
  const double *moved; /* the same vertices, displaced [m] */
  const double *value; /* vertex_count, 0 to 1: what the colour shows */
  int64_t face_count;
  const int32_t *faces; /* face_count x 3, going round outwards */
} experiment_solid;

/* From where it is seen, and where in the picture. */
typedef struct experiment_view {
  double azimuth;               /* of the eye about z, from the x axis [degrees] */
  double elevation;             /* of the eye above the ground [degrees] */
  int left, top, width, height; /* of its part of the picture, which it fills but for a margin */
} experiment_view;

/* Draws the solid into its part of the picture. */
thrum_status experiment_render(const experiment_solid *solid, const experiment_view *view,
                               experiment_image *image, thrum_error *error);

/* The colour of a value from 0 to 1, without light. */
void experiment_color(double value, double rgb[3]);

#endif
