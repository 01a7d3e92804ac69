/* Gradients of runs: how what was observed of a run changes with its start, its forces, its damping
 * and its material, for about the time of two more runs, however many numbers there are.
 *
 *   thrum_tape_def def = thrum_default_tape_def();
 *   def.steps = steps;
 *   thrum_tape_create(model, &def, &tape, &error);
 *   thrum_tape_start(model, tape, state, q0, p0, &error);
 *   for (k = 0; k < steps; k++)
 *     thrum_tape_step(model, tape, state, force + k * rank, &error);
 *   ... q_bar, p_bar: derivatives of the loss by q and p after each step ...
 *   thrum_tape_pull_back(model, tape, q_bar, p_bar, &gradient, &error);
 *
 * A tape steps an ordinary state and keeps q, p and the force of each step. The gradient is that of
 * the equation of each step (thrum/step_equation.h) at what was stepped, with an exact Jacobian:
 * for a step that solves its equation to rounding it is the gradient of the run. A state solves to
 * the `tolerance` of its def, and gradients then err by about as much: where they are to agree with
 * differences of runs, set the tolerance to 1e-13.
 *
 * Steps by energy, newmark, midpoint and verlet of one dt, damping at rest, models of polynomials,
 * of cubature points and condensed ones, and bodies that act (thrum/actuation.h). What has no
 * derivative here is refused with THRUM_UNSUPPORTED: other integrators, tangent damping, plastic
 * flow, what follows with a damping_beta, and a run with a step that a fallback level has divided.
 *
 * A force has the coordinates of thrum_condensed_shape_model (`width`): of a model that is not
 * condensed, those of the model.
 *
 * The library needs libthrum and libm. Only thrum_tape_create allocates. A tape belongs to one
 * thread at a time. Equations: docs/mathematics/22_gradients.md. Source: Giles & Pierce 2000, An
 * introduction to the adjoint approach to design, doi:10.1023/A:1011430410075.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_GRADIENT_H
#define THRUM_GRADIENT_H

#include "thrum/api.h"
#include "thrum/contact.h"
#include "thrum/model.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct thrum_tape thrum_tape;

/* What a pass takes for the derivative of a step with contact that has none. */
typedef enum thrum_tape_subgradient {
  THRUM_SUBGRADIENT_NONE = 0, /* it refuses the step */
  THRUM_SUBGRADIENT_FIXED = 1 /* that of the step where each touch keeps the law that it had: what
                                 rests or sticks stays so, an impact throws back by the share that
                                 it did, and what a spring has stored stays. It is that of the step
                                 as a neighbouring run makes it, as long as the same places touch in
                                 the same steps; by when they touch it does not change. */
} thrum_tape_subgradient;

/* --- a tape's life ---------------------------------------------------------------------------- */

typedef struct thrum_tape_def {
  uint32_t cookie; /* sizeof(thrum_tape_def), from thrum_tape_def_init */
  int64_t steps;   /* that there is room for, 1 or more [1] */

  /* 0: q and p of all steps are kept, with forces and levels 24 rank + 8 (width + actuators) bytes
   * a step. Else the state is kept this often, and the steps between are made again, with the same
   * bits, when a pass comes to them: a pass costs one run more. Memory is least, and grows with the
   * root of `steps`, where the square of this is 24 rank steps over thrum_state_kept_bytes. */
  int64_t checkpoints;
  const thrum_state *state; /* with checkpoints: the one to be recorded, for its size */
  int64_t touches; /* with contact: room for so many touches of all steps together; one that sticks
                      takes 3. They go without checkpoints. 0: steps without contact [1] */
  thrum_tape_subgradient subgradient; /* default: none */

  /* What passes are given and give of q and p has a row after each `every` steps, the start first:
   * steps / every + 1 of them, also where it says (steps + 1) below. 1 or more; larger: less memory
   * beside a tape with checkpoints, for a loss that sees less [1] */
  int64_t every;
} thrum_tape_def;

/* A def with every default set: 1 step, no checkpoints. size: of the def as the caller knows it
 * (docs/versioning.md). Any thread. */
THRUM_API void thrum_tape_def_init(thrum_tape_def *def, size_t size);

