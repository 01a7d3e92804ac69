/* The memory of a state, private to libthrum: one header, then arrays at offsets that follow
 * from the sizes in the header. No pointer is stored, so a copy of the bytes is a state
 * (thrum/state.h).
 *
 * The block ends with scratch, of any content between calls, or with a pointer to scratch that the
 * state borrows. The bytes before it persist: a step that fails leaves them as they were, and equal
 * histories give equal bytes.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STATE_STATE_LAYOUT_H
#define THRUM_CORE_STATE_STATE_LAYOUT_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "thrum/state.h"

/* How many inverses of Jacobians are kept for the extrapolation of the next one. */
#define THRUM_INVERSES 3

/* How many solves the first guess may extrapolate. */
#define THRUM_PAST_SOLVES 5

/* The version of the header and the arrays below; it is raised with each change of them, so that a
 * snapshot of another version is known. */
#define THRUM_STATE_VERSION 20

/* --- the header ------------------------------------------------------------------------------- */

/* The memory of the stability monitor of imexv (design 4). The balance B is the energy less the
 * work of the load plus the dissipation; it would be constant without errors of the scheme. */
typedef struct thrum_stability_monitor {
  double work;          /* of the load less the dissipation, since the reference was set [J] */
  double moved;         /* magnitudes of work and dissipation in this window [J] */
  double recent;        /* dissipation of the last steps, fading [J] */
  double scale;         /* largest energy in this window [J] */
  double scale_before;  /* and in the window before [J] */
  double motion;        /* largest energy of a step's increment in this window [J] */
  double motion_before; /* and in the window before [J] */

  /* The means of the windows. */
  double balance_sum;        /* of B over the samples of this window [J] */
  double reference;          /* what the mean of B is compared with [J] */
  double modified_reference; /* what B less the modified Hamiltonian's part is compared with [J] */
  double drift_sum;          /* errors of the means since then; before it stands, the means [J] */
  double block_sum;          /* the same in this block, as shares of the energy, */
  double block_square;       /* and their squares */

  /* Corrections and switches. */
  double corrected;       /* net of the corrections since then [J] */
  double energy_error;    /* correction that is still to be made [J] */
  double quiet_peak;      /* largest stability number of the def's explicit set, for a return */
  double switched_energy; /* when the energy integrator took over [J] */
  double number_rate;     /* largest change of the stability number a step, lately, as a share */
  double middle_balance;  /* position form: the balance in the middle of the last step whose
                             energy was evaluated [J] */

  /* Counters and steps. */
  int64_t samples;         /* of the balance in this window */
  int64_t windows;         /* since the reference was set; -1: the next energy is the reference */
  int64_t window_end;      /* step */
  int64_t drifting;        /* 1: the means have drifted since the reference was set */
  int64_t switch_deadline; /* step of a switch to come, 0: none */
  int64_t energy_step;     /* step of the energy that was entered last */
  int64_t sample_step;     /* step of the last sample of the stability number; -1: none */
  int64_t before_step;     /* step of q_before and p_before, -1: none */
  double before_dt;        /* and its length [s] */
  int64_t quiet_end;       /* step of the next look at a return */
} thrum_stability_monitor;

typedef enum thrum_energy_correction {
  THRUM_ENERGY_CORRECTION_CLOSED = 0, /* there is no target */
  THRUM_ENERGY_CORRECTION_BALANCED,   /* the energy was on target when last compared */
  THRUM_ENERGY_CORRECTION_PENDING     /* an error is outstanding: compared in every step */
} thrum_energy_correction;

/* Target energy of the energy-conserving scheme (energy_correction.h). */
typedef struct thrum_energy_target {
  double energy;  /* [J] */
  double carry;   /* rounding of its sum [J] */
  double moved;   /* magnitudes of work and dissipation since it was set [J] */
  int64_t status; /* thrum_energy_correction */
  int64_t begin;  /* step at which it was set */
} thrum_energy_target;

/* The energy that unverified corrections move between low and high modes, [0] and [1]
 * (spurious_work.h). */
typedef struct thrum_spurious_work {
  double work;        /* in this window, estimated [J] */
  double square;      /* sum of the squares of its samples [J^2] */
  double energy[2];   /* sum of 1/2 (p^2 + omega^2 q^2) over its samples [J] */
  int64_t samples;    /* in this window */
  int64_t window_end; /* step */
  int64_t halvings;   /* of the tolerance */
  int64_t quiet;      /* windows until one of them is taken back */
  int64_t wait;       /* windows that it takes, doubled each time that the work is too much */
} thrum_spurious_work;

