/* Stress at the nodes of a body for reports and frames, see node_stress.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/node_stress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/json.h"
#include "platform/allocate.h"

static int64_t vertex_of(const node_stress *stress, int64_t n) {
  return stress->nodes ? thrum_stress_nodes_vertex(stress->nodes, n) : stress->solids.vertex[n];
}

static int64_t region_of(const node_stress *stress, int64_t n) {
  return stress->nodes ? thrum_stress_nodes_region(stress->nodes, n) : stress->solids.region[n];
}

/* What reads the stress: the library of tetrahedra, the body of solids. */
static thrum_status open_reader(const thrum_model *model, node_stress *stress, thrum_error *error) {
  size_t size = 0;
  if (model->solid_count > 0) {
    THRUM_TRY(thrum_model_fem_elements(model, &stress->body, error));
    THRUM_TRY(thrum_solid_stresses_make(&stress->body.fem, &stress->solids, error));
    stress->count = stress->solids.count;
    return THRUM_OK;
  }
  THRUM_TRY(thrum_stress_nodes_size(model, &size, error));
  THRUM_TRY(thrum_reserve_aligned(&stress->memory, size, "stresses", error));
  THRUM_TRY(thrum_stress_nodes_init(stress->memory, size, model, &stress->nodes, error));
  stress->count = thrum_stress_nodes_count(stress->nodes);
  stress->patches = !thrum_stress_nodes_extrapolated(stress->nodes);
  return THRUM_OK;
}

thrum_status node_stress_open(const thrum_model *model, node_stress *stress, thrum_error *error) {
  *stress = (node_stress){.peak = NAN, .peak_node = -1};
  thrum_status status = open_reader(model, stress, error);

  // one allocation for what a look fills
  const int64_t count = stress->count, vertices = model->vertex_count;
  THRUM_THEN(status, thrum_reserve(&stress->work, 7 * count + 4 * vertices, sizeof *stress->work,
                                   "stresses", error));
  if (status < 0) {
    node_stress_close(stress);
    return status;
  }
  stress->cauchy = stress->work;
  stress->von_mises = stress->cauchy + 6 * count;
  stress->largest = stress->von_mises + count;
  stress->u = stress->largest + vertices;
  return THRUM_OK;
}

static thrum_status read(const double *u, node_stress *stress, thrum_error *error) {
  if (stress->nodes)
    return thrum_stress_nodes_read(stress->nodes, u, stress->cauchy, stress->von_mises, error);
  stress->solids.fem = &stress->body.fem; // which is where the stress is
  thrum_solid_stresses_read(&stress->solids, u, stress->cauchy);
  for (int64_t n = 0; n < stress->count; n++)
    stress->von_mises[n] = thrum_von_mises(stress->cauchy + 6 * n);
  return THRUM_OK;
}

thrum_status node_stress_look(const thrum_model *model, const double *u, double time,
                              node_stress *stress, thrum_error *error) {
  THRUM_TRY(read(u, stress, error));

  // vertices that no element has feel nothing
  memset(stress->largest, 0, (size_t)model->vertex_count * sizeof *stress->largest);
  for (int64_t n = 0; n < stress->count; n++) {
    const double here = stress->von_mises[n];
    const int64_t v = vertex_of(stress, n);
    stress->largest[v] = here > stress->largest[v] || isnan(here) ? here : stress->largest[v];

    // a comparison that is true of the first stress, and never of one that is no number
    if (here > stress->peak || (stress->peak_node < 0 && here >= 0)) {
      stress->peak = here;
      stress->peak_node = n;
      stress->peak_time = time;
      memcpy(stress->peak_place, model->vertices + 3 * v, sizeof stress->peak_place);
    }
  }
  return THRUM_OK;
}

bool node_stress_is_open(const node_stress *stress) {
  return stress->work != NULL;
}

static const char *kind_of(const node_stress *stress) {
  return stress->patches ? "patch average" : "nodes";
}

void node_stress_json(const node_stress *stress, cJSON *object) {
  const bool known = stress->peak_node >= 0;
  json_string(object, "kind", kind_of(stress));
  json_number(object, "peak_von_mises_pa", stress->peak);
  json_number(object, "peak_vertex",
              known ? (double)vertex_of(stress, stress->peak_node) + 1 : NAN);
  if (known)
    json_numbers(object, "peak_place_m", stress->peak_place, 3);
  else
    cJSON_AddNullToObject(object, "peak_place_m");
  json_number(object, "peak_region",
              known ? (double)region_of(stress, stress->peak_node) + 1 : NAN);
}

const report_line node_stress_lines[] = {
    REPORT_LINE("stress",
                "von Mises up to {stress.peak_von_mises_pa:.6g} Pa{stress.kind=patch average? "
                "(average of a patch)} at "
                "vertex {stress.peak_vertex} ({stress.peak_place_m:.4g} m at rest), region "
                "{stress.peak_region}"
                "[, at {stress.peak_time_s:g} s]"),
    REPORT_LINE("  at centres", "up to {stress.centre_peak_von_mises_pa:.6g} Pa, in tetrahedron "
                                "{stress.centre_peak_tet} at "
                                "{stress.centre_peak_time_s:g} s"),
    {0}};

void node_stress_close(node_stress *stress) {
  thrum_solid_stresses_free(&stress->solids);
  thrum_model_fem_free(&stress->body);
  free(stress->memory);
  free(stress->work);
  *stress = (node_stress){0};
}
