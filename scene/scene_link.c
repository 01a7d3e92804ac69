/* Links between places of bodies, or of a body and the world (thrum/link.h): what weighs the
 * vertices of a place and of its directions, ends that follow a path, and which links hold.
 *
 * A place is the mean of given vertices, or of those that are near it, moved to where it is asked
 * for by weights that add up to 0; a direction has such weights alone. With m weights that fall
 * with the distance, y positions, c their mean and C = sum m (y - c)(y - c)^T,
 *
 *   w = m (y - c) C^-1 e:   sum w = 0,   sum w y = e,
 *
 * least in sum w^2/m of all that have these sums. Between two times of a path an end goes by a
 * cubic that overshoots nothing (Fritsch & Butland 1984, doi:10.1137/0905021), at rest at both
 * ends.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "scene/scene_link.h"

#include "scene/scene_access.h"
#include "scene/scene_fields.h"
#include "scene/scene_memory.h"
#include "scene/scene_pairs_room.h"
#include "scene/scene_placement.h"
#include "scene/scene_shape.h"

#include "core/base/def.h"
#include "core/base/finite.h"
#include "core/base/intervals.h"
#include "core/base/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NEAR 0.15   /* of the diagonal: vertices that are so near a place weigh in its directions */
#define SPREAD 1e-9 /* det C over (trace C)^3, below which they lie in a plane */
#define WIDER 12    /* doublings of that distance, before the body is called flat */
#define WHOLE 1e-6  /* steps within which a time is that of a step (thrum_load_mean) */
#define REACH_MAX 1e30 /* how far places may be [m], how fast paths [m/s], and their times [s] */
#define ARM_MAX 1e6    /* diagonals of a body up to which its deformation moves a place exactly */
#define LINKS_MAX 1024 /* of a scene, as thrum_contact_pairs_def has room for */

/* --- places and directions of a body ---------------------------------------------------------- */

/* A body's vertices as they are now, in its axes, and what they weigh. */
typedef struct cloud {
  const scene_body *body;
  double *at;                   /* vertex_count x 3 [m] */
  double *near;                 /* vertex_count: fall with the distance from the place */
  double *weights;              /* vertex_count: of what is being made */
  double middle[3], inverse[9]; /* c and C^-1 */
} cloud;

static int64_t size_of(const cloud *c) {
  return c->body->model->vertex_count;
}

/* The inverse of a symmetric 3 x 3 matrix; false where its points lie in a plane. */
static bool invert(const double matrix[9], double inverse[9]) {
  const double trace = matrix[0] + matrix[4] + matrix[8];
  const double determinant = thrum_triple3(matrix, matrix + 3, matrix + 6);
  if (!(determinant > SPREAD * (trace * trace * trace)))
    return false;
  for (int row = 0; row < 3; row++) {
    double product[3];
    thrum_cross3(matrix + 3 * ((row + 1) % 3), matrix + 3 * ((row + 2) % 3), product);
    for (int axis = 0; axis < 3; axis++)
      inverse[3 * row + axis] = product[axis] / determinant;
  }
  return true;
}

/* The weight of a vertex by the square of its distance, in that of the reach: nearly exp(-square),
 * by operations whose bits are the same everywhere. */
static double fall_off(double square) {
  const double share = 1.0 / (1.0 + 0.125 * square), fourth = (share * share) * (share * share);
  return fourth * fourth;
}

