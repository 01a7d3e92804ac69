/* Many bodies on an accelerator: states of one model that OpenCL steps on a graphics processor, or
 * on the processor by PoCL.
 *
 *   thrum_accelerator_create(&def, &accelerator, &error);
 *   thrum_crowd_create(accelerator, model, &crowd_def, &crowd, &error);
 *   thrum_crowd_set(crowd, q, p, rank, &error);
 *   thrum_crowd_step(crowd, 100, NULL, &error);
 *   thrum_crowd_get(crowd, q, p, rank, &error);
 *
 * A crowd steps the equations of thrum/step_equation.h: `verlet`, `midpoint`, and `energy` by the
 * trapezoidal discrete gradient, the last two by a fixed number of Newton iterations. The cubic and
 * quartic coefficients are of single precision, and so are their sums; q, p, the linear part and
 * the residual are of double precision, or, where the def asks for it, of single precision too. So
 * a step differs from one of thrum_step by about 1e-7 of the force of what is not linear. All sums
 * have a fixed order: a device gives the same bits in each run.
 *
 * Models of polynomials, condensed ones too, and of cubature points of Saint Venant-Kirchhoff
 * material. What a crowd cannot step is refused with THRUM_UNSUPPORTED: other laws, actuators,
 * other integrators, tangent damping, damping_beta of a condensed model.
 *
 * The library needs libthrum, libm and the C library's dlopen; OpenCL 1.2 is looked for by
 * thrum_accelerator_create. Memory: _create allocates, on the host and on the device; a step does
 * not. An accelerator and its crowds belong to one thread at a time; the accelerator must outlive
 * its crowds, the model need not. The drivers start threads of their own.
 * Source of the method: docs/accelerator.md.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_ACCELERATOR_H
#define THRUM_ACCELERATOR_H

#include "thrum/api.h"
#include "thrum/model.h"
#include "thrum/state.h"

#ifdef __cplusplus
extern "C" {
#endif

/* --- devices ---------------------------------------------------------------------------------- */

typedef struct thrum_accelerator thrum_accelerator;

typedef struct thrum_accelerator_def {
  uint32_t cookie; /* sizeof(thrum_accelerator_def), from thrum_accelerator_def_init */
  int32_t device;  /* which of thrum_accelerator_count, from 0 [1]; default 0 */
  int32_t single;  /* 1: single precision throughout, also where the device has double; default 0 */
  int32_t reserved; /* 0 */
} thrum_accelerator_def;

/* A def with every default set. size: of the def as the caller knows it (docs/versioning.md). Any
 * thread. */
THRUM_API void thrum_accelerator_def_init(thrum_accelerator_def *def, size_t size);

/* The same as a value. */
static inline thrum_accelerator_def thrum_default_accelerator_def(void) {
  thrum_accelerator_def def;
  thrum_accelerator_def_init(&def, sizeof def);
  return def;
}

/* The devices of all platforms of this machine, into *count. THRUM_MISSING where there is no
 * OpenCL, with what to install. */
THRUM_API thrum_status thrum_accelerator_count(int32_t *count, thrum_error *error);

/* Takes a device; the caller owns *accelerator. THRUM_UNINITIALISED_DEF, THRUM_INVALID_ARGUMENT for
 * a number that no device has, THRUM_MISSING where there is no OpenCL or no device,
 * THRUM_UNSUPPORTED for a device without double precision unless `single` is set,
 * THRUM_OUT_OF_MEMORY. */
THRUM_API thrum_status thrum_accelerator_create(const thrum_accelerator_def *def,
                                                thrum_accelerator **accelerator,
                                                thrum_error *error);
THRUM_API void thrum_accelerator_destroy(thrum_accelerator *accelerator); /* NULL does nothing */

typedef struct thrum_accelerator_info {
  char name[128], platform[128]; /* as the driver gives them */
  int64_t memory, buffer_most;   /* of the device, and of one buffer [bytes] */
  int32_t units;                 /* compute units [1] */
  int32_t has_double;            /* 1: it has double precision */
  int32_t single;                /* 1: it is not used here */
} thrum_accelerator_info;

/* What the device is, into *info. THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_accelerator_get_info(const thrum_accelerator *accelerator,
                                                  thrum_accelerator_info *info, thrum_error *error);

/* --- crowds ----------------------------------------------------------------------------------- */

