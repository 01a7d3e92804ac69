/* The uses of a body of ten-node tetrahedra: full-order runs, tractions, stress, monitors,
 * embedded and shown surfaces, and files. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/precompute_support.h"
#include "tests/support/test_folder.h"

#include "core/base/quadratic_tet.h"
#include "driver/model/display_surface.h"
#include "io/vtu.h"
#include "precompute/embed.h"
#include "precompute/full/full.h"
#include "precompute/model/traction.h"
#include "thrum/monitor.h"
#include "thrum/stress.h"
#include "thrum/thrum.h"

/* A model of a body with curved edges, and coordinates of some bending. */
typedef struct curved_model {
  body body;
  thrum_precomputed result;
  double *q;
} curved_model;

static curved_model curved_make(void) {
  curved_model made = {.body = body_quadratic("beam:4x2x1@1x0.3x0.2", "x<0.001", 0, 0.01)};
  made.result = body_precompute(&made.body, 4, 8);
  made.q = need(8, sizeof *made.q);
  for (int i = 0; i < 8; i++)
    made.q[i] = 0.1 * random_number();
  return made;
}

static void curved_free(curved_model *made) {
  free(made->q);
  thrum_precomputed_free(&made->result);
  body_free(&made->body);
}

static void node_of(const thrum_model *model, int64_t t, int32_t node[10]) {
  memcpy(node, model->tets + 4 * t, 4 * sizeof *node);
  memcpy(node + 4, model->midsides + 6 * t, 6 * sizeof *node);
}

/* Green strain at the centre of a tet, over all ten nodes. */
static void strain_at_centre(const thrum_model *model, int64_t t, const double *q,
                             double strain[6]) {
  static const double centre[4] = {0.25, 0.25, 0.25, 0.25};
  static const int rows[6] = {0, 1, 2, 0, 1, 0}, columns[6] = {0, 1, 2, 1, 2, 2};
  double places[10][3], slopes[10][3], map[9], g[3][3] = {{0}};
  int32_t node[10];

  // the slopes of the shape functions there, in the body's axes
  node_of(model, t, node);
  for (int a = 0; a < 10; a++)
    memcpy(places[a], model->vertices + 3 * (int64_t)node[a], sizeof places[a]);
  thrum_quadratic_slopes(centre, slopes);
  assert_true(thrum_quadratic_map(places, slopes, map) > 0);

  // the displacement gradient is a sum over the nodes
  for (int a = 0; a < 10; a++)
    for (int c = 0; c < 3; c++) {
      const double u =
          dot_of(model->basis + (3 * (int64_t)node[a] + c) * model->rank, q, model->rank);
      for (int d = 0; d < 3; d++)
        g[c][d] +=
            u * (slopes[a][0] * map[d] + slopes[a][1] * map[3 + d] + slopes[a][2] * map[6 + d]);
    }

  // E = 1/2 (G + G^T + G^T G)
  for (int n = 0; n < 6; n++) {
    const int c = rows[n], d = columns[n];
    strain[n] = (g[c][d] + g[d][c]) / 2;
    for (int k = 0; k < 3; k++)
      strain[n] += g[k][c] * g[k][d] / 2;
  }
}

