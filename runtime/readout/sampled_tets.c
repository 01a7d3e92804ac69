/* Which tetrahedra to sample: those that each basis vector strains most, |sym G_i| in Frobenius'
 * norm (thrum/monitor.h). The lists of all modes lie one behind the other in the caller's array,
 * so a tet that an earlier mode took is not taken again.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include <stdbool.h>

#include "runtime/readout/stress_private.h"
#include "runtime/readout/tet_strain.h"
#include "thrum/monitor.h"

/* |sym G_i|^2 of a tet under a unit of basis vector `mode`. */
static double strain_square(const thrum_model *model, int64_t tet, int64_t mode,
                            const double shape[9]) {
  double u[12], g[3][3], square = 0;
  for (int a = 0; a < 4; a++) {
    int32_t nodes[3];
    const int parts = thrum_stress_points_nodes(model, tet, a, nodes);
    for (int axis = 0; axis < 3; axis++) {
      // from -0, so that one part alone keeps all its bits
      u[3 * a + axis] = -0.0;
      for (int part = 0; part < parts; part++)
        u[3 * a + axis] += model->basis[(3 * (int64_t)nodes[part] + axis) * model->rank + mode];
    }
  }

  // the square of the symmetric part of the displacement gradient
  thrum_tet_gradient(u, shape, g);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++)
      square += 0.25 * (g[i][j] + g[j][i]) * (g[i][j] + g[j][i]);
  return square;
}

static bool contains(const int32_t *tets, int64_t count, int64_t tet) {
  for (int64_t n = 0; n < count; n++)
    if (tets[n] == tet)
      return true;
  return false;
}

/* Puts `tet` into the list of the `count` largest, in descending order; returns the new length. */
static int64_t insert(int32_t *tets, double *values, int64_t length, int64_t count, int32_t tet,
                      double value) {
  int64_t at = length < count ? length : count - 1;
  if (at < length && !(value > values[at]))
    return length;
  for (; at > 0 && value > values[at - 1]; at--) {
    values[at] = values[at - 1];
    tets[at] = tets[at - 1];
  }
  values[at] = value;
  tets[at] = tet;
  return length < count ? length + 1 : length;
}

thrum_status thrum_sampled_tets_choose(const thrum_model *model, int64_t count, int32_t *tets,
                                       int64_t *chosen, thrum_error *error) {
  if (!model || !tets || !chosen || count < 1 || count > THRUM_SAMPLED_TETS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "model, tets or chosen is NULL, or the count is not in 1..%d",
                           THRUM_SAMPLED_TETS_MAX);
  if (!model->basis || !model->tets)
    return thrum_error_set(error, THRUM_MISSING, "the model has no mesh or no basis to sample");

  // each mode adds its most strained tetrahedra
  const int64_t each = count > model->rank ? count / model->rank : 1;
  double values[THRUM_SAMPLED_TETS_MAX];
  int64_t done = 0;

  // a sorted list of those that are not chosen yet
  for (int64_t mode = 0; mode < model->rank && done < count; mode++) {
    const int64_t most = each < count - done ? each : count - done;
    int64_t length = 0;
    for (int64_t tet = 0; tet < model->tet_count; tet++) {
      double shape[9];
      if (!thrum_stress_points_shape(model, tet, shape))
        return thrum_error_set(error, THRUM_BAD_VALUE,
                               "tetrahedron %lld of the model has no positive volume",
                               (long long)tet + 1);
      const double value = strain_square(model, tet, mode, shape);
      if ((length < most || value > values[length - 1]) && !contains(tets, done, tet))
        length = insert(tets + done, values, length, most, (int32_t)tet, value);
    }
    done += length;
  }

  *chosen = done;
  return THRUM_OK;
}
