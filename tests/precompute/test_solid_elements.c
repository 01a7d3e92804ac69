/* Hexahedra, wedges and solid-shells: the shape functions, the patch test on distorted meshes, and
 * that energy, forces, stiffness, derivatives and the reduced polynomial are those of one quartic.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/monomials.h"
#include "tests/support/precompute_support.h"

#include "core/base/vec3.h"
#include "mesh/divide_shells.h"
#include "mesh/mesh_shells.h"
#include "precompute/basis/order_find.h"
#include "precompute/fem/fem_solids.h"
#include "precompute/fem/refine_solids.h"
#include "precompute/fem/solid_stress.h"
#include "precompute/model/solid_inertia.h"
#include "precompute/model/traction.h"
#include "thrum/polynomial.h"

static void assert_within(double value, double expected, double tolerance) {
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.17g is not %.17g within %g", value, expected, tolerance);
}

/* A box of nx x ny x 1 boxes of 1 x 1 x `height`, each an element or two of a form; inner and outer
 * nodes are moved by up to `shift`, of solid-shells along the middle surface alone. */
enum { CELLS_MAX = 10, LINES_MAX = 2 * CELLS_MAX + 1 };

typedef struct grid {
  thrum_mesh mesh;
  int64_t ends;
} grid;

static int32_t place_node(grid *g, int32_t *index, const int at[3], double height) {
  int32_t *node = &index[(at[2] * LINES_MAX + at[1]) * LINES_MAX + at[0]];
  if (*node >= 0)
    return *node;
  *node = (int32_t)g->mesh.vertex_count++;
  double *place = g->mesh.vertices + 3 * (int64_t)*node;
  place[0] = at[0] / 2.0;
  place[1] = at[1] / 2.0;
  place[2] = height * at[2] / 2.0;
  return *node;
}

/* One element of corners on the grid; middle nodes where the form has them. */
static void place_element(grid *g, int32_t *index, thrum_solid_form form, int (*corners)[3],
                          double height) {
  const thrum_solid_form_shape *of = &thrum_solid_forms[form];
  const thrum_solid_topology *shape = &thrum_solid_shapes[of->kind];
  int64_t numbers[THRUM_SOLID_NODES_MAX];
  int tets[THRUM_SOLID_MIDDLE_TETS_MAX][4];
  int32_t *nodes = g->mesh.solid_nodes + g->ends;
  for (int n = 0; n < of->nodes; n++) {
    int at[3];
    for (int d = 0; d < 3; d++) {
      const int *edge = n < shape->corners ? NULL : shape->edge[n - shape->corners];
      at[d] = edge ? (corners[edge[0]][d] + corners[edge[1]][d]) / 2 : corners[n][d];
    }
    numbers[n] = nodes[n] = place_node(g, index, at, height);
  }

  // its tets are its shape
  const int count = of->nodes > shape->corners ? thrum_solid_cut_middles(of->kind, numbers, tets)
                                               : thrum_solid_cut(of->kind, numbers, tets);
  for (int t = 0; t < count; t++)
    for (int c = 0; c < 4; c++)
      g->mesh.tets[4 * (g->mesh.tet_count + t) + c] = nodes[tets[t][c]];
  g->mesh.tet_count += count;
  g->ends += of->nodes;
  g->mesh.solid_form[g->mesh.solid_count] = (uint8_t)form;
  g->mesh.solid_ends[g->mesh.solid_count] = (int32_t)g->ends;
  g->mesh.solid_tet_ends[g->mesh.solid_count++] = (int32_t)g->mesh.tet_count;
}

