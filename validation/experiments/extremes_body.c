/* Makes the bodies of the extremes: meshes built on the spot, and their reduced models.
 *
 * The mirrored beam: each cell of split=6 is cut into six tets along one diagonal; mirrored
 * about the axis they are mapped to themselves by the eight symmetries of the square, whose
 * two-dimensional representation makes pairs of bending modes of equal frequency, exactly.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_clean.h"
#include "mesh/mesh_fix.h"
#include "mesh/mesh_groups.h"
#include "platform/allocate.h"
#include "validation/experiments/extremes.h"

#define ARCH_RISE 0.04 /* of the span */

static thrum_status make_beam(const experiment_extreme *extreme, thrum_mesh *mesh,
                              thrum_error *error) {
  char spec[160];
  snprintf(spec, sizeof spec, "beam:%dx%dx%d@%.17gx%.17gx%.17g,split=6", extreme->cells[0],
           extreme->cells[1], extreme->cells[2], extreme->size[0], extreme->size[1],
           extreme->size[2]);
  return thrum_mesh_read(spec, 1, mesh, error);
}

/* Mirrors the cells below the middle of one axis of the grid, of `cells` cells along it. */
static void mirror(thrum_mesh *mesh, const int cells[3], int axis) {
  const int64_t strides[3] = {(int64_t)(cells[1] + 1) * (cells[2] + 1), cells[2] + 1, 1};
  const int64_t steps[3] = {(int64_t)cells[1] * cells[2], cells[2], 1};
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    const int64_t cell = t / 6 / steps[axis] % cells[axis];
    int32_t *tet = mesh->tets + 4 * t;
    if (2 * cell >= cells[axis])
      continue;

    // a grid line at `at` goes to 2 cell + 1 - at, its mirror image within the cell
    for (int n = 0; n < 4; n++) {
      const int64_t at = tet[n] / strides[axis] % (cells[axis] + 1);
      tet[n] += (int32_t)(strides[axis] * (2 * cell + 1 - 2 * at));
    }
    // a mirrored tet is wound the other way
    const int32_t swap = tet[2];
    tet[2] = tet[3];
    tet[3] = swap;
  }
}

/* Bends the beam to a shallow parabola, and names the crown: what lies in its middle. */
static thrum_status bend(const experiment_extreme *extreme, thrum_mesh *mesh, thrum_error *error) {
  const double span = extreme->size[0];
  int32_t *crown = NULL;
  THRUM_TRY(thrum_reserve(&crown, mesh->vertex_count, sizeof *crown, "the arch", error));
  int64_t count = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++) {
    const double along = mesh->vertices[3 * v] / span;
    mesh->vertices[3 * v + 2] += ARCH_RISE * span * 4 * along * (1 - along);
    if (fabs(along - 0.5) < 1e-6)
      crown[count++] = (int32_t)v;
  }
  const thrum_status status = thrum_mesh_add_group(mesh, "crown", crown, count, error);
  free(crown);
  return status;
}

static thrum_status make_tet(const experiment_extreme *extreme, thrum_mesh *mesh,
                             thrum_error *error) {
  static const char text[] = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n"
                             "0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n";
  static const int32_t last = 3;
  thrum_mesh made = {0};
  const thrum_mesh_source source = {"one tetrahedron", text, sizeof text - 1, NULL, false, false};
  thrum_status status = thrum_mesh_parse_medit(&source, &made, error);
  THRUM_THEN(status, thrum_mesh_clean(&made, "one tetrahedron", extreme->size[0], error));
  THRUM_THEN(status, thrum_mesh_add_group(&made, "apex", &last, 1, error));
  if (status >= 0)
    *mesh = made;
  else
    thrum_mesh_free(&made);
  return status;
}

static thrum_status make_mesh(const experiment_extreme *extreme, thrum_mesh *mesh,
                              thrum_error *error) {
  if (extreme->shape == EXPERIMENT_SHAPE_TET)
    return make_tet(extreme, mesh, error);
  thrum_status status = THRUM_OK;
  THRUM_TRY(make_beam(extreme, mesh, error));
  if (extreme->shape == EXPERIMENT_SHAPE_SQUARE) {
    mirror(mesh, extreme->cells, 1);
    mirror(mesh, extreme->cells, 2);
  }
  if (extreme->shape == EXPERIMENT_SHAPE_ARCH)
    status = bend(extreme, mesh, error);
  if (status < 0)
    thrum_mesh_free(mesh);
  return status;
}

