/* A precompute by several processes, see shared_precompute.h. Rank 0 checks the whole body, cuts it
 * and hands the parts out; every process runs the stages of thrum_precompute_part on its own; rank
 * 0 gathers the rows of the basis and makes the model that one process would have made. What rank 0
 * holds beside its part is the mesh, its graph and 3 vertices x rank numbers: matrices and factor
 * are never in one place.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "mpi/shared_precompute.h"

#include <stdlib.h>
#include <string.h>

#include "mpi/agreement.h"
#include "mpi/body_modes.h"
#include "mpi/shared_system.h"
#include "platform/allocate.h"
#include "precompute/basis/order_find.h"
#include "precompute/estimate.h"
#include "precompute/fem/constraints.h"
#include "precompute/model/model_fill.h"
#include "precompute/options_check.h"

/* Tets up to which rank 0 estimates the error of linear tets on the whole mesh. */
#define ORDER_ERRORS_TETS 50000

typedef enum order { ORDER_END, ORDER_PRECOMPUTE, ORDER_ESTIMATE, ORDER_SYSTEM } order;

/* The command of rank 0 to the others; pointers of the options are of no use to them. */
typedef struct command {
  order order;
  int parts; /* that the body is cut into; later processes have none */
  thrum_precompute_options options;
} command;

/* A precompute as one process sees it. */
typedef struct session {
  MPI_Comm comm; /* of those that have a part */
  command command;
  body_part part;
  body_system system;
  thrum_precomputed result; /* of the part */
} session;

static void session_free(session *s) {
  body_system_free(&s->system);
  thrum_precomputed_free(&s->result);
  body_part_free(&s->part);
  if (s->comm != MPI_COMM_NULL)
    MPI_Comm_free(&s->comm);
}

// hears or, in rank 0, says what is to be done, and by which processes
static void session_open(MPI_Comm all, session *s) {
  int rank;
  MPI_Comm_rank(all, &rank);
  s->comm = MPI_COMM_NULL;
  agree_on_bytes(all, &s->command, (int64_t)sizeof s->command);
  if (s->command.order == ORDER_PRECOMPUTE || s->command.order == ORDER_ESTIMATE)
    MPI_Comm_split(all, rank < s->command.parts ? 0 : MPI_UNDEFINED, rank, &s->comm);
}

// the body is cut by all; *again: some part has nothing in it that moves, so fewer should have one
static thrum_status session_cut(session *s, const thrum_fem *fem, body_cut *cut, bool *again,
                                thrum_error *error) {
  const thrum_status status =
      agree_on_status(s->comm, body_cut_make(s->comm, fem, cut, error), error);
  *again = status >= 0 && fem != NULL && !body_cut_is_full(fem, cut);
  if (status >= 0)
    agree_on_bytes(s->comm, again, (int64_t)sizeof *again);
  return status;
}

// the stages on the part of this process
static thrum_status run_part(session *s, thrum_error *error) {
  s->system = body_system_begin(s->comm, &s->part, &s->command.options);
  thrum_ranks ranks = body_system_ranks(&s->system);
  body_modes_add(&ranks);
  const thrum_status status = thrum_precompute_part(&s->part.mesh, s->part.fixed,
                                                    &s->command.options, &ranks, &s->result, error);
  return agree_on_status(s->comm, status, error);
}

// what the stages would take on the part of this process, without the solver
static thrum_status estimate_part(session *s, const thrum_fem *fem, double entries,
                                  thrum_shared_estimate *estimate) {
  const double share = 1.0 / estimate->processes;
  thrum_estimate by_factor = {.factor_nonzeros = (int64_t)(share * estimate->nonzeros),
                              .factor_flops = share * estimate->flops};
  thrum_estimate by_cg = by_factor;
  thrum_estimate_times(fem, &s->command.options, &by_factor);
  thrum_estimate_times_cg(fem, &s->command.options, entries, &by_cg);

  // the slowest process counts, in the sum of its stages
  double seconds[2] = {0, 0};
  for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++) {
    seconds[0] += by_factor.seconds[stage];
    seconds[1] += by_cg.seconds[stage];
  }
  MPI_Allreduce(MPI_IN_PLACE, seconds, 2, MPI_DOUBLE, MPI_MAX, s->comm);
  estimate->factor.seconds = seconds[0];
  estimate->cg.seconds = seconds[1];
  return THRUM_OK;
}

