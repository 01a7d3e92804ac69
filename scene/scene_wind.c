/* Air that drags on the windward surface (design 15):  f_v = 1/2 rho C_d A |w - v| (w - v)  on each
 * vertex v, with A = max(0, -a . (w - v)/|w - v|), a its outward area vector at rest. So a convex
 * body at rest feels 1/2 rho C_d |w|^2 times its frontal area (Hoerner 1965, Fluid-dynamic drag,
 * chapter I).
 *
 * With c the velocity of the body as a whole, u = w - c decays as u' = u / (1 + h |F| / (m |u|))
 * under F = sum f(u) alone: the drag on the whole is divided so, which makes it the mean over the
 * step, and no step goes past the wind. The part from rotation and deformation, f(w - v) - f(u), is
 * taken at the start of the step and divided by 1 + h kappa, kappa = rho C_d sum |a_v| |w - v|max
 * |U_v|^2 a bound of its rate: an explicit force could otherwise turn the motion over. Cost: 12 r
 * operations a vertex of the surface, and the synchronised momentum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_wind.h"

#include "scene/scene_fields.h"
#include "scene/scene_placement.h"
#include "scene/scene_shape.h"

#include "core/base/def.h"
#include "core/base/finite.h"

#include <math.h>
#include <string.h>

thrum_status thrum_scene_set_wind(thrum_scene *scene, const thrum_scene_wind_def *def,
                                  thrum_error *error) {
  thrum_scene_wind_def whole = thrum_default_scene_wind_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_WIND, def, error));
  const double air = 0.5 * def->density * def->drag;
  if (!isfinite(air))
    return thrum_error_set_field(error, "density", THRUM_BAD_VALUE,
                                 " times the drag coefficient is beyond the range of numbers");
  memcpy(scene->wind, def->velocity, sizeof scene->wind);
  scene->air = air;
  scene->stirred++;
  return THRUM_OK;
}

/* Drag on one vertex with this area vector, past which the air goes with `speed`. */
static void drag_on(double air, const double area[3], const double speed[3], double force[3]) {
  const double facing = -(area[0] * speed[0] + area[1] * speed[1] + area[2] * speed[2]);
  for (int axis = 0; axis < 3; axis++)
    force[axis] = facing > 0 ? air * facing * speed[axis] : 0;
}

