/* The state of one body, and the steps that advance it.
 *
 * Reduced coordinates q (rank) give the displacements u = U q of the model's vertices; the mass
 * matrix in them is the identity, so the momentum p is also the velocity. Quantities are SI:
 * q in kg^1/2 m, p in kg^1/2 m/s, reduced forces in kg^1/2 m/s^2, energies in J, times in s.
 *
 *   imexv     two-stage implicit-explicit variational integrator, design 5 (2)-(5)
 *   verlet    imexv with every mode explicit: Stoermer-Verlet
 *   midpoint  imexv with every mode implicit: the implicit midpoint rule
 *   newmark   the Newmark family, design 6, any beta and gamma; the baseline
 *   energy    an energy-conserving step by a discrete gradient, design 7: it keeps
 *             1/2 |p|^2 + V at any dt, up to the work of the load and the dissipation; the default
 *   manifold  an energy-conserving step of a condensed model with the inertia of what follows,
 *             design 17: p is the velocity of the masters, and the kinetic energy has that of the
 *             slaves as well
 *
 * imexv also has a quadratic split, design 5 (6). With `adaptive` set it monitors its own stability
 * (design 4): it moves modes between the explicit set E and the implicit set I, corrects slow drift
 * of the energy, and switches to the step of `energy` where its energy balance grows. A step that
 * quasi-Newton does not solve goes through the levels of the fallback chain (design 8). The report
 * counts each of these events.
 *
 * Memory: a state is one block aligned to 64 bytes, without pointers inside but for one to scratch
 * that it borrows (thrum_state_lend), behind all that persists. thrum_state_create
 * takes it from the heap and thrum_state_destroy returns it; a caller with memory of its own asks
 * thrum_state_size and calls thrum_state_init. No other function here allocates, and a step never
 * does. Within a program a snapshot is memcpy of thrum_state_kept_bytes(state) bytes, a restore is
 * the memcpy back: the history of the solver (kept Jacobian, first guess, split) comes along bit
 * for bit. A snapshot that leaves the program is made by thrum_state_snapshot, and
 * thrum_state_restore checks every bit of it.
 *
 * Threads: a state belongs to one thread at a time, and so does scratch that states borrow. The
 * model is only read and may be shared by any number of threads. No function here prints or keeps a
 * global.
 *
 * Sources: Stern & Grinspun 2009, Implicit-explicit variational integration of highly oscillatory
 * problems, doi:10.1137/080732936; Kane et al. 2000,
 * doi:10.1002/1097-0207(20001210)49:10<1295::AID-NME993>3.0.CO;2-W; Gonzalez 1996,
 * doi:10.1007/BF02440162.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_STATE_H
#define THRUM_STATE_H

#include "thrum/api.h"
#include "thrum/kernel.h"
#include "thrum/model.h"

#ifdef __cplusplus
extern "C" {
#endif

/* --- choices, each with its name in options, files and reports ---------------------------------
 *
 * X(NAME, value, text) */

/* Which integrator advances a state. */
#define THRUM_INTEGRATOR_LIST(X)                                                                   \
  X(IMEXV, 0, "imexv")                                                                             \
  X(NEWMARK, 1, "newmark")                                                                         \
  X(VERLET, 2, "verlet")                                                                           \
  X(MIDPOINT, 3, "midpoint")                                                                       \
  X(ENERGY, 4, "energy")                                                                           \
  X(FOX_GOODWIN, 5, "fox-goodwin")                                                                 \
  X(BACKWARD_EULER, 6, "backward-euler")           /* drains; for comparison */                    \
  X(SEMI_IMPLICIT_EULER, 7, "semi-implicit-euler") /* one Newton step of it; for comparison */     \
  X(RK4, 8, "rk4")                                 /* explicit; for comparison */                  \
  X(MANIFOLD, 9, "manifold")                       /* condensed models, with inertia of slaves */

/* Form of the Rayleigh damping matrix D (design 5). */
#define THRUM_DAMPING_FORM_LIST(X)                                                                 \
  X(REST, 0, "rest")       /* alpha 1 + beta diag(omega^2): constant, never negative */            \
  X(TANGENT, 1, "tangent") /* alpha 1 + beta T(q): adds energy where T is indefinite */