// the matrices of the part and the plan of the factor, and what would come after them
static thrum_status estimate_together(session *s, thrum_shared_estimate *estimate,
                                      thrum_error *error) {
  const thrum_precompute_options *options = &s->command.options;
  thrum_fem fem = {0};
  thrum_sparse stiffness = {0}, mass = {0};
  thrum_status status = thrum_fem_create_of_order(&s->part.mesh, s->part.fixed,
                                                  options->quadrature_order, &fem, error);
  THRUM_THEN(status, thrum_fem_pattern(&fem, &stiffness, error));
  THRUM_THEN(status, thrum_fem_mass(&fem, options->mass, &stiffness, &mass, error));
  THRUM_THEN(status, thrum_fem_stiffness(&fem, NULL, &stiffness, error));
  status = agree_on_status(s->comm, status, error);

  s->system = body_system_begin(s->comm, &s->part, options);
  THRUM_THEN(status, body_system_estimate(&s->system, &fem, &stiffness, &mass, estimate, error));
  status = agree_on_status(s->comm, status, error);
  const double entries = status >= 0 ? 2.0 * (double)stiffness.begin[stiffness.size] : 0;
  THRUM_THEN(status, estimate_part(s, &fem, entries, estimate));
  thrum_sparse_free(&stiffness);
  thrum_sparse_free(&mass);
  thrum_fem_free(&fem);
  return status;
}

/* --- rank 0 ----------------------------------------------------------------------------------- */

typedef struct whole {
  const thrum_mesh *mesh;
  const uint8_t *fixed;
  body_cut cut;
  part_facts facts;
  double *modes; /* 3 vertex_count rows x modes, where they are gathered */
} whole;

// cuts the body into as many parts as there are processes, or fewer where some would be empty
static thrum_status cut_together(MPI_Comm all, session *s, const thrum_fem *fem, body_cut *cut,
                                 thrum_error *error) {
  int parts;
  bool again = true;
  MPI_Comm_size(all, &parts);
  thrum_status status = THRUM_OK;
  for (; again && status >= 0; parts = (parts + 1) / 2) {
    if (s->comm != MPI_COMM_NULL)
      MPI_Comm_free(&s->comm);
    body_cut_free(cut);
    s->command.parts = parts;
    session_open(all, s);
    status = session_cut(s, fem, cut, &again, error);
  }
  return status;
}

// the facts of the whole body, and its cut, in which all take part
static thrum_status cut_body(MPI_Comm all, session *s, whole *w, thrum_error *error) {
  thrum_fem fem = {0};
  bool free_body = false;
  thrum_precompute_options *options = &s->command.options;
  thrum_status status =
      thrum_fem_create_of_order(w->mesh, w->fixed, options->quadrature_order, &fem, error);
  THRUM_THEN(status, thrum_options_check_body(options, &fem, &free_body, error));

  // from here on the others are there; all parts take the points that the whole mesh wants
  if (status >= 0) {
    w->facts = (part_facts){.free_count = fem.free_count, .free_body = free_body};
    if (fem.rule && options->quadrature_order == 0)
      options->quadrature_order = fem.usual_order;
    status = cut_together(all, s, &fem, &w->cut, error);
  }

  // springs are found on the whole body, and known by their places in the cut
  if (status >= 0 && free_body) {
    thrum_support_find(&fem, &w->facts.support);
    for (int n = 0; n < THRUM_SUPPORTS; n++)
      w->facts.support.vertex[n] = w->cut.place[w->facts.support.vertex[n]];
  }
  thrum_fem_free(&fem);
  return status;
}