/* The same as a value. */
static inline thrum_tape_def thrum_default_tape_def(void) {
  thrum_tape_def def;
  thrum_tape_def_init(&def, sizeof def);
  return def;
}

/* Bytes of a tape of this model and def, into *size. THRUM_UNINITIALISED_DEF,
 * THRUM_INVALID_ARGUMENT with the field, THRUM_OUT_OF_MEMORY where no memory could hold it. */
THRUM_API thrum_status thrum_tape_size(const thrum_model *model, const thrum_tape_def *def,
                                       size_t *size, thrum_error *error);

/* Lays an empty tape into `memory`, aligned to 64 and of at least thrum_tape_size bytes, which the
 * caller owns. THRUM_MISALIGNED, THRUM_BUFFER_TOO_SMALL, or what thrum_tape_size says. */
THRUM_API thrum_status thrum_tape_init(void *memory, size_t memory_size, const thrum_model *model,
                                       const thrum_tape_def *def, thrum_tape **tape,
                                       thrum_error *error);

/* The same from the heap; the caller passes it to thrum_tape_destroy. THRUM_OUT_OF_MEMORY, or what
 * thrum_tape_size says. */
THRUM_API thrum_status thrum_tape_create(const thrum_model *model, const thrum_tape_def *def,
                                         thrum_tape **tape, thrum_error *error);
THRUM_API void thrum_tape_destroy(thrum_tape *tape);

/* --- recording -------------------------------------------------------------------------------- */

/* Sets the state to q and p (rank each; NULL: zero) as thrum_state_set does, and begins the tape
 * anew there. The state's def is the one it was made with. THRUM_UNSUPPORTED as
 * thrum_step_equation_get and for what follows with a damping_beta, THRUM_MODEL_MISMATCH for a tape
 * of another rank, or of another state's size, else as thrum_state_set. */
THRUM_API thrum_status thrum_tape_start(const thrum_model *model, thrum_tape *tape,
                                        thrum_state *state, const double *q, const double *p,
                                        thrum_error *error);

/* Sets the force of the step (width; NULL: none) [kg^1/2 m/s^2] as thrum_state_set_load does, makes
 * it, and records it. With checkpoints the force is read again by the passes: it is a row of one
 * array that stays until then, right behind that of the step before, or NULL in all steps; a pass
 * that finds it changed is refused, THRUM_INVALID_ARGUMENT. Returns what thrum_step does; the tape
 * keeps no step that fails. THRUM_BUFFER_TOO_SMALL where the tape is full, THRUM_UNSUPPORTED where
 * dt was changed since the start, THRUM_INVALID_ARGUMENT for a state that is not where the tape
 * ends, or another array. */
THRUM_API thrum_status thrum_tape_step(const thrum_model *model, thrum_tape *tape,
                                       thrum_state *state, const double *force, thrum_error *error);

/* Makes and records a step of thrum_contact_step, whose load is that of the environment: of a body
 * that is held, and planes and boxes that each touches by points. It has a derivative by start,
 * forces, damping, stiffness and density. What springs push, and what slides, is smooth; impacts,
 * rest and stick are not, and neither is energy that an elastic touch gives back after the step:
 * passes refuse such a step with its time, vertex and obstacle, or take the subgradient of the
 * def. A contact is solved to the tolerance of its def, by which gradients err. THRUM_UNSUPPORTED
 * for free, condensed and acting bodies, pulls, spheres, and newmark where touches take energy,
 * THRUM_BUFFER_TOO_SMALL where the tape has no room for the touches of a step that was made, else
 * as thrum_tape_step and thrum_contact_step. */
THRUM_API thrum_status thrum_tape_contact_step(const thrum_model *model, thrum_tape *tape,
                                               thrum_state *state, thrum_contact *contact,
                                               const thrum_contact_environment *environment,
                                               thrum_error *error);

/* Makes `count` >= 0 steps of thrum_tape_step with the rows of `force` (count x width; NULL: none),
 * and ends before at the first that fails; *made (may be NULL) gets how many were made, also then.
 * Returns as thrum_steps. */
