/* Tests of bodies that come to rest: what holds a body up is its own elasticity, whatever the time
 * step is, the forces on it are its weight, and it is still; on a slope below the angle of friction
 * too.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/touching_body.h"

#include "tests/support/sanitized.h"
#include "tests/support/scene_call.h"

static const thrum_scene_thing anything = {THRUM_SCENE_ANYTHING, 0};

#define GRAVITY 9.81
#define RADIUS 0.5

/* The cube of the mesh becomes a ball: a point goes out until the sphere has its distance from the
 * cube's. */
static void round_off(body *cube) {
  double *x = cube->mesh.vertices;
  for (int64_t v = 0; v < cube->mesh.vertex_count; v++, x += 3) {
    double most = 0, square = 0;
    x[0] -= RADIUS; // the other two are about the middle
    for (int axis = 0; axis < 3; axis++) {
      most = fmax(most, fabs(x[axis]));
      square += x[axis] * x[axis];
    }
    for (int axis = 0; axis < 3 && square > 0; axis++)
      x[axis] *= most / sqrt(square);
  }
}

static int setup(void **context) {
  touching_body *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->mesh = body_make("beam:5x5x5@1x1x1,split=6", NULL);
  round_off(&f->mesh);
  touching_body_make(f, 8, 16);
  *context = f;
  return 0;
}

/* What a ball is laid on. */
typedef enum ground { PLANE, SOLID, SLAB } ground;

/* How it lies in the end. */
typedef struct rest {
  double middle;   /* height of its middle above what it touches [m] */
  double force;    /* mean of the contact over the last half second, in weights */
  double speed;    /* largest of the middle in that time [m/s] */
  double depth;    /* of what touches [m] */
  double distance; /* least, that contact with a solid keeps [m] */
  int64_t impacts; /* of the body as a whole */
} rest;

/* Adds a plane or a box with its face at z = 0; nothing of it rubs. */
static void add_ground(thrum_scene *scene, ground on) {
  thrum_obstacle plane = thrum_default_obstacle();
  thrum_scene_solid_def solid = thrum_default_scene_solid_def();
  const thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  plane.friction = solid.friction = 0;
  solid.half[0] = solid.half[1] = 2;
  solid.position[2] = -0.5;
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));
  if (on == PLANE)
    MUST(thrum_scene_add_obstacle(scene, &plane, NULL, &failure));
  else if (on == SOLID)
    MUST(thrum_scene_add_solid(scene, &solid, NULL, &failure));
}

/* The factor of stiffness by which rho g D / E is `softness`. */
static double factor_of(const touching_body *f, double softness) {
  const double *material = f->made.model.material;
  return material[2] * GRAVITY * 2 * RADIUS / (softness * material[0]);
}

