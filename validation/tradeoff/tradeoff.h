/* Speed against accuracy: one load script, stepped by the full-order body of the same mesh
 * and by reduced models over rank, precision, integrator, time step and tolerance (design 14).
 *
 * Fields are compared at equally spaced times in the norm of the mass: |U q - u|^2 =
 * |u|^2 - 2 q U^T M u + |q|^2 as U^T M U = 1. Three errors are told apart: of the basis (a tightly
 * solved run in that basis against the full order), in time (a run against the tight one of its
 * basis), and of both together (against the full order).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_TRADEOFF_TRADEOFF_H
#define THRUM_VALIDATION_TRADEOFF_TRADEOFF_H

#include <math.h>
#include <stdio.h>

#include "driver/make/full_motion.h"
#include "validation/experiments/scheme.h"

#define TRADEOFF_LIST_MAX 16
#define TRADEOFF_BASES_MAX 256
#define TRADEOFF_POINTS_MAX 4 /* errors of the force that points are chosen for */
#define TRADEOFF_TESTS_MAX 16

/* The coordinates that are stepped: a basis, how many of them, and what gives their energy. */
typedef struct tradeoff_recipe {
  int64_t modes, rank; /* modes 0: the model's own basis, with its rank */
  bool single;         /* coefficients rounded to single precision; not of an own basis */
  bool trained;        /* half of the rank shows the motion under the loads (precompute --train) */
  int64_t masters;     /* coordinates that are stepped, the others following; 0: all are stepped */
  /* Relative error of the force at which cubature points in place of the polynomial are enough
   * (precompute --cubature-error); 0: the polynomial, or an own basis as it is. */
  double cubature_error;
} tradeoff_recipe;

struct tradeoff_result;

/* The settings to be compared. `model` needs a mesh, a basis and fixed vertices; its material is of
 * its point_law, which need not be that of its coefficients where its own basis is in no recipe. */
typedef struct tradeoff_problem {
  const thrum_model *model;
  full_motion_script script;
  double full_dt;        /* of the full order [s] */
  const char *keep_runs; /* folder where full-order runs are kept and taken from; may be NULL */

  /* Tried in any case, each with all that follows. */
  int64_t recipe_count;
  tradeoff_recipe recipes[TRADEOFF_BASES_MAX];
  int64_t dt_count, tolerance_count;
  double dts[TRADEOFF_LIST_MAX];
  double tolerances[TRADEOFF_LIST_MAX];
  bool integrators[EXPERIMENT_SCHEME_COUNT];
  bool condense; /* each basis also with its linear modes alone stepped, by `verlet` too */

  /* The wish: an error of the displacement, a cost [s/s]; NaN: no limit, one is a number.
   * Where no recipe does it and rank_max is above 0, trained bases of `modes` linear modes are
   * tried, of higher and higher rank up to rank_max: with polynomials, unless points are wanted
   * alone, and with points for each of these errors of the force, where they may pay or are wanted
   * alone. */
  double error, cost;
  bool by_worse; /* the error is the larger of those of displacement and velocity */
  int64_t modes, rank_max;
  bool points_alone; /* no polynomials */
  int64_t cubature_count;
  double cubature_errors[TRADEOFF_POINTS_MAX];
  int64_t cubature_refine;   /* steps in which the gradients of points are learned; 0: none */
  const double *mode_omega2; /* linear modes of the model's own basis [1/s^2]; NULL: not known */
  int64_t mode_count;

  /* Loads that no basis is trained on, under which the chosen setting is run as well. */
  int64_t test_count;
  const full_motion_script *tests;

  /* Where the recipes and the full order of the tests were run elsewhere, as jobs: gives what
   * tradeoff_solve_recipe made of a recipe, and says whether that of a test is kept. A result
   * without bases and without one that was dropped: it is not there, and is left out. NULL: all is
   * run. */
  thrum_status (*take)(void *context, const tradeoff_recipe *recipe, struct tradeoff_result *part,
                       thrum_error *error);
  bool (*is_kept)(void *context, int64_t test);
  void *take_context;

  int threads;
  /* Called as a stage advances; false stops. May be NULL. */
  bool (*progress)(void *context, const char *stage, double fraction);
  /* Called when the search goes on beyond the recipes, with about how long it may take [s]; may be
   * NULL. */
  void (*search_begins)(void *context, double seconds);
  void *progress_context;
} tradeoff_problem;

/* Errors relative to the largest of the reference over the time: root mean square of displacement
 * and velocity, largest of the energy. */
typedef struct tradeoff_errors {
  double displacement, velocity, energy;
} tradeoff_errors;

/* The error that a setting is judged by. */
static inline double tradeoff_judged(const tradeoff_errors *errors, bool by_worse) {
  return by_worse ? fmax(errors->displacement, errors->velocity) : errors->displacement;
}

/* A basis, and what its tightly solved run shows. */
typedef struct tradeoff_basis {
  tradeoff_recipe recipe;
  int64_t rank;          /* as it was made */
  int64_t points;        /* cubature points in place of the polynomial; 0: none */
  double cubature_range; /* largest displacement that they are trained on, over the diagonal; */
  double force_error;    /* relative rms of the force in other states; both NaN: not made here */
  tradeoff_errors error; /* of the basis, with its points */
  double projection;     /* displacement that no motion in the basis can show; below every error */
  double tight_dt;
  double precompute_seconds; /* processor time; NaN: the model's own */
} tradeoff_basis;