/* Which modes imexv treats explicitly (design 4). */
#define THRUM_SPLIT_RULE_LIST(X)                                                                   \
  X(CFL, 0, "cfl")           /* those with dt omega <= 2 split_safety */                           \
  X(SAMPLING, 1, "sampling") /* the thesis' rule f < 1/dt: admits modes pi times too fast */       \
  X(COUNT, 2, "count")       /* the lowest explicit_count modes */

/* How imexv splits the potential V (design 5). */
#define THRUM_SPLIT_FORM_LIST(X)                                                                   \
  X(THESIS, 0, "thesis")       /* R_E at q_k and R_I at the midpoint: the thesis' form */          \
  X(QUADRATIC, 1, "quadratic") /* (6): symplectic, no iteration; small steps or amplitudes */      \
  X(POSITION, 2, "position")   /* (7): symplectic, all forces at one point, p at whole steps */

/* How implicit steps are solved (design 5). */
#define THRUM_IMPLICIT_SOLVER_LIST(X)                                                              \
  X(QUASI_NEWTON, 0, "quasi-newton") /* an inverse kept over many steps, corrected by BFGS */      \
  X(NEWTON, 1, "newton") /* the thesis' way: a Jacobian and its inverse each iteration */

/* The scheme that advances a state at present; imexv may change it. */
#define THRUM_SCHEME_LIST(X)                                                                       \
  X(THESIS, 0, "thesis")           /* (2)-(5), verlet and midpoint included */                     \
  X(QUADRATIC, 1, "quadratic")     /* (6) */                                                       \
  X(ENERGY, 2, "energy")           /* design 7 */                                                  \
  X(NEWMARK, 3, "newmark")         /* design 6 */                                                  \
  X(FOX_GOODWIN, 4, "fox-goodwin") /* design 6, with beta by mode */                               \
  X(POSITION, 5, "position")       /* (7) */                                                       \
  X(BACKWARD_EULER, 6, "backward-euler")                                                           \
  X(SEMI_IMPLICIT_EULER, 7, "semi-implicit-euler")                                                 \
  X(RK4, 8, "rk4")                                                                                 \
  X(MANIFOLD, 9, "manifold") /* design 17 */

typedef enum thrum_integrator {
#define X(name, value, text) THRUM_INTEGRATOR_##name = value,
  THRUM_INTEGRATOR_LIST(X)
#undef X
} thrum_integrator;

typedef enum thrum_damping_form {
#define X(name, value, text) THRUM_DAMPING_##name = value,
  THRUM_DAMPING_FORM_LIST(X)
#undef X
} thrum_damping_form;

typedef enum thrum_split_rule {
#define X(name, value, text) THRUM_SPLIT_##name = value,
  THRUM_SPLIT_RULE_LIST(X)
#undef X
} thrum_split_rule;

typedef enum thrum_split_form {
#define X(name, value, text) THRUM_FORM_##name = value,
  THRUM_SPLIT_FORM_LIST(X)
#undef X
} thrum_split_form;

typedef enum thrum_implicit_solver {
#define X(name, value, text) THRUM_SOLVER_##name = value,
  THRUM_IMPLICIT_SOLVER_LIST(X)
#undef X
} thrum_implicit_solver;

typedef enum thrum_scheme {
#define X(name, value, text) THRUM_SCHEME_##name = value,
  THRUM_SCHEME_LIST(X)
#undef X
} thrum_scheme;

/* Name of a choice, "imexv" and so on; NULL for a number that names none. Static storage. Any
 * thread. */
THRUM_API const char *thrum_integrator_name(thrum_integrator integrator);
THRUM_API const char *thrum_damping_form_name(thrum_damping_form form);
THRUM_API const char *thrum_split_rule_name(thrum_split_rule rule);
THRUM_API const char *thrum_split_form_name(thrum_split_form form);
THRUM_API const char *thrum_implicit_solver_name(thrum_implicit_solver solver);
THRUM_API const char *thrum_scheme_name(thrum_scheme scheme);

/* The choice of that name. THRUM_INVALID_ARGUMENT for NULL and for any other text; the error then
 * lists the names. Any thread. */
THRUM_API thrum_status thrum_integrator_from_name(const char *name, thrum_integrator *integrator,
                                                  thrum_error *error);
THRUM_API thrum_status thrum_damping_form_from_name(const char *name, thrum_damping_form *form,
                                                    thrum_error *error);
