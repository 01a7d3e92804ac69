/* A free body falls on a floor, bounces and comes to rest.   drop free.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

/* Memory as the library wants it, aligned to 64 bytes. */
static void *aligned_memory(size_t size) {
  return aligned_alloc(64, (size + 63) / 64 * 64);
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *model;
  thrum_state *state;
  thrum_contact *contact;
  size_t size;
  thrum_state_def def = thrum_default_state_def();
  def.damping_alpha = 2;

  // a model that nothing holds
  if (argc != 2 || thrum_model_load(argv[1], &model, &error) < 0 || !model->rigid)
    return fprintf(stderr, "usage: drop FREE_MODEL.npz\n%s\n", error.message), 1;

  // a state, and what its contacts need
  const thrum_contact_def touching = thrum_default_contact_def(); // any vertex may touch
  if (thrum_state_create(model, &def, &state, &error) < 0 ||
      thrum_contact_size(model, state, &touching, &size, &error) < 0 ||
      thrum_contact_init(aligned_memory(size), size, model, state, &touching, &contact, &error) < 0)
    return fprintf(stderr, "drop: %s\n", error.message), 1;

  // in a rigid shift every vertex moves by one over the root of the mass
  const double shift = model->rigid[0], mass = 1 / (shift * shift);
  thrum_translation translation = {.mass = mass, .position = {0, 0, 0.5}};

  // a floor at the height of the body's lowest vertices, half a metre below it, and its weight
  thrum_obstacle floor = thrum_default_obstacle(); // the plane z = 0
  floor.centre[2] = model->vertices[2];
  const thrum_contact_environment environment = {.translation = &translation,
                                                 .obstacles = &floor,
                                                 .obstacle_count = 1,
                                                 .force = {0, 0, -9.81 * mass}};

  // the contact step finds the contact forces and then makes the step under them
  for (int step = 0; step < 1000; step++) {
    if (thrum_contact_step(model, state, contact, &environment, &error) < 0)
      return fprintf(stderr, "drop: step %d: %s\n", step, error.message), 1;

    const thrum_contact_report report = thrum_contact_report_get(contact);
    if (step % 50 == 49)
      printf("%.2f s: %.4f m up, %d points touch with %.0f N\n", (step + 1) * def.dt,
             translation.position[2], (int)report.touching, report.normal);
  }

  thrum_state_destroy(state);
  free(contact);
  thrum_model_destroy(model);
  return 0;
}
