/* The answer of `thrum static`: a table for people, one JSON object for programs.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "driver/model/locking.h"
#include "driver/spec/shared_options.h"
#include "driver/spec/static_solve.h"
#include "io/json.h"
#include "runtime/material/material_law.h"
#include "thrum/thrum.h"

static const char *const instabilities[] = {"none", "bifurcation", "limit point"};

const char *static_status_name(const static_answer *answer) {
  const thrum_equilibrium_report *report = &answer->report;
  if (answer->forces.inverted > 0)
    return "inverted";
  if (isfinite(answer->lower_energy))
    return "higher";
  if (report->least < 0)
    return "unstable";
  if (report->instability == THRUM_INSTABILITY_LIMIT)
    return "snapped";
  if (report->instability == THRUM_INSTABILITY_BIFURCATION)
    return "buckled";
  if (isfinite(answer->lost_at))
    return "lost";
  const bool wrong = answer->belief.judged &&
                     basis_estimate_is_large(&answer->belief.error, &answer->request->basis);
  return wrong ? "basis_wrong" : "done";
}

thrum_status static_stress_look(const thrum_model *model, const double *u, node_stress *stress,
                                thrum_error *error) {
  if (model->tets == NULL || thrum_law_has_yield(model))
    return THRUM_OK;
  node_stress_close(stress);
  THRUM_TRY(node_stress_open(model, stress, error));
  return node_stress_look(model, u, 0, stress, error);
}

vtu_stress static_stress_frame(const node_stress *stress) {
  return (vtu_stress){stress->largest, NULL, !thrum_stress_nodes_extrapolated(stress->nodes)};
}

bool static_was_watched(const static_answer *answer) {
  return !answer->request->full || !isnan(answer->least_start);
}

/* The softest stiffness of the body without load: that of the mesh where it is known. */
static double least_at_rest(const static_answer *answer) {
  const static_request *request = answer->request;
  return request->full && request->from == NULL && !isnan(answer->least_start)
             ? answer->least_start
             : answer->model->omega2[0];
}

/* Loads and motions as they were given, each kind under the name of its option. */
static void add_asked(cJSON *object, const static_request *request) {
  cJSON *loads = cJSON_AddArrayToObject(object, "load");
  for (int64_t n = 0; n < request->load_count; n++)
    json_add_string(loads, request->loads[n].text);

  // all kinds are there, so that a reader need not ask which
  cJSON *lists[STATIC_MOVE_KINDS];
  for (int kind = 0; kind < STATIC_MOVE_KINDS; kind++)
    lists[kind] = cJSON_AddArrayToObject(object, static_move_names[kind]);
  for (int64_t n = 0; n < request->move_count; n++)
    json_add_string(lists[request->moves[n].kind], request->moves[n].text);
}

static void add_displacements(cJSON *object, const static_answer *answer) {
  cJSON *list = cJSON_AddArrayToObject(object, "displacements");
  for (int64_t n = 0; n < answer->request->target_count; n++) {
    cJSON *item = json_add_row(list);
    json_string(item, "at", answer->request->at[n]);
    json_numbers(item, "mean_m", answer->displaced[n], 3);
  }
  json_number(object, "peak_displacement_m", answer->peak);
  json_number(object, "peak_vertex",
              answer->peak_vertex >= 0 ? (double)answer->peak_vertex + 1 : NAN);
}

static void add_files(cJSON *object, const static_request *request) {
  const char *const files[] = {request->output, request->field, request->frame, request->path,
                               request->reactions};
  cJSON *list = cJSON_AddArrayToObject(object, "files");
  for (int n = 0; n < 5; n++)
    if (files[n] != NULL)
      cJSON_AddItemToArray(list, cJSON_CreateString(files[n]));
}

void static_report_json(const static_answer *answer) {
  const static_request *request = answer->request;
  const thrum_equilibrium_report *report = &answer->report;
  cJSON *object = json_report("static", static_status_name(answer));

  // what was asked
  json_string(object, "model", request->model_path);
  json_number(object, "rank", (double)answer->model->rank);
  locking_json(object, answer->model);
  add_asked(object, request);
  cJSON_AddStringToObject(
      object, "law", thrum_law_name(law_of_run(request->law_given, request->law, answer->model)));
  json_number(object, "factor", report->factor);

  // the equilibrium
  json_numbers(object, "q", answer->q, answer->model->rank);
  add_displacements(object, answer);
  json_number(object, "energy_j", report->energy);
  json_number(object, "load_energy_j", report->load_energy);
  json_number(object, "lower_energy_j", answer->lower_energy);
  json_number(object, "residual", report->residual);

  // the least eigenvalues tell whether the equilibrium is stable
  cJSON_AddBoolToObject(object, "stable", !(report->least < 0));
  json_number(object, "least_eigenvalue", report->least);
  json_number(object, "frequency_hz", report->least >= 0 ? static_hertz(report->least) : NAN);
  json_number(object, "frequency_rest_hz", static_hertz(least_at_rest(answer)));
  json_number(object, "softest_eigenvalue", report->softest);
  json_number(object, "softest_factor", report->softest_factor);

  // how the path lost it, where it was watched
  json_string(object, "instability",
              static_was_watched(answer) ? instabilities[report->instability] : NULL);
  json_number(object, "critical_factor", report->critical);
  json_number(object, "critical_factor_from", answer->critical_from);
  json_number(object, "critical_factor_to", answer->critical_to);
  json_number(object, "critical_residual", answer->critical_share);
  json_number(object, "critical_factor_mesh", answer->critical_mesh);
  json_number(object, "critical_factor_linear", report->critical_linear);
  json_number(object, "lost_factor", answer->lost_at);
  if (request->full)
    cJSON_AddNullToObject(object, "mode");
  else
    json_numbers(object, "mode", answer->mode, answer->model->rank);

  // what holds the body there
  static_forces_json(&answer->forces, object);

  // and how much it bears
  cJSON *stress = json_section(object, "stress", answer->stress.nodes != NULL);
  if (stress != NULL)
    node_stress_json(&answer->stress, stress);

  // what of it is to be believed
  cJSON *monitor = json_section(object, "monitor", !isnan(answer->belief.stretch));
  if (monitor != NULL) {
    json_number(monitor, "least_stretch", answer->belief.stretch);
  }

  if (answer->belief.judged)
    basis_estimate_json(&answer->belief.error, object);
  else
    cJSON_AddNullToObject(object, "error_estimate");

  // the cost
  json_number(object, "jumps", report->jumps);
  json_number(object, "load_steps", report->load_steps);
  json_number(object, "cut_steps", report->cut_steps);
  json_number(object, "iterations", report->iterations);
  json_number(object, "factorisations", report->factorisations);
  if (request->full)
    json_number(object, "components", (double)answer->components);
  add_files(object, request);
  json_number(object, "seconds", answer->seconds);
  json_print(object);
}

