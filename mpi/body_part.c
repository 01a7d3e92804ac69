/* Parts of a body on their way from rank 0 to the others, and rows on their way back, see
 * body_part.h. Rank 0 makes one part after the other, so that it holds no more than one beside the
 * whole. SPDX-License-Identifier: Apache-2.0 */
#include "mpi/body_part.h"

#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"

enum { TAG = 1 };

void body_part_free(body_part *part) {
  thrum_mesh_free(&part->mesh);
  thrum_scope_free(&part->memory);
  *part = (body_part){0};
}

// arrays of the sizes that the facts say
static thrum_status part_allocate(body_part *part, thrum_error *error) {
  const char *what = "a part of the body";
  const part_facts *facts = &part->facts;
  thrum_mesh *mesh = &part->mesh;
  mesh->vertex_count = facts->vertices;
  mesh->tet_count = facts->tets;
  mesh->region_count = facts->regions;
  mesh->has_material = true;
  THRUM_TRY(thrum_reserve(&mesh->vertices, 3 * facts->vertices, sizeof(double), what, error));
  THRUM_TRY(thrum_reserve(&mesh->tets, 4 * facts->tets, sizeof(int32_t), what, error));
  THRUM_TRY(thrum_reserve(&mesh->tet_region, facts->tets, sizeof(int32_t), what, error));
  THRUM_TRY(thrum_reserve(&mesh->materials, facts->regions, sizeof(thrum_material), what, error));
  if (facts->quadratic)
    THRUM_TRY(thrum_reserve(&mesh->midsides, 6 * facts->tets, sizeof(int32_t), what, error));

  // what the part knows of its vertices
  part->memory = thrum_scope_begin(what, error);
  part->fixed = thrum_scope_allocate(&part->memory, facts->vertices, 1);
  part->own = thrum_scope_allocate(&part->memory, facts->vertices, 1);
  part->vertex = thrum_scope_allocate(&part->memory, facts->vertices, sizeof(int32_t));
  part->place = thrum_scope_allocate(&part->memory, facts->vertices, sizeof(int32_t));
  part->inner = thrum_scope_allocate(&part->memory, facts->own, sizeof(int32_t));
  part->outer = thrum_scope_allocate(&part->memory, facts->own, sizeof(int32_t));
  return part->memory.status;
}

// local[v]: the number of vertex v in the part, or -1; sizes of the part
static void find_vertices(const thrum_mesh *mesh, const body_cut *cut, int number, int32_t *local,
                          part_facts *facts) {
  memset(local, -1, sizeof *local * (size_t)mesh->vertex_count);
  facts->tets = facts->vertices = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    int32_t nodes[10];
    if (cut->tet_part[t] != number)
      continue;
    facts->tets++;
    for (int a = thrum_mesh_nodes(mesh, t, nodes) - 1; a >= 0; a--)
      local[nodes[a]] = 0;
  }
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    if (local[v] == 0)
      local[v] = (int32_t)facts->vertices++;
  facts->own = cut->own_count[number];
}

// the vertices of the part in the order of the whole mesh
static void copy_vertices(const thrum_mesh *mesh, const uint8_t *fixed, const body_cut *cut,
                          int number, const int32_t *local, body_part *part) {
  int64_t owned = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++) {
    const int64_t n = local[v];
    if (n < 0)
      continue;
    memcpy(part->mesh.vertices + 3 * n, mesh->vertices + 3 * v, 3 * sizeof(double));
    part->fixed[n] = fixed[v];
    part->vertex[n] = (int32_t)v;
    part->place[n] = cut->place[v];
    part->own[n] = cut->owner[v] == number;
    if (part->own[n]) {
      part->inner[owned] = cut->inner[v];
      part->outer[owned++] = cut->outer[v];
    }
  }
}

static void copy_tets(const thrum_mesh *mesh, const body_cut *cut, int number, const int32_t *local,
                      body_part *part) {
  int64_t n = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    if (cut->tet_part[t] != number)
      continue;
    for (int a = 0; a < 4; a++)
      part->mesh.tets[4 * n + a] = local[mesh->tets[4 * t + a]];
    for (int a = 0; a < 6 && mesh->midsides; a++)
      part->mesh.midsides[6 * n + a] = local[mesh->midsides[6 * t + a]];
    part->mesh.tet_region[n++] = mesh->tet_region[t];
  }
  memcpy(part->mesh.materials, mesh->materials,
         sizeof *mesh->materials * (size_t)mesh->region_count);
}

static thrum_status make_part(const thrum_mesh *mesh, const uint8_t *fixed, const body_cut *cut,
                              const part_facts *facts, int number, int32_t *local, body_part *part,
                              thrum_error *error) {
  part->facts = *facts;
  part->facts.regions = mesh->region_count;
  part->facts.quadratic = mesh->midsides != NULL;
  find_vertices(mesh, cut, number, local, &part->facts);
  THRUM_TRY(part_allocate(part, error));
  copy_vertices(mesh, fixed, cut, number, local, part);
  copy_tets(mesh, cut, number, local, part);
  return THRUM_OK;
}

// one array after the other, sent or received: they are in the same order in both
typedef struct message {
  MPI_Comm comm;
  int other;
  bool sends;
} message;

