/* Bodies and comparisons for the tests of precompute. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_PRECOMPUTE_SUPPORT_H
#define THRUM_TESTS_SUPPORT_PRECOMPUTE_SUPPORT_H

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "mesh/formats/mesh_read.h"
#include "mesh/mesh_fix.h"
#include "mesh/midsides.h"
#include "precompute/fem/fem.h"
#include "precompute/precompute.h"

#define TWO_PI 6.283185307179586

typedef struct body {
  thrum_mesh mesh;
  uint8_t *fixed;
} body;

static inline void *need(size_t count, size_t size) {
  void *memory = calloc(count + 1, size);
  assert_non_null(memory);
  return memory;
}

/* A number uniform in [-1, 1); the sequence is the same in every run. */
static inline double random_number(void) {
  static uint64_t state = 42;
  state = state * 6364136223846793005u + 1442695040888963407u;
  return (double)(state >> 11) / 4503599627370496.0 - 1;
}

/* A mesh by name and its supports (NULL: none). */
static inline body body_make(const char *name, const char *fix) {
  body made = {0};
  thrum_error error = {0};
  if (thrum_mesh_read(name, 1, &made.mesh, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  made.fixed = need((size_t)made.mesh.vertex_count, 1);
  int64_t count;
  if (fix && thrum_mesh_fix(&made.mesh, fix, made.fixed, &count, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return made;
}

static inline void body_free(body *b) {
  thrum_mesh_free(&b->mesh);
  free(b->fixed);
}

/* A body of ten-node tets; nodes move by up to `corner` and middle nodes by up to `middle` more. */
static inline body body_quadratic(const char *name, const char *fix, double corner, double middle) {
  body made = body_make(name, NULL);
  thrum_error error = {0};
  for (int64_t i = 0; i < 3 * made.mesh.vertex_count; i++)
    made.mesh.vertices[i] += corner * random_number();
  const int64_t corners = made.mesh.vertex_count;
  if (thrum_midsides_add(&made.mesh, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  for (int64_t i = 3 * corners; i < 3 * made.mesh.vertex_count; i++)
    made.mesh.vertices[i] += middle * random_number();

  // supports are looked up again, as there are more vertices now
  free(made.fixed);
  made.fixed = need((size_t)made.mesh.vertex_count, 1);
  int64_t count;
  if (fix && thrum_mesh_fix(&made.mesh, fix, made.fixed, &count, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return made;
}

/* Three regions along x, from 0 to `length`, each of another law and stiffness. */
static inline void body_divide(body *b, double length) {
  thrum_mesh *mesh = &b->mesh;
  const thrum_material first = mesh->materials[0];
  free(mesh->materials);
  free(mesh->laws);
  // the regions of the file had names, which these have not
  for (int64_t g = 0; g < mesh->region_count && mesh->region_names != NULL; g++)
    free(mesh->region_names[g]);
  free(mesh->region_names);
  mesh->region_names = NULL;
  mesh->region_count = 3;
  mesh->materials = need(3, sizeof *mesh->materials);
  mesh->laws = need(3, sizeof *mesh->laws);
  for (int i = 0; i < 3; i++) {
    mesh->materials[i] = first;
    mesh->materials[i].young *= 1 + 0.5 * i;
    mesh->laws[i] = (thrum_region_law){.law = (thrum_law)i};
  }

  // each tetrahedron is of the third of the length that its middle is in
  for (int64_t t = 0; t < mesh->tet_count; t++) {
    double x = 0;
    for (int a = 0; a < 4; a++)
      x += mesh->vertices[3 * (int64_t)mesh->tets[4 * t + a]] / 4;
    mesh->tet_region[t] = x < length / 3 ? 0 : x < 2 * length / 3 ? 1 : 2;
  }
}

static inline body body_beam1k(void) {
  return body_make(THRUM_TEST_DATA "/beam1k.veg", THRUM_TEST_DATA "/beam1k.bou");
}

static inline thrum_fem body_fem(const body *b) {
  thrum_fem fem = {0};
  thrum_error error = {0};
  if (thrum_fem_create(&b->mesh, b->fixed, &fem, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return fem;
}

static inline thrum_precomputed body_precompute(const body *b, int64_t modes, int64_t rank) {
  thrum_precompute_options options = thrum_default_precompute_options();
  options.modes = modes;
  options.rank = rank;
  thrum_precomputed result = {0};
  thrum_error error = {0};
  if (thrum_precompute(&b->mesh, b->fixed, &options, &result, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return result;
}

static inline double *random_vector(int64_t count, double size) {
  double *made = need((size_t)count, sizeof *made);
  for (int64_t i = 0; i < count; i++)
    made[i] = size * random_number();
  return made;
}

static inline double norm_of(const double *x, int64_t count) {
  double square = 0;
  for (int64_t i = 0; i < count; i++)
    square += x[i] * x[i];
  return sqrt(square);
}

static inline double dot_of(const double *x, const double *y, int64_t count) {
  double sum = 0;
  for (int64_t i = 0; i < count; i++)
    sum += x[i] * y[i];
  return sum;
}

/* |x - y| <= tolerance |y|; a failure reports the actual difference. */
static inline void assert_near(const double *x, const double *y, int64_t count, double tolerance) {
  double square = 0;
  for (int64_t i = 0; i < count; i++)
    square += (x[i] - y[i]) * (x[i] - y[i]);
  const double size = norm_of(y, count);
  if (!(sqrt(square) <= tolerance * size))
    fail_msg("relative distance %.3g exceeds %.3g", sqrt(square) / size, tolerance);
}

static inline void assert_close(double x, double y, double tolerance) {
  if (!(fabs(x - y) <= tolerance * fabs(y)))
    fail_msg("%.17g is not %.17g: relative distance %.3g exceeds %.3g", x, y, fabs(x - y) / fabs(y),
             tolerance);
}

/* Whether a mesh of the optional reference data is available. */
static inline bool have_data(const char *file) {
  char path[1024];
  snprintf(path, sizeof path, "%s/%s", THRUM_DATA, file);
  FILE *stream = strlen(THRUM_DATA) > 0 ? fopen(path, "rb") : NULL;
  if (stream)
    fclose(stream);
  return stream != NULL;
}

static inline body body_data(const char *mesh, const char *fix) {
  char mesh_path[1024], fix_path[1024];
  snprintf(mesh_path, sizeof mesh_path, "%s/%s", THRUM_DATA, mesh);
  snprintf(fix_path, sizeof fix_path, "%s/%s", THRUM_DATA, fix);
  return body_make(mesh_path, fix_path);
}

#endif
