/* What the basis of a model leaves out of its motion, design 10.
 *
 * A reduced body solves U^T r = 0 with r = f - M a - R(U q), the residual of the whole mesh. What
 * is left of r acts on shapes that the basis has not, and one correction says how far the mesh
 * would follow: (K(U q) + w^2 M) e = r. As U^T M U = 1 the acceleration a = U U^T (f - R(U q))
 * needs no history: r is f - R less its part in M U. With w = 0 this is Newton's step towards the
 * static answer. In motion e has inertia: what changes at the rate w gets there by a share k / (k +
 * w^2) of its stiffness k at least, which is never more than what it would be at rest.
 *
 * The system is solved by conjugate gradients with the factor of K at rest, which end where the
 * matrix is not positive: e is then a first part of the correction, in which the mesh gives way at
 * least. Cost: the factor once; for each look the forces, an assembly and some solves.
 *
 * Source of the truncation: Steihaug 1983, doi:10.1137/0720042.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/model/basis_judge.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "platform/allocate.h"
#include "precompute/fem/rigid_modes.h"

#define SOLVES_MAX 60  /* of a look */
#define SOLVED 1e-6    /* share of the residual's square, in the norm of K^-1, that may be left */
#define ROUNDING 1e-12 /* of the largest force, by which a residual of rounding is off (rms) */

/* X(name): vectors of the free components */
#define JUDGE_VECTORS(X) X(r) X(z) X(p) X(product)

struct thrum_basis_judge {
  const thrum_model *model;
  thrum_model_statics statics;
  thrum_sparse tangent; /* values of its own on the pattern of the stiffness */
  thrum_scope memory;
  double *masses;     /* vertex_count */
  double *u, *inside; /* all components: displacement and internal forces */
  double *work;       /* of products */
#define X(name) double *name;
  JUDGE_VECTORS(X)
#undef X
  double *directions; /* free_count x (room + 1), of which the one behind `count` is being made */
  int64_t count, room;
};

const double *thrum_basis_judge_masses(const thrum_basis_judge *judge) {
  return judge->masses;
}

const thrum_model_statics *thrum_basis_judge_statics(const thrum_basis_judge *judge) {
  return &judge->statics;
}

int64_t thrum_basis_judge_directions(const thrum_basis_judge *judge, const double **directions) {
  *directions = judge->directions;
  return judge->count;
}

void thrum_basis_judge_free(thrum_basis_judge *judge) {
  if (judge == NULL)
    return;
  thrum_model_statics_free(&judge->statics);
  thrum_scope_free(&judge->memory);
  free(judge);
}

static thrum_status allocate(thrum_basis_judge *judge) {
  const thrum_model_fem *body = &judge->statics.body;
  const int64_t n = body->fem.free_count, all = 3 * judge->model->vertex_count;
  const int64_t entries = body->stiffness.begin[body->stiffness.size];
  thrum_scope *memory = &judge->memory;
#define X(name) judge->name = thrum_scope_allocate(memory, n, sizeof(double));
  JUDGE_VECTORS(X)
#undef X
  judge->masses = thrum_scope_allocate(memory, judge->model->vertex_count, sizeof(double));
  judge->u = thrum_scope_allocate(memory, all, sizeof(double));
  judge->inside = thrum_scope_allocate(memory, all, sizeof(double));
  judge->work = thrum_scope_allocate(memory, n * THRUM_PRODUCT_WORK, sizeof(double));
  judge->directions = thrum_scope_allocate(memory, n * (judge->room + 1), sizeof(double));

  // the tangent borrows the pattern and owns its values
  judge->tangent = body->stiffness;
  judge->tangent.value = thrum_scope_allocate(memory, entries, sizeof(double));
  return memory->status;
}

static thrum_status fill(thrum_basis_judge *judge, thrum_error *error) {
  thrum_model_fem *body = &judge->statics.body;
  THRUM_TRY(thrum_model_statics_plan(judge->model, &judge->statics, error));
  body->fem.law = thrum_law_of_model(judge->model);
  THRUM_TRY(allocate(judge));
  thrum_fem_vertex_mass(&body->fem, body->kind, judge->masses);
  return THRUM_OK;
}