static void strain_is_that_at_the_centre_of_each_element(void **state) {
  (void)state;
  curved_model m = curved_make();
  const thrum_model *model = &m.result.model;
  static const int32_t some[3] = {7, 0, 30};

  // all tets, with and without a workspace, and some
  for (int way = 0; way < 3; way++) {
    const thrum_stress_points_def def = {way == 2 ? some : NULL, 3};
    size_t size;
    const thrum_stress_points *points;
    assert_int_equal(thrum_stress_points_size(model, &def, &size, NULL), THRUM_OK);
    void *memory = aligned_alloc(64, size);
    assert_int_equal(thrum_stress_points_init(memory, size, model, &def, &points, NULL), THRUM_OK);
    const int64_t count = thrum_stress_points_count(points);
    double *work = need((size_t)thrum_stress_points_work_count(points), sizeof *work);
    double *strain = need((size_t)(6 * count), sizeof *strain);
    const thrum_stress_points_output output = {.strain = strain};
    assert_int_equal(thrum_stress_points_read(points, m.q, way == 0 ? work : NULL, &output, NULL),
                     THRUM_OK);
    for (int64_t n = 0; n < count; n++) {
      double wanted[6];
      strain_at_centre(model, way == 2 ? some[n] : n, m.q, wanted);
      assert_near(strain + 6 * n, wanted, 6, 1e-12);
    }
    free(memory);
    free(work);
    free(strain);
  }
  curved_free(&m);
}

static void monitors_look_at_a_body_of_ten_node_tets(void **state) {
  (void)state;
  curved_model m = curved_make();
  const thrum_model *model = &m.result.model;
  const thrum_monitor_def def = thrum_default_monitor_def();
  size_t size;
  const thrum_monitor *monitor;
  assert_int_equal(thrum_monitor_size(model, &def, &size, NULL), THRUM_OK);
  void *memory = aligned_alloc(64, size);
  assert_int_equal(thrum_monitor_init(memory, size, model, &def, &monitor, NULL), THRUM_OK);

  // the least stretch of the sampled tets is that of their strains
  thrum_monitor_record record;
  thrum_monitor_clear(&record);
  assert_true(thrum_monitor_look(monitor, m.q, &record, NULL) >= 0);
  double strain[6];
  strain_at_centre(model, record.stretch_tet, m.q, strain);
  assert_true(record.stretch > 0.3 && record.stretch < 1);
  const double trace = strain[0] + strain[1] + strain[2];
  assert_true((record.stretch * record.stretch - 1) / 2 <= trace / 3 + 1e-12);
  free(memory);
  curved_free(&m);
}

