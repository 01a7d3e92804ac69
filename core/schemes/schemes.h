/* What the core asks of a scheme, and of what stands above the core: one row for each scheme, and
 * the hooks that others have in a step and in the life of a state. The library that is linked has
 * one const table of them, thrum_schemes; core/alone.c has that of the core alone. Each list of
 * hooks ends with NULL, is called in its order, and is NULL itself where there is none. Private to
 * libthrum, see schemes.c.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_SCHEMES_SCHEMES_H
#define THRUM_CORE_SCHEMES_SCHEMES_H

#include "core/schemes/mode_factor.h"
#include "core/solve/implicit_problem.h"

typedef struct thrum_step_run thrum_step_run;

/* --- schemes ---------------------------------------------------------------------------------- */

/* How many there are. */
#define THRUM_ONE_MORE(name, value, text) +1
enum { THRUM_SCHEMES = 0 THRUM_SCHEME_LIST(THRUM_ONE_MORE) };
#undef THRUM_ONE_MORE

/* A scheme. Members that are NULL, false or 0 are as those of the step of design 5: momenta of the
 * first modes half a step before q, all of the increment damped, no solve to be continued. */
/* The start of a step, and R there: vectors of the state. */
typedef struct thrum_known_start {
  const double *q, *p, *force;
} thrum_known_start;

typedef struct thrum_scheme_row {
  thrum_scheme scheme;

  /* The integrator that begins with it, and the split form of the def; -1: any. verlet and midpoint
   * begin with that of imexv's thesis form. */
  thrum_integrator integrator;
  int form;

  /* What it keeps from step to step besides q and p. */
  bool carries_acceleration; /* of Newmark */
  bool keeps_nothing;        /* no inverse of a Jacobian either */
  bool velocity_by_dt; /* what it stores for p is a velocity of its own, which depends on dt */
  bool restricts;      /* V is restricted to the implicit modes, where both kinds are there */
  bool is_explicit;    /* no mode is implicit, whatever the split says */

  /* Changes the sizes of the arrays in the header, all of them filled in but `bytes`. */
  void (*plan)(const thrum_model *model, thrum_state *state);

  /* One step: candidates into the view, nothing that persists is written. THRUM_OK,
   * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
  thrum_status (*step)(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                       thrum_solve_report *report);

  /* How a step turns the linear mode i, where z is h omega. */
  thrum_mode_factor (*frequency)(const thrum_model *model, const thrum_state *state, int32_t i,
                                 double z);

  /* The problem whose first guess extrapolates past solves and whose inverse is kept, without kick
   * and drift; false where there is none. */
  bool (*problem)(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                  thrum_solve_report *report, thrum_solver *s);

  /* Momenta that are stored in another way than half a step before q: as
   * thrum_staggered_synchronise and thrum_staggered_unsynchronise. */
  thrum_status (*synchronise)(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, double *potential);
  thrum_status (*unsynchronise)(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, const double *q, double *p);

  /* How many of the first modes have a rule of their own, and the a and b of their dissipation
   * a D b / h (dissipation.c). */
  int32_t (*own_modes)(const thrum_model *model, const thrum_state *state);
  thrum_damped_part (*damped)(const thrum_model *model, const thrum_state *state,
                              const thrum_state_view *view, int32_t i);

  /* How mode i moves under a force in a step that is linear about rest; `own` is own_modes, or 0.
   * NULL: explicit below the split, by the midpoint rule from it on. */
  thrum_mode_answer (*answer)(const thrum_model *model, const thrum_state *state, int32_t own,
                              int32_t i);

  /* Where the next step starts and R there, which the last one has left, unless its load jumps;
   * false where they are not known. NULL: they never are. */
  bool (*start)(const thrum_state *state, const thrum_state_view *view, thrum_known_start *start);

  /* Kinetic energy beyond that of p [J]. */
  double (*kinetic)(const thrum_model *model, const double *q, const double *p);
} thrum_scheme_row;

/* The time steps that the energy integrator gives slow modes: their frequency is then that of the
 * body. NULL in a library that has none: all modes have dt. */
typedef struct thrum_mode_steps {
  /* Finds the modes that are not matched, and notes them in the header. */
  void (*find)(const thrum_model *model, thrum_state *state);

  /* How many of the first modes may be matched with the dt of the state. */
  int32_t (*count)(const thrum_model *model, const thrum_state *state);

  /* How mode i, one of them, is stepped; and the first `count` modes, into three vectors. */
  thrum_matched_step (*of)(const thrum_model *model, const thrum_state *state, int32_t i);
  void (*all)(const thrum_model *model, const thrum_state *state, int32_t count, double *stretch,
              double *inverse, double *speed);
} thrum_mode_steps;

/* --- hooks ------------------------------------------------------------------------------------ */

/* A state: refuses a def; changes sizes in the header as a row does; fills what follows from the
 * model in a new state; forgets what is known of the steps so far, and of the last one alone. */