/* Lays a ball 1 mm above the ground, and looks at it after 4 s. slab: that it is. */
static rest lie(const touching_body *f, ground on, const thrum_scene_body_def *slab,
                double softness, double dt) {
  thrum_scene *scene = NULL;
  const double gravity[3] = {0, 0, -GRAVITY};
  MUST(thrum_scene_create(dt, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  add_ground(scene, on);

  // the ball, of which all vibration dies out within the time
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.touch = f->touch;
  def.touch_count = f->made.model.vertex_count;
  def.free = 1;
  def.position[2] = RADIUS + 0.001;
  def.stiffness = factor_of(f, softness);
  def.state.damping_alpha = 60;
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  MUST(thrum_scene_add_probe(scene, NULL, 0, NULL, 0, &failure));
  if (on == SLAB)
    MUST(thrum_scene_add_body(scene, slab, NULL, &failure));

  // most of the time it lies down
  rest r = {0};
  thrum_scene_body_info info;
  const int count = (int)(4 / dt), last = (int)(0.5 / dt);
  double x[3], v[3];
  for (int n = 0; n < count; n++) {
    MUST(thrum_scene_step(scene, &failure));
    if (n < count - last)
      continue;
    MUST(thrum_scene_body(scene, 0, &info, &failure));
    MUST(thrum_scene_probe_get(scene, 0, x, v, &failure));
    const thrum_contact_pairs_report between = thrum_scene_collisions(scene);
    r.force += (info.contact.normal + between.normal) / (last * info.mass * GRAVITY);
    r.speed = fmax(r.speed, sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    r.depth = fmax(info.contact.depth, between.depth);
    r.distance = on != PLANE ? between.distance + between.depth : 0;
    r.impacts = info.contact.impacts + between.impacts;
  }
  r.middle = x[2] - r.distance;
  thrum_scene_destroy(scene);
  return r;
}

/* The places that may bear: those of the lowest tenth of the ball. */
enum { LOWEST = 60 };

/* The height of the middle of a ball that lies in equilibrium on a smooth plane, as linear
 * elasticity in the basis has it: gaps and forces are not below 0, one of both is 0 at each place,
 * and the forces add up to the weight. Gauss-Seidel over the places, with the height by bisection;
 * the ball does not turn. */
static double height_in_equilibrium(const touching_body *f, double softness) {
  const thrum_model *m = &f->made.model;
  int64_t places[LOWEST], count = 0;
  double compliance[LOWEST][LOWEST], force[LOWEST] = {0}, sum = 0;
  for (int64_t v = 0; v < m->vertex_count; v++)
    if (m->vertices[3 * v + 2] < -0.8 * RADIUS && count < LOWEST)
      places[count++] = v;
  assert_in_range(count, 4, LOWEST - 1);

  // how they give way to each other
  for (int64_t a = 0; a < count; a++)
    for (int64_t b = 0; b < count; b++) {
      const double *first = m->basis + (3 * places[a] + 2) * m->rank;
      const double *second = m->basis + (3 * places[b] + 2) * m->rank;
      compliance[a][b] = 0;
      for (int64_t i = 0; i < m->rank; i++)
        compliance[a][b] += first[i] * second[i] / (m->omega2[i] * factor_of(f, softness));
    }

  // the lower the middle, the larger the force
  double low = 0.5 * RADIUS, high = RADIUS;
  for (int n = 0; n < 40; n++) {
    const double middle = 0.5 * (low + high);
    for (int sweep = 0; sweep < 400; sweep++)
      for (int64_t a = 0; a < count; a++) {
        double gap = middle + m->vertices[3 * places[a] + 2];
        for (int64_t b = 0; b < count; b++)
          gap += compliance[a][b] * force[b];
        force[a] = fmax(force[a] - gap / compliance[a][a], 0);
      }
    sum = 0;
    for (int64_t a = 0; a < count; a++)
      sum += force[a];
    if (sum > f->made.mass * GRAVITY)
      low = middle;
    else
      high = middle;
  }

  // of the mean of all vertices, which the probe follows
  double mean = 0;
  for (int64_t v = 0; v < m->vertex_count; v++)
    for (int64_t i = 0; i < m->rank; i++)
      for (int64_t a = 0; a < count; a++)
        mean += m->basis[(3 * v + 2) * m->rank + i] * m->basis[(3 * places[a] + 2) * m->rank + i] *
                force[a] / (m->omega2[i] * factor_of(f, softness) * (double)m->vertex_count);
  return low + mean;
}

/* What holds a soft ball up is its contact alone: at any step and on either ground it sinks in by
 * the same, the forces are its weight, and it is still. */
static void a_soft_ball_rests_at_the_same_height_at_any_step(void **context) {
  static const double steps[] = {0.001, 0.002, 0.004};
  const touching_body *f = *context;
  const double hard = lie(f, PLANE, NULL, 1e-4, 0.002).middle,
               soft = lie(f, PLANE, NULL, 0.07, 0.0005).middle;
  for (int on = PLANE; on <= SOLID; on++)
    for (int n = 0; n < LENGTH_OF_RUN(3, 1); n++) {
      const rest r = lie(f, (ground)on, NULL, 0.07, steps[n]);
      print_message("%s, h = %g: sags by %.6f m, bears %.7f of the weight, %.1e m/s, %.1e m deep\n",
                    on == PLANE ? "plane" : "solid", steps[n], hard - r.middle, r.force, r.speed,
                    r.depth);
      assert_close(hard - r.middle, hard - soft, 1e-4);
      assert_true(fabs(r.force - 1) < 1e-5);
      assert_true(r.speed < 1e-6);
      assert_true(r.depth < 0.02 * (hard - soft));

      // it is not struck as a whole as it lies down
      assert_int_equal(r.impacts, 0);
    }
}

/* How far it sinks in is what linear elasticity says of small deformation. */
static void a_ball_rests_in_its_equilibrium(void **context) {
  const touching_body *f = *context;
  const double hard = height_in_equilibrium(f, 1e-4), soft = height_in_equilibrium(f, 0.01);
  for (int on = PLANE; on <= SOLID; on++) {
    const double found = hard - lie(f, (ground)on, NULL, 0.01, 0.002).middle;
    print_message("%s: sags by %.6f m, in equilibrium by %.6f m\n", on == PLANE ? "plane" : "solid",
                  found, hard - soft);
    assert_close(found, hard - soft, 0.03);
  }
}

/* Adds a ball of the fixture at a height, so stiff that it bounces as a whole. */
static void add_stiff(thrum_scene *scene, const touching_body *f, double height) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &f->made.model;
  def.triangles = f->triangles;
  def.triangle_count = f->triangle_count;
  def.touch = f->touch;
  def.touch_count = f->made.model.vertex_count;
  def.free = 1;
  def.position[2] = height;
  def.stiffness = factor_of(f, 1e-4);
  def.state.damping_alpha = 60;
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
}

/* Newton's laws of what is said of contact: over any time the forces on a body add up to the change
 * of its momentum less that by its weight, impacts included, and what two do to each other is
 * opposite. Two balls fall, bounce and lie, one on the other. */
static void forces_of_contact_are_the_change_of_momentum(void **context) {
  const touching_body *f = *context;
  for (int on = PLANE; on <= SOLID; on++) {
    thrum_scene *scene = NULL;
    const double gravity[3] = {0, 0, -GRAVITY}, dt = 0.004;
    MUST(thrum_scene_create(dt, &scene, &failure));
    MUST(thrum_scene_set_gravity(scene, gravity, &failure));
    add_ground(scene, (ground)on);
    add_stiff(scene, f, RADIUS + 0.05);
    add_stiff(scene, f, 3 * RADIUS + 0.1);
    const thrum_scene_thing from = {on == PLANE ? THRUM_SCENE_OBSTACLE : THRUM_SCENE_SOLID, 0};

    double sum[3] = {0}, between = 0;
    const int steps = LENGTH_OF_RUN(500, 100);
    int64_t impacts = 0;
    for (int n = 0; n < steps; n++) {
      double all[2][3], down[3], other[2][3];
      MUST(thrum_scene_step(scene, &failure));
      for (int32_t ball = 0; ball < 2; ball++) {
        MUST(thrum_scene_contact_force(scene, ball, anything, all[ball], &failure));
        MUST(thrum_scene_contact_force(
            scene, ball, ((thrum_scene_thing){THRUM_SCENE_BODY, 1 - ball}), other[ball], &failure));
      }
      MUST(thrum_scene_contact_force(scene, 0, from, down, &failure));

      // what one does to the other is opposite, and all is the sum of its parts
      for (int axis = 0; axis < 3; axis++) {
        assert_true(other[0][axis] == -other[1][axis] && all[1][axis] == other[1][axis]);
        assert_close(all[0][axis], other[0][axis] + down[axis], 1e-12);
        sum[axis] += dt * (all[0][axis] + all[1][axis]);
      }
      between = fmax(between, other[1][2]);
    }

    // both together
    thrum_scene_account account;
    thrum_scene_body_info info;
    MUST(thrum_scene_account_get(scene, &account, &failure));
    MUST(thrum_scene_body(scene, 0, &info, &failure));
    impacts = info.contact.impacts + thrum_scene_collisions(scene).impacts;
    const double weight = 2 * info.mass * GRAVITY * dt * steps;
    assert_true(impacts > 0 && between > 0);
    assert_true(fabs(account.momentum[0] - sum[0]) < 1e-10 * weight);
    assert_true(fabs(account.momentum[1] - sum[1]) < 1e-10 * weight);
    assert_true(fabs(account.momentum[2] - sum[2] + weight) < 1e-10 * weight);
    thrum_scene_destroy(scene);
  }
}

static void a_force_of_nothing_in_the_scene_is_refused(void **context) {
  const touching_body *f = *context;
  thrum_scene *scene = NULL;
  double force[3] = {1, 2, 3};
  static const thrum_scene_thing wrong[] = {{THRUM_SCENE_BODY, 1},
                                            {THRUM_SCENE_BODY, -2},
                                            {THRUM_SCENE_SOLID, 0},
                                            {THRUM_SCENE_OBSTACLE, 1}};
  MUST(thrum_scene_create(0.002, &scene, &failure));
  add_ground(scene, PLANE);
  add_stiff(scene, f, 2);
  for (int n = 0; n < 4; n++)
    assert_int_equal(thrum_scene_contact_force(scene, 0, wrong[n], force, &failure),
                     THRUM_INVALID_ARGUMENT);
  assert_true(thrum_scene_contact_force(scene, 1, anything, force, &failure) < 0);
  assert_true(force[0] == 1 && force[1] == 2 && force[2] == 3);

  // nothing touches before the first step
  MUST(thrum_scene_contact_force(scene, 0, anything, force, &failure));
  assert_true(force[0] == 0 && force[1] == 0 && force[2] == 0);
  thrum_scene_destroy(scene);
}

/* --- a slope ---------------------------------------------------------------------------------- */

#define SIDE 0.1
#define ROUGH 0.2

/* A body with what a scene asks for. */
typedef struct shape {
  body mesh;
  thrum_precomputed made;
  int32_t *triangles, *touch;
  int64_t triangle_count;
} shape;

static shape shape_make(const char *name, const char *fix) {
  shape s = {.mesh = body_make(name, fix)};
  s.made = body_precompute(&s.mesh, 4, 8);
  s.triangles = outer_triangles(&s.mesh.mesh, &s.triangle_count);
  s.touch = need((size_t)s.made.model.vertex_count, sizeof *s.touch);
  for (int64_t v = 0; v < s.made.model.vertex_count; v++)
    s.touch[v] = (int32_t)v;
  return s;
}

static void shape_free(shape *s) {
  thrum_precomputed_free(&s->made);
  body_free(&s->mesh);
  free(s->triangles);
  free(s->touch);
}

/* A body of a shape with this Young's modulus. */
static thrum_scene_body_def def_of(const shape *s, double young) {
  thrum_scene_body_def def = thrum_default_scene_body_def();
  def.model = &s->made.model;
  def.triangles = s->triangles;
  def.triangle_count = s->triangle_count;
  def.touch = s->touch;
  def.touch_count = s->made.model.vertex_count;
  def.stiffness = young / s->made.model.material[0];
  return def;
}

/* What a cube lies on; the slab deforms. */
enum { ON_PLANE, ON_SOLID, ON_SLAB, GROUNDS };

/* On a slab that gives way as much as the ball does, it lies as deep at any step too. */
static void a_soft_ball_sinks_into_a_soft_slab_by_the_same_at_any_step(void **context) {
  const touching_body *f = *context;
  static const double steps[] = {0.0005, 0.001, 0.002, 0.004};
  shape under = shape_make("beam:4x4x2@1.6x1.6x0.4,split=6", "z<-0.199");
  thrum_scene_body_def def = def_of(&under, f->made.model.material[0] * factor_of(f, 0.07));
  def.position[0] = -0.8;
  def.position[2] = -0.2;
  def.state.damping_alpha = 60;

  // what both give together
  double sags[4];
  for (int n = 0; n < LENGTH_OF_RUN(4, 2); n++) {
    const rest r = lie(f, SLAB, &def, 0.07, steps[n]);
    sags[n] = RADIUS - r.middle;
    print_message("slab, h = %g: sags by %.6f m, bears %.7f of the weight, %.1e m/s\n", steps[n],
                  sags[n], r.force, r.speed);
    assert_close(sags[n], sags[0], 6e-3);
    assert_true(fabs(r.force - 1) < 5e-3); // normals lean, and friction bears the rest
    assert_true(r.speed < 1e-4);
  }
  shape_free(&under);
}

/* Adds ground with its face at z = 0; the slab is of 0.1 GPa. */
static void add_face(thrum_scene *scene, const shape *slab, int on, double damping) {
  thrum_obstacle plane = thrum_default_obstacle();
  thrum_scene_solid_def solid = thrum_default_scene_solid_def();
  thrum_scene_body_def def = def_of(slab, 1e8);
  plane.friction = solid.friction = ROUGH;
  solid.half[0] = solid.half[1] = 2;
  solid.position[2] = -0.5;
  def.position[0] = -0.4;
  def.position[2] = -0.5 * SIDE;
  def.state.damping_alpha = damping;
  if (on == ON_PLANE)
    MUST(thrum_scene_add_obstacle(scene, &plane, NULL, &failure));
  else if (on == ON_SOLID)
    MUST(thrum_scene_add_solid(scene, &solid, NULL, &failure));
  else
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
}

/* Lays a cube of 10 MPa on ground of which the slope is `share` of the coefficient of friction.
 * where: its way in x at the start, after the second third and at the end of 0.6 s [m]. */
static void slide(const shape *cube, const shape *slab, int on, double share, double dt,
                  double where[3]) {
  const double angle = atan(share * ROUGH);
  const double gravity[3] = {GRAVITY * sin(angle), 0, -GRAVITY * cos(angle)};
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(dt, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  pairs.friction = ROUGH;
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));

  // 0.01 mm above the distance that contact keeps
  const double gap = on == ON_PLANE ? 1e-5 : 1e-5 + SIDE * sqrt(3) / 250;
  thrum_scene_body_def def = def_of(cube, 1e7);
  def.free = 1;
  def.position[0] = -0.2;
  def.position[2] = 0.5 * SIDE + gap;
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  MUST(thrum_scene_add_probe(scene, NULL, 0, NULL, 0, &failure));

  add_face(scene, slab, on, 0);

  // three parts of 0.2 s
  double x[3];
  MUST(thrum_scene_probe_get(scene, 0, x, NULL, &failure));
  const double start = x[0];
  for (int n = 0; n < 3; n++) {
    for (int k = 0; k < (int)(0.2 / dt + 0.5); k++)
      MUST(thrum_scene_step(scene, &failure));
    MUST(thrum_scene_probe_get(scene, 0, x, NULL, &failure));
    where[n] = x[0] - start;
  }
  thrum_scene_destroy(scene);
}

/* Coulomb: below the angle of friction a cube that is laid down stays within a millimetre, above it
 * slides by g (sin a - mu cos a), on a plane, on a solid and on a slab that deforms. */
static void a_cube_slides_above_the_angle_of_friction_alone(void **context) {
  (void)context;
  shape cube = shape_make("beam:2x2x2@0.1x0.1x0.1,split=6", NULL);
  shape slab = shape_make("beam:6x6x1@0.8x0.8x0.1,split=6", "z<-0.049");
  for (int on = 0; on < GROUNDS; on++) {
    double where[3];
    slide(&cube, &slab, on, 0.95, 0.002, where);
    print_message("%d: slides by %.3f mm below the angle", on, 1e3 * where[2]);
    const bool stays = fabs(where[2]) < 1e-4 && fabs(where[2] - where[1]) < 1e-5;
    slide(&cube, &slab, on, 1.05, 0.002, where);
    const double angle = atan(1.05 * ROUGH);
    const double found = (where[2] - 2 * where[1] + where[0]) / (0.2 * 0.2);
    print_message(", with %.5f of the acceleration above it\n",
                  found / (GRAVITY * (sin(angle) - ROUGH * cos(angle))));
    assert_true(stays);
    assert_close(found, GRAVITY * (sin(angle) - ROUGH * cos(angle)), 1e-3);
  }
  shape_free(&cube);
  shape_free(&slab);
}

/* The largest speed of a cube in the last of 4 s after it was laid down from 0.1 mm, as the mean of
 * all vertices [m/s]; *share: the mean force of contact in that time, in weights. */
static double speed_at_rest(const shape *cube, const shape *slab, int on, double young,
                            double *share) {
  const double gravity[3] = {0, 0, -GRAVITY}, dt = 0.001;
  const int64_t vertices = cube->made.model.vertex_count;
  thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(dt, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  pairs.friction = ROUGH;
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));

  // all is damped by 2 1/s
  const double gap = on == ON_PLANE ? 1e-4 : 1e-4 + SIDE * sqrt(3) / 250;
  thrum_scene_body_def def = def_of(cube, young);
  def.free = 1;
  def.position[0] = -0.2;
  def.position[2] = 0.5 * SIDE + gap;
  def.state.damping_alpha = 2;
  MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  add_face(scene, slab, on, 2);

  double most = 0;
  thrum_scene_body_info info;
  *share = 0;
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  for (int n = 0; n < 4000; n++) {
    double x[3], v[3], force[3], sum = 0;
    MUST(thrum_scene_step(scene, &failure));
    if (n < 3000)
      continue;
    for (int64_t k = 0; k < vertices; k++) {
      MUST(thrum_scene_body_vertex(scene, 0, k, x, v, &failure));
      sum += sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / (double)vertices;
    }
    most = fmax(most, sum);
    MUST(thrum_scene_contact_force(scene, 0, anything, force, &failure));
    *share += force[2] / (1000 * info.mass * GRAVITY);
  }
  thrum_scene_destroy(scene);
  return most;
}

