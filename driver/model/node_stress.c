/* Stress at the nodes of a body for reports and frames, see node_stress.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/node_stress.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/json.h"
#include "platform/allocate.h"

thrum_status node_stress_open(const thrum_model *model, node_stress *stress, thrum_error *error) {
  node_stress made = {.peak = NAN, .peak_node = -1};
  size_t size = 0;
  THRUM_TRY(thrum_stress_nodes_size(model, &size, error));
  THRUM_TRY(thrum_reserve_aligned(&made.memory, size, "stresses", error));
  thrum_status status = thrum_stress_nodes_init(made.memory, size, model, &made.nodes, error);

  // one allocation for what a look fills
  const int64_t count = thrum_stress_nodes_count(made.nodes), vertices = model->vertex_count;
  THRUM_THEN(status, thrum_reserve(&made.work, 7 * count + 4 * vertices, sizeof *made.work,
                                   "stresses", error));
  if (status < 0) {
    node_stress_close(&made);
    return status;
  }
  made.cauchy = made.work;
  made.von_mises = made.cauchy + 6 * count;
  made.largest = made.von_mises + count;
  made.u = made.largest + vertices;
  *stress = made;
  return THRUM_OK;
}

thrum_status node_stress_look(const thrum_model *model, const double *u, double time,
                              node_stress *stress, thrum_error *error) {
  THRUM_TRY(thrum_stress_nodes_read(stress->nodes, u, stress->cauchy, stress->von_mises, error));

  // vertices that no tetrahedron has feel nothing
  memset(stress->largest, 0, (size_t)model->vertex_count * sizeof *stress->largest);
  for (int64_t n = 0; n < thrum_stress_nodes_count(stress->nodes); n++) {
    const double here = stress->von_mises[n];
    const int64_t v = thrum_stress_nodes_vertex(stress->nodes, n);
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

static const char *kind_of(const node_stress *stress) {
  return thrum_stress_nodes_extrapolated(stress->nodes) ? "nodes" : "patch average";
}

void node_stress_json(const node_stress *stress, cJSON *object) {
  const bool known = stress->peak_node >= 0;
  json_string(object, "kind", kind_of(stress));
  json_number(object, "peak_von_mises_pa", stress->peak);
  json_number(object, "peak_vertex",
              known ? (double)thrum_stress_nodes_vertex(stress->nodes, stress->peak_node) + 1
                    : NAN);
  if (known)
    json_numbers(object, "peak_place_m", stress->peak_place, 3);
  else
    cJSON_AddNullToObject(object, "peak_place_m");
  json_number(object, "peak_region",
              known ? (double)thrum_stress_nodes_region(stress->nodes, stress->peak_node) + 1
                    : NAN);
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
  free(stress->memory);
  free(stress->work);
  *stress = (node_stress){0};
}