/* Weighs the vertices by their distance from a place; false where those near it lie in a plane. */
static bool weigh(cloud *c, const double place[3], double reach) {
  double nearest = INFINITY, sum = 0.0, matrix[9] = {0};
  memset(c->middle, 0, sizeof c->middle);

  // a place far from the body is near its nearest vertices
  for (int64_t v = 0; v < size_of(c); v++) {
    double way[3];
    thrum_subtract3(c->at + 3 * v, place, way);
    c->near[v] = thrum_dot3(way, way);
    nearest = fmin(nearest, c->near[v]);
  }
  for (int64_t v = 0; v < size_of(c); v++) {
    c->near[v] = fall_off((c->near[v] - nearest) / (reach * reach));
    sum += c->near[v];
    for (int axis = 0; axis < 3; axis++)
      c->middle[axis] += c->near[v] * c->at[3 * v + axis];
  }
  for (int axis = 0; axis < 3; axis++)
    c->middle[axis] /= sum;

  // how they are spread about their mean
  for (int64_t v = 0; v < size_of(c); v++) {
    double way[3];
    thrum_subtract3(c->at + 3 * v, c->middle, way);
    for (int n = 0; n < 9; n++)
      matrix[n] += c->near[v] / sum * way[n / 3] * way[n % 3];
    c->weights[v] = c->near[v] / sum;
  }
  memcpy(c->near, c->weights, (size_t)size_of(c) * sizeof *c->near);
  return invert(matrix, c->inverse);
}

/* weights += those of a direction e. */
static void add_direction(cloud *c, const double e[3]) {
  double by[3], way[3];
  thrum_apply3(c->inverse, e, by);
  for (int64_t v = 0; v < size_of(c); v++) {
    thrum_subtract3(c->at + 3 * v, c->middle, way);
    c->weights[v] += c->near[v] * thrum_dot3(way, by);
  }
}

/* The place and its rows, or a direction, that the weights make. */
static void sum_up(const cloud *c, double rest[3], double *rows) {
  const thrum_model *model = c->body->model;
  const int64_t rank = c->body->derived->rank;
  const double scale = c->body->derived->by.length;
  memset(rest, 0, 3 * sizeof *rest);
  memset(rows, 0, 3 * (size_t)rank * sizeof *rows);
  for (int64_t v = 0; v < size_of(c); v++)
    for (int axis = 0; axis < 3 && c->weights[v] != 0.0; axis++) {
      const double *row = model->basis + (3 * v + axis) * model->rank;
      rest[axis] += c->weights[v] * scale * model->vertices[3 * v + axis];
      for (int64_t i = 0; i < rank; i++)
        rows[axis * rank + i] += c->weights[v] * c->body->k * row[i];
    }
}

/* Where the weights are now. */
static void centre_of(const cloud *c, double at[3]) {
  memset(at, 0, 3 * sizeof *at);
  for (int64_t v = 0; v < size_of(c); v++)
    for (int axis = 0; axis < 3; axis++)
      at[axis] += c->weights[v] * c->at[3 * v + axis];
}

static void cloud_free(cloud *c) {
  free(c->at);
  free(c->near);
  free(c->weights);
}

static thrum_status cloud_make(scene_body *body, cloud *c, thrum_error *error) {
  const thrum_model *model = body->model;
  const size_t count = (size_t)model->vertex_count;
  *c = (cloud){.body = body};
  THRUM_TRY(scene_body_read(body, false, error));
  c->at = malloc(3 * count * sizeof *c->at);
  c->near = malloc(count * sizeof *c->near);
  c->weights = malloc(count * sizeof *c->weights);
  if (!c->at || !c->near || !c->weights)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a link");

  // X + U q of the scaled body
  for (size_t n = 0; n < 3 * count; n++) {
    double moved = 0.0;
    for (int64_t i = 0; i < body->derived->rank; i++)
      moved += model->basis[n * (size_t)model->rank + (size_t)i] * body->q[i];
    c->at[n] = body->derived->by.length * model->vertices[n] + body->k * moved;
  }
  return THRUM_OK;
}

/* A point of the world in the axes of a body, and back. */
static void into_body(const scene_body *body, const double in_world[3], double out[3]) {
  double way[3];
  thrum_subtract3(in_world, body->here.origin, way);
  scene_to_body(&body->here, way, out);
}

static void out_of_body(const scene_body *body, const double in_body[3], double out[3]) {
  scene_to_world(&body->here, in_body, out);
  for (int axis = 0; axis < 3; axis++)
    out[axis] += body->here.origin[axis];
}

