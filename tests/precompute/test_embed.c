/* Embedded surfaces: the theorems of the binding (affine maps are carried along exactly, weights
 * sum to one, a vertex of the mesh has its own rows, the nearest tetrahedron is the nearest), the
 * file, and what the runtime shows of it. SPDX-License-Identifier: Apache-2.0 */
#include <unistd.h>

#include "core/base/quadratic_tet.h"
#include "io/file.h"
#include "io/npz.h"
#include "mesh/formats/surface_read.h"
#include "mesh/tet_distance.h"
#include "mesh/tet_tree.h"
#include "precompute/embed.h"
#include "tests/support/precompute_support.h"

#define BEAM "beam:6x3x2@1x0.4x0.3"

static char folder[] = "/tmp/thrum-embed-XXXXXX";

static int make_folder(void **state) {
  (void)state;
  return mkdtemp(folder) == NULL || chdir(folder) != 0;
}

static int remove_folder(void **state) {
  (void)state;
  char command[64];
  snprintf(command, sizeof command, "rm -r %s", folder);
  return chdir("/") != 0 || system(command) != 0;
}

/* `count` points around the middle of the beam, within `size` of it along each axis. */
static thrum_surface_mesh cloud(int64_t count, double size) {
  thrum_surface_mesh made = {.vertex_count = count, .triangle_count = count - 2};
  made.vertices = need((size_t)count * 3, sizeof *made.vertices);
  made.triangles = need((size_t)made.triangle_count * 3, sizeof *made.triangles);
  for (int64_t n = 0; n < count; n++) {
    made.vertices[3 * n] = 0.5 + size * random_number();
    made.vertices[3 * n + 1] = size * random_number();
    made.vertices[3 * n + 2] = size * random_number();
  }
  for (int64_t t = 0; t < made.triangle_count; t++)
    for (int32_t c = 0; c < 3; c++)
      made.triangles[3 * t + c] = (int32_t)t + c;
  return made;
}

static thrum_embed embed(const thrum_model *model, const thrum_surface_mesh *surface) {
  thrum_embed made = {0};
  thrum_error error = {0};
  if (thrum_embed_make(model, surface, "{\"a\":1}", NULL, &made, &error) < 0)
    fail_msg("%s", error.message);
  return made;
}

/* The affine map A x + b of all points. */
static void map(const double *points, int64_t count, double *mapped) {
  static const double a[3][3] = {{0.3, -1.2, 0.5}, {2, 0.1, -0.7}, {-0.4, 0.9, 1.6}};
  static const double b[3] = {7, -3, 11};
  for (int64_t n = 0; n < count; n++)
    for (int i = 0; i < 3; i++) {
      double sum = b[i];
      for (int j = 0; j < 3; j++)
        sum += a[i][j] * points[3 * n + j];
      mapped[3 * n + i] = sum;
    }
}

/* The weights reproduce every affine map A, inside the mesh and far outside of it:
 * sum w_c A(X_c) = A(x), and sum w_c = 1. */
static void an_affine_map_of_the_mesh_carries_the_surface_along(void **state) {
  (void)state;
  body b = body_make(BEAM, "x<0.001");
  thrum_precomputed model = body_precompute(&b, 4, 6);

  // clouds reach from points inside the beam to points many lengths away
  for (double size = 0.1; size < 20; size *= 12) {
    thrum_surface_mesh surface = cloud(2000, size);
    thrum_embed made = embed(&model.model, &surface);
    double *moved = need(3 * (size_t)b.mesh.vertex_count, sizeof *moved);
    double *wanted = need(3 * 2000, sizeof *wanted);
    map(b.mesh.vertices, b.mesh.vertex_count, moved);
    map(surface.vertices, 2000, wanted);

    // every vertex lies where its weights put it
    for (int64_t v = 0; v < 2000; v++) {
      const double *w = made.embedding.weights + 4 * v;
      const int32_t *corners = b.mesh.tets + 4 * (int64_t)made.embedding.tet[v];

      // rounding grows with the size of the weights
      const double grown = 1 + fabs(w[0]) + fabs(w[1]) + fabs(w[2]) + fabs(w[3]);
      assert_true(fabs(w[0] + w[1] + w[2] + w[3] - 1) < 1e-15 * grown);
      for (int axis = 0; axis < 3; axis++) {
        double sum = 0;
        for (int c = 0; c < 4; c++)
          sum += w[c] * moved[3 * (int64_t)corners[c] + axis];
        assert_true(fabs(sum - wanted[3 * v + axis]) < 3e-14 * grown);
      }
    }

    free(moved);
    free(wanted);
    thrum_embed_free(&made);
    thrum_surface_mesh_free(&surface);
  }

  thrum_precomputed_free(&model);
  body_free(&b);
}

