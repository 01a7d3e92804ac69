/* The state of one body and the steps that advance it.
 *
 * A state is planned (thrum_state_size), then laid into the caller's memory (thrum_state_init). It
 * holds no pointer, so a snapshot is memcpy of thrum_state_bytes(state) bytes and a restore is the
 * memcpy back: the solver's history (kept Jacobian, warm start, split) comes along bit for bit.
 * A state belongs to one thread at a time; the model is shared. No function here allocates, prints
 * or keeps a global. All quantities are SI in reduced coordinates u = U q, with unit mass.
 *
 *   imexv     two-stage implicit-explicit variational integrator, design 5 (2)-(5), component split
 *   verlet    its end |I| = 0: Stoermer-Verlet
 *   midpoint  its end |I| = r: the implicit midpoint rule
 *   newmark   design 6, any beta and gamma, full Newton; the baseline
 *
 * Sources: Stern & Grinspun 2009, Implicit-explicit variational integration of highly oscillatory
 * problems, doi:10.1137/080732936; Kane et al. 2000, doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STATE_H
#define THRUM_STATE_H

#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum thrum_integrator {
  THRUM_INTEGRATOR_IMEXV = 0,
  THRUM_INTEGRATOR_NEWMARK = 1,
  THRUM_INTEGRATOR_VERLET = 2,
  THRUM_INTEGRATOR_MIDPOINT = 3
} thrum_integrator;

/* Rayleigh damping D, design 5. */
typedef enum thrum_damping_form {
  THRUM_DAMPING_REST = 0,   /* D = alpha 1 + beta diag(omega^2): constant, never negative */
  THRUM_DAMPING_TANGENT = 1 /* D = alpha 1 + beta T(q): may feed energy in where T is indefinite */
} thrum_damping_form;

/* Which modes imexv treats explicitly, design 4. */
typedef enum thrum_split_rule {
  THRUM_SPLIT_CFL = 0,      /* explicit when h omega <= 2 safety */
  THRUM_SPLIT_SAMPLING = 1, /* the thesis' rule f < 1/h: admits modes pi times too fast */
  THRUM_SPLIT_COUNT = 2     /* the lowest explicit_count modes */
} thrum_split_rule;

typedef struct thrum_state_def {
  uint32_t cookie;                 /* set by thrum_default_state_def; catches an uninitialised def */
  thrum_integrator integrator;     /* default imexv */
  double dt;                       /* time step h [s], > 0; default 0.003 */
  double damping_alpha;            /* [1/s], >= 0; default 0 */
  double damping_beta;             /* [s], >= 0; default 0 */
  thrum_damping_form damping_form; /* default rest */
  thrum_split_rule split_rule;     /* default cfl; verlet and midpoint ignore it */
  double split_safety;             /* c in h omega <= 2 c, in (0, 1]; default 0.5 */
  int32_t explicit_count;          /* for THRUM_SPLIT_COUNT, 0..rank; default 0 */
  double newmark_beta;             /* beta_N >= 0; default 1/4 */
  double newmark_gamma;            /* gamma in [0, 1]; default 1/2 */
  double tolerance;                /* of the implicit solve, relative, in (0, 1e-2]; default 1e-10 */
  int32_t iterations_max;          /* of one implicit solve, >= 1; default 50 */
} thrum_state_def;

/* A def with every default set. */
thrum_state_def thrum_default_state_def(void);

/* Opaque: lives at the start of the memory given to thrum_state_init. */
typedef struct thrum_state thrum_state;

/* Energies from the synchronised momentum [J]. */
typedef struct thrum_energies {
  double kinetic;   /* 1/2 |p|^2 */
  double potential; /* V(q) */
  double total;     /* their sum */
  double high;      /* 1/2 sum over the rest-state I0 of p_i^2 + omega_i^2 q_i^2 */
} thrum_energies;

/* What a state has done since init, and how it stands. */
typedef struct thrum_state_report {
  int64_t steps;          /* completed steps */
  double time;            /* steps at their dt, summed [s] */
  int64_t iterations;     /* of implicit solves, all steps together */
  int64_t factorisations; /* of their Jacobians */
  int64_t newton_steps;   /* steps that needed full Newton after quasi-Newton failed */
  int32_t explicit_modes; /* |E| now; r for verlet, 0 for midpoint and newmark */
  int32_t implicit_modes; /* |I| now */
  int32_t iterations_last;
  double residual_last;   /* scaled residual of the last solve */
} thrum_state_report;

/* Bytes of a state for this model and def. Checks the def and says what is wrong with it. */
thrum_status thrum_state_size(const thrum_model *model, const thrum_state_def *def, size_t *size,
                              thrum_error *error);

/* Lays a state at rest (q = p = 0, no load) into `memory`, aligned to 64, at least
 * thrum_state_size bytes; the caller owns it and frees it when done. */
thrum_status thrum_state_init(void *memory, size_t memory_size, const thrum_model *model,
                              const thrum_state_def *def, thrum_state **state, thrum_error *error);

/* Bytes to copy for a snapshot: those of thrum_state_size. */
size_t thrum_state_bytes(const thrum_state *state);

/* Sets synchronised q and p (rank each; NULL means zero). Counters, load and time stay; the
 * solver's history is forgotten. The mean load of the step before counts as zero.
 * THRUM_BAD_VALUE for NaN or Inf, THRUM_NOT_FINITE where the forces at q overflow. */
thrum_status thrum_state_set(const thrum_model *model, thrum_state *state, const double *q,
                             const double *p, thrum_error *error);

/* Writes q and the synchronised p (rank each; either may be NULL). Uses the state's scratch. */
thrum_status thrum_state_get(const thrum_model *model, thrum_state *state, double *q, double *p,
                             thrum_error *error);

/* Reduced external load f (rank) [kg^1/2 m/s^2] of the steps to come: its mean over the step
 * (design 5). Stays until set again; NULL means zero. See thrum/force.h for vertex forces. */
thrum_status thrum_state_set_force(const thrum_model *model, thrum_state *state,
                                   const double *force, thrum_error *error);

/* Changes the time step between two steps: synchronise, change, un-synchronise (design 4). */
thrum_status thrum_state_set_dt(const thrum_model *model, thrum_state *state, double dt,
                                thrum_error *error);

/* Advances by one step. THRUM_OK; THRUM_FELL_BACK when full Newton was needed;
 * THRUM_NOT_CONVERGED or THRUM_NOT_FINITE with every byte of the state as it was before. */
thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error);

/* Energies at the present step, from synchronised p. Uses the state's scratch. */
thrum_status thrum_state_energies(const thrum_model *model, thrum_state *state,
                                  thrum_energies *energies, thrum_error *error);

thrum_state_report thrum_state_report_get(const thrum_state *state);

#ifdef __cplusplus
}
#endif
#endif