/* Equal shares of the vertices of a list (NULL: all). */
static void share(cloud *c, const int32_t *vertices, int64_t count) {
  memset(c->weights, 0, (size_t)size_of(c) * sizeof *c->weights);
  const int64_t all = vertices ? count : size_of(c);
  for (int64_t n = 0; n < all; n++)
    c->weights[vertices ? vertices[n] : n] += 1.0 / (double)all;
}

/* Refuses a place so far from a body that the end of the arm to it is lost in rounding. */
static thrum_status check_arm(const cloud *c, const double place[3], thrum_error *error) {
  double arm[3];
  thrum_subtract3(place, c->at, arm);
  if (sqrt(thrum_dot3(arm, arm)) <= ARM_MAX * thrum_box3_diagonal(c->at, size_of(c)))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_BAD_VALUE,
                         "a place of a link is more than 1e6 times the size of body '%s' away from "
                         "it",
                         c->body->name);
}

/* Fills one side: the place, which is `place` in the world where that is known and becomes it where
 * it is not, and the three directions. near: by vertices near the place, in place of a list. */
static thrum_status fill_side(cloud *c, const int32_t *vertices, int64_t count, bool near,
                              double place[3], const double directions[9], double rest[12],
                              double *rows, thrum_error *error) {
  const scene_body *body = c->body;
  const int64_t rank = body->derived->rank;
  double at[3], off[3];
  share(c, vertices, count);
  centre_of(c, at);
  if (isnan(place[0]))
    out_of_body(body, at, place);
  into_body(body, place, at);
  THRUM_TRY(check_arm(c, at, error));

  // directions need vertices on all sides of a plane
  double reach = NEAR * thrum_box3_diagonal(c->at, size_of(c));
  for (int n = 0; !weigh(c, at, reach); n++, reach *= 2.0)
    if (n == WIDER)
      return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                             "the vertices of body '%s' lie in a plane: a link has no direction "
                             "there",
                             body->name);

  // the mean, and what moves it to the place
  if (!near)
    share(c, vertices, count);
  centre_of(c, off);
  thrum_subtract3(at, off, off);
  add_direction(c, off);
  sum_up(c, rest, rows);
  for (int n = 0; n < 3; n++) {
    double own[3];
    scene_to_body(&body->here, directions + 3 * n, own);
    memset(c->weights, 0, (size_t)size_of(c) * sizeof *c->weights);
    add_direction(c, own);
    sum_up(c, rest + 3 * (n + 1), rows + 3 * (n + 1) * rank);
  }
  return THRUM_OK;
}