static void tractions_on_six_node_triangles_add_up_to_area_and_moment(void **state) {
  (void)state;
  curved_model m = curved_make();
  const thrum_model *model = &m.result.model;
  const double pull[3] = {3, -2, 5};
  const int64_t n = model->vertex_count;
  double *forces = need((size_t)(3 * n), sizeof *forces), area = 0, sum[3] = {0};
  assert_int_equal(thrum_traction_fill(model, NULL, 0, pull, forces, &area, NULL), THRUM_OK);
  for (int64_t c = 0; c < 3 * n; c++)
    sum[c % 3] += forces[c];
  for (int axis = 0; axis < 3; axis++)
    assert_close(sum[axis], area * pull[axis], 1e-12);
  curved_free(&m);

  // the plane end of a straight beam: a third on middle nodes alone, and no moment about its centre
  body b = body_quadratic("beam:2x2x2@1x0.4x0.3", "x<0.001", 0, 0);
  thrum_precomputed result = body_precompute(&b, 2, 2);
  const int32_t *list;
  int64_t count;
  assert_int_equal(thrum_model_group(&result.model, "right", &list, &count, NULL), THRUM_OK);
  free(forces);
  forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces);
  assert_int_equal(thrum_traction_fill(&result.model, list, count, pull, forces, &area, NULL),
                   THRUM_OK);
  assert_close(area, 0.12, 1e-13);
  double moment[2] = {0};
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    if (v < 27) // the corners come first
      assert_true(fabs(forces[3 * v]) < 1e-14);
    moment[0] += forces[3 * v] * b.mesh.vertices[3 * v + 1];
    moment[1] += forces[3 * v] * b.mesh.vertices[3 * v + 2];
  }
  assert_true(fabs(moment[0]) < 1e-14 && fabs(moment[1]) < 1e-14);
  free(forces);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void a_tumbling_body_keeps_energy_and_both_momenta(void **state) {
  (void)state;
  body b = body_quadratic("beam:4x1x1@1x0.2x0.2", NULL, 0, 0.01);
  thrum_precomputed result = body_precompute(&b, 4, 4);
  thrum_full_def def = thrum_default_full_def();
  def.dt = 0.01;
  def.tolerance = 1e-13;
  thrum_full *full = NULL;
  assert_int_equal(thrum_full_create(&result.model, NULL, &def, &full, NULL), THRUM_OK);

  // thrown so that it rotates and vibrates
  const int64_t n = b.mesh.vertex_count;
  double *u = need((size_t)(3 * n), sizeof *u), *v = need((size_t)(3 * n), sizeof *v);
  for (int64_t k = 0; k < n; k++) {
    const double *x = b.mesh.vertices + 3 * k;
    u[3 * k + 1] = 0.1 * x[0] * x[0];
    v[3 * k] = 0.3 - 2 * x[1];
    v[3 * k + 1] = -0.2 + 2 * x[0];
    v[3 * k + 2] = 0.5 * x[0] * x[0];
  }
  assert_int_equal(thrum_full_set(full, u, v, NULL), THRUM_OK);

  double linear[3], angular[3], p[3], l[3];
  const double energy = thrum_full_energy(full).total;
  thrum_full_momentum(full, linear, angular);
  for (int k = 0; k < 40; k++)
    assert_true(thrum_full_step(full, NULL) >= 0);
  thrum_full_momentum(full, p, l);
  assert_close(thrum_full_energy(full).total, energy, 1e-10);
  assert_near(p, linear, 3, 1e-10);
  assert_near(l, angular, 3, 1e-10);

  free(u);
  free(v);
  thrum_full_free(full);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void explicit_steps_take_the_scaled_diagonal_as_mass(void **state) {
  (void)state;
  body b = body_quadratic("beam:2x1x1@1x0.3x0.3", "x<0.001", 0, 0);
  thrum_precomputed result = body_precompute(&b, 2, 2);
  thrum_full_def def = thrum_default_full_def();
  def.scheme = THRUM_FULL_CENTRAL;
  def.dt = 1e-5;
  thrum_full *full = NULL;
  assert_int_equal(thrum_full_create(&result.model, NULL, &def, &full, NULL), THRUM_OK);
  assert_true(thrum_full_report_get(full).dt_stable > 1e-4);

  // the weight of the body is all there, whatever the mass
  double *forces = need((size_t)(3 * b.mesh.vertex_count), sizeof *forces), sum = 0;
  thrum_full_add_gravity(full, (double[]){0, 0, -2}, forces);
  for (int64_t v = 0; v < b.mesh.vertex_count; v++) {
    assert_true(forces[3 * v + 2] < 0);
    sum += forces[3 * v + 2];
  }
  assert_close(sum, -2 * 90, 1e-12);
  free(forces);
  thrum_full_free(full);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void an_embedded_surface_moves_with_all_ten_nodes(void **state) {
  (void)state;
  body b = body_quadratic("beam:4x2x1@1x0.3x0.2", "x<0.001", 0, 0);
  thrum_precomputed result = body_precompute(&b, 4, 8);
  const thrum_model *model = &result.model;

  // a corner, a middle node, and a point in between
  int32_t node[10];
  node_of(model, 5, node);
  static const double place[4] = {0.1, 0.2, 0.3, 0.4};
  double points[9] = {0}, shape[10];
  thrum_quadratic_shape(place, shape);
  for (int axis = 0; axis < 3; axis++) {
    points[axis] = model->vertices[3 * node[2] + axis];
    points[3 + axis] = model->vertices[3 * node[8] + axis];
    for (int a = 0; a < 4; a++)
      points[6 + axis] += place[a] * model->vertices[3 * node[a] + axis];
  }
  int32_t triangle[3] = {0, 1, 2};
  const thrum_surface_mesh surface = {
      .vertex_count = 3, .vertices = points, .triangle_count = 1, .triangles = triangle};
  thrum_embed embed = {0};
  assert_int_equal(thrum_embed_make(model, &surface, NULL, NULL, &embed, NULL), THRUM_OK);
  for (int axis = 0; axis < 3; axis++)
    for (int i = 0; i < 8; i++) {
      const double wanted[3] = {model->basis[(3 * node[2] + axis) * 8 + i],
                                model->basis[(3 * node[8] + axis) * 8 + i], 0};
      double inner = 0;
      for (int a = 0; a < 10; a++)
        inner += shape[a] * model->basis[(3 * node[a] + axis) * 8 + i];
      for (int v = 0; v < 3; v++) {
        const double found = embed.embedding.basis[(3 * v + axis) * 8 + i];
        assert_true(fabs(found - (v < 2 ? wanted[v] : inner)) < 1e-6 * (1 + fabs(found)));
      }
    }
  thrum_embed_free(&embed);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void the_shown_surface_has_four_triangles_a_face(void **state) {
  (void)state;
  body b = body_quadratic("beam:3x2x1@1x0.4x0.2", "x<0.001", 0, 0);
  thrum_precomputed result = body_precompute(&b, 2, 2);
  display_surface skin = {0};
  assert_int_equal(display_surface_make(&result.model, &skin, NULL), THRUM_OK);

  // two triangles a square, four each, outwards: area and enclosed volume of the box
  assert_int_equal(skin.triangle_count, 4 * 2 * 2 * (3 * 2 + 3 + 2));
  assert_int_equal(skin.vertex_count, skin.triangle_count / 2 + 2);
  double volume = 0;
  for (int64_t t = 0; t < skin.triangle_count; t++) {
    const double *x[3];
    for (int k = 0; k < 3; k++)
      x[k] = result.model.vertices + 3 * (int64_t)skin.vertices[skin.triangles[3 * t + k]];
    for (int c = 0; c < 3; c++)
      volume += x[0][c] *
                (x[1][(c + 1) % 3] * x[2][(c + 2) % 3] - x[1][(c + 2) % 3] * x[2][(c + 1) % 3]) / 6;
  }
  assert_close(volume, 0.08, 1e-13);
  display_surface_free(&skin);
  thrum_precomputed_free(&result);
  body_free(&b);
}

static void model_files_and_frames_keep_the_ten_nodes(void **state) {
  (void)state;
  curved_model m = curved_make();
  const thrum_model *model = &m.result.model;
  const size_t mids = 6 * (size_t)model->tet_count * sizeof *model->midsides;
  assert_int_equal(model->format[0], 2);

  // a frame, read as a mesh
  double *u = need((size_t)(3 * model->vertex_count), sizeof *u);
  thrum_mesh read = {0};
  assert_int_equal(vtu_write(in_folder("frame.vtu"), model, u, NULL, 0, NULL), THRUM_OK);
  assert_int_equal(thrum_mesh_read(in_folder("frame.vtu"), 1, &read, NULL), THRUM_OK);
  assert_int_equal(read.vertex_count, model->vertex_count);
  assert_non_null(read.midsides);
  assert_memory_equal(read.midsides, model->midsides, mids);
  thrum_mesh_free(&read);
  free(u);
  curved_free(&m);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(strain_is_that_at_the_centre_of_each_element),
      cmocka_unit_test(monitors_look_at_a_body_of_ten_node_tets),
      cmocka_unit_test(tractions_on_six_node_triangles_add_up_to_area_and_moment),
      cmocka_unit_test(a_tumbling_body_keeps_energy_and_both_momenta),
      cmocka_unit_test(explicit_steps_take_the_scaled_diagonal_as_mass),
      cmocka_unit_test(an_embedded_surface_moves_with_all_ten_nodes),
      cmocka_unit_test(the_shown_surface_has_four_triangles_a_face),
      cmocka_unit_test(model_files_and_frames_keep_the_ten_nodes),
  };
  return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