THRUM_API thrum_status thrum_split_form_from_name(const char *name, thrum_split_form *form,
                                                  thrum_error *error);
THRUM_API thrum_status thrum_implicit_solver_from_name(const char *name,
                                                       thrum_implicit_solver *solver,
                                                       thrum_error *error);

/* --- definition ------------------------------------------------------------------------------- */

/* Plastic flow of a material, design 19: the strain beyond `yield` flows after each step and stays.
 * The parameters are those of O'Brien, Bargteil & Hodgins 2002, doi:10.1145/566654.566579, and
 * Mueller & Gross 2004, Interactive virtual materials. */
typedef struct thrum_plastic {
  /* Norm of the deviator of the principal elastic strains s - 1 above which the material flows; >
   * 0, default infinite: it never does. Larger: stronger. */
  double yield;

  /* Share of the strain beyond it that flows in a second, as the rate of an exponential; > 0 [1/s],
   * default infinite: all of it flows at once. Larger: softer under loads that last. */
  double creep;

  /* Norm of the logarithms of the principal plastic stretches that is not exceeded; > 0, default
   * infinite: no bound. Larger: flows further. */
  double largest;
} thrum_plastic;

/* How a state is to be stepped. Start from thrum_default_state_def and change fields. */
typedef struct thrum_state_def {
  /* Set by thrum_default_state_def; a def without it is refused with THRUM_UNINITIALISED_DEF. */
  uint32_t cookie;

  /* Which integrator; default energy. */
  thrum_integrator integrator;

  /* Time step [s]; finite and > 0, default 0.003. Larger: a simulated second takes
   * fewer steps and is less accurate; more modes become implicit, fast ones swing too slowly, and
   * solves need more iterations. */
  double dt;

  /* Mass-proportional damping [1/s]; finite and >= 0, default 0. Larger: all motion decays faster,
   * slow modes relative to their period most. */
  double damping_alpha;

  /* Stiffness-proportional damping [s]; finite and >= 0, default 0. Larger: fast modes decay
   * faster, with the square of their frequency. */
  double damping_beta;

  /* Form of the damping matrix; default rest. */
  thrum_damping_form damping_form;

  /* Which modes imexv treats explicitly; default cfl. The other integrators ignore it. */
  thrum_split_rule split_rule;

  /* c of the rule cfl, dt omega <= 2 c; in (0, 1], default 0.5. Larger: more modes are explicit and
   * a step is cheaper, but the explicit modes come nearer to the stability limit c = 1, and the
   * monitor moves them more often. */
  double split_safety;

  /* Newmark's beta; finite and >= 0, default 1/4. Larger: more implicit, so stable at larger steps
   * and less accurate; 0 is the explicit central difference. */
  double newmark_beta;

  /* Newmark's gamma; in [0, 1], default 1/2. Larger: numerical damping, and only first order of
   * accuracy; smaller: numerical growth. */
  double newmark_gamma;

  /* Residual at which an implicit solve ends, relative to the step's increment; in [0, 1e-2],
   * default 0: the integrator's own, 1e-5 for energy, 1e-6 for manifold and 1e-10 for all others.
   * Larger: fewer iterations. energy keeps the energy at any tolerance, the others err in each
   * step's energy by about it; with energy it bounds what the correction carried to the
   * next step leaves, ten times as much where a step takes one force evaluation (design 7). */
  double tolerance;

  /* Plastic flow at the cubature points of a model with a point_law, by the integrator energy; a
   * finite yield of any other model or integrator is refused. Default none. Of regions with laws of
   * their own those of Saint Venant-Kirchhoff's material do not flow, and those that have a
   * region_yield flow beyond that whatever the yield here. The plastic strain of
   * each point is part of the state. A step costs a pass over the points more, and one in which
   * something flows an evaluation of the force. */
  thrum_plastic plastic;

  /* Explicit modes of the rule count; 0 to the model's rank, default 0. Larger: a cheaper step,
   * until the fastest of them is beyond its stability limit. */
  int32_t explicit_count;

  /* Iterations after which a solve counts as failed; >= 1, default 50. Larger: a hopeless solve
   * takes longer to reach the next fallback level. */
  int32_t iterations_max;

  /* Which instructions evaluate the polynomial; default the best of this machine. All kernels give
   * the same bits. */
  thrum_kernel_id kernel;

  /* How imexv splits the energy; default position. */
  thrum_split_form split_form;

  /* 1: imexv monitors its stability and adapts (design 4), and fox-goodwin gives way to `energy`
   * where its energy is no longer explained; 0: they stay as they begin. Default 1. The other
   * integrators ignore it. */
  int32_t adaptive;

  /* 1: steps that the solver does not solve go through the fallback chain (design 8); 0: they fail
   * with THRUM_NOT_CONVERGED. Full Newton with its line search comes after quasi-Newton in any
   * case, and after the solver newton only with 1. Default 1. verlet, midpoint and the
   * integrators for comparison have no fallback chain. */
  int32_t fallback;

  /* How implicit steps are solved; default quasi-newton. newton costs several times as much and
   * leads to the same steps where it converges. */
  thrum_implicit_solver solver;

  /* 1: steps of energy turn modes with dt omega <= 1 at their own frequency (design 7); 0: by the
   * trapezoidal rule, which is late by (dt omega)^2/12 of the angle. Default 1. It counts for every
   * step of energy, also where one stands in for imexv or fox-goodwin. */
  int32_t frequency_matched;

  /* 1: the state keeps what persists alone, and works in scratch that the caller lends it
   * (thrum_state_lend), which many states may share; 0: it has scratch of its own. Default 0. */
  int32_t borrows_scratch;

  /* 1: plastic flow is stepped at cubature points that were chosen for an elastic body, or whose
   * gradients were learned, though strain and work of what flows may be several times too small;
   * 0: a state of such a model with a yield is refused with THRUM_UNSUPPORTED. Default 0. A model
   * without point_training does not say what its points were chosen for, and is stepped. */
  int32_t untrained_flow;
} thrum_state_def;

