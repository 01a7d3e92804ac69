/* What a scene says and what has no effect in it: loads that move nothing or come too late, motions
 * of a base that nothing is held by, and keys that others make void.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_idle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config/message.h"
#include "driver/run/coarse_step.h"
#include "driver/scene/scene_run_world.h"
#include "driver/scene/scene_words.h"

/* Warns under the line of a key, where the record has it. */
static void warn_of_key(const scene_run *run, const config_record *at, const char *where,
                        const char *key, const char *why) {
  const json_node *node = config_record_member(&run->spec.file, at, key);
  char place[SCENE_PLACE_MAX];
  if (node == NULL)
    return;
  snprintf(place, sizeof place, "%.150s:%lld", run->spec.file.name, (long long)node->line);
  config_warn_under(place, NULL);
  config_warn("%s\"%s\" has no effect: %s", where, key, why);
  config_warn_under(NULL, scene_words);
}

/* --- loads ------------------------------------------------------------------------------------ */

/* Does the load move the body at its full strength? */
static bool moves(const scene_body_run *body, const load_spec *load) {
  const double *v = load->vector;
  double reduced[THRUM_RANK_MAX];
  bool any = v[0] != 0 || v[1] != 0 || v[2] != 0;
  if (!any || (body->spec->free && !load->traction))
    return any;

  // of a body that deforms in place only what its modes feel
  if (load_spec_reduce(body->model, load, reduced, NULL) < 0)
    return true;
  any = false;
  for (int64_t i = 0; i < body->model->rank; i++)
    any = any || reduced[i] != 0;
  return any;
}

static void look_at_loads(const scene_run *run, const scene_body_run *body) {
  const double time = (double)run->steps * run->dt;
  const simulate_request *request = &body->request;
  for (int64_t n = 0; n < request->load_count; n++) {
    const load_spec *load = &request->loads[n];
    if (load->text == body->gravity)
      continue;
    if (load->course.from >= time)
      config_warn("\"loads\": '%s' begins at %g s and has no effect: the run ends at %g s",
                  load->text, load->course.from, time);
    else if (!moves(body, load))
      config_warn("\"loads\": '%s' moves nothing: it is zero, or all that it acts on is held",
                  load->text);
  }
}

#define BIT(name) (1u << THRUM_INTEGRATOR_##name)
#define EXPLICIT (BIT(VERLET) | BIT(RK4))

/* The step against what the loads and the start of a body move. Bodies that are free are moved by
 * what they touch, which nobody knows before. */
static void look_at_step(const scene_run *run, const scene_body_run *body) {
  const scene_body_spec *of = body->spec;
  const int64_t r = body->model->rank, count = body->request.load_count;
  double *directions = calloc((size_t)(count * r) + 1, sizeof *directions);
  bool known = directions != NULL && !(body->spec->free && body->spec->start.count == 0);
  for (int64_t n = 0; n < count && known && !body->spec->free; n++)
    known = load_spec_reduce(body->model, &body->request.loads[n], directions + n * r, NULL) >= 0;

  // the run has the step and the time, which the request of a body has not
  simulate_request request = body->request;
  request.def.dt = run->dt;
  request.time = (double)run->steps * run->dt;
  const coarse_step_motion motion = {.request = &request,
                                     .model = body->model,
                                     .pace = sqrt(of->stiffness / of->density) / of->scale,
                                     .directions = directions,
                                     .q = body->start,
                                     .p = body->start + r,
                                     .base = run->base_motion_count > 0 && !body->spec->free &&
                                             body->model->rigid == NULL};
  if (known)
    coarse_step_warn(&motion, "");
  if (known && !(1u << request.def.integrator & EXPLICIT))
    coarse_step_warn_slowest(body->model, motion.pace, run->dt);
  free(directions);
}

/* --- keys ------------------------------------------------------------------------------------- */