/* Where edges are curved, sum N_a(l) X_a is the vertex itself, so affine maps are carried along, no
 * vertex inside an element counts as outside, and middle nodes have their own rows. */
static void curved_elements_place_a_surface_by_their_shape_functions(void **state) {
  (void)state;
  body b = body_quadratic(BEAM, "x<0.001", 0.01, 0.01);
  thrum_precomputed model = body_precompute(&b, 4, 6);
  thrum_surface_mesh surface = cloud(3000, 0.1);
  memcpy(surface.vertices, b.mesh.vertices, 3 * (size_t)b.mesh.vertex_count * sizeof(double));

  // the nodes first, then points in elements that are drawn
  for (int64_t v = b.mesh.vertex_count; v < 3000; v++) {
    const int64_t t = v * 7 % b.mesh.tet_count;
    double l[4] = {0.05, 0.1 + 0.2 * fabs(random_number()), 0.1 + 0.3 * fabs(random_number()), 0};
    double shape[10];
    int32_t node[10];
    l[3] = 1 - l[0] - l[1] - l[2];
    thrum_quadratic_shape(l, shape);
    thrum_mesh_nodes(&b.mesh, t, node);
    for (int axis = 0; axis < 3; axis++) {
      surface.vertices[3 * v + axis] = 0;
      for (int a = 0; a < 10; a++)
        surface.vertices[3 * v + axis] += shape[a] * b.mesh.vertices[3 * (int64_t)node[a] + axis];
    }
  }

  thrum_embed made = embed(&model.model, &surface);
  assert_int_equal(made.report.outside, 0);
  for (int64_t v = 0; v < 3000; v++) {
    double shape[10];
    int32_t node[10];
    thrum_quadratic_shape(made.embedding.weights + 4 * v, shape);
    thrum_mesh_nodes(&b.mesh, made.embedding.tet[v], node);
    for (int axis = 0; axis < 3; axis++) {
      double sum = 0;
      for (int a = 0; a < 10; a++)
        sum += shape[a] * b.mesh.vertices[3 * (int64_t)node[a] + axis];
      assert_true(fabs(sum - surface.vertices[3 * v + axis]) < 1e-14);
    }
    for (int64_t i = 0; i < 18 && v < b.mesh.vertex_count; i++)
      assert_true(fabs((double)made.embedding.basis[18 * v + i] - model.model.basis[18 * v + i]) <
                  1e-6 * (1 + fabs(model.model.basis[18 * v + i])));
  }

  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

/* The tree's answer is compared with a search through all tetrahedra; all weights are
 * non-negative exactly where the distance is 0. */
static void the_tetrahedron_found_is_the_nearest(void **state) {
  (void)state;
  body b = body_make(BEAM, NULL);
  thrum_tet_tree *tree = NULL;
  assert_int_equal(thrum_tet_tree_make(b.mesh.vertices, b.mesh.tets, b.mesh.tet_count, &tree, NULL),
                   THRUM_OK);

  // points inside the beam and around it
  static const int faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  int64_t inside = 0;
  for (int n = 0; n < 3000; n++) {
    const double point[3] = {0.5 + 0.8 * random_number(), 0.4 * random_number(),
                             0.4 * random_number()};
    const thrum_tet_place place = thrum_tet_tree_find(tree, point);

    // the search through all tetrahedra, which the tree has to reproduce
    double least = INFINITY;
    for (int64_t t = 0; t < b.mesh.tet_count; t++) {
      const double *corners[4];
      double w[4];
      for (int c = 0; c < 4; c++)
        corners[c] = b.mesh.vertices + 3 * (int64_t)b.mesh.tets[4 * t + c];
      thrum_tet_weights(corners, point, w);
      double distance = INFINITY;
      for (int f = 0; f < 4; f++)
        distance =
            fmin(distance, thrum_triangle_distance2(corners[faces[f][0]], corners[faces[f][1]],
                                                    corners[faces[f][2]], point));
      least = fmin(least, w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && w[3] >= 0 ? 0 : sqrt(distance));
    }
    assert_true(fabs(place.distance - least) < 1e-12);

    // the beam is a box, so the distance to it is known in closed form too
    double off = 0;
    static const double low[3] = {0, -0.2, -0.15}, high[3] = {1, 0.2, 0.15};
    for (int axis = 0; axis < 3; axis++) {
      const double over = fmax(fmax(low[axis] - point[axis], point[axis] - high[axis]), 0);
      off += over * over;
    }
    assert_true(fabs(place.distance - sqrt(off)) < 1e-12);
    inside += off <= 0;
  }

  // the sample has points on both sides of the surface
  assert_in_range(inside, 300, 2700);

  thrum_tet_tree_free(tree);
  body_free(&b);
}

/* The surface was modelled by hand over the tetrahedra of a real bridge: all of it is found near
 * them, and each vertex is reproduced by its weights. */
static void a_real_surface_lies_about_its_mesh(void **state) {
  (void)state;
  char path[2][512];
  snprintf(path[0], sizeof path[0], "%s/simpleBridge.veg", THRUM_DATA);
  snprintf(path[1], sizeof path[1], "%s/simpleBridge.obj", THRUM_DATA);
  if (!*THRUM_DATA || access(path[0], R_OK) != 0 || access(path[1], R_OK) != 0)
    skip();
  body b = body_make(path[0], NULL);
  thrum_surface_mesh surface = {0};
  thrum_tet_tree *tree = NULL;
  assert_int_equal(thrum_surface_mesh_read(path[1], 1, &surface, NULL), THRUM_OK);
  assert_int_equal(thrum_tet_tree_make(b.mesh.vertices, b.mesh.tets, b.mesh.tet_count, &tree, NULL),
                   THRUM_OK);

  // no vertex is far from the mesh, and its weights reproduce its position exactly
  int64_t outside = 0;
  for (int64_t v = 0; v < surface.vertex_count; v++) {
    const thrum_tet_place place = thrum_tet_tree_find(tree, surface.vertices + 3 * v);
    outside += place.distance > 1e-6;
    assert_true(place.distance < 0.0025 * 20.3);
    for (int axis = 0; axis < 3; axis++) {
      double sum = 0;
      for (int c = 0; c < 4; c++)
        sum += place.weights[c] *
               b.mesh.vertices[3 * (int64_t)b.mesh.tets[4 * (int64_t)place.tet + c] + axis];
      assert_true(fabs(sum - surface.vertices[3 * v + axis]) < 1e-13);
    }
  }

  // only a few vertices lie outside, but some do
  assert_in_range(outside, 1, surface.vertex_count / 100);

  thrum_tet_tree_free(tree);
  thrum_surface_mesh_free(&surface);
  body_free(&b);
}

/* The distance to a triangle is compared with the least over a fine grid of its points. */
static void the_distance_to_a_triangle_is_the_least(void **state) {
  (void)state;
  enum { GRID = 60 };
  for (int n = 0; n < 200; n++) {
    // a random triangle and a random point near it
    double corners[3][3], point[3], least = INFINITY, side = 0;
    for (int c = 0; c < 3; c++)
      for (int axis = 0; axis < 3; axis++)
        corners[c][axis] = random_number();
    for (int axis = 0; axis < 3; axis++)
      point[axis] = 2 * random_number();

    // the least distance over the grid, an upper bound of the true one
    for (int i = 0; i <= GRID; i++)
      for (int j = 0; j <= GRID - i; j++) {
        double sum = 0;
        for (int axis = 0; axis < 3; axis++) {
          const double off =
              (corners[0][axis] * i + corners[1][axis] * j + corners[2][axis] * (GRID - i - j)) /
                  GRID -
              point[axis];
          sum += off * off;
        }
        least = fmin(least, sqrt(sum));
      }

    // the grid's spacing bounds how far the grid can be off
    for (int c = 0; c < 3; c++) {
      double sum = 0;
      for (int axis = 0; axis < 3; axis++)
        sum += pow(corners[c][axis] - corners[(c + 1) % 3][axis], 2);
      side = fmax(side, sqrt(sum));
    }
    const double found = sqrt(thrum_triangle_distance2(corners[0], corners[1], corners[2], point));
    assert_true(found <= least + 1e-12);
    assert_true(least - found <= side / GRID);
  }
}

static void a_vertex_of_the_mesh_has_just_its_own_rows(void **state) {
  (void)state;
  body b = body_make(BEAM, "x<0.001");
  thrum_precomputed model = body_precompute(&b, 4, 6);

  // the surface's vertices are the mesh's own
  thrum_surface_mesh surface = cloud(b.mesh.vertex_count, 1);
  memcpy(surface.vertices, b.mesh.vertices, 3 * (size_t)b.mesh.vertex_count * sizeof(double));
  thrum_embed made = embed(&model.model, &surface);
  assert_int_equal(made.report.outside, 0);
  assert_true(made.report.weight_max <= 1);

  // the row of each is the model's row, rounded to single precision
  for (int64_t n = 0; n < 3 * b.mesh.vertex_count * model.model.rank; n++) {
    const float own = (float)model.model.basis[n];
    assert_memory_equal(&made.embedding.basis[n], &own, sizeof own);
  }

  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

static void vertices_outside_the_mesh_are_counted_and_their_distance_measured(void **state) {
  (void)state;
  body b = body_make(BEAM, "x<0.001");
  thrum_precomputed model = body_precompute(&b, 4, 6);

  // two points outside of the mesh, one of them far
  thrum_surface_mesh surface = cloud(4, 1);
  static const double points[12] = {0.5, 0.1, 0.1, 1.75, 0, 0, 0.5, 0.2, 0.15, 0.3, -0.25, 0};
  memcpy(surface.vertices, points, sizeof points);

  // the report counts them and names the farthest
  thrum_embed made = embed(&model.model, &surface);
  assert_int_equal(made.report.outside, 2);
  assert_int_equal(made.report.farthest, 1);
  assert_true(fabs(made.report.distance_max - 0.75) < 1e-14);
  assert_true(made.report.extent == 1);
  assert_true(made.report.weight_max > 1);
  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);

  // a model without its basis has no rows to give
  thrum_model lean = model.model;
  lean.basis = NULL;
  surface = cloud(4, 1);
  assert_int_equal(thrum_embed_make(&lean, &surface, NULL, NULL, &made, NULL), THRUM_MISSING);

  // a position too large to compute with is refused by its number
  surface.vertices[4] = 1e200;
  thrum_error error = {0};
  assert_int_equal(thrum_embed_make(&model.model, &surface, NULL, NULL, &made, &error),
                   THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "vertex 2 of the surface is too far"));

  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

/* The positions are X + W q and the normals those of a direct computation; both are interleaved in
 * one buffer. */
static void check_shown(const thrum_surface *surface, const thrum_embedding *e) {
  double q[16] = {0};
  for (int64_t i = 0; i < e->rank; i++)
    q[i] = 0.1 * random_number();

  // positions and normals share a buffer of eight numbers per vertex
  float *out = need((size_t)e->vertex_count * 8, sizeof *out);
  double *x = need((size_t)e->vertex_count * 3, sizeof *x);
  double *normals = need((size_t)e->vertex_count * 3, sizeof *normals);
  thrum_error error = {0};
  if (thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0, e->vertex_count, out, 8,
                              &error) != THRUM_OK ||
      thrum_surface_normals(surface, out, 8, out + 3, 8, &error) != THRUM_OK)
    fail_msg("%s", error.message);

  // the positions in double precision, from the definition
  for (int64_t n = 0; n < 3 * e->vertex_count; n++) {
    x[n] = e->positions[n];
    for (int64_t i = 0; i < e->rank; i++)
      x[n] += (double)e->basis[n * e->rank + i] * q[i];
    assert_true(fabs((double)out[n / 3 * 8 + n % 3] - x[n]) < 1e-5);
  }

  // area-weighted face normals summed at the corners
  for (int64_t t = 0; t < e->triangle_count; t++) {
    const int32_t *c = e->triangles + 3 * t;
    double f[2][3];
    for (int axis = 0; axis < 3; axis++) {
      f[0][axis] = x[3 * c[1] + axis] - x[3 * c[0] + axis];
      f[1][axis] = x[3 * c[2] + axis] - x[3 * c[0] + axis];
    }
    for (int corner = 0; corner < 3; corner++)
      for (int axis = 0; axis < 3; axis++)
        normals[3 * c[corner] + axis] += f[0][(axis + 1) % 3] * f[1][(axis + 2) % 3] -
                                         f[0][(axis + 2) % 3] * f[1][(axis + 1) % 3];
  }

  // the directions agree, and the buffer's two spare numbers stay untouched
  for (int64_t v = 0; v < e->vertex_count; v++) {
    const double *n = normals + 3 * v, size = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int axis = 0; axis < 3; axis++)
      assert_true(fabs((double)out[8 * v + 3 + axis] - n[axis] / size) < 1e-4);
    assert_true(out[8 * v + 6] == 0 && out[8 * v + 7] == 0);
  }

  free(out);
  free(x);
  free(normals);
}

