/* Surface tractions: f_a = sum over the triangles around a of t times the integral of N_a, the
 * consistent load of a uniform traction: area/3 at each node of a linear triangle, and in one of
 * six nodes nothing at its corners and area/3 at its middle nodes where its edges are straight;
 * curved ones take seven points (degree 5, Radon 1948, doi:10.1007/BF01525334). Cost: finding the
 * surface, linear in the mesh. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/traction.h"

#include <math.h>
#include <stdlib.h>

#include "core/base/vec3.h"
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

/* Shape functions of a six-node triangle at barycentric coordinates l, corners first, then the
 * middle nodes of edges 01, 12, 20, and their derivatives by l_1 and l_2. */
static void triangle_shape(const double l[3], double shape[6], double slopes[6][2]) {
  for (int k = 0; k < 3; k++) {
    const int n = (k + 1) % 3;
    shape[k] = l[k] * (2 * l[k] - 1);
    shape[3 + k] = 4 * l[k] * l[n];
    for (int d = 0; d < 2; d++) {
      // l_0 falls as the others rise
      const double own = k == 0 ? -1 : k == d + 1, next = n == 0 ? -1 : n == d + 1;
      slopes[k][d] = (4 * l[k] - 1) * own;
      slopes[3 + k][d] = 4 * (l[k] * next + l[n] * own);
    }
  }
}

/* Loads a six-node triangle; returns its area. */
static double load_quadratic(const double *vertices, const int32_t node[6],
                             const double traction[3], double *forces) {
  // seven points of degree 5: the centre and two orbits of three
  static const double a = 0.47014206410511508977, b = 0.10128650732345633880;
  static const double weight_a = 0.13239415278850618074, weight_b = 0.12593918054482715260;
  double whole = 0;
  for (int p = 0; p < 7; p++) {
    const double share = p == 6 ? 1.0 / 3 : p < 3 ? a : b;
    double l[3] = {share, share, share}, shape[6], slopes[6][2], edge[2][3] = {{0}};
    if (p < 6)
      l[p % 3] = 1 - 2 * share;
    triangle_shape(l, shape, slopes);

    // the map's two edges span twice the area around the point
    for (int n = 0; n < 6; n++)
      for (int d = 0; d < 2; d++)
        for (int c = 0; c < 3; c++)
          edge[d][c] += slopes[n][d] * vertices[3 * (int64_t)node[n] + c];
    double normal[3];
    thrum_cross3(edge[0], edge[1], normal);
    const double weight = p == 6 ? 0.225 : p < 3 ? weight_a : weight_b;
    const double area = weight * sqrt(thrum_dot3(normal, normal)) / 2;
    whole += area;
    for (int n = 0; n < 6; n++)
      for (int c = 0; c < 3; c++)
        forces[3 * (int64_t)node[n] + c] += area * shape[n] * traction[c];
  }
  return whole;
}

/* Loads a face of ten-node tets whose six nodes are all chosen; returns its area, else 0. */
static double load_six_nodes(const thrum_mesh *mesh, const thrum_mesh_face *face,
                             const uint8_t *chosen, const double traction[3], double *forces) {
  int32_t node[6];
  for (int k = 0; k < 3; k++) {
    node[k] = face->vertices[k];
    node[3 + k] =
        thrum_mesh_middle_node(mesh, face->tet, face->vertices[k], face->vertices[(k + 1) % 3]);
  }
  for (int n = 0; n < 6; n++)
    if (!chosen[node[n]])
      return 0;
  return load_quadratic(mesh->vertices, node, traction, forces);
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
    if (mesh->midsides != NULL) {
      whole += load_six_nodes(mesh, &faces->faces[n], chosen, traction, forces);
      continue;
    }

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
  uint8_t *chosen = NULL;
  THRUM_TRY(thrum_model_borrow_mesh(model, &mesh, error));

  // which vertices bear the traction, and the triangles of the surface
  thrum_status status = thrum_reserve(&chosen, mesh.vertex_count, 1, "the surface", error);
  if (status >= 0) {
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
  thrum_model_return_mesh(&mesh);
  return status;
}