// the rows of all parts: the basis, Z of a free body, and the modes where they are wanted
static thrum_status gather_rows(session *s, whole *w, thrum_model *model, double *modes,
                                thrum_error *error) {
  const thrum_model *own = &s->result.model;
  const int64_t count = w ? w->mesh->vertex_count : 0, k = s->result.mode_count;
  const body_cut *cut = w ? &w->cut : NULL;
  double *basis = model ? thrum_model_writable(model->basis) : NULL;
  THRUM_TRY(
      body_part_gather(s->comm, &s->part, cut, count, 3 * own->rank, own->basis, basis, error));
  if (own->rigid)
    THRUM_TRY(body_part_gather(s->comm, &s->part, cut, count, 3 * THRUM_RIGID_COUNT, own->rigid,
                               model ? thrum_model_writable(model->rigid) : NULL, error));

  // modes are fields one after the other
  for (int64_t i = 0; i < k && s->result.mode_vectors; i++)
    THRUM_TRY(body_part_gather(s->comm, &s->part, cut, count, 3,
                               s->result.mode_vectors + 3 * i * s->part.facts.vertices,
                               modes ? modes + 3 * i * count : NULL, error));
  return THRUM_OK;
}

// the polynomial and the sums, which every part has whole
static void copy_reduced(const thrum_model *from, thrum_model *to) {
  memcpy(thrum_model_writable(to->c3), from->c3, sizeof *to->c3 * (size_t)to->c3_count);
  memcpy(thrum_model_writable(to->c4), from->c4, sizeof *to->c4 * (size_t)to->c4_count);
  memcpy(thrum_model_writable(to->omega2), from->omega2, sizeof *to->omega2 * (size_t)to->rank);
  memcpy(thrum_model_writable(to->axis_mass), from->axis_mass,
         sizeof *to->axis_mass * (size_t)(3 * to->rank));
}

// room for the model of the whole body
static thrum_status make_model(const session *s, const whole *w, thrum_model *model, double **modes,
                               thrum_error *error) {
  THRUM_TRY(thrum_model_fill_mesh(w->mesh, w->fixed, s->result.model.rank, false, model, error));
  copy_reduced(&s->result.model, model);
  const int64_t rows = 3 * w->mesh->vertex_count;
  if (s->result.model.rigid)
    THRUM_TRY(
        thrum_reserve(&model->rigid, THRUM_RIGID_COUNT * rows, sizeof(double), "the model", error));
  if (!s->result.mode_vectors)
    return THRUM_OK;
  return thrum_reserve(modes, s->result.mode_count * rows, sizeof **modes, "the modes", error);
}

// how much too high the frequencies of linear tets are, as one process finds it
static thrum_status estimate_errors(const whole *w, thrum_precomputed *result, thrum_error *error) {
  thrum_fem fem = {0};
  int64_t count =
      result->mode_count < THRUM_ORDER_ERRORS_MAX ? result->mode_count : THRUM_ORDER_ERRORS_MAX;
  thrum_status status = thrum_fem_create(w->mesh, w->fixed, &fem, error);
  THRUM_THEN(status, thrum_order_find(w->mesh, &fem, INFINITY, &count, result->order_error, error));
  if (status >= 0)
    result->order_error_count = count;
  thrum_fem_free(&fem);
  return status;
}

// the result of the whole body takes the figures of the part's, and its arrays
static thrum_status finish(session *s, const whole *w, bool keep_modes, thrum_model *model,
                           double *modes, thrum_precomputed *result, thrum_error *error) {
  THRUM_TRY(thrum_model_check(model, error));
  if (!w->mesh->midsides && !s->command.options.order_known &&
      w->mesh->tet_count <= ORDER_ERRORS_TETS)
    THRUM_TRY(estimate_errors(w, &s->result, error));
  model->identity = thrum_model_identity(model);
  thrum_model_fill_free(&s->result.model);
  free(s->result.mode_vectors);
  s->result.mode_vectors = NULL;
  *result = s->result;
  result->model = *model;
  if (keep_modes)
    result->mode_vectors = modes;
  else
    free(modes);
  s->result = (thrum_precomputed){0};
  return THRUM_OK;
}

// the part of this process, which rank 0 deals out of the whole body
static thrum_status take_part(session *s, const whole *w, thrum_error *error) {
  const thrum_status status =
      body_part_share(s->comm, w->mesh, w->fixed, &w->cut, &w->facts, &s->part, error);
  return agree_on_status(s->comm, status, error);
}

