/* Tests of surfaces for display: u = U q in single precision against the product in double
 * precision, rest positions, chosen vertices, strides, ranges, normals, and the arguments that are
 * refused.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/state_support.h"

#include "runtime/readout/surface_private.h"
#include "thrum/displacement.h"
#include "thrum/surface.h"

/* Makes a surface in a heap block of exactly its size: a sanitizer sees the first byte beyond it.
 */
static const thrum_surface *surface_make(const thrum_model *model, const thrum_surface_def *def) {
  size_t size = 0;
  thrum_error error;
  if (thrum_surface_size(model, def, &size, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  void *memory = aligned_alloc(64, size);
  assert_non_null(memory);
  memset(memory, 0xff, size);
  const thrum_surface *surface = NULL;
  if (thrum_surface_init(memory, size, model, def, &surface, &error) != THRUM_OK)
    fail_msg("%s", error.message);
  return surface;
}

static void surface_free(const thrum_surface *surface) {
  free((void *)(uintptr_t)surface);
}

enum { VERTICES_MAX = 70, RANKS = 4 };
static const int64_t ranks[RANKS] = {1, 5, 30, 61};

static void displacements_are_those_of_the_model_to_single_rounding(void **context) {
  (void)context;

  // counts of vertices around the width of a block
  static const int64_t counts[] = {4, 15, 16, 17, 32, 70};
  for (int r = 0; r < RANKS; r++)
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++) {
      // the surface of a whole random model, without triangles
      random_model m;
      random_model_make(&m, 3, ranks[r], 1, 9, INFINITY);
      random_model_add_mesh(&m, 5, counts[c]);
      const thrum_surface_def def = {.vertices = NULL};
      const thrum_surface *surface = surface_make(&m.model, &def);
      assert_int_equal(thrum_surface_vertex_count(surface), counts[c]);
      assert_int_equal(thrum_surface_triangle_count(surface), 0);

      // displacements and positions in single precision, and the product in double precision
      double q[64], u[3 * VERTICES_MAX];
      float shown[3 * VERTICES_MAX], placed[3 * VERTICES_MAX];
      random_state random = {9};
      random_vector(&random, ranks[r], 1, q);
      assert_int_equal(thrum_displacement(&m.model, q, 0, counts[c], u, NULL), THRUM_OK);
      assert_int_equal(thrum_surface_positions(surface, THRUM_SURFACE_DISPLACEMENTS, q, 0,
                                               counts[c], shown, 3, NULL),
                       THRUM_OK);
      assert_int_equal(thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, counts[c],
                                               placed, 3, NULL),
                       THRUM_OK);

      for (int64_t n = 0; n < 3 * counts[c]; n++) {
        // the classical bound of a sum in floats: (rank + 2) u sum |U_i q_i|
        double bound = 0;
        for (int64_t i = 0; i < ranks[r]; i++)
          bound += fabs(m.basis[n * ranks[r] + i] * q[i]);
        bound *= (double)(ranks[r] + 2) * 0x1p-24;
        assert_true(fabs((double)shown[n] - u[n]) <= bound + 1e-45);
        assert_true(fabs((double)placed[n] - (m.vertices[n] + u[n])) <=
                    bound + 0x1p-23 * (fabs(m.vertices[n]) + fabs(u[n])));
      }
      surface_free(surface);
      random_model_free(&m);
    }
}

static void every_kernel_gives_the_bits_of_plain_c(void **context) {
  (void)context;

  // every rank has its own remainder in the unrolled loops
  for (int64_t rank = 1; rank <= 100; rank++) {
    float *rows = aligned_alloc(64, (size_t)rank * THRUM_SURFACE_LANES * sizeof(float));
    assert_non_null(rows);
    float q[100], a[THRUM_SURFACE_LANES], b[THRUM_SURFACE_LANES];
    random_state random = {(uint64_t)rank};

    // both kernels add to the same start values
    for (int64_t n = 0; n < rank * THRUM_SURFACE_LANES; n++)
      rows[n] = (float)random_uniform(&random);
    for (int64_t i = 0; i < rank; i++)
      q[i] = (float)random_uniform(&random);
    for (int s = 0; s < THRUM_SURFACE_LANES; s++)
      a[s] = b[s] = (float)random_uniform(&random);

    // the best kernel of this machine and plain C agree to the bit
    thrum_surface_kernel_reference(rank, rows, q, a);
    thrum_surface_kernel_best()(rank, rows, q, b);
    assert_memory_equal(a, b, sizeof a);
    free(rows);
  }
}