typedef struct thrum_crowd thrum_crowd;

typedef struct thrum_crowd_def {
  uint32_t cookie;    /* sizeof(thrum_crowd_def), from thrum_crowd_def_init */
  int32_t iterations; /* of Newton in each step, 1 to 32 [1]; default 4 */
  int64_t count;      /* of bodies, >= 1 [1]; default 1 */
  double tolerance;   /* last correction of an increment, over the increment, up to which a step is
                         taken, > 0 [1]; default 1e-4. One below 1e-7 of q is rounding, and taken */
  thrum_state_def state; /* integrator, dt, damping_alpha, damping_beta and frequency_matched of
                            all bodies; the rest is not read */
} thrum_crowd_def;

/* As thrum_accelerator_def_init. */
THRUM_API void thrum_crowd_def_init(thrum_crowd_def *def, size_t size);

/* The same as a value. */
static inline thrum_crowd_def thrum_default_crowd_def(void) {
  thrum_crowd_def def;
  thrum_crowd_def_init(&def, sizeof def);
  return def;
}

/* Makes a crowd at rest without loads; the caller owns it. THRUM_UNINITIALISED_DEF,
 * THRUM_INVALID_ARGUMENT with the member of the def, THRUM_UNSUPPORTED as said at the top,
 * THRUM_OUT_OF_MEMORY with what the device would need and has, or as thrum_state_create. */
THRUM_API thrum_status thrum_crowd_create(thrum_accelerator *accelerator, const thrum_model *model,
                                          const thrum_crowd_def *def, thrum_crowd **crowd,
                                          thrum_error *error);
THRUM_API void thrum_crowd_destroy(thrum_crowd *crowd); /* NULL does nothing */

/* Sets q and p of all bodies: rank doubles of body n begin at n * stride; a stride of 0 gives all
 * the same. Either may be NULL: zero. A body that had stopped steps again. THRUM_INVALID_ARGUMENT
 * for another stride below the rank, THRUM_BAD_VALUE for a number that is not finite, or in single
 * precision beyond its range, with the body; nothing is set then. */
THRUM_API thrum_status thrum_crowd_set(thrum_crowd *crowd, const double *q, const double *p,
                                       int64_t stride, thrum_error *error);

/* Sets the reduced loads of the steps to come (thrum_state_set_force), as thrum_crowd_set does;
 * NULL: none. */
THRUM_API thrum_status thrum_crowd_set_forces(thrum_crowd *crowd, const double *forces,
                                              int64_t stride, thrum_error *error);

/* Steps all bodies `steps` times (>= 0). A body whose last correction is beyond the tolerance, or
 * is not finite, stops before that step: it stays as it was there, the others go on. stopped
 * (count, may be NULL) gets for each body the steps that it has made since it was set, or -1 where
 * it has not stopped. THRUM_NOT_CONVERGED where one has stopped, with its number and what to do. */
THRUM_API thrum_status thrum_crowd_step(thrum_crowd *crowd, int64_t steps, int64_t *stopped,
                                        thrum_error *error);

/* Writes q and p as thrum_crowd_set reads them; either may be NULL. The stride is the rank at
 * least. */
THRUM_API thrum_status thrum_crowd_get(thrum_crowd *crowd, double *q, double *p, int64_t stride,
                                       thrum_error *error);

/* Writes the kinetic and the strain energy of each body [J] (count each; either may be NULL). */
THRUM_API thrum_status thrum_crowd_energies(thrum_crowd *crowd, double *kinetic, double *strain,
                                            thrum_error *error);

/* --- a whole mesh -----------------------------------------------------------------------------
 *
 * The body of a model's mesh, unreduced: its tetrahedra of four nodes, or of ten with straight
 * edges, with the consistent mass. Each step is solved by Newton, each of its corrections by
 * conjugate gradients that never store the tangent stiffness. */

typedef struct thrum_mesh_body thrum_mesh_body;

typedef enum thrum_mesh_scheme {
  THRUM_MESH_MIDPOINT = 0,      /* implicit midpoint rule, of order 2 */
  THRUM_MESH_IMPLICIT_EULER = 1 /* of order 1: it damps, fast modes above all */
} thrum_mesh_scheme;