static body grid_make(thrum_solid_form form, int nx, int ny, double height, double shift) {
  const int room = 2 * nx * ny;
  grid g = {0};
  int32_t index[3 * LINES_MAX * LINES_MAX];
  memset(index, -1, sizeof index);
  g.mesh.vertices = need(3 * sizeof index / sizeof *index, sizeof(double));
  g.mesh.tets = need((size_t)room * THRUM_SOLID_MIDDLE_TETS_MAX * 4, sizeof(int32_t));
  g.mesh.solid_form = need((size_t)room, 1);
  g.mesh.solid_ends = need((size_t)room, sizeof(int32_t));
  g.mesh.solid_tet_ends = need((size_t)room, sizeof(int32_t));
  g.mesh.solid_nodes = need((size_t)room * THRUM_SOLID_NODES_MAX, sizeof(int32_t));
  const bool wedges = thrum_solid_forms[form].kind == THRUM_SOLID_WEDGE;
  for (int i = 0; i < 2 * nx; i += 2)
    for (int j = 0; j < 2 * ny; j += 2) {
      int box[8][3], wedge[2][6][3];
      static const int side[8][3] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0},
                                     {0, 0, 2}, {2, 0, 2}, {2, 2, 2}, {0, 2, 2}};
      static const int of_wedge[2][6] = {{0, 1, 2, 4, 5, 6}, {0, 2, 3, 4, 6, 7}};
      for (int c = 0; c < 24; c++)
        box[c / 3][c % 3] = side[c / 3][c % 3] + (c % 3 == 0 ? i : c % 3 == 1 ? j : 0);
      for (int w = 0; w < 2; w++)
        for (int c = 0; c < 6; c++)
          memcpy(wedge[w][c], box[of_wedge[w][c]], sizeof wedge[w][c]);
      for (int w = 0; wedges && w < 2; w++)
        place_element(&g, index, form, wedge[w], height);
      if (!wedges)
        place_element(&g, index, form, box, height);
    }

  // upright edges of a solid-shell stay upright
  const bool shell = form == THRUM_FORM_SHELL6 || form == THRUM_FORM_SHELL8;
  for (int64_t v = 0; v < g.mesh.vertex_count; v++) {
    double *x = g.mesh.vertices + 3 * v;
    const double moved[2] = {sin(3 * x[0] + 5 * x[1]), cos(4 * x[0] + 7 * x[1])};
    for (int d = 0; d < (shell ? 2 : 3); d++)
      x[d] += shift * (shell ? moved[d] : random_number());
  }

  g.mesh.tet_region = need((size_t)g.mesh.tet_count, sizeof(int32_t));
  g.mesh.region_count = 1;
  g.mesh.materials = need(1, sizeof *g.mesh.materials);
  g.mesh.materials[0] = (thrum_material){1e3, 0.3, 2};
  g.mesh.has_material = true;
  return (body){g.mesh, need((size_t)g.mesh.vertex_count, 1)};
}

static const thrum_solid_form forms[] = {THRUM_FORM_WEDGE6, THRUM_FORM_WEDGE15, THRUM_FORM_HEX8,
                                         THRUM_FORM_HEX20,  THRUM_FORM_SHELL6,  THRUM_FORM_SHELL8};
enum { FORMS = sizeof forms / sizeof *forms };

static bool is_shell(thrum_solid_form form) {
  return form == THRUM_FORM_SHELL6 || form == THRUM_FORM_SHELL8;
}

static body distorted(thrum_solid_form form) {
  return grid_make(form, 3, 2, is_shell(form) ? 0.1 : 1, is_shell(form) ? 0.1 : 0.08);
}

static void shape_functions_add_up_to_one_and_are_one_at_their_node(void **state) {
  (void)state;
  for (int form = 0; form < THRUM_FORMS; form++) {
    thrum_solid_table table;
    thrum_solid_table_make((thrum_solid_form)form, &table);
    double volume = 0;
    for (int p = 0; p < table.points; p++) {
      double sum = 0, slope[3] = {0};
      volume += table.weight[p];
      for (int n = 0; n < table.nodes; n++) {
        sum += table.shape[p][n];
        for (int d = 0; d < 3; d++)
          slope[d] += table.slopes[p][n][d];
      }
      assert_within(sum, 1, 1e-14);
      for (int d = 0; d < 3; d++)
        assert_within(slope[d], 0, 1e-14);

      // slopes are those of the functions
      for (int d = 0; d < 3; d++) {
        double up[THRUM_SOLID_NODES_MAX], down[THRUM_SOLID_NODES_MAX], at[2][3];
        for (int side = 0; side < 2; side++)
          for (int c = 0; c < 3; c++)
            at[side][c] = table.place[p][c] + (c == d ? (side ? 1e-6 : -1e-6) : 0);
        thrum_solid_shape_at((thrum_solid_form)form, at[0], down, NULL);
        thrum_solid_shape_at((thrum_solid_form)form, at[1], up, NULL);
        for (int n = 0; n < table.nodes; n++)
          assert_within((up[n] - down[n]) / 2e-6, table.slopes[p][n][d], 1e-8);
      }
    }
    const thrum_solid kind = thrum_solid_forms[form].kind;
    assert_within(volume,
                  kind == THRUM_SOLID_HEXAHEDRON ? 8
                  : kind == THRUM_SOLID_WEDGE    ? 1
                                                 : 1.0 / 6,
                  1e-14);
  }
}

