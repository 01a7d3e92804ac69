/* Fuzz target of the functions that take a model and that fuzz_model_use does not call: energies
 * and passes, what follows, states laid into memory, loads, readouts, rigid motion, contact of one
 * body and of two. Each is called with every kind of model: plain, condensed, with touch modes, of
 * cubature points, of a law that flows, free, locked, scaled. A call that succeeds leaves finite
 * numbers.
 * sources: scene/*.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/fuzz/fuzz_use.h"

#define STEPS 4
#define VERTICES_MOST 200

/* --- energies, passes and names ------------------------------------------------------------------
 */

static void use_energy(const thrum_model *model, fuzz_draw *draw) {
  const int64_t r = model->rank;
  double q[RANK_MOST], v[RANK_MOST], out[RANK_MOST], tangent[RANK_MOST * RANK_MOST];
  double *work = block(thrum_work_count(model) * sizeof *work);
  draw_vector(draw, r, 0.1, q);
  draw_vector(draw, r, 1, v);

  // a model without a polynomial answers by NaN alone
  const double energy = thrum_strain_energy(model, q, work);
  const double with_force = thrum_internal_force(model, q, out, work);
  if (thrum_model_masters(model) > 0 && !(isnan(energy) && isnan(with_force) && isnan(out[0])))
    abort();
  thrum_tangent_stiffness(model, q, tangent, work);
  thrum_internal_force_tangent(model, q, out, tangent, work);
  thrum_tangent_product(model, q, v, out, work);

  // each pass, restrict first
  thrum_error error = {0};
  double *result = block(thrum_pass_result_count(model) * sizeof *result);
  const int32_t split = (int32_t)draw_index(draw, r + 2) - 1;
  for (int pass = 0; pass <= THRUM_PASS_COUNT; pass++) {
    const thrum_kernel_id kernel = (thrum_kernel_id)draw_index(draw, 7);
    fuzz_check(thrum_pass_run(model, kernel, (thrum_pass)pass, split, q, v, result, work, &error),
               &error);
    const thrum_pass_cost cost = thrum_pass_cost_of(r, (thrum_pass)pass, split);
    must_be_finite(&cost.operations, 1);
    if (!thrum_kernel_usable(thrum_kernel_chosen(kernel)) && thrum_kernel_name(kernel) != NULL)
      abort();
  }
  free(result);
  free(work);
}

static void use_model(const thrum_model *model, fuzz_draw *draw) {
  thrum_error error = {0};
  thrum_model copy = *model;
  const int64_t r = model->rank;
  fuzz_check(thrum_model_check(model, &error), &error);
  fuzz_check(thrum_model_check_shapes(model, &error), &error);
  if (thrum_c3_index(r, 0, r - 1, r - 1) >= thrum_c3_count(r) ||
      thrum_c4_index(r, 0, r - 1, r - 1, r - 1) >= thrum_c4_count(r))
    abort();

  // packed once more, and known by its coefficients
  const size_t size = thrum_model_pack_size(&copy);
  void *memory = block(size);
  fuzz_check(thrum_model_pack(&copy, memory, size, &error), &error);
  if (thrum_model_identity(&copy) != thrum_model_identity(model))
    abort();
  free(memory);

  // groups
  const char *name = thrum_model_group_name(model, draw_index(draw, model->group_count + 1));
  const int32_t *vertices = NULL;
  int64_t count = 0;
  fuzz_check(thrum_model_group(model, name != NULL ? name : "none", &vertices, &count, &error),
             &error);
}

/* Names of every choice, and what is none. */
static void use_names(fuzz_draw *draw) {
  thrum_error error = {0};
  const int any = (int)draw_byte(draw) - 128;
  if (thrum_status_text((thrum_status)any) == NULL || thrum_version() == NULL)
    abort();
  (void)thrum_warning_text((thrum_warning)any);
  (void)thrum_split_rule_name((thrum_split_rule)any);
  (void)thrum_scheme_name((thrum_scheme)any);

  // a name leads back to its choice
  for (int n = -1; n < 12; n++) {
    thrum_integrator integrator;
    thrum_damping_form form;
    thrum_split_form split;
    thrum_implicit_solver solver;
    const char *name = thrum_integrator_name((thrum_integrator)n);
    fuzz_check(thrum_integrator_from_name(name, &integrator, &error), &error);
    fuzz_check(
        thrum_damping_form_from_name(thrum_damping_form_name((thrum_damping_form)n), &form, &error),
        &error);
    fuzz_check(
        thrum_split_form_from_name(thrum_split_form_name((thrum_split_form)n), &split, &error),
        &error);
    fuzz_check(thrum_implicit_solver_from_name(thrum_implicit_solver_name((thrum_implicit_solver)n),
                                               &solver, &error),
               &error);
    if (name != NULL && (int)integrator != n)
      abort();
  }
}

