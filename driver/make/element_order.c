/* Linear tetrahedra that lock are taken with ten nodes, where a model of these can be made.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/element_order.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "driver/model/locking.h"
#include "io/json.h"
#include "mesh/midsides.h"
#include "mesh/solids.h"
#include "platform/memory_limit.h"
#include "platform/threads.h"
#include "precompute/basis/order_find.h"
#include "precompute/estimate.h"
#include "precompute/fem/refine_solids.h"
#include "precompute/options_check.h"

#define TETS_MAX 200000  /* beyond it a plan for ten nodes alone takes long */
#define REFINED_MAX 8000 /* vertices of the finer mesh, whose modes take about a second */
#define WORK_MAX 5e12    /* operations of the factor and its solves: minutes on one core */

/* Whether a failure says that nothing is chosen, and not that precompute will refuse the body and
 * say why. */
static bool is_fatal(thrum_status status) {
  return status == THRUM_OUT_OF_MEMORY || status == THRUM_NOT_CONVERGED ||
         status == THRUM_INTERRUPTED;
}

/* The error of the mesh as it is. A body that precompute will refuse has none; without memory
 * nothing is chosen. */
static thrum_status estimate(const precompute_request *request, const thrum_mesh *mesh,
                             const uint8_t *fixed, element_order *order, thrum_error *error) {
  const int threads = request->options.threads;
  thrum_fem fem = {0};
  int64_t count = THRUM_ORDER_ERRORS_MAX;
  THRUM_TRY(thrum_threads_ready(threads, error));
  const thrum_threads before = thrum_threads_set(threads);

  // the limit is of the whole process
  const char *whose;
  double room = thrum_memory_available(&whose);
  if (request->options.memory_limit > 0)
    room = fmax(0, request->options.memory_limit - thrum_memory_resident());

  thrum_status status = thrum_fem_create(mesh, fixed, &fem, error);
  THRUM_THEN(status, thrum_order_find(mesh, &fem, room, &count, order->errors, error));
  order->error_count = status >= 0 ? count : 0;
  thrum_fem_free(&fem);
  thrum_threads_restore(before);
  return is_fatal(status) ? status : THRUM_OK;
}

/* Whether a model of the mesh with ten nodes is made, or why not. */
static thrum_status weigh(const precompute_request *request, const thrum_mesh *mesh,
                          const uint8_t *fixed, element_order *order, bool *affordable,
                          thrum_error *error) {
  thrum_estimate made = {0};
  thrum_precompute_options options = request->options;
  options.shared = NULL;
  *affordable = false;
  const thrum_status status = thrum_precompute_estimate(mesh, fixed, &options, &made, error);
  if (status < 0)
    return is_fatal(status) ? status : THRUM_OK;

  // several processes have more memory than this one
  if (!made.fits && request->options.shared == NULL) {
    snprintf(order->kept, sizeof order->kept, "ten nodes would take about %.0f MB of the %.0f %s",
             made.more / 1048576, made.available / 1048576, made.whose);
    return THRUM_OK;
  }

  // solves are for the modes and for the derivatives, as many as there are pairs of modes
  const thrum_precompute_options complete = thrum_options_complete(&options);
  const double shapes = (double)thrum_options_shapes(&complete);
  const double solves = 2 * shapes + 32 + shapes * (shapes + 1) / 2;
  *affordable = made.factor_flops + 4 * (double)made.factor_nonzeros * solves <= WORK_MAX;
  if (*affordable)
    return THRUM_OK;
  double seconds = 0;
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
    seconds += made.seconds[stage];
  snprintf(order->kept, sizeof order->kept, "ten nodes would take about %.2g minutes and %.0f MB",
           seconds / 60, made.more / 1048576);
  return THRUM_OK;
}

/* The mesh with its middle nodes, and what of it is held. */
static thrum_status change(const precompute_request *request, element_order_hold *hold, bool add,
                           thrum_mesh *mesh, uint8_t **fixed, thrum_error *error) {
  if (add)
    THRUM_TRY(thrum_midsides_add(mesh, error));
  else
    thrum_midsides_undo(mesh);
  free(*fixed);
  *fixed = NULL;
  return hold(request, mesh, fixed, error);
}

thrum_status element_order_choose(const precompute_request *request, bool read,
                                  element_order_hold *hold, config_progress *bar, thrum_mesh *mesh,
                                  uint8_t **fixed, element_order *order, thrum_error *error) {
  *order = (element_order){.by = ELEMENT_ORDER_AUTO};
  if (request->reading.order > 0)
    order->by = request->order_of_recipe ? ELEMENT_ORDER_RECIPE : ELEMENT_ORDER_USER;
  else if (!read || mesh->midsides || mesh->solid_count > 0 || request->import_basis)
    order->by = ELEMENT_ORDER_MESH;
  if (order->by != ELEMENT_ORDER_AUTO)
    return THRUM_OK;

  // a large mesh is estimated by the precompute itself
  if (mesh->tet_count > TETS_MAX) {
    snprintf(order->kept, sizeof order->kept,
             "of more than %d tetrahedra ten nodes are made where they are asked for", TETS_MAX);
    return THRUM_OK;
  }
  config_progress_update(bar, "four nodes or ten", 0);
  THRUM_TRY(estimate(request, mesh, *fixed, order, error));
  config_progress_update(bar, "four nodes or ten", 0.5);
  if (!(locking_most(order->errors, order->error_count) > LOCKING_TOLD))
    return THRUM_OK;

  bool affordable = false;
  THRUM_TRY(change(request, hold, true, mesh, fixed, error));
  THRUM_TRY(weigh(request, mesh, *fixed, order, &affordable, error));
  if (affordable)
    return THRUM_OK;
  return change(request, hold, false, mesh, fixed, error);
}