/* Room for the rows of a side, which belong to the link. */
static thrum_status make_rows(const scene_body *body, scene_link *link, int side,
                              thrum_error *error) {
  const size_t rank = (size_t)body->derived->rank;
  link->rows[side] = calloc(12 * rank, sizeof *link->rows[side]);
  if (link->rows[side] == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a link");
  link->sides[side].rows = link->rows[side];
  link->sides[side].rank = (int64_t)rank;
  return THRUM_OK;
}

static thrum_status make_side(scene_body *body, const int32_t *vertices, int64_t count, bool near,
                              double place[3], const double directions[9], scene_link *link,
                              int side, thrum_error *error) {
  cloud c;
  thrum_status status = cloud_make(body, &c, error);
  THRUM_THEN(status, make_rows(body, link, side, error));
  THRUM_THEN(status, fill_side(&c, vertices, count, near, place, directions, link->sides[side].rest,
                               link->rows[side], error));
  cloud_free(&c);
  return status;
}

/* --- the world's end -------------------------------------------------------------------------- */

/* The slope of a path at one of its times, along an axis. */
static double slope_at(const scene_link *link, int64_t n, int axis) {
  if (n == 0 || n + 1 >= link->path_count)
    return 0.0;
  const double *t = link->times + n, *x = link->path + 3 * n + axis;
  const double before = (x[0] - x[-3]) / (t[0] - t[-1]), after = (x[3] - x[0]) / (t[1] - t[0]);
  return before * after > 0.0 ? 2.0 * before * after / (before + after) : 0.0;
}

/* Where the world's end of a link is at a time. */
static void end_at(const scene_link *link, double time, double place[3]) {
  memcpy(place, link->end, sizeof link->end);
  if (link->path_count == 0)
    return;
  const int64_t from = thrum_interval_at(link->times, link->path_count, time);
  const int64_t to = from + 1 < link->path_count ? from + 1 : from;
  const double length = link->times[to] - link->times[from];
  double s = length > 0.0 ? (time - link->times[from]) / length : 0.0;
  s = fmin(fmax(s, 0.0), 1.0);

  // by Hermite's cubic, from where the path begins
  for (int axis = 0; axis < 3; axis++) {
    const double a = link->path[3 * from + axis], b = link->path[3 * to + axis];
    const double u = length * slope_at(link, from, axis), v = length * slope_at(link, to, axis);
    const double rise = (b - a) * (s * s * (3.0 - 2.0 * s));
    const double bends = s * (1.0 - s) * ((1.0 - s) * u - s * v);
    place[axis] += a - link->path[axis] + rise + bends;
  }
}

static thrum_placement placement_at(const scene_link *link, double time) {
  thrum_placement at = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  end_at(link, time, at.origin);
  return at;
}

/* --- adding ----------------------------------------------------------------------------------- */

static thrum_status check_vertices(const scene_body *body, const int32_t *vertices, int64_t count,
                                   thrum_error *error) {
  THRUM_TRY(scene_vertex_check(body, 0, error));
  if (vertices != NULL && count < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a link is given no vertices");
  for (int64_t n = 0; vertices != NULL && n < count; n++)
    THRUM_TRY(scene_vertex_check(body, vertices[n], error));
  return THRUM_OK;
}

/* A side that was made before, of a body that steps as many coordinates as it has columns. */
static thrum_status check_side(const scene_body *body, const thrum_scene_link_side *side,
                               thrum_error *error) {
  if (side->rows == NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a link's ready side on body '%s' has no rows", body->name);
  if (side->rank != body->derived->rank)
    return thrum_error_set(error, THRUM_MODEL_MISMATCH,
                           "a link's ready side has %lld coordinates, and body '%s' steps %lld",
                           (long long)side->rank, body->name, (long long)body->derived->rank);
  if (!thrum_all_finite(side->rest, 12) || !thrum_all_finite(side->rows, 12 * side->rank))
    return thrum_error_set(error, THRUM_BAD_VALUE, "a link's ready side on body '%s' is not finite",
                           body->name);
  return THRUM_OK;
}

/* The body of a side, by its vertices or by a ready side (NULL: none). */
static thrum_status check_body(const thrum_scene *scene, int32_t number, const int32_t *vertices,
                               int64_t count, const thrum_scene_link_side *side, scene_body **body,
                               thrum_error *error) {
  THRUM_TRY(scene_body_at(scene, number, body, error));
  if ((*body)->derived->condensed || (*body)->detail != NULL)
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "body '%s' is condensed, by a rank below its model's as well, or has a level of "
        "detail, and cannot be linked: step all of its coordinates",
        (*body)->name);
  return side != NULL ? check_side(*body, side, error)
                      : check_vertices(*body, vertices, count, error);
}

static bool is_amount(double value) {
  return value >= 0.0 && value <= THRUM_CONTACT_STIFFNESS_MAX;
}

/* Within the range in which distances to fourth powers are finite. */
static bool is_near(const double place[3]) {
  return fabs(place[0]) <= REACH_MAX && fabs(place[1]) <= REACH_MAX && fabs(place[2]) <= REACH_MAX;
}

/* A place that is given, or not at all. */
static bool is_place(const double place[3]) {
  return (isnan(place[0]) && isnan(place[1]) && isnan(place[2])) || is_near(place);
}

/* Is the way from one time and place of a path to the next slow enough for finite slopes? */
static bool is_way(const double times[2], const double places[6]) {
  const double length = times[1] - times[0];
  bool slow = length > 0.0;
  for (int axis = 0; axis < 3; axis++)
    slow = slow && fabs(places[3 + axis] - places[axis]) / length <= REACH_MAX;
  return slow;
}

static thrum_status check_path(const thrum_scene_link_def *def, thrum_error *error) {
  if (def->path_count < 0 || def->path_count > (INT64_C(1) << 24) ||
      (def->path_count > 0 && (def->path_times == NULL || def->path_places == NULL)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the path of a link has 1 to 2^24 times, each with a place");
  if (def->path_count > 0 && def->other >= 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a link of two bodies follows no path: its end must be in the world");

  // times ascend, so that there is one way from each to the next
  for (int64_t n = 0; n < def->path_count; n++)
    if (!(fabs(def->path_times[n]) <= REACH_MAX) || !is_near(def->path_places + 3 * n) ||
        (n > 0 && !is_way(def->path_times + n - 1, def->path_places + 3 * (n - 1))))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "place %lld of a link's path is not within 1e30 m, its time is not "
                             "after the one before or not within 1e30 s, or the way there is "
                             "faster than 1e30 m/s",
                             (long long)n);
  return THRUM_OK;
}

static thrum_status check_def(const thrum_scene *scene, const thrum_scene_link_def *def,
                              thrum_error *error) {
  THRUM_TRY(scene_fields_check(THRUM_SCENE_RECORD_LINK, def, error));
  if (def->kind < THRUM_LINK_SPRING || def->kind > THRUM_LINK_WELD)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a link is of no known kind");
  if (scene->link_count == LINKS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "a scene has at most %d links",
                           LINKS_MAX);
  if (def->other == def->body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a link is of two bodies, or of a body and the world");
  if (def->other < 0 && def->other_vertices != NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a link with the world has no vertices there");

  // written so that NaN is refused as well
  if (!is_amount(def->stiffness) || !is_amount(def->damping) ||
      def->length > THRUM_CONTACT_STIFFNESS_MAX)
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "the stiffness and damping of a link must be 0 to 1e30, its length at "
                           "most that");
  if (!is_place(def->place) || !is_place(def->other_place))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a place of a link is not within 1e30 m: set all three of its numbers, "
                           "or none");
  if (def->sides != NULL &&
      (isnan(def->place[0]) || (def->kind == THRUM_LINK_SPRING && isnan(def->other_place[0]))))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a link with ready sides needs its place, and a spring its other place");
  if (def->sides != NULL && def->other < 0 && !thrum_all_finite(def->sides[1].rest + 3, 9))
    return thrum_error_set(error, THRUM_BAD_VALUE,
                           "a link's ready side in the world is not finite");
  if (!isnormal(thrum_dot3(def->axis, def->axis)))
    return thrum_error_set(error, THRUM_BAD_VALUE, "the axis of a link has no length");
  return check_path(def, error);
}

/* Three directions at right angles, the first along an axis. */
static void make_directions(const double axis[3], double directions[9]) {
  // the axis of the world that is most across it leads to the second
  const double length = sqrt(thrum_dot3(axis, axis));
  int least = 0;
  for (int n = 0; n < 3; n++) {
    directions[n] = axis[n] / length;
    least = fabs(axis[n]) < fabs(axis[least]) ? n : least;
  }

  // at right angles, and of length 1
  const double unit[3] = {least == 0, least == 1, least == 2};
  thrum_cross3(directions, unit, directions + 3);
  const double scale = 1.0 / sqrt(thrum_dot3(directions + 3, directions + 3));
  for (int n = 3; n < 6; n++)
    directions[n] *= scale;
  thrum_cross3(directions, directions + 3, directions + 6);
}

static thrum_status keep_path(const thrum_scene_link_def *def, scene_link *link,
                              thrum_error *error) {
  const size_t count = (size_t)def->path_count;
  if (count == 0)
    return THRUM_OK;
  link->times = malloc(count * sizeof *link->times);
  link->path = malloc(3 * count * sizeof *link->path);
  if (link->times == NULL || link->path == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the path of a link");
  memcpy(link->times, def->path_times, count * sizeof *link->times);
  memcpy(link->path, def->path_places, 3 * count * sizeof *link->path);
  link->path_count = def->path_count;
  return THRUM_OK;
}

static void free_link(scene_link *link) {
  free(link->sides);
  free(link->rows[0]);
  free(link->rows[1]);
  free(link->times);
  free(link->path);
}

/* Both sides of the meshes, as the bodies are now; place and other become those of its ends. */
static thrum_status weigh_sides(const thrum_scene_link_def *def, scene_body *bodies[2],
                                double place[3], double other[3], scene_link *link,
                                thrum_error *error) {
  const bool joint = def->kind != THRUM_LINK_SPRING;
  double directions[9];
  make_directions(def->axis, directions);
  THRUM_TRY(make_side(bodies[0], def->vertices, def->count,
                      def->vertices == NULL && !isnan(place[0]), place, directions, link, 0,
                      error));

  // a joint is at one place, a spring has two
  if (joint || (isnan(other[0]) && def->other_vertices == NULL))
    memcpy(other, place, 3 * sizeof *other);
  if (bodies[1] != NULL)
    return make_side(bodies[1], def->other_vertices, def->other_count, def->other_vertices == NULL,
                     other, directions, link, 1, error);
  memcpy(link->sides[1].rest + 3, directions, sizeof directions);
  return THRUM_OK;
}

/* Both sides as they were made before. */
static thrum_status copy_sides(const thrum_scene_link_def *def, scene_body *bodies[2],
                               scene_link *link, thrum_error *error) {
  for (int n = 0; n < 2; n++) {
    const thrum_scene_link_side *side = def->sides + n;
    memcpy(link->sides[n].rest, side->rest, sizeof side->rest);
    if (bodies[n] == NULL)
      continue;
    THRUM_TRY(make_rows(bodies[n], link, n, error));
    memcpy(link->rows[n], side->rows, 12 * (size_t)side->rank * sizeof *side->rows);
  }
  return THRUM_OK;
}

/* Both sides, and what a spring is at its beginning. */
static thrum_status make_sides(const thrum_scene_link_def *def, scene_body *bodies[2],
                               scene_link *link, thrum_error *error) {
  const bool joint = def->kind != THRUM_LINK_SPRING;
  link->sides = calloc(2, sizeof *link->sides);
  if (link->sides == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a link");
  memcpy(link->place, def->place, sizeof link->place);
  memcpy(link->end, def->sides != NULL && joint ? def->place : def->other_place, sizeof link->end);
  THRUM_TRY(def->sides != NULL ? copy_sides(def, bodies, link, error)
                               : weigh_sides(def, bodies, link->place, link->end, link, error));

  // a spring may begin with energy
  double way[3];
  thrum_subtract3(link->place, link->end, way);
  const double apart = sqrt(thrum_dot3(way, way));
  const double length = def->length >= 0 ? def->length : apart;
  link->tie.length = joint ? 0.0 : length;
  link->began = joint ? 0.0 : 0.5 * def->stiffness * ((apart - length) * (apart - length));
  link->tie.report.stored = link->began;
  return THRUM_OK;
}

/* Ties or unties both bodies, which need a contact as long as they are tied. */
static thrum_status tie(thrum_scene *scene, const scene_link *link, int32_t by,
                        thrum_error *error) {
  scene->bodies[link->body]->tied += by;
  if (link->other >= 0)
    scene->bodies[link->other]->tied += by;
  return scene_pairs_equip(scene, error);
}

thrum_status thrum_scene_add_link(thrum_scene *scene, const thrum_scene_link_def *def,
                                  int32_t *number, thrum_error *error) {
  thrum_scene_link_def whole = thrum_default_scene_link_def();
  def = thrum_def_whole(def, &whole, sizeof whole);
  scene_body *bodies[2] = {NULL, NULL};
  THRUM_TRY(check_def(scene, def, error));
  THRUM_TRY(check_body(scene, def->body, def->vertices, def->count, def->sides, bodies, error));
  if (def->other >= 0)
    THRUM_TRY(check_body(scene, def->other, def->other_vertices, def->other_count,
                         def->sides != NULL ? def->sides + 1 : NULL, bodies + 1, error));
  if (!scene_grow(&scene->links, scene->link_count + 1, sizeof *scene->links))
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a link");

  // the link as it is now
  scene_link made = {
      .body = def->body,
      .other = def->other < 0 ? -1 : def->other,
      .until = def->until,
      .since = scene->steps,
      .tie = {.kind = def->kind, .stiffness = def->stiffness, .damping = def->damping}};
  thrum_status status = make_sides(def, bodies, &made, error);
  THRUM_THEN(status, keep_path(def, &made, error));
  if (status < 0) {
    free_link(&made);
    return status;
  }

  // the bodies that it ties need a contact
  scene->links[scene->link_count++] = made;
  status = tie(scene, &made, 1, error);
  if (status < 0) {
    scene->link_count--;
    tie(scene, &made, -1, NULL);
    free_link(&made);
    return status;
  }
  scene->revision++;
  scene->stirred++;
  if (number != NULL)
    *number = scene->link_count - 1;
  return THRUM_OK;
}

void scene_links_free(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->link_count; n++)
    free_link(scene->links + n);
  free(scene->links);
}

/* --- in a step -------------------------------------------------------------------------------- */

/* A spring that lets go keeps what it holds. */
static void let_go(scene_link *link) {
  link->released = true;
  link->tie.report.lost += link->tie.report.stored;
  link->tie.report.stored = link->tie.report.drift = 0.0;
  memset(link->tie.report.force, 0, sizeof link->tie.report.force);
  memset(link->tie.report.torque, 0, sizeof link->tie.report.torque);
}

void scene_links_begin(thrum_scene *scene) {
  const double time = thrum_scene_time(scene);
  for (int32_t n = 0; n < scene->link_count; n++) {
    scene_link *link = scene->links + n;

    // a body that has failed steps no more, so what it was tied to is free of it
    const bool failed = scene->bodies[link->body]->status < 0 ||
                        (link->other >= 0 && scene->bodies[link->other]->status < 0);
    if (!link->released && (failed || time >= link->until - WHOLE * scene->dt))
      let_go(link);
    link->holds = !link->released;
    link->moving = (thrum_contact_solid){.now = placement_at(link, time),
                                         .next = placement_at(link, time + scene->dt)};
  }
}

/* The member of a body, which lie in the order of their numbers. */
static int64_t member_of(const thrum_contact_member *members, int64_t count, int32_t number) {
  for (int64_t n = 0; n < count; n++)
    if (members[n].number == number)
      return n;
  return -1;
}

thrum_contact_links scene_links_gather(thrum_scene *scene, int32_t group,
                                       thrum_contact_member *members, int64_t *count,
                                       thrum_link *room) {
  const int64_t bodies = *count;
  thrum_contact_links links = {.links = room};
  for (int32_t n = 0; n < scene->link_count; n++) {
    scene_link *link = scene->links + n;
    if (!link->holds || scene->bodies[link->body]->group != group)
      continue;

    // the world's end is a member of its own
    int64_t second = *count;
    if (link->other < 0)
      members[(*count)++] =
          (thrum_contact_member){.solid = &link->moving, .number = LINK_MEMBERS + n};
    else
      second = member_of(members, bodies, link->other);
    link->tie.sides[0] = (thrum_link_side){member_of(members, bodies, link->body),
                                           link->sides[0].rest, link->sides[0].rows};
    link->tie.sides[1] = (thrum_link_side){second, link->sides[1].rest, link->sides[1].rows};
    room[links.count++] = link->tie;
  }
  return links;
}

void scene_links_keep(thrum_scene *scene, int32_t group, const thrum_contact_links *links) {
  int64_t at = 0;
  for (int32_t n = 0; n < scene->link_count; n++)
    if (scene->links[n].holds && scene->bodies[scene->links[n].body]->group == group)
      scene->links[n].tie = links->links[at++];
}

bool scene_links_join(const thrum_scene *scene, int32_t a, int32_t b) {
  for (int32_t n = 0; n < scene->link_count; n++) {
    const scene_link *link = scene->links + n;
    if (!link->released && link->tie.kind != THRUM_LINK_SPRING &&
        ((link->body == a && link->other == b) || (link->body == b && link->other == a)))
      return true;
  }
  return false;
}

void scene_links_reset(thrum_scene *scene) {
  for (int32_t n = 0; n < scene->link_count; n++) {
    scene_link *link = scene->links + n;
    link->released = link->since > 0;
    link->tie.steps = 0;
    link->tie.report = (thrum_link_report){.stored = link->released ? 0.0 : link->began};
  }
}

/* --- calls ------------------------------------------------------------------------------------ */

int32_t thrum_scene_link_count(const thrum_scene *scene) {
  return scene->link_count;
}

static thrum_status link_at(const thrum_scene *scene, int32_t number, scene_link **link,
                            thrum_error *error) {
  if (number < 0 || number >= scene->link_count)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no link %d: the scene has %d",
                           (int)number, (int)scene->link_count);
  *link = scene->links + number;
  return THRUM_OK;
}

thrum_status thrum_scene_link_release(thrum_scene *scene, int32_t number, thrum_error *error) {
  scene_link *link = NULL;
  THRUM_TRY(link_at(scene, number, &link, error));
  if (!link->released)
    let_go(link);
  scene->stirred++;
  return THRUM_OK;
}

thrum_status thrum_scene_link_made(const thrum_scene *scene, int32_t number,
                                   thrum_scene_link_def *def, thrum_error *error) {
  scene_link *link = NULL;
  THRUM_TRY(link_at(scene, number, &link, error));
  thrum_scene_link_def made = thrum_default_scene_link_def();
  made.kind = link->tie.kind;
  made.body = link->body;
  made.other = link->other;
  made.sides = link->sides;
  memcpy(made.place, link->place, sizeof made.place);
  memcpy(made.other_place, link->end, sizeof made.other_place);

  // values that the def left to be found are returned as numbers
  made.stiffness = link->tie.stiffness;
  made.damping = link->tie.damping;
  made.length = link->tie.length;
  made.path_times = link->times;
  made.path_places = link->path;
  made.path_count = link->path_count;
  made.until = link->until;
  *def = made;
  return THRUM_OK;
}

/* Where the place of a side is now. */
static thrum_status place_of(scene_body *body, const thrum_scene_link_side *side, double place[3],
                             thrum_error *error) {
  const int64_t rank = body->derived->rank;
  double at[3];
  THRUM_TRY(scene_body_read(body, false, error));
  for (int axis = 0; axis < 3; axis++) {
    at[axis] = side->rest[axis];
    for (int64_t i = 0; i < rank; i++)
      at[axis] += side->rows[axis * rank + i] * body->q[i];
  }
  out_of_body(body, at, place);
  return THRUM_OK;
}

thrum_status thrum_scene_link_get(thrum_scene *scene, int32_t number, thrum_scene_link *got,
                                  thrum_error *error) {
  scene_link *link = NULL;
  THRUM_TRY(link_at(scene, number, &link, error));
  thrum_scene_link filled = (thrum_scene_link){.holds = !link->released,
                                               .kind = link->tie.kind,
                                               .bodies = {link->body, link->other},
                                               .length = link->tie.length,
                                               .report = link->tie.report};

  // the places now, of which the world's goes along its path
  THRUM_TRY(place_of(scene->bodies[link->body], link->sides, filled.places[0], error));
  if (link->other >= 0)
    THRUM_TRY(place_of(scene->bodies[link->other], link->sides + 1, filled.places[1], error));
  else
    end_at(link, thrum_scene_time(scene), filled.places[1]);
  *got = filled;
  return THRUM_OK;
}
