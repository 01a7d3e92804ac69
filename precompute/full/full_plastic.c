/* Plastic flow of the full-order body, after each step and at the displacement that it has reached
 * (design 19). The step itself is elastic, so the strain energy that the flow takes away is all
 * that is lost: kinetic energy, strain energy and plastic work add up to the work of the loads.
 * Cost: a pass over the points.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/fem_tet.h"
#include "precompute/full/full_private.h"

enum {
  HALVINGS_MAX = 12, // of what flows, until it takes energy
  BOUND_MAX = 64     // the same until it stays within its bound, beyond which nothing is left
};

static int64_t point_count(const thrum_full *full) {
  const thrum_fem *fem = full_elastic(full);
  return fem->tet_count * fem->point_count;
}

thrum_status full_plastic_make(thrum_full *full, thrum_error *error) {
  if (isinf(full->def.plastic.yield))
    return THRUM_OK;
  const int64_t count = 9 * point_count(full);
  THRUM_TRY(thrum_reserve(&full->plastic, count, sizeof *full->plastic, "plastic flow", error));
  THRUM_TRY(
      thrum_reserve(&full->plastic_kept, count, sizeof *full->plastic_kept, "plastic flow", error));

  // the elements see it; nothing has flowed yet
  full->body.fem.plastic = full->four.plastic = full->plastic;
  return THRUM_OK;
}

void full_plastic_free(thrum_full *full) {
  free(full->plastic);
  free(full->plastic_kept);
}

void full_plastic_keep(thrum_full *full) {
  full->plastic_work_kept = full->plastic_work;
  if (full->plastic)
    memcpy(full->plastic_kept, full->plastic, (size_t)(9 * point_count(full)) * sizeof(double));
}

void full_plastic_return(thrum_full *full) {
  full->plastic_work = full->plastic_work_kept;
  if (full->plastic)
    memcpy(full->plastic, full->plastic_kept, (size_t)(9 * point_count(full)) * sizeof(double));
}

static double strain_of(const double *plastic) {
  double matrix[3][3];
  memcpy(matrix, plastic, sizeof matrix);
  return thrum_plastic_strain(matrix);
}

/* The flow that stays within the bound, from `*share` of what the rule asks for on, and where it
 * takes the point; false where there is none. */
static bool flow_within(const thrum_plastic *material, double dt, thrum_tet *tet,
                        double before[3][3], double *share, double flowed[3][3]) {
  if (!thrum_plastic_flow(material, dt, tet->displacement, before, *share, flowed))
    return false;
  if (isinf(material->largest))
    return true;

  // a strain that is beyond it may become less
  const double most = fmax(material->largest, thrum_plastic_strain(before));
  for (int k = 0; k < BOUND_MAX && thrum_plastic_strain(flowed) > most; k++) {
    *share *= 0.5;
    thrum_plastic_flow(material, dt, tet->displacement, before, *share, flowed);
  }
  return thrum_plastic_strain(flowed) <= most;
}

/* The flow at one point; whether there was any. */
static bool flow_at(thrum_full *full, double dt, int64_t t, int p) {
  const thrum_fem *fem = full_elastic(full);
  double *plastic = full->plastic + 9 * (t * fem->point_count + p);
  double before[3][3], flowed[3][3], share = 1;
  memcpy(before, plastic, sizeof before);
  thrum_tet tet, after;
  thrum_tet_place(fem, t, p, full->place, &tet);

  // less of it where the energy would rise
  for (int k = 0; k < HALVINGS_MAX; k++, share *= 0.5) {
    if (!flow_within(&full->def.plastic, dt, &tet, before, &share, flowed))
      break;

    // most points are within the yield, so the energy before it is taken where there is a flow
    if (k == 0)
      thrum_tet_deform(fem, t, p, full->place, &tet);
    memcpy(plastic, flowed, sizeof flowed);
    thrum_tet_deform(fem, t, p, full->place, &after);
    if (after.energy <= tet.energy) {
      full->plastic_work += tet.energy - after.energy;
      return true;
    }
  }

  memcpy(plastic, before, sizeof before);
  return false;
}

void thrum_full_clear_plastic(thrum_full *full) {
  full->plastic_work = 0;
  if (!full->plastic)
    return;
  memset(full->plastic, 0, (size_t)(9 * point_count(full)) * sizeof(double));

  // forces have changed, and accelerations with them
  full->fresh = true;
}

void full_plastic_flow(thrum_full *full, double dt) {
  if (!full->plastic)
    return;
  const thrum_fem *fem = full_elastic(full);
  bool flowed = false;
  full_place(full, full->u, 0, NULL, full->place);
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int p = 0; p < fem->point_count; p++)
      flowed = flow_at(full, dt, t, p) || flowed;

  // forces have changed, and accelerations with them
  full->fresh = full->fresh || flowed;
}

double thrum_full_plastic_strain(const thrum_full *full) {
  double largest = 0;
  for (int64_t point = 0; full->plastic && point < point_count(full); point++)
    largest = fmax(largest, strain_of(full->plastic + 9 * point));
  return largest;
}
