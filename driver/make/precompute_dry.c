/* `thrum precompute --dry-run`: what the model would take, without making it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>

#include "driver/make/precompute_dry.h"
#include "driver/make/precompute_progress.h"
#include "driver/make/precompute_train.h"
#include "io/json.h"
#include "mesh/solids.h"
#include "precompute/build_info.h"
#include "precompute/estimate.h"
#include "precompute/options_check.h"

static double total_of(const thrum_estimate *estimate) {
  double total = 0;
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    total += estimate->seconds[stage];
  return total;
}

static void print_json(const precompute_outcome *outcome, const thrum_estimate *estimate) {
  const thrum_mesh *mesh = outcome->mesh;
  const bool cubature = outcome->request->options.cubature;
  cJSON *object = cJSON_CreateObject();

  // the verdict and the size of the problem
  cJSON_AddStringToObject(object, "status", estimate->fits ? "fits" : "does not fit");
  json_number(object, "vertices", (double)mesh->vertex_count);
  json_number(object, "tets", (double)mesh->tet_count);
  element_order_json(object, &outcome->order, mesh);
  json_number(object, "fixed", (double)outcome->fixed_count);
  json_number(object, "free_dofs", (double)estimate->free_dofs);
  json_number(object, "factor_nonzeros", (double)estimate->factor_nonzeros);
  json_number(object, "factor_gflop", 1e-9 * estimate->factor_flops);

  json_number(object, "rank", (double)estimate->rank);
  json_number(object, "file_mb", estimate->file / 1048576);

  // the estimates that the verdict rests on
  json_number(object, "memory_mb", estimate->memory / 1048576);
  json_number(object, "available_mb", estimate->available / 1048576);

  // rough times, stage by stage
  cJSON *seconds = cJSON_AddObjectToObject(object, "seconds");
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    json_number(seconds, precompute_stage_label_of((thrum_stage)stage, cubature).name,
                estimate->seconds[stage]);
  json_number(seconds, "total", total_of(estimate));

  // the times hold for this kernel of the linear algebra
  cJSON_AddStringToObject(object, "blas_core", thrum_build_blas_core());
  json_print(object);
}

static void print_table(const precompute_outcome *outcome, const thrum_estimate *estimate) {
  const thrum_mesh *mesh = outcome->mesh;
  const bool cubature = outcome->request->options.cubature;

  // the size of the problem, and the memory that it takes
  printf("%-18s%" PRId64 " vertices (%" PRId64 " held), ", "mesh", mesh->vertex_count,
         outcome->fixed_count);
  if (mesh->solid_count > 0)
    printf("%s\n", thrum_solid_count_words(mesh->solid_form, mesh->solid_count).text);
  else
    printf("%" PRId64 " tetrahedra%s\n", mesh->tet_count,
           mesh->midsides != NULL ? " of ten nodes" : "");
  printf("%-18s%" PRId64 " free components, %.4g nonzeros, %.4g Gflop\n", "factor",
         estimate->free_dofs, (double)estimate->factor_nonzeros, 1e-9 * estimate->factor_flops);
  printf("%-18sabout %.0f MB, %.0f MB more than now; %.0f MB %s are left: %s\n", "memory",
         estimate->memory / 1048576, estimate->more / 1048576, estimate->available / 1048576,
         estimate->whose, estimate->fits ? "it fits" : "it does NOT fit");

  printf("%-18srank %" PRId64 ", a file of about %.3g MB", "model", estimate->rank,
         estimate->file / 1048576);
  if (outcome->request->options.parameters)
    printf(", with what moduli and densities of %" PRId64 " regions add", mesh->region_count);
  putchar('\n');

  // rough times, stage by stage
  printf("%-18sabout %.2g s", "time", total_of(estimate));
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    printf("%s%s %.2g", stage == 0 ? ": " : ", ",
           precompute_stage_label_of((thrum_stage)stage, cubature).text, estimate->seconds[stage]);
  printf("\n%-18s(rough: within a factor of two or so on an idle machine%s)\n", "",
         outcome->request->train_count + outcome->request->test_count > 0
             ? "; the runs of --train and --test come on top"
             : "");
}

/* --- several processes ------------------------------------------------------------------------ */

static bool fits(const thrum_shared_solver *solver) {
  return solver->more <= solver->room;
}

