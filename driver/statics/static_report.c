/* The answer of `thrum static`: a table for people, one JSON object for programs.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_report.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdint.h>

#include "driver/model/locking.h"
#include "driver/spec/shared_options.h"
#include "driver/spec/static_solve.h"
#include "io/json.h"
#include "io/report.h"
#include "runtime/material/material_law.h"
#include "thrum/thrum.h"

static const char *const instabilities[] = {"none", "bifurcation", "limit point"};

const char *static_flag(const static_answer *answer) {
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
  return wrong ? "basis_wrong" : NULL;
}

static const char *static_status(const static_answer *answer) {
  const char *flag = static_flag(answer);
  return flag != NULL ? flag : "done";
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
  return (vtu_stress){stress->largest, NULL, stress->patches};
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
    const int64_t vertex = load_target_only(answer->model, &answer->request->targets[n]);
    json_number(item, "vertex", vertex >= 0 ? (double)vertex + 1 : NAN);
    if (vertex >= 0)
      json_numbers(item, "place_m", answer->model->vertices + 3 * vertex, 3);
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

static cJSON *make_report(const static_answer *answer) {
  const static_request *request = answer->request;
  const thrum_equilibrium_report *report = &answer->report;
  cJSON *object = json_report("static", static_status(answer));

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
  cJSON *stress = json_section(object, "stress", node_stress_is_open(&answer->stress));
  if (stress != NULL)
    node_stress_json(&answer->stress, stress);

  // what of it is to be believed
  cJSON *monitor = json_section(object, "monitor", !isnan(answer->belief.stretch));
  if (monitor != NULL) {
    json_number(monitor, "least_stretch", answer->belief.stretch);
  }

  if (answer->belief.judged)
    basis_estimate_json(&answer->belief.error, NAN, object);
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
  return object;
}

static const report_line before[] = {
    // how the search went
    REPORT_LINE("load", "{factor:g} of what is given, {load_steps} steps ({cut_steps} cut), "
                        "{iterations} iterations, "
                        "residual {residual:.1e}"),
    REPORT_LINE("full order", "{components} components, {seconds:.3g} s"),

    // where the body came to rest
    REPORT_LINE(
        "energy",
        "{energy_j:.6g} J in the body"
        "{load_energy_j=null?; loads that turn have none|, {load_energy_j:.6g} J of the load}"),
    REPORT_LINE("displaced", "{at}[ (vertex {vertex} at {place_m:g})]: {mean_m:.6g} m",
                .each = "displacements"),
    REPORT_LINE("peak", "{peak_displacement_m:.6g} m at vertex {peak_vertex}"),
    {0}};

static const report_line behind[] = {
    // whether it stays there; the softest vibration tells how far the body is from buckling
    REPORT_LINE("monitor",
                "least stretch {monitor.least_stretch:.3f} (warns below 0.577{full? with StVK})"),
    REPORT_LINE("stability", "{stable?stable|unstable}", .when = "!watched"),
    REPORT_LINE(
        "stability",
        "stable; softest vibration {frequency_hz:.6g} Hz, at rest {frequency_rest_hz:.6g} Hz",
        .when = "watched"),
    REPORT_LINE("stability",
                "unstable: the least eigenvalue of the tangent is {least_eigenvalue:.6g} /s^2",
                .when = "lost_watched"),

    // a critical load that was passed on the way, and how well it is known
    REPORT_LINE("critical",
                "none up to {factor:g} of the load; softest at {softest_factor:.6g} of it "
                "({softest_hz:.6g} "
                "Hz)",
                .when = "instability=none"),
    REPORT_LINE("critical",
                "{critical_factor:.9g} of the load: a {instability}"
                "{jumps?; the body then fell to another equilibrium}",
                .when = "!instability=none"),
    REPORT_LINE(
        "found",
        "between {critical_factor_from:.9g} and {critical_factor_to:.9g}; at the former the "
        "least stiffness is "
        "{critical_residual:.1e} of that at the start"),
    REPORT_LINE(
        "mesh",
        "critical at about {critical_factor_mesh:.4g} of the load, by its stiffness before"),
    REPORT_LINE("branch",
                "followed to {lost_factor:.6g} of the load; what is beyond may be another one"),
    REPORT_LINE("estimate",
                "{critical_factor_linear:.6g} of the load would be critical, linearly from rest"),
    REPORT_LINE("status", "{status}"),
    REPORT_LINE("files", "{files}", .when = "files"),
    {0}};

void static_report_print(const static_answer *answer, bool json) {
  cJSON *report = make_report(answer);
  if (json) {
    json_print(report);
    return;
  }

  // what the lines hang on beside the report
  const thrum_equilibrium_report *found = &answer->report;
  const bool watched = static_was_watched(answer);
  cJSON *more = cJSON_CreateObject();
  cJSON_AddBoolToObject(more, "full", answer->request->full);
  cJSON_AddBoolToObject(more, "watched", watched);
  cJSON_AddBoolToObject(more, "lost_watched", watched && found->least < 0);
  json_number(more, "softest_hz", static_hertz(found->softest));

  json_string(more, "judged", "shape");

  report_print(report, more, REPORT_LABEL, before);
  report_print(report, more, REPORT_LABEL, static_forces_lines);
  report_print(report, more, REPORT_LABEL, node_stress_lines);
  report_print(report, more, REPORT_LABEL, basis_estimate_lines);
  report_end(report, more, REPORT_LABEL, behind);
}
