/* Periodic motions of a reduced model: backbone curves and frequency response by harmonic balance,
 * their stability, and where it changes.
 *
 *   q'' + D q' + R(q) = f(t),   q(t) = a_0 + sum_{k=1..H} a_k cos(k Omega t) + b_k sin(k Omega t),
 *
 * R the force of thrum/polynomial.h, D diagonal, f of period 2 pi / Omega. The coefficients are
 * those for which the residual has no component in the same functions (Galerkin). R is cubic in q,
 * so 4 H + 1 samples a period give its projection exactly, and the energy balance of each motion is
 * exact too: the work of f over a period is what D takes. A model of cubature points is sampled
 * twice as often.
 *
 * A curve of such motions is followed by its arc length, through folds, from one frequency to
 * another (forced) or from rest by amplitude (backbone: free and undamped, even in time). Its
 * motions come to the caller one by one, with those where its stability changes in between, in
 * order. Where curves cross it may go on along the other one.
 *
 * The library needs libthrum and libm. It allocates nothing: all memory is the workspace. Any
 * thread, as long as each has its own workspace. Equations: docs/mathematics/21_periodic_motion.md.
 * Sources: Nayfeh and Balachandran 1995, doi:10.1002/9783527617548; Krack and Gross 2019,
 * doi:10.1007/978-3-030-14023-6.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RESPONSE_H
#define THRUM_RESPONSE_H

#include <stdbool.h>

#include "thrum/api.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

#define THRUM_RESPONSE_HARMONICS_MAX 64
/* Squared coefficients and frequencies of such sizes stay finite. */
#define THRUM_RESPONSE_MOST 1e100

/* What a curve is asked for. Start from thrum_default_response_def and change fields. */
typedef struct thrum_response_def {
  /* Set by thrum_default_response_def; a def without it is refused with THRUM_UNINITIALISED_DEF. */
  uint32_t cookie;

  /* Harmonics H beside the mean; 1 to THRUM_RESPONSE_HARMONICS_MAX, default 5. Larger: sharper
   * motions are right, and a point costs more, by the cube of it. */
  int32_t harmonics;

  /* Mode of the backbone (0-based); -1, the default: the forced curve. */
  int64_t mode;

  /* Angular frequency at which a forced curve begins, and where it ends [rad/s]; both > 0, and they
   * differ. It may begin at the higher. A backbone ends where it leaves the range between them. */
  double from, to;

  /* Amplitude at which a backbone ends, of the first harmonic of its mode [kg^1/2 m]; > 0, default
   * infinite. */
  double amplitude;

  /* Longest step along the curve; in (0, 1], default 0.05: of the range of frequencies, or of the
   * largest motion so far. Larger: fewer points. */
  double step;

  /* Points after which the curve ends; >= 2, default 2000. */
  int32_t points;

  /* Residual of a point, of each coordinate over its stiffness and inertia, relative to the motion;
   * in (0, 1e-3], default 1e-12. Larger: fewer iterations. */
  double tolerance;

  /* 1: the stability of each point, and the places where it changes; 0: folds alone. Default 1. */
  int32_t stability;

  /* Steps a period in which stability is looked for; 0, the default: 6 for each harmonic, and 48 at
   * least. Where a motion is unstable by them half of them must find the same, or they are doubled
   * until two do, six times
   * at most. Larger: exponents are more accurate, by the fourth power. */
  int32_t stability_steps;

  /* 1: the slaves of a condensed model have inertia as they follow, and damping; 0: they have none,
   * as in steps of it. Default 1. A softening that comes of how they follow is wrong without it. */
  int32_t inertia;

  /* D, of each coordinate [1/s] (rank), none negative: 2 zeta omega for a ratio zeta of a linear
   * mode; others follow modes at their frequency, and have the rate of one. NULL, the default:
   * none. A backbone uses none. */
  const double *damping;

  /* The same of each slave [1/s] (rank of the shape model less rank). NULL, the default: none. */
  const double *slave_damping;

  /* The load, of each coordinate (of the shape model's rank, where the model is condensed)
   * [kg^1/2 m/s^2]: f = mean + cosine cos(Omega t) + sine sin(Omega t). NULL, the default: none. A
   * forced curve needs one of the last two, and a backbone has none. */
  const double *load_mean, *load_cosine, *load_sine;

  /* Periods of the load in one of the motion; 1 to harmonics, default 1. All frequencies are the
   * motion's: the load swings with periods times Omega. With 2, what a curve of 1 calls a period
   * doubling is a branch point. A backbone has 1. */
  int32_t periods;

  /* N: at the Nth branch point the curve goes on along the other curve through it, to one side;
   * -N: to the other. 0, the default: it goes straight on. */
  int32_t branch;
} thrum_response_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_response_def_init(thrum_response_def *def, size_t size);