/* --- what follows, loads and readouts ------------------------------------------------------------
 */

static void use_condensed(const thrum_model *model, fuzz_draw *draw) {
  const thrum_model *shape = thrum_condensed_shape_model(model);
  double x[RANK_MOST], v[RANK_MOST], load[RANK_MOST], q[RANK_MOST];
  draw_vector(draw, model->rank, 0.1, x);
  draw_vector(draw, model->rank, 1, v);
  draw_vector(draw, shape->rank, 10, load);
  thrum_condensed_shape(model, x, draw_byte(draw) % 2 ? load : NULL, q);
  thrum_condensed_velocity(model, x, v, q);
  thrum_condensed_load(model, x, load, q);
  (void)thrum_condensed_inertia_share(model, x, v);
  (void)thrum_model_unit_energy(model);
}

static void use_base_motion(const thrum_model *model, fuzz_draw *draw) {
  enum { COUNT = 4 };
  double times[COUNT], accelerations[3 * COUNT], positions[3 * COUNT], velocities[3 * COUNT];
  double work[COUNT], mean[3], place[3], reduced[RANK_MOST] = {0};
  thrum_error error = {0};
  for (int n = 0; n < COUNT; n++)
    times[n] = (n > 0 ? times[n - 1] : 0) + draw_above(draw, 0.1);
  draw_vector(draw, 3 * COUNT, 1, accelerations);
  thrum_base_motion motion = {COUNT, times, accelerations, NULL, NULL};
  const double dt = draw_above(draw, 0.01);

  // a motion that passes its check has a path that is finite
  if (thrum_base_motion_check(&motion, &error) >= 0) {
    thrum_base_motion_integrate(COUNT, times, accelerations, velocities, positions);
    motion.velocities = velocities;
    motion.positions = positions;
    thrum_base_motion_mean(&motion, (int64_t)draw_byte(draw), dt, mean);
    thrum_base_motion_at(&motion, (double)draw_byte(draw) / 64, place, mean);
    must_be_finite(place, 3);
    thrum_base_motion_spline(COUNT, times, positions, accelerations, velocities, work);
    fuzz_check(thrum_base_motion_load(model, mean, reduced, &error), &error);
  }
  const thrum_load course = {.shape = (thrum_load_shape)draw_index(draw, 4),
                             .from = draw_about(draw, 1),
                             .until = draw_about(draw, 1),
                             .frequency = draw_any(draw)};
  (void)thrum_base_motion_sine(&course, draw_about(draw, 1));
}

