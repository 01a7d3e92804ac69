/* `thrum precompute --dry-run`: what the model would take, without making it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <stdio.h>

#include "driver/precompute_dry.h"
#include "driver/precompute_progress.h"
#include "driver/precompute_train.h"
#include "io/json.h"
#include "precompute/build_info.h"
#include "precompute/estimate.h"

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
  json_number(object, "order", mesh->midsides != NULL ? 2 : 1);
  json_number(object, "fixed", (double)outcome->fixed_count);
  json_number(object, "free_dofs", (double)estimate->free_dofs);
  json_number(object, "factor_nonzeros", (double)estimate->factor_nonzeros);
  json_number(object, "factor_gflop", 1e-9 * estimate->factor_flops);

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
  printf("%-18s%" PRId64 " vertices (%" PRId64 " held), %" PRId64 " tetrahedra\n", "mesh",
         mesh->vertex_count, outcome->fixed_count, mesh->tet_count);
  printf("%-18s%" PRId64 " free components, %.4g nonzeros, %.4g Gflop\n", "factor",
         estimate->free_dofs, (double)estimate->factor_nonzeros, 1e-9 * estimate->factor_flops);
  printf("%-18sabout %.0f MB, %.0f MB more than now; %.0f MB %s are left: %s\n", "memory",
         estimate->memory / 1048576, estimate->more / 1048576, estimate->available / 1048576,
         estimate->whose, estimate->fits ? "it fits" : "it does NOT fit");

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

thrum_status precompute_dry_run(const precompute_outcome *outcome, const uint8_t *fixed,
                                bool *flagged, thrum_error *error) {
  thrum_estimate estimate;
  const precompute_request *request = outcome->request;
  THRUM_TRY(thrum_precompute_estimate(outcome->mesh, fixed, &request->options, &estimate, error));

  // a training holds its snapshots beside all of that
  const double training = precompute_train_bytes(request, outcome->mesh->vertex_count);
  estimate.more += training;
  estimate.memory += training;
  estimate.fits = estimate.more <= estimate.available;
  (request->json ? print_json : print_table)(outcome, &estimate);
  *flagged = !estimate.fits;
  return THRUM_OK;
}
