/* The state's block, private to the runtime: one header, then arrays at offsets that follow from
 * the sizes in the header; no pointer is stored (see thrum/state.h).
 *
 * The block ends with scratch, of any content between calls. What lies before it persists: a failed
 * step leaves it as it was, and equal histories give equal bytes there.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_DYNAMICS_STATE_PRIVATE_H
#define THRUM_RUNTIME_DYNAMICS_STATE_PRIVATE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/state.h"

/* How many inverses of Jacobians are kept. */
#define THRUM_INVERSES 3

/* Widest fields first and none missing: no padding, so blocks can be compared byte by byte. */
struct thrum_state {
  uint64_t magic;
  uint64_t bytes;                  /* of the whole block */
  int64_t work_count;              /* doubles in `work` */
  int64_t restricted_count;        /* doubles in `restricted` */
  int64_t kept_count;              /* doubles in each of `inverses` */
  int64_t next_count;              /* doubles in `jacobian_next` */
  int64_t tangent_count;           /* doubles in `tangent` */
  int64_t steps;                   /* report */
  int64_t iterations;              /* report */
  int64_t factorisations;          /* report */
  int64_t newton_steps;            /* report */
  int64_t energy_steps;            /* report */
  int64_t substep_steps;           /* report */
  int64_t switched_steps;          /* report */
  int64_t split_changes;           /* report */
  int64_t scheme_switches;         /* report */
  int64_t corrections;             /* report */
  double time;                     /* report [s] */
  double residual_last;            /* report */
  double dt;                       /* h [s] */
  double damping_alpha;            /* [1/s] */
  double damping_beta;             /* [s] */
  double split_safety;             /* c of h omega <= 2 c */
  double newmark_beta;             /* beta_N */
  double newmark_gamma;            /* gamma */
  double tolerance;                /* of the implicit solve */
  double stability_number_last;    /* report */
  double stability_number_peak;    /* report */
  double balance_last;             /* report */
  double balance_peak;             /* report */
  double corrected;                /* report [J] */
  double quiet_peak;               /* largest angle of the whole set since the last look */
  double switched_energy;          /* when design 7 took over [J] */
  double stability_work;           /* of the load less dissipation, since the reset [J] */
  double stability_moved;          /* by load and damping in this window, magnitudes [J] */
  double stability_recent;         /* the same over the last steps, load_jump included [J] */
  double stability_scale;          /* largest energy in this window [J] */
  double stability_scale_before;   /* in the window before */
  double stability_sum;            /* of the balance in this window [J] */
  double stability_reference;      /* what its mean is compared with [J] */
  double stability_steady;         /* what the balance less the shadow is compared with [J] */
  double stability_off;            /* sum of what the means were off by since then [J] */
  double stability_spent;          /* net of the corrections since then [J] */
  double stability_energy_error;   /* correction to come [J] */
  double target_energy;            /* what the energy is to be in design 7 [J], */
  double energy_correction_carry;  /* and what its sums were rounded by */
  double energy_correction_moved;  /* in and out since it was opened, magnitudes [J] */
  int64_t energy_correction;       /* thrum_energy_correction */
  int64_t energy_correction_begin; /* step at which it was opened */
  int64_t stability_samples;       /* of the balance in this window */
  int64_t stability_windows;       /* since the reference */
  int64_t stability_window_end;    /* step */
  int64_t watch_deadline;          /* step of a hand-over to come, 0: none */
  int64_t kept_step;               /* of q_kept and p_kept, -1: none */
  int64_t quiet_end;               /* step of the next look at a return */
  int64_t eager_end;               /* step up to which solves make their Jacobian at once */
  /* Whose Jacobian each of `inverses` is that of, the latest first, -1: of several steps, or that
   * there is none. */
  int64_t inverse_step[THRUM_INVERSES];
  int64_t path_end;        /* energy: step up to which the mean force is that of the path */
  int64_t past_ends;       /* energy: 1 where past_q and past_r are those of the ends */
  int64_t potential_step;  /* of `potential`, -1: none */
  double potential;        /* V(q) [J] */
  double guess_last;       /* residual of the last first guess, relative to the step */
  double amplitude;        /* largest scaled norm of the motion so far, design 5 */
  int32_t rank;            /* r */
  int32_t integrator;      /* thrum_integrator */
  int32_t damping_form;    /* thrum_damping_form */
  int32_t split_rule;      /* thrum_split_rule */
  int32_t explicit_count;  /* of the def, for THRUM_SPLIT_COUNT */
  int32_t iterations_max;  /* of one implicit solve */
  int32_t split;           /* E = 0..split-1, I = split..rank-1, now */
  int32_t high_first;      /* I0 = high_first..rank-1, fixed for the run */
  int32_t jacobian_kept;   /* 1: `inverse` is one for the present split and dt */
  int32_t past_count;      /* how many steps of past_q and past_r are known */
  int32_t iterations_last; /* report */
  int32_t split_form;      /* of the def */
  int32_t scheme;          /* thrum_scheme, now */
  int32_t adaptive;        /* of the def */
  int32_t fallback;        /* of the def */
  int32_t kernel;          /* thrum_kernel_id of the def */
  int32_t inverse_place;   /* of the latest among `inverses` */
  int32_t unused;          /* zero, so that there is no padding */
};

