/* Cutting a body into parts, see body_cut.h: the graph of the vertices, whose edges join those of
 * one tet, is cut by PT-Scotch (Chevalier, Pellegrini 2008, doi:10.1016/j.parco.2007.12.001) so
 * that parts have equally many vertices and few neighbours. A tet goes where most of its vertices
 * are. Cost: O(vertices) in each process, but for the graph, which rank 0 makes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/body_cut.h"

#include <petscmat.h>
#include <stdlib.h>
#include <string.h>

#include "mpi/petsc_status.h"
#include "platform/allocate.h"

/* Fewer vertices than this for each part are dealt out in a row: nothing is gained by more. */
#define CUT_LEAST 64

typedef struct vertex_graph {
  int64_t *begin; /* vertex_count + 1 */
  int32_t *next;  /* begin[vertex_count]: neighbours */
} vertex_graph;

// the neighbours of every vertex; mark[w] == v says that w is listed
static void walk_graph(const thrum_fem *fem, int32_t *mark, vertex_graph *graph) {
  int64_t count = 0;
  for (int64_t v = 0; v < fem->vertex_count; v++)
    mark[v] = -1;

  // every node of the tets around a vertex is its neighbour, but the vertex itself
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    mark[v] = (int32_t)v;
    for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
      const int32_t *node = fem->nodes + fem->incident[e] / fem->node_count * fem->node_count;
      for (int a = 0; a < fem->node_count; a++)
        if (mark[node[a]] != v) {
          mark[node[a]] = (int32_t)v;
          if (graph->next != NULL)
            graph->next[count] = node[a];
          count++;
        }
    }
    graph->begin[v + 1] = count;
  }
}

static thrum_status graph_make(const thrum_fem *fem, thrum_scope *memory, vertex_graph *graph) {
  int32_t *mark = thrum_scope_allocate(memory, fem->vertex_count, sizeof *mark);
  graph->begin = thrum_scope_allocate(memory, fem->vertex_count + 1, sizeof *graph->begin);
  THRUM_TRY(memory->status);

  // the first walk counts the neighbours, the second one lists them
  walk_graph(fem, mark, graph);
  graph->next = thrum_scope_allocate(memory, graph->begin[fem->vertex_count], sizeof *graph->next);
  THRUM_TRY(memory->status);
  walk_graph(fem, mark, graph);
  return THRUM_OK;
}

// the first row of the graph that a process holds while it is cut
static int64_t slice_begin(int64_t count, int parts, int part) {
  return count * part / parts;
}

// rows [first, end) of the graph as PETSc wants them, which frees them
static thrum_status slice_receive(MPI_Comm comm, const vertex_graph *graph, int64_t count,
                                  PetscInt **begin, PetscInt **next, thrum_error *error) {
  int rank, parts;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &parts);
  const int64_t rows = slice_begin(count, parts, rank + 1) - slice_begin(count, parts, rank);
  int64_t entries = 0;
  PETSC_TRY(PetscMalloc1((size_t)rows + 1, begin));

  // rank 0 deals the rows out, and takes its own
  for (int part = 0; rank == 0 && part < parts; part++) {
    const int64_t first = slice_begin(count, parts, part),
                  end = slice_begin(count, parts, part + 1);
    const int64_t size = graph->begin[end] - graph->begin[first];
    PetscInt *local = *begin;
    if (part > 0)
      PETSC_TRY(PetscMalloc1((size_t)(end - first) + 1, &local));
    for (int64_t v = first; v <= end; v++)
      local[v - first] = (PetscInt)(graph->begin[v] - graph->begin[first]);
    if (part == 0) {
      PETSC_TRY(PetscMalloc1((size_t)size + 1, next));
      memcpy(*next, graph->next + graph->begin[first], sizeof **next * (size_t)size);
      continue;
    }
    MPI_Send(local, (int)(end - first + 1), MPIU_INT, part, 0, comm);
    MPI_Send(graph->next + graph->begin[first], (int)size, MPI_INT32_T, part, 0, comm);
    PETSC_TRY(PetscFree(local));
  }
  if (rank == 0)
    return THRUM_OK;

  MPI_Recv(*begin, (int)rows + 1, MPIU_INT, 0, 0, comm, MPI_STATUS_IGNORE);
  entries = (*begin)[rows];
  PETSC_TRY(PetscMalloc1((size_t)entries + 1, next));
  MPI_Recv(*next, (int)entries, MPIU_INT, 0, 0, comm, MPI_STATUS_IGNORE);
  return THRUM_OK;
}

