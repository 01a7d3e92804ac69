/* Bodies that lie inside an obstacle or another body: vertices that are inside, edges that go
 * through faces (Moller & Trumbore 1997, doi:10.1080/10867651.1997.10487468), and, as bodies at the
 * same place have neither, points of the middle. SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_link.h"
#include "scene/scene_shape.h"
#include "scene/scene_solid.h"

#include "core/base/vec3.h"

#include <stdlib.h>

#define INNER_MAX 64    /* points of the middle of a body that are tried */
#define MEETINGS 64     /* faces that an edge is followed through */
#define ON_RIM 1e-12    /* of a triangle or an edge: what meets its rim meets it */
#define ON_SURFACE 1e-9 /* of a body's size: a vertex so near is on the surface */
#define TOGETHER 1e-9   /* of an edge: faces that it meets so near each other are one */

/* The surface of a body or a solid in the world. */
typedef struct outline {
  double *points;           /* vertex_count x 3; owned */
  const int32_t *triangles; /* triangle_count x 3; of the body or the solid */
  int64_t triangle_count;
  int32_t *vertices; /* count: those of the triangles, each once; owned */
  int64_t count;
  bool open; /* it has no inside */
  double least[3], most[3];
} outline;

/* Adds a vertex of a body; its place is the same wherever it is named. */
static void place(const scene_body *body, int64_t vertex, outline *of) {
  const thrum_model *model = body->model;
  double *x = of->points + 3 * vertex;
  scene_point(body, model->vertices + 3 * vertex, model->basis + 3 * vertex * model->rank, x, NULL);
}

static void hold(outline *of, const double x[3]) {
  for (int axis = 0; axis < 3; axis++) {
    of->least[axis] = fmin(of->least[axis], x[axis]);
    of->most[axis] = fmax(of->most[axis], x[axis]);
  }
}