/* A def with every default set. size: of the def as the caller knows it, which may be
 * that of an earlier version (docs/versioning.md). Any thread. */
THRUM_API void thrum_state_def_init(thrum_state_def *def, size_t size);

/* The same as a value. */
static inline thrum_state_def thrum_default_state_def(void) {
  thrum_state_def def;
  thrum_state_def_init(&def, sizeof def);
  return def;
}

/* --- a state's life --------------------------------------------------------------------------- */

/* Opaque: lives at the start of its block of memory. */
typedef struct thrum_state thrum_state;

/* Takes memory from the heap and lays a state at rest (q = p = 0, no load) into it; the caller owns
 * it and passes it to thrum_state_destroy. THRUM_OUT_OF_MEMORY, or what thrum_state_size says. */
THRUM_API thrum_status thrum_state_create(const thrum_model *model, const thrum_state_def *def,
                                          thrum_state **state, thrum_error *error);

/* Returns the memory of a state that thrum_state_create made; NULL does nothing. */
THRUM_API void thrum_state_destroy(thrum_state *state);

/* Bytes that a state of this model and def takes, into *size. Checks the def and the model:
 * THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT with the field and its range, THRUM_MISSING or
 * THRUM_BAD_VALUE for the model's arrays. */
THRUM_API thrum_status thrum_state_size(const thrum_model *model, const thrum_state_def *def,
                                        size_t *size, thrum_error *error);

/* Lays a state at rest (q = p = 0, no load) into `memory`, aligned to 64 bytes and of at least
 * thrum_state_size bytes. The caller owns the memory and frees it when done; *state points into it.
 * THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or what thrum_state_size says. */
THRUM_API thrum_status thrum_state_init(void *memory, size_t memory_size, const thrum_model *model,
                                        const thrum_state_def *def, thrum_state **state,
                                        thrum_error *error);

/* Bytes of a state, those of thrum_state_size; a copy of them in other memory that is aligned to 64
 * bytes is a state of its own. 0 for NULL. */
THRUM_API size_t thrum_state_bytes(const thrum_state *state);

/* Bytes of scratch that a state of this model and def works in, into *size, whether it owns or
 * borrows it. Failures as thrum_state_size. */
THRUM_API thrum_status thrum_state_scratch_size(const thrum_model *model,
                                                const thrum_state_def *def, size_t *size,
                                                thrum_error *error);