static void the_file_comes_back_and_is_shown(void **state) {
  (void)state;
  body b = body_make(BEAM, "x<0.001");
  thrum_precomputed model = body_precompute(&b, 4, 6);
  thrum_surface_mesh surface = cloud(333, 0.2);
  thrum_embed made = embed(&model.model, &surface);
  thrum_error error = {0};
  if (thrum_embed_save("s.npz", &made.embedding, &error) < 0)
    fail_msg("%s", error.message);

  // every array and the metadata come back to the bit
  const thrum_embedding *e = NULL;
  if (thrum_embedding_load("s.npz", &e, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(e->vertex_count, 333);
  assert_int_equal(e->meta_bytes, 7);
  assert_memory_equal(e->meta, "{\"a\":1}", 7);
  const struct {
    const void *back, *given;
    int64_t size;
  } arrays[] = {{e->omega2, model.model.omega2, 8 * model.model.rank},
                {e->positions, surface.vertices, 8 * 3 * 333},
                {e->triangles, surface.triangles, 4 * 3 * 331},
                {e->basis, made.embedding.basis, 4 * 3 * 333 * model.model.rank},
                {e->tet, made.embedding.tet, 4 * 333},
                {e->weights, made.embedding.weights, 8 * 4 * 333}};
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++)
    assert_memory_equal(arrays[n].back, arrays[n].given, (size_t)arrays[n].size);

  // a game's model may lack its mesh and its basis: the surface is shown from its own rows
  thrum_model lean = {.rank = model.model.rank, .omega2 = model.model.omega2};
  const thrum_surface *shown = NULL;
  if (thrum_surface_load("s.npz", &lean, &shown, &error) < 0)
    fail_msg("%s", error.message);
  assert_int_equal(thrum_surface_vertex_count(shown), 333);
  assert_int_equal(thrum_surface_triangle_count(shown), 331);
  check_shown(shown, e);
  thrum_surface_destroy(shown);

  // a truncated model has fewer coordinates and still fits; one of other frequencies does not
  lean.rank = 2;
  assert_int_equal(thrum_surface_load("s.npz", &lean, &shown, &error), THRUM_OK);
  thrum_surface_destroy(shown);
  const double other[2] = {1, 2};
  lean.omega2 = other;
  shown = NULL;
  assert_int_equal(thrum_surface_load("s.npz", &lean, &shown, &error), THRUM_BAD_VALUE);
  assert_non_null(strstr(error.message, "s.npz: the surface is embedded in another model"));
  assert_null(shown);

  thrum_embedding_destroy(e);
  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

static void python(const char *script) {
  assert_int_equal(thrum_file_write_atomic("script.py", script, strlen(script), NULL), THRUM_OK);
  if (system("/usr/bin/python3 -W error script.py") != 0)
    fail_msg("the script failed (does /usr/bin/python3 have numpy?)");
}

/* NumPy recomputes the rows from the model's file and the weights and writes the file again; a
 * damaged file is refused with the reason. */
static void numpy_makes_the_same_rows_and_the_same_file(void **state) {
  (void)state;
  body b = body_make(BEAM, "x<0.001");
  thrum_precomputed model = body_precompute(&b, 4, 6);
  thrum_surface_mesh surface = cloud(50, 0.3);
  thrum_embed made = embed(&model.model, &surface);
  thrum_error error = {0};
  assert_int_equal(thrum_model_save("m.npz", &model.model, &error), THRUM_OK);
  assert_int_equal(thrum_embed_save("n.npz", &made.embedding, &error), THRUM_OK);

  // the script checks the rows, copies the file and writes damaged variants of it
  python("import numpy as np\n"
         "m, s = np.load('m.npz'), dict(np.load('n.npz'))\n"
         "corners = m['tets'][s['tet']]\n"
         "W = np.einsum('vc,vcai->vai', s['weights'], m['basis'].reshape(-1, 3, 6)[corners])\n"
         "assert s['basis'].dtype == np.float32 and s['basis'].shape == (150, 6)\n"
         "assert np.abs(W.reshape(150, 6) - s['basis']).max() <= 1e-7 * np.abs(W).max()\n"
         "X = np.einsum('vc,vca->va', s['weights'], m['vertices'][corners])\n"
         "assert np.abs(X - s['positions']).max() < 1e-14\n"
         "assert (s['omega2'] == m['omega2']).all() and list(s['surface_format']) == [1, 0]\n"
         "np.savez('again.npz', **s)\n"
         "def spoil(name, **arrays): np.savez(name, **{k: v for k, v in {**s, **arrays}.items()"
         " if v is not None})\n"
         "bad = s['triangles'].copy(); bad[7, 1] = 50\n"
         "spoil('1.npz', triangles=bad)\n"
         "bad = s['basis'].copy(); bad[1, 0] = np.nan\n"
         "spoil('2.npz', basis=bad)\n"
         "spoil('3.npz', basis=s['basis'].astype('f8'))\n"
         "spoil('4.npz', weights=s['weights'][1:])\n"
         "spoil('5.npz', tet=None)\n"
         "spoil('6.npz', surface_format=np.array([2, 0], '<i4'))\n"
         "spoil('7.npz', surface_format=None)\n"
         "spoil('8.npz', tet=-s['tet'] - 1)\n"
         "spoil('9.npz', future=np.zeros(3))\n");

  // each damaged file is refused, and the message names the array and the entry
  const thrum_embedding *e = NULL;
  static const struct {
    const char *path, *words;
  } cases[] = {{"1.npz", "entry 22 of array 'triangles' is 50, which is outside 0..49"},
               {"2.npz", "entry 6 of array 'basis' is nan"},
               {"3.npz", "array 'basis'"},
               {"4.npz", "array 'weights' has shape (49, 4), (vertex_count, 4) is needed"},
               {"5.npz", "array 'tet' is missing"},
               {"6.npz", "says version 2.0, this program reads version 1"},
               {"7.npz", "array 'surface_format' is missing"},
               {"8.npz", "entry 0 of array 'tet' is -"},
               {"m.npz", "array 'surface_format' is missing: is it a file of `thrum embed`?"},
               {"script.py", "script.py: not a"},
               {"none.npz", "none.npz: "},
               {"", "the name of the surface file is empty"}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    assert_true(thrum_embedding_load(cases[n].path, &e, &error) < 0);
    if (strstr(error.message, cases[n].words) == NULL)
      fail_msg("wanted '%s', got '%s'", cases[n].words, error.message);
    assert_null(e);
  }

  // NumPy's own copy is read, and so is a file with an array of a later version
  static const char *const good[] = {"again.npz", "9.npz"};
  for (int n = 0; n < 2; n++) {
    if (thrum_embedding_load(good[n], &e, &error) < 0)
      fail_msg("%s", error.message);
    assert_memory_equal(e->basis, made.embedding.basis, 4 * 150 * 6);
    thrum_embedding_destroy(e);
    e = NULL;
  }

  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

/* The bytes are read in place, as a program would have them linked in; every truncation is
 * refused. */
static void bytes_are_viewed_in_place(void **state) {
  (void)state;
  body b = body_make("beam:2x1x1@1x1x1", "x<0.001");
  thrum_precomputed model = body_precompute(&b, 2, 3);
  thrum_surface_mesh surface = cloud(5, 0.3);
  thrum_embed made = embed(&model.model, &surface);
  thrum_error error = {0};
  assert_int_equal(thrum_embed_save("v.npz", &made.embedding, &error), THRUM_OK);
  void *data = NULL;
  size_t size = 0;
  assert_int_equal(thrum_file_read("v.npz", &data, &size, &error), THRUM_OK);

  // a view demands alignment, which the file's own buffer need not have
  unsigned char *aligned = aligned_alloc(64, (size + 127) / 64 * 64);
  assert_non_null(aligned);
  memcpy(aligned, data, size);

  // no prefix of the file is accepted, and a refusal leaves the view as it was
  thrum_embedding e = {.rank = 77};
  for (size_t cut = 0; cut < size; cut++)
    assert_true(thrum_embedding_view(aligned, cut, &e, NULL) < 0);
  assert_int_equal(e.rank, 77);

  // the whole is accepted, and the arrays point into the given bytes
  assert_int_equal(thrum_embedding_view(aligned, size, &e, &error), THRUM_OK);
  assert_true((const unsigned char *)e.basis > aligned &&
              (const unsigned char *)e.basis < aligned + size);
  assert_memory_equal(e.basis, made.embedding.basis, 4 * 15 * 3);

  // the same arrays as a surface's definition; each wrong member is refused
  const thrum_surface_def def = thrum_embedding_surface(&e);
  size_t needed = 0;
  assert_int_equal(thrum_surface_size(&model.model, &def, &needed, &error), THRUM_OK);
  thrum_surface_def bad = def;
  bad.row_rank = 2;
  assert_int_equal(thrum_surface_size(&model.model, &bad, &needed, &error), THRUM_INVALID_ARGUMENT);
  bad = def;
  bad.vertices = def.triangles;
  assert_int_equal(thrum_surface_size(&model.model, &bad, &needed, &error), THRUM_INVALID_ARGUMENT);
  bad = def;
  bad.rows = NULL;
  assert_int_equal(thrum_surface_size(&model.model, &bad, &needed, &error), THRUM_INVALID_ARGUMENT);

  // bytes off their alignment are refused
  memmove(aligned + 1, aligned, size);
  assert_int_equal(thrum_embedding_view(aligned + 1, size, &e, &error), THRUM_MISALIGNED);

  free(aligned);
  free(data);
  thrum_embed_free(&made);
  thrum_surface_mesh_free(&surface);
  thrum_precomputed_free(&model);
  body_free(&b);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_affine_map_of_the_mesh_carries_the_surface_along),
      cmocka_unit_test(curved_elements_place_a_surface_by_their_shape_functions),
      cmocka_unit_test(the_tetrahedron_found_is_the_nearest),
      cmocka_unit_test(a_real_surface_lies_about_its_mesh),
      cmocka_unit_test(the_distance_to_a_triangle_is_the_least),
      cmocka_unit_test(a_vertex_of_the_mesh_has_just_its_own_rows),
      cmocka_unit_test(vertices_outside_the_mesh_are_counted_and_their_distance_measured),
      cmocka_unit_test(the_file_comes_back_and_is_shown),
      cmocka_unit_test(numpy_makes_the_same_rows_and_the_same_file),
      cmocka_unit_test(bytes_are_viewed_in_place),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
