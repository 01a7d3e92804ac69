/* Which vertex of which body a ray hits first, on the surfaces as they are deformed now.
 * Moeller & Trumbore 1997, Fast, minimum storage ray/triangle intersection,
 * doi:10.1080/10867651.1997.10487468. Cost: every triangle of every body once.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"

#include <math.h>

#include "core/base/vec3.h"

typedef struct ray {
  double origin[3], direction[3];
} ray;

typedef struct hit {
  int32_t body, vertex;
  double distance; /* along the ray, in lengths of its direction */
} hit;

// the ray in the axes and lengths of the model: `matrix` is a rotation times a scale, and a shift
static ray into_model(const ray *world, const double matrix[16]) {
  ray local;
  for (int i = 0; i < 3; i++) {
    const double *column = matrix + 4 * i;
    double scale2 = thrum_dot3(column, column);
    const double from[3] = {world->origin[0] - matrix[12], world->origin[1] - matrix[13],
                            world->origin[2] - matrix[14]};
    local.origin[i] = thrum_dot3(column, from) / scale2;
    local.direction[i] = thrum_dot3(column, world->direction) / scale2;
  }
  return local;
}

// distance to the triangle, INFINITY where the ray misses it; bary: weights of its corners
static double meet(const ray *r, const float *a, const float *b, const float *c, double bary[3]) {
  double e1[3], e2[3], from[3], p[3], s[3];
  for (int i = 0; i < 3; i++) {
    e1[i] = (double)b[i] - a[i];
    e2[i] = (double)c[i] - a[i];
    from[i] = r->origin[i] - a[i];
  }

  // Moeller and Trumbore 1997, doi:10.1080/10867651.1997.10487468
  thrum_cross3(r->direction, e2, p);
  double det = thrum_dot3(e1, p);
  if (det == 0.0)
    return INFINITY;

  thrum_cross3(from, e1, s);
  bary[1] = thrum_dot3(from, p) / det;
  bary[2] = thrum_dot3(r->direction, s) / det;
  bary[0] = 1.0 - bary[1] - bary[2];
  double distance = thrum_dot3(e2, s) / det;
  return bary[0] >= 0.0 && bary[1] >= 0.0 && bary[2] >= 0.0 && distance > 0.0 ? distance : INFINITY;
}

// the corner that is nearest and not held in all three axes; -1: all are
static int32_t free_corner(const uint8_t *fixed, const int32_t corners[3], const double bary[3]) {
  int best = -1;
  for (int i = 0; i < 3; i++)
    if (fixed[corners[i]] != 7 && (best < 0 || bary[i] > bary[best]))
      best = i;
  return best < 0 ? -1 : corners[best];
}

static void pick_body(thrum_scene *scene, int32_t body, const ray *world, hit *nearest) {
  const page_model *shown = page_body_model(scene, body);
  double matrix[16];
  thrum_scene_body_matrix(scene, body, matrix);

  // the positions now, in the coordinates of the model
  float *x = shown->positions;
  if (thrum_scene_body_positions(scene, body, shown->surface, x, 3, NULL) != THRUM_OK)
    return;

  const ray local = into_model(world, matrix);
  int64_t count = thrum_surface_triangle_count(shown->surface);
  for (int64_t t = 0; t < count; t++) {
    const int32_t *corners = shown->triangles + 3 * t;
    double bary[3];
    double distance =
        meet(&local, x + 3 * corners[0], x + 3 * corners[1], x + 3 * corners[2], bary);

    if (distance < nearest->distance) {
      nearest->distance = distance;
      nearest->body = body;
      nearest->vertex = free_corner(shown->model.fixed, corners, bary);
    }
  }
}

/* numbers: origin 3 and direction 3 of the ray in; out: body, vertex (-1: that place is held),
 * distance. Returns 1 when something was hit. */
int32_t EXPORT(page_pick)(thrum_scene *scene) {
  ray world;
  for (int i = 0; i < 3; i++) {
    world.origin[i] = js_number[i];
    world.direction[i] = js_number[3 + i];
  }
  hit nearest = {-1, -1, INFINITY};
  for (int32_t body = 0; body < thrum_scene_body_count(scene); body++)
    pick_body(scene, body, &world, &nearest);
  js_number[0] = nearest.body;
  js_number[1] = nearest.vertex;
  js_number[2] = nearest.distance;
  return nearest.body >= 0;
}
