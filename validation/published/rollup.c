/* A cantilever that an end moment rolls up: under M = theta E I/L it is an arc of the angle theta,
 * and a ring at 2 pi. The moment turns with the face that it acts on (full order, design 12).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "core/base/pi.h"
#include "precompute/full/full.h"
#include "validation/published/published.h"

#define THICK 0.01 /* of the length */

/* Mean displacement of the face under the moment of an arc of this angle, from where the body is.
 */
static thrum_status bend(const thrum_model *model, thrum_full *full, double angle, double mean[3],
                         thrum_error *error) {
  const int32_t *vertices;
  int64_t count;
  thrum_full_equilibrium found;
  THRUM_TRY(thrum_model_group(model, "right", &vertices, &count, error));
  const thrum_full_follower moment = {
      .vertices = vertices, .count = count, .moment = {0, -angle * pow(THICK, 4) / 12, 0}};
  const thrum_full_loading loading = {.followers = &moment, .follower_count = 1};
  THRUM_TRY(thrum_full_rest_under(full, &loading, &found, error));
  thrum_full_mean(full, vertices, count, mean);
  return THRUM_OK;
}

static thrum_status rollup_rows(const published_sink *sink, int cells, thrum_error *error) {
  published_body body = {.fix = {"x<1e-9", "y>-1e9:y"}, .material = {1, 0, 1}, .order = 2};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x1@1x%gx%g", cells, THICK, THICK);
  thrum_precomputed made = {0};
  thrum_full *full = NULL;
  const thrum_full_def def = thrum_default_full_def();
  double half[3], ring[3];
  THRUM_TRY(published_precompute(&body, 6, 12, false, &made, error));

  // the ring goes on from half of it
  thrum_status status = thrum_full_create(&made.model, NULL, &def, &full, error);
  THRUM_THEN(status, bend(&made.model, full, THRUM_PI, half, error));
  THRUM_THEN(status, bend(&made.model, full, 2 * THRUM_PI, ring, error));
  if (status >= 0) {
    published_add(sink, "rollup", "half a ring, across", body.mesh, cells, 2 / THRUM_PI, half[2]);
    published_add(sink, "rollup", "half a ring, along", body.mesh, cells, -1, half[0]);
    published_add(sink, "rollup", "ring, along", body.mesh, cells, -1, ring[0]);
  }
  thrum_full_free(full);
  thrum_precomputed_free(&made);
  return status < 0 ? status : THRUM_OK;
}

thrum_status published_rollup(const published_sink *sink, thrum_error *error) {
  // elements are ten times as long as thick, and fewer do not close
  for (int level = 0; level <= (sink->level > 0 ? 2 : 1); level++)
    THRUM_TRY(rollup_rows(sink, 20 << level, error));
  return THRUM_OK;
}