/* Coordinates that a step cannot follow come to rest with the body, on what deforms too, and it
 * bears its weight. */
static void what_is_laid_down_lies_still(void **context) {
  (void)context;
  shape cube = shape_make("beam:2x2x2@0.1x0.1x0.1,split=6", NULL);
  shape slab = shape_make("beam:6x6x1@0.8x0.8x0.1,split=6", "z<-0.049");
  for (int on = 0; on < GROUNDS; on++)
    for (int n = 0; n < LENGTH_OF_RUN(2, 1); n++) {
      double share;
      const double speed = speed_at_rest(&cube, &slab, on, n ? 1e8 : 1e9, &share);
      print_message("%d: %.1e m/s, bears %.7f of the weight\n", on, speed, share);
      assert_true(speed < 1e-4);
      assert_close(share, 1, 1e-4);
    }
  shape_free(&cube);
  shape_free(&slab);
}

/* Bodies that lie on each other approach by what a solve leaves, which is no impact: in the end
 * none is struck, and each bears what is above it. */
static void a_stack_at_rest_is_struck_no_more(void **context) {
  (void)context;
  enum { COUNT = 3, STEPS = 2000, LAST = 250 };
  const double gravity[3] = {0, 0, -GRAVITY}, gap = 1e-5 + SIDE * sqrt(3) / 250;
  const thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  const thrum_obstacle plane = thrum_default_obstacle();
  shape cube = shape_make("beam:2x2x2@0.1x0.1x0.1,split=6", NULL);
  thrum_scene *scene = NULL;
  MUST(thrum_scene_create(0.002, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, gravity, &failure));
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));
  MUST(thrum_scene_add_obstacle(scene, &plane, NULL, &failure));
  for (int n = 0; n < COUNT; n++) {
    thrum_scene_body_def def = def_of(&cube, 1e7);
    def.free = 1;
    def.position[2] = 0.5 * SIDE + n * (SIDE + gap);
    def.state.damping_alpha = 20;
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }

  // what strikes after most of the time, and the mean force from below
  int64_t before = 0;
  double borne[COUNT] = {0};
  thrum_scene_body_info info;
  for (int n = 0; n < STEPS; n++) {
    MUST(thrum_scene_step(scene, &failure));
    if (n == STEPS - LAST - 1)
      before = thrum_scene_collisions(scene).impacts;
    for (int32_t b = 0; b < COUNT && n >= STEPS - LAST; b++) {
      double force[3];
      const thrum_scene_thing below = {b > 0 ? THRUM_SCENE_BODY : THRUM_SCENE_OBSTACLE,
                                       b > 0 ? b - 1 : 0};
      MUST(thrum_scene_contact_force(scene, b, below, force, &failure));
      borne[b] += force[2] / LAST;
    }
  }
  MUST(thrum_scene_body(scene, 0, &info, &failure));
  for (int b = 0; b < COUNT; b++) {
    print_message("cube %d bears %.6f weights\n", b, borne[b] / (info.mass * GRAVITY));
    assert_close(borne[b], (COUNT - b) * info.mass * GRAVITY, 1e-5);
  }
  assert_int_equal(thrum_scene_collisions(scene).impacts, before);
  thrum_scene_destroy(scene);
  shape_free(&cube);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_soft_ball_rests_at_the_same_height_at_any_step),
      cmocka_unit_test(a_ball_rests_in_its_equilibrium),
      cmocka_unit_test(a_soft_ball_sinks_into_a_soft_slab_by_the_same_at_any_step),
      cmocka_unit_test(forces_of_contact_are_the_change_of_momentum),
      cmocka_unit_test(a_force_of_nothing_in_the_scene_is_refused),
      cmocka_unit_test(a_cube_slides_above_the_angle_of_friction_alone),
      cmocka_unit_test(what_is_laid_down_lies_still),
      cmocka_unit_test(a_stack_at_rest_is_struck_no_more),
  };
  return cmocka_run_group_tests(tests, setup, touching_body_teardown);
}
