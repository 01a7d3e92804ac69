/* The program of docs/tutorial.md: pulls a body at one point, lets go, and prints how it swings.
 *   pluck hook.npz 0.0604 0 0.0777 >swing.csv
 * The arguments after the model are the point, in metres; the vertex nearest to it is pulled.
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

/* The vertex of the mesh nearest to a point, both at rest. */
static int32_t nearest_vertex(const thrum_model *model, const double point[3]) {
  int32_t nearest = 0;
  double least = 1e300;

  // a search through all vertices is fast enough to be done once
  for (int32_t v = 0; v < model->vertex_count; v++) {
    double distance = 0;
    for (int axis = 0; axis < 3; axis++) {
      const double off = model->vertices[3 * v + axis] - point[axis];
      distance += off * off;
    }
    if (distance < least) {
      least = distance;
      nearest = v;
    }
  }
  return nearest;
}

/* Prints a CSV line: the time, how far the vertex is displaced upwards, the energy of the body. */
static thrum_status print_row(const thrum_model *model, thrum_state *state, int32_t vertex,
                              thrum_error *error) {
  static double q[THRUM_RANK_MAX];
  double moved[3];
  thrum_energies energies;

  THRUM_TRY(thrum_state_get(model, state, q, NULL, error));
  THRUM_TRY(thrum_displacement_mean(model, &vertex, 1, q, moved, error));
  THRUM_TRY(thrum_state_energies(model, state, &energies, error));
  printf("%.3f,%.6f,%.6f\n", thrum_state_report_get(state).time, moved[2], energies.total);
  return THRUM_OK;
}

/* Pulls for one second with a force that grows from nothing, then lets go. */
static thrum_status pluck(const thrum_model *model, thrum_state *state, const thrum_state_def *def,
                          int32_t vertex, thrum_error *error) {
  const int64_t steps = thrum_step_count(3, def->dt);

  for (int64_t step = 0; step < steps; step++) {
    static double force[THRUM_RANK_MAX];
    const double time = ((double)step + 0.5) * def->dt;
    const double pull[3] = {0, 0, time < 1 ? -4 * time : 0}; // [N]

    // forces on vertices add up to one reduced force, which acts until it is set again
    for (int64_t i = 0; i < model->rank; i++)
      force[i] = 0;
    THRUM_TRY(thrum_load_add_shared(model, &vertex, 1, pull, force, error));
    THRUM_TRY(thrum_state_set_force(model, state, force, error));

    THRUM_TRY(thrum_step(model, state, error));
    THRUM_TRY(print_row(model, state, vertex, error));
  }
  return THRUM_OK;
}

int main(int argc, char **argv) {
  if (argc != 5)
    return fprintf(stderr, "usage: pluck MODEL.npz X Y Z, the point to be pulled [m]\n"), 2;
  const double point[3] = {atof(argv[2]), atof(argv[3]), atof(argv[4])};
  thrum_error error = {0};
  const thrum_model *model;
  thrum_state *state;

  // the definition of a state: here the energy integrator, with a little damping
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  def.damping_alpha = 0.5;

  // the model is read once and never changes; the state is what moves
  if (thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_state_create(model, &def, &state, &error) < 0)
    return fprintf(stderr, "pluck: %s\n", error.message), 1;

  printf("time_s,tip_m,energy_j\n");
  if (pluck(model, state, &def, nearest_vertex(model, point), &error) < 0)
    return fprintf(stderr, "pluck: %s\n", error.message), 1;

  thrum_state_destroy(state);
  thrum_model_destroy(model);
  return 0;
}