THRUM_API thrum_status thrum_tape_run(const thrum_model *model, thrum_tape *tape,
                                      thrum_state *state, const double *force, int64_t count,
                                      int64_t *made, thrum_error *error);

/* The same with the levels of each step (count x thrum_model_actuators; NULL: those of the state),
 * as thrum_state_set_actuation sets them. The tape keeps the levels of all its steps, and those
 * that a caller sets between two of them too. Failures also as thrum_state_set_actuation. */
THRUM_API thrum_status thrum_tape_run_levels(const thrum_model *model, thrum_tape *tape,
                                             thrum_state *state, const double *force,
                                             const double *levels, int64_t count, int64_t *made,
                                             thrum_error *error);

/* Runs of one model side by side, each on a tape of its own that was started with its state. The
 * caller's, and only read. */
typedef struct thrum_tape_batch {
  const thrum_model *model;
  thrum_tape *const *tapes;   /* count */
  thrum_state *const *states; /* count, all different */
  int64_t count;              /* 1 or more; more: steps are faster (thrum/batch.h) */
  thrum_status *statuses;     /* count: of each in the last step */
  void *workspace;            /* of thrum_batch_size bytes, aligned to 64 */
  size_t workspace_size;
} thrum_tape_batch;

/* Makes `steps` >= 0 steps of all of them by thrum_batch_step with the rows of `force` (count x
 * steps x width; NULL: none), and records them: the same bits as by thrum_tape_run. It ends after
 * the first step in which one fails, which the others have made; *made (may be NULL) gets how many
 * all have. Passes then go over each tape. Returns as thrum_batch_step, or as thrum_tape_step. */
THRUM_API thrum_status thrum_tape_batch_run(const thrum_tape_batch *batch, const double *force,
                                            int64_t steps, int64_t *made, thrum_error *error);

/* Steps recorded since the start; 0 for NULL. */
THRUM_API int64_t thrum_tape_steps(const thrum_tape *tape);

/* q and p after each step, the start first: (steps + 1) x rank, in the tape and valid until it is
 * started again. NULL for NULL, and with checkpoints, where the state tells them as it goes. */
THRUM_API const double *thrum_tape_q(const thrum_tape *tape);
THRUM_API const double *thrum_tape_p(const thrum_tape *tape);

/* --- derivatives ------------------------------------------------------------------------------ */

/* A part of the strain energy, such as that of a region of the body, in the coordinates of the
 * model: 1/2 q L q and a cubic and a quartic form. A factor of it turns the modes, unless L is
 * diagonal: its derivative is that of the body whose modes were found anew, seen in coordinates
 * that stay. */
typedef struct thrum_energy_part {
  const double *linear; /* L, rank x rank, both triangles [1/s^2] */
  /* A model of the same rank, best a packed one, whose energy, with its omega2, is added to that of
   * L. It need not have an identity. NULL: L alone, such as that of a spring
   * (thrum_spring_linear). */
  const struct thrum_model *form;
  /* M of a part that moves mass, rank x rank, both triangles; NULL: none. A share t of it is one in
   * coordinates x = (1 + 1/2 t M) q that keep unit mass, while all that a caller gives and sees, q
   * and p of the run and the forces, stays that of the coordinates q. */
  const double *mass;
} thrum_energy_part;

/* --- moduli and densities of regions ---------------------------------------------------------- */

/* The parts of the parameters of a model (thrum/parameters.h), in their order: lambda, mu and
 * density of each region. */
typedef struct thrum_parameter_parts thrum_parameter_parts;

/* Makes them from the heap; the caller passes them to thrum_parameter_parts_destroy. The model may
 * go before. THRUM_UNSUPPORTED for a model without parameters, THRUM_OUT_OF_MEMORY,
 * THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_parameter_parts_create(const thrum_model *model,
                                                    thrum_parameter_parts **parts,
                                                    thrum_error *error);
THRUM_API void thrum_parameter_parts_destroy(thrum_parameter_parts *parts);

/* For `parts` and `part_count` of a thrum_tape_gradient, whose `part` then has the derivatives per
 * Pa and per kg/m^3, or a direction in these units: of the body that thrum_model_set_parameters
 * makes, where displacements, velocities and forces at the start and of each step are held, and
 * alpha and beta of its damping. The parts lie in the object. NULL and 0 for NULL. */