/* The same as a value. */
static inline thrum_response_def thrum_default_response_def(void) {
  thrum_response_def def;
  thrum_response_def_init(&def, sizeof def);
  return def;
}

/* What a point of the curve is. */
#define THRUM_RESPONSE_KIND_LIST(X)                                                                \
  X(REGULAR, 0, "regular")                                                                         \
  X(FOLD, 1, "fold")                       /* the curve turns back in frequency */                 \
  X(PERIOD_DOUBLING, 2, "period doubling") /* a multiplier goes through -1 */                      \
  X(NEIMARK_SACKER, 3, "Neimark-Sacker")   /* a pair leaves the unit circle: a torus */            \
  X(BRANCH, 4, "branch point")             /* a multiplier goes through 1, and no fold */

typedef enum thrum_response_kind {
#define X(name, value, text) THRUM_RESPONSE_##name = value,
  THRUM_RESPONSE_KIND_LIST(X)
#undef X
} thrum_response_kind;

/* Name of a kind; NULL for a number that names none. Static storage. */
THRUM_API const char *thrum_response_kind_name(thrum_response_kind kind);

/* How a curve ended. */
#define THRUM_RESPONSE_END_LIST(X)                                                                 \
  X(ARRIVED, 0, "arrived")         /* at `to`, or out of the range of a backbone */                \
  X(LEFT, 1, "left the range")     /* behind `from`, or as far as `to` behind a given start */     \
  X(AMPLITUDE, 2, "amplitude")     /* the amplitude asked for is reached */                        \
  X(CLOSED, 3, "closed")           /* back at its first point */                                   \
  X(POINTS, 4, "number of points") /* as many as were allowed */                                   \
  X(LOST, 5, "lost")               /* no further point could be found */                           \
  X(STOPPED, 6, "stopped")         /* the caller asked to stop */

typedef enum thrum_response_end {
#define X(name, value, text) THRUM_RESPONSE_END_##name = value,
  THRUM_RESPONSE_END_LIST(X)
#undef X
} thrum_response_end;

THRUM_API const char *thrum_response_end_name(thrum_response_end end);

/* One periodic motion. The arrays are the workspace's and valid only during the call of `visit`. */
typedef struct thrum_response_point {
  double omega;               /* angular frequency Omega [rad/s] */
  const double *coefficients; /* (2 H + 1) x rank: a_0, a_1 .. a_H, b_1 .. b_H [kg^1/2 m] */
  double energy;              /* kinetic and strain energy, mean of a period [J] */
  double work;                /* of the load over a period [J] */
  double dissipated;          /* by D over a period [J]; equal to the work but for the residual */
  double tail;                /* kinetic energy of the last two harmonics over that of all [1]; 0
                                 where H is 2 or less, which says nothing */
  double residual;            /* as of `tolerance` */
  double arc;                 /* length of the curve up to here, in steps relative to 1 */
  const double *multipliers;  /* 2 rank Floquet multipliers, real and imaginary parts in turn, by
                                 falling  magnitude; NULL without stability */
  int32_t unstable;           /* multipliers outside of the unit circle; -1: not looked at, or not
                                 found, as they depend on the steps */
  int32_t iterations;         /* that it took */
  thrum_response_kind kind;
} thrum_response_point;

typedef struct thrum_response_report {
  thrum_response_end end;
  int32_t points;         /* visited */
  int32_t folds;          /* and other special points among them */
  int32_t special;        /* all special points, folds too */
  int32_t iterations;     /* over the whole curve */
  int32_t factorisations; /* of Jacobians */
  double tail;            /* largest of all points */
  double balance; /* largest |work - dissipated| over the larger of both; 0 for a backbone */
} thrum_response_report;

/* Bytes of workspace for this model and def, into *size. Fails as thrum_response. */
THRUM_API thrum_status thrum_response_size(const thrum_model *model, const thrum_response_def *def,
                                           size_t *size, thrum_error *error);