// all that rank 0 does once the body is cut
static thrum_status lead_session(session *s, whole *w, bool keep_modes, thrum_precomputed *result,
                                 thrum_error *error) {
  thrum_status status = take_part(s, w, error);
  THRUM_THEN(status, run_part(s, error));
  if (status < 0)
    return status;

  // room first, as the others wait to send
  thrum_model model = {0};
  double *modes = NULL;
  status = agree_on_status(s->comm, make_model(s, w, &model, &modes, error), error);
  THRUM_THEN(status, agree_on_status(s->comm, gather_rows(s, w, &model, modes, error), error));
  THRUM_THEN(status, finish(s, w, keep_modes, &model, modes, result, error));
  if (status < 0) {
    thrum_model_fill_free(&model);
    free(modes);
  }
  return status;
}

static thrum_status lead(void *context, const thrum_mesh *mesh, const uint8_t *fixed,
                         const thrum_precompute_options *options, thrum_precomputed *result,
                         thrum_error *error) {
  const shared_lead *leading = context;
  session s = {.comm = MPI_COMM_NULL, .command = {ORDER_PRECOMPUTE, 0, *options}};
  whole w = {.mesh = mesh, .fixed = fixed};
  thrum_error told = {0};
  thrum_error *heard = error ? error : &told;
  thrum_status status = cut_body(leading->comm, &s, &w, heard);
  THRUM_THEN(status, lead_session(&s, &w, options->keep_modes, result, heard));
  session_free(&s);
  body_cut_free(&w.cut);
  return status;
}

static thrum_status lead_estimate(void *context, const thrum_mesh *mesh, const uint8_t *fixed,
                                  const thrum_precompute_options *options,
                                  thrum_shared_estimate *estimate, thrum_error *error) {
  const shared_lead *leading = context;
  session s = {.comm = MPI_COMM_NULL, .command = {ORDER_ESTIMATE, 0, *options}};
  whole w = {.mesh = mesh, .fixed = fixed};
  thrum_error told = {0};
  thrum_error *heard = error ? error : &told;
  thrum_status status = cut_body(leading->comm, &s, &w, heard);
  THRUM_THEN(status, take_part(&s, &w, heard));
  THRUM_THEN(status, estimate_together(&s, estimate, heard));
  session_free(&s);
  body_cut_free(&w.cut);
  return status;
}

void shared_lead_begin(MPI_Comm comm, shared_lead *leading) {
  *leading = (shared_lead){.comm = comm};
  leading->shared = (thrum_precompute_shared){leading, lead, lead_estimate};
}

void shared_serve_system(MPI_Comm comm) {
  command system = {.order = ORDER_SYSTEM};
  agree_on_bytes(comm, &system, (int64_t)sizeof system);
}

void shared_serve_end(MPI_Comm comm) {
  command end = {.order = ORDER_END};
  agree_on_bytes(comm, &end, (int64_t)sizeof end);
}

/* --- the others ------------------------------------------------------------------------------- */

static void serve_session(session *s) {
  thrum_error error = {0};
  body_cut none = {0};
  bool again = false;
  thrum_status status = session_cut(s, NULL, &none, &again, &error);
  if (status < 0 || again)
    return;
  status = take_part(s, &(whole){0}, &error);
  if (s->command.order == ORDER_ESTIMATE) {
    thrum_shared_estimate estimate = {0};
    THRUM_THEN(status, estimate_together(s, &estimate, &error));
    return;
  }
  THRUM_THEN(status, run_part(s, &error));

  // rank 0 says whether it has room for what is sent
  THRUM_THEN(status, agree_on_status(s->comm, THRUM_OK, &error));
  THRUM_THEN(status, agree_on_status(s->comm, gather_rows(s, NULL, NULL, NULL, &error), &error));
}

void shared_serve(MPI_Comm comm) {
  for (;;) {
    session s = {.comm = MPI_COMM_NULL};
    session_open(comm, &s);
    if (s.command.order == ORDER_END)
      return;
    if (s.command.order == ORDER_SYSTEM)
      shared_systems_serve(comm);
    if (s.comm == MPI_COMM_NULL)
      continue;

    // what of the options is of rank 0 alone
    s.command.options.progress = NULL;
    s.command.options.shared = NULL;
    serve_session(&s);
    session_free(&s);
  }
}
