/* A small body with a contact, for tests. Header only. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_CONTACT_SUPPORT_H
#define THRUM_TESTS_SUPPORT_CONTACT_SUPPORT_H

#include "tests/support/state_support.h"

#define RIG_RANK 4
#define RIG_POINTS 8
#define RIG_MASS 2.0
#define RIG_GRAVITY 10.0

static const thrum_integrator all_integrators[9] = {THRUM_INTEGRATOR_IMEXV,
                                                    THRUM_INTEGRATOR_NEWMARK,
                                                    THRUM_INTEGRATOR_VERLET,
                                                    THRUM_INTEGRATOR_MIDPOINT,
                                                    THRUM_INTEGRATOR_ENERGY,
                                                    THRUM_INTEGRATOR_FOX_GOODWIN,
                                                    THRUM_INTEGRATOR_BACKWARD_EULER,
                                                    THRUM_INTEGRATOR_SEMI_IMPLICIT_EULER,
                                                    THRUM_INTEGRATOR_RK4};

/* The definition of a rig: rig_default, then the members that differ. */
typedef struct rig_def {
  thrum_integrator integrator;
  double dt, omega; /* omega: the softest mode's; the stiffest has three times that */
  double shape;     /* the displacement of a point by a unit of q, 0: a rigid body */
  double stiffness; /* per point [N/m] */
  int points;       /* candidates of contact, the lowest ones first; at most RIG_POINTS - 1 */
  int pulls;
} rig_def;

static inline rig_def rig_default(void) {
  const rig_def def = {.integrator = THRUM_INTEGRATOR_IMEXV,
                       .dt = 0.001,
                       .omega = 50,
                       .stiffness = 1e6,
                       .points = 1,
                       .pulls = 1};
  return def;
}

/* A body whose first points lie at height 0 when its translation is 0, and the others above. */
typedef struct rig {
  random_model m;
  thrum_state *state;
  thrum_contact *contact;
  thrum_translation translation;
  thrum_obstacle floor;
  thrum_contact_environment environment;
} rig;

static inline thrum_contact *contact_make(const thrum_model *model, const thrum_state *state,
                                          const thrum_contact_def *def) {
  size_t size = 0;
  thrum_error error = {0};
  if (thrum_contact_size(model, state, def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  thrum_contact *contact = NULL;
  if (thrum_contact_init(memory, size, model, state, def, &contact, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return contact;
}

/* A rig points at its own parts, so it must stay where it is made. */
static inline void rig_make(rig *r, const rig_def *def) {
  memset(r, 0, sizeof *r);

  // the points' motion along the basis is scaled by the given shape
  random_model_make(&r->m, 3, RIG_RANK, def->omega, 3 * def->omega, def->shape > 0 ? 1 : INFINITY);
  random_model_add_mesh(&r->m, 4, RIG_POINTS);
  for (int i = 0; i < 3 * RIG_POINTS * RIG_RANK; i++)
    r->m.basis[i] *= def->shape;

  // the lowest points are the candidates of the contact
  int32_t vertices[RIG_POINTS];
  double areas[RIG_POINTS];
  for (int v = 0; v < RIG_POINTS; v++) {
    vertices[v] = v + 1;
    areas[v] = 1;
    r->m.vertices[3 * v + 2] = v <= def->points ? 0 : 1;
  }
  random_model_pack(&r->m);

  // the state before the contact that acts on it
  thrum_state_def state_def = thrum_default_state_def();
  state_def.integrator = def->integrator;
  state_def.dt = def->dt;
  r->state = state_make(&r->m.model, &state_def);

  // each point has area 1, so the stiffness is that of a point
  thrum_contact_def contact_def = thrum_default_contact_def();
  contact_def.vertices = vertices;
  contact_def.vertex_count = def->points;
  contact_def.areas = areas;
  contact_def.stiffness = def->stiffness;
  contact_def.pull_max = def->pulls;
  r->contact = contact_make(&r->m.model, r->state, &contact_def);

  // a rigid translation under gravity above a floor
  r->translation = (thrum_translation){.mass = RIG_MASS};
  r->floor = thrum_default_obstacle();
  r->environment = (thrum_contact_environment){.translation = &r->translation,
                                               .obstacles = &r->floor,
                                               .obstacle_count = 1,
                                               .force = {0, 0, -RIG_MASS * RIG_GRAVITY}};
}

static inline void rig_free(rig *r) {
  state_free(r->state);
  free(r->contact);
  random_model_free(&r->m);
}

static inline void rig_steps(rig *r, int64_t count) {
  thrum_error error = {0};
  for (int64_t n = 0; n < count; n++)
    if (thrum_contact_step(&r->m.model, r->state, r->contact, &r->environment, &error) < 0)
      fail_msg("%s", error.message);
}

static inline double rig_kinetic(const rig *r) {
  const double *v = r->translation.velocity;
  return 0.5 * RIG_MASS * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/* The mechanical energy of the body, with its translation, its rotation and its weight [J]. */
static inline double rig_energy(rig *r) {
  double height = 0;
  for (int axis = 0; axis < 3; axis++)
    height -= r->environment.force[axis] * r->translation.position[axis];
  const thrum_rigid_frame *rigid_frame = r->environment.rigid_frame;
  return state_energy(&r->m.model, r->state).total + rig_kinetic(r) + height +
         (rigid_frame ? thrum_rigid_frame_energy(rigid_frame, r->environment.placement) : 0);
}

#endif
