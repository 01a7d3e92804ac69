/* Bodies, loads and time steps far outside the usual, and one body in many systems of units.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_VALIDATION_EXPERIMENTS_EXTREMES_H
#define THRUM_VALIDATION_EXPERIMENTS_EXTREMES_H

#include "platform/allocate.h"
#include "precompute/precompute.h"
#include "validation/experiments/experiment_body.h"
#include "validation/experiments/scheme.h"

/* The quantity that is extreme. X(name); validation/report.py has the texts for people. */
#define EXPERIMENT_SUBJECT_LIST(X)                                                                 \
  X(stiffness)                                                                                     \
  X(poisson)                                                                                       \
  X(size)                                                                                          \
  X(density)                                                                                       \
  X(load)                                                                                          \
  X(snap)                                                                                          \
  X(tet)                                                                                           \
  X(square)                                                                                        \
  X(rank)                                                                                          \
  X(resonance)                                                                                     \
  X(rate)

typedef enum experiment_subject {
#define X(name) EXPERIMENT_SUBJECT_##name,
  EXPERIMENT_SUBJECT_LIST(X)
#undef X
      EXPERIMENT_SUBJECT_COUNT
} experiment_subject;

extern const char *const experiment_subject_names[EXPERIMENT_SUBJECT_COUNT];

typedef enum experiment_shape {
  EXPERIMENT_SHAPE_BEAM = 0, /* what `cells` and `size` say, held at x = 0, pulled at the tip */
  EXPERIMENT_SHAPE_SQUARE,   /* the same, mirrored so that a quarter turn maps the mesh to itself */
  EXPERIMENT_SHAPE_ARCH, /* the same, bent up by ARCH_RISE, held at both ends, pushed at the crown
                          */
  EXPERIMENT_SHAPE_TET   /* one, of edges `size`[0] along the axes, pulled at its last vertex */
} experiment_shape;

/* One body, its time step and its load. The load is constant, from rest, for the first half of the
 * steps, then none: so the work done is known without a reference. */
typedef struct experiment_extreme {
  experiment_subject subject;
  const char *name;
  experiment_shape shape;
  int cells[3];
  double size[3]; /* [m] */
  bool free;      /* nothing is held */
  thrum_material material;
  int64_t modes, rank;
  double dt;           /* [s]; 0: the one at which h omega of `mode` is `angle` */
  double angle;        /* h omega */
  int64_t mode;        /* 1 is the lowest */
  double split_safety; /* 0: the default */
  double load;         /* beside the one that, were the body linear, bent it by its length */
  int64_t steps_share; /* makes the steps so many times fewer; 0: once */
} experiment_extreme;

/* The list that the table is made from. */
extern const experiment_extreme experiment_extreme_list[];
int64_t experiment_extreme_count(void);

/* An extreme that has been made: a body, its time step and force, or why it was refused. */
typedef struct experiment_extreme_body {
  const experiment_extreme *extreme;
  thrum_status status;
  thrum_error refusal;
  thrum_precomputed made;
  experiment_body body;
  double dt;       /* [s] */
  double force;    /* [N] */
  double omega[2]; /* lowest and highest of the basis [1/s] */
} experiment_extreme_body;

/* Makes the body with the precompute pipeline; one at a time in a process. What is refused is no
 * failure: it says so in `made`. Only memory can fail. */
thrum_status experiment_extreme_make(const experiment_extreme *extreme,
                                     experiment_extreme_body *made, thrum_error *error);
void experiment_extreme_free(experiment_extreme_body *made);

typedef struct experiment_extreme_case {
  const experiment_extreme_body *body;
  experiment_scheme scheme;
  int64_t steps;
} experiment_extreme_case;

typedef struct experiment_extreme_result {
  thrum_status status; /* THRUM_OK, or why it was refused or ended before its time */
  thrum_error stop;
  thrum_state_report report;
  bool not_finite;       /* a number of the state was none: never */
  double us_per_step;    /* processor time */
  double work;           /* most that the load had done [J] */
  double energy_error;   /* largest |E - work| / the most work; NAN when no work was done */
  double energy_end;     /* the same at the end */
  double peak_amplitude; /* as a share of the body's length */
} experiment_extreme_result;

/* Runs one case; a step that cannot be solved is in the status of the result. */
thrum_status experiment_extreme_run(const experiment_extreme_case *run,
                                    experiment_extreme_result *result, thrum_error *error);

/* refused, stopped, lost (at the end the balance errs by more than all work), or the last fallback
 * level that it needed: runs (quasi-Newton), newton, switched, energy, substep. Static
 * storage. */
const char *experiment_extreme_outcome(const experiment_extreme_case *run,
                                       const experiment_extreme_result *result);

/* A system of units, each unit in SI. */
typedef struct experiment_units {
  const char *name;
  double length; /* [m] */
  double mass;   /* [kg] */
  double time;   /* [s] */
} experiment_units;

extern const experiment_units experiment_unit_systems[]; /* the first is SI */
int64_t experiment_unit_count(void);

/* The bodies that are put into other units: one swings widely, one snaps through. */
extern const experiment_extreme experiment_unit_extremes[];
enum { EXPERIMENT_UNIT_EXTREMES = 2 };

typedef struct experiment_unit_case {
  const experiment_extreme *extreme;
  const experiment_units *units;
  experiment_scheme scheme;
  int64_t steps;
} experiment_unit_case;

/* The same body in other units beside itself in SI. */
typedef struct experiment_unit_result {
  double difference;  /* largest of the pulled part's displacements, beside the largest of them */
  int64_t iterations; /* in these units; and */
  int64_t iterations_si;
  bool same_levels; /* as in SI */
} experiment_unit_result;

/* Runs one case and the same in SI. It makes the bodies: one at a time in a process. */
thrum_status experiment_units_run(const experiment_unit_case *run, experiment_unit_result *result,
                                  thrum_error *error);

/* All extremes of the chosen subjects, and their units. The caller fills the first members. */
typedef struct experiment_extremes {
  bool subjects[EXPERIMENT_SUBJECT_COUNT];
  bool schemes[EXPERIMENT_SCHEME_COUNT];
  int64_t steps;
  int threads;
  /* Called as a stage advances; may be NULL; false stops. */
  bool (*progress)(void *context, const char *stage, double fraction);
  void *progress_context;
  int64_t body_count, count, unit_count;
  experiment_extreme_body *bodies; /* body_count */
  experiment_extreme_case *cases;  /* count, by body, scheme, the last fastest */
  experiment_extreme_result *results;
  experiment_unit_case
      *units; /* unit_count, by body, system, scheme (of those that keep), the last fastest */
  experiment_unit_result *unit_results;
  thrum_scope memory; /* of these arrays */
} experiment_extremes;

/* Makes the bodies and runs all cases. Free with experiment_extremes_free, on failure too. */
thrum_status experiment_extremes_run(experiment_extremes *extremes, thrum_error *error);
void experiment_extremes_free(experiment_extremes *extremes);

/* Whether a run failed that should not. */
bool experiment_extremes_flagged(const experiment_extremes *extremes);

#endif
