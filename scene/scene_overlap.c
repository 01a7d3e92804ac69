/* Bodies that lie inside an obstacle or another body. SPDX-License-Identifier: Apache-2.0 */
#include "runtime/base/fp_contract.h"

#include "runtime/base/vec3.h"
#include "scene/scene_private.h"

#include <stdlib.h>

#define ON_SURFACE 1e-9 /* of a body's size: a vertex so near is on the surface */
#define BELOW 1e-4      /* of a body's size: how far below a face a point is inside */

/* A body's vertices in the world, as far as they may touch. */
typedef struct outline {
  double *points;    /* vertex_count x 3; owned */
  int32_t *vertices; /* count: those of the triangles, each once; owned */
  int64_t count;
  double least[3], most[3];
} outline;

/* Adds a vertex; its place is the same wherever it is named. */
static void place(const scene_body *body, int64_t vertex, outline *of) {
  const thrum_model *model = body->model;
  double *x = of->points + 3 * vertex;
  scene_point(body, model->vertices + 3 * vertex, model->basis + 3 * vertex * model->rank, x, NULL);
  for (int axis = 0; axis < 3; axis++) {
    of->least[axis] = fmin(of->least[axis], x[axis]);
    of->most[axis] = fmax(of->most[axis], x[axis]);
  }
}

