/* Do the held components, and those on springs, stop every rigid motion? For each connected part,
 * the six rigid motions restricted to its held components have full rank exactly when it is held.
 * O(vertices + tets).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/fem/constraints.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/lapack_status.h"

static int32_t root_of(int32_t *parent, int32_t v) {
  // halve the path on the way up
  while (parent[v] != v) {
    parent[v] = parent[parent[v]];
    v = parent[v];
  }
  return v;
}

// parent[v]: the lowest vertex of the connected part of v
static void find_parts(const thrum_fem *fem, int32_t *parent) {
  for (int64_t v = 0; v < fem->vertex_count; v++)
    parent[v] = (int32_t)v;
  for (int64_t t = 0; t < fem->tet_count; t++)
    for (int a = 1; a < fem->node_count; a++) {
      const int32_t p = root_of(parent, fem->nodes[fem->node_count * t]);
      const int32_t q = root_of(parent, fem->nodes[fem->node_count * t + a]);
      parent[p > q ? p : q] = p > q ? q : p;
    }
  for (int64_t s = 0; s < fem->solids.count; s++) {
    const int32_t *node = thrum_solid_nodes(&fem->solids, s);
    for (int a = 1; a < thrum_solid_node_count(&fem->solids, s); a++) {
      const int32_t p = root_of(parent, node[0]), q = root_of(parent, node[a]);
      parent[p > q ? p : q] = p > q ? q : p;
    }
  }
  for (int64_t v = 0; v < fem->vertex_count; v++)
    parent[v] = root_of(parent, (int32_t)v);
}

typedef struct part {
  double count, centre[3], size;
  double gram[36]; /* of the six rigid motions over the held components */
} part;

// adds one held component: its row of (1, x cross) about the centre, lengths in part sizes
static void hold(part *p, const double *position, int axis) {
  double row[6] = {0};
  double arm[3];
  for (int c = 0; c < 3; c++)
    arm[c] = (position[c] - p->centre[c]) / p->size;
  row[axis] = 1;
  row[3 + (axis + 1) % 3] = arm[(axis + 2) % 3];
  row[3 + (axis + 2) % 3] = -arm[(axis + 1) % 3];
  for (int c = 0; c < 6; c++)
    for (int d = 0; d < 6; d++)
      p->gram[6 * c + d] += row[c] * row[d];
}

static bool is_held(const thrum_fem *fem, int64_t component) {
  return fem->dof[component] < 0 || (fem->springs && fem->springs[component] > 0);
}

static void measure_parts(const thrum_fem *fem, const int32_t *parent, const int32_t *index,
                          part *parts) {
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    part *p = &parts[index[parent[v]]];
    p->count++;
    for (int c = 0; c < 3; c++)
      p->centre[c] += (fem->vertices[3 * v + c] - p->centre[c]) / p->count;
  }
  for (int64_t v = 0; v < fem->vertex_count; v++) {
    part *p = &parts[index[parent[v]]];
    for (int c = 0; c < 3; c++)
      p->size = fmax(p->size, fabs(fem->vertices[3 * v + c] - p->centre[c]));
  }
  for (int64_t c = 0; c < 3 * fem->vertex_count; c++)
    if (is_held(fem, c))
      hold(&parts[index[parent[c / 3]]], fem->vertices + c / 3 * 3, (int)(c % 3));
}

static thrum_status judge(part *p, thrum_error *error) {
  double values[6];
  double trace = 0;
  for (int c = 0; c < 6; c++)
    trace += p->gram[7 * c];

  // eigenvalues of the Gram matrix of the six motions at the held components
  THRUM_TRY(thrum_lapack_status(LAPACKE_dsyev(LAPACK_ROW_MAJOR, 'N', 'U', 6, p->gram, 6, values),
                                THRUM_SINGULAR, "the held components could not be judged", error));

  // one that vanishes beside the trace is a motion that nothing holds
  int motions = 0;
  for (int c = 0; c < 6; c++)
    motions += !(values[c] > 1e-14 * trace);

  if (motions == 0)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_SINGULAR,
                         "too little is fixed: %d rigid motions of the part around (%g, %g, %g) m "
                         "are free; fix more of it with --fix",
                         motions, p->centre[0], p->centre[1], p->centre[2]);
}

// one free body is a body of its own; several would each need rigid modes of theirs
static thrum_status judge_free(int32_t parts, bool *free_body, thrum_error *error) {
  if (parts > 1)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "nothing is fixed, and the mesh has %d separate parts: a free body is "
                           "one part; fix some of each with --fix, or split the mesh",
                           (int)parts);
  *free_body = true;
  return THRUM_OK;
}

thrum_status thrum_constraints_check(const thrum_fem *fem, bool *free_body, thrum_error *error) {
  *free_body = false;
  thrum_scope memory = thrum_scope_begin("the constraints", error);
  int32_t *parent = thrum_scope_allocate(&memory, fem->vertex_count, sizeof *parent);
  int32_t *index = thrum_scope_allocate(&memory, fem->vertex_count, sizeof *index);
  part *parts = NULL;
  thrum_status status = memory.status;

  if (status >= 0) {
    find_parts(fem, parent);

    // every part has a number, that of its first vertex
    int32_t count = 0;
    for (int64_t v = 0; v < fem->vertex_count; v++)
      index[v] = parent[v] == v ? count++ : -1;

    // a body with nothing held is free, if it is one part
    bool nothing_held = true;
    for (int64_t c = 0; c < 3 * fem->vertex_count && nothing_held; c++)
      nothing_held = !is_held(fem, c);
    if (nothing_held)
      status = judge_free(count, free_body, error);
    else
      parts = thrum_scope_allocate(&memory, count, sizeof *parts);
    THRUM_THEN(status, memory.status);

    // else each part is held against its own six motions
    if (parts) {
      measure_parts(fem, parent, index, parts);
      for (int32_t i = 0; i < count && status >= 0; i++)
        status = judge(&parts[i], error);
    }
  }

  thrum_scope_free(&memory);
  return status;
}
