/* Which free bodies are coupled where the file does not say, and those that turned fast without it.
 *
 * What the coupling does is of the order of w/w1, with w the spin of the body and w1 its lowest
 * angular frequency: Coriolis forces split the frequencies of a body that vibrates by as much, and
 * centrifugal forces stretch it by the square of it. A bar and a plate that began with w/w1 = 0.01,
 * 0.03 and 0.1, at rest and bent by 2 cm, were 0.5, 4.7 and 14 % of their motion away from the same
 * without coupling within 4 s at most. A coupled step takes some 8 times as long. See
 * docs/mathematics/20_floating_frame.md. SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_couple.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "io/json.h"
#include "runtime/material/material_law.h"

#define TURNS 0.02     /* w/w1 at the start from which a body is coupled */
#define TURNS_FAST 0.1 /* w/w1, rms over a run, from which one that is not is warned of */
#define NAMES_MAX 4    /* bodies that a line names */
#define NAMES_SIZE 320

/* Where the file says whether the body is coupled. */
static bool is_said(const scene_run *run, const scene_body_run *body) {
  return config_record_member(&run->spec.file, &body->spec->settings.at, "coupled") != NULL;
}

/* The lowest angular frequency of the body's shape as it is in the scene [rad/s]; 0: it has none.
 */
static double lowest_frequency(const scene_body_run *body) {
  const scene_body_spec *spec = body->spec;
  for (int64_t n = 0; n < body->model->rank; n++)
    if (body->model->omega2[n] > 0)
      return sqrt(body->model->omega2[n] * spec->stiffness / spec->density) / spec->scale;
  return 0;
}

/* Is the body stepped so that it can be coupled: all of its coordinates, by energy? */
static bool may_couple(const scene_body_run *body) {
  const scene_body_spec *spec = body->spec;
  const thrum_state_def *def = &body->request.def;
  return body->request.condense == 0 && spec->error == 0 && spec->budget == 0 &&
         spec->detail.at.node == NULL && thrum_model_masters(body->model) == 0 &&
         def->integrator == THRUM_INTEGRATOR_ENERGY && def->damping_form == THRUM_DAMPING_REST;
}

bool scene_run_couples(const scene_run *run, scene_body_run *body) {
  const double *spin = body->def.spin, lowest = lowest_frequency(body);
  body->coupled_by_default = false;
  if (is_said(run, body) || !body->spec->free || !(lowest > 0))
    return body->spec->coupled;
  body->turn_share = sqrt(spin[0] * spin[0] + spin[1] * spin[1] + spin[2] * spin[2]) / lowest;
  body->coupled_by_default = body->turn_share >= TURNS && may_couple(body);
  return body->coupled_by_default;
}

void scene_run_note_turns(scene_run *run) {
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    scene_body_run *body = run->bodies + n;
    double matrix[16], trace = 0, size = 0;
    if (!body->spec->free || body->def.coupled || is_said(run, body))
      continue;

    // the rotation of the step, by what the axes before it and after it have in common
    thrum_scene_body_matrix(run->scene, n, matrix);
    for (int k = 0; k < 3; k++)
      for (int axis = 0; axis < 3; axis++) {
        trace += matrix[4 * k + axis] * body->axes_before[3 * k + axis];
        size += matrix[4 * k + axis] * matrix[4 * k + axis];
        body->axes_before[3 * k + axis] = matrix[4 * k + axis];
      }
    if (body->turn_steps++ == 0)
      continue;
    const double cosine = fmin(fmax((3 * trace / size - 1) / 2, -1), 1);
    const double speed = acos(cosine) / run->dt;
    body->turn_square += speed * speed;
  }
}

/* Adds a body's name to those that a line has, the `count`-th of them. */
static void add_name(char names[NAMES_SIZE], int64_t count, const char *name) {
  const size_t length = strlen(names);
  if (count <= NAMES_MAX)
    snprintf(names + length, NAMES_SIZE - length, "%s%.60s", count > 1 ? ", " : "", name);
  else if (count == NAMES_MAX + 1)
    snprintf(names + length, NAMES_SIZE - length, " and others");
}

void scene_run_coupled_json(const scene_run *run, cJSON *object) {
  char names[NAMES_SIZE] = "";
  int64_t count = 0;
  double least = INFINITY, most = 0;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    if (!body->coupled_by_default)
      continue;
    add_name(names, ++count, body->spec->name);
    least = fmin(least, body->turn_share);
    most = fmax(most, body->turn_share);
  }
  cJSON *turning = json_section(object, "turning", count > 0);
  if (turning == NULL)
    return;
  json_string(turning, "names", names);
  json_number(turning, "count", (double)count);
  json_number(turning, "least", least);
  json_number(turning, "most", most);
}

void scene_run_warn_of_turns(const scene_run *run) {
  char names[NAMES_SIZE] = "";
  int64_t count = 0;
  double most = 0;
  bool may = true, points = false;
  for (int32_t n = 0; n < run->spec.bodies.count; n++) {
    const scene_body_run *body = run->bodies + n;
    const double lowest = lowest_frequency(body);
    if (body->turn_steps < 2 || !(lowest > 0))
      continue;
    const double share = sqrt(body->turn_square / (double)(body->turn_steps - 1)) / lowest;
    if (!(share >= TURNS_FAST))
      continue;
    add_name(names, ++count, body->spec->name);
    most = fmax(most, share);
    may = may && may_couple(body);
    points = points || thrum_law_of_model(body->model) != THRUM_LAW_STVK;
  }
  if (count > 0)
    config_warn("%s turned at %s%.2g of %s lowest frequenc%s (rms) without what spin and shape do "
                "to each other, which is an error of up to that share: %s; \"coupled\": false says "
                "that it is meant",
                names, count > 1 ? "up to " : "", most, count > 1 ? "their" : "its",
                count > 1 ? "ies" : "y",
                points ? "cubature points of another law cannot be coupled"
                : may  ? "take \"coupled\": true"
                       : "take \"coupled\": true, the integrator energy and all coordinates");
}
