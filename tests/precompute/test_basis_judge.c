/* The judgement of a basis: in the limit of small loads what is lacking is the difference between
 * the mesh's answer and the model's, and a richer model has it.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>

#include "precompute/model/basis_judge.h"
#include "precompute/richer_model.h"
#include "tests/support/precompute_support.h"

/* A beam with a load at one vertex of its end, its model's static answer q, and the field. */
typedef struct loaded {
  body beam;
  thrum_precomputed made;
  thrum_basis_judge *judge;
  double *forces;
  double q[4];
} loaded;

enum { RANK = 4 };

static void make(loaded *l, const char *fix) {
  *l = (loaded){.beam = body_make("beam:6x1x1@1x0.2x0.2", fix)};
  l->made = body_precompute(&l->beam, RANK, RANK);
  const thrum_model *model = &l->made.model;
  l->forces = need((size_t)(3 * model->vertex_count), sizeof *l->forces);
  l->forces[3 * (model->vertex_count - 1) + 2] = 1e-3;
  l->forces[2] = -2e-3;

  // a free body's rigid part is no load
  for (int64_t i = 0; i < RANK; i++) {
    double sum = 0;
    for (int64_t c = 0; c < 3 * model->vertex_count; c++)
      sum += model->basis[c * RANK + i] * l->forces[c];
    l->q[i] = sum / model->omega2[i];
  }
  assert_int_equal(thrum_basis_judge_create(model, 4, &l->judge, NULL), THRUM_OK);
  assert_int_equal(thrum_basis_judge_begin(l->judge, NULL), THRUM_OK);
}

static void unmake(loaded *l) {
  thrum_basis_judge_free(l->judge);
  thrum_precomputed_free(&l->made);
  body_free(&l->beam);
  free(l->forces);
}

/* |K^-1 f|^2 and |K^-1 f - U q|^2 over all components. */
static void find(loaded *l, double *whole, double *apart) {
  const thrum_model_statics *statics = thrum_basis_judge_statics(l->judge);
  const thrum_fem *fem = &statics->body.fem;
  const int64_t n = fem->free_count;
  double *x = need((size_t)n, sizeof *x);
  thrum_fem_gather(fem, l->forces, x);
  assert_int_equal(thrum_factor_solve(statics->factor, x, 1, x, NULL), THRUM_OK);
  *whole = *apart = 0;
  for (int64_t i = 0; i < n; i++) {
    double u = 0;
    for (int64_t k = 0; k < RANK; k++)
      u += l->made.model.basis[fem->component[i] * RANK + k] * l->q[k];
    *whole += x[i] * x[i];
    *apart += (x[i] - u) * (x[i] - u);
  }
  free(x);
}

static void what_is_lacking_is_what_the_mesh_does_otherwise(void **state) {
  (void)state;
  static const char *const fixes[2] = {"x<0.001", NULL};
  for (int n = 0; n < 2; n++) {
    loaded l;
    make(&l, fixes[n]);
    double whole, apart, moved, lacking, faster;
    find(&l, &whole, &apart);
    assert_int_equal(thrum_basis_judge_look(l.judge, l.q, l.forces, 0, &moved, &lacking, NULL),
                     THRUM_OK);
    assert_true(apart > 1e-4 * whole);
    assert_true(fabs(moved / whole - 1) < 0.01 && fabs(lacking / apart - 1) < 0.01);

    // inertia lets the mesh follow less
    const double rate2 = l.made.model.omega2[RANK - 1];
    assert_int_equal(thrum_basis_judge_look(l.judge, l.q, l.forces, rate2, &moved, &faster, NULL),
                     THRUM_OK);
    assert_true(faster > 0 && faster < lacking);
    unmake(&l);
  }
}

static void a_richer_model_has_what_was_lacking(void **state) {
  (void)state;
  loaded l;
  make(&l, "x<0.001");
  thrum_richer_model richer = {.change = NULL};
  double whole, apart, moved, lacking, q[THRUM_RANK_MAX] = {0};
  find(&l, &whole, &apart);
  assert_int_equal(thrum_basis_judge_look(l.judge, l.q, l.forces, 0, &moved, &lacking, NULL),
                   THRUM_OK);
  assert_int_equal(thrum_richer_model_make(&l.made.model, l.judge, l.forces, 1, 3, &richer, NULL),
                   THRUM_OK);
  assert_int_equal(richer.model.rank, RANK + 3);

  // the change of coordinates keeps the shape
  for (int64_t c = 0; c < 3 * richer.model.vertex_count; c++) {
    double poor = 0, rich = 0;
    for (int64_t k = 0; k < RANK; k++)
      poor += l.made.model.basis[c * RANK + k] * l.q[k];
    for (int64_t k = 0; k < richer.model.rank; k++)
      for (int64_t i = 0; i < RANK; i++)
        rich +=
            richer.model.basis[c * richer.model.rank + k] * richer.change[k * RANK + i] * l.q[i];
    assert_true(fabs(poor - rich) < 1e-9 * sqrt(whole));
  }

  // and its static answer is the mesh's
  double sum = 0;
  const thrum_model_statics *statics = thrum_basis_judge_statics(l.judge);
  const thrum_fem *fem = &statics->body.fem;
  for (int64_t k = 0; k < richer.model.rank; k++) {
    for (int64_t c = 0; c < 3 * richer.model.vertex_count; c++)
      q[k] += richer.model.basis[c * richer.model.rank + k] * l.forces[c];
    q[k] /= richer.model.omega2[k];
  }
  double *x = need((size_t)fem->free_count, sizeof *x);
  thrum_fem_gather(fem, l.forces, x);
  assert_int_equal(thrum_factor_solve(statics->factor, x, 1, x, NULL), THRUM_OK);
  for (int64_t i = 0; i < fem->free_count; i++) {
    double u = 0;
    for (int64_t k = 0; k < richer.model.rank; k++)
      u += richer.model.basis[fem->component[i] * richer.model.rank + k] * q[k];
    sum += (x[i] - u) * (x[i] - u);
  }
  assert_true(sum < 1e-6 * apart);
  free(x);
  thrum_richer_model_free(&richer);
  unmake(&l);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_lacking_is_what_the_mesh_does_otherwise),
      cmocka_unit_test(a_richer_model_has_what_was_lacking),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
