/* The report of a run: a table for people, one JSON object for programs and for run.json.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/simulate_report.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "driver/model/locking.h"
#include "driver/spec/shared_options.h"
#include "io/json.h"
#include "io/report.h"
#include "platform/clock.h"

static void add_split(cJSON *object, const thrum_state_def *def) {
  if (def->split_rule == THRUM_SPLIT_COUNT)
    json_number(object, "split", def->explicit_count);
  else
    json_string(object, "split", thrum_split_rule_name(def->split_rule));

  // the other options of imexv
  json_number(object, "safety", def->split_safety);
  cJSON_AddStringToObject(object, "split_form", thrum_split_form_name(def->split_form));
  cJSON_AddBoolToObject(object, "adaptive", def->adaptive);
  cJSON_AddBoolToObject(object, "fallback", def->fallback);
  cJSON_AddBoolToObject(object, "frequency_matching", def->frequency_matched);
}

/* The texts of the loads and starts, in the words of the user. */
static void add_specs(cJSON *object, const simulate_request *request) {
  cJSON *loads = cJSON_AddArrayToObject(object, "load");
  for (int64_t n = 0; n < request->load_count; n++)
    json_add_string(loads, request->loads[n].text);
  cJSON *actuates = cJSON_AddArrayToObject(object, "actuate");
  for (int64_t n = 0; n < request->actuate_count; n++)
    json_add_string(actuates, request->actuates[n].text);
  cJSON *starts = cJSON_AddArrayToObject(object, "start");
  for (int64_t n = 0; n < request->start_count; n++)
    json_add_string(starts, request->starts[n].text);
  cJSON *probes = cJSON_AddArrayToObject(object, "probe");
  for (int64_t n = 0; n < request->probe_count; n++)
    json_add_string(probes, request->probes[n].name);
  cJSON *motions = cJSON_AddArrayToObject(object, "base_motion");
  for (int64_t n = 0; n < request->base_motion_count; n++)
    json_add_string(motions, request->base_motions[n].text);
}

/* What the model of a mesh is made by. */
static void add_mesh_options(cJSON *object, const mesh_model_def *def) {
  const thrum_mesh_read_options *reading = &def->reading;
  json_strings(object, "fix", def->fixes, def->fix_count);
  json_number(object, "young", def->material.young);
  json_number(object, "poisson", def->material.poisson);
  json_number(object, "density", def->material.density);
  json_strings(object, "material", def->materials, def->material_count);

  // how its file is read
  json_number(object, "scale", reading->scale);
  json_string(object, "unit", reading->unit);
  json_string(object, "regions", reading->regions);
  json_number(object, "order", reading->order > 0 ? (double)reading->order : NAN);
  json_string(object, "element", element_names[reading->element]);
}

cJSON *simulate_options_json(const simulate_request *request) {
  const thrum_state_def *def = &request->def;
  cJSON *object = cJSON_CreateObject();

  // which coordinates, of what
  json_number(object, "rank", request->rank > 0 ? (double)request->rank : NAN);
  json_number(object, "condense",
              request->condense > 0 && request->condense != request->rank
                  ? (double)request->condense
                  : NAN);
  if (request->full)
    add_mesh_options(object, &request->mesh_def);

  // the integrator and its parameters
  cJSON_AddStringToObject(object, "integrator", thrum_integrator_name(def->integrator));
  json_number(object, "dt", def->dt);
  json_number(object, "time", request->time);
  json_numbers(object, "damping", (const double[]){def->damping_alpha, def->damping_beta}, 2);
  json_numbers(object, "damping_ratios", request->modal.ratios, request->modal.ratio_count);
  cJSON_AddStringToObject(object, "damping_form", thrum_damping_form_name(def->damping_form));
  add_split(object, def);
  json_numbers(object, "newmark", (const double[]){def->newmark_beta, def->newmark_gamma}, 2);
  cJSON_AddStringToObject(object, "solver", thrum_implicit_solver_name(def->solver));
  json_number(object, "tolerance", def->tolerance);
  json_number(object, "iterations", def->iterations_max);

  // loads, starts and base motions
  add_specs(object, request);

  // what is written, and how often
  json_numbers(object, "spin", request->spin, 3);
  json_number(object, "record_every", (double)request->record_every);
  cJSON_AddBoolToObject(object, "full", request->full);
  json_string(object, "linear_solver", full_solver_names[request->solver]);
  cJSON_AddStringToObject(object, "quadrature", full_quadrature_names[request->quadrature]);
  if (request->law_given)
    cJSON_AddStringToObject(object, "law", law_names[request->law]);
  json_number(object, "yield", def->plastic.yield);
  json_number(object, "creep", def->plastic.creep);
  json_number(object, "largest_plastic_strain", def->plastic.largest);
  cJSON_AddStringToObject(object, "frames_in", request->ground ? "ground" : "base");

  // frames in the form that the option takes
  if (request->frames_every > 0) {
    char text[32];
    snprintf(text, sizeof text, "every-%" PRId64, request->frames_every);
    cJSON_AddStringToObject(object, "frames", text);
  } else if (request->frames_rate > 0) {
    json_number(object, "frames", request->frames_rate);
  } else {
    cJSON_AddNullToObject(object, "frames");
  }

  cJSON_AddBoolToObject(object, "stress", request->stress);
  cJSON_AddBoolToObject(object, "monitor", request->monitor);
  json_number(object, "against_mesh", request->against_mesh);
  json_number(object, "accept_error", request->basis.accepted);
  cJSON_AddStringToObject(object, "judge", basis_judging_names[request->basis.judging]);
  return object;
}