/* Lends scratch to a state whose def has borrows_scratch: `size` bytes at `scratch`, aligned to 64,
 * of any content and at least thrum_state_scratch_size; NULL takes it back. The caller owns it, and
 * it outlives its use. Any number of states, also of different models and defs, may have the same
 * scratch: it holds nothing between calls. Two calls that use one scratch must not run at the same
 * time, so each thread has its own, and lends it to the states that it is about to step; the bits
 * do not depend on it. Until a state has scratch, each call that needs it, thrum_step and all that
 * read or set p among them, answers THRUM_INVALID_ARGUMENT; thrum_batch_step needs none. A copy of
 * the state's bytes has the same scratch, a snapshot none. THRUM_INVALID_ARGUMENT for NULL and for
 * a state with scratch of its own, THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL. */
THRUM_API thrum_status thrum_state_lend(thrum_state *state, void *scratch, size_t size,
                                        thrum_error *error);

/* How many of them, from the first on, persist between calls: what a snapshot has to copy, and what
 * is equal in states of equal histories. The bytes after them are scratch of any content. */
THRUM_API size_t thrum_state_kept_bytes(const thrum_state *state);

/* Bytes of a snapshot for a file or another process: the kept bytes behind a head with version,
 * byte order and checksum. 0 for NULL. */
THRUM_API size_t thrum_state_snapshot_size(const thrum_state *state);

/* Writes a snapshot into `memory`, at any address, of `size` bytes: THRUM_BUFFER_TOO_SMALL where
 * they are less than thrum_state_snapshot_size. */
THRUM_API thrum_status thrum_state_snapshot(const thrum_state *state, void *memory, size_t size,
                                            thrum_error *error);

/* Puts a state to where a snapshot was taken; steps from there give the same bits. The state is one
 * that was made for the same model and with a def of the same sizes; dt and all else of the
 * snapshot's def come along. Any bytes may be given: THRUM_BAD_CHECKSUM for changed ones,
 * THRUM_BAD_FORMAT for none of a snapshot, THRUM_UNSUPPORTED for another version or byte order,
 * THRUM_MODEL_MISMATCH for another model or def, THRUM_BAD_VALUE for numbers that no state can
 * have, THRUM_BUFFER_TOO_SMALL, THRUM_INVALID_ARGUMENT for NULL. The state then stays as it was. */
THRUM_API thrum_status thrum_state_restore(const thrum_model *model, thrum_state *state,
                                           const void *memory, size_t size, thrum_error *error);

/* Would the thrum_state_kept_bytes bytes at `copy`, at any address, be a state of this model and of
 * the sizes of `state` when copied over it? For programs that keep states in containers of their
 * own, which have a checksum. Failures as thrum_state_restore. */
THRUM_API thrum_status thrum_state_copy_check(const thrum_model *model, const thrum_state *state,
                                              const void *copy, thrum_error *error);

/* --- setting and stepping ---------------------------------------------------------------------
 *
 * Each function checks that state and model belong together: THRUM_INVALID_ARGUMENT for NULL or
 * for memory that holds no state, THRUM_MODEL_MISMATCH for another model than that of
 * thrum_state_init: of another rank, or of other coefficients (`identity` of thrum_model). A call
 * that fails leaves every byte that persists as it was. */

/* Sets q and p of the same time (rank each; NULL means zero). Counters, load, time and what has
 * flowed stay; the history of the solver is forgotten, and the mean load of the step before counts
 * as zero. THRUM_BAD_VALUE for NaN or Inf, THRUM_NOT_FINITE where the forces at q overflow. */
THRUM_API thrum_status thrum_state_set(const thrum_model *model, thrum_state *state,
                                       const double *q, const double *p, thrum_error *error);

/* Writes q and p of the same time (rank each; either may be NULL). Uses the state's scratch.
 * THRUM_SINGULAR where tangent damping has no solution, THRUM_NOT_FINITE where p overflows. */
THRUM_API thrum_status thrum_state_get(const thrum_model *model, thrum_state *state, double *q,
                                       double *p, thrum_error *error);

/* Sets the reduced external load (rank) [kg^1/2 m/s^2] of the steps to come: its mean over each
 * step (design 5). It stays until set again; NULL means zero. See thrum/external_load.h for forces
 * at vertices. THRUM_BAD_VALUE for NaN or Inf. */
THRUM_API thrum_status thrum_state_set_force(const thrum_model *model, thrum_state *state,
                                             const double *force, thrum_error *error);

