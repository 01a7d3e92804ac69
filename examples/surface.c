/* A fine surface on a coarse body: reads a model and a surface embedded in it, pushes the tip, and
 * fills a vertex buffer as a renderer takes it, positions and normals interleaved, 60 times a
 * second.   surface beam.npz shown.npz
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdio.h>
#include <stdlib.h>

#include "thrum/thrum.h"

enum { STRIDE = 8 }; // floats a vertex: three of position, three of normal, two left for a texture

/* Stands for a renderer: says where the lowest vertex is and where its normal points. */
static void draw(const float *buffer, int64_t count, double time) {
  const float *low = buffer;
  for (int64_t v = 1; v < count; v++)
    if (buffer[v * STRIDE + 2] < low[2])
      low = buffer + v * STRIDE;
  printf("%.3f s: lowest at (%+.4f, %+.4f, %+.4f) m, normal (%+.3f, %+.3f, %+.3f)\n", time,
         (double)low[0], (double)low[1], (double)low[2], (double)low[3], (double)low[4],
         (double)low[5]);
}

int main(int argc, char **argv) {
  static double force[THRUM_RANK_MAX], q[THRUM_RANK_MAX];
  const double push[3] = {0, 0, -40}; // [N]
  const int32_t *tip;
  int64_t tip_count;
  size_t size;
  thrum_error error = {0};
  const thrum_model *model;
  const thrum_surface *surface;
  thrum_state *state;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 1.0 / 240;
  if (argc != 3 || thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_surface_load(argv[2], model, &surface, &error) < 0 ||
      thrum_model_group(model, "tip", &tip, &tip_count, &error) < 0 ||
      thrum_state_size(model, &def, &size, &error) < 0)
    return fprintf(stderr, "usage: surface MODEL.npz SURFACE.npz %s\n", error.message), 1;
  const int64_t count = thrum_surface_vertex_count(surface);
  float *buffer = calloc((size_t)count, STRIDE * sizeof *buffer);
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  if (buffer == NULL || memory == NULL ||
      thrum_state_init(memory, size, model, &def, &state, &error) < 0 ||
      thrum_force_add_shared(model, tip, tip_count, push, force, &error) < 0)
    return fprintf(stderr, "surface: %s\n", error.message), 1;
  for (int step = 1; step <= 240; step++) {
    thrum_state_set_force(model, state, step <= 10 ? force : NULL, NULL);
    if (thrum_step(model, state, &error) < 0)
      return fprintf(stderr, "surface: step %d: %s\n", step, error.message), 1;
    if (step % 4 != 0)
      continue;
    if (thrum_state_get(model, state, q, NULL, &error) < 0 ||
        thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, count, buffer, STRIDE,
                                &error) < 0 ||
        thrum_surface_normals(surface, buffer, STRIDE, buffer + 3, STRIDE, &error) < 0)
      return fprintf(stderr, "surface: %s\n", error.message), 1;
    if (step % 40 == 0)
      draw(buffer, count, step * def.dt);
  }
  free(buffer);
  free(memory);
  thrum_surface_free(surface);
  thrum_model_free(model);
  return 0;
}