/* An outline of so many vertices, whose points are still to be filled in. */
static thrum_status open_outline(int64_t vertices, const int32_t *triangles, int64_t count,
                                 outline *of, thrum_error *error) {
  *of = (outline){.triangles = triangles, .triangle_count = count};
  for (int axis = 0; axis < 3; axis++) {
    of->least[axis] = INFINITY;
    of->most[axis] = -INFINITY;
  }
  if (vertices == 0)
    return THRUM_OK;

  // a vertex is named by several triangles; places beyond the list mark which ones are in it
  of->points = malloc(3 * (size_t)vertices * sizeof *of->points);
  of->vertices = calloc(2 * (size_t)vertices, sizeof *of->vertices);
  if (of->points == NULL || of->vertices == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the outline of a body");
  for (int64_t n = 0; n < 3 * count; n++) {
    int32_t *marked = of->vertices + vertices + triangles[n];
    if (*marked == 0)
      of->vertices[of->count++] = triangles[n];
    *marked = 1;
  }
  return THRUM_OK;
}

static thrum_status make_outline(scene_body *body, outline *of, thrum_error *error) {
  const bool seen = body->touch_count > 0 || body->triangle_count > 0;
  THRUM_TRY(open_outline(seen ? body->model->vertex_count : 0, body->triangles,
                         body->triangle_count, of, error));
  if (!seen)
    return THRUM_OK;

  // what may touch obstacles, and what is touched by others
  THRUM_TRY(scene_body_read(body, false, error));
  for (int64_t n = 0; n < body->touch_count; n++) {
    place(body, body->touching[n], of);
    hold(of, of->points + 3 * (int64_t)body->touching[n]);
  }
  for (int64_t n = 0; n < of->count; n++) {
    place(body, of->vertices[n], of);
    hold(of, of->points + 3 * (int64_t)of->vertices[n]);
  }
  return THRUM_OK;
}

/* The outline of a solid where it is now. */
static thrum_status make_solid_outline(const scene_solid *solid, outline *of, thrum_error *error) {
  const thrum_placement *now = &solid->moving.now;
  THRUM_TRY(open_outline(solid->vertex_count, solid->triangles, solid->triangle_count, of, error));
  of->open = solid->open;
  for (int64_t n = 0; n < solid->vertex_count; n++) {
    double *x = of->points + 3 * n;
    thrum_apply3(now->axes, solid->vertices + 3 * n, x);
    for (int axis = 0; axis < 3; axis++)
      x[axis] += now->origin[axis];
    hold(of, x);
  }
  return THRUM_OK;
}

static void free_outlines(outline *outlines, int64_t count) {
  for (int64_t n = 0; outlines != NULL && n < count; n++) {
    free(outlines[n].points);
    free(outlines[n].vertices);
  }
  free(outlines);
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

/* --- two surfaces ----------------------------------------------------------------------------- */

static bool is_in_box(const outline *of, const double x[3]) {
  bool in = true;
  for (int axis = 0; axis < 3; axis++)
    in = in && x[axis] >= of->least[axis] && x[axis] <= of->most[axis];
  return in;
}

/* How deep a point is inside a closed surface; 0 outside. */
static double depth_in(const outline *in, const double x[3]) {
  if (!is_in_box(in, x))
    return 0;
  return fmax(-thrum_triangles_distance(in->points, in->triangles, in->triangle_count, x), 0);
}

static const double *corner(const outline *of, int64_t triangle, int n) {
  return of->points + 3 * (int64_t)of->triangles[3 * triangle + n];
}

/* Does the line from x along `way` meet a triangle? *at: where, 1 at the end of the way. */
static bool meets(const outline *of, int64_t triangle, const double x[3], const double way[3],
                  double *at) {
  double a[3], b[3], from[3], across[3], turned[3];
  thrum_subtract3(corner(of, triangle, 1), corner(of, triangle, 0), a);
  thrum_subtract3(corner(of, triangle, 2), corner(of, triangle, 0), b);
  thrum_cross3(way, b, across);
  const double volume = thrum_dot3(a, across);
  if (volume == 0)
    return false;

  // where it meets the plane, in the coordinates of the triangle
  thrum_subtract3(x, corner(of, triangle, 0), from);
  const double u = thrum_dot3(from, across) / volume;
  thrum_cross3(from, a, turned);
  const double v = thrum_dot3(way, turned) / volume;
  *at = thrum_dot3(b, turned) / volume;
  return u >= -ON_RIM && v >= -ON_RIM && u + v <= 1 + ON_RIM;
}

/* The deepest point of an edge inside a closed surface, between each two faces that it meets. */
static double depth_of_edge(const double from[3], const double to[3], const outline *in) {
  double way[3], met[MEETINGS + 2], at;
  int count = 1;
  thrum_subtract3(to, from, way);

  // the ends, and the faces between them in their order
  met[0] = 0;
  for (int64_t t = 0; t < in->triangle_count && count <= MEETINGS; t++) {
    if (!meets(in, t, from, way, &at) || !(at > 0 && at < 1))
      continue;
    int place = count++;
    for (; place > 0 && met[place - 1] > at; place--)
      met[place] = met[place - 1];
    met[place] = at;
  }
  if (count == 1)
    return 0;
  met[count] = 1;

  double depth = 0;
  for (int n = 0; n < count; n++) {
    double middle[3];
    if (met[n + 1] - met[n] < TOGETHER)
      continue;
    for (int axis = 0; axis < 3; axis++)
      middle[axis] = from[axis] + 0.5 * (met[n] + met[n + 1]) * way[axis];
    depth = fmax(depth, depth_in(in, middle));
  }
  return depth;
}

/* How deep the end of an edge is behind an open surface that the edge goes through; 0: it does not.
 */
static double depth_behind(const double from[3], const double to[3], const outline *in) {
  double way[3], depth = 0, at;
  thrum_subtract3(to, from, way);
  for (int64_t t = 0; t < in->triangle_count; t++) {
    double a[3], b[3], normal[3];
    if (!meets(in, t, from, way, &at) || !(at > 0 && at < 1))
      continue;
    thrum_subtract3(corner(in, t, 1), corner(in, t, 0), a);
    thrum_subtract3(corner(in, t, 2), corner(in, t, 0), b);
    thrum_cross3(a, b, normal);
    const double along = thrum_dot3(way, normal) / sqrt(thrum_dot3(normal, normal));
    depth = fmax(depth, along < 0 ? -(1 - at) * along : at * along);
  }
  return depth;
}

/* Are the boxes of an edge and of an outline apart? */
static bool is_far(const double from[3], const double to[3], const outline *of) {
  bool apart = false;
  for (int axis = 0; axis < 3; axis++)
    apart = apart || fmax(from[axis], to[axis]) < of->least[axis] ||
            fmin(from[axis], to[axis]) > of->most[axis];
  return apart;
}

/* The deepest of the edges of one surface that go through faces of the other. */
static double depth_of_edges(const outline *of, const outline *in) {
  double depth = 0;
  for (int64_t n = 0; n < 3 * of->triangle_count; n++) {
    const int32_t first = of->triangles[n], second = of->triangles[n % 3 < 2 ? n + 1 : n - 2];
    const double *from = of->points + 3 * (int64_t)first, *to = of->points + 3 * (int64_t)second;

    // two triangles of a closed surface have the edge, either way round
    if ((first > second && !of->open) || is_far(from, to, in))
      continue;
    depth = fmax(depth, in->open ? depth_behind(from, to, in) : depth_of_edge(from, to, in));
  }
  return depth;
}

/* Fills x with the middle of a closed surface behind a triangle: halfway to what is opposite. */
static bool find_middle(const outline *of, int64_t triangle, double x[3]) {
  double a[3], b[3], inwards[3], nearest = INFINITY, at;
  thrum_subtract3(corner(of, triangle, 1), corner(of, triangle, 0), a);
  thrum_subtract3(corner(of, triangle, 2), corner(of, triangle, 0), b);
  thrum_cross3(b, a, inwards);
  for (int axis = 0; axis < 3; axis++)
    x[axis] = (corner(of, triangle, 0)[axis] + corner(of, triangle, 1)[axis] +
               corner(of, triangle, 2)[axis]) /
              3;
  for (int64_t t = 0; t < of->triangle_count; t++)
    if (t != triangle && meets(of, t, x, inwards, &at) && at > 0)
      nearest = fmin(nearest, at);
  for (int axis = 0; axis < 3 && isfinite(nearest); axis++)
    x[axis] += 0.5 * nearest * inwards[axis];
  return isfinite(nearest);
}

/* The deepest point of the middle of one closed surface inside another. */
static double depth_of_middle(const outline *of, const outline *in) {
  const int64_t every = 1 + of->triangle_count / INNER_MAX;
  double depth = 0;
  for (int64_t t = 0; t < of->triangle_count; t += every) {
    double x[3];
    if (find_middle(of, t, x))
      depth = fmax(depth, depth_in(in, x));
  }
  return depth;
}

/* How deep one closed surface is inside another by its vertices and its middle: half of its least
 * side where both fill the same place, and no vertex is deeper than the surface. */
static double depth_of_points(const outline *of, const outline *in) {
  double depth = 0, outside = 0, least = INFINITY, size = 0;
  for (int axis = 0; axis < 3; axis++) {
    least = fmin(least, of->most[axis] - of->least[axis]);
    size = fmax(size, of->most[axis] - of->least[axis]);
  }

  // its vertices, of which those outside of the box are outside of the surface too
  for (int64_t n = 0; n < of->count; n++) {
    const double *x = of->points + 3 * (int64_t)of->vertices[n];
    const double distance = is_in_box(in, x) ? thrum_triangles_distance(in->points, in->triangles,
                                                                        in->triangle_count, x)
                                             : INFINITY;
    depth = fmax(depth, -distance);
    outside = fmax(outside, distance);
  }
  if (of->open)
    return depth;

  // its middle, and whether both surfaces are one
  const double middle = depth_of_middle(of, in);
  const bool same = middle > 0 && fmax(depth, outside) <= ON_SURFACE * size;
  return fmax(fmax(depth, middle), same ? 0.5 * least : 0);
}

/* How deep one surface is inside another: its vertices, its edges, and its middle. */
static double depth_of(const outline *of, const outline *in) {
  for (int axis = 0; axis < 3; axis++)
    if (of->least[axis] > in->most[axis] || in->least[axis] > of->most[axis])
      return 0;
  const double depth = in->open ? 0 : depth_of_points(of, in);
  return fmax(depth, depth_of_edges(of, in));
}

/* A sphere that vertices touch and no vertex is in: how deep it is in the body. */
static double depth_of_sphere(const thrum_obstacle *sphere, const outline *of) {
  if (sphere->shape != THRUM_OBSTACLE_SPHERE || sphere->inside || of->triangle_count == 0)
    return 0;
  return fmax(sphere->radius - thrum_triangles_distance(of->points, of->triangles,
                                                        of->triangle_count, sphere->centre),
              0);
}

/* --- all bodies ------------------------------------------------------------------------------- */

static void look_at_obstacles(const thrum_scene *scene, int32_t number, const outline *of,
                              thrum_scene_overlap *deepest) {
  const scene_body *body = scene->bodies[number];
  for (int32_t o = 0; o < scene->obstacle_count; o++) {
    double depth = 0, normal[3];
    for (int64_t n = 0; n < body->touch_count; n++)
      depth = fmax(depth, -thrum_obstacle_gap(scene->obstacles + o,
                                              of->points + 3 * (int64_t)body->touching[n], normal));
    if (body->touch_count > 0)
      depth = fmax(depth, depth_of_sphere(scene->obstacles + o, of));
    note(deepest, of,
         (thrum_scene_overlap){
             .body = number, .other = -1, .obstacle = o, .solid = -1, .depth = depth});
  }
}

/* Has it a surface that touches others, or would if it were not condensed? */
static bool has_surface(const scene_body *body) {
  return body->skin != NULL || (body->triangle_count > 0 && body->derived->condensed);
}

/* Do two bodies touch each other, or would they? */
static bool meet(const thrum_scene *scene, const scene_body *a, const scene_body *b) {
  return scene->collides && a->collides && b->collides && has_surface(a) && has_surface(b);
}

thrum_status thrum_scene_find_overlap(thrum_scene *scene, thrum_scene_overlap *deepest,
                                      thrum_error *error) {
  thrum_scene_overlap found = {.body = -1, .other = -1, .obstacle = -1, .solid = -1};

  // solids are where they are now, also after a restore or a reset
  scene_solids_move(scene);
  const int64_t count = scene->body_count + scene->solid_count;
  outline *outlines = calloc((size_t)count + 1, sizeof *outlines);
  outline *solids = outlines != NULL ? outlines + scene->body_count : NULL;
  thrum_status status = outlines != NULL
                            ? THRUM_OK
                            : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for outlines");
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++)
    status = make_outline(scene->bodies[n], outlines + n, error);
  for (int32_t s = 0; status >= 0 && s < scene->solid_count; s++)
    status = make_solid_outline(scene->solids + s, solids + s, error);

  // each body against all obstacles and against all other bodies
  for (int32_t n = 0; status >= 0 && n < scene->body_count; n++) {
    const outline *of = outlines + n;
    thrum_scene_overlap in = {.body = n, .other = -1, .obstacle = -1, .solid = -1};
    look_at_obstacles(scene, n, of, &found);
    for (in.other = 0; in.other < scene->body_count; in.other++) {
      if (in.other == n || !meet(scene, scene->bodies[n], scene->bodies[in.other]) ||
          scene_links_join(scene, n, in.other))
        continue;
      in.depth = depth_of(of, outlines + in.other);
      note(&found, of, in);
    }

    // a solid may be the one that is inside
    in.other = -1;
    for (in.solid = 0; in.solid < scene->solid_count && has_surface(scene->bodies[n]); in.solid++) {
      in.depth = fmax(depth_of(of, solids + in.solid), depth_of(solids + in.solid, of));
      note(&found, of, in);
    }
  }
  free_outlines(outlines, count);
  if (status >= 0)
    *deepest = found;
  return status;
}
