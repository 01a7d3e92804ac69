/* Static responses to unit forces, design 2: x = K^-1 f, scaled to x^T M x = 1, with the Rayleigh
 * quotient x^T K x / x^T M x in place of a mode's squared frequency. After attachment modes, see
 * R. Craig 1981, Structural dynamics. Cost: three solves a handle.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/basis/handles.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/text.h"
#include "platform/allocate.h"

thrum_status thrum_handle_find(const thrum_mesh *mesh, const char *spec, thrum_handle *handle,
                               thrum_error *error) {
  static const char key[] = "vertex=";
  const size_t length = sizeof key - 1;

  // a vertex by its number in the file
  if (strncmp(spec, key, length) == 0) {
    int64_t number = 0;
    const char *end = spec + strlen(spec);
    const bool whole =
        thrum_text_scan_integer(spec + length, end, &number) == (size_t)(end - spec) - length;
    const int64_t vertex = whole ? thrum_mesh_vertex_of(mesh, number) : -1;
    if (vertex < 0)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "'%.100s': the mesh has no such vertex that an element uses", spec);
    *handle = (thrum_handle){.name = spec, .count = 1, .vertex = (int32_t)vertex};
    return THRUM_OK;
  }

  // a group by its name
  for (int64_t g = 0; g < mesh->group_count; g++)
    if (strcmp(mesh->groups[g].name, spec) == 0 && mesh->groups[g].count > 0) {
      *handle = (thrum_handle){
          .name = spec, .count = mesh->groups[g].count, .vertices = mesh->groups[g].vertices};
      return THRUM_OK;
    }
  return thrum_error_set(error, THRUM_MISSING,
                         "'%.100s' is neither a group of the mesh nor vertex=N nor near:X,Y,Z",
                         spec);
}

// unit forces along the axes, 3 columns; refuses a handle that cannot move
static thrum_status fill_forces(const thrum_fem *fem, const thrum_handle *handle, double *force,
                                thrum_error *error) {
  bool moves = false;
  memset(force, 0, sizeof *force * (size_t)(3 * fem->free_count));
  for (int64_t n = 0; n < handle->count; n++) {
    const int64_t v = handle->vertices ? handle->vertices[n] : handle->vertex;
    for (int axis = 0; axis < 3; axis++) {
      const int32_t dof = fem->dof[3 * v + axis];
      if (dof >= 0)
        force[axis * fem->free_count + dof] += 1.0 / (double)handle->count;
      moves = moves || dof >= 0;
    }
  }
  return moves ? THRUM_OK
               : thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                                 "--handles '%.100s': all of it is held", handle->name);
}

// x of unit mass norm; its Rayleigh quotient with K x = f
static double normalise(const thrum_fem *fem, const thrum_sparse *mass, const double *force,
                        double *x, double *work) {
  const int n = (int)fem->free_count;
  const double compliance = cblas_ddot(n, x, 1, force, 1);
  thrum_sparse_product(mass, x, 1, work);
  const double square = cblas_ddot(n, x, 1, work, 1);
  if (!(square > 0 && compliance > 0)) {
    memset(x, 0, sizeof *x * (size_t)n);
    return INFINITY;
  }
  cblas_dscal(n, 1 / sqrt(square), x, 1);
  return compliance / square;
}

thrum_status thrum_handle_responses(const thrum_fem *fem, const thrum_sparse *mass,
                                    thrum_factor *factor, int64_t count,
                                    const thrum_handle *handles, double *responses, double *omega2,
                                    thrum_error *error) {
  const int64_t n = fem->free_count;
  double *force = NULL;
  thrum_status status = thrum_reserve(&force, 4 * n, sizeof *force, "the handles", error);
  for (int64_t h = 0; h < count && status >= 0; h++) {
    double *x = responses + 3 * h * n;
    status = fill_forces(fem, &handles[h], force, error);
    THRUM_THEN(status, thrum_factor_solve(factor, force, 3, x, error));
    for (int axis = 0; axis < 3 && status >= 0; axis++)
      omega2[3 * h + axis] = normalise(fem, mass, force + axis * n, x + axis * n, force + 3 * n);
  }
  free(force);
  return status;
}
