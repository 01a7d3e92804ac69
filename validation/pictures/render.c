/* A software renderer for the pictures of bodies: triangles into a depth buffer, several samples a
 * pixel, light from three sides, darkness where little of the sky is seen.
 *
 * Both places of the body are drawn into buffers of samples. The moved one is shaded; of the one at
 * rest an outline is kept where its depth jumps. Normals are means over the faces around a corner
 * that are turned by less than a crease, so that round things look round and edges stay.
 * Darkness: the share of nearby samples that lie in front; M. Mittring 2007, Finding next gen,
 * doi:10.1145/1281500.1281671. SPDX-License-Identifier: Apache-2.0 */
#include "validation/pictures/render.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define SAMPLES 3       /* a pixel, along each axis */
#define MARGIN 0.04     /* of the smaller side of the part */
#define CREASE 0.50     /* cosine: faces turned further from each other make an edge */
#define DISTANCE 6.0    /* of the eye, in half sizes of the body */
#define SKY_SAMPLES 28  /* looked at for darkness */
#define SKY_RADIUS 0.05 /* of the height of the part */
#define PI 3.14159265358979323846

typedef struct vector {
  double x, y, z;
} vector;

/* The picture's plane: x right, y down, z away from the eye, in samples. */
typedef struct camera {
  vector right, up, away, centre;
  double half;             /* size of the body [m] */
  double scale, left, top; /* to samples */
} camera;

typedef struct buffer {
  int width, height;
  float *depth;  /* INFINITY: nothing; the far one is larger */
  float *normal; /* x 3, in the camera's frame */
  float *value;
} buffer;