/* The names of the files, relative to the run's folder; one that was not wanted is none. */
static void add_files(cJSON *object, const driver_body *body) {
  const simulate_figures *figures = &body->figures;
  const run_output *output = &body->output;
  const char *const names[] = {RUN_JSON,
                               "energy.csv",
                               "q.npy",
                               output->moved ? RUN_PLACEMENTS : NULL,
                               output->end ? "end.npy" : NULL,
                               output->plot,
                               body->probes.count > 0 ? RUN_PROBES_CSV : NULL,
                               body->probes.plot,
                               figures->against.asked ? AGAINST_MESH_CSV : NULL,
                               figures->against.plot,
                               output->frames > 0 ? "frames.pvd" : NULL,
                               output->frames > 0 ? RUN_FRAMES "/" : NULL};
  cJSON *files = cJSON_AddArrayToObject(object, "files");
  for (size_t n = 0; n < sizeof names / sizeof names[0]; n++)
    if (names[n] != NULL)
      json_add_string(files, names[n]);
}

/* Fallback levels of the fallback chain (design 8), and what the stability monitor of imexv found
 * and changed (design 4). */
static void add_robustness(cJSON *object, const simulate_figures *figures) {
  const thrum_state_report *report = &figures->report;

  // how often each level of the fallback chain was needed
  cJSON *fallback_levels = cJSON_AddObjectToObject(object, "fallback_levels");
  json_number(fallback_levels, "full_newton", (double)report->newton_steps);
  json_number(fallback_levels, "energy_steps", (double)report->energy_steps);
  json_number(fallback_levels, "substeps", (double)report->substep_steps);
  json_number(fallback_levels, "failures",
              figures->status == THRUM_NOT_CONVERGED || figures->status == THRUM_NOT_FINITE);

  // the others have no monitor
  const thrum_state_def *def = &figures->request->def;
  const bool monitored =
      def->integrator == THRUM_INTEGRATOR_IMEXV || def->integrator == THRUM_INTEGRATOR_FOX_GOODWIN;
  cJSON *stability = json_section(object, "stability", monitored && def->adaptive);
  if (stability == NULL)
    return;

  // the stability number h sqrt(rho), and what was adapted to it
  cJSON_AddStringToObject(stability, "scheme", thrum_scheme_name(report->scheme));
  json_number(stability, "h_sqrt_rho_last", report->stability_number_last);
  json_number(stability, "h_sqrt_rho_peak", report->stability_number_peak);
  json_number(stability, "split_changes", (double)report->split_changes);
  json_number(stability, "scheme_switches", (double)report->scheme_switches);
  json_number(stability, "switched_steps", (double)report->switched_steps);
  json_number(stability, "first_switch",
              report->first_switch < 0 ? NAN : (double)report->first_switch);

  // one map all along, as --adaptive off would have stepped it
  cJSON_AddBoolToObject(stability, "untouched",
                        report->split_changes + report->scheme_switches + report->corrections +
                                report->energy_steps + report->substep_steps ==
                            0);

  // the energy balance and its corrections
  json_number(stability, "corrections", (double)report->corrections);
  json_number(stability, "corrected_j", report->corrected);
  json_number(stability, "balance_last", report->balance_last);
  json_number(stability, "balance_peak", report->balance_peak);
}