/* A mesh that is two or four times as fine, as far as it has few enough elements. */
static thrum_status refine(const thrum_mesh *mesh, const uint8_t *fixed, thrum_mesh *finer,
                           uint8_t **held, int *levels, thrum_error *error) {
  THRUM_TRY(thrum_mesh_refine(mesh, fixed, finer, held, error));
  *levels = 1;
  thrum_refined_size size;
  THRUM_TRY(thrum_mesh_refined_size(finer, &size, error));
  if (size.vertices > REFINED_MAX)
    return THRUM_OK;
  thrum_mesh finest = {0};
  uint8_t *finest_held = NULL;
  THRUM_TRY(thrum_mesh_refine(finer, *held, &finest, &finest_held, error));
  thrum_mesh_free(finer);
  free(*held);
  *finer = finest;
  *held = finest_held;
  *levels = 2;
  return THRUM_OK;
}

thrum_status element_order_refine(const precompute_request *request, const thrum_mesh *mesh,
                                  const uint8_t *fixed, int64_t modes, const double *omega2,
                                  element_order *order, thrum_error *error) {
  order->finer_count = 0;
  thrum_refined_size size;
  THRUM_TRY(thrum_mesh_refined_size(mesh, &size, error));
  if (size.elements == 0 || size.vertices > REFINED_MAX || mesh->springs != NULL || mesh->about)
    return THRUM_OK;
  const int64_t count = modes < ELEMENT_ORDER_FINER ? modes : ELEMENT_ORDER_FINER;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = options.rank = count;
  options.mass = request->options.mass;
  options.check = THRUM_CHECK_SEARCH;
  options.order_known = true;
  options.threads = request->options.threads;
  options.memory_limit = request->options.memory_limit;

  thrum_mesh finer = {0};
  uint8_t *held = NULL;
  int levels = 0;
  thrum_precomputed made = {0};
  thrum_status status = refine(mesh, fixed, &finer, &held, &levels, error);
  THRUM_THEN(status, thrum_precompute(&finer, held, &options, &made, error));

  // the error of what is 2^levels times as fine is 4^-levels times that of the mesh
  const double share = 1 - ldexp(1, -2 * levels);
  for (int64_t i = 0; i < count && status >= 0; i++)
    order->finer_errors[order->finer_count++] = (sqrt(omega2[i] / made.mode_omega2[i]) - 1) / share;
  thrum_precomputed_free(&made);
  thrum_mesh_free(&finer);
  free(held);

  // a finer mesh that fails, or finds no memory, says nothing of this one
  return status == THRUM_INTERRUPTED ? status : THRUM_OK;
}

void element_order_say(const element_order *order, const thrum_mesh *mesh, const char *name) {
  char text[LOCKING_TEXT_MAX];
  if (order->by != ELEMENT_ORDER_AUTO || !mesh->midsides)
    return;
  fprintf(stderr,
          "thrum: %s: its tetrahedra are taken with ten nodes, as with four its first frequencies "
          "would be about %s too high (--order 1 keeps four)\n",
          name, locking_text(order->errors, order->error_count, text));
}

/* Three digits are more than an estimate has, and the same on every machine. */
static void add_errors(cJSON *object, const char *key, const double *values, int64_t count) {
  if (count == 0)
    return;
  cJSON *errors = cJSON_AddArrayToObject(object, key);
  for (int64_t i = 0; i < count; i++) {
    char text[32];
    snprintf(text, sizeof text, "%.3g", values[i]);
    cJSON_AddItemToArray(errors, json_number_item(strtod(text, NULL)));
  }
}

void element_solids_json(cJSON *object, const thrum_mesh *mesh) {
  if (mesh->solid_count > 0)
    cJSON_AddStringToObject(object, "solids",
                            thrum_solid_count_words(mesh->solid_form, mesh->solid_count).text);
}

void element_order_json(cJSON *object, const element_order *order, const thrum_mesh *mesh) {
  static const char *const names[] = {"mesh", "user", "recipe", "auto"};
  json_number(object, "order", mesh->midsides != NULL ? 2 : 1);
  cJSON_AddStringToObject(object, "order_by", names[order->by]);
  add_errors(object, "order_error", order->errors, order->error_count);
  add_errors(object, "ten_node_error", order->cubic_errors, order->cubic_count);
  add_errors(object, "finer_error", order->finer_errors, order->finer_count);
}