typedef struct tradeoff_run {
  int64_t basis; /* which */
  experiment_scheme integrator;
  double dt, tolerance;
  bool stable;                /* came to its end with an energy that a body of this load can have */
  int64_t fallback_steps;     /* for which `thrum simulate` flags the run fell_back */
  bool grew;                  /* `thrum simulate` flags the run energy_grew */
  bool disproved;             /* condensing leaves out more than a run of it can be believed with */
  double us_per_step;         /* processor time */
  double cost;                /* processor seconds a simulated second */
  tradeoff_errors error;      /* against the full order; NaN where not stable */
  tradeoff_errors time_error; /* against the tight run of the basis */
  bool cancels;               /* its error is below that of its basis */
  double drift; /* change of the mean energy after the last load; NaN with damping or load */
  /* The mode, among those that the load moves, whose frequency a step gets most wrong: which it is,
   * by how much relatively, and both frequencies [Hz]; stepped NaN: it does not vibrate. */
  int64_t frequency_mode;
  double frequency_error, frequency, stepped_frequency;
  bool front; /* no run is both cheaper and more accurate */
} tradeoff_run;

typedef struct tradeoff_result {
  int64_t basis_count, run_count;
  tradeoff_basis *bases;
  tradeoff_run *runs;
  int64_t searched;        /* bases beyond the recipes */
  int64_t free_count;      /* components of the full order */
  bool lumped;             /* its mass, and that of the bases */
  double full_us_per_step; /* processor time */
  double full_cost;        /* processor seconds a simulated second */
  int64_t dropped;         /* bases that could not be made, and why the last one could not */
  thrum_error dropped_reason;
  double full_error; /* of the reference in time: the finest basis at full_dt against tight */
  /* By how much the mesh has the worst of its first frequencies too high, at least; NaN: it is of
   * ten-node tetrahedra, or the linear modes of the model are not known. */
  double mesh_error;
  bool by_worse;  /* the problem's */
  int64_t chosen; /* the run that does what was wanted; -1: none */
  /* Errors of the displacement under the tests, and of the velocity: of the chosen run, and of the
   * model's own basis at its time step; NaN where a run is lost. Without a chosen run there are
   * none. */
  double test_error[TRADEOFF_TESTS_MAX], test_own_error[TRADEOFF_TESTS_MAX];
  double test_velocity[TRADEOFF_TESTS_MAX], test_own_velocity[TRADEOFF_TESTS_MAX];
} tradeoff_result;

/* Free with tradeoff_free. A basis that the mesh does not have is dropped, unless none is left.
 * THRUM_BAD_VALUE when the load moves nothing in the time; THRUM_INTERRUPTED when progress says so.
 */
thrum_status tradeoff_solve(const tradeoff_problem *problem, tradeoff_result *result,
                            thrum_error *error);
void tradeoff_free(tradeoff_result *result);

/* The recipes of a problem and then those that the search may go on with, at most
 * TRADEOFF_BASES_MAX; returns how many. */
int64_t tradeoff_recipes(const tradeoff_problem *problem, tradeoff_recipe *recipes);

/* A basis with cubature points in place of the polynomial for each error of the force, into
 * `recipes`, which has room for TRADEOFF_POINTS_MAX; returns how many. None where the polynomial is
 * tried too and a force by it is likely to be cheaper (thrum_cubature_cost). */
int64_t tradeoff_points(const tradeoff_problem *problem, const tradeoff_recipe *basis,
                        tradeoff_recipe *recipes);

/* Solves one recipe: a result of its basis and the condensed ones of it alone, none of them
 * chosen. Or the full order of a test alone, which is kept where the problem says. */
thrum_status tradeoff_solve_recipe(const tradeoff_problem *problem, const tradeoff_recipe *recipe,
                                   tradeoff_result *result, thrum_error *error);
thrum_status tradeoff_solve_test(const tradeoff_problem *problem, int64_t test, thrum_error *error);

/* How coefficients are stored, "double" or "single"; gradients of points are single. */
const char *tradeoff_precision(const tradeoff_basis *basis);

/* The status that `thrum simulate` flags a run with; NULL: none. */
const char *tradeoff_flag(const tradeoff_run *run);

/* Why a run is not taken under these bounds, or comes last: "lost", "condensed too far", "error too
 * large", "too dear", "errors cancel", or how it is flagged; NULL: nothing speaks against it. */
const char *tradeoff_barred(const tradeoff_result *result, const tradeoff_run *run, double error,
                            double cost);

/* The cheapest run whose error, by which it is judged, is at most `error`, or the most accurate
 * whose cost is at most `cost`; NaN: no limit, but one of them must be a number. One whose basis is
 * no worse than that either goes before one that owes it to errors that cancel, and then one that
 * is not flagged before one that is. -1: there is none. */
int64_t tradeoff_choose(const tradeoff_result *result, double error, double cost);

/* The runs as comma-separated values, one row for each, with what bars each under the bounds. */
void tradeoff_csv(FILE *stream, const tradeoff_result *result, double error, double cost);

#endif