THRUM_API const thrum_energy_part *thrum_parameter_parts_list(const thrum_parameter_parts *parts);
THRUM_API int64_t thrum_parameter_parts_count(const thrum_parameter_parts *parts);

/* L of a spring of 1 N/m from the mean of `count` vertices to the ground, along `direction` (a unit
 * vector; NULL: in all directions), into `linear` (rank x rank) [1/kg]: the part by which a run
 * changes with its stiffness, and, times its stiffness, that of a body which is hung on one.
 * THRUM_MISSING for a model without a basis, THRUM_INVALID_ARGUMENT for NULL, no vertices or one
 * that there is not. Any thread. */
THRUM_API thrum_status thrum_spring_linear(const thrum_model *model, const int32_t *vertices,
                                           int64_t count, const double *direction, double *linear,
                                           thrum_error *error);

/* Derivatives of a loss, or a direction of the same numbers. Arrays are the caller's, and each may
 * be NULL: not wanted, or a direction of zero. */
typedef struct thrum_tape_gradient {
  double *q, *p;    /* by the start (rank each) */
  double *force;    /* by the force of each step (steps x width) */
  double *levels;   /* by the levels of the actuators in each step (steps x actuators) */
  double *damping;  /* by D of each mode (rank) [1/s], apart from alpha and beta: of a ratio zeta
                       of a linear mode it is 2 omega times that */
  double alpha;     /* by damping_alpha [1/s] */
  double beta;      /* by damping_beta [s] */
  double stiffness; /* by a factor of Young's modulus of the whole body, at 1, with beta and the
                       levels held: muscles follow it, pressures, tendons and gases do not */
  double density;   /* by a factor of its density, at 1, where q, p, the force at each point and
                       alpha and beta are held */
  const thrum_energy_part *parts; /* part_count */
  double *part; /* by a part's share, where that much of it is added to V (part_count); D of a mode
                   follows its frequency by beta alone */
  int64_t part_count;
} thrum_tape_gradient;

/* The gradient of a loss into *gradient, from its derivatives by q and p after each step, the start
 * first ((steps + 1) x rank each; NULL: it does not depend on them). Costs about a tangent
 * stiffness and 2/3 rank^3 a step. THRUM_UNSUPPORTED with the step and its time where one was
 * divided by a fallback level, THRUM_SINGULAR, THRUM_BAD_VALUE where a derivative given is not
 * finite, THRUM_NOT_FINITE where the gradient is not. The outputs then stay as they were, but for
 * `part`, `force` and `levels`, in which the sums are made: where a pass fails on its way they are
 * all 0. */
THRUM_API thrum_status thrum_tape_pull_back(const thrum_model *model, thrum_tape *tape,
                                            const double *q_bar, const double *p_bar,
                                            thrum_tape_gradient *gradient, thrum_error *error);

/* The gradient of a loss of a body at rest, T(q) dq = df - R ds: from its derivative q_bar by q
 * (rank), an equilibrium under a load, into *force_bar (rank), its derivative by the load, and
 * *stiffness_bar, that by a factor of Young's modulus. Either may be NULL. work: rank (rank + 3) +
 * thrum_work_count doubles. THRUM_SINGULAR at a limit or bifurcation point, THRUM_UNSUPPORTED for a
 * condensed model, and with stiffness_bar for bodies that act, THRUM_INVALID_ARGUMENT for NULL,
 * THRUM_BAD_VALUE for numbers that are not finite. */
THRUM_API thrum_status thrum_rest_pull_back(const thrum_model *model, const double *q,
                                            const double *q_bar, double *force_bar,
                                            double *stiffness_bar, double *work,
                                            thrum_error *error);

/* The change of q and p after each step, the start first ((steps + 1) x rank each), for a direction
 * of what they depend on: what the run would change by, to first order. Failures as
 * thrum_tape_pull_back, but that the content of the arrays is then undefined. */
THRUM_API thrum_status thrum_tape_push_forward(const thrum_model *model, thrum_tape *tape,
                                               const thrum_tape_gradient *direction, double *q,
                                               double *p, thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