/* The load at which the path lost its stability, and how well it is known. */
static void print_critical(const static_answer *answer) {
  const thrum_equilibrium_report *report = &answer->report;
  if (report->instability == THRUM_INSTABILITY_NONE) {
    printf("critical     none up to %g of the load; softest at %.6g of it (%.6g Hz)\n",
           report->factor, report->softest_factor, static_hertz(report->softest));
  } else {
    printf("critical     %.9g of the load: a %s%s\n", report->critical,
           instabilities[report->instability],
           report->jumps > 0 ? "; the body then fell to another equilibrium" : "");
  }
  if (isfinite(answer->critical_from))
    printf("found        between %.9g and %.9g; at the former the least stiffness is %.1e of "
           "that at the start\n",
           answer->critical_from, answer->critical_to, answer->critical_share);
  if (isfinite(answer->critical_mesh))
    printf("mesh         critical at about %.4g of the load, by its stiffness before\n",
           answer->critical_mesh);
  if (isfinite(answer->lost_at))
    printf("branch       followed to %.6g of the load; what is beyond may be another one\n",
           answer->lost_at);
}

static void print_stability(const static_answer *answer) {
  const thrum_equilibrium_report *report = &answer->report;
  if (!static_was_watched(answer)) {
    printf("stability    %s\n", report->least < 0 ? "unstable" : "stable");
    return;
  }

  // the softest vibration tells how far the body is from buckling
  if (report->least >= 0) {
    printf("stability    stable; softest vibration %.6g Hz, at rest %.6g Hz\n",
           static_hertz(report->least), static_hertz(least_at_rest(answer)));
  } else {
    printf("stability    unstable: the least eigenvalue of the tangent is %.6g /s^2\n",
           report->least);
  }

  // a critical load that was passed on the way
  print_critical(answer);
  if (isfinite(report->critical_linear))
    printf("estimate     %.6g of the load would be critical, linearly from rest\n",
           report->critical_linear);
}

void static_report_table(const static_answer *answer) {
  const static_request *request = answer->request;
  const thrum_equilibrium_report *report = &answer->report;

  // how the search went
  printf("load         %g of what is given, %d steps (%d cut), %d iterations, residual %.1e\n",
         report->factor, (int)report->load_steps, (int)report->cut_steps, (int)report->iterations,
         report->residual);
  if (request->full)
    printf("full order   %" PRId64 " components, %.3g s\n", answer->components, answer->seconds);

  // where the body came to rest
  if (isfinite(report->load_energy))
    printf("energy       %.6g J in the body, %.6g J of the load\n", report->energy,
           report->load_energy);
  else
    printf("energy       %.6g J in the body; loads that turn have none\n", report->energy);
  for (int64_t n = 0; n < request->target_count; n++) {
    const double *mean = answer->displaced[n];
    printf("displaced    %s: %.6g, %.6g, %.6g m\n", request->at[n], mean[0], mean[1], mean[2]);
  }
  if (answer->peak_vertex >= 0)
    printf("peak         %.6g m at vertex %" PRId64 "\n", answer->peak, answer->peak_vertex + 1);

  static_forces_table(&answer->forces);
  if (answer->stress.peak_node >= 0 && answer->stress.nodes != NULL) {
    node_stress_print(&answer->stress);
    puts("");
  }

  if (request->full && !isnan(answer->belief.stretch))
    printf("monitor      least stretch %.3f (warns below 0.577 with StVK)\n",
           answer->belief.stretch);
  if (!request->full && !isnan(answer->belief.stretch))
    printf("monitor      least stretch %.3f (warns below 0.577)\n", answer->belief.stretch);
  if (answer->belief.judged)
    basis_estimate_print(&answer->belief.error, NULL, "shape");

  // whether it stays there
  print_stability(answer);
  printf("status       %s\n", static_status_name(answer));
  const char *const files[] = {request->output, request->field, request->frame, request->path,
                               request->reactions};
  const char *before = "files        ";
  for (int n = 0; n < 5; n++)
    if (files[n] != NULL) {
      printf("%s%s", before, files[n]);
      before = ", ";
    }
  if (before[0] == ',')
    puts("");
}