/* How the energy integrator solved, and what its unverified corrections did (design 7). */
static void add_energy_solves(cJSON *object, const simulate_figures *figures) {
  const thrum_state_report *report = &figures->report;
  const bool taken =
      !figures->request->full &&
      (figures->request->def.integrator == THRUM_INTEGRATOR_ENERGY || report->switched_steps > 0);
  cJSON *solves = json_section(object, "energy_solves", taken);
  if (solves == NULL)
    return;
  json_number(solves, "single_steps", (double)report->single_steps);
  json_number(solves, "spurious_j", report->spurious);
  json_number(solves, "tightened", (double)report->tightened);
}

void simulate_report_condensed(cJSON *object, const simulate_figures *figures) {
  cJSON *condensed = json_section(object, "condensed", figures->masters > 0);
  if (condensed == NULL)
    return;
  json_number(condensed, "masters", (double)figures->masters);
  json_number(condensed, "inertia_share", figures->inertia_share);
  json_number(condensed, "energy_defect", figures->energy_defect);
  json_number(condensed, "vibration_share", figures->vibration_share);
  json_number(condensed, "impact_share", figures->impact_share);
}

static double per_step(const simulate_figures *figures, double value) {
  return figures->report.steps > 0 ? value / (double)figures->report.steps : NAN;
}

/* The solver of the full order; null for a run of a reduced model. */
static void add_full(cJSON *object, const simulate_figures *figures) {
  const simulate_request *request = figures->request;
  cJSON *full = json_section(object, "full", request->full);
  if (full == NULL)
    return;
  json_number(full, "components", (double)figures->full.free_count);
  json_string(full, "linear_solver", full_solver_names[request->solver]);
  json_number(full, "solver_iterations", (double)figures->full.solver_iterations);
  json_number(full, "dt_stable", figures->full.dt_stable);
}

/* The energy that came into the body and left it, and the part of its energy that this does not
 * explain. */
static void add_work(cJSON *object, const simulate_figures *figures) {
  cJSON *work = cJSON_AddObjectToObject(object, "work");
  json_number(work, "load_j", figures->work_load);
  json_number(work, "base_j", figures->work_base);
  if (actuate_specs_act(figures->model, figures->request->actuate_count))
    json_number(work, "actuators_j", figures->work_actuators);
  json_number(work, "dissipated_j", figures->dissipated);
  json_number(work, "plastic_j", figures->plastic_work);
  json_number(work, "balance_j", simulate_figures_balance(figures));
  if (figures->blow.mesh > 0) {
    json_number(work, "blow_basis_j", figures->blow.basis);
    json_number(work, "blow_mesh_j", figures->blow.mesh);
  }
}

static void add_energies(cJSON *object, const simulate_figures *figures) {
  json_number(object, "energy_first_j", figures->first.total);
  json_number(object, "energy_last_j", figures->last.total);
  json_number(object, "energy_min_j", figures->energy_min);
  json_number(object, "energy_max_j", figures->energy_max);
  json_number(object, "energy_high_last_j", figures->last.high);
  if (simulate_spins(figures->request))
    json_numbers(object, "spin_last_deg_s", figures->spin, 3);
  json_number(object, "drift", figures->drift);
  json_number(object, "plastic_strain", figures->plastic_strain);
  json_number(object, "point_stiffness",
              figures->point_stiffness > 0 ? figures->point_stiffness : NAN);
  json_number(object, "peak_displacement_m", figures->peak);
  json_number(object, "peak_vertex",
              figures->peak_vertex >= 0 ? (double)figures->peak_vertex + 1 : NAN);
}

static void add_seconds(cJSON *object, const simulate_figures *figures) {
  cJSON *seconds = cJSON_AddObjectToObject(object, "seconds");
  json_number(seconds, "read", figures->seconds_read);
  json_number(seconds, "step", figures->seconds_step);
  json_number(seconds, "output", figures->seconds_output);
  json_number(seconds, "plot", figures->seconds_plot);
  json_number(seconds, "total", figures->seconds_total);
  json_number(object, "peak_mb", clock_peak_mb());
}