/* The energy balance of the other integrators (energy_balance.h). */
typedef struct thrum_energy_balance {
  double explained; /* energy at the beginning, plus work of the loads, less dissipation [J] */
  double scale;     /* largest explained energy [J] */
  double moved;     /* magnitudes of the work of changing loads and of the dissipation [J] */
  double motion;    /* largest energy of a step's increment lately [J] */
  int64_t begin;    /* step at which it began; -1: the next one begins it */
  int64_t grew;     /* 1: the energy was far above the explained one at the last look */
} thrum_energy_balance;

/* Widest fields first and none missing: there is no padding, so that blocks can be compared byte by
 * byte. */
struct thrum_state {
  uint64_t magic;
  uint64_t bytes;            /* of the whole block */
  uint64_t identity;         /* of the model */
  thrum_state_def def;       /* adaptive is 0 but for imexv and fox-goodwin */
  thrum_state_report report; /* scheme and numbers of modes are filled in when asked for */
  thrum_stability_monitor monitor;
  thrum_energy_target target;
  thrum_spurious_work spurious;
  thrum_energy_balance balance;
  /* Bit i % 64 of entry i / 64: mode i follows a softer one (frequency_matching.h). */
  uint64_t following[(THRUM_RANK_MAX + 63) / 64];
  int64_t work_count;        /* doubles in `work` */
  int64_t restricted_count;  /* doubles in `restricted` */
  int64_t kept_count;        /* doubles in each of `inverses` */
  int64_t next_count;        /* doubles in `jacobian_next` */
  int64_t tangent_count;     /* doubles in `tangent` */
  int64_t plastic_count;     /* doubles in `plastic`; 0: none flows */
  int64_t shares_count;      /* doubles in `shares`, */
  int64_t shapes_count;      /* and in `shapes` */
  int64_t levels_count;      /* doubles in `levels`; 0: the model has no actuators */
  int64_t ahead_count;       /* doubles in `q_ahead`: rank, or 0 where no load asks for it */
  int64_t eager_end;         /* step up to which solves refresh their Jacobian at once */
  int64_t average_field_end; /* energy: step up to which it takes the average vector field */
  int64_t past_discrete;     /* energy: 1 where past_q, past_r are of the discrete gradient */
  int64_t potential_step;    /* step of `potential`, -1: none */
  int64_t jacobian_step;     /* energy: step in which the newest Jacobian was made, */
  int64_t jacobian_due;      /* and the one in which the next is planned */
  /* Step at which each of `inverses` was factored, newest first; -1: BFGS-updated or empty. */
  int64_t inverse_step[THRUM_INVERSES];
  int64_t split_end; /* step at which a lower split_dt may be taken */
  double split_dt;   /* the split is for this length of a step [s] (step_length.h) */
  double longest_dt; /* the longest step in force since split_end was set [s] */
  /* Lengths of the steps of past_q and past_r, in the order of the ring [s]. */
  double past_dt[THRUM_PAST_SOLVES];
  double potential;      /* V(q), or V(q_corrected) if that is carried [J] */
  double potential_end;  /* V(q_k) where that is carried [J] */
  double contraction;    /* energy: share of a residual that the inverse leaves, 0: not known */
  double step_recent;    /* energy: largest scaled norm of an increment lately */
  double guess_last;     /* residual of the last first guess, relative to the step */
  double amplitude;      /* largest scaled norm of the motion so far, design 5 */
  int32_t rank;          /* r */
  int32_t scheme;        /* thrum_scheme, now */
  int32_t split;         /* E = 0..split-1, I = split..rank-1, now */
  int32_t high_first;    /* the modes implicit at rest are high_first..rank-1, fixed for the run */
  int32_t jacobian_kept; /* 1: the newest inverse is one for the present split and dt */
  int32_t past_count;    /* how many of the past solves are known */
  int32_t inverse_place; /* of the newest among `inverses` */
  int32_t carried;       /* energy: 1: the next step starts from q_corrected, p_corrected */
  int32_t jacobian_interval; /* energy: steps between two planned Jacobians, 0: none yet */
  int32_t release_due;       /* 1: what the plastic strains have released is to be found again */
};

_Static_assert(sizeof(thrum_state_def) ==
                       offsetof(thrum_state_def, untrained_flow) + sizeof(int32_t) &&
                   sizeof(thrum_state_report) ==
                       offsetof(thrum_state_report, residual_last) + sizeof(double) &&
                   offsetof(thrum_state, report) ==
                       offsetof(thrum_state, def) + sizeof(thrum_state_def) &&
                   sizeof(thrum_state) == offsetof(thrum_state, release_due) + sizeof(int32_t),
               "there is padding in a state");

/* --- the arrays ------------------------------------------------------------------------------- */