/* Green's strain of a displacement gradient, and its stress P = F S. */
static double respond(const thrum_fem *fem, double g[3][3], double p[3][3]) {
  double e[3][3], s[3][3], energy = 0;
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      e[c][d] = (g[c][d] + g[d][c]) / 2;
      for (int k = 0; k < 3; k++)
        e[c][d] += g[k][c] * g[k][d] / 2;
    }
  thrum_stress(fem->lambda[0], fem->mu[0], e, s);
  for (int c = 0; c < 3; c++)
    for (int d = 0; d < 3; d++) {
      energy += s[c][d] * e[c][d] / 2;
      p[c][d] = s[c][d];
      for (int k = 0; k < 3; k++)
        p[c][d] += g[c][k] * s[k][d];
    }
  return energy;
}

/* Under a uniform displacement gradient, of large strain, every element has the energy of the
 * continuum, and pushes its nodes as the stress of that does: the volume integrals of the gradients
 * of the shape functions times P. Solid-shells do where nothing shears across. */
static void patch_test_passes_on_distorted_meshes(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    body b = distorted(forms[f]);
    thrum_fem fem = body_fem(&b);
    const int64_t all = 3 * fem.vertex_count;
    double g[3][3] = {{0.1, 0.02, 0.03}, {-0.04, 0.05, 0.06}, {0.02, -0.01, -0.03}}, p[3][3];
    double *u = need((size_t)all, sizeof *u), *force = need((size_t)all, sizeof *force);
    double *expected = need((size_t)all, sizeof *expected), volume = 0;
    for (int c = 0; c < 2 && is_shell(forms[f]); c++)
      g[c][2] = g[2][c] = 0;
    const double density = respond(&fem, g, p);
    for (int64_t v = 0; v < fem.vertex_count; v++)
      for (int c = 0; c < 3; c++)
        u[3 * v + c] = thrum_dot3(g[c], fem.vertices + 3 * v);

    for (int64_t s = 0; s < fem.solids.count; s++) {
      volume += fem.solids.volume[s];
      for (int64_t at = fem.solids.point_begin[s]; at < fem.solids.point_begin[s + 1]; at++) {
        double shape[THRUM_SOLID_NODES_MAX][3];
        thrum_solid_gradients(&fem.solids, s, (int)(at - fem.solids.point_begin[s]), shape);
        for (int a = 0; a < thrum_solid_node_count(&fem.solids, s); a++)
          for (int c = 0; c < 3; c++)
            expected[3 * (int64_t)thrum_solid_nodes(&fem.solids, s)[a] + c] +=
                fem.solids.weight[at] * thrum_dot3(p[c], shape[a]);
      }
    }
    assert_within(thrum_fem_energy(&fem, u, force) / (density * volume), 1, 1e-12);
    assert_near(force, expected, all, 1e-11);
    thrum_fem_free(&fem);
    body_free(&b);
    free(u);
    free(force);
    free(expected);
  }
}

/* Under the same strain what pushes on the nodes is the traction P n of the sides of a box alone,
 * whatever elements it is made of and wherever its inner nodes lie. */
