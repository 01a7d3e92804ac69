/* Surface tractions: f_a = sum over the faces around a of t times the integral of N_a, the shape
 * function of the element, so it is the consistent load of a uniform traction: area/3 at each node
 * of a linear triangle, a quarter at each of a rectangle; in a triangle of six nodes nothing at its
 * corners and area/3 at its middle nodes, in a rectangle of eight -area/12 and area/3.
 * Cost: finding the surface, linear in the mesh. SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/traction.h"

#include <stdlib.h>
#include <string.h>

#include "mesh/mesh_faces.h"
#include "platform/allocate.h"
#include "precompute/fem/solid_face.h"
#include "precompute/model/model_fem.h"

/* An element, which is a solid or, where the mesh has none, a tetrahedron. */
typedef struct traction_element {
  thrum_solid_form form;
  int32_t nodes[THRUM_SOLID_NODES_MAX];
  double places[THRUM_SOLID_NODES_MAX][3];
} traction_element;

static int64_t element_count(const thrum_mesh *mesh) {
  return mesh->solid_count > 0 ? mesh->solid_count : mesh->tet_count;
}

static void read_element(const thrum_mesh *mesh, int64_t e, traction_element *made) {
  if (mesh->solid_count > 0) {
    const int32_t begin = e > 0 ? mesh->solid_ends[e - 1] : 0;
    made->form = (thrum_solid_form)mesh->solid_form[e];
    memcpy(made->nodes, mesh->solid_nodes + begin,
           sizeof(int32_t) * (size_t)(mesh->solid_ends[e] - begin));
  } else {
    made->form = mesh->midsides ? THRUM_FORM_TET10 : THRUM_FORM_TET4;
    thrum_mesh_nodes(mesh, e, made->nodes);
  }
  for (int n = 0; n < thrum_solid_forms[made->form].nodes; n++)
    memcpy(made->places[n], mesh->vertices + 3 * (int64_t)made->nodes[n], sizeof *made->places);
}

/* The face that a triangle of the surface is a part of; -1: none. */
static int face_of(const traction_element *element, const int32_t triangle[3]) {
  const thrum_solid kind = thrum_solid_forms[element->form].kind;
  for (int face = 0; face < thrum_solid_shapes[kind].faces; face++) {
    int nodes[THRUM_SOLID_FACE_NODES_MAX], found = 0;
    const int count = thrum_solid_face_nodes(element->form, face, nodes);
    for (int k = 0; k < 3 * count; k++)
      found += element->nodes[nodes[k / 3]] == triangle[k % 3];
    if (found == 3)
      return face;
  }
  return -1;
}

/* Loads a face whose nodes are all chosen; returns its area, else 0. */
static double load_face(traction_element *element, int face, const uint8_t *chosen,
                        const double traction[3], double *forces) {
  int nodes[THRUM_SOLID_FACE_NODES_MAX];
  double shares[THRUM_SOLID_FACE_NODES_MAX];
  const int count = thrum_solid_face_nodes(element->form, face, nodes);
  for (int k = 0; k < count; k++)
    if (!chosen[element->nodes[nodes[k]]])
      return 0;
  const double area = thrum_solid_face_shares(element->form, face, element->places, shares);
  for (int k = 0; k < 3 * count; k++)
    forces[3 * (int64_t)element->nodes[nodes[k / 3]] + k % 3] += shares[k / 3] * traction[k % 3];
  return area;
}

/* Loads the faces of the surface whose nodes are all chosen; returns their area. `done` has a bit
 * for each face of an element, as several triangles lie on one. */
static double load_faces(const thrum_mesh *mesh, const thrum_mesh_faces *faces, uint8_t *done,
                         const uint8_t *chosen, const double traction[3], double *forces) {
  double whole = 0;
  int64_t e = 0;
  for (int64_t n = 0; n < faces->count; n++) {
    const thrum_mesh_face *triangle = &faces->faces[n];

    // faces are in the order of their tets, and these in that of their solids
    while (mesh->solid_count > 0 && triangle->tet >= mesh->solid_tet_ends[e])
      e++;
    if (mesh->solid_count == 0)
      e = triangle->tet;
    if (triangle->other >= 0)
      continue;
    traction_element element;
    read_element(mesh, e, &element);
    const int face = face_of(&element, triangle->vertices);
    if (face < 0 || (done[e] >> face & 1))
      continue;
    done[e] = (uint8_t)(done[e] | 1 << face);
    whole += load_face(&element, face, chosen, traction, forces);
  }
  return whole;
}

thrum_status thrum_traction_fill(const thrum_model *model, const int32_t *vertices, int64_t count,
                                 const double traction[3], double *forces, double *area,
                                 thrum_error *error) {
  // the model's mesh as the functions of meshes take it
  thrum_mesh mesh = {0};
  thrum_mesh_faces faces = {0};
  uint8_t *chosen = NULL, *done = NULL;
  THRUM_TRY(thrum_model_borrow_mesh(model, &mesh, error));

  // which vertices bear the traction, and the triangles of the surface
  thrum_status status = thrum_reserve(&chosen, mesh.vertex_count, 1, "the surface", error);
  THRUM_THEN(status, thrum_reserve(&done, element_count(&mesh), 1, "the surface", error));
  if (status >= 0) {
    int64_t tets[3];
    for (int64_t v = 0; v < mesh.vertex_count; v++)
      chosen[v] = vertices == NULL;
    for (int64_t k = 0; vertices != NULL && k < count; k++)
      chosen[vertices[k]] = 1;
    status = thrum_mesh_find_faces(&mesh, &faces, tets, error);
  }

  // each face whose nodes all do hands its share to them
  if (status >= 0) {
    const double whole = load_faces(&mesh, &faces, done, chosen, traction, forces);
    if (!(whole > 0))
      status = thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                               "no face of the surface has all of its vertices there, so a "
                               "traction has nothing to act on");
    else if (area != NULL)
      *area = whole;
  }

  free(chosen);
  free(done);
  free(faces.faces);
  thrum_model_return_mesh(&mesh);
  return status;
}