/* Arrays that persist. X(name, size): a vector has rank entries; the others as *_count says. */
#define THRUM_STATE_ARRAYS(X)                                                                      \
  X(q, vector)              /* q_k */                                                              \
  X(p, vector)              /* p^-_k on E, before the kick; p_k on I; v for Newmark */             \
  X(load, vector)           /* mean load of the steps to come, f_k */                              \
  X(load_before, vector)    /* of the step before, f_{k-1} */                                      \
  X(acceleration, vector)   /* Newmark: a, taken with load_before */                               \
  X(plastic, plastic)       /* F_p^-1 - 1 of each cubature point, where the material may flow, */  \
                            /* and what was released by it (core/polynomial/points.h) */           \
  X(levels, levels)         /* of the actuators of its model, and what is kept of each beside */   \
  X(q_ahead, ahead)         /* q in the middle of the step to come, extrapolated */                \
  X(power_explicit, vector) /* iterate of the power iteration on the explicit modes now */         \
  X(power_whole, vector)    /* and on the explicit modes of the def */                             \
  X(q_before, vector)       /* q before the last step, for a step that is repeated */              \
  X(p_before, vector)       /* and the synchronised p */                                           \
  X(past_q, past)      /* q + at d of the past solves, for the first guess; the one of step */     \
                       /* k lies at thrum_past_at(view, k) */                                      \
  X(past_r, past)      /* and R there */                                                           \
  X(force_now, vector) /* energy: R there or at q_k, where potential_step says that it is known */ \
  X(q_corrected, vector) /* energy: start of the next step, where carried */                       \
  X(p_corrected, vector) /* and its p */                                                           \
  X(inverses, inverses)  /* of Jacobians, |I| x |I|, symmetric; order as inverse_place says */

/* Arrays of a state that follow from its model, filled when the state is made. */
#define THRUM_STATE_FIXED(X)                                                                       \
  X(shares, shares) /* of the stiffness that the cubature points have, where they flow, */         \
  X(shapes, shapes) /* and whose they are (runtime/points/point_rest.h) */

/* Scratch: any content when a call begins. */
#define THRUM_STATE_SCRATCH(X)                                                                     \
  X(q_next, vector)              /* candidate of q' */                                             \
  X(p_next, vector)              /* candidate of p'; p^+ on E */                                   \
  X(acceleration_next, vector)   /* Newmark: a' */                                                 \
  X(force, vector)               /* R(q_k), later R(q-bar); energy: E in the end */                \
  X(middle, vector)              /* where an implicit step evaluates the model: q-bar, or q' */    \
  X(velocity, vector)            /* the velocity there */                                          \
  X(product, vector)             /* T times velocity */                                            \
  X(unknown, vector)             /* increment d = q' - q on I that is solved for */                \
  X(trial, vector)               /* an increment or a residual to compare with */                  \
  X(residual, vector)            /* of the solve */                                                \
  X(direction, vector)           /* Newton's correction */                                         \
  X(image, vector)               /* the next correction */                                         \
  X(scale, vector)               /* Jacobian at rest: scale of a mode's residual */                \
  X(unscale, vector)             /* 1/scale */                                                     \
  X(mass, vector)                /* of the solve: mu, */                                           \
  X(speed, vector)               /* nu */                                                          \
  X(drag, vector)                /* and eta */                                                     \
  X(kick, vector)                /* of the solve: d without forces */                              \
  X(drift, vector)               /* of the solve: the velocity for d = 0 */                        \
  X(total, vector)               /* R + D v - f at the middle */                                   \
  X(q_start, vector)             /* q after a step that was repeated */                            \
  X(p_before_next, vector)       /* synchronised p at the start of the step */                     \
  X(p_start, vector)             /* p as another scheme has it */                                  \
  X(p_level, vector)             /* synchronised p on a fallback level */                          \
  X(p_damped, vector)            /* position form: p after the first half of tangent damping */    \
  X(q_sub, vector)               /* between sub-steps */                                           \
  X(p_sub, vector)               /* between sub-steps */                                           \
  X(acceleration_sub, vector)    /* between sub-steps */                                           \
  X(power_explicit_next, vector) /* iterates after this step */                                    \
  X(power_whole_next, vector)                                                                      \
  X(point, vector)       /* where energy evaluates the model */                                    \
  X(point_2, vector)     /* and its second point */                                                \
  X(force_2, vector)     /* R there; energy: R(q') in the end */                                   \
  X(force_start, vector) /* energy: R(q_k) */                                                      \
  X(stretch, vector)     /* energy: lambda, */                                                     \
  X(unstretch, vector)   /* and 1/lambda */                                                        \
  X(bordered, vector)    /* energy: J0^-1 (q' - q) */                                              \
  X(slope, vector)       /* energy: h^2/2 |d|^2 grad(sigma) + J0 d */                              \
  X(correction, vector)  /* energy: by the inverse before a new one, negated */                    \
  X(q_corrected_next, vector)                                                                      \
  X(p_corrected_next, vector)                                                                      \
  X(load_damped, vector)    /* f_k with the drag of the slaves of a condensed model */             \
  X(pivots_next, vector)    /* int32: of jacobian_next */                                          \
  X(work, work)             /* of the polynomial */                                                \
  X(restricted, restricted) /* V at fixed q_E, a quartic in q_I */                                 \
  X(pairs, pairs)           /* BFGS corrections of the inverse learnt in this step */              \
  X(jacobian_next, next)    /* Jacobian, factors or inverse made in this step */                   \
  X(tangent, tangent)       /* T(q), rank x rank, for the tangent form of damping */               \
  X(tangent_2, tangent)     /* a second one */