/* Follows the curve. `workspace` has thrum_response_size bytes, is aligned to 64 and stays the
 * caller's. `visit` is called with `context` and each point in turn, in this thread; where it
 * returns false the curve ends. start: NULL, or coefficients ((2 H + 1) x rank) near those of the
 * first point of a forced curve, whose frequency is `from`. Such a curve may go on behind `from`,
 * to from^2 / to.
 *
 * What was found stays found: a curve that cannot be followed to its end is done with report->end.
 * THRUM_NOT_CONVERGED where not even the first point is found, THRUM_BAD_VALUE for numbers that are
 * not finite or out of range, THRUM_MISSING for a model without V, or a forced curve without a
 * load, THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT with the field and its range,
 * THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL. */
THRUM_API thrum_status thrum_response(
    const thrum_model *model, const thrum_response_def *def, const double *start, void *workspace,
    size_t workspace_size, bool (*visit)(void *context, const thrum_response_point *point),
    void *context, thrum_response_report *report, thrum_error *error);

/* q and p (rank each) of a motion at the phase Omega t = `phase` [rad]; coefficients as of a point.
 * Either may be NULL. */
THRUM_API void thrum_response_at(int64_t rank, int32_t harmonics, double omega, double phase,
                                 const double *coefficients, double *q, double *p);

/* The normal form of one mode: with the complex amplitude z of its coordinate, q = z + zbar to
 * first order, zdot = i (omega + c |z|^2 + d |z|^4 + e |z|^6) z. All other coordinates follow, and
 * no scale of the mode changes d omega / c^2 and e omega^2 / c^3. */
#define THRUM_NORMAL_FORM_ORDER 7
typedef struct thrum_normal_form {
  double omega;           /* [rad/s] */
  double coefficients[3]; /* c, d and e [1/s over (kg^1/2 m)^2, ^4, ^6] */
} thrum_normal_form;

/* Bytes of workspace for this model, into *size. Fails as thrum_normal_form_find. */
THRUM_API thrum_status thrum_normal_form_size(const thrum_model *model, int64_t mode, size_t *size,
                                              thrum_error *error);

/* Finds the normal form of the mode (0-based) of a polynomial of all coordinates. scale: amplitude
 * of the mode at which its nonlinear forces are about as large as the linear one, of the
 * coordinate. Rounding grows with it, that of e by about its eleventh power: keep it within a few
 * times that amplitude. `workspace` has thrum_normal_form_size bytes and is
 * aligned to 64. THRUM_SINGULAR where another mode has a multiple of the frequency to 1e-3 of its
 * square, THRUM_NOT_FINITE where scale is too far from that amplitude, THRUM_MISSING
 * without a polynomial or where the model is condensed,
 * THRUM_INVALID_ARGUMENT, THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL. */
THRUM_API thrum_status thrum_normal_form_find(const thrum_model *model, int64_t mode, double scale,
                                              void *workspace, size_t workspace_size,
                                              thrum_normal_form *found, thrum_error *error);

/* One coefficient f of zdot_j = i (omega_j z_j + sum of f z_1^a zbar_1^b z_2^c zbar_2^d). */
typedef struct thrum_normal_form_term {
  int32_t of;         /* j: 0 or 1 */
  int32_t powers[4];  /* a, b, c, d */
  double coefficient; /* [1/s over (kg^1/2 m) to the order less one] */
} thrum_normal_form_term;

#define THRUM_NORMAL_FORM_TERMS_MAX 76 /* of two modes near 1:1 to order 7 */
typedef struct thrum_normal_form_pair {
  double omega[2]; /* [rad/s] */
  int32_t count;
  thrum_normal_form_term terms[THRUM_NORMAL_FORM_TERMS_MAX];
} thrum_normal_form_pair;

/* The normal form of two modes (0-based) of which the second has about `ratio` times the frequency
 * of the first, 1 to 3, to the order 2 to THRUM_NORMAL_FORM_ORDER: all terms that turn as
 * their mode does where the ratio is exact. The rest as of thrum_normal_form_find, whose workspace
 * is enough. */
THRUM_API thrum_status thrum_normal_form_pair_find(const thrum_model *model, const int64_t modes[2],
                                                   int32_t ratio, int32_t order, double scale,
                                                   void *workspace, size_t workspace_size,
                                                   thrum_normal_form_pair *found,
                                                   thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