typedef thrum_status (*thrum_on_check)(const thrum_model *model, const thrum_state_def *def,
                                       thrum_error *error);
typedef void (*thrum_on_plan)(const thrum_model *model, thrum_state *state);
typedef void (*thrum_on_made)(const thrum_model *model, thrum_state *state);
typedef void (*thrum_on_forget)(thrum_state *state);

/* Where a state is set to another place: before, and there. */
typedef void (*thrum_on_moved)(const thrum_model *model, thrum_state *state);

/* The model as a state that belongs to it sees it: the model, or `copy` with what the state has. */
typedef const thrum_model *(*thrum_on_seen)(const thrum_model *model, thrum_state *state,
                                            thrum_model *copy);

/* A step. `load` adds forces to run->view.load, in an array of its own. `before` may change the
 * scheme and what goes with it, and so may `sample`, from a product that it has asked for by
 * run->samples and makes itself unless product_there; after a failure of either, the step goes on
 * as if no `before` had been called. */
typedef void (*thrum_on_load)(const thrum_model *model, thrum_step_run *run);
typedef thrum_status (*thrum_on_before)(const thrum_model *model, thrum_step_run *run);
typedef thrum_status (*thrum_on_sample)(const thrum_model *model, thrum_step_run *run,
                                        bool product_there);

/* After the kick of staggered modes, with their force in view->force and V(q_k). */
typedef void (*thrum_on_kicked)(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, double potential,
                                thrum_solve_report *report);

/* After an attempt, which may have failed: true where the step is to be attempted again with what
 * was changed. `solved` is asked once candidates and dissipation are known; *status < 0: what was
 * changed failed. `settle` may lead a step that failed to candidates; returns the failure where it
 * does not. */
typedef bool (*thrum_on_attempt)(const thrum_model *model, thrum_step_run *run,
                                 thrum_status *status);
typedef thrum_status (*thrum_on_settle)(const thrum_model *model, thrum_step_run *run,
                                        thrum_status failure);

/* Candidates that will be committed: of a step of a body alone, of one that exchanges energy with
 * what the state does not have; then, of both, what is written beside them. */
typedef void (*thrum_on_accepted)(const thrum_model *model, thrum_step_run *run);

/* After the commit. */
typedef void (*thrum_on_committed)(const thrum_model *model, thrum_state *state,
                                   const thrum_state_view *view);

typedef struct thrum_scheme_set {
  const thrum_scheme_row *rows[THRUM_SCHEMES]; /* by thrum_scheme; NULL: the library lacks it */
  const thrum_mode_steps *mode_steps;
  bool adapts, falls_back; /* what `adaptive` and `fallback` of a def ask for is there */

  const thrum_on_check *check;
  const thrum_on_plan *plan;
  const thrum_on_made *made;
  const thrum_on_forget *forget, *forget_step;
  const thrum_on_moved *leave, *arrive;
  thrum_on_seen seen;

  const thrum_on_load *load;
  const thrum_on_before *before;
  const thrum_on_sample *sample;
  const thrum_on_kicked *kicked;
  const thrum_on_attempt *after_attempt, *solved;
  const thrum_on_settle *settle;
  const thrum_on_accepted *accepted, *coupled, *keep;
  const thrum_on_committed *committed;
} thrum_scheme_set;

/* The table of the library. */
extern const thrum_scheme_set thrum_schemes;

/* Calls each hook of a list. */
#define THRUM_CALL_HOOKS(type, list, ...)                                                          \
  for (const type *hook_ = thrum_schemes.list; hook_ && *hook_; hook_++)                           \
  (*hook_)(__VA_ARGS__)

/* --- questions -------------------------------------------------------------------------------- */

/* The row of the scheme that a state is stepped by. */
static inline const thrum_scheme_row *thrum_row_of(const thrum_state *state) {
  return thrum_schemes.rows[state->scheme];
}

/* True for the schemes that carry an acceleration from step to step; of the others it is zero. */
static inline bool thrum_carries_acceleration(const thrum_state *state) {
  return thrum_row_of(state)->carries_acceleration;
}

/* The model as a state sees it; `copy` holds as long as both do. */
static inline const thrum_model *thrum_seen_model(const thrum_model *model, thrum_state *state,
                                                  thrum_model *copy) {
  return thrum_schemes.seen ? thrum_schemes.seen(model, state, copy) : model;
}

/* Whether a state is stepped by the scheme that its def begins with. */
static inline bool thrum_is_first_scheme(const thrum_state *state) {
  const thrum_scheme_row *row = thrum_row_of(state);
  const thrum_state_def *def = &state->def;
  if (row->integrator == def->integrator)
    return row->form < 0 || row->form == (int)def->split_form;
  return state->scheme == THRUM_SCHEME_THESIS && (def->integrator == THRUM_INTEGRATOR_VERLET ||
                                                  def->integrator == THRUM_INTEGRATOR_MIDPOINT);
}

/* The scheme that a state of this def begins with, -1 where the library lacks it. */
int thrum_first_scheme(const thrum_state_def *def);

#endif