/* Pointers into the block of a state; each call makes them for itself. */
typedef struct thrum_state_view {
#define X(name, size) double *name;
  THRUM_STATE_ARRAYS(X)
  THRUM_STATE_SCRATCH(X)
  THRUM_STATE_FIXED(X)
#undef X
  double *inverse[THRUM_INVERSES];   /* the newest first */
  double *kept_end;                  /* behind the last array that persists */
  const struct thrum_kernel *kernel; /* the one of the def, or the best one here */
  const double *restricted_from;     /* not NULL: a batch has the content of `restricted` there, */
  int64_t restricted_stride;         /* one entry every so many doubles */
  int64_t stride;                    /* doubles from one vector to the next in an array of them */
  bool power_sampled;                /* the power_*_next are to be kept */
} thrum_state_view;

/* Bytes of the whole block, from the sizes in the header. */
uint64_t thrum_state_layout_bytes(const thrum_state *state);

/* Pointers to the arrays of a state; the first writes them where a step needs them. */
void thrum_state_view_fill(thrum_state *state, thrum_state_view *view);
thrum_state_view thrum_state_view_of(thrum_state *state);

/* Bytes of the scratch of a state. */
uint64_t thrum_state_layout_scratch(const thrum_state *state);

/* Where a state that borrows scratch has the pointer to it, at the end of its block. */
void *thrum_state_lent(const thrum_state *state);
void thrum_state_set_lent(thrum_state *state, void *scratch);

/* Workspace of a batch that takes the place of a state's scratch. `work` and `restricted` may be
 * shared by several states, as each use fills them again. */
typedef struct thrum_borrowed_workspace {
  double *work, *restricted;
  double *own; /* thrum_borrowed_own(rank) doubles, aligned to 64: all else */
} thrum_borrowed_workspace;

/* Doubles in the `own` of a borrowed workspace. */
int64_t thrum_borrowed_own(int64_t rank);

/* Points the view of a state of this rank to the borrowed workspace. */
void thrum_state_view_borrow(thrum_state_view *view, int64_t rank,
                             const thrum_borrowed_workspace *borrowed);

/* Place of step k in the ring of past solves. */
static inline int64_t thrum_past_place(int64_t k) {
  return (k % THRUM_PAST_SOLVES + THRUM_PAST_SOLVES) % THRUM_PAST_SOLVES;
}

/* Offset of step k in past_q and past_r. */
static inline int64_t thrum_past_at(const thrum_state_view *view, int64_t k) {
  return thrum_past_place(k) * view->stride;
}

/* True for the integrators that may switch to `energy` by themselves. */
static inline bool thrum_adapts(thrum_integrator integrator) {
  return integrator == THRUM_INTEGRATOR_IMEXV || integrator == THRUM_INTEGRATOR_FOX_GOODWIN;
}

/* True for a state whose material may flow: by the yield of its def, or by those of the regions. */
static inline bool thrum_can_flow(const thrum_state *state) {
  return state->plastic_count > 0;
}

/* True for an imexv with its stability monitor. */
static inline bool thrum_is_monitored_imexv(const thrum_state *state) {
  return state->def.adaptive && state->def.integrator == THRUM_INTEGRATOR_IMEXV;
}

/* True for D = alpha 1 + beta T(q) with beta > 0. */
static inline bool thrum_tangent_damped(const thrum_state *state) {
  return state->def.damping_form == THRUM_DAMPING_TANGENT && state->def.damping_beta != 0.0;
}

/* Damping of a mode that goes with its mass: alpha, and what the mode has of its own [1/s]. */
static inline double thrum_mass_damping(const thrum_model *model, const thrum_state *state,
                                        int64_t i) {
  const double alpha = state->def.damping_alpha;
  return model->damping ? alpha + model->damping[i] : alpha;
}

/* Damping of a mode at rest, that and beta omega_i^2 [1/s]. */
static inline double thrum_rest_damping(const thrum_model *model, const thrum_state *state,
                                        int64_t i) {
  return thrum_mass_damping(model, state, i) + state->def.damping_beta * model->omega2[i];
}

/* True where anything damps. */
static inline bool thrum_is_damped(const thrum_model *model, const thrum_state *state) {
  return state->def.damping_alpha != 0.0 || state->def.damping_beta != 0.0 || model->damping;
}

#endif