static void use_loads(const thrum_model *model, fuzz_draw *draw) {
  double reduced[RANK_MOST] = {0}, q[RANK_MOST], next[RANK_MOST], vector[3];
  double *field = block(3 * (size_t)model->vertex_count * sizeof *field);
  thrum_error error = {0};
  draw_vector(draw, 3, 10, vector);
  draw_vector(draw, 3 * model->vertex_count, 10, field);
  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, model->rank, 0.1, next);
  const int32_t vertices[2] = {(int32_t)draw_index(draw, model->vertex_count + 1), 0};

  // at places, over the body, and what the vertices and the weight of it say
  fuzz_check(thrum_load_add_vertex(model, draw_index(draw, model->vertex_count + 1), vector,
                                   reduced, &error),
             &error);
  fuzz_check(thrum_load_add_shared(model, draw_byte(draw) % 2 ? vertices : NULL,
                                   draw_index(draw, 3), vector, reduced, &error),
             &error);
  fuzz_check(thrum_load_add_field(model, field, reduced, &error), &error);
  fuzz_check(thrum_load_add_gravity(model, vector, reduced, &error), &error);
  free(field);

  // over time
  const thrum_load courses[2] = {
      {(thrum_load_shape)draw_index(draw, 4), draw_about(draw, 1), draw_about(draw, 1), 3},
      {.shape = THRUM_LOAD_SINE, .until = INFINITY, .frequency = draw_any(draw)}};
  double directions[2 * RANK_MOST];
  draw_vector(draw, 2 * model->rank, 1, directions);
  (void)thrum_load_mean(courses, draw_byte(draw), draw_above(draw, 0.01));
  thrum_load_sum(courses, directions, 2, model->rank, draw_byte(draw), draw_above(draw, 0.01),
                 reduced);
  (void)thrum_load_work(reduced, q, next, model->rank);
  (void)thrum_damping_loss(model, draw_above(draw, 1), draw_above(draw, 1), q, next, 0.003);
  if (thrum_step_count(draw_any(draw), draw_any(draw)) < 0)
    abort();
  use_base_motion(model, draw);
}

/* A surface in the first tetrahedron: three vertices with rows of their own. */
static void use_embedding(const thrum_model *model, fuzz_draw *draw) {
  static const int32_t format[2] = {1, 0}, triangles[3] = {0, 1, 2};
  const int32_t tet[3] = {0, 0, (int32_t)draw_byte(draw) % 4 - 2};
  double positions[9], weights[12];
  float basis[9 * RANK_MOST];
  thrum_error error = {0};
  draw_vector(draw, 9, 1, positions);
  draw_vector(draw, 12, 1, weights);
  for (int64_t n = 0; n < 9 * model->rank; n++)
    basis[n] = (float)draw_about(draw, 1);
  const thrum_embedding embedding = {.rank = model->rank,
                                     .vertex_count = 3,
                                     .triangle_count = 1,
                                     .surface_format = format,
                                     .omega2 = model->omega2,
                                     .positions = positions,
                                     .triangles = triangles,
                                     .basis = basis,
                                     .tet = tet,
                                     .weights = weights};

  // what passes the checks is shown
  if (thrum_embedding_check(&embedding, &error) < 0 ||
      thrum_embedding_fits(&embedding, model, &error) < 0)
    return;
  const thrum_surface_def def = thrum_embedding_surface(&embedding);
  const thrum_surface *surface = NULL;
  size_t size = 0;
  fuzz_check(thrum_surface_size(model, &def, &size, &error), &error);
  void *memory = block(size);
  if (thrum_surface_init(memory, size, model, &def, &surface, &error) >= 0 &&
      (thrum_surface_fits(surface, model, &error) < 0 ||
       thrum_surface_triangle_count(surface) != 1))
    abort();
  free(memory);
}

/* Stresses at nodes, of displacements that are drawn. */
static void use_stress_nodes(const thrum_model *model, const double *u) {
  const thrum_stress_nodes *nodes = NULL;
  thrum_error error = {0};
  size_t size = 0;
  if (thrum_stress_nodes_size(model, &size, &error) < 0)
    return;
  void *memory = block(size);
  if (thrum_stress_nodes_init(memory, size, model, &nodes, &error) >= 0) {
    const int64_t count = thrum_stress_nodes_count(nodes);
    double *cauchy = block(7 * (size_t)count * sizeof *cauchy);
    fuzz_check(thrum_stress_nodes_read(nodes, u, cauchy, cauchy + 6 * count, &error), &error);
    free(cauchy);
    if (thrum_stress_nodes_extrapolated(nodes) >> 1 != 0 ||
        thrum_stress_nodes_vertex(nodes, count - 1) >= model->vertex_count ||
        thrum_stress_nodes_region(nodes, count - 1) >= model->region_count)
      abort();
  }
  free(memory);
}