/* Keys of a step that some integrators have alone. Those of imexv are refused. */
static const struct {
  const char *key;
  unsigned of;
  const char *why;
} solver_keys[] = {
    {"newmark", BIT(NEWMARK), "it is of newmark"},
    {"frequency_matching", BIT(ENERGY), "it is of energy"},
    {"untrained_flow", BIT(ENERGY), "it is of energy"},
    {"adaptive", BIT(IMEXV) | BIT(FOX_GOODWIN), "it is of imexv and fox-goodwin"},
    {"fallback", BIT(IMEXV) | BIT(NEWMARK) | BIT(ENERGY) | BIT(FOX_GOODWIN),
     "it is of imexv, newmark, energy and fox-goodwin"},
    {"solver", ~EXPLICIT, "nothing is solved for in explicit steps"},
    {"tolerance", ~EXPLICIT, "nothing is solved for in explicit steps"},
    {"iterations", ~EXPLICIT, "nothing is solved for in explicit steps"},
};

/* integrators: bits of those that the keys of the record serve. */
static void look_at_solver(const scene_run *run, const config_record *at, const char *where,
                           unsigned integrators) {
  for (size_t n = 0; n < sizeof solver_keys / sizeof solver_keys[0]; n++)
    if ((integrators & solver_keys[n].of) == 0)
      warn_of_key(run, at, where, solver_keys[n].key, solver_keys[n].why);
}

/* What only obstacles ask a body for. */
static void look_at_touch(const scene_run *run, const scene_body_run *body, const char *where) {
  const config_record *at = &body->spec->settings.at;
  bool soft = false;
  for (int64_t n = 0; n < run->spec.obstacles.count; n++)
    soft = soft || (!scene_obstacle_is_solid(&scene_obstacles(&run->spec)[n]) &&
                    !(scene_obstacles(&run->spec)[n].stiffness > 0));
  if (run->spec.obstacles.count == 0) {
    warn_of_key(run, at, where, "touch", "the scene has no obstacles");
    warn_of_key(run, at, where, "touch_stiffness", "the scene has no obstacles");
  } else if (strcmp(body->spec->touch, "none") == 0) {
    warn_of_key(run, at, where, "touch_stiffness", "\"touch\" is \"none\"");
  } else if (!soft) {
    warn_of_key(run, at, where, "touch_stiffness",
                "the obstacles are solid or have a stiffness of their own");
  }
}

/* What serves all bodies. */
static void look_at_scene(const scene_run *run) {
  const scene_spec *spec = &run->spec;
  const config_record *at = &spec->settings.at;
  bool far = false, held = false, touches = false;
  unsigned integrators = 0;
  for (int64_t n = 0; n < spec->bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    integrators |= 1u << body->request.def.integrator;
    far = far || body->spec->detail.beyond > 0;
    held = held || (!body->spec->free && body->model->rigid == NULL);
    touches = touches || strcmp(body->spec->touch, "none") != 0;
  }

  look_at_solver(run, at, "", integrators);
  if (!far) {
    warn_of_key(run, at, "", "eye", "no body has a \"detail\" with \"beyond\"");
    warn_of_key(run, at, "", "eye_velocity", "no body has a \"detail\" with \"beyond\"");
  }
  if (!held)
    warn_of_key(run, at, "", "base_motion", "nothing holds any of the bodies");
  if (!scene_run_touches(run))
    warn_of_key(run, at, "", "collisions", "no bodies touch each other, themselves or solids");
  if (!touches)
    warn_of_key(run, at, "", "obstacles", "\"touch\" of all bodies is \"none\"");
  if (spec->wind.at.node != NULL && spec->wind.drag == 0)
    warn_of_key(run, at, "", "wind", "its \"drag\" is 0");
}

/* A body that nothing holds, and that is not let go either, stays where it stands. */
static void look_at_gravity(const scene_run *run, const scene_body_run *body) {
  const double *g = run->spec.gravity;
  if (body->model->rigid != NULL && !body->spec->free && (g[0] != 0 || g[1] != 0 || g[2] != 0))
    config_warn("nothing holds this body, and it stays where it stands all the same: add \"free\": "
                "true to let it fall");
}

void scene_run_warn_of_idle(const scene_run *run) {
  look_at_scene(run);
  for (int64_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    char place[SCENE_PLACE_MAX], where[90];
    snprintf(where, sizeof where, "body '%.64s': ", body->spec->name);
    look_at_solver(run, &body->spec->settings.at, where, 1u << body->request.def.integrator);
    look_at_touch(run, body, where);

    // what moves it
    config_warn_under(scene_body_place(&run->spec, body->spec, place), scene_words);
    look_at_gravity(run, body);
    look_at_loads(run, body);
    look_at_step(run, body);
    config_warn_under(NULL, scene_words);
  }
}