thrum_status thrum_basis_judge_create(const thrum_model *model, int64_t directions,
                                      thrum_basis_judge **judge, thrum_error *error) {
  if (model->basis == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no basis to judge");
  thrum_basis_judge *made = NULL;
  THRUM_TRY(thrum_reserve(&made, 1, sizeof *made, "the judgement of the basis", error));
  made->memory = thrum_scope_begin("the judgement of the basis", error);
  made->model = model;
  made->room = directions;

  const thrum_status status = fill(made, error);
  if (status >= 0)
    *judge = made;
  else
    thrum_basis_judge_free(made);
  return status;
}

thrum_status thrum_basis_judge_begin(thrum_basis_judge *judge, thrum_error *error) {
  return thrum_model_statics_factorise(&judge->statics, error);
}

/* The row of the basis of a free component. */
static const double *row_of(const thrum_basis_judge *judge, int64_t i) {
  return judge->model->basis + judge->statics.body.fem.component[i] * judge->model->rank;
}

/* r = f - R(U q) less its part in M U; zero where that is rounding. */
static void find_residual(thrum_basis_judge *judge, const double *forces) {
  const thrum_model_fem *body = &judge->statics.body;
  const thrum_fem *fem = &body->fem;
  const int n = (int)fem->free_count, rank = (int)judge->model->rank;
  double a[THRUM_RANK_MAX] = {0};
  thrum_fem_energy(fem, judge->u, judge->inside);
  for (int64_t i = 0; i < n; i++)
    judge->r[i] = forces[fem->component[i]] - judge->inside[fem->component[i]];

  // the acceleration of the coordinates, and of the mesh with them
  for (int64_t i = 0; i < n; i++)
    cblas_daxpy(rank, judge->r[i], row_of(judge, i), 1, a, 1);
  for (int64_t i = 0; i < n; i++)
    judge->z[i] = cblas_ddot(rank, row_of(judge, i), 1, a, 1);
  thrum_sparse_product_in(&body->mass, judge->z, 1, judge->product, judge->work);
  cblas_daxpy(n, -1, judge->product, 1, judge->r, 1);

  // what moves a free body as a whole deforms nothing
  const double *rigid = judge->statics.rigid, *dual = judge->statics.dual;
  for (int64_t k = 0; rigid && k < THRUM_RIGID_COUNT; k++)
    cblas_daxpy(n, -cblas_ddot(n, rigid + k * n, 1, judge->r, 1), dual + k * n, 1, judge->r, 1);

  // what is left of forces that do that alone is their rounding
  double size = 0;
  for (int i = 0; i < n; i++)
    size =
        fmax(size, fmax(fabs(forces[fem->component[i]]), fabs(judge->inside[fem->component[i]])));
  if (cblas_dnrm2(n, judge->r, 1) <= ROUNDING * sqrt(n) * size)
    memset(judge->r, 0, (size_t)n * sizeof *judge->r);
}

/* product = (K(U q) + rate2 M) p. */
static void apply(thrum_basis_judge *judge, double rate2) {
  thrum_sparse_product_in(&judge->tangent, judge->p, 1, judge->product, judge->work);
  if (rate2 == 0)
    return;
  thrum_sparse_product_in(&judge->statics.body.mass, judge->p, 1, judge->z, judge->work);
  cblas_daxpy((int)judge->tangent.size, rate2, judge->z, 1, judge->product, 1);
}

/* e of (K(U q) + rate2 M) e = r, which becomes what is left of it. */
static thrum_status correct(thrum_basis_judge *judge, double rate2, double *e, thrum_error *error) {
  const int n = (int)judge->tangent.size;
  memset(e, 0, (size_t)n * sizeof *e);
  double first = 0, before = 0;
  for (int k = 0; k < SOLVES_MAX; k++) {
    THRUM_TRY(thrum_factor_solve(judge->statics.factor, judge->r, 1, judge->z, error));
    const double now = cblas_ddot(n, judge->r, 1, judge->z, 1);
    first = k == 0 ? now : first;
    if (!(now > SOLVED * first))
      break;

    // the next direction
    for (int i = 0; i < n; i++)
      judge->p[i] = judge->z[i] + (k > 0 ? now / before * judge->p[i] : 0);
    before = now;
    apply(judge, rate2);

    // where the matrix is not positive the first step is that of the body at rest
    const double curvature = cblas_ddot(n, judge->p, 1, judge->product, 1);
    if (!(curvature > 0)) {
      if (k == 0)
        cblas_daxpy(n, 1, judge->p, 1, e, 1);
      break;
    }
    cblas_daxpy(n, now / curvature, judge->p, 1, e, 1);
    cblas_daxpy(n, -now / curvature, judge->product, 1, judge->r, 1);
  }
  return THRUM_OK;
}

thrum_status thrum_basis_judge_look(thrum_basis_judge *judge, const double *q, const double *forces,
                                    double rate2, double *moved, double *lacking,
                                    thrum_error *error) {
  const thrum_model *model = judge->model;
  const int64_t all = 3 * model->vertex_count, n = judge->tangent.size;
  double *e = judge->directions + judge->count * n;
  for (int64_t c = 0; c < all; c++)
    judge->u[c] = cblas_ddot((int)model->rank, model->basis + c * model->rank, 1, q, 1);

  find_residual(judge, forces);
  THRUM_TRY(thrum_fem_stiffness(&judge->statics.body.fem, judge->u, &judge->tangent, error));
  THRUM_TRY(correct(judge, rate2, e, error));
  for (int64_t i = 0; i < n; i++)
    judge->u[judge->statics.body.fem.component[i]] += e[i];
  *moved = cblas_ddot((int)all, judge->u, 1, judge->u, 1);
  *lacking = cblas_ddot((int)n, e, 1, e, 1);
  judge->count += judge->count < judge->room;
  return THRUM_OK;
}
