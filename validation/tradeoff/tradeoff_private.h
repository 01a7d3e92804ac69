/* The things that the parts of the trade-off share: the reference, the bases, and the work on them.
 * For tradeoff*.c alone. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_TRADEOFF_TRADEOFF_PRIVATE_H
#define THRUM_VALIDATION_TRADEOFF_TRADEOFF_PRIVATE_H

#include "precompute/model/model_fem.h"
#include "precompute/precompute.h"
#include "validation/tradeoff/tradeoff.h"

#define TRADEOFF_SAMPLES FULL_MOTION_SAMPLES

/* Progress of a stage under its name, for what reports a fraction alone. */
typedef struct tradeoff_stage {
  const tradeoff_problem *problem;
  const char *name;
} tradeoff_stage;
static inline bool tradeoff_show(void *context, double fraction) {
  const tradeoff_stage *stage = context;
  const tradeoff_problem *problem = stage->problem;
  return problem->progress == NULL ||
         problem->progress(problem->progress_context, stage->name, fraction);
}

/* The full order at the sample times. */
typedef struct tradeoff_reference {
  thrum_model_fem body;
  int64_t n;      /* free components */
  double *mass_u; /* TRADEOFF_SAMPLES x n: M u */
  double *mass_v; /* M v */
  double *u;      /* FULL_MOTION_SNAPSHOTS x 3 vertex_count where it is kept, else NULL */
  double u_square[TRADEOFF_SAMPLES], v_square[TRADEOFF_SAMPLES], energy[TRADEOFF_SAMPLES];
  double reach; /* largest displacement of a vertex [m] */
  double us_per_step;
} tradeoff_reference;

/* `keep`: u as well. `stage`: for the progress. */
thrum_status tradeoff_reference_make(const tradeoff_problem *problem,
                                     const full_motion_script *script, const char *stage, bool keep,
                                     tradeoff_reference *reference, thrum_error *error);
void tradeoff_reference_free(tradeoff_reference *reference);

/* By how much the mesh has the worst of its first frequencies too high, by thrum_order_find; NaN
 * for ten-node tetrahedra. */
thrum_status tradeoff_mesh_error(const tradeoff_reference *reference, double *found,
                                 thrum_error *error);

/* A reduced run's samples: q and p (TRADEOFF_SAMPLES x rank each) and energies. */
typedef struct tradeoff_samples {
  double *q, *p;
  double energy[TRADEOFF_SAMPLES];
} tradeoff_samples;
thrum_status tradeoff_samples_make(int64_t rank, tradeoff_samples *samples, thrum_error *error);

/* A script as one basis sees it: its loads, and the reference. */
typedef struct tradeoff_view {
  const full_motion_script *script;
  const tradeoff_reference *reference;
  double *directions;  /* load_count x rank; owned, with the others */
  double *start;       /* rank: coordinates at the start */
  double *reference_q; /* TRADEOFF_SAMPLES x rank: U^T M u */
  double *reference_p;
} tradeoff_view;
thrum_status tradeoff_view_make(const thrum_model *shape, const full_motion_script *script,
                                const tradeoff_reference *reference, tradeoff_view *view,
                                thrum_error *error);
void tradeoff_view_free(tradeoff_view *view);

/* A basis, made or the model's own, as the runs of it share it. */
typedef struct tradeoff_space {
  const thrum_model *shape;   /* with all coordinates */
  const thrum_model *stepped; /* the same, or the condensed model of its lowest coordinates */
  thrum_precomputed made;     /* empty for the model's own */
  void *packed;               /* its coefficients as steps read them, or NULL */
  void *condensed;            /* memory of `stepped`, or NULL */
  double *fields;             /* trained shapes, or NULL */
  tradeoff_view view;         /* of the loads asked for */
  tradeoff_samples tight;
} tradeoff_space;

/* Everything while it is made. */
typedef struct tradeoff_solution {
  const tradeoff_problem *problem;
  tradeoff_reference reference;
  tradeoff_space *spaces; /* TRADEOFF_BASES_MAX; of what was made elsewhere, without a shape */
  double full_error;      /* of those, that of the basis of least error; see tradeoff_result */
  double least_error;     /* of those */
  tradeoff_result result; /* with room for so many bases */
} tradeoff_solution;

/* Makes the basis of a recipe in spaces[basis_count] and counts it. */
thrum_status tradeoff_space_make(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                 thrum_error *error);
void tradeoff_space_free(tradeoff_space *space);

/* Makes the space of a basis that was made elsewhere, unless it is there. */
thrum_status tradeoff_space_again(tradeoff_solution *s, int64_t b, thrum_error *error);

/* Numbers of masters of the basis `b` that are worth trying, at most two, into `masters`; returns
 * how many. */
int64_t tradeoff_masters(const tradeoff_solution *s, int64_t b, int64_t masters[2]);

/* A run of one setting in one space under the script of a view. */
typedef struct tradeoff_pass {
  double seconds;         /* processor time a step */
  bool whole;             /* it did not end early */
  bool believed;          /* true of what is not condensed */
  int64_t fallback_steps; /* steps that needed more than their own scheme */
  bool grew;              /* a step gained energy that nothing gave it */
} tradeoff_pass;
thrum_status tradeoff_step(const tradeoff_space *space, const tradeoff_view *view,
                           const thrum_state_def *def, tradeoff_samples *samples,
                           tradeoff_pass *pass, thrum_error *error);

/* The errors of samples against the full order, and against others of the same basis. */
tradeoff_errors tradeoff_against_full(const tradeoff_view *view, int64_t rank,
                                      const tradeoff_samples *samples);
tradeoff_errors tradeoff_against(int64_t rank, const tradeoff_samples *samples,
                                 const tradeoff_samples *other);

/* The share of the reference's displacement that lies outside the basis. */
double tradeoff_outside(const tradeoff_view *view, int64_t rank);

/* of the kinetic energy of the tight run, for a mode to be in the load's band */
thrum_state_def tradeoff_def(const tradeoff_problem *problem, experiment_scheme scheme, double dt,
                             double tolerance);

/* All recipes; those that the mesh is too small for are left out. */
thrum_status tradeoff_spaces_make(tradeoff_solution *s, thrum_error *error);
/* The linear modes of the bases alone, the other coordinates following. */
thrum_status tradeoff_spaces_condense(tradeoff_solution *s, thrum_error *error);

/* Tight runs of the bases from `first` on, then all settings of them. */
thrum_status tradeoff_try(tradeoff_solution *s, int64_t first, thrum_error *error);

/* A recipe and its condensed forms, with all settings; one that cannot be made is counted, and no
 * failure. */
thrum_status tradeoff_try_recipe(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                 thrum_error *error);

/* The same from what was made elsewhere: all recipes of the problem, or one. */
thrum_status tradeoff_take_recipes(tradeoff_solution *s, thrum_error *error);
thrum_status tradeoff_take_recipe(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                  thrum_error *error);

/* The recipes of the search, into `recipes`, which has room for them; returns how many. */
int64_t tradeoff_search_recipes(const tradeoff_problem *problem, tradeoff_recipe *recipes);

/* Goes on with condensed and trained bases until one does what is wanted. */
thrum_status tradeoff_search(tradeoff_solution *s, thrum_error *error);

#endif