/* Holds one end, both ends of the arch, or three corners of the tet. */
static thrum_status hold(const experiment_extreme *extreme, const thrum_mesh *mesh, uint8_t *fixed,
                         thrum_error *error) {
  static const char *const held[] = {"left", "left", "left", NULL};
  int64_t count = 0;
  if (extreme->free)
    return THRUM_OK;
  if (extreme->shape == EXPERIMENT_SHAPE_TET) {
    memset(fixed, 7, 3);
    return THRUM_OK;
  }
  thrum_status status = thrum_mesh_fix(mesh, held[extreme->shape], fixed, &count, error);
  if (status >= 0 && extreme->shape == EXPERIMENT_SHAPE_ARCH)
    status = thrum_mesh_fix(mesh, "right", fixed, &count, error);
  return status;
}

static thrum_status reduce(const experiment_extreme *extreme, thrum_mesh *mesh,
                           thrum_precomputed *made, thrum_error *error) {
  thrum_precompute_options options = thrum_default_precompute_options();
  uint8_t *fixed = NULL;
  THRUM_TRY(thrum_reserve(&fixed, mesh->vertex_count, 1, extreme->name, error));
  options.modes = extreme->modes;
  options.rank = extreme->rank;
  for (int64_t n = 0; n < mesh->region_count; n++)
    mesh->materials[n] = extreme->material;
  mesh->has_material = true;
  thrum_status status = hold(extreme, mesh, fixed, error);
  THRUM_THEN(status, thrum_precompute(mesh, fixed, &options, made, error));
  free(fixed);
  return status;
}

/* Where it is pushed, how strongly, and how fast it is stepped. */
static thrum_status prepare(const experiment_extreme *extreme, experiment_extreme_body *made,
                            thrum_error *error) {
  static const char *const groups[] = {"tip", "tip", "crown", "apex"};
  static const double softest[3] = {0, 0, 0}, down[3] = {0, 0, -1};
  const thrum_model *model = &made->made.model;
  THRUM_TRY(experiment_body_init(extreme->name, model, groups[extreme->shape],
                                 extreme->shape == EXPERIMENT_SHAPE_ARCH ? down : softest,
                                 &made->body, error));
  made->omega[0] = sqrt(model->omega2[0]);
  made->omega[1] = sqrt(model->omega2[model->rank - 1]);
  made->force = extreme->load * made->body.length / made->body.compliance;
  made->dt =
      extreme->dt > 0 ? extreme->dt : extreme->angle / sqrt(model->omega2[extreme->mode - 1]);
  return THRUM_OK;
}

thrum_status experiment_extreme_make(const experiment_extreme *extreme,
                                     experiment_extreme_body *made, thrum_error *error) {
  experiment_extreme_body body = {.extreme = extreme};

  // a body that is refused is a result, and keeps its reason
  thrum_mesh mesh = {0};
  body.status = make_mesh(extreme, &mesh, &body.refusal);
  if (body.status >= 0)
    body.status = reduce(extreme, &mesh, &body.made, &body.refusal);
  thrum_mesh_free(&mesh);
  if (body.status >= 0) {
    body.status = prepare(extreme, &body, &body.refusal);
    if (body.status < 0)
      thrum_precomputed_free(&body.made);
  }

  // missing memory alone is none
  if (body.status == THRUM_OUT_OF_MEMORY) {
    if (error != NULL)
      *error = body.refusal;
    return body.status;
  }

  // the copy has moved, and the body borrows the model
  *made = body;
  made->body.model = &made->made.model;
  return THRUM_OK;
}

void experiment_extreme_free(experiment_extreme_body *made) {
  if (made->status >= 0 && made->extreme != NULL) {
    experiment_body_free(&made->body);
    thrum_precomputed_free(&made->made);
  }
  memset(made, 0, sizeof *made);
}