_Static_assert(sizeof(thrum_state) == offsetof(thrum_state, unused) + sizeof(int32_t),
               "there is padding at the end");

/* Arrays that persist. X(name, size): a vector is rank long; the others as *_count says. */
#define THRUM_STATE_ARRAYS(X)                                                                      \
  X(q, vector)            /* q_k */                                                                \
  X(p, vector)            /* p^-_k on E (before the kick), synchronised p_k on I; v for Newmark */ \
  X(load, vector)         /* mean load of the steps to come, f_k */                                \
  X(load_before, vector)  /* of the step before, f_{k-1} */                                        \
  X(acceleration, vector) /* Newmark: a, taken with load_before */                                 \
  X(guide, vector)        /* of the power iteration on the explicit modes now */                   \
  X(guide_whole, vector)  /* and on those of the def */                                            \
  X(q_kept, vector)       /* synchronised state before the last step, for the watch */             \
  X(p_kept, vector)                                                                                \
  X(past_q, past)      /* where the last THRUM_PAST solves ended: q + at d, for the first guess */ \
  X(past_r, past)      /* and R there; those of step k at thrum_past_at(view, k) */                \
  X(force_now, vector) /* energy: R(q_k), where potential_step says that it is known */            \
  X(inverses, inverses) /* of the Jacobian of the steps before, |I| x |I|, symmetric, and those */ \
                        /* made anew before it, where the view's `inverse` says */

/* Scratch: any content when a call begins. */
#define THRUM_STATE_SCRATCH(X)                                                                     \
  X(q_next, vector)            /* candidate of q' */                                               \
  X(p_next, vector)            /* candidate of p'; p^+ on E */                                     \
  X(acceleration_next, vector) /* Newmark: a' */                                                   \
  X(force, vector)             /* R(q_k), later R(q-bar); energy: E in the end */                  \
  X(middle, vector)            /* where an implicit step evaluates the model: q-bar, or q' */      \
  X(velocity, vector)          /* the velocity there */                                            \
  X(product, vector)           /* T times velocity */                                              \
  X(unknown, vector)           /* of the solve: q' - q on I */                                     \
  X(trial, vector)             /* an unknown or a residual to compare with */                      \
  X(residual, vector)          /* of the solve */                                                  \
  X(direction, vector)         /* Newton's correction */                                           \
  X(image, vector)             /* the one to come */                                               \
  X(scale, vector)             /* Jacobian at rest, the scale of a mode's residual */              \
  X(unscale, vector)           /* 1/scale */                                                       \
  X(kick, vector)              /* of the solve: what d is without forces */                        \
  X(drift, vector)             /* of the solve: the velocity for d = 0 */                          \
  X(total, vector)             /* R + D v - f at the middle */                                     \
  X(q_start, vector)           /* q of a step redone */                                            \
  X(p_kept_next, vector)       /* synchronised p at the start of the step */                       \
  X(p_start, vector)           /* p as another scheme has it */                                    \
  X(p_level, vector)           /* synchronised p on a fallback level */                            \
  X(q_sub, vector)             /* between sub-steps */                                             \
  X(p_sub, vector)                                                                                 \
  X(acceleration_sub, vector)                                                                      \
  X(guide_next, vector)                                                                            \
  X(guide_whole_next, vector)                                                                      \
  X(point, vector)          /* where energy evaluates the model */                                 \
  X(point_2, vector)        /* and its second point */                                             \
  X(force_2, vector)        /* R there; energy: R(q') in the end */                                \
  X(force_start, vector)    /* energy: R(q_k) */                                                   \
  X(bordered, vector)       /* energy: J0^-1 (q' - q) */                                           \
  X(slope, vector)          /* energy: h^2/2 |d|^2 grad(sigma) + J0 d */                           \
  X(pivots_next, vector)    /* int32: of jacobian_next */                                          \
  X(work, work)             /* of the polynomial */                                                \
  X(restricted, restricted) /* V at fixed q_E, a quartic in q_I */                                 \
  X(pairs, pairs)           /* corrections of the inverse learnt in this step */                   \
  X(jacobian_next, next)    /* Jacobian, factors or inverse made in this step */                   \
  X(tangent, tangent)       /* T(q), rank x rank, for the tangent form of damping */               \
  X(tangent_2, tangent)     /* a second one */