/* Resets the material to one that has not flowed: it has no plastic strain and no plastic work, and
 * the plastic work is taken out of `dissipated` of the report. q, p, counters, load and time stay.
 * The strain energy changes at once, so an account of energies begins anew. THRUM_OK without a
 * change for a state that cannot flow. */
THRUM_API thrum_status thrum_state_clear_plastic(const thrum_model *model, thrum_state *state,
                                                 thrum_error *error);

/* Copies the plastic strain of `from` into `state`, for bodies whose state is made anew. The two
 * models must have the same cubature points, but may differ in rank and scale. Plastic work stays
 * counted in `from`. The strain energy changes at once; what was released of it is found by the
 * next call that has the model, also by one that fails. THRUM_INVALID_ARGUMENT for NULL,
 * THRUM_MODEL_MISMATCH where one of the states has other points or cannot flow. */
THRUM_API thrum_status thrum_state_take_plastic(thrum_state *state, const thrum_state *from,
                                                thrum_error *error);

/* Largest plastic strain of all points, the norm of the logarithms of the principal plastic
 * stretches; 0 for a state that has not flowed and for NULL. Any thread that only reads the state.
 */
THRUM_API double thrum_state_plastic_strain(const thrum_state *state);

/* The stiffness of the cubature points of a state that may flow over that of the whole body at
 * small strains, along the shape where that is most. Up to 1 a body that has not flowed is the
 * elastic one; beyond, its points see such shapes shortened by the root of it (18.7), and points
 * that are trained on the yield (precompute --yield), or more of them, are better. 0 for a state
 * that cannot flow and for NULL. Any thread that only reads the state. */
THRUM_API double thrum_state_point_stiffness(const thrum_state *state);

/* Changes the time step [s] between two steps, as often as wanted (design 4). q and p of the
 * present time stay as they are, and so do the target energy, the energy balance, a switch to
 * another scheme, and what solves have learnt. The explicit modes are those for the longest step
 * lately. Costs an inversion of the implicit modes' Jacobian, and two forces where momenta are
 * staggered. THRUM_INVALID_ARGUMENT unless finite and > 0, or as thrum_state_get. */
THRUM_API thrum_status thrum_state_set_dt(const thrum_model *model, thrum_state *state, double dt,
                                          thrum_error *error);

/* Number of steps of dt [s] that `time` [s] takes: time / dt rounded up, where a time within a
 * millionth of a step of a whole number is that number, so 0.3 s are 100 steps of 0.003 s. 0 for a
 * time <= 0, a dt <= 0 or NaN; INT64_MAX where it does not fit. Any thread. */
THRUM_API int64_t thrum_step_count(double time, double dt);

/* Advances by one step of dt. Every status >= 0 is a step that was made:
 *
 *   THRUM_OK           by the scheme of the def
 *   THRUM_ENERGY_GREW  (> 0) the state has gained energy that neither its start nor its loads
 *                      explain, as much again as the largest that they do: what it holds is no
 *                      motion of the body any more. `energy` and a monitored imexv keep an account
 *                      instead. The others look after each step that moves more than those lately
 *                      and every 16 steps, since a look costs an energy: a slow growth is said up
 *                      to 16 steps late, and grown_steps lacks these
 *   THRUM_FELL_BACK    (> 0) quasi-Newton did not solve it, but a level of the fallback chain did
 *   THRUM_SWITCHED     (> 0) imexv, fox-goodwin: the monitor has switched the state to another
 *                      scheme, mostly `energy`, and that made this step, as it will the next; the
 *                      report has the scheme, the steps so made, and when the first switch was
 *
 * A step of several kinds has the first of them in this list. THRUM_NOT_CONVERGED or
 * THRUM_NOT_FINITE (< 0) where no level solved it. */
THRUM_API thrum_status thrum_step(const thrum_model *model, thrum_state *state, thrum_error *error);

/* Makes `count` >= 0 steps, with the bits of as many calls of thrum_step, and ends before at the
 * first that fails; *made (may be NULL) gets how many were made, also then. Returns the failure,
 * else the first in the list of thrum_step of what the steps returned, THRUM_OK if none was
 * notable. THRUM_INVALID_ARGUMENT for count < 0. */
THRUM_API thrum_status thrum_steps(const thrum_model *model, thrum_state *state, int64_t count,
                                   int64_t *made, thrum_error *error);