// part (count, in rank 0): where each vertex goes
static thrum_status cut_graph(MPI_Comm comm, const vertex_graph *graph, int64_t count,
                              int32_t *part, thrum_error *error) {
  int rank, parts;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &parts);
  if (count < (int64_t)CUT_LEAST * parts) {
    for (int64_t v = 0; rank == 0 && v < count; v++)
      part[v] = (int32_t)(v * parts / count);
    return THRUM_OK;
  }

  // the graph by rows, a slice in each process
  PetscInt *begin = NULL, *next = NULL;
  Mat adjacency;
  MatPartitioning cutter;
  IS chosen;
  const int64_t rows = slice_begin(count, parts, rank + 1) - slice_begin(count, parts, rank);
  THRUM_TRY(slice_receive(comm, graph, count, &begin, &next, error));
  PETSC_TRY(MatCreateMPIAdj(comm, (PetscInt)rows, (PetscInt)count, begin, next, NULL, &adjacency));
  PETSC_TRY(MatPartitioningCreate(comm, &cutter));
  PETSC_TRY(MatPartitioningSetAdjacency(cutter, adjacency));
  PETSC_TRY(MatPartitioningSetType(cutter, MATPARTITIONINGPTSCOTCH));
  PETSC_TRY(MatPartitioningApply(cutter, &chosen));

  // what each process says of its slice comes back to rank 0
  const PetscInt *local;
  PETSC_TRY(ISGetIndices(chosen, &local));
  if (rank > 0)
    MPI_Send(local, (int)rows, MPIU_INT, 0, 0, comm);
  for (int from = 0; rank == 0 && from < parts; from++) {
    const int64_t first = slice_begin(count, parts, from),
                  end = slice_begin(count, parts, from + 1);
    if (from == 0)
      memcpy(part, local, sizeof *part * (size_t)rows);
    else
      MPI_Recv(part + first, (int)(end - first), MPIU_INT, from, 0, comm, MPI_STATUS_IGNORE);
  }
  PETSC_TRY(ISRestoreIndices(chosen, &local));
  PETSC_TRY(ISDestroy(&chosen));
  PETSC_TRY(MatPartitioningDestroy(&cutter));
  PETSC_TRY(MatDestroy(&adjacency));
  return THRUM_OK;
}

// a tet goes to the part of most of its nodes, the lowest of several
static void deal_tets(const thrum_fem *fem, const int32_t *part, int32_t *tet_part) {
  for (int64_t t = 0; t < fem->tet_count; t++) {
    const int32_t *node = fem->nodes + fem->node_count * t;
    int most = 0;
    tet_part[t] = INT32_MAX;
    for (int a = 0; a < fem->node_count; a++) {
      int votes = 0;
      for (int b = 0; b < fem->node_count; b++)
        votes += part[node[b]] == part[node[a]];
      if (votes > most || (votes == most && part[node[a]] < tet_part[t])) {
        most = votes;
        tet_part[t] = part[node[a]];
      }
    }
  }
}

// a vertex stays with the part that was chosen for it where that part has one of its tets;
// otherwise the lowest part that has one becomes its owner
static void choose_owners(const thrum_fem *fem, const int32_t *tet_part, int32_t *owner) {
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    int32_t lowest = INT32_MAX;
    bool stays = false;
    for (int64_t e = fem->incident_begin[v]; e < fem->incident_begin[v + 1]; e++) {
      const int32_t part = tet_part[fem->incident[e] / fem->node_count];
      stays = stays || part == owner[v];
      lowest = part < lowest ? part : lowest;
    }
    if (!stays)
      owner[v] = lowest;
  }
}