/* Pointers into a state's block, made anew in every call. */
typedef struct thrum_state_view {
#define X(name, size) double *name;
  THRUM_STATE_ARRAYS(X)
  THRUM_STATE_SCRATCH(X)
#undef X
  double *inverse[THRUM_INVERSES];   /* the latest first */
  const struct thrum_kernel *kernel; /* the one asked for, or the best one here */
  const double *restricted_from;     /* not NULL: where a batch has what restricted is to hold, */
  int64_t restricted_stride;         /* at every so many doubles */
  int64_t stride;                    /* of vectors one after the other in an array */
  bool guided;                       /* by whoever writes guide_next */
} thrum_state_view;

typedef enum thrum_fallback_level {
  THRUM_FALLBACK_NONE = 0, /* quasi-Newton or full Newton */
  THRUM_FALLBACK_ENERGY,
  THRUM_FALLBACK_SUBSTEPS
} thrum_fallback_level;

/* How the account of the energy stands. */
typedef enum thrum_energy_correction {
  THRUM_ENERGY_CORRECTION_CLOSED = 0, /* nothing is known */
  THRUM_ENERGY_CORRECTION_BALANCED,   /* nothing was energy_error when it was last looked at */
  THRUM_ENERGY_CORRECTION_PENDING     /* looked at in every step */
} thrum_energy_correction;

typedef enum thrum_stability_decision {
  THRUM_DECISION_CONTINUE = 0,
  THRUM_DECISION_SWITCH, /* design 7 takes this step and those to come */
  THRUM_DECISION_REDO    /* and the one before */
} thrum_stability_decision;

/* What a solve did; committed to the report with the step. */
typedef struct thrum_solve_report {
  int32_t iterations;
  int32_t factorisations;
  bool newton;       /* full Newton was needed */
  bool slow;         /* quasi-Newton found too late that it needs its Jacobian anew */
  bool verified;     /* R was evaluated at the increment found */
  bool solved;       /* the increment came from a solve: the next guess may go on from it */
  bool refreshed;    /* jacobian_next replaces inverse, */
  bool extrapolated; /* or has stood in for it */
  int32_t learnt;    /* pairs to be folded into it */
  double guess;      /* scaled residual of the first guess, relative to the scaled step */
  double reached;    /* the same of the last evaluation */
  bool ends;         /* energy: the mean force was that of the ends */
  bool path;         /* energy: the mean force of the ends led nowhere */
  bool saw_nonfinite;
  bool potential_known;
  bool energy_known;
  bool energy_ahead; /* it is that of the end of the step, less what the step's work added */
  bool load_jumped;  /* a sudden load has spoilt the step */
  thrum_fallback_level fallback_level;
  double residual;               /* scaled, relative to the scaled step */
  double potential;              /* V(q'), where potential_known [J] */
  double potential_start;        /* energy: V(q) [J] */
  double inverse_square;         /* energy: 1/|d|^2 for it */
  double along_step;             /* energy: sigma, what the mean force has along d [s^-2] */
  double bordered;               /* energy: J0^-1 d along h^2/2 grad(sigma) */
  double energy;                 /* at the start of the step, for the watch [J] */
  double energy_scale;           /* what a hand-over of one of these two compares with later [J] */
  double modified_energy;        /* what Stoermer-Verlet's own energy is below it [J] */
  double modified_energy_change; /* what the load of the step to come adds to that [J] */
} thrum_solve_report;

/* How many solves the first guess remembers. */
#define THRUM_PAST 5

/* Where those arrays have step k. */
static inline int64_t thrum_past_at(const thrum_state_view *view, int64_t k) {
  return (k % THRUM_PAST + THRUM_PAST) % THRUM_PAST * view->stride;
}

