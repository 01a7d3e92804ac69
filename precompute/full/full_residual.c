/* The residual of the full-order body and its matrix: internal forces, mass and damping at a
 * displacement, which the steps and the equilibrium share. Cost: one pass over the tets.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/full/full_private.h"

double full_dot(const thrum_full *full, const double *x, const double *y) {
  double sum = 0;
  for (int64_t i = 0; i < full->body.fem.free_count; i++)
    sum += x[i] * y[i];
  return sum;
}

const thrum_fem *full_elastic(const thrum_full *full) {
  return full->def.quadrature == THRUM_FULL_FOUR ? &full->four : &full->body.fem;
}

void full_place(const thrum_full *full, const double *u, double share, const double *d,
                double *place) {
  const thrum_fem *fem = &full->body.fem;
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++) {
    const int32_t i = fem->dof[c];
    place[c] = i < 0 ? full->held[c] : u[i] + (d ? share * d[i] : 0);
  }
}

double full_subtract_forces(thrum_full *full, const double *place, double *r) {
  const thrum_fem *fem = full_elastic(full);
  const double energy = thrum_fem_energy(fem, place, full->forces);
  for (int64_t i = 0; i < fem->free_count; i++)
    r[i] -= full->forces[fem->component[i]];
  return energy;
}

void full_subtract_mass(thrum_full *full, double scale, const double *x, double *r) {
  thrum_sparse_product(&full->body.mass, x, 1, full->product);
  for (int64_t i = 0; i < full->body.fem.free_count; i++)
    r[i] -= scale * full->product[i];
}

void full_subtract_damping(thrum_full *full, double scale, const double *x, double *r) {
  if (full->def.damping_alpha > 0)
    full_subtract_mass(full, scale * full->def.damping_alpha, x, r);
  if (!(full->def.damping_beta > 0))
    return;
  thrum_sparse_product(&full->body.stiffness, x, 1, full->product);
  for (int64_t i = 0; i < full->body.fem.free_count; i++)
    r[i] -= scale * full->def.damping_beta * full->product[i];
}

thrum_status full_assemble(thrum_full *full, const double *place, double of_tangent, double of_mass,
                           double of_damping, thrum_error *error) {
  const thrum_sparse *rest = &full->body.stiffness, *mass = &full->body.mass;
  if (full->positive && place)
    thrum_fem_stiffness_positive(full_elastic(full), place, &full->tangent);
  else
    THRUM_TRY(thrum_fem_stiffness(full_elastic(full), place, &full->tangent, error));
  const double of_rest = of_damping * full->def.damping_beta;
  for (int64_t e = 0; e < rest->begin[rest->size]; e++)
    full->system.value[e] = of_tangent * full->tangent.value[e] + of_rest * rest->value[e];
  const double weight = of_mass + of_damping * full->def.damping_alpha;
  for (int64_t e = 0; e < mass->begin[mass->size]; e++)
    full->system.value[full->mass_slot[e]] += weight * mass->value[e];
  return THRUM_OK;
}
