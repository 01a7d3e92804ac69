/* The state of one body and the steps that advance it.
 *
 * A state is planned (thrum_state_size), then laid into the caller's memory (thrum_state_init). It
 * holds no pointer, so a snapshot is memcpy of thrum_state_kept_bytes(state) bytes and a restore is
 * the memcpy back: the solver's history (kept Jacobian, warm start, split) comes along bit for bit.
 * A state belongs to one thread at a time; the model is shared. No function here allocates, prints
 * or keeps a global. All quantities are SI in reduced coordinates u = U q, with unit mass.
 *
 *   imexv     two-stage implicit-explicit variational integrator, design 5 (2)-(5), component split
 *   verlet    its end |I| = 0: Stoermer-Verlet
 *   midpoint  its end |I| = r: the implicit midpoint rule
 *   newmark   design 6, any beta and gamma; the baseline
 *   energy    design 7, a discrete gradient: conserves 1/2 |p|^2 + V at any h
 *
 * imexv also runs in the quadratic split (6), and watches itself (design 4): it moves modes between
 * E and I, and switches to the step of `energy` where its energy balance grows. What a step needs
 * beyond quasi-Newton is a fallback level of the fallback chain (design 8); every fallback level is
 * counted.
 *
 * Sources: Stern & Grinspun 2009, Implicit-explicit variational integration of highly oscillatory
 * problems, doi:10.1137/080732936; Kane et al. 2000,
 * doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STATE_H
#define THRUM_STATE_H

#include "thrum/kernel.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef enum thrum_integrator {
  THRUM_INTEGRATOR_IMEXV = 0,
  THRUM_INTEGRATOR_NEWMARK = 1,
  THRUM_INTEGRATOR_VERLET = 2,
  THRUM_INTEGRATOR_MIDPOINT = 3,
  THRUM_INTEGRATOR_ENERGY = 4
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

/* How imexv splits V, design 5. */
typedef enum thrum_split_form {
  THRUM_FORM_COMPONENT = 0, /* R_E at q_k, R_I at the midpoint: the thesis' form */
  THRUM_FORM_QUADRATIC = 1  /* (6): symplectic, no iteration; for small steps or amplitudes */
} thrum_split_form;

/* What advances a state at present; imexv may change it. */
typedef enum thrum_scheme {
  THRUM_SCHEME_COMPONENT = 0, /* (2)-(5), verlet and midpoint included */
  THRUM_SCHEME_QUADRATIC = 1, /* (6) */
  THRUM_SCHEME_ENERGY = 2,    /* design 7 */
  THRUM_SCHEME_NEWMARK = 3    /* design 6 */
} thrum_scheme;

typedef struct thrum_state_def {
  uint32_t cookie;             /* set by thrum_default_state_def; catches an uninitialised def */
  thrum_integrator integrator; /* default imexv */
  double dt;                   /* time step h [s], > 0; default 0.003 */
  double damping_alpha;        /* [1/s], >= 0; default 0 */
  double damping_beta;         /* [s], >= 0; default 0 */
  thrum_damping_form damping_form; /* default rest */
  thrum_split_rule split_rule;     /* default cfl; verlet and midpoint ignore it */
  double split_safety;             /* c in h omega <= 2 c, in (0, 1]; default 0.5 */
  int32_t explicit_count;          /* for THRUM_SPLIT_COUNT, 0..rank; default 0 */
  double newmark_beta;             /* beta_N >= 0; default 1/4 */
  double newmark_gamma;            /* gamma in [0, 1]; default 1/2 */
  double tolerance;            /* of the implicit solve, relative, in (0, 1e-2]; default 1e-10 */
  int32_t iterations_max;      /* of one implicit solve, >= 1; default 50 */
  thrum_kernel_id kernel;      /* which instructions; default the best; same bits whatever it is */
  thrum_split_form split_form; /* of imexv; default component */
  int32_t adaptive;            /* 1: imexv watches itself, design 4; 0: not; default 1 */
  int32_t fallback; /* 1: fallback levels after full Newton, design 8; 0: none; default 1 */
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
  int64_t
      newton_steps; /* fallback level 2: steps that full Newton solved after quasi-Newton failed */
  int64_t energy_steps;    /* fallback level 3, imexv: steps that one step of `energy` replaced */
  int64_t substep_steps;   /* fallback level 4: steps solved by shorter ones */
  int64_t switched_steps;  /* imexv: steps of `energy` after the watch switched to the energy
                              integrator; no fallback level */
  int64_t split_changes;   /* imexv: changes of E and I by the watch */
  int64_t scheme_switches; /* imexv: changes of the scheme by the watch */
  int64_t corrections;     /* imexv: times the watch took slow drift out through the momentum */
  double corrected;        /* imexv: energy that they gave and took in all, net [J] */
  double stability_number_last; /* imexv, watched: h sqrt(rho), rho the spectral radius of what is
                        treated explicitly; stable below 2 (design 4) */
  double stability_number_peak; /* its largest */
  double balance_last;    /* imexv, watched: energy - work + dissipation, relative to the energy */
  double balance_peak;    /* its largest magnitude */
  thrum_scheme scheme;    /* now */
  int32_t explicit_modes; /* |E| now; r for verlet, 0 for midpoint, newmark and energy */
  int32_t implicit_modes; /* |I| now */
  int32_t iterations_last;
  double residual_last; /* scaled residual of the last solve; expected at most, if not evaluated */
} thrum_state_report;

/* Bytes of a state for this model and def. Checks the def and says what is wrong with it. */
thrum_status thrum_state_size(const thrum_model *model, const thrum_state_def *def, size_t *size,
                              thrum_error *error);

/* Lays a state at rest (q = p = 0, no load) into `memory`, aligned to 64, at least
 * thrum_state_size bytes; the caller owns it and frees it when done. */
thrum_status thrum_state_init(void *memory, size_t memory_size, const thrum_model *model,
                              const thrum_state_def *def, thrum_state **state, thrum_error *error);

/* Bytes of a state, those of thrum_state_size: for a copy in other memory, which can step. */
size_t thrum_state_bytes(const thrum_state *state);

/* How many of them, from the first on, persist between calls: enough for a snapshot to restore in
 * the same memory or over a copy, and what is the same in equal states. What lies behind is
 * scratch, of any content. */
size_t thrum_state_kept_bytes(const thrum_state *state);

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

/* Advances by one step. THRUM_OK; THRUM_FELL_BACK when a fallback level beyond quasi-Newton was
 * needed; THRUM_NOT_CONVERGED or THRUM_NOT_FINITE with every byte that persists as it was before.
 */
thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error);

/* Energies at the present step, from synchronised p. Uses the state's scratch. */
thrum_status thrum_state_energies(const thrum_model *model, thrum_state *state,
                                  thrum_energies *energies, thrum_error *error);

thrum_state_report thrum_state_report_get(const thrum_state *state);

#ifdef __cplusplus
}
#endif
#endif
