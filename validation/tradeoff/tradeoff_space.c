/* The bases that are compared, and the loads and the reference as they see them.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdlib.h>

#include "core/base/vec3.h"
#include "driver/make/precompute_train.h"
#include "driver/model/model_cut.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "runtime/material/material_law.h"
#include "thrum/external_load.h"
#include "thrum/polynomial.h"
#include "validation/tradeoff/tradeoff_private.h"

#define AGREES 1.02 /* a frequency of the basis over that of the linear mode it stands for */
#define MASTERS_LEAST 3
#define RANGE_LEAST 0.01 /* of cubature points: below it a body has little that is not linear */

/* --- views ------------------------------------------------------------------------------------ */

/* U^T of the reference's samples. */
static void project(const thrum_model *shape, tradeoff_view *view) {
  const tradeoff_reference *reference = view->reference;
  const int64_t rank = shape->rank;
  const double *from[2] = {reference->mass_u, reference->mass_v};
  double *to[2] = {view->reference_q, view->reference_p};
  for (int w = 0; w < 2; w++)
    for (int64_t n = 0; n < TRADEOFF_SAMPLES; n++)
      for (int64_t f = 0; f < reference->n; f++) {
        const double *row = shape->basis + reference->body.fem.component[f] * rank;
        const double value = from[w][n * reference->n + f];
        for (int64_t i = 0; i < rank; i++)
          to[w][n * rank + i] += row[i] * value;
      }
}

thrum_status tradeoff_view_make(const thrum_model *shape, const full_motion_script *script,
                                const tradeoff_reference *reference, tradeoff_view *view,
                                thrum_error *error) {
  const int64_t rank = shape->rank, components = 3 * shape->vertex_count;
  const int64_t count = (script->load_count + 2 * TRADEOFF_SAMPLES + 1) * rank;
  *view = (tradeoff_view){.script = script, .reference = reference};
  THRUM_TRY(thrum_reserve(&view->directions, count, sizeof *view->directions, "a basis", error));
  view->reference_q = view->directions + script->load_count * rank;
  view->reference_p = view->reference_q + TRADEOFF_SAMPLES * rank;
  view->start = view->reference_p + TRADEOFF_SAMPLES * rank;

  project(shape, view);
  for (int64_t l = 0; l < script->load_count; l++)
    THRUM_TRY(thrum_load_add_field(shape, script->forces + l * components,
                                   view->directions + l * rank, error));
  return full_motion_reduced_start(shape, &reference->body, script, view->start, error);
}

void tradeoff_view_free(tradeoff_view *view) {
  free(view->directions);
  *view = (tradeoff_view){0};
}

/* --- bases ------------------------------------------------------------------------------------ */

/* The range that points are trained on: how far the reference goes over the body's diagonal,
 * rounded up to two digits, as it stands in commands. */
static double range_of(const tradeoff_solution *s) {
  const thrum_model *model = s->problem->model;
  const double share =
      s->reference.reach / thrum_box3_diagonal(model->vertices, model->vertex_count);
  if (!(share > RANGE_LEAST))
    return RANGE_LEAST;
  const double digits = pow(10, 1 - floor(log10(share)));
  return ceil(share * digits) / digits;
}

/* Cubature points as the recipe says. */
static void ask_for_points(const tradeoff_solution *s, const tradeoff_recipe *recipe,
                           tradeoff_basis *basis, thrum_precompute_options *options) {
  if (!(recipe->cubature_error > 0))
    return;
  basis->cubature_range = range_of(s);
  options->cubature = true;
  options->cubature_error = recipe->cubature_error;
  options->cubature_range = basis->cubature_range;
  options->cubature_refine = s->problem->cubature_refine;
}

/* A model made from the mesh, half of it trained on the reference where the recipe says so. */
static thrum_status precompute(const tradeoff_solution *s, const tradeoff_recipe *recipe,
                               tradeoff_space *space, tradeoff_basis *basis, thrum_error *error) {
  const thrum_mesh *mesh = &s->reference.body.mesh;
  const uint8_t *fixed = s->problem->model->fixed;
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = recipe->modes;
  options.rank = recipe->rank;
  options.single = recipe->single;
  options.mass = s->reference.body.kind;
  options.law = thrum_law_of_model(s->problem->model);
  ask_for_points(s, recipe, basis, &options);

  if (recipe->trained) {
    thrum_precomputed base = {0};
    thrum_status status = precompute_train_base(mesh, fixed, &options, 0, &base, error);
    THRUM_THEN(status, precompute_train_shapes(&base.model, s->reference.u, 1, &options,
                                               &space->fields, error));
    thrum_precomputed_free(&base);
    if (status < 0)
      return status;
  }
  THRUM_TRY(thrum_precompute(mesh, fixed, &options, &space->made, error));
  if (options.cubature)
    basis->force_error = space->made.cubature.test_error;

  // its steps are timed, so it is packed as a model from a file is
  const size_t size = thrum_model_pack_size(&space->made.model);
  THRUM_TRY(thrum_reserve_aligned(&space->packed, size, "a basis", error));
  return thrum_model_pack(&space->made.model, space->packed, size, error);
}

/* The space whose basis the recipe condenses; NULL: it is not there. */
static const tradeoff_space *uncondensed(const tradeoff_solution *s,
                                         const tradeoff_recipe *recipe) {
  for (int64_t b = 0; b < s->result.basis_count; b++) {
    const tradeoff_recipe *other = &s->result.bases[b].recipe;
    if (other->masters == 0 && other->modes == recipe->modes && other->single == recipe->single &&
        other->trained == recipe->trained && !(other->cubature_error > 0) &&
        (recipe->modes == 0 || other->rank == recipe->rank))
      return &s->spaces[b];
  }
  return NULL;
}