static double dot(vector a, vector b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

static vector cross(vector a, vector b) {
  return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vector minus(vector a, vector b) {
  return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static vector unit(vector a) {
  const double length = sqrt(dot(a, a));
  return length > 0 ? (vector){a.x / length, a.y / length, a.z / length} : a;
}

static vector at(const double *points, int64_t n) {
  return (vector){points[3 * n], points[3 * n + 1], points[3 * n + 2]};
}

thrum_status experiment_image_make(int width, int height, experiment_image *image,
                                   thrum_error *error) {
  const size_t bytes = (size_t)width * (size_t)height * 3;
  uint8_t *pixels = malloc(bytes + 1);
  if (pixels == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a picture");
  memset(pixels, 255, bytes);
  *image = (experiment_image){width, height, pixels};
  return THRUM_OK;
}

void experiment_image_free(experiment_image *image) {
  free(image->pixels);
  memset(image, 0, sizeof *image);
}

void experiment_color(double value, double rgb[3]) {
  // from a quiet blue over ivory to a deep red
  static const double stops[6][3] = {{0.30, 0.50, 0.78}, {0.54, 0.77, 0.90}, {0.90, 0.95, 0.90},
                                     {1.00, 0.85, 0.55}, {0.97, 0.55, 0.32}, {0.80, 0.16, 0.20}};
  const double place = 5 * fmin(fmax(value, 0), 1);
  const int n = place >= 5 ? 4 : (int)place;
  for (int c = 0; c < 3; c++)
    rgb[c] = stops[n][c] + (place - n) * (stops[n + 1][c] - stops[n][c]);
}

static camera point_camera(const experiment_view *view) {
  const double a = view->azimuth * PI / 180, e = view->elevation * PI / 180;
  const vector away = {-cos(a) * cos(e), -sin(a) * cos(e), -sin(e)};
  camera c = {.away = away, .right = {-sin(a), cos(a), 0}};
  c.up = cross(c.right, away);
  return c;
}

/* In front of the camera: x and y on the plane of the centre, z the distance beyond it [m]. */
static vector seen(const camera *c, vector point) {
  const vector p = minus(point, c->centre);
  const double z = dot(p, c->away), near = DISTANCE * c->half / (DISTANCE * c->half + z);
  return (vector){dot(p, c->right) * near, -dot(p, c->up) * near, z};
}

static vector project(const camera *c, vector point) {
  const vector s = seen(c, point);
  return (vector){c->left + c->scale * s.x, c->top + c->scale * s.y, c->scale * s.z};
}

/* Makes both places of the body fill `width` x `height` samples. */
static void fit(const experiment_solid *solid, int width, int height, camera *c) {
  vector least = {INFINITY, INFINITY, INFINITY}, most = {-INFINITY, -INFINITY, -INFINITY};
  for (int64_t n = 0; n < 2 * solid->vertex_count; n++) {
    const vector p = at(n % 2 ? solid->moved : solid->rest, n / 2);
    least = (vector){fmin(least.x, p.x), fmin(least.y, p.y), fmin(least.z, p.z)};
    most = (vector){fmax(most.x, p.x), fmax(most.y, p.y), fmax(most.z, p.z)};
  }
  const vector size = minus(most, least);
  c->centre = (vector){least.x + size.x / 2, least.y + size.y / 2, least.z + size.z / 2};
  c->half = 0.5 * sqrt(dot(size, size));
  double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
  for (int64_t n = 0; n < 2 * solid->vertex_count; n++) {
    const vector s = seen(c, at(n % 2 ? solid->moved : solid->rest, n / 2));
    x0 = fmin(x0, s.x);
    x1 = fmax(x1, s.x);
    y0 = fmin(y0, s.y);
    y1 = fmax(y1, s.y);
  }
  const double room = 1 - 2 * MARGIN;
  c->scale = room * fmin(width / (x1 - x0), height / (y1 - y0));
  c->left = 0.5 * width - c->scale * 0.5 * (x0 + x1);
  c->top = 0.5 * height - c->scale * 0.5 * (y0 + y1);
}

static bool buffer_make(int width, int height, buffer *b) {
  const size_t count = (size_t)width * (size_t)height;
  b->width = width;
  b->height = height;
  b->depth = malloc(count * sizeof *b->depth);
  b->normal = calloc(3 * count, sizeof *b->normal);
  b->value = calloc(count, sizeof *b->value);
  if (b->depth == NULL || b->normal == NULL || b->value == NULL)
    return false;
  for (size_t n = 0; n < count; n++)
    b->depth[n] = INFINITY;
  return true;
}

static void buffer_free(buffer *b) {
  free(b->depth);
  free(b->normal);
  free(b->value);
}

static vector face_normal(const experiment_solid *solid, const double *points, int64_t face) {
  const int32_t *f = solid->faces + 3 * face;
  const vector a = at(points, f[0]);
  return cross(minus(at(points, f[1]), a), minus(at(points, f[2]), a));
}

/* Which faces meet at each vertex: those of v are list[first[v]] up to list[first[v + 1]]. */
typedef struct corners {
  int64_t *first;
  int64_t *list;
} corners;

static bool corners_make(const experiment_solid *solid, corners *c) {
  c->first = calloc((size_t)solid->vertex_count + 2, sizeof *c->first);
  c->list = calloc((size_t)(3 * solid->face_count) + 1, sizeof *c->list);
  if (c->first == NULL || c->list == NULL)
    return false;
  for (int64_t n = 0; n < 3 * solid->face_count; n++)
    c->first[solid->faces[n] + 2]++;
  for (int64_t v = 0; v < solid->vertex_count; v++)
    c->first[v + 2] += c->first[v + 1];
  for (int64_t n = 0; n < 3 * solid->face_count; n++)
    c->list[c->first[solid->faces[n] + 1]++] = n / 3;
  return true;
}

/* The normal at a corner of a face: the mean of those around it that are not beyond a crease. */
static vector corner_normal(const experiment_solid *solid, const double *points, const corners *c,
                            int64_t face, int32_t vertex) {
  const vector own = unit(face_normal(solid, points, face));
  vector sum = {0, 0, 0};
  for (int64_t n = c->first[vertex]; n < c->first[vertex + 1]; n++) {
    // weighted by area
    const vector other = face_normal(solid, points, c->list[n]);
    if (dot(own, unit(other)) < CREASE)
      continue;
    sum = (vector){sum.x + other.x, sum.y + other.y, sum.z + other.z};
  }
  return unit(sum);
}

/* One sample of a triangle, where it is the nearest so far. */
static void set_sample(buffer *b, size_t place, const double w[3], const vector p[3],
                       const vector n[3], const double value[3]) {
  const double depth = w[0] * p[0].z + w[1] * p[1].z + w[2] * p[2].z;
  if (!(depth < b->depth[place]))
    return;
  b->depth[place] = (float)depth;
  b->value[place] = (float)(w[0] * value[0] + w[1] * value[1] + w[2] * value[2]);
  const vector sum = unit((vector){w[0] * n[0].x + w[1] * n[1].x + w[2] * n[2].x,
                                   w[0] * n[0].y + w[1] * n[1].y + w[2] * n[2].y,
                                   w[0] * n[0].z + w[1] * n[1].z + w[2] * n[2].z});
  b->normal[3 * place] = (float)sum.x;
  b->normal[3 * place + 1] = (float)sum.y;
  b->normal[3 * place + 2] = (float)sum.z;
}

static void draw_triangle(buffer *b, const vector p[3], const vector n[3], const double value[3]) {
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
  const int x0 = (int)fmax(0, floor(fmin(p[0].x, fmin(p[1].x, p[2].x))));
  const int y0 = (int)fmax(0, floor(fmin(p[0].y, fmin(p[1].y, p[2].y))));
  const int x1 = (int)fmin(b->width - 1, ceil(fmax(p[0].x, fmax(p[1].x, p[2].x))));
  const int y1 = (int)fmin(b->height - 1, ceil(fmax(p[0].y, fmax(p[1].y, p[2].y))));
  if (area == 0)
    return;
  for (int y = y0; y <= y1; y++) {
    for (int x = x0; x <= x1; x++) {
      double w[3];
      for (int k = 0; k < 3; k++) {
        const vector s = p[(k + 1) % 3], e = p[(k + 2) % 3];
        w[k] = ((e.x - s.x) * (y + 0.5 - s.y) - (x + 0.5 - s.x) * (e.y - s.y)) / area;
      }
      if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0)
        set_sample(b, (size_t)y * (size_t)b->width + (size_t)x, w, p, n, value);
    }
  }
}

static void draw(const experiment_solid *solid, const double *points, const camera *c,
                 const corners *around, buffer *b) {
  for (int64_t face = 0; face < solid->face_count; face++) {
    vector p[3], n[3];
    double value[3];
    for (int k = 0; k < 3; k++) {
      const int32_t v = solid->faces[3 * face + k];
      const vector normal = corner_normal(solid, points, around, face, v);
      p[k] = project(c, at(points, v));
      n[k] = (vector){dot(normal, c->right), dot(normal, c->up), -dot(normal, c->away)};
      value[k] = solid->value[v];
    }
    draw_triangle(b, p, n, value);
  }
}

static float depth_at(const buffer *b, int x, int y) {
  if (x < 0 || y < 0 || x >= b->width || y >= b->height)
    return INFINITY;
  return b->depth[(size_t)y * (size_t)b->width + (size_t)x];
}

/* Does the depth jump within `reach` samples of here? */
static bool outline(const buffer *b, int x, int y, int reach, double jump) {
  const float here = depth_at(b, x, y);
  for (int dy = -reach; dy <= reach; dy++) {
    for (int dx = -reach; dx <= reach; dx++) {
      if (dx * dx + dy * dy > reach * reach)
        continue;
      // on the nearer side alone, or the line would be twice as wide
      if (depth_at(b, x + dx, y + dy) > here + jump)
        return true;
    }
  }
  return false;
}

/* The share of the sky that is seen from a sample, over a spiral of others around it. */
static double sky(const buffer *b, int x, int y, double radius) {
  const float here = depth_at(b, x, y);
  double hidden = 0;
  for (int n = 0; n < SKY_SAMPLES; n++) {
    const double share = (n + 0.5) / SKY_SAMPLES, turn = 2.399963 * n + 0.7 * ((x * 7 + y * 3) % 9);
    const double reach = radius * sqrt(share);
    const double front = here - (double)depth_at(b, x + (int)lrint(reach * cos(turn)),
                                                 y + (int)lrint(reach * sin(turn)));
    // what is far in front is another part of the body, not a fold
    if (front > 0.15 * radius)
      hidden += front < 2 * radius ? 1 : fmax(0, 2 - front / (2 * radius));
  }
  return 1 - hidden / SKY_SAMPLES;
}

/* Light from the upper left, a weaker one from the right, and the sky. */
static void shade(const buffer *b, int x, int y, double radius, double rgb[3]) {
  static const vector key = {-0.48, 0.68, 0.56}, fill = {0.78, 0.10, 0.62};
  const size_t place = (size_t)y * (size_t)b->width + (size_t)x;
  const vector n = {b->normal[3 * place], b->normal[3 * place + 1], b->normal[3 * place + 2]};
  const double open = sky(b, x, y, radius);
  const double light = (0.54 + 0.12 * n.y) * (0.40 + 0.60 * open) +
                       0.58 * fmax(0, dot(n, key)) * (0.55 + 0.45 * open) +
                       0.14 * fmax(0, dot(n, fill));
  // a soft highlight: half way between the light and the eye
  const vector half = unit((vector){key.x, key.y, key.z + 1});
  const double shine = 0.16 * pow(fmax(0, dot(n, half)), 24);
  experiment_color(b->value[place], rgb);
  for (int k = 0; k < 3; k++)
    rgb[k] = fmin(1, rgb[k] * light + shine);
}

static void blend(double rgb[3], double grey, double share) {
  for (int k = 0; k < 3; k++)
    rgb[k] += share * (grey - rgb[k]);
}

/* One sample of the picture. */
static void compose(const buffer *rest, const buffer *moved, int x, int y, double radius,
                    double rgb[3]) {
  const bool body = isfinite(depth_at(moved, x, y)), ghost = isfinite(depth_at(rest, x, y));
  rgb[0] = rgb[1] = rgb[2] = 1;
  if (ghost && !body)
    blend(rgb, 0.86, 0.5);
  if (body) {
    shade(moved, x, y, radius, rgb);
    if (outline(moved, x, y, SAMPLES / 2, 0.3 * radius))
      blend(rgb, 0.12, 0.55);
  }
  if (ghost && outline(rest, x, y, SAMPLES - 1, 0.6 * radius))
    blend(rgb, 0.30, body ? 0.20 : 0.62);
}

/* Averages the samples of each pixel. */
static void resolve(const buffer *rest, const buffer *moved, const experiment_view *view,
                    experiment_image *image) {
  const double radius = SKY_RADIUS * moved->height;
  for (int py = 0; py < view->height; py++) {
    for (int px = 0; px < view->width; px++) {
      double sum[3] = {0, 0, 0};
      for (int n = 0; n < SAMPLES * SAMPLES; n++) {
        double rgb[3];
        compose(rest, moved, SAMPLES * px + n % SAMPLES, SAMPLES * py + n / SAMPLES, radius, rgb);
        for (int k = 0; k < 3; k++)
          sum[k] += rgb[k];
      }
      uint8_t *pixel = image->pixels + 3 * ((size_t)(view->top + py) * (size_t)image->width +
                                            (size_t)(view->left + px));
      for (int k = 0; k < 3; k++)
        pixel[k] = (uint8_t)lrint(255 * sum[k] / (SAMPLES * SAMPLES));
    }
  }
}

thrum_status experiment_render(const experiment_solid *solid, const experiment_view *view,
                               experiment_image *image, thrum_error *error) {
  if (view->left < 0 || view->top < 0 || view->width < 1 || view->height < 1 ||
      view->left + view->width > image->width || view->top + view->height > image->height)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the view lies outside the picture");
  camera c = point_camera(view);
  buffer rest = {0}, moved = {0};
  corners around = {0};
  thrum_status status = THRUM_OK;
  fit(solid, SAMPLES * view->width, SAMPLES * view->height, &c);
  if (!buffer_make(SAMPLES * view->width, SAMPLES * view->height, &rest) ||
      !buffer_make(SAMPLES * view->width, SAMPLES * view->height, &moved) ||
      !corners_make(solid, &around)) {
    status = thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a picture");
  } else {
    draw(solid, solid->rest, &c, &around, &rest);
    draw(solid, solid->moved, &c, &around, &moved);
    resolve(&rest, &moved, view, image);
  }
  buffer_free(&rest);
  buffer_free(&moved);
  free(around.first);
  free(around.list);
  return status;
}