static void chosen_vertices_come_in_their_order_and_nothing_else_is_written(void **context) {
  (void)context;
  enum { COUNT = 37, STRIDE = 5 };

  // vertices in any order, some of them several times
  random_model m;
  random_model_make(&m, 3, 7, 1, 9, INFINITY);
  random_model_add_mesh(&m, 5, 50);
  int32_t chosen[COUNT];
  random_state random = {4};
  for (int n = 0; n < COUNT; n++)
    chosen[n] = (int32_t)random_index(&random, 50);

  // the surface of the chosen vertices, and that of the whole mesh to compare with
  const thrum_surface_def some = {.vertices = chosen, .vertex_count = COUNT};
  const thrum_surface_def whole = {.vertices = NULL};
  const thrum_surface *part = surface_make(&m.model, &some);
  const thrum_surface *all = surface_make(&m.model, &whole);
  double q[7];
  random_vector(&random, 7, 1, q);
  float full[3 * 50], out[COUNT * STRIDE];
  assert_int_equal(thrum_surface_positions(all, THRUM_SURFACE_POSITIONS, q, 0, 50, full, 3, NULL),
                   THRUM_OK);

  // any range gives the bits of the whole
  for (int64_t first = 0; first < COUNT; first++)
    for (int64_t count = 0; count <= COUNT - first; count++) {
      // gaps between the vertices and everything behind the range keep their values
      for (int n = 0; n < COUNT * STRIDE; n++)
        out[n] = -7.0f;
      assert_int_equal(thrum_surface_positions(part, THRUM_SURFACE_POSITIONS, q, first, count, out,
                                               STRIDE, NULL),
                       THRUM_OK);
      for (int64_t n = 0; n < COUNT; n++) {
        if (n < count)
          assert_memory_equal(out + n * STRIDE, full + 3 * chosen[first + n], 3 * sizeof(float));
        for (int64_t s = n < count ? 3 : 0; s < STRIDE; s++)
          assert_true(out[n * STRIDE + s] == -7.0f);
      }
    }
  surface_free(part);
  surface_free(all);
  random_model_free(&m);
}

static void a_sphere_has_radial_normals_and_a_lone_vertex_none(void **context) {
  (void)context;

  // a sphere of rings and two poles; the last vertex belongs to no triangle
  enum { RINGS = 24, SIDES = 48, COUNT = RINGS * SIDES + 3, TRIANGLES = 2 * RINGS * SIDES };
  static double vertices[3 * COUNT], basis[3 * COUNT];
  static int32_t triangles[3 * TRIANGLES];
  static float out[6 * COUNT];

  // the vertices of the rings and the poles
  for (int r = 0; r < RINGS; r++)
    for (int s = 0; s < SIDES; s++) {
      const double theta = pi * (r + 1) / (RINGS + 1), phi = 2 * pi * s / SIDES;
      double *v = vertices + 3 * (r * SIDES + s);
      v[0] = sin(theta) * cos(phi);
      v[1] = sin(theta) * sin(phi);
      v[2] = cos(theta);
    }
  const int32_t north = RINGS * SIDES, south = north + 1;
  vertices[3 * north + 2] = 1;
  vertices[3 * south + 2] = -1;

  // two triangles for each cell between the rings, oriented outwards
  int64_t count = 0;
  for (int32_t r = 0; r + 1 < RINGS; r++)
    for (int32_t s = 0; s < SIDES; s++) {
      const int32_t a = r * SIDES + s, b = r * SIDES + (s + 1) % SIDES, c = a + SIDES,
                    d = b + SIDES;
      const int32_t two[6] = {a, c, b, b, c, d};
      memcpy(triangles + 3 * count, two, sizeof two);
      count += 2;
    }

  // the caps around the poles
  for (int32_t s = 0; s < SIDES; s++, count += 2) {
    const int32_t last = (RINGS - 1) * SIDES, next = (s + 1) % SIDES;
    const int32_t caps[6] = {north, s, next, south, last + next, last + s};
    memcpy(triangles + 3 * count, caps, sizeof caps);
  }
  assert_int_equal(count, TRIANGLES);

  // a model of rank 1 over this mesh
  thrum_model model;
  memset(&model, 0, sizeof model);
  model.rank = 1;
  model.vertex_count = COUNT;
  model.vertices = vertices;
  // the mode scales the sphere, which leaves the normals as they are
  memcpy(basis, vertices, sizeof basis);
  model.basis = basis;

  const thrum_surface_def def = {.triangles = triangles, .triangle_count = TRIANGLES};
  for (int k = 0; k < 2; k++) {
    // the second time the areas are so small that their squares underflow in single precision
    for (int n = 0; n < 3 * COUNT && k == 1; n++)
      basis[n] = vertices[n] *= 1e-12;
    const double scale = k == 1 ? 1e12 : 1;
    const thrum_surface *surface = surface_make(&model, &def);
    assert_int_equal(thrum_surface_triangle_count(surface), TRIANGLES);

    // positions and normals share one buffer
    const double q = 0.5;
    assert_int_equal(
        thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, &q, 0, COUNT, out, 6, NULL),
        THRUM_OK);
    assert_int_equal(thrum_surface_normals(surface, out, 6, out + 3, 6, NULL), THRUM_OK);

    // normals have unit length and point along the radius
    for (int n = 0; n < COUNT - 1; n++) {
      double along = 0, length = 0;
      for (int axis = 0; axis < 3; axis++) {
        along += (double)out[6 * n + 3 + axis] * vertices[3 * n + axis] * scale;
        length += (double)out[6 * n + 3 + axis] * (double)out[6 * n + 3 + axis];
      }
      assert_true(fabs(length - 1) < 1e-6);
      assert_true(along > 0.99);
    }

    // the vertex without triangles has the normal zero
    for (int axis = 0; axis < 3; axis++)
      assert_true(out[6 * (COUNT - 1) + 3 + axis] == 0.0f);
    surface_free(surface);
  }
}