cJSON *simulate_report_begin(const char *status, const thrum_error *stop) {
  cJSON *object = json_report("simulate", status);
  if (stop->message[0] != 0)
    json_string(object, "message", stop->message);
  return object;
}

cJSON *simulate_report_json(const driver_body *body) {
  const simulate_figures *figures = &body->figures;
  const run_output *output = &body->output;
  const thrum_state_report *report = &figures->report;
  const simulate_request *request = figures->request;
  char stepped_by[128];
  cJSON *object =
      simulate_report_begin(run_outcome_word(simulate_outcome(figures)), &figures->stop);
  json_string(object, "model", request->model_path);
  if (figures->model_file != NULL)
    json_string(object, "model_file", figures->model_file);
  model_hash_json(object, &figures->model_hash);
  cJSON_AddStringToObject(
      object, "law", thrum_law_name(law_of_run(request->law_given, request->law, figures->model)));
  json_string(object, "run", request->run_path);
  add_files(object, body);

  // what stepped it, and at what cost
  cJSON_AddStringToObject(object, "integrator", thrum_integrator_name(request->def.integrator));
  simulate_figures_stepped_by(figures, stepped_by);
  cJSON_AddStringToObject(object, "stepped_by", stepped_by);
  json_number(object, "dt", request->def.dt);
  json_number(object, "rank", (double)figures->model->rank);
  locking_json(object, figures->model);
  simulate_report_condensed(object, figures);
  json_number(object, "explicit_modes", report->explicit_modes);
  json_number(object, "implicit_modes", report->implicit_modes);
  json_number(object, "steps", (double)report->steps);
  json_number(object, "simulated_s", report->time);
  json_number(object, "us_per_step", per_step(figures, 1e6 * figures->seconds_step));
  json_number(object, "mean_iterations", per_step(figures, (double)report->iterations));
  json_number(object, "factorisations", (double)report->factorisations);
  json_number(object, "fallback_steps", (double)figures->fallback_steps);
  json_number(object, "grown_steps", (double)figures->report.grown_steps);

  // whether the run can be trusted
  add_robustness(object, figures);
  add_energy_solves(object, figures);

  // what was written and found
  json_number(object, "rows", (double)output->rows);
  json_number(object, "frames", (double)output->frames);
  add_full(object, figures);
  add_energies(object, figures);
  add_work(object, figures);
  run_probes_json(&body->probes, object);
  simulate_measures_json(&body->measures, report->time, object);
  against_mesh_json(&figures->against, object);
  cJSON_AddItemToObject(object, "options", simulate_options_json(request));
  add_seconds(object, figures);
  return object;
}

/* Why a run has no drift. */
static const char *no_drift(const simulate_figures *figures) {
  if (figures->report.steps < figures->request->steps)
    return "the run ended early";
  if (figures->request->def.damping_alpha > 0 || figures->request->def.damping_beta > 0)
    return "only of motion without damping";
  if (figures->plastic_work > 0)
    return "only of motion without plastic flow";
  if (figures->windows.last_end == 0)
    return "needs 100 rows after the loads have ended";
  return "no energy to compare with";
}

#define FLOW "{work.plastic_j:.6g} J taken by the flow, plastic strain up to {plastic_strain:.3g}"