// the order of the vertices by parts (next: parts), and the neighbours of each by owner
static void number_vertices(const thrum_fem *fem, const vertex_graph *graph, int64_t *next,
                            body_cut *cut) {
  for (int64_t v = 0; v < fem->vertex_count; v++)
    cut->own_count[cut->owner[v]]++;
  for (int part = 1; part < cut->parts; part++)
    next[part] = next[part - 1] + cut->own_count[part - 1];
  for (int64_t v = 0; v < fem->vertex_count; v++)
    cut->place[v] = (int32_t)next[cut->owner[v]]++;

  for (int64_t v = 0; v < fem->vertex_count; v++) {
    cut->inner[v] = 1;
    for (int64_t e = graph->begin[v]; e < graph->begin[v + 1]; e++)
      ++*(cut->owner[graph->next[e]] == cut->owner[v] ? &cut->inner[v] : &cut->outer[v]);
  }
}

static thrum_status cut_allocate(const thrum_fem *fem, int parts, body_cut *cut,
                                 thrum_error *error) {
  cut->parts = parts;
  cut->memory = thrum_scope_begin("the parts of the body", error);
  cut->owner = thrum_scope_allocate(&cut->memory, fem->vertex_count, sizeof *cut->owner);
  cut->tet_part = thrum_scope_allocate(&cut->memory, fem->tet_count, sizeof *cut->tet_part);
  cut->place = thrum_scope_allocate(&cut->memory, fem->vertex_count, sizeof *cut->place);
  cut->inner = thrum_scope_allocate(&cut->memory, fem->vertex_count, sizeof *cut->inner);
  cut->outer = thrum_scope_allocate(&cut->memory, fem->vertex_count, sizeof *cut->outer);
  cut->own_count = thrum_scope_allocate(&cut->memory, parts, sizeof *cut->own_count);
  return cut->memory.status;
}

thrum_status body_cut_make(MPI_Comm comm, const thrum_fem *fem, body_cut *cut, thrum_error *error) {
  int rank, parts;
  MPI_Comm_rank(comm, &rank);
  MPI_Comm_size(comm, &parts);
  body_cut made = {0};
  vertex_graph graph = {0};
  thrum_scope memory = thrum_scope_begin("the parts of the body", error);
  thrum_status status = THRUM_OK;
  if (rank == 0) {
    status = cut_allocate(fem, parts, &made, error);
    THRUM_THEN(status, graph_make(fem, &memory, &graph));
  }

  // all cut together, unless rank 0 has no graph to give
  int64_t count = rank == 0 && status >= 0 ? fem->vertex_count : 0;
  MPI_Bcast(&count, 1, MPI_INT64_T, 0, comm);
  if (count == 0 && rank > 0)
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the parts of the body");
  THRUM_THEN(status, cut_graph(comm, &graph, count, made.owner, error));

  int64_t *next = thrum_scope_allocate(&memory, parts, sizeof *next);
  THRUM_THEN(status, memory.status);
  if (rank == 0 && status >= 0) {
    deal_tets(fem, made.owner, made.tet_part);
    choose_owners(fem, made.tet_part, made.owner);
    number_vertices(fem, &graph, next, &made);
  }
  thrum_scope_free(&memory);
  if (status >= 0)
    *cut = made;
  else
    body_cut_free(&made);
  return status;
}

// whether a tet has a node that can move
static bool moves(const thrum_fem *fem, int64_t t) {
  for (int a = 0; a < fem->node_count; a++)
    for (int c = 0; c < 3; c++)
      if (fem->dof[3 * (int64_t)fem->nodes[fem->node_count * t + a] + c] >= 0)
        return true;
  return false;
}

bool body_cut_is_full(const thrum_fem *fem, const body_cut *cut) {
  bool full = true;
  for (int part = 0; part < cut->parts && full; part++) {
    full = false;
    for (int64_t t = 0; t < fem->tet_count && !full; t++)
      full = cut->tet_part[t] == part && moves(fem, t);
  }
  return full;
}

void body_cut_free(body_cut *cut) {
  thrum_scope_free(&cut->memory);
  *cut = (body_cut){0};
}