static void pass(const message *m, void *array, int64_t count, MPI_Datatype type, int each) {
  MPI_Datatype row;
  MPI_Type_contiguous(each, type, &row);
  MPI_Type_commit(&row);
  if (m->sends)
    MPI_Send(array, (int)count, row, m->other, TAG, m->comm);
  else
    MPI_Recv(array, (int)count, row, m->other, TAG, m->comm, MPI_STATUS_IGNORE);
  MPI_Type_free(&row);
}

static void pass_arrays(const message *m, body_part *part) {
  const part_facts *facts = &part->facts;
  pass(m, part->mesh.vertices, facts->vertices, MPI_DOUBLE, 3);
  pass(m, part->mesh.tets, facts->tets, MPI_INT32_T, 4);
  pass(m, part->mesh.tet_region, facts->tets, MPI_INT32_T, 1);
  pass(m, part->mesh.materials, facts->regions, MPI_DOUBLE, 3);
  if (facts->quadratic)
    pass(m, part->mesh.midsides, facts->tets, MPI_INT32_T, 6);
  pass(m, part->fixed, facts->vertices, MPI_UINT8_T, 1);
  pass(m, part->own, facts->vertices, MPI_UINT8_T, 1);
  pass(m, part->vertex, facts->vertices, MPI_INT32_T, 1);
  pass(m, part->place, facts->vertices, MPI_INT32_T, 1);
  pass(m, part->inner, facts->own, MPI_INT32_T, 1);
  pass(m, part->outer, facts->own, MPI_INT32_T, 1);
}

static thrum_status send_part(MPI_Comm comm, int to, body_part *part) {
  const message m = {comm, to, true};
  pass(&m, &part->facts, (int64_t)sizeof part->facts, MPI_BYTE, 1);
  pass_arrays(&m, part);
  return THRUM_OK;
}

static thrum_status receive_part(MPI_Comm comm, body_part *part, thrum_error *error) {
  const message m = {comm, 0, false};
  pass(&m, &part->facts, (int64_t)sizeof part->facts, MPI_BYTE, 1);
  THRUM_TRY(part_allocate(part, error));
  pass_arrays(&m, part);
  return THRUM_OK;
}

// parts for all, the first one for this process itself
static thrum_status deal_parts(MPI_Comm comm, const thrum_mesh *mesh, const uint8_t *fixed,
                               const body_cut *cut, const part_facts *facts, body_part *own,
                               thrum_error *error) {
  int32_t *local = NULL;
  thrum_status status =
      thrum_reserve(&local, mesh->vertex_count, sizeof *local, "the parts of the body", error);
  for (int part = 1; part < cut->parts && status >= 0; part++) {
    body_part made = {0};
    status = make_part(mesh, fixed, cut, facts, part, local, &made, error);
    THRUM_THEN(status, send_part(comm, part, &made));
    body_part_free(&made);
  }
  THRUM_THEN(status, make_part(mesh, fixed, cut, facts, 0, local, own, error));
  free(local);
  return status;
}

thrum_status body_part_share(MPI_Comm comm, const thrum_mesh *mesh, const uint8_t *fixed,
                             const body_cut *cut, const part_facts *facts, body_part *part,
                             thrum_error *error) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  body_part made = {0};
  const thrum_status status = rank == 0 ? deal_parts(comm, mesh, fixed, cut, facts, &made, error)
                                        : receive_part(comm, &made, error);
  if (status >= 0)
    *part = made;
  else
    body_part_free(&made);
  return status;
}

// the rows of the vertices that a part owns, in their order
static void pack_own(const body_part *part, int64_t width, const double *rows, double *packed) {
  for (int64_t n = 0, next = 0; n < part->facts.vertices; n++)
    if (part->own[n])
      memcpy(packed + width * next++, rows + width * n, sizeof *rows * (size_t)width);
}

// rows of one part to their places in the whole
static void unpack(const body_cut *cut, int part, int64_t count, int64_t width,
                   const double *packed, double *whole) {
  for (int64_t v = 0, next = 0; v < count; v++)
    if (cut->owner[v] == part)
      memcpy(whole + width * v, packed + width * next++, sizeof *whole * (size_t)width);
}

thrum_status body_part_gather(MPI_Comm comm, const body_part *part, const body_cut *cut,
                              int64_t whole_count, int64_t width, const double *part_rows,
                              double *whole, thrum_error *error) {
  int rank;
  MPI_Comm_rank(comm, &rank);
  int64_t most = part->facts.own;
  for (int q = 0; rank == 0 && q < cut->parts; q++)
    most = cut->own_count[q] > most ? cut->own_count[q] : most;
  double *packed = NULL;
  THRUM_TRY(thrum_reserve(&packed, width * most, sizeof *packed, "the rows of a part", error));
  pack_own(part, width, part_rows, packed);

  // rank 0 takes one part after the other
  if (rank > 0) {
    const message m = {comm, 0, true};
    pass(&m, packed, part->facts.own, MPI_DOUBLE, (int)width);
  } else {
    for (int from = 0; from < cut->parts; from++) {
      const message m = {comm, from, false};
      if (from > 0)
        pass(&m, packed, cut->own_count[from], MPI_DOUBLE, (int)width);
      unpack(cut, from, whole_count, width, packed, whole);
    }
  }
  free(packed);
  return THRUM_OK;
}