/* --- what a state says of itself -------------------------------------------------------------- */

/* Energies of q and p of the same time [J]. */
typedef struct thrum_energies {
  double kinetic;   /* 1/2 |p|^2 */
  double potential; /* V(q) */
  double total;     /* their sum */
  double high;      /* 1/2 sum over the modes implicit at rest of p_i^2 + omega_i^2 q_i^2 */
} thrum_energies;

/* Energies at the present step. Uses the state's scratch. THRUM_SINGULAR as thrum_state_get,
 * THRUM_NOT_FINITE where an energy overflows. */
THRUM_API thrum_status thrum_state_energies(const thrum_model *model, thrum_state *state,
                                            thrum_energies *energies, thrum_error *error);

/* How a linear undamped mode vibrates, and how as it is stepped. A step keeps the frequency of a
 * mode only up to an error that grows with h omega. */
typedef struct thrum_stepped_mode {
  double hertz;         /* omega / 2 pi [Hz] */
  double stepped_hertz; /* frequency as it is stepped, at most 1 / (2 dt) [Hz]; NaN: the step is
                           beyond its limit of stability for it, and it does not vibrate */
  double factor;        /* of its amplitude in a step: 1: kept, below: drained, above: it grows */
} thrum_stepped_mode;

/* Fills `modes` (rank, ascending in frequency) for the dt, scheme and split that the state has now,
 * at rest and without damping. Any thread that only reads the state. */
THRUM_API thrum_status thrum_state_stepped_modes(const thrum_model *model, const thrum_state *state,
                                                 thrum_stepped_mode *modes, thrum_error *error);

/* Counters of a state since init, and how it stands. Fields marked imexv stay zero for the other
 * integrators; those of the monitor also without `adaptive`. */
typedef struct thrum_state_report {
  int64_t steps;           /* completed steps */
  double time;             /* steps at their dt, summed [s] */
  int64_t iterations;      /* of implicit solves, over all steps */
  int64_t factorisations;  /* of their Jacobians */
  int64_t newton_steps;    /* fallback level 2: full Newton solved after quasi-Newton had failed */
  int64_t energy_steps;    /* fallback level 3, imexv, fox-goodwin: a step of `energy` stood in */
  int64_t substep_steps;   /* fallback level 4: shorter steps stood in */
  int64_t switched_steps;  /* imexv, fox-goodwin: steps of `energy` after a switch to it */
  int64_t first_switch;    /* imexv, fox-goodwin: steps before the first of them; -1: none */
  int64_t grown_steps;     /* steps that returned THRUM_ENERGY_GREW */
  int64_t split_changes;   /* imexv: changes of E and I by the monitor */
  int64_t scheme_switches; /* imexv, fox-goodwin: changes of the scheme */
  int64_t corrections;     /* imexv: energy-drift corrections (momentum rescalings) */
  double corrected;        /* imexv: energy that they added, net [J] */
  int64_t single_steps;    /* energy: steps that took a single force evaluation */
  int64_t tightened;       /* energy: how often spurious work has tightened the tolerance */
  double spurious;         /* energy: what unverified corrections have moved from the modes explicit
                              at rest to the others, net, estimated [J]; a leak that grows is one
                              that the total energy hides */
  double stability_number_last; /* imexv: dt sqrt(rho), rho the spectral radius of the stiffness
                                   treated explicitly; stable below 2 (design 4) */
  double stability_number_peak; /* its largest value */
  double balance_last;     /* imexv: energy less work plus dissipation, relative to the energy */
  double balance_peak;     /* its largest magnitude */
  double dissipated;       /* energy that damping and plastic flow took [J]; the tangent form of
                              damping may feed some in */
  double plastic_work;     /* of it, that plastic flow took: strain energy, never negative [J] */
  thrum_scheme scheme;     /* in use now */
  int32_t explicit_modes;  /* |E| now; r for verlet and rk4, else 0 but for imexv */
  int32_t implicit_modes;  /* |I| now */
  int32_t iterations_last; /* of the last step */
  double residual_last;    /* of its solve, relative to the increment; an upper estimate where the
                              last iterate was not evaluated */
} thrum_state_report;

/* The report of a state; all zero for NULL. */
THRUM_API thrum_state_report thrum_state_report_get(const thrum_state *state);

#ifdef __cplusplus
}
#endif
#endif