/* Fills in what the recipe steps and shows. */
static thrum_status fill(const tradeoff_solution *s, const tradeoff_recipe *recipe,
                         tradeoff_space *space, tradeoff_basis *basis, thrum_error *error) {
  // the coordinates that are left follow in a basis that is there already
  const tradeoff_space *whole = recipe->masters > 0 ? uncondensed(s, recipe) : NULL;
  if (whole != NULL) {
    space->shape = whole->shape;
  } else if (recipe->modes > 0) {
    THRUM_TRY(precompute(s, recipe, space, basis, error));
    space->shape = &space->made.model;
  } else {
    space->shape = s->problem->model;
  }

  space->stepped = space->shape;
  if (recipe->masters > 0)
    THRUM_TRY(model_condense_to(space->shape, recipe->masters, &space->condensed, &space->stepped,
                                error));
  return THRUM_OK;
}

thrum_status tradeoff_samples_make(int64_t rank, tradeoff_samples *samples, thrum_error *error) {
  THRUM_TRY(thrum_reserve(&samples->q, 2 * TRADEOFF_SAMPLES * rank, sizeof *samples->q, "samples",
                          error));
  samples->p = samples->q + TRADEOFF_SAMPLES * rank;
  return THRUM_OK;
}

/* Fills the space with this number, and what of its basis the space shows. */
static thrum_status make_at(tradeoff_solution *s, const tradeoff_recipe *recipe, int64_t b,
                            tradeoff_basis *basis, thrum_error *error) {
  tradeoff_space *space = &s->spaces[b];
  *space = (tradeoff_space){0};
  *basis = (tradeoff_basis){
      .recipe = *recipe, .precompute_seconds = NAN, .cubature_range = NAN, .force_error = NAN};
  const double began = clock_thread_seconds();
  thrum_status status = fill(s, recipe, space, basis, error);
  if (recipe->modes > 0)
    basis->precompute_seconds = clock_thread_seconds() - began;

  // the reference and the loads in this basis
  THRUM_THEN(status, tradeoff_view_make(space->shape, &s->problem->script, &s->reference,
                                        &space->view, error));
  THRUM_THEN(status, tradeoff_samples_make(space->shape->rank, &space->tight, error));
  if (status < 0) {
    tradeoff_space_free(space);
    return status;
  }

  basis->rank = space->shape->rank;
  basis->points = space->shape->point_count;
  basis->projection = tradeoff_outside(&space->view, space->shape->rank);
  if (recipe->modes == 0)
    basis->recipe.single = basis->points == 0 && s->problem->model->packed_single != NULL;
  return THRUM_OK;
}

thrum_status tradeoff_space_make(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                 thrum_error *error) {
  const int64_t b = s->result.basis_count;
  if (b == TRADEOFF_BASES_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "more than %d bases at a time",
                           TRADEOFF_BASES_MAX);
  THRUM_TRY(make_at(s, recipe, b, &s->result.bases[b], error));
  s->result.basis_count++;
  return THRUM_OK;
}

thrum_status tradeoff_space_again(tradeoff_solution *s, int64_t b, thrum_error *error) {
  tradeoff_basis made;
  const tradeoff_recipe *recipe = &s->result.bases[b].recipe;
  if (s->spaces[b].shape != NULL)
    return THRUM_OK;

  // a condensed basis has its coordinates from the whole one
  const tradeoff_space *whole = recipe->masters > 0 ? uncondensed(s, recipe) : NULL;
  if (whole != NULL)
    THRUM_TRY(tradeoff_space_again(s, whole - s->spaces, error));
  return make_at(s, recipe, b, &made, error);
}

void tradeoff_space_free(tradeoff_space *space) {
  thrum_precomputed_free(&space->made);
  free(space->packed);
  free(space->condensed);
  free(space->fields);
  tradeoff_view_free(&space->view);
  free(space->tight.q);
  *space = (tradeoff_space){0};
}

int64_t tradeoff_masters(const tradeoff_solution *s, int64_t b, int64_t masters[2]) {
  const tradeoff_space *space = &s->spaces[b];
  const bool own = s->result.bases[b].recipe.modes == 0;
  const double *linear = own ? s->problem->mode_omega2 : space->made.mode_omega2;
  const double *omega2 = space->shape->omega2;
  int64_t most = own ? s->problem->mode_count : s->result.bases[b].recipe.modes;
  // what follows is found from coefficients, which points have none of
  if (space->shape->point_count > 0)
    return 0;
  if (most >= space->shape->rank)
    most = space->shape->rank - 1;

  // masters must be linear modes: the first of the basis that are
  int64_t linear_ones = 0, found = 0;
  while (linear != NULL && linear_ones < most &&
         omega2[linear_ones] <= AGREES * AGREES * linear[linear_ones])
    linear_ones++;
  if (linear_ones < MASTERS_LEAST)
    return 0;
  masters[found++] = linear_ones;

  // and fewer, up to the widest gap of the frequencies
  int64_t gap = MASTERS_LEAST;
  for (int64_t k = MASTERS_LEAST; k < linear_ones; k++)
    if (omega2[k] * omega2[gap - 1] > omega2[gap] * omega2[k - 1])
      gap = k;
  if (gap < linear_ones)
    masters[found++] = gap;
  return found;
}
