/* The cost of contact: medians of the time of a step of a free model by itself, with contact far
 * from the floor, and while it touches.   thrum_contact_cost free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "platform/allocate.h"
#include "platform/clock.h"
#include "thrum/thrum.h"

#define STEPS 3000
#define STEP 0.001

typedef enum scene { ALONE, FAR, FALLING, SLIDING, PULLED } scene;
static const char *const names[] = {"alone", "far", "falling", "sliding", "pulled"};

typedef struct trial {
  double times[STEPS]; /* of the steps that count [us] */
  int count;
  double touching, sweeps; /* means over them */
} trial;

static int compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double lowest(const thrum_model *model) {
  double least = model->vertices[2];
  for (int64_t v = 0; v < model->vertex_count; v++)
    if (model->vertices[3 * v + 2] < least)
      least = model->vertices[3 * v + 2];
  return least;
}

/* The body, its floor, and the time of its steps: those that touch, where it is to. */
static thrum_status measure(const thrum_model *model, scene which, trial *out, thrum_error *error) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_IMEXV;
  def.dt = STEP;
  def.damping_alpha = 2;
  const thrum_contact_def touching = thrum_default_contact_def();
  thrum_state *state;
  thrum_contact *contact;
  size_t size;
  THRUM_TRY(thrum_state_create(model, &def, &state, error));
  THRUM_TRY(thrum_contact_size(model, state, &touching, &size, error));
  THRUM_TRY(thrum_contact_init(thrum_allocate_aligned(size, "the contact", error), size, model,
                               state, &touching, &contact, error));

  // the body above its floor, sliding on it, far from it, or pulled at
  const double mass = 1 / (model->rigid[0] * model->rigid[0]);
  thrum_translation way = {.mass = mass, .position = {0, 0, which == FALLING ? 0.02 : 0}};
  way.velocity[0] = which == SLIDING ? 1 : 0;
  thrum_obstacle floor = thrum_default_obstacle();
  floor.centre[2] = lowest(model) - (which == FAR || which == PULLED ? 1e3 : 0);
  const double *x = model->vertices;
  const thrum_pull pull = {
      .weights = {1, 0, 0}, .target = {x[0], x[1], x[2] + 0.1}, .stiffness = 1e3, .damping = -1};
  thrum_contact_environment environment = {.translation = &way,
                                           .obstacles = &floor,
                                           .obstacle_count = 1,
                                           .pulls = &pull,
                                           .pull_count = which == PULLED,
                                           .force = {0, 0, -9.81 * mass}};

  out->count = 0;
  out->touching = out->sweeps = 0;
  thrum_status status = THRUM_OK;
  for (int step = 0; step < STEPS && status >= 0; step++) {
    const int64_t swept = thrum_contact_report_get(contact).sweeps;
    const double begun = clock_seconds();
    status = which == ALONE ? thrum_step(model, state, error)
                            : thrum_contact_step(model, state, contact, &environment, error);

    // for a moving body only the steps in which it touches count
    const double time = 1e6 * (clock_seconds() - begun);
    const thrum_contact_report report = thrum_contact_report_get(contact);
    if ((which == FALLING || which == SLIDING) && report.touching == 0)
      continue;
    out->times[out->count++] = time;
    out->touching += report.touching;
    out->sweeps += (double)(report.sweeps - swept);
  }
  thrum_state_destroy(state);
  free(contact);
  return status;
}

int main(int argc, char **argv) {
  static trial found;
  thrum_error error = {0};
  const thrum_model *model;
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0 || !model->rigid)
    return fprintf(stderr, "usage: thrum_contact_cost FREE_MODEL.npz %s\n", error.message), 1;

  // the median over the steps of each scene
  printf("rank %d, %d points\n", (int)model->rank, (int)model->vertex_count);
  for (int which = ALONE; which <= PULLED; which++) {
    if (measure(model, (scene)which, &found, &error) < 0)
      return fprintf(stderr, "%s\n", error.message), 1;
    qsort(found.times, (size_t)found.count, sizeof *found.times, compare);
    const double count = found.count > 0 ? found.count : 1;
    printf("%-8s %5d steps, %4.1f points touch, %4.1f sweeps, median %6.2f us\n", names[which],
           found.count, found.touching / count, found.sweeps / count, found.times[found.count / 2]);
  }
  thrum_model_destroy(model);
  return 0;
}