static thrum_status make_outline(scene_body *body, outline *of, thrum_error *error) {
  for (int axis = 0; axis < 3; axis++) {
    of->least[axis] = INFINITY;
    of->most[axis] = -INFINITY;
  }
  if (body->touch_count == 0 && body->triangle_count == 0)
    return THRUM_OK;
  THRUM_TRY(scene_body_read(body, false, error));
  of->points = malloc(3 * (size_t)body->model->vertex_count * sizeof *of->points);
  if (of->points == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the outline of a body");
  for (int64_t n = 0; n < body->touch_count; n++)
    place(body, body->touching[n], of);
  for (int64_t n = 0; n < 3 * body->triangle_count; n++)
    place(body, body->triangles[n], of);

  // a vertex is named by several triangles; places beyond the list mark which ones are in it
  const size_t vertices = (size_t)body->model->vertex_count;
  of->vertices = calloc(2 * vertices, sizeof *of->vertices);
  if (of->vertices == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the outline of a body");
  for (int64_t n = 0; n < 3 * body->triangle_count; n++) {
    int32_t *marked = of->vertices + vertices + body->triangles[n];
    if (*marked == 0)
      of->vertices[of->count++] = body->triangles[n];
    *marked = 1;
  }
  return THRUM_OK;
}

/* Keeps what is deeper for the size of its body. */
static void note(thrum_scene_overlap *deepest, const outline *of, thrum_scene_overlap found) {
  const double sides[3] = {of->most[0] - of->least[0], of->most[1] - of->least[1],
                           of->most[2] - of->least[2]};
  found.diagonal = sqrt(thrum_dot3(sides, sides));
  if (found.depth > 0 &&
      (deepest->body < 0 || found.depth * deepest->diagonal > deepest->depth * found.diagonal))
    *deepest = found;
}

static void look_at_obstacles(const thrum_scene *scene, int32_t number, const outline *of,
                              thrum_scene_overlap *deepest) {
  const scene_body *body = scene->bodies[number];
  for (int32_t o = 0; o < scene->obstacle_count; o++) {
    double depth = 0, normal[3];
    for (int64_t n = 0; n < body->touch_count; n++)
      depth = fmax(depth, -thrum_obstacle_gap(scene->obstacles + o,
                                              of->points + 3 * (int64_t)body->touching[n], normal));
    note(deepest, of,
         (thrum_scene_overlap){
             .body = number, .other = -1, .obstacle = o, .solid = -1, .depth = depth});
  }
}

static bool is_in_box(const outline *of, const double x[3]) {
  bool in = true;
  for (int axis = 0; axis < 3; axis++)
    in = in && x[axis] >= of->least[axis] && x[axis] <= of->most[axis];
  return in;
}

/* Does the body lie inside the other one, of which all its vertices are on the surface? A point
 * just below the first face that has an area is looked at. */
static bool lies_within(const outline *of, const scene_body *a, const outline *in,
                        const scene_body *b, double size) {
  for (int64_t t = 0; t < a->triangle_count; t++) {
    const int32_t *corner = a->triangles + 3 * t;
    const double *p = of->points + 3 * (int64_t)corner[0];
    double side[2][3], normal[3], x[3];
    for (int n = 0; n < 2; n++)
      thrum_subtract3(of->points + 3 * (int64_t)corner[n + 1], p, side[n]);
    thrum_cross3(side[0], side[1], normal);
    const double length = sqrt(thrum_dot3(normal, normal));
    if (!(length > 0))
      continue;

    // below its middle
    for (int axis = 0; axis < 3; axis++)
      x[axis] =
          p[axis] + (side[0][axis] + side[1][axis]) / 3.0 - BELOW * size * normal[axis] / length;
    return thrum_triangles_distance(in->points, b->triangles, b->triangle_count, x) < 0;
  }
  return false;
}

/* The deepest vertex of one body inside another; half of its least side where it fills the same
 * place, and no vertex is deeper than the surface. */
static void look_at_pair(const thrum_scene *scene, const outline *outlines, int32_t number,
                         int32_t other, thrum_scene_overlap *deepest) {
  const scene_body *b = scene->bodies[other];
  const outline *of = outlines + number, *in = outlines + other;
  double depth = 0, outside = 0, least = INFINITY, size = 0;
  for (int axis = 0; axis < 3; axis++) {
    if (of->least[axis] > in->most[axis] || in->least[axis] > of->most[axis])
      return;
    least = fmin(least, of->most[axis] - of->least[axis]);
    size = fmax(size, of->most[axis] - of->least[axis]);
  }

  for (int64_t n = 0; n < of->count; n++) {
    const double *x = of->points + 3 * (int64_t)of->vertices[n];
    const double distance =
        is_in_box(in, x) ? thrum_triangles_distance(in->points, b->triangles, b->triangle_count, x)
                         : INFINITY;
    depth = fmax(depth, -distance);
    outside = fmax(outside, distance);
  }
  if (fmax(depth, outside) <= ON_SURFACE * size &&
      lies_within(of, scene->bodies[number], in, b, size))
    depth = 0.5 * least;
  note(deepest, of,
       (thrum_scene_overlap){
           .body = number, .other = other, .obstacle = -1, .solid = -1, .depth = depth});
}

/* The deepest vertex of a body inside a solid; a height field has no inside. */
static void look_at_solid(const thrum_scene *scene, int32_t number, const outline *of,
                          int32_t index, thrum_scene_overlap *deepest) {
  const scene_solid *solid = scene->solids + index;
  const thrum_placement *now = &solid->moving.now;
  double depth = 0, least[3] = {INFINITY, INFINITY, INFINITY};
  double most[3] = {-INFINITY, -INFINITY, -INFINITY};
  if (solid->open)
    return;
  for (int64_t n = 0; n < 3 * solid->vertex_count; n++) {
    least[n % 3] = fmin(least[n % 3], solid->vertices[n]);
    most[n % 3] = fmax(most[n % 3], solid->vertices[n]);
  }

  // vertices in the axes of the solid
  for (int64_t n = 0; n < of->count; n++) {
    double from[3], x[3];
    thrum_subtract3(of->points + 3 * (int64_t)of->vertices[n], now->origin, from);
    thrum_apply3_transposed(now->axes, from, x);
    bool in = true;
    for (int axis = 0; axis < 3; axis++)
      in = in && x[axis] >= least[axis] && x[axis] <= most[axis];
    if (in)
      depth = fmax(depth, -thrum_triangles_distance(solid->vertices, solid->triangles,
                                                    solid->triangle_count, x));
  }
  note(deepest, of,
       (thrum_scene_overlap){
           .body = number, .other = -1, .obstacle = -1, .solid = index, .depth = depth});
}

/* Do two bodies touch each other? */
static bool meet(const thrum_scene *scene, const scene_body *a, const scene_body *b) {
  return scene->collides && a->collides && b->collides && a->skin != NULL && b->skin != NULL;
}

thrum_status thrum_scene_find_overlap(thrum_scene *scene, thrum_scene_overlap *deepest,
                                      thrum_error *error) {
  thrum_scene_overlap found = {.body = -1, .other = -1, .obstacle = -1, .solid = -1};

  // solids are where they are now, also after a restore or a reset
  scene_solids_move(scene);
  outline *outlines = calloc((size_t)scene->body_count + 1, sizeof *outlines);
  thrum_status status = outlines != NULL
                            ? THRUM_OK
                            : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for outlines");
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++)
    status = make_outline(scene->bodies[n], outlines + n, error);

  // each body against all obstacles and against all other bodies
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++) {
    look_at_obstacles(scene, n, outlines + n, &found);
    for (int32_t m = 0; m < scene->body_count; m++)
      if (m != n && meet(scene, scene->bodies[n], scene->bodies[m]) &&
          !scene_links_join(scene, n, m))
        look_at_pair(scene, outlines, n, m, &found);
    for (int32_t s = 0; s < scene->solid_count && scene->bodies[n]->skin != NULL; s++)
      look_at_solid(scene, n, outlines + n, s, &found);
  }
  for (int32_t n = 0; outlines != NULL && n < scene->body_count; n++) {
    free(outlines[n].points);
    free(outlines[n].vertices);
  }
  free(outlines);
  if (status >= 0)
    *deepest = found;
  return status;
}
