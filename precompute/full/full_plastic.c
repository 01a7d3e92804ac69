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

static int64_t point_count(const thrum_full *full) {
  const thrum_fem *fem = full_elastic(full);
  return fem->tet_count * fem->point_count;
}

thrum_status full_plastic_make(thrum_full *full) {
  if (isinf(full->def.plastic.yield) && !thrum_fem_has_yield(full_elastic(full)))
    return THRUM_OK;
  const int64_t count = 9 * point_count(full);
  full->plastic = thrum_scope_allocate(&full->memory, count, sizeof(double));
  full->plastic_kept = thrum_scope_allocate(&full->memory, count, sizeof(double));
  THRUM_TRY(full->memory.status);

  // the elements see it; nothing has flowed yet
  full->body.fem.plastic = full->four.plastic = full->plastic;
  return THRUM_OK;
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

/* A point of the mesh. */
typedef struct mesh_point {
  const thrum_full *full;
  int64_t tet;
  int number;
  double *plastic; /* its place in the array that the elements see */
} mesh_point;

/* Leaves what it is asked about in the array. */
static double energy_at(const void *context, double plastic[3][3]) {
  const mesh_point *at = context;
  thrum_tet tet;
  memcpy(at->plastic, plastic, 9 * sizeof *at->plastic);
  thrum_tet_deform(full_elastic(at->full), at->tet, at->number, at->full->place, &tet);
  return tet.energy;
}

/* The flow at one point; whether there was any. */
static bool flow_at(thrum_full *full, double dt, int64_t t, int p) {
  const thrum_fem *fem = full_elastic(full);
  const mesh_point at = {full, t, p, full->plastic + 9 * (t * fem->point_count + p)};
  thrum_plastic material = full->def.plastic;
  material.yield = thrum_fem_yield(fem, fem->tet_region[t], material.yield);
  const thrum_plastic_point point = {&material, dt, 1, energy_at, &at};
  double plastic[3][3];
  memcpy(plastic, at.plastic, sizeof plastic);
  thrum_tet tet;
  thrum_fem_tet_at(fem, t, p, full->place, &tet);
  const bool flowed = thrum_plastic_settle(&point, tet.displacement, plastic, &full->plastic_work);
  memcpy(at.plastic, plastic, sizeof plastic);
  return flowed;
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