static const thrum_shared_solver *chosen_of(const thrum_shared_estimate *estimate) {
  return estimate->solver == THRUM_SOLVER_CG ? &estimate->cg : &estimate->factor;
}

static void add_solver(cJSON *object, const char *name, const thrum_shared_solver *solver) {
  cJSON *row = cJSON_AddObjectToObject(object, name);
  json_number(row, "memory_mb", (solver->held + solver->more) / 1048576);
  json_number(row, "more_mb", solver->more / 1048576);
  json_number(row, "available_mb", solver->room / 1048576);
  cJSON_AddBoolToObject(row, "fits", fits(solver));
  json_number(row, "processes", solver->processes);
  json_number(row, "seconds", solver->seconds);
}

static void print_shared_json(const thrum_shared_estimate *estimate) {
  cJSON *object = cJSON_CreateObject();
  cJSON_AddStringToObject(object, "status", fits(chosen_of(estimate)) ? "fits" : "does not fit");
  json_number(object, "processes", estimate->processes);
  json_number(object, "free_dofs", (double)estimate->free_dofs);
  json_number(object, "factor_nonzeros", estimate->nonzeros);
  json_number(object, "factor_gflop", 1e-9 * estimate->flops);
  cJSON_AddStringToObject(object, "solver", estimate->solver == THRUM_SOLVER_CG ? "cg" : "factor");

  // each process, and with either solver
  cJSON *solvers = cJSON_AddObjectToObject(object, "solvers");
  add_solver(solvers, "factor", &estimate->factor);
  add_solver(solvers, "cg", &estimate->cg);
  json_print(object);
}

static void print_solver(const char *name, const thrum_shared_solver *solver) {
  const double mb = 1048576;
  printf("%-18sabout %.0f MB in a process, %.0f MB more than now; %.0f MB are left: ", name,
         (solver->held + solver->more) / mb, solver->more / mb, solver->room / mb);
  if (fits(solver))
    printf("it fits; about %.2g s\n", solver->seconds);
  else
    printf("it does NOT fit, but would into about %.0f processes with %.0f MB each\n",
           solver->processes, solver->room / mb);
}

static void print_shared(const thrum_shared_estimate *estimate) {
  printf("%-18s%d, with %" PRId64 " free components\n", "processes", estimate->processes,
         estimate->free_dofs);
  print_solver("a factor", &estimate->factor);
  print_solver("cg", &estimate->cg);
  printf("%-18s%s\n", "taken", estimate->solver == THRUM_SOLVER_CG ? "cg" : "the factor");
  printf("%-18s(times are rough: within a factor of three or so, where each process has a core)\n",
         "");
}

static thrum_status dry_run_shared(const precompute_outcome *outcome, const uint8_t *fixed,
                                   bool *flagged, thrum_error *error) {
  const precompute_request *request = outcome->request;
  const thrum_precompute_options options = thrum_options_complete(&request->options);
  const thrum_precompute_shared *shared = options.shared;
  thrum_shared_estimate estimate = {0};
  THRUM_TRY(thrum_options_check(&options, error));
  THRUM_TRY(shared->estimate(shared->context, outcome->mesh, fixed, &options, &estimate, error));
  if (request->json)
    print_shared_json(&estimate);
  else
    print_shared(&estimate);
  *flagged = !fits(chosen_of(&estimate));
  return THRUM_OK;
}

thrum_status precompute_dry_run(const precompute_outcome *outcome, const uint8_t *fixed,
                                bool *flagged, thrum_error *error) {
  thrum_estimate estimate;
  const precompute_request *request = outcome->request;
  if (request->options.shared != NULL)
    return dry_run_shared(outcome, fixed, flagged, error);
  THRUM_TRY(thrum_precompute_estimate(outcome->mesh, fixed, &request->options, &estimate, error));

  // a training holds its snapshots beside all of that
  const double training = precompute_train_bytes(request, outcome->mesh->vertex_count);
  estimate.more += training;
  estimate.memory += training;
  estimate.fits = estimate.more <= estimate.available;
  if (!estimate.fits && request->elsewhere)
    return thrum_estimate_refuse(&estimate, error);
  (request->json ? print_json : print_table)(outcome, &estimate);
  *flagged = !estimate.fits;
  return THRUM_OK;
}
