/* A fine surface on a coarse body: reads a model and a surface embedded in it, pushes the tip, and
 * fills a vertex buffer as a renderer takes it, positions and normals interleaved, 60 times a
 * second.   show_surface beam.npz shown.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

enum { STRIDE = 8 }; // floats a vertex: three of position, three of normal, two left for a texture

int main(int argc, char **argv) {
  static double force[THRUM_RANK_MAX], q[THRUM_RANK_MAX];
  const double push[3] = {0, 0, -40}; // [N]
  const int32_t *tip;
  int64_t tip_count;
  thrum_error error = {0};
  const thrum_model *model;
  const thrum_surface *surface;
  thrum_state *state;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 1.0 / 240;

  // the model, the surface that was embedded in it, and a group to push
  if (argc != 3 || thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_surface_load(argv[2], model, &surface, &error) < 0 ||
      thrum_model_group(model, "tip", &tip, &tip_count, &error) < 0)
    return fprintf(stderr, "usage: show_surface MODEL.npz SURFACE.npz\n%s\n", error.message), 1;

  // a vertex buffer, a state at rest, and the push as a load on its coordinates
  const int64_t count = thrum_surface_vertex_count(surface);
  float *buffer = calloc((size_t)count * STRIDE, sizeof *buffer);
  if (buffer == NULL || thrum_state_create(model, &def, &state, &error) < 0 ||
      thrum_load_add_shared(model, tip, tip_count, push, force, &error) < 0)
    return fprintf(stderr, "show_surface: %s\n", error.message), 1;

  // four steps a frame, then the vertices where they are by then
  for (int frame = 1; frame <= 60; frame++) {
    thrum_state_set_force(model, state, frame <= 3 ? force : NULL, NULL);
    for (int step = 0; step < 4; step++)
      if (thrum_step(model, state, &error) < 0)
        return fprintf(stderr, "show_surface: frame %d: %s\n", frame, error.message), 1;

    if (thrum_state_get(model, state, q, NULL, &error) < 0 ||
        thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, count, buffer, STRIDE,
                                &error) < 0 ||
        thrum_surface_normals(surface, buffer, STRIDE, buffer + 3, STRIDE, &error) < 0)
      return fprintf(stderr, "show_surface: frame %d: %s\n", frame, error.message), 1;

    // here a renderer would draw the buffer
    const float *last = buffer + (count - 1) * STRIDE;
    if (frame % 10 == 0)
      printf("frame %d: the last vertex is at (%+.4f, %+.4f, %+.4f) m, its normal (%+.2f, %+.2f, "
             "%+.2f)\n",
             frame, (double)last[0], (double)last[1], (double)last[2], (double)last[3],
             (double)last[4], (double)last[5]);
  }

  free(buffer);
  thrum_state_destroy(state);
  thrum_surface_destroy(surface);
  thrum_model_destroy(model);
  return 0;
}