static const report_line before[] = {
    REPORT_LINE("{options.full?full order|integrator}",
                "{stepped_by}, dt {dt:g} s, {explicit_modes} explicit and {implicit_modes} "
                "implicit {options.full?components|modes}"),
    REPORT_LINE("steps",
                "{steps} ({simulated_s:g} s)[, {us_per_step:.2f} us and {mean_iterations:.2f} "
                "iterations a step]"),
    REPORT_LINE("material", "{law}, flows beyond the yields of regions: " FLOW,
                .when = "flows=by region"),
    REPORT_LINE("material", "{law}, flows beyond a strain of {options.yield:g}: " FLOW,
                .when = "flows=by yield"),
    REPORT_LINE("material", "{law}, which does not flow", .when = "flows=no"),

    // how far a condensed run can be believed; at rest there is no energy to be wrong
    REPORT_LINE("condensed", "{condensed.masters} of {rank} coordinates stepped; "
                             "{condensed.inertia_share:.2g%} of the kinetic "
                             "energy {integrator=manifold?in what follows|left out}"
                             "[, {condensed.energy_defect:.2g%} of the strain energy wrong], "
                             "{condensed.vibration_share:.2g%} of "
                             "the motion is vibration left out{condensed.impact_share?, "
                             "{condensed.impact_share:.2g%} of it is off after impacts}"),

    // the headline names the integrator asked for, so a run that another one stepped says so
    REPORT_LINE("switched",
                "{stability.switched_steps} of these steps were the energy integrator's, to which "
                "{integrator} switched "
                "when its energy drifted",
                .when = "stability.switched_steps"),
    REPORT_LINE(
        "spurious",
        "{energy_solves.spurious_j:.3g} J between slow and fast modes by corrections that were not "
        "verified, "
        "estimated; the tolerance was tightened {energy_solves.tightened} "
        "time{energy_solves.tightened#|s}",
        .when = "energy_solves.tightened"),

    // where the energy went; damping of the unreduced mesh is not counted
    REPORT_LINE("energy",
                "first {energy_first_j:.6g}, last {energy_last_j:.6g}, least {energy_min_j:.6g}, "
                "most {energy_max_j:.6g} J"),
    REPORT_LINE("work",
                "{work.load_j:.6g} of the loads, {work.base_j:.6g} of the base, "
                "[{work.actuators_j:.6g} of the actuators, ]"
                "{work.dissipated_j=null?dissipation by damping not counted with "
                "--full|{work.dissipated_j:.6g} J dissipated}",
                .when = "driven"),
    REPORT_LINE("blow",
                "the basis takes about {work.blow_basis_j:.3g} J of {work.blow_mesh_j:.3g} J "
                "that the load gives the mesh (linear): the rest vibrates fast",
                .when = "work.blow_mesh_j"),
    REPORT_LINE("spin", "{spin_last_deg_s:.6g} degrees/s about the axes of the world at the end"),
    REPORT_LINE(
        "drift",
        "{no_drift?- ({no_drift})|{drift:.2e} of the mean energy, first to last tenth of the "
        "free motion}"),

    // and where the body went
    REPORT_LINE("peak", "{peak_displacement_m:.6g} m at vertex {peak_vertex}"),
    {0}};

static const report_line monitor[] = {
    // a run that was lost may have stretches of a hundred digits
    REPORT_LINE("monitor",
                "least stretch {far?{monitor.least_stretch:.3g}|{monitor.least_stretch:.3f}} at "
                "{monitor.time_s:g} s (warns below {warns_below:.3g})"),
    {0}};

static const report_line behind[] = {
    REPORT_LINE("status", "{status}"), REPORT_LINE("files", "{run}/{files}"), {0}};

/* How the material flows, where a run says so: all but those of the usual law without a yield. */
static const char *flows(const simulate_figures *figures) {
  const simulate_request *request = figures->request;
  const bool yields = thrum_law_has_yield(figures->model);
  if (!request->full && isinf(request->def.plastic.yield) && !yields)
    return NULL;
  if (yields && law_of_run(request->law_given, request->law, figures->model) == THRUM_LAW_BY_REGION)
    return "by region";
  return isinf(request->def.plastic.yield) ? "no" : "by yield";
}

void simulate_report_table(const driver_body *body, const cJSON *report) {
  const simulate_figures *figures = &body->figures;
  const simulate_request *request = figures->request;
  const bool driven =
      request->load_count > 0 || request->base_motion_count > 0 || request->actuate_count > 0;
  cJSON *more = cJSON_CreateObject();
  json_string(more, "flows", flows(figures));
  cJSON_AddBoolToObject(more, "driven", driven);
  json_string(more, "no_drift", isfinite(figures->drift) ? NULL : no_drift(figures));

  cJSON_AddBoolToObject(more, "far", fabs(body->measures.record.stretch_least) >= 1000);
  json_number(more, "warns_below", body->measures.warns_below);

  const report_line *const lists[] = {before,
                                      run_probes_lines,
                                      node_stress_lines,
                                      basis_estimate_lines,
                                      monitor,
                                      against_mesh_lines,
                                      behind};
  for (size_t n = 0; n < sizeof lists / sizeof *lists; n++)
    report_print(report, more, REPORT_LABEL, lists[n]);
  cJSON_Delete(more);
}