static void use_readouts(const thrum_model *model, fuzz_draw *draw) {
  double q[RANK_MOST], stress[6];
  double *field = block(3 * (size_t)model->vertex_count * sizeof *field);
  thrum_error error = {0};
  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, 3 * model->vertex_count, 10, field);
  draw_vector(draw, 6, 1e6, stress);
  (void)thrum_von_mises(stress);

  // the monitor looks at a load
  int32_t tets[8];
  int64_t chosen = 0;
  fuzz_check(thrum_sampled_tets_choose(model, draw_index(draw, 9), tets, &chosen, &error), &error);
  const thrum_monitor_def def = thrum_default_monitor_def();
  const thrum_monitor *monitor = NULL;
  size_t size = 0;
  if (thrum_monitor_size(model, &def, &size, &error) >= 0) {
    void *memory = block(size);
    if (thrum_monitor_init(memory, size, model, &def, &monitor, &error) >= 0) {
      thrum_monitor_record record;
      const int32_t *sampled = NULL;
      thrum_monitor_clear(&record);
      fuzz_check(thrum_monitor_look_at_load(monitor, model, field, &record, &error), &error);
      if (thrum_monitor_sampled_tets(monitor, &sampled) > 0 && sampled[0] >= model->tet_count)
        abort();
    }
    free(memory);
  }

  // stress points name their tetrahedra
  const thrum_stress_points_def points_def = {0};
  const thrum_stress_points *points = NULL;
  if (thrum_stress_points_size(model, &points_def, &size, &error) >= 0) {
    void *memory = block(size);
    if (thrum_stress_points_init(memory, size, model, &points_def, &points, &error) >= 0 &&
        thrum_stress_points_tet(points, thrum_stress_points_count(points) - 1) >= model->tet_count)
      abort();
    free(memory);
  }

  use_stress_nodes(model, field);

  // displacements that are given are finite
  if (thrum_displacement(model, q, 0, model->vertex_count, field, &error) >= 0)
    must_be_finite(field, 3 * model->vertex_count);
  free(field);
  use_embedding(model, draw);
}

/* --- states -------------------------------------------------------------------------------------
 */

/* A state that is laid into memory and works in scratch that is lent. */
static void use_state(const thrum_model *model, fuzz_draw *draw) {
  thrum_state_def def = draw_def(draw, model->rank);
  thrum_error error = {0};
  thrum_state *state = NULL, *other = NULL;
  size_t size = 0, scratch_size = 0;
  def.borrows_scratch = draw_byte(draw) % 2;
  if (draw_byte(draw) % 2)
    def.plastic = (thrum_plastic){draw_above(draw, 0.01), draw_above(draw, 1), INFINITY};
  if (thrum_state_size(model, &def, &size, &error) < 0 ||
      thrum_state_scratch_size(model, &def, &scratch_size, &error) < 0)
    return;
  void *memory = block(size), *again = block(size), *scratch = block(scratch_size);
  fuzz_check(thrum_state_init(memory, size, model, &def, &state, &error), &error);
  fuzz_check(thrum_state_init(again, size, model, &def, &other, &error), &error);
  if (state != NULL && other != NULL) {
    if (def.borrows_scratch)
      fuzz_check(thrum_state_lend(state, scratch, scratch_size, &error), &error);
    double q[RANK_MOST];
    draw_vector(draw, model->rank, 0.1, q);
    fuzz_check(thrum_state_set(model, state, q, NULL, &error), &error);

    // steps, and what has flowed in them
    int64_t made = 0;
    fuzz_check(thrum_steps(model, state, STEPS, &made, &error), &error);
    const thrum_state_report report = thrum_state_report_get(state);
    const double said[] = {report.time,
                           report.corrected,
                           report.dissipated,
                           report.plastic_work,
                           thrum_state_plastic_strain(state),
                           thrum_state_point_stiffness(state)};
    must_be_finite(said, sizeof said / sizeof said[0]);
    fuzz_check(thrum_state_take_plastic(other, state, &error), &error);
    fuzz_check(thrum_state_clear_plastic(model, state, &error), &error);

    // a copy of what persists is a state of this model
    void *copy = block(thrum_state_kept_bytes(state));
    memcpy(copy, state, thrum_state_kept_bytes(state));
    fuzz_check(thrum_state_copy_check(model, state, copy, &error), &error);
    free(copy);
  }
  free(scratch);
  free(again);
  free(memory);
}

/* --- rigid motion -------------------------------------------------------------------------------
 */

