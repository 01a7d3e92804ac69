/* Surface tractions: f_a = sum over the triangles around a of (area/3) t, the consistent load of a
 * linear triangle under a uniform traction. Cost: finding the surface, linear in the mesh.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/traction.h"

#include <math.h>
#include <stdlib.h>

#include "mesh/mesh_faces.h"
#include "platform/allocate.h"
#include "precompute/model/model_fem.h"

/* Area of a triangle [m^2]. */
static double area_of(const double *vertices, const int32_t corner[3]) {
  double a[3], b[3], sum = 0;
  for (int c = 0; c < 3; c++) {
    a[c] = vertices[3 * corner[1] + c] - vertices[3 * corner[0] + c];
    b[c] = vertices[3 * corner[2] + c] - vertices[3 * corner[0] + c];
  }
  for (int c = 0; c < 3; c++) {
    const double normal = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
    sum += normal * normal;
  }
  return 0.5 * sqrt(sum);
}

/* Loads the triangles whose vertices are all chosen; returns their area. */
static double load_faces(const thrum_mesh *mesh, const thrum_mesh_faces *faces,
                         const uint8_t *chosen, const double traction[3], double *forces) {
  double whole = 0;
  for (int64_t n = 0; n < faces->count; n++) {
    const int32_t *corner = faces->faces[n].vertices;

    // inner faces and faces with a vertex that is not chosen carry no load
    if (faces->faces[n].other >= 0 || !chosen[corner[0]] || !chosen[corner[1]] ||
        !chosen[corner[2]])
      continue;

    // each corner takes a third
    const double area = area_of(mesh->vertices, corner);
    whole += area;
    for (int k = 0; k < 3; k++)
      for (int c = 0; c < 3; c++)
        forces[3 * (int64_t)corner[k] + c] += area / 3 * traction[c];
  }

  return whole;
}

thrum_status thrum_traction_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double traction[3], double *forces, double *area,
                                 thrum_error *error) {
  // the model's mesh as the functions of meshes take it
  thrum_mesh mesh = {0};
  thrum_mesh_faces faces = {0};
  thrum_status status = thrum_model_borrow_mesh(model, &mesh, error);
  if (status < 0)
    return status;

  // which vertices bear the traction, and the triangles of the surface
  uint8_t *chosen = thrum_allocate(mesh.vertex_count, 1, "the surface", error);
  if (chosen == NULL) {
    status = THRUM_OUT_OF_MEMORY;
  } else {
    int64_t tets[3];
    for (int64_t v = 0; v < mesh.vertex_count; v++)
      chosen[v] = vertices == NULL;
    for (int64_t k = 0; vertices != NULL && k < count; k++)
      chosen[vertices[k]] = 1;
    status = thrum_mesh_find_faces(&mesh, &faces, tets, error);
  }

  // each triangle whose three vertices do hands its share to them
  if (status >= 0) {
    const double whole = load_faces(&mesh, &faces, chosen, traction, forces);
    if (!(whole > 0))
      status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                               "no triangle of the surface has all of its vertices there, so a "
                               "traction has nothing to act on");
    else if (area != NULL)
      *area = whole;
  }

  free(chosen);
  free(faces.faces);
  free(mesh.materials);
  return status;
}