static double length_of(const double *vector) {
  return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

/* Motion of a body relative to a wind, in its own axes. */
typedef struct scene_flow {
  double wind[3], way[3], spin[3]; /* velocities of the air and of a free body as a whole */
  double centre[3];
  double past[3]; /* velocity of the air past the body as a whole */
  double fastest; /* largest speed of its vertices, without that of the whole */
  double mean;    /* mean drag on the whole over the step, relative to that at its start */
  double share;   /* share of the other drag from the body's motion that one step can take */
} scene_flow;

/* The velocity of a vertex without that of the body as a whole. */
static void velocity_of(const scene_body *body, const double *rows, double velocity[3]) {
  const int64_t r = body->model->rank, rank = scene_shown(body);
  for (int axis = 0; axis < 3; axis++) {
    double sum = 0;
    for (int64_t i = 0; i < rank; i++)
      sum += rows[axis * r + i] * body->p[i];
    velocity[axis] = body->k * sum;
  }
}

static const double *rows_of(const scene_body *body, int64_t n) {
  return body->model->basis + 3 * (int64_t)body->surface[n] * body->model->rank;
}

static void arm_of(const scene_body *body, const scene_flow *flow, int64_t n, double arm[3]) {
  const double *rest = body->model->vertices + 3 * (int64_t)body->surface[n];
  for (int axis = 0; axis < 3; axis++)
    arm[axis] = body->derived->by.length * rest[axis] - flow->centre[axis];
}

static scene_flow find_flow(const thrum_scene *scene, const scene_body *body) {
  scene_flow flow = {.fastest = 0};
  double spin[3] = {0};
  if (body->free)
    thrum_rigid_frame_velocity(&body->rigid_frame, &body->placement, spin);

  // all velocities in the axes of the body, in which its rows are
  scene_to_body(&body->here, scene->wind, flow.wind);
  scene_to_body(&body->here, body->way.velocity, flow.way);
  scene_to_body(&body->here, spin, flow.spin);
  memcpy(flow.centre, body->rigid_frame.centre, sizeof flow.centre);
  for (int axis = 0; axis < 3; axis++)
    flow.past[axis] = flow.wind[axis] - flow.way[axis];

  // the fastest vertex bounds the rate of the drag
  for (int64_t n = 0; n < body->surface_count; n++) {
    double v[3];
    velocity_of(body, rows_of(body, n), v);
    const double speed = length_of(v);
    flow.fastest = speed > flow.fastest ? speed : flow.fastest;
  }
  return flow;
}

/* u' / u of a free body; a body that is held does not follow. */
static double mean_of(const thrum_scene *scene, const scene_body *body, const scene_flow *flow) {
  double sum[3] = {0};
  const double speed = length_of(flow->past);
  if (!body->free || !(speed > 0))
    return 1;
  for (int64_t n = 0; n < body->surface_count; n++) {
    double force[3];
    drag_on(scene->air, body->areas + 3 * n, flow->past, force);
    for (int axis = 0; axis < 3; axis++)
      sum[axis] += force[axis];
  }
  return 1 / (1 + scene->dt * length_of(sum) / (body->way.mass * speed));
}

/* Share of the drag from rotation and deformation that one step can take. */
static double limit(const thrum_scene *scene, const scene_body *body, const scene_flow *flow) {
  double rate = 0, rigid_frame = 0, longest = 0;
  const double *inverse = body->rigid_frame.inverse;
  for (int64_t n = 0; n < body->surface_count; n++) {
    const double area = length_of(body->areas + 3 * n);
    double arm[3];
    arm_of(body, flow, n, arm);
    rate += area * body->stretch[n];
    rigid_frame += area * (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
    longest = fmax(longest, length_of(arm));
  }
  if (body->free)
    rate += rigid_frame * (inverse[0] + inverse[4] + inverse[8]);
  const double speed = length_of(flow->past) + flow->fastest + longest * length_of(flow->spin);
  return 1 / (1 + scene->dt * 2 * scene->air * speed * rate);
}

/* torque += arm x force */
static void add_torque(const double arm[3], const double force[3], double torque[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    torque[axis] += arm[next] * force[last] - arm[last] * force[next];
  }
}

/* The drag on vertex n of the surface in the step to come. */
static void vertex_drag(const thrum_scene *scene, const scene_body *body, const scene_flow *flow,
                        int64_t n, double force[3]) {
  double v[3], past[3], whole[3], arm[3], turned[3] = {0};
  velocity_of(body, rows_of(body, n), v);
  arm_of(body, flow, n, arm);
  add_torque(flow->spin, arm, turned); // the same product: spin x arm
  for (int axis = 0; axis < 3; axis++)
    past[axis] = flow->past[axis] - v[axis] - turned[axis];
  drag_on(scene->air, body->areas + 3 * n, flow->past, whole);
  drag_on(scene->air, body->areas + 3 * n, past, force);
  for (int axis = 0; axis < 3; axis++)
    force[axis] = flow->mean * whole[axis] + flow->share * (force[axis] - whole[axis]);
}

thrum_status scene_wind_add(const thrum_scene *scene, scene_body *body, scene_wrench *wrench,
                            thrum_error *error) {
  // the flow around the body: its mean speed, and the share of the drag that keeps a step stable
  THRUM_TRY(scene_body_read(body, true, error));
  const int64_t r = body->model->rank, rank = scene_shown(body);
  scene_flow flow = find_flow(scene, body);
  flow.mean = mean_of(scene, body, &flow);
  flow.share = limit(scene, body, &flow);

  // the drag of each vertex of the surface, in coordinates and on the whole
  double sum[3] = {0}, torque[3] = {0}, world[3], world_torque[3];
  for (int64_t n = 0; n < body->surface_count; n++) {
    const double *rows = rows_of(body, n);
    double force[3], arm[3];
    vertex_drag(scene, body, &flow, n, force);
    arm_of(body, &flow, n, arm);
    add_torque(arm, force, torque);
    for (int axis = 0; axis < 3; axis++) {
      sum[axis] += force[axis];
      for (int64_t i = 0; i < rank; i++)
        body->force[i] += body->k * rows[axis * r + i] * force[axis];
    }
  }

  scene_to_world(&body->here, sum, world);
  scene_to_world(&body->here, torque, world_torque);
  for (int axis = 0; axis < 3; axis++) {
    wrench->force[axis] += world[axis];
    wrench->torque[axis] += world_torque[axis];
  }
  return THRUM_OK;
}