static void use_rigid(const thrum_model *model, fuzz_draw *draw) {
  thrum_rigid_frame frame = {.attitude = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  thrum_translation way = {draw_above(draw, 10), {0}, {0}};
  thrum_error error = {0};
  double torque[3], angle[3], velocity[3], q[RANK_MOST], p[RANK_MOST], force[RANK_MOST];
  draw_vector(draw, 3, 1, torque);
  draw_vector(draw, model->rank, 0.1, q);
  draw_vector(draw, model->rank, 1, p);
  thrum_translation_step(&way, torque, draw_above(draw, 0.01));
  if (thrum_rigid_frame_of(model, &frame, &error) < 0)
    return;
  thrum_rigid_frame_step(&frame, NULL, torque, draw_above(draw, 0.01), angle);
  (void)thrum_rigid_frame_energy(&frame, NULL);
  thrum_rigid_frame_velocity(&frame, NULL, velocity);
  const thrum_placement here = thrum_placement_now(NULL, &frame, way.position);

  // the rotation and the shape together
  thrum_inertia *inertia = NULL;
  const int64_t rank = draw_index(draw, model->rank + 1);
  fuzz_check(thrum_inertia_create(model, rank, NULL, &inertia, &error), &error);
  if (inertia == NULL)
    return;
  const int64_t of = thrum_inertia_rank(inertia);
  double *work = block(thrum_floating_frame_work_count(inertia) * sizeof *work);
  double *numbers = block((size_t)thrum_inertia_number_count(of) * sizeof *numbers);
  double *room = block(9 * (size_t)of * sizeof *room), tensor[9];
  thrum_inertia_numbers(inertia, numbers);
  thrum_inertia_tensor(inertia, q, tensor, room);
  thrum_state *state = NULL;
  thrum_state_def def = thrum_default_state_def();
  def.integrator = THRUM_INTEGRATOR_ENERGY;
  fuzz_check(thrum_state_create(model, &def, &state, &error), &error);
  if (thrum_floating_frame_settle(inertia, q, p, &frame, work, &error) >= 0 && state != NULL) {
    thrum_floating_frame_spin(&here, torque, &frame);
    thrum_floating_frame_force(inertia, &here, &frame, q, p, force, work);
    for (int n = 0; n < STEPS; n++)
      fuzz_check(thrum_floating_frame_step(model, state, inertia, &here, &frame, torque, angle,
                                           work, &error),
                 &error);
  }
  thrum_state_destroy(state);
  free(room);
  free(numbers);
  free(work);
  thrum_inertia_destroy(inertia);
}

/* --- contact ------------------------------------------------------------------------------------
 */

/* A body over an obstacle, with a pull. */
typedef struct touched {
  thrum_state *state;
  thrum_contact *contact;
  void *memory;
  thrum_obstacle obstacle;
  thrum_pull pull;
  thrum_translation way;
  thrum_contact_environment around;
} touched;

static bool touched_make(const thrum_model *model, fuzz_draw *draw, touched *made) {
  thrum_error error = {0};
  thrum_state_def def = draw_def(draw, model->rank);
  thrum_contact_def contact = thrum_default_contact_def();
  size_t size = 0;
  *made = (touched){.obstacle = thrum_default_obstacle(), .way = {.mass = 1}};
  fuzz_check(thrum_state_create(model, &def, &made->state, &error), &error);
  if (made->state == NULL || model->vertex_count > VERTICES_MOST ||
      thrum_contact_size(model, made->state, &contact, &size, &error) < 0)
    return false;
  made->memory = block(size);
  fuzz_check(
      thrum_contact_init(made->memory, size, model, made->state, &contact, &made->contact, &error),
      &error);
  made->obstacle.shape = (thrum_obstacle_shape)draw_index(draw, 3);
  made->obstacle.centre[2] = draw_about(draw, 0.5);
  made->obstacle.restitution = draw_above(draw, 1) / 64;
  made->pull = (thrum_pull){.weights = {1, 0, 0},
                            .target = {0, 0, draw_about(draw, 1)},
                            .stiffness = draw_above(draw, 1000),
                            .damping = -1};
  made->around = (thrum_contact_environment){.obstacles = &made->obstacle,
                                             .obstacle_count = 1,
                                             .pulls = &made->pull,
                                             .pull_count = draw_byte(draw) % 2};
  return made->contact != NULL;
}

static void touched_free(touched *made) {
  thrum_state_destroy(made->state);
  free(made->memory);
}

static void use_contact(const thrum_model *model, fuzz_draw *draw) {
  touched one;
  thrum_error error = {0};
  double normal[3], force[3], place[3];
  draw_vector(draw, 3, 1, place);
  if (touched_make(model, draw, &one)) {
    fuzz_check(thrum_obstacle_check(&one.obstacle, 0, &error), &error);
    (void)thrum_obstacle_gap(&one.obstacle, place, normal);
    for (int n = 0; n < STEPS; n++)
      fuzz_check(thrum_contact_step(model, one.state, one.contact, &one.around, &error), &error);

    // by its parts
    thrum_status status = thrum_contact_begin(model, one.state, one.contact, &one.around, &error);
    THRUM_THEN(status, thrum_step(model, one.state, &error));
    THRUM_THEN(status, thrum_contact_end(model, one.state, one.contact, &one.around, &error));
    fuzz_check(status, &error);

    // what it says of itself
    const thrum_contact_report report = thrum_contact_report_get(one.contact);
    const double said[] = {
        report.depth,  report.normal,  report.stored, report.lost,
        report.driven, report.granted, report.pulled, thrum_contact_stiffness(one.contact)};
    must_be_finite(said, sizeof said / sizeof said[0]);
    thrum_touch touch;
    fuzz_check(thrum_contact_touch_get(one.contact, draw_index(draw, 3), &touch, &error), &error);
    fuzz_check(thrum_contact_pull_force(one.contact, draw_index(draw, 2), force, &error), &error);
    void *copy = block(thrum_contact_bytes(one.contact));
    memcpy(copy, one.contact, thrum_contact_bytes(one.contact));
    if (status >= 0)
      fuzz_check(thrum_contact_copy_check(one.contact, copy, &error), &error);
    free(copy);
    thrum_contact_reset(one.contact);
  }
  touched_free(&one);
}

/* The first face of each tetrahedron, and the skin over them; NULL: refused. */
static thrum_skin *skin_of(const thrum_model *model, int32_t *faces, void **memory) {
  thrum_error error = {0};
  thrum_skin *skin = NULL;
  size_t size = 0;
  for (int64_t t = 0; t < model->tet_count; t++)
    for (int k = 0; k < 3; k++)
      faces[3 * t + k] = model->tets[4 * t + (k == 0 ? 0 : 3 - k)];
  if (thrum_skin_size(model, faces, model->tet_count, &size, &error) < 0)
    return NULL;
  *memory = block(size);
  fuzz_check(thrum_skin_init(*memory, size, model, faces, model->tet_count, &skin, &error), &error);
  return skin;
}

/* A solid triangle that rests. */
static thrum_skin *solid_skin(fuzz_draw *draw, void **memory) {
  static const int32_t triangle[3] = {0, 1, 2};
  double vertices[9];
  thrum_error error = {0};
  thrum_skin *skin = NULL;
  size_t size = 0;
  draw_vector(draw, 9, 1, vertices);
  if (thrum_skin_solid_size(vertices, 3, triangle, 1, &size, &error) < 0)
    return NULL;
  *memory = block(size);
  fuzz_check(thrum_skin_solid_init(*memory, size, vertices, 3, triangle, 1, &skin, &error), &error);
  const double place[3] = {draw_about(draw, 1), 0, 0};
  if (skin != NULL)
    (void)thrum_triangles_distance(vertices, triangle, 1, place);
  return skin;
}

/* Steps a body beside a solid, as one call and by groups. */
static void step_pairs(thrum_contact_pairs *pairs, const thrum_contact_pairs_def *def, size_t size,
                       thrum_contact_member members[2], fuzz_draw *draw) {
  thrum_error error = {0};
  const thrum_skin_bound bound = thrum_contact_member_bound(&members[0]);
  const thrum_skin_bound solid = thrum_contact_member_bound(&members[1]);
  (void)thrum_contact_pairs_near(&bound, &solid);
  for (int n = 0; n < STEPS; n++) {
    thrum_contact_pairs_begin(pairs);
    fuzz_check(thrum_contact_pairs_step(pairs, members, 2, &error), &error);
  }
  thrum_contact_group group;
  const thrum_contact_links none = {NULL, 0};
  thrum_contact_pairs_begin(pairs);
  fuzz_check(thrum_contact_pairs_step_beside(pairs, pairs, 1, members, 2, &none, &group, &error),
             &error);
  thrum_contact_pairs_gather(pairs, &group, 1);

  // what they say, and others that go on from them
  const thrum_contact_pairs_report report = thrum_contact_pairs_report_get(pairs);
  const double said[] = {report.depth,  report.deepest, report.deepest_share, report.normal,
                         report.stored, report.lost,    report.driven};
  must_be_finite(said, sizeof said / sizeof said[0]);
  thrum_pair_touch touch;
  fuzz_check(thrum_contact_pairs_touch_get(pairs, draw_index(draw, 3), &touch, &error), &error);
  const size_t kept = thrum_contact_pairs_kept_bytes(pairs);
  void *copy = block(kept), *memory = block(size);
  memcpy(copy, pairs, kept);
  fuzz_check(thrum_contact_pairs_copy_check(pairs, copy, &error), &error);
  thrum_contact_pairs *next = NULL;
  if (thrum_contact_pairs_init(memory, size, def, &next, &error) >= 0)
    thrum_contact_pairs_continue(next, pairs);
  free(memory);
  free(copy);
  thrum_contact_pairs_reset(pairs);
}

static void use_pairs(const thrum_model *model, fuzz_draw *draw) {
  void *of_body = NULL, *of_solid = NULL, *memory = NULL;
  int32_t *faces = block(3 * (size_t)model->tet_count * sizeof *faces);
  touched one;
  thrum_error error = {0};
  size_t size = 0;
  const bool made = touched_make(model, draw, &one);
  thrum_skin *skin = made ? skin_of(model, faces, &of_body) : NULL;
  thrum_skin *triangle = solid_skin(draw, &of_solid);
  if (skin != NULL && triangle != NULL) {
    if (draw_byte(draw) % 2)
      thrum_skin_prepare_own(skin);
    const thrum_contact_solid rests = {.now = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}},
                                       .next = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0}},
                                       .friction = 0.5,
                                       .restitution = 0.5};
    thrum_contact_member members[2] = {{.model = model,
                                        .state = one.state,
                                        .contact = one.contact,
                                        .environment = &one.around,
                                        .skin = skin,
                                        .touches_itself = draw_byte(draw) % 2},
                                       {.skin = triangle, .solid = &rests, .number = 1}};
    thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
    thrum_contact_pairs *pairs = NULL;
    def.member_max = 2;
    def.vertex_max = thrum_skin_vertex_count(skin) + thrum_skin_vertex_count(triangle);
    def.node_max = thrum_skin_node_count(skin) + thrum_skin_node_count(triangle);
    def.rank_max = model->rank;
    def.touch_max = 64;
    def.thickness = thrum_skin_diagonal(skin) * 0.01;
    if (thrum_contact_pairs_size(&def, &size, &error) >= 0) {
      memory = block(size);
      if (thrum_contact_pairs_init(memory, size, &def, &pairs, &error) >= 0)
        step_pairs(pairs, &def, size, members, draw);
    }
  }
  touched_free(&one);
  free(memory);
  free(of_solid);
  free(of_body);
  free(faces);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static void (*const uses[])(const thrum_model *, fuzz_draw *) = {
      use_energy, use_model, use_condensed, use_loads, use_readouts,
      use_state,  use_rigid, use_contact,   use_pairs,
  };
  enum { USES = sizeof uses / sizeof uses[0] };
  if (size < PLAN_BYTES)
    return 0;
  fuzz_draw draw = {data, PLAN_BYTES};
  fuzz_opened opened = fuzz_open(data, size, &draw);
  const unsigned choice = draw_byte(&draw) % (USES + 1);
  if (choice == USES)
    use_names(&draw);
  else if (opened.model != NULL)
    uses[choice](opened.model, &draw);
  fuzz_close(&opened);
  return 0;
}