static void tractions_on_the_sides_hold_an_even_strain(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    const double size[3] = {2, 2, 0.1};
    body b = grid_make(forms[f], 2, 2, size[2], 0);
    for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
      double *x = b.mesh.vertices + 3 * v, inside = x[0] * x[1] * (2 - x[0]) * (2 - x[1]);
      x[0] += 0.1 * inside;
      x[1] -= 0.07 * inside;
    }
    thrum_fem fem = body_fem(&b);
    const int64_t all = 3 * fem.vertex_count;
    double g[3][3] = {{0.1, 0.02, 0}, {-0.04, 0.05, 0}, {0, 0, -0.03}}, p[3][3];
    double *u = need((size_t)all, sizeof *u), *force = need((size_t)all, sizeof *force);
    double *sides = need((size_t)all, sizeof *sides);
    int32_t *list = need((size_t)fem.vertex_count, sizeof *list);
    respond(&fem, g, p);
    for (int64_t c = 0; c < all; c++)
      u[c] = thrum_dot3(g[c % 3], fem.vertices + c / 3 * 3);
    thrum_fem_energy(&fem, u, force);

    // the six sides
    const double material[3] = {1e3, 0.3, 2};
    thrum_model model = {.vertex_count = fem.vertex_count,
                         .tet_count = b.mesh.tet_count,
                         .solid_count = b.mesh.solid_count,
                         .region_count = 1,
                         .vertices = b.mesh.vertices,
                         .tets = b.mesh.tets,
                         .tet_region = b.mesh.tet_region,
                         .material = material,
                         .solid_form = b.mesh.solid_form,
                         .solid_ends = b.mesh.solid_ends,
                         .solid_nodes = b.mesh.solid_nodes,
                         .solid_tet_ends = b.mesh.solid_tet_ends};
    for (int side = 0; side < 6; side++) {
      const int d = side / 2;
      const double at = side % 2 * size[d], out = side % 2 ? 1 : -1;
      const double traction[3] = {out * p[0][d], out * p[1][d], out * p[2][d]};
      double area = 0;
      int64_t count = 0;
      for (int64_t v = 0; v < fem.vertex_count; v++)
        if (fabs(fem.vertices[3 * v + d] - at) < 1e-9)
          list[count++] = (int32_t)v;
      assert_int_equal(thrum_traction_fill(&model, list, count, traction, sides, &area, NULL), 0);
      assert_within(area, size[(d + 1) % 3] * size[(d + 2) % 3], 1e-13);
    }
    assert_near(sides, force, all, 1e-12);
    thrum_fem_free(&fem);
    body_free(&b);
    free(u);
    free(force);
    free(sides);
    free(list);
  }
}

/* A displacement of this gradient. */
static double *uniform(const thrum_fem *fem, double g[3][3]) {
  double *u = need(3 * (size_t)fem->vertex_count, sizeof *u);
  for (int64_t v = 0; v < fem->vertex_count; v++)
    for (int c = 0; c < 3; c++)
      u[3 * v + c] = thrum_dot3(g[c], fem->vertices + 3 * v);
  return u;
}

/* What shears uniformly across a solid-shell has the energy of the continuum too, and the force on
 * the two nodes through the thickness together is right. How it is shared between the two is not: a
 * plate that shears without load bends, so that this is no state of rest, and the shear that is
 * tied gives its couples to other nodes of the element. */
