/* The report of one step's solve, committed to the state with the step; private to libthrum.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_STATE_SOLVE_REPORT_H
#define THRUM_CORE_STATE_SOLVE_REPORT_H

#include <stdbool.h>
#include <stdint.h>

typedef enum thrum_fallback_level {
  THRUM_FALLBACK_NONE = 0, /* quasi-Newton or full Newton solved the step */
  THRUM_FALLBACK_ENERGY,   /* one step of the energy integrator */
  THRUM_FALLBACK_SUBSTEPS  /* several shorter steps */
} thrum_fallback_level;

typedef struct thrum_solve_report {
  int32_t iterations;
  int32_t factorisations;
  bool newton;          /* full Newton was needed */
  bool late_refresh;    /* quasi-Newton found too late that it needs a new Jacobian */
  bool verified;        /* R was evaluated at the increment found */
  bool solved;          /* the increment came from a solve, so the next guess may extrapolate it */
  bool refreshed;       /* jacobian_next replaces the newest inverse, */
  bool extrapolated;    /* or has stood in for it */
  int32_t learnt;       /* BFGS corrections to be folded into it */
  double guess;         /* scaled residual of the first guess, relative to the scaled step */
  double reached;       /* the same of the last evaluation */
  bool discrete;        /* energy: the mean force was that of the discrete gradient */
  bool discrete_failed; /* energy: the solve with the discrete gradient failed */
  bool carries;         /* energy: the last correction is left to the next step */
  bool sampled;         /* energy: spurious_work and band_energy are known */
  bool saw_nonfinite;
  bool potential_known;
  bool energy_known;
  bool energy_ahead; /* `energy` is that of the end of the step, less what the step's work added */
  bool spoilt;       /* the energy at the end of the step shows that it went wrong */
  bool dissipation_known;
  thrum_fallback_level fallback_level;
  double dissipation;            /* of the step, where it is not that of its increment alone [J] */
  double residual;               /* scaled, relative to the scaled step */
  double step;                   /* energy: scaled norm of the increment */
  double contraction;            /* energy: share of a residual that the kept inverse leaves; */
                                 /* < 0: not measured */
  double spurious_work;          /* energy: that corrections by the kept inverse would have moved */
                                 /* from low to high modes in the steps since it was made [J] */
  double band_energy[2];         /* energy: 1/2 (p^2 + omega^2 q^2), of low and of high modes [J] */
  double potential;              /* V(q'), where potential_known [J] */
  double potential_corrected;    /* energy: V where the next step starts, if it carries [J] */
  double potential_start;        /* energy: V(q) [J] */
  double inverse_square;         /* energy: 1/|d|^2, less where sigma would be rounding */
  double along_step;             /* energy: sigma, the mean force's part along d [s^-2] */
  double bordered;               /* energy: J0^-1 d along h^2/2 grad(sigma) */
  double energy;                 /* at the start of the step, for the stability monitor [J] */
  double energy_scale;           /* what its errors are relative to: it, or that at the end [J] */
  double switch_energy;          /* what a switch for one of the two reasons above compares with */
  double modified_energy;        /* how far Stoermer-Verlet's modified Hamiltonian lies below it */
  double modified_energy_change; /* what the load of the step to come adds to that [J] */
} thrum_solve_report;

#endif
