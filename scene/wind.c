/* Air that drags on the windward surface (design 15):  f_v = 1/2 rho C_d A |w - v| (w - v)  on each
 * vertex v, with A = max(0, -a . (w - v)/|w - v|), a its outward area vector at rest. So a convex
 * body at rest feels 1/2 rho C_d |w|^2 times its frontal area (Hoerner 1965, Fluid-dynamic drag,
 * chapter I).
 *
 * What the body's own motion adds, f(w - v) - f(w), is taken at the start of the step and divided
 * by 1 + h kappa, kappa = rho C_d sum |a_v| |w - v|max |U_v|^2 a bound of its rate: an explicit
 * force could otherwise turn the motion over. Cost: 12 r operations a vertex of the surface, and
 * the synchronised momentum.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif

#include <math.h>
#include <string.h>

#include "scene/internal.h"

thrum_status thrum_scene_set_wind(thrum_scene *scene, const double velocity[3], double density,
                                  double drag, thrum_error *error) {
  const double air = 0.5 * density * drag;
  if (!isfinite(velocity[0]) || !isfinite(velocity[1]) || !isfinite(velocity[2]) ||
      !(density >= 0) || !(drag >= 0) || !isfinite(air))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a wind wants a velocity that is finite, and a density and a drag "
                           "coefficient >= 0");
  memcpy(scene->wind, velocity, sizeof scene->wind);
  scene->air = air;
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

/* What a body does in a wind, in its own axes. */
typedef struct scene_flow {
  double wind[3], way[3], spin[3]; /* of the air, and of a free body as a whole */
  double centre[3];
  double fastest; /* of its vertices, without the whole */
} scene_flow;

/* The velocity of a vertex without that of the body as a whole. */
static void velocity_of(const scene_body *body, const double *rows, double velocity[3]) {
  const int64_t r = body->model->rank, rank = body->derived->rank;
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
    thrum_turning_velocity(&body->turning, &body->placement, spin);
  scene_to_body(&body->here, scene->wind, flow.wind);
  scene_to_body(&body->here, body->way.velocity, flow.way);
  scene_to_body(&body->here, spin, flow.spin);
  memcpy(flow.centre, body->turning.centre, sizeof flow.centre);
  for (int64_t n = 0; n < body->surface_count; n++) {
    double v[3];
    velocity_of(body, rows_of(body, n), v);
    const double speed = length_of(v);
    flow.fastest = speed > flow.fastest ? speed : flow.fastest;
  }
  return flow;
}

/* How much of the drag's change with the body's own motion one step can take. */
static double limit(const thrum_scene *scene, const scene_body *body, const scene_flow *flow) {
  double rate = 0, whole = 0, turning = 0, longest = 0;
  const double *inverse = body->turning.inverse;
  for (int64_t n = 0; n < body->surface_count; n++) {
    const double area = length_of(body->areas + 3 * n);
    double arm[3];
    arm_of(body, flow, n, arm);
    rate += area * body->stretch[n];
    whole += area;
    turning += area * (arm[0] * arm[0] + arm[1] * arm[1] + arm[2] * arm[2]);
    longest = fmax(longest, length_of(arm));
  }
  if (body->free)
    rate += whole / body->way.mass + turning * (inverse[0] + inverse[4] + inverse[8]);
  const double speed = length_of(flow->wind) + length_of(flow->way) + flow->fastest +
                       longest * length_of(flow->spin);
  return 1 / (1 + scene->dt * 2 * scene->air * speed * rate);
}

/* torque += arm x force */
static void add_torque(const double arm[3], const double force[3], double torque[3]) {
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    torque[axis] += arm[next] * force[last] - arm[last] * force[next];
  }
}

/* The drag on vertex n of the surface, of which `share` of what motion adds is taken. */
static void vertex_drag(const thrum_scene *scene, const scene_body *body, const scene_flow *flow,
                        int64_t n, double share, double force[3]) {
  double v[3], past[3], still[3], arm[3], turned[3] = {0};
  velocity_of(body, rows_of(body, n), v);
  arm_of(body, flow, n, arm);
  add_torque(flow->spin, arm, turned); // the same product: spin x arm
  for (int axis = 0; axis < 3; axis++)
    past[axis] = flow->wind[axis] - v[axis] - flow->way[axis] - turned[axis];
  drag_on(scene->air, body->areas + 3 * n, flow->wind, still);
  drag_on(scene->air, body->areas + 3 * n, past, force);
  for (int axis = 0; axis < 3; axis++)
    force[axis] = still[axis] + share * (force[axis] - still[axis]);
}

thrum_status scene_wind_add(const thrum_scene *scene, scene_body *body, scene_wrench *wrench,
                            thrum_error *error) {
  const thrum_status status = scene_body_read(body, true, error);
  if (status < 0)
    return status;
  const int64_t r = body->model->rank, rank = body->derived->rank;
  const scene_flow flow = find_flow(scene, body);
  const double share = limit(scene, body, &flow);
  double sum[3] = {0}, torque[3] = {0}, world[3], world_torque[3];
  for (int64_t n = 0; n < body->surface_count; n++) {
    const double *rows = rows_of(body, n);
    double force[3], arm[3];
    vertex_drag(scene, body, &flow, n, share, force);
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