typedef enum thrum_mesh_law {
  THRUM_MESH_STVK = 0,       /* Saint Venant-Kirchhoff */
  THRUM_MESH_NEO_HOOKEAN = 1 /* stable neo-Hookean: Smith, De Goes & Kim 2018 */
} thrum_mesh_law;

typedef struct thrum_mesh_body_def {
  uint32_t cookie;          /* sizeof(thrum_mesh_body_def), from thrum_mesh_body_def_init */
  thrum_mesh_scheme scheme; /* default midpoint */
  thrum_mesh_law law;       /* of all tetrahedra; default Saint Venant-Kirchhoff */
  int32_t iterations;       /* of Newton in a step at most, >= 1 [1]; default 12 */
  double dt;                /* time step [s], > 0; default 0.003 */
  double damping;           /* mass-proportional [1/s], >= 0; default 0 */
  double tolerance; /* last correction of the increment, over the increment, with which a step is
                       solved, >= 0 [1]; default 0: 1e-8, in single precision 1e-4. One below 1e-12
                       (1e-6) of the displacement is rounding, and solved as well */
  double solver_tolerance;   /* residual at which conjugate gradients end, relative, in [0, 1) [1];
                                default 0: 1e-6, in single precision 1e-4 */
  int32_t solver_iterations; /* of conjugate gradients at most, >= 1 [1]; default 2000 */
  int32_t reserved;          /* 0 */
} thrum_mesh_body_def;

/* As thrum_accelerator_def_init. */
THRUM_API void thrum_mesh_body_def_init(thrum_mesh_body_def *def, size_t size);

/* The same as a value. */
static inline thrum_mesh_body_def thrum_default_mesh_body_def(void) {
  thrum_mesh_body_def def;
  thrum_mesh_body_def_init(&def, sizeof def);
  return def;
}

/* Counts since the body was made. */
typedef struct thrum_mesh_body_report {
  int64_t steps, iterations, solver_iterations; /* of Newton, of conjugate gradients */
} thrum_mesh_body_report;

/* Makes the body at rest; the caller owns it. The model need not stay. THRUM_UNINITIALISED_DEF,
 * THRUM_INVALID_ARGUMENT with the member of the def, THRUM_MISSING for a model without a mesh,
 * THRUM_UNSUPPORTED for elements, springs, actuators or materials that a device does not step,
 * THRUM_OUT_OF_MEMORY. */
THRUM_API thrum_status thrum_mesh_body_create(thrum_accelerator *accelerator,
                                              const thrum_model *model,
                                              const thrum_mesh_body_def *def,
                                              thrum_mesh_body **body, thrum_error *error);
THRUM_API void thrum_mesh_body_destroy(thrum_mesh_body *body); /* NULL does nothing */

/* Displacements [m] and velocities [m/s], 3 vertex_count each; NULL: zero. Held components are
 * taken as zero. THRUM_BAD_VALUE for a number that is not finite, or out of range: nothing is set.
 */
THRUM_API thrum_status thrum_mesh_body_set(thrum_mesh_body *body, const double *u, const double *v,
                                           thrum_error *error);

/* Forces of the steps to come [N], 3 vertex_count; NULL: none. */
THRUM_API thrum_status thrum_mesh_body_set_forces(thrum_mesh_body *body, const double *forces,
                                                  thrum_error *error);

/* Makes `steps` steps (>= 0). THRUM_NOT_CONVERGED where one is not solved, with what to do: the
 * body then stays at the end of the step before. */
THRUM_API thrum_status thrum_mesh_body_step(thrum_mesh_body *body, int64_t steps,
                                            thrum_error *error);

/* Writes u and v, 3 vertex_count each; either may be NULL. */
THRUM_API thrum_status thrum_mesh_body_get(thrum_mesh_body *body, double *u, double *v,
                                           thrum_error *error);

/* What it has done, into *report. THRUM_INVALID_ARGUMENT for NULL. */
THRUM_API thrum_status thrum_mesh_body_get_report(const thrum_mesh_body *body,
                                                  thrum_mesh_body_report *report,
                                                  thrum_error *error);

#ifdef __cplusplus
}
#endif
#endif