/* How many modes have their momentum half a step late: the first so many. */
static inline int32_t thrum_staggered(const thrum_state *state) {
  return state->scheme == THRUM_SCHEME_QUADRATIC ? state->rank : state->split;
}

/* True for D = alpha 1 + beta T(q) with beta > 0. */
static inline bool thrum_tangent_damped(const thrum_state *state) {
  return state->damping_form == THRUM_DAMPING_TANGENT && state->damping_beta != 0.0;
}

/* alpha + beta omega_i^2 */
static inline double thrum_rest_damping(const thrum_model *model, const thrum_state *state,
                                        int64_t i) {
  return state->damping_alpha + state->damping_beta * model->omega2[i];
}

/* state.c: pointers to the arrays. */
thrum_state_view thrum_state_view_of(thrum_state *state);

/* Scratch of somebody else in place of the state's own, each NULL for that. `work` and `restricted`
 * may be shared with other states: each use fills them anew. */
typedef struct thrum_lent {
  double *work, *restricted;
  double *vectors; /* thrum_lent_vectors(rank) doubles, aligned to 64: the vectors, and pairs */
} thrum_lent;

/* state.c */
int64_t thrum_lent_vectors(int64_t rank);
void thrum_state_lend(thrum_state_view *view, const thrum_lent *lent);

/* state.c: refuses NULL, memory that is no state, and a model of another rank. */
thrum_status thrum_state_check(const thrum_model *model, const thrum_state *state,
                               thrum_error *error);

/* state.c: are all n values finite? */
bool thrum_all_finite(const double *values, int64_t n);

/* state.c: scaled norm of a motion (design 5), in the measure of the residuals of a solve:
 * sqrt(sum_I (1 + h^2/4 omega^2) q^2 + sum_E h^2/4 omega^2 q^2 + h^2 |p|^2). */
double thrum_state_amplitude(const thrum_model *model, const thrum_state *state, const double *q,
                             const double *p);

/* state_def.c: says what is wrong with what every evaluation needs of a model. */
thrum_status thrum_state_check_model(const thrum_model *model, thrum_error *error);

/* state_def.c: says what is wrong with a def or with the model's sizes. */
thrum_status thrum_state_def_check(const thrum_model *model, const thrum_state_def *def,
                                   thrum_error *error);

/* split.c: number of explicit modes by a rule, and |E| of a state at its dt. */
int32_t thrum_split_explicit(const thrum_model *model, thrum_split_rule rule, double dt,
                             double safety, int32_t count);
int32_t thrum_split_of(const thrum_model *model, const thrum_state *state);

/* stagger.c: what pushes the explicit modes at q into their entries of force: R, less kappa q in
 * the quadratic split. Returns V(q). */
double thrum_stagger_force(const thrum_model *model, const thrum_state *state,
                           thrum_state_view *view, const double *q);

/* stagger.c: kick of the explicit modes (2), p^+_E into p_next. Needs that force at q_k.
 * THRUM_OK or THRUM_SINGULAR. */
thrum_status thrum_stagger_kick(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view);

/* stagger.c: synchronised momentum of all modes into p_next; V(q) into *potential if not NULL.
 * Overwrites force. THRUM_OK or THRUM_SINGULAR. */
thrum_status thrum_stagger_synchronise(const thrum_model *model, const thrum_state *state,
                                       thrum_state_view *view, double *potential);

/* stagger.c: turns the explicit part of `p` (rank, synchronised) into p^-_E at `q`, for the state's
 * dt and split and the load of the step before (NULL: zero). Overwrites force and product. */
void thrum_stagger_delay(const thrum_model *model, const thrum_state *state, thrum_state_view *view,
                         const double *q, const double *load_before, double *p);

/* One step each: candidates into q_next and p_next (Newmark also acceleration_next; after a solve
 * also middle, force, pairs and, when refreshed, jacobian_next); nothing persistent is written.
 * THRUM_OK, THRUM_NOT_CONVERGED or THRUM_NOT_FINITE. */