static void solid_shells_take_uniform_shear_across(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    if (!is_shell(forms[f]))
      continue;
    body b = distorted(forms[f]);
    thrum_fem fem = body_fem(&b);
    double g[3][3] = {{0.1, 0.02, 0.03}, {-0.04, 0.05, 0.06}, {0.02, -0.01, -0.03}}, p[3][3];
    double volume = 0, *u = uniform(&fem, g);
    for (int64_t s = 0; s < fem.solids.count; s++)
      volume += fem.solids.volume[s];
    assert_within(thrum_fem_energy(&fem, u, NULL) / (respond(&fem, g, p) * volume), 1, 1e-12);
    free(u);

    // a small shear alone: across the middle surface the force is its flow through each element
    memset(g, 0, sizeof g);
    g[2][0] = 1e-7;
    g[2][1] = -2e-7;
    double *force = need(3 * (size_t)fem.vertex_count, sizeof *force);
    double *expected = need(3 * (size_t)fem.vertex_count, sizeof *expected);
    u = uniform(&fem, g);
    thrum_fem_energy(&fem, u, force);
    respond(&fem, g, p);
    for (int64_t s = 0; s < fem.solids.count; s++)
      for (int64_t at = fem.solids.point_begin[s]; at < fem.solids.point_begin[s + 1]; at++) {
        double shape[THRUM_SOLID_NODES_MAX][3];
        thrum_solid_gradients(&fem.solids, s, (int)(at - fem.solids.point_begin[s]), shape);
        for (int a = 0; a < thrum_solid_node_count(&fem.solids, s); a++)
          expected[3 * (int64_t)thrum_solid_nodes(&fem.solids, s)[a] + 2] +=
              fem.solids.weight[at] * thrum_dot3(p[2], shape[a]);
      }
    double most = 0, wrong = 0;
    for (int64_t v = 0; v < fem.vertex_count; v++)
      for (int64_t w = v + 1; w < fem.vertex_count; w++) {
        if (fem.vertices[3 * v] != fem.vertices[3 * w] ||
            fem.vertices[3 * v + 1] != fem.vertices[3 * w + 1])
          continue;
        const double pair = expected[3 * v + 2] + expected[3 * w + 2];
        most = fmax(most, fabs(pair));
        wrong = fmax(wrong, fabs(force[3 * v + 2] + force[3 * w + 2] - pair));
      }
    assert_within(wrong / most, 0, 1e-6);
    free(u);
    free(force);
    free(expected);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

/* Stress at the nodes is that of the continuum under a uniform gradient; of the strains that an
 * element has in any motion it has the energy, point by point. */
static void stress_is_that_of_the_strains(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    body b = distorted(forms[f]);
    thrum_fem fem = body_fem(&b);
    thrum_solid_stresses stress = {0};
    double g[3][3] = {{0.1, 0.02, 0.03}, {-0.04, 0.05, 0.06}, {0.02, -0.01, -0.03}}, p[3][3];
    assert_int_equal(thrum_solid_stresses_make(&fem, &stress, NULL), THRUM_OK);
    assert_int_equal(stress.count, fem.vertex_count);
    double *cauchy = need(6 * (size_t)stress.count, sizeof *cauchy), *u = uniform(&fem, g);
    respond(&fem, g, p);

    // sigma = P F^T / J
    double deformed[3][3], cross[3];
    memcpy(deformed, g, sizeof g);
    for (int c = 0; c < 3; c++)
      deformed[c][c] += 1;
    thrum_cross3(deformed[0], deformed[1], cross);
    const double ratio = thrum_dot3(cross, deformed[2]);
    static const int axes[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {0, 2}};
    thrum_solid_stresses_read(&stress, u, cauchy);
    for (int64_t n = 0; n < stress.count; n++)
      for (int c = 0; c < 6; c++)
        assert_within(cauchy[6 * n + c], thrum_dot3(p[axes[c][0]], deformed[axes[c][1]]) / ratio,
                      1e-9);
    free(u);
    free(cauchy);

    // V = 1/2 sum w S : C^-1 S
    u = random_vector(3 * fem.vertex_count, 0.02);
    double energy = 0;
    const double lambda = fem.lambda[0], mu = fem.mu[0];
    for (int64_t s = 0; s < fem.solids.count && thrum_solid_has_rows(&fem.solids, s); s++) {
      const int count = thrum_solid_products(thrum_solid_node_count(&fem.solids, s));
      double products[THRUM_SOLID_PRODUCTS_MAX];
      thrum_fem_solid_products(&fem, s, u, products);
      for (int64_t at = fem.solids.point_begin[s]; at < fem.solids.point_begin[s + 1]; at++) {
        double second[6];
        for (int k = 0; k < 6; k++) {
          const int64_t row = 6 * (at - fem.solids.point_begin[s]) + k;
          second[k] = dot_of(stress.matrix + stress.begin[s] + row * count, products, count);
        }
        const double trace = second[0] + second[1] + second[2];
        double sum = -lambda * trace * trace / (2 * mu * (3 * lambda + 2 * mu));
        for (int k = 0; k < 6; k++)
          sum += second[k] * second[k] * (k < 3 ? 1 : 2) / (2 * mu);
        energy += fem.solids.weight[at] * sum / 2;
      }
    }
    if (thrum_solid_has_rows(&fem.solids, 0))
      assert_within(energy / thrum_fem_energy(&fem, u, NULL), 1, 1e-11);
    free(u);
    thrum_solid_stresses_free(&stress);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

static void force_is_the_slope_of_energy_and_stiffness_that_of_force(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    body b = distorted(forms[f]);
    memset(b.fixed, 7, 2);
    thrum_fem fem = body_fem(&b);
    const int64_t all = 3 * fem.vertex_count, n = fem.free_count;
    thrum_error error = {0};
    thrum_sparse stiffness = {0};
    assert_int_equal(thrum_fem_pattern(&fem, &stiffness, &error), THRUM_OK);

    // differences along a direction about a displaced place
    const double h = 1e-5;
    double *u = random_vector(all, 0.05), *d = random_vector(n, 1);
    double *along = need((size_t)all, sizeof *along), *at = need((size_t)all, sizeof *at);
    double *force[3], *slope = need((size_t)n, sizeof *slope), *kd = need((size_t)n, sizeof *kd);
    double energy[3];
    thrum_fem_scatter(&fem, d, along);
    for (int k = 0; k < 3; k++) {
      force[k] = need((size_t)all, sizeof **force);
      for (int64_t i = 0; i < all; i++)
        at[i] = u[i] + (k - 1) * h * along[i];
      energy[k] = thrum_fem_energy(&fem, at, force[k]);
    }
    const double work = dot_of(force[1], along, all);
    assert_within((energy[2] - energy[0]) / (2 * h) / work, 1, 1e-4);
    assert_int_equal(thrum_fem_stiffness(&fem, u, &stiffness, &error), THRUM_OK);
    thrum_sparse_product(&stiffness, d, 1, kd);
    for (int64_t i = 0; i < n; i++)
      slope[i] = (force[2][fem.component[i]] - force[0][fem.component[i]]) / (2 * h);
    assert_near(slope, kd, n, 1e-5);

    // the force between two places does the work of the change of energy
    double *mean = need((size_t)all, sizeof *mean);
    for (int64_t i = 0; i < all; i++)
      at[i] = 2 * u[i] + along[i] * 0.1;
    thrum_fem_solids_mean_force(&fem, u, at, mean);
    const double change = thrum_fem_energy(&fem, at, NULL) - energy[1];
    for (int64_t i = 0; i < all; i++)
      at[i] -= u[i];
    assert_within(dot_of(mean, at, all) / change, 1, 1e-11);

    for (int k = 0; k < 3; k++)
      free(force[k]);
    free(mean);
    free(u);
    free(d);
    free(along);
    free(at);
    free(slope);
    free(kd);
    thrum_sparse_free(&stiffness);
    thrum_fem_free(&fem);
    body_free(&b);
  }
}

/* V(q) is V_full(U q) to rounding, so the energy of the mesh is a quartic. */
static void reduced_polynomial_is_the_energy_of_the_mesh(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    body b = distorted(forms[f]);
    for (int64_t v = 0; v < b.mesh.vertex_count; v++)
      b.fixed[v] = b.mesh.vertices[3 * v] < 0.25 ? 7 : 0;
    thrum_precomputed result = body_precompute(&b, 4, 8);
    thrum_fem fem = body_fem(&b);
    const int64_t all = 3 * fem.vertex_count;
    double q[8], *u = need((size_t)all, sizeof *u);
    for (int i = 0; i < 8; i++)
      q[i] = 0.3 * random_number();
    for (int64_t c = 0; c < all; c++)
      u[c] = dot_of(result.model.basis + 8 * c, q, 8);
    assert_within(polynomial_of(&result.model, q) / thrum_fem_energy(&fem, u, NULL), 1, 1e-10);
    assert_int_equal(result.model.solid_count, b.mesh.solid_count);
    assert_within(result.mass, 2 * result.volume, 1e-12);
    free(u);
    thrum_fem_free(&fem);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

static double volume_of(const body *b) {
  thrum_fem fem = body_fem(b);
  double volume = 0;
  for (int64_t s = 0; s < fem.solids.count; s++)
    volume += fem.solids.volume[s];
  thrum_fem_free(&fem);
  return volume;
}

/* A refined grid has eight elements for one, solid-shells four, and the same volume; vertices are
 * shared by all elements around them, and held where all that they lie between are. */
static void refined_elements_fill_the_same_body(void **state) {
  (void)state;
  static const int vertices[FORMS] = {
      7 * 5 * 3, 7 * 5 * 3 + 6 * 5 * 3 + 7 * 4 * 3 + 7 * 5 * 2 + 6 * 4 * 3,
      7 * 5 * 3, 7 * 5 * 3 + 6 * 5 * 3 + 7 * 4 * 3 + 7 * 5 * 2,
      7 * 5 * 2, 7 * 5 * 2};
  for (int f = 0; f < FORMS; f++) {
    const bool shell = is_shell(forms[f]);
    body b = grid_make(forms[f], 3, 2, shell ? 0.1 : 1, 0.03), finer = {0};
    for (int64_t v = 0; v < b.mesh.vertex_count; v++)
      b.fixed[v] = b.mesh.vertices[3 * v] < 0.3 ? 7 : b.mesh.vertices[3 * v] < 1.3 ? 1 : 0;
    assert_int_equal(thrum_mesh_refine(&b.mesh, b.fixed, &finer.mesh, &finer.fixed, NULL),
                     THRUM_OK);
    assert_int_equal(finer.mesh.solid_count, (shell ? 4 : 8) * b.mesh.solid_count);
    thrum_refined_size size;
    assert_int_equal(thrum_mesh_refined_size(&b.mesh, &size, NULL), THRUM_OK);
    assert_int_equal(finer.mesh.solid_count, size.elements);
    assert_int_equal(finer.mesh.vertex_count, vertices[f]);
    assert_within(volume_of(&finer) / volume_of(&b), 1, 1e-12);
    for (int64_t v = 0; v < finer.mesh.vertex_count; v++) {
      const double x = finer.mesh.vertices[3 * v];
      assert_int_equal(finer.fixed[v], x < 0.2 ? 7 : x < 1.2 ? 1 : 0);
    }
    body_free(&finer);
    body_free(&b);
  }
}

/* A box has m L^2 / 12 along each axis; the basis is orthonormal in the mass that its numbers are
 * of, and turns nothing. */
static void free_solids_have_the_inertia_of_their_box(void **state) {
  (void)state;
  for (int f = 0; f < FORMS; f++) {
    const double size[3] = {2, 2, 0.5}, mass = 4;
    body b = grid_make(forms[f], 2, 2, size[2], 0);
    thrum_precomputed result = body_precompute(&b, 3, 6);
    const int64_t r = result.model.rank;
    double *numbers = NULL;
    assert_int_equal(thrum_solid_inertia(&result.model, &numbers, NULL), THRUM_OK);
    assert_non_null(numbers);
    for (int k = 0; k < 9; k++)
      assert_within(numbers[k], k % 4 == 0 ? mass * size[k / 3] * size[k / 3] / 12 : 0, 1e-12);
    for (int64_t i = 0; i < r; i++) {
      const double *linear = numbers + 9 + 9 * i;
      for (int a = 0; a < 3; a++)
        assert_within(linear[3 * a + (a + 1) % 3], linear[3 * ((a + 1) % 3) + a], 1e-9);
      for (int64_t j = 0; j < r; j++) {
        const double *pair = numbers + 9 + 9 * r + 9 * (j * r + i);
        assert_within(pair[0] + pair[4] + pair[8], i == j, 1e-9);
      }
    }
    free(numbers);

    // without them the shape is not known to the library
    thrum_inertia *inertia = NULL;
    thrum_error error = {0};
    assert_int_equal(thrum_inertia_create(&result.model, 0, NULL, &inertia, &error),
                     THRUM_UNSUPPORTED);
    assert_non_null(strstr(error.message, "hexahedra and wedges"));
    assert_int_equal(thrum_solid_inertia_create(&result.model, &inertia, NULL), THRUM_OK);
    thrum_inertia_destroy(inertia);
    thrum_precomputed_free(&result);
    body_free(&b);
  }
}

/* The thickness is the shortest side, whichever node a file begins with. */
static void turned_hexahedra_are_the_same_shell(void **state) {
  (void)state;
  body b = grid_make(THRUM_FORM_HEX8, 3, 2, 0.1, 0), c = grid_make(THRUM_FORM_HEX8, 3, 2, 0.1, 0);
  static const int turned[8] = {0, 3, 7, 4, 1, 2, 6, 5};
  for (int64_t s = 0; s < c.mesh.solid_count; s++) {
    int32_t old[8];
    memcpy(old, c.mesh.solid_nodes + 8 * s, sizeof old);
    for (int n = 0; n < 8; n++)
      c.mesh.solid_nodes[8 * s + n] = old[turned[n]];
  }
  assert_int_equal(thrum_mesh_choose_shells(&b.mesh, THRUM_SHELL_THIN), b.mesh.solid_count);
  assert_int_equal(thrum_mesh_choose_shells(&c.mesh, THRUM_SHELL_THIN), b.mesh.solid_count);
  thrum_fem one = body_fem(&b), other = body_fem(&c);
  double *u = random_vector(3 * one.vertex_count, 0.05);
  assert_int_equal(c.mesh.solid_form[0], THRUM_FORM_SHELL8);
  assert_within(thrum_fem_energy(&one, u, NULL) / thrum_fem_energy(&other, u, NULL), 1, 1e-9);
  free(u);
  thrum_fem_free(&one);
  thrum_fem_free(&other);
  body_free(&b);
  body_free(&c);
}

/* A clamped square plate, one element thick and 1,000 times as wide, is as far off as it should be
 * with so few elements: Leissa 1969, Vibration of Plates, NASA SP-160: 35.985 and twice 73.394 over
 * L^2 times the root of D by rho t. Elements that lock are off by a hundred times that. */
static void check_plate(thrum_solid_form form, bool divided, const double most[3]) {
  enum { N = 10 };
  static const double exact[3] = {35.985, 73.394, 73.394};
  const double height = 0.001 * N, length = N;
  body b = grid_make(form, N, N, height, 0);
  if (divided) {
    bool done = false;
    assert_int_equal(thrum_mesh_divide_shells(&b.mesh, &done, NULL), THRUM_OK);
    assert_true(done);
    free(b.fixed);
    b.fixed = need((size_t)b.mesh.vertex_count, 1);
  }
  for (int64_t v = 0; v < b.mesh.vertex_count; v++)
    for (int d = 0; d < 2; d++) {
      const double x = b.mesh.vertices[3 * v + d];
      b.fixed[v] = x < 0.1 || x > N - 0.1 ? 7 : b.fixed[v];
    }
  thrum_precomputed result = body_precompute(&b, 3, 3);

  // how linear tetrahedra would lock is no matter here
  thrum_fem fem = body_fem(&b);
  int64_t count = 2;
  double errors[2];
  assert_int_equal(thrum_order_find(&b.mesh, &fem, INFINITY, &count, errors, NULL), THRUM_OK);
  assert_int_equal(count, 0);
  thrum_fem_free(&fem);
  const thrum_material *m = &b.mesh.materials[0];
  const double stiffness = m->young * pow(height, 3) / (12 * (1 - m->poisson * m->poisson));
  for (int i = 0; i < 3; i++) {
    const double number =
        sqrt(result.mode_omega2[i] * m->density * height / stiffness) * length * length;
    assert_true(number > exact[i] && number < (1 + most[i]) * exact[i]);
  }
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void thin_plates_do_not_lock(void **state) {
  (void)state;
  check_plate(THRUM_FORM_SHELL8, false, (const double[3]){0.03, 0.08, 0.08});
}

/* Wedges whose diagonals all go one way are 440 % off as they are. */
static void divided_wedges_do_not_lock(void **state) {
  (void)state;
  check_plate(THRUM_FORM_SHELL6, true, (const double[3]){0.01, 0.02, 0.02});
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(shape_functions_add_up_to_one_and_are_one_at_their_node),
      cmocka_unit_test(patch_test_passes_on_distorted_meshes),
      cmocka_unit_test(tractions_on_the_sides_hold_an_even_strain),
      cmocka_unit_test(solid_shells_take_uniform_shear_across),
      cmocka_unit_test(stress_is_that_of_the_strains),
      cmocka_unit_test(force_is_the_slope_of_energy_and_stiffness_that_of_force),
      cmocka_unit_test(reduced_polynomial_is_the_energy_of_the_mesh),
      cmocka_unit_test(refined_elements_fill_the_same_body),
      cmocka_unit_test(free_solids_have_the_inertia_of_their_box),
      cmocka_unit_test(turned_hexahedra_are_the_same_shell),
      cmocka_unit_test(thin_plates_do_not_lock),
      cmocka_unit_test(divided_wedges_do_not_lock),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