static void missing_arguments_of_a_surface_are_refused(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 3, 4, 1, 9, INFINITY);
  random_model_add_mesh(&m, 5, 20);
  const thrum_surface_def whole = {.vertices = NULL};
  size_t size = 77;
  assert_int_equal(thrum_surface_size(NULL, &whole, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_size(&m.model, NULL, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_size(&m.model, &whole, NULL, NULL), THRUM_INVALID_ARGUMENT);
  thrum_model bare = m.model;
  bare.vertices = NULL;
  assert_int_equal(thrum_surface_size(&bare, &whole, &size, NULL), THRUM_MISSING);

  // a surface of its own: positions and rows together, for all coordinates, without vertices
  static const double positions[3] = {0};
  static const float rows[3 * (THRUM_RANK_MAX + 1)] = {0};
  static const int32_t vertices[1] = {0};
  const thrum_surface_def own = {
      .positions = positions, .rows = rows, .row_rank = 4, .vertex_count = 1};
  for (int n = 0; n < 5; n++) {
    thrum_surface_def wrong = own;
    wrong.positions = n == 0 ? NULL : positions;
    wrong.rows = n == 1 ? NULL : rows;
    wrong.vertices = n == 2 ? vertices : NULL;
    wrong.row_rank = n == 3 ? 3 : n == 4 ? THRUM_RANK_MAX + 1 : 4;
    assert_int_equal(thrum_surface_size(&m.model, &wrong, &size, NULL), THRUM_INVALID_ARGUMENT);
  }
  assert_int_equal(size, 77);

  // readings from what is no surface, and no surface's counts
  void *torn = aligned_alloc(64, 4096);
  assert_non_null(torn);
  memset(torn, 0, 4096);
  const double q[4] = {0};
  float out[3];
  const thrum_surface_output rest = THRUM_SURFACE_POSITIONS;
  assert_int_equal(thrum_surface_positions(NULL, rest, q, 0, 1, out, 3, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_positions(torn, rest, q, 0, 1, out, 3, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_vertex_count(NULL), 0);
  assert_int_equal(thrum_surface_triangle_count(NULL), 0);
  free(torn);
  random_model_free(&m);
}

static void vertices_outside_the_mesh_are_refused_and_nothing_is_written(void **context) {
  (void)context;

  // a model without a mesh has no surface
  random_model m;
  random_model_make(&m, 3, 4, 1, 9, INFINITY);
  const thrum_surface_def whole = {.vertices = NULL};
  size_t size = 77;
  thrum_error error;
  assert_int_equal(thrum_surface_size(&m.model, &whole, &size, &error), THRUM_MISSING);
  random_model_add_mesh(&m, 5, 20);

  // vertices and triangles outside the mesh, empty lists, and counts beyond 2^31 - 1
  static const int32_t beyond[3] = {0, 20, 1}, below[3] = {0, -1, 1}, fine[3] = {0, 1, 2};
  const struct {
    const int32_t *vertices;
    int64_t vertex_count;
    const int32_t *triangles;
    int64_t triangle_count;
  } bad[] = {{beyond, 3, NULL, 0},
             {below, 3, NULL, 0},
             {fine, 0, NULL, 0},
             {NULL, 0, beyond, 1},
             {fine, 3, below, 1},
             {fine, 2, fine, 1},
             {NULL, 0, fine, 0},
             {fine, INT64_C(1) << 31, NULL, 0},
             {NULL, 0, fine, INT64_C(1) << 31}};
  for (size_t n = 0; n < sizeof bad / sizeof bad[0]; n++) {
    const thrum_surface_def def = {.vertices = bad[n].vertices,
                                   .vertex_count = bad[n].vertex_count,
                                   .triangles = bad[n].triangles,
                                   .triangle_count = bad[n].triangle_count};
    assert_int_equal(thrum_surface_size(&m.model, &def, &size, &error), THRUM_INVALID_ARGUMENT);
  }
  assert_int_equal(size, 77);

  // a block that is too small, misaligned, or for a basis that single precision cannot hold
  assert_int_equal(thrum_surface_size(&m.model, &whole, &size, &error), THRUM_OK);
  unsigned char *memory = aligned_alloc(64, size + 64);
  assert_non_null(memory);
  const thrum_surface *surface = NULL;
  assert_int_equal(thrum_surface_init(memory, size - 1, &m.model, &whole, &surface, &error),
                   THRUM_BUFFER_TOO_SMALL);
  assert_int_equal(thrum_surface_init(memory + 4, size, &m.model, &whole, &surface, &error),
                   THRUM_MISALIGNED);
  m.basis[30] = 1e300;
  assert_int_equal(thrum_surface_init(memory, size, &m.model, &whole, &surface, &error),
                   THRUM_BAD_VALUE);
  assert_null(surface);

  // a good surface refuses bad coordinates, strides, ranges and missing triangles
  m.basis[30] = 1;
  assert_int_equal(thrum_surface_init(memory, size, &m.model, &whole, &surface, &error), THRUM_OK);
  double q[4] = {1, 2, 3, NAN};
  float out[60];
  for (int n = 0; n < 60; n++)
    out[n] = -7.0f;

  // coordinates that are not finite, also in single precision
  const thrum_surface_output rest = THRUM_SURFACE_POSITIONS;
  assert_int_equal(thrum_surface_positions(surface, rest, q, 0, 20, out, 3, &error),
                   THRUM_BAD_VALUE);
  q[3] = 1e60;
  assert_int_equal(thrum_surface_positions(surface, rest, q, 0, 20, out, 3, &error),
                   THRUM_BAD_VALUE);

  // a stride below 3, ranges outside the surface, and normals without triangles
  q[3] = 0;
  assert_int_equal(thrum_surface_positions(surface, rest, q, 0, 20, out, 2, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_positions(surface, rest, q, 1, 20, out, 3, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_positions(surface, rest, q, -1, 2, out, 3, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_positions(NULL, rest, q, 0, 1, out, 3, &error),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_surface_normals(surface, out, 3, out, 3, &error), THRUM_MISSING);

  // a refusal writes nothing
  for (int n = 0; n < 60; n++)
    assert_true(out[n] == -7.0f);
  free(memory);
  random_model_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(displacements_are_those_of_the_model_to_single_rounding),
      cmocka_unit_test(every_kernel_gives_the_bits_of_plain_c),
      cmocka_unit_test(chosen_vertices_come_in_their_order_and_nothing_else_is_written),
      cmocka_unit_test(a_sphere_has_radial_normals_and_a_lone_vertex_none),
      cmocka_unit_test(missing_arguments_of_a_surface_are_refused),
      cmocka_unit_test(vertices_outside_the_mesh_are_refused_and_nothing_is_written),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
