/* Tests of contact that takes no energy, e = 1 without friction: the energy and the momenta of what
 * collides stay, of near-rigid bodies as of soft ones, over 10,000 collisions.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/touching_body.h"

#include "tests/support/sanitized.h"
#include "tests/support/scene_call.h"

#define SIDE 0.1

static int setup(void **context) {
  touching_body *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  f->mesh = body_make("beam:2x2x2@0.1x0.1x0.1,split=6", NULL);
  touching_body_make(f, 4, 8);
  *context = f;
  return 0;
}

/* Cubes that fly at each other at a speed, and spin. */
static thrum_scene *scene_of(const touching_body *f, int count, double young, double speed) {
  thrum_scene *scene = NULL;
  const double none[3] = {0};
  MUST(thrum_scene_create(1e-3, &scene, &failure));
  MUST(thrum_scene_set_gravity(scene, none, &failure));
  thrum_contact_pairs_def pairs = thrum_default_contact_pairs_def();
  pairs.friction = 0;
  pairs.restitution = 1;
  MUST(thrum_scene_set_collisions(scene, &pairs, &failure));
  for (int n = 0; n < count; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = &f->made.model;
    def.triangles = f->triangles;
    def.triangle_count = f->triangle_count;
    def.touch = f->touch;
    def.touch_count = f->made.model.vertex_count;
    def.stiffness = young / f->made.model.material[0];
    def.free = 1;
    def.position[0] = (count == 1 ? -0.5 : n == 0 ? -1.5 : 0.5) * SIDE; // the mesh begins at 0
    def.position[1] = 0.2 * n * SIDE;
    def.velocity[0] = (n == 0 ? 1.1 : -1) * speed;
    def.velocity[1] = 0.3 * speed;
    def.velocity[2] = 0.2 * speed;
    def.spin[0] = speed;
    def.spin[2] = 2 * speed;
    MUST(thrum_scene_add_body(scene, &def, NULL, &failure));
  }
  return scene;
}

static void add_room(thrum_scene *scene, double half) {
  thrum_obstacle room = thrum_default_obstacle();
  room.shape = THRUM_OBSTACLE_BOX;
  room.inside = 1;
  room.restitution = 1;
  room.friction = 0;
  room.half[0] = room.half[1] = room.half[2] = half;
  MUST(thrum_scene_add_obstacle(scene, &room, NULL, &failure));
}

static thrum_scene_account account_of(thrum_scene *scene) {
  thrum_scene_account account;
  MUST(thrum_scene_account_get(scene, &account, &failure));
  return account;
}

/* Impacts so far, and in *touching how many places touch. */
static int64_t struck(thrum_scene *scene, int count, int64_t *touching) {
  const thrum_contact_pairs_report between = thrum_scene_collisions(scene);
  int64_t sum = between.impacts;
  *touching = between.touching;
  for (int n = 0; n < count; n++) {
    thrum_scene_body_info info;
    MUST(thrum_scene_body(scene, n, &info, &failure));
    sum += info.contact.impacts;
    *touching += info.contact.touching;
  }
  return sum;
}

static void elastic_collisions_keep_the_energy(void **context) {
  static const struct {
    int bodies;
    double young, speed, half;
    int64_t collisions;
  } cases[] = {{1, 1e10, 10, 0.13, 10000},
               {2, 1e10, 10, 0.2, 2000},
               {1, 1e6, 2, 0.13, 250},
               {2, 1e6, 2, 0.2, 250},
               {2, 1e8, 2, 0.2, 300}};
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    const int count = cases[n].bodies;
    thrum_scene *scene = scene_of(*context, count, cases[n].young, cases[n].speed);
    add_room(scene, cases[n].half);
    const double began = account_of(scene).total;

    // an impact, or the begin of a touch, is a collision
    int64_t collisions = 0, touches = 0, touching = 0, steps = 0;
    while (collisions < LENGTH_OF_RUN(cases[n].collisions, 100) && steps < 100000) {
      const bool was = touching > 0;
      MUST(thrum_scene_step(scene, &failure));
      const int64_t impacts = struck(scene, count, &touching);
      touches += !was && touching > 0;
      collisions = impacts + touches;
      steps++;
    }

    // what waits to be given back counts, and is little
    const thrum_scene_account account = account_of(scene);
    print_message("%d cubes of %.0e Pa at %g m/s: %lld collisions in %lld steps, energy off %.1e\n",
                  count, cases[n].young, cases[n].speed, (long long)collisions, (long long)steps,
                  account.total / began - 1);
    assert_true(collisions >= LENGTH_OF_RUN(cases[n].collisions, 100));
    assert_true(fabs(account.total / began - 1) <= 1e-9);
    assert_true(fabs(account.contact) <= 0.5 * began);
    thrum_scene_destroy(scene);
  }
}

static void momenta_stay_while_what_collides_gives_back(void **context) {
  static const double youngs[] = {1e6, 1e8, 1e10};
  for (int n = 0; n < 3; n++) {
    thrum_scene *scene = scene_of(*context, 2, youngs[n], 2);
    const thrum_scene_account began = account_of(scene);

    // they meet within a twentieth of a second
    int64_t touching, most = 0;
    for (int step = 0; step < 200; step++) {
      MUST(thrum_scene_step(scene, &failure));
      most += struck(scene, 2, &touching) + touching > 0;
    }

    // against the momentum of one of them, and that about a side
    const thrum_scene_account account = account_of(scene);
    const double size = 2 * 1e-3 * (*(touching_body **)context)->made.model.material[2];
    double off = 0, turned = 0;
    for (int axis = 0; axis < 3; axis++) {
      off = fmax(off, fabs(account.momentum[axis] - began.momentum[axis]));
      turned = fmax(turned, fabs(account.angular_momentum[axis] - began.angular_momentum[axis]));
    }
    print_message("%.0e Pa: momentum off %.1e, angular %.1e, energy %.1e of it\n", youngs[n],
                  off / size, turned / (size * SIDE), account.total / began.total - 1);
    assert_true(most > 0);
    assert_true(off <= 1e-9 * size);
    assert_true(turned <= 1e-9 * size * SIDE);
    assert_true(fabs(account.total / began.total - 1) <= 1e-9);
    thrum_scene_destroy(scene);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(elastic_collisions_keep_the_energy),
      cmocka_unit_test(momenta_stay_while_what_collides_gives_back),
  };
  return cmocka_run_group_tests(tests, setup, touching_body_teardown);
}
