/* Bodies with actuators of all kinds, for tests. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_ACTING_BODY_H
#define THRUM_TESTS_SUPPORT_ACTING_BODY_H

#include "tests/support/precompute_support.h"

#include "mesh/actuator.h"
#include "mesh/mesh_groups.h"
#include "thrum/thrum.h"

/* A block of 3 x 3 x 3 cells without the middle one, or without that and the one above it. The
 * walls of the hole are the group `inside`. */
static inline body hollow(bool open, bool quadratic) {
  body b = body_make("beam:3x3x3@0.3x0.3x0.3", NULL);
  thrum_mesh *mesh = &b.mesh;
  thrum_error error = {0};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int64_t c = 0; c < 3 * mesh->vertex_count; c++) {
    low[c % 3] = fmin(low[c % 3], mesh->vertices[c]);
    high[c % 3] = fmax(high[c % 3], mesh->vertices[c]);
  }

  // tets whose middle lies in the hole go
  int64_t kept = 0;
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    bool within = true;
    for (int axis = 0; axis < 3; axis++) {
      double at = 0;
      for (int a = 0; a < 4; a++)
        at += mesh->vertices[3 * (int64_t)mesh->tets[4 * t + a] + axis] / 4;
      const double share = (at - low[axis]) / (high[axis] - low[axis]);
      within = within && share > 1.0 / 3 && (share < 2.0 / 3 || (open && axis == 2));
    }
    if (within)
      continue;
    memmove(mesh->tets + 4 * kept, mesh->tets + 4 * t, 4 * sizeof *mesh->tets);
    mesh->tet_region[kept++] = mesh->tet_region[t];
  }
  mesh->tet_count = kept;

  // what is at the hole
  int32_t inside[64];
  int64_t count = 0;
  for (int64_t v = 0; v < mesh->vertex_count; v++) {
    bool at_hole = true;
    for (int axis = 0; axis < 3; axis++) {
      const double share = (mesh->vertices[3 * v + axis] - low[axis]) / (high[axis] - low[axis]);
      at_hole = at_hole && share > 0.3 && (share < 0.7 || (open && axis == 2));
    }
    if (at_hole)
      inside[count++] = (int32_t)v;
  }
  assert_int_equal(thrum_mesh_add_group(mesh, "inside", inside, count, &error), THRUM_OK);

  // uneven places, so that nothing is right by symmetry
  for (int64_t c = 0; c < 3 * mesh->vertex_count; c++)
    mesh->vertices[c] += 0.004 * random_number();
  if (quadratic) {
    const int64_t corners = mesh->vertex_count;
    assert_int_equal(thrum_midsides_add(mesh, &error), THRUM_OK);
    for (int64_t c = 3 * corners; c < 3 * mesh->vertex_count; c++)
      mesh->vertices[c] += 0.001 * random_number();
  }
  for (int64_t m = 0; m < mesh->region_count; m++)
    mesh->materials[m] = (thrum_material){1e5, 0.3, 1000};
  free(b.fixed);
  b.fixed = need((size_t)mesh->vertex_count, 1);
  assert_int_equal(thrum_mesh_fix(mesh, "x<0.01", b.fixed, &count, &error) < 0, 0);
  return b;
}

enum { MOST = 8 };

/* A model of a body with these actuators. */
typedef struct acting_body {
  body body;
  thrum_actuator actuators[MOST];
  int64_t count;
  thrum_precomputed found;
} acting_body;

static inline acting_body act_on(body b, const char *const *texts, int64_t modes, int64_t rank) {
  acting_body made = {.body = b};
  thrum_error error = {0};
  for (; texts[made.count]; made.count++)
    if (thrum_actuator_read(&b.mesh, b.fixed, texts[made.count], &made.actuators[made.count],
                            &error) < 0)
      fail_msg("%s", error.message);
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank + 2 * made.count;
  options.actuators = made.actuators;
  options.actuator_count = made.count;
  if (thrum_precompute(&b.mesh, b.fixed, &options, &made.found, &error) < 0)
    fail_msg("%s", error.message);
  return made;
}

static inline void acting_free(acting_body *made) {
  for (int64_t k = 0; k < made->count; k++)
    thrum_actuator_free(&made->actuators[k]);
  thrum_precomputed_free(&made->found);
  body_free(&made->body);
}

static const char *const all_kinds[] = {"air=chamber:inside,cap",
                                        "lid=gas:inside,cap,outside=2e4",
                                        "biceps=muscle:all,1,2,-1",
                                        "heat=swell:1",
                                        "bend=eigenstrain:all,1,0,-1,0.5,0.2,0.1",
                                        "wire=tendon:near:0,0,0.15,near:0.1,0.1,0.15,"
                                        "near:0.3,0,0.15,at:0.5,0.1,0.4",
                                        NULL};
static const double all_levels[] = {3e3, -4e3, 0.02, 0.03, -0.01, 40};

#endif