thrum_status thrum_step_imexv(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_step_quadratic(const thrum_model *model, const thrum_state *state,
                                  thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_step_energy(const thrum_model *model, const thrum_state *state,
                               thrum_state_view *view, thrum_solve_report *report);
thrum_status thrum_step_newmark(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, thrum_solve_report *report);

/* A step in four parts, so that a batch can make many samples and attempts together. */
typedef struct thrum_step_run {
  thrum_state *state;
  thrum_state next; /* the header to be */
  thrum_state_view view;
  double *q, *p; /* the state's own; the view may come to have others */
  thrum_solve_report report;
  bool samples; /* the watch wants a product: see thrum_stability_before */
} thrum_step_run;

/* step.c: checks the state and lets the watch begin; lent may be NULL. Not THRUM_OK: there is
 * nothing to end. */
thrum_status thrum_step_begin(const thrum_model *model, thrum_state *state, const thrum_lent *lent,
                              thrum_step_run *run, thrum_error *error);

/* step.c: lets the watch choose the scheme, run->next.scheme; with the product that it wants, or
 * makes it. */
void thrum_step_monitor(const thrum_model *model, thrum_step_run *run, bool product_there);

/* step.c: one step of that scheme: candidates, as thrum_step_imexv. */
thrum_status thrum_step_attempt(const thrum_model *model, thrum_step_run *run);

/* step.c: from the attempt's status on: the watch, the fallback, the commit. */
thrum_status thrum_step_end(const thrum_model *model, thrum_step_run *run, thrum_status attempted,
                            thrum_error *error);

/* watch.c: forgets what the balance was compared with. */
void thrum_stability_reset(thrum_state *state);

/* watch.c: before a step; `state` is the header to be. May change its scheme and split, and then
 * points view->p at the momentum that goes with them. Not THRUM_OK: that could not be done. Where
 * *samples is set, T_EE times view->direction is wanted in view->product, which multiply puts
 * there; then sample goes on, and may change the same. */
thrum_status thrum_stability_before(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, bool *samples);
void thrum_stability_multiply(const thrum_model *model, const thrum_state *state,
                              thrum_state_view *view);
thrum_status thrum_stability_sample(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view);

/* watch.c: the energy at q_k for the report, with V(q_k) and the explicit force in view->force. */
void thrum_stability_energy(const thrum_model *model, const thrum_state *state,
                            thrum_state_view *view, double potential, thrum_solve_report *report);

/* watch.c: after a solved step, whose candidates are in the view. Without explicit modes no stage 1
 * has the energy; then that at the end, for the report. With them, and a load that has just changed
 * much, whether that has spoilt the step. */
void thrum_stability_ahead(const thrum_model *model, thrum_state *state, thrum_state_view *view,
                           thrum_solve_report *report);

/* watch.c: takes the energy in, where it is known. */
thrum_stability_decision thrum_stability_judge(thrum_state *state,
                                               const thrum_solve_report *report);

/* watch.c: makes the header and the view those of design 7; after THRUM_DECISION_REDO with the step
 * before this one redone. Clears the report. */
thrum_status thrum_stability_switch(const thrum_model *model, thrum_state *state,
                                    thrum_state_view *view, thrum_stability_decision decision,
                                    thrum_solve_report *report);

/* watch.c: work and dissipation of a solved step. */
void thrum_stability_after(const thrum_model *model, thrum_state *state,
                           const thrum_state_view *view);

/* energy correction.c: opens the account with the energy that is to be [J], or closes it. */
void thrum_energy_correction_open(thrum_state *state, double energy);
void thrum_energy_correction_close(thrum_state *state);

/* energy correction.c: enters a solved step of design 7; may scale view->p_next by what is
 * energy_error. */
void thrum_energy_correction_after(const thrum_model *model, thrum_state *state,
                                   thrum_state_view *view, const thrum_solve_report *report);

/* energy correction.c: gives imexv's momentum what is *energy_error* [J] where its kinetic energy
 * is `least` or more; then view->p is view->p_start and *energy_error zero. */
thrum_status thrum_energy_correction_apply(const thrum_model *model, thrum_state *state,
                                           thrum_state_view *view, double least,
                                           double *energy_error);

/* fallback.c: the fallback levels after full Newton, for a step that ended in `failure`; returns
 * that where there are none. */
thrum_status thrum_fallback_run(const thrum_model *model, thrum_state *state,
                                thrum_state_view *view, thrum_status failure,
                                thrum_solve_report *report);

/* newmark.c: a = -R(q) - D v, without a load, into `acceleration`. Overwrites force, product. */
void thrum_newmark_acceleration(const thrum_model *model, const thrum_state *state,
                                thrum_state_view *view, const double *q, const double *v,
                                double *acceleration);

/* Residuals below this times the amplitude seen so far are rounding (design 5). */
#define THRUM_ROUNDING_FLOOR 0x1p-44

#endif
