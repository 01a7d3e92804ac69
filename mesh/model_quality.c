/* Measures a mesh in one pass over the tetrahedra; see model_quality.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/model_quality.h"

#include <math.h>
#include <string.h>

#include "core/base/pi.h"
#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"
#include "mesh/solids.h"

double thrum_tet_mean_ratio(const double *const corners[4], double *volume) {
  double edge[3][3];
  double squares = 0;
  for (int a = 0; a < 3; a++) {
    for (int axis = 0; axis < 3; axis++) {
      edge[a][axis] = corners[a + 1][axis] - corners[0][axis];
      squares += edge[a][axis] * edge[a][axis];
    }
  }

  // the other three edges are differences of the first three
  for (int a = 0; a < 3; a++) {
    for (int axis = 0; axis < 3; axis++) {
      const double side = edge[a][axis] - edge[(a + 1) % 3][axis];
      squares += side * side;
    }
  }

  *volume = thrum_triple3(edge[0], edge[1], edge[2]) / 6;

  // 12 (3 V)^(2/3) over the sum of the squared edges: 1 for the regular tet
  if (!(squares > 0))
    return 0;
  const double root = cbrt(3 * fabs(*volume));
  return 12 * root * root / squares;
}

static double quadratic_volume(const thrum_model *model, int64_t t) {
  double places[THRUM_QUADRATIC_NODES][3];
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++) {
    const int64_t v = a < 4 ? model->tets[4 * t + a] : model->midsides[6 * t + a - 4];
    memcpy(places[a], model->vertices + 3 * v, sizeof places[a]);
  }
  return thrum_quadratic_volume(places);
}

/* The shape of solids, whose tetrahedra are no elements. */
static void measure_solids(const thrum_model *model, thrum_quality *measured) {
  for (int64_t s = 0; s < model->solid_count; s++) {
    const thrum_solid_form_shape *form = &thrum_solid_forms[model->solid_form[s]];
    const double ratio = thrum_solid_shape_measure(
        form->kind, model->vertices, model->solid_nodes + model->solid_ends[s] - form->nodes);
    measured->ratio_mean += ratio;
    if (ratio < measured->ratio_min - 1e-12) {
      measured->ratio_min = ratio;
      measured->worst_tet = s;
    }
  }
}

thrum_status thrum_quality_measure(const thrum_model *model, thrum_quality *quality,
                                   thrum_error *error) {
  if (model->vertices == NULL || model->tets == NULL || model->tet_count < 1)
    return thrum_error_set(error, THRUM_MISSING, "the model holds no mesh");

  // the box and the held vertices
  thrum_quality measured = {.ratio_min = INFINITY};
  thrum_box3(model->vertices, model->vertex_count, measured.box_min, measured.box_max);
  for (int64_t v = 0; v < model->vertex_count; v++)
    measured.fixed_count += model->fixed[v] != 0;

  // volume, mass and shape of each tetrahedron
  for (int64_t t = 0; t < model->tet_count; t++) {
    const double *corners[4];
    for (int a = 0; a < 4; a++)
      corners[a] = model->vertices + 3 * (int64_t)model->tets[4 * t + a];
    double volume = 0;
    const double ratio = thrum_tet_mean_ratio(corners, &volume);
    if (model->midsides != NULL)
      volume = quadratic_volume(model, t);
    measured.volume += volume;
    measured.mass += volume * model->material[3 * (int64_t)model->tet_region[t] + 2];
    if (model->solid_count > 0)
      continue;
    measured.ratio_mean += ratio;

    // among equals the first is named, whatever rounding says
    if (ratio < measured.ratio_min * (1 - 1e-12)) {
      measured.ratio_min = ratio;
      measured.worst_tet = t;
    }
  }

  measure_solids(model, &measured);
  measured.ratio_mean /= (double)(model->solid_count > 0 ? model->solid_count : model->tet_count);
  *quality = measured;
  return THRUM_OK;
}

void thrum_frequencies(const double *omega2, int64_t count, double *hertz) {
  for (int64_t n = 0; n < count; n++)
    hertz[n] = sqrt(omega2[n]) / (2 * THRUM_PI);
}
