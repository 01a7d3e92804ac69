/* Many threads share one model: each steps states of its own and gets the bits of a run alone.
 * Under a thread sanitizer this also shows that no call writes to the model or to a global.
 * SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

#include <pthread.h>
#include <stdbool.h>

#include "thrum/contact_pairs.h"

enum { RANK = 8, LOW = 3, THREADS = 4, STEPS = 300, INTEGRATORS = 5 };

typedef struct worker {
  const thrum_model *model; /* shared */
  uint64_t seed;
  thrum_state *states[INTEGRATORS]; /* its own */
  bool stepped;
} worker;

static bool step_all(const worker *w) {
  double f[RANK], q[RANK], p[RANK];
  thrum_energies energies;

  // the seed gives the loads, so a run alone can have the same ones
  random_state random = {w->seed};
  for (int k = 0; k < STEPS; k++) {
    random_vector(&random, RANK, 0.5, f);
    for (int n = 0; n < INTEGRATORS; n++) {
      thrum_state *state = w->states[n];
      if (thrum_state_set_force(w->model, state, f, NULL) != THRUM_OK ||
          thrum_step(w->model, state, NULL) < 0 ||
          thrum_state_get(w->model, state, q, p, NULL) != THRUM_OK ||
          thrum_state_energies(w->model, state, &energies, NULL) != THRUM_OK)
        return false;
    }
  }
  return true;
}

static void *run(void *context) {
  worker *w = context;
  w->stepped = step_all(w);
  return NULL;
}

static worker make_worker(const thrum_model *model, int number) {
  worker w = {.model = model, .seed = 100 + (uint64_t)number};
  for (int n = 0; n < INTEGRATORS; n++) {
    thrum_state_def def = imexv_def();
    def.integrator = (thrum_integrator)n;
    def.dt = 0.02 + 0.005 * number;
    def.split_rule = THRUM_SPLIT_COUNT;
    def.explicit_count = LOW;
    def.damping_alpha = 0.1;
    def.damping_beta = 0.002;
    def.damping_form = number % 2 == 0 ? THRUM_DAMPING_REST : THRUM_DAMPING_TANGENT;
    w.states[n] = state_make(model, &def);
  }
  return w;
}

static void threads_that_share_a_model_step_to_the_bits_of_a_run_alone(void **context) {
  (void)context;
  random_model m;
  worker together[THREADS], alone;
  pthread_t threads[THREADS];
  random_model_make(&m, 31, RANK, 1.0, 20.0, 0.5);

  // each thread has states of its own, all of one model
  for (int t = 0; t < THREADS; t++)
    together[t] = make_worker(&m.model, t);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_create(&threads[t], NULL, run, &together[t]), 0);
  for (int t = 0; t < THREADS; t++)
    assert_int_equal(pthread_join(threads[t], NULL), 0);

  // the same states stepped alone have the same bytes
  for (int t = 0; t < THREADS; t++) {
    alone = make_worker(&m.model, t);
    assert_true(step_all(&alone) && together[t].stepped);
    for (int n = 0; n < INTEGRATORS; n++) {
      assert_int_equal(thrum_state_report_get(alone.states[n]).steps, STEPS);
      assert_memory_equal(together[t].states[n], alone.states[n],
                          thrum_state_kept_bytes(alone.states[n]));

      state_free(together[t].states[n]);
      state_free(alone.states[n]);
    }
  }
  random_model_free(&m);
}

/* Scratch of a thread, and the states that are its turn. */
typedef struct shift {
  const thrum_model *model;
  thrum_state **states;
  void *scratch;
  size_t size;
  int first;
  bool stepped;
} shift;

/* Steps every other state with the scratch of this thread. */
static void *run_shift(void *context) {
  shift *s = context;
  s->stepped = true;
  for (int n = s->first; n < 2 * THREADS; n += 2) {
    s->stepped =
        s->stepped && thrum_state_lend(s->states[n], s->scratch, s->size, NULL) == THRUM_OK;
    for (int k = 0; k < 20; k++)
      s->stepped = s->stepped && thrum_step(s->model, s->states[n], NULL) >= 0;
  }
  return NULL;
}

/* States that borrow scratch are stepped by the one thread and then by the other, each with its
 * own. */
static void threads_lend_their_scratch_to_the_states_that_they_step(void **context) {
  (void)context;
  random_model m;
  random_model_make(&m, 31, RANK, 1.0, 20.0, 0.5);
  thrum_state *states[2 * THREADS], *alone[2 * THREADS];
  thrum_state_def def = imexv_def();
  def.dt = 0.02;
  size_t size;
  assert_int_equal(thrum_state_scratch_size(&m.model, &def, &size, NULL), THRUM_OK);
  shift shifts[2];
  for (int t = 0; t < 2; t++) {
    shifts[t] = (shift){.model = &m.model, .states = states, .size = size};
    shifts[t].scratch = aligned_alloc(64, size);
    assert_non_null(shifts[t].scratch);
  }

  // every state has a start of its own
  for (int n = 0; n < 2 * THREADS; n++) {
    random_state random = {(uint64_t)n + 1};
    double p[RANK];
    random_vector(&random, RANK, 1.0, p);
    def.borrows_scratch = 0;
    alone[n] = state_make(&m.model, &def);
    def.borrows_scratch = 1;
    states[n] = state_make(&m.model, &def);
    assert_int_equal(thrum_state_lend(states[n], shifts[0].scratch, size, NULL), THRUM_OK);
    state_put(&m.model, states[n], NULL, p);
    state_put(&m.model, alone[n], NULL, p);
    state_steps(&m.model, alone[n], 20 * 4);
  }

  for (int round = 0; round < 4; round++) {
    pthread_t threads[2];
    for (int t = 0; t < 2; t++) {
      shifts[t].first = (t + round) % 2;
      assert_int_equal(pthread_create(&threads[t], NULL, run_shift, &shifts[t]), 0);
    }
    for (int t = 0; t < 2; t++) {
      assert_int_equal(pthread_join(threads[t], NULL), 0);
      assert_true(shifts[t].stepped);
    }
  }

  for (int n = 0; n < 2 * THREADS; n++) {
    double q[2][RANK];
    state_read(&m.model, states[n], q[0], NULL);
    state_read(&m.model, alone[n], q[1], NULL);
    assert_memory_equal(q[0], q[1], sizeof q[0]);
    state_free(states[n]);
    state_free(alone[n]);
  }
  for (int t = 0; t < 2; t++)
    free(shifts[t].scratch);
  random_model_free(&m);
}

/* --- groups of bodies that touch -------------------------------------------------------------- */

enum { GROUPS = 2, FALLS = 60 };

/* A cube, as the surface of a body and of the solid under it. */
static const double cube[24] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0,
                                0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};
static const int32_t cube_faces[36] = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                       2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};

/* Cubes that fall, each on a solid of its own, and the rooms in which they step. */
typedef struct falls {
  rig bodies[GROUPS];
  thrum_skin *skins[GROUPS], *solid_skin;
  thrum_contact_solid solids[GROUPS];
  thrum_contact_pairs *rooms[GROUPS];
  thrum_contact_member members[GROUPS][2];
  thrum_contact_group groups[GROUPS];
} falls;

/* A group that a thread steps. */
typedef struct fall {
  falls *of;
  int group, room;
  thrum_status status;
} fall;

static void *room_of(size_t size) {
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(memory);
  return memory;
}

static void add_fall(falls *f, int n) {
  static const thrum_placement still = {.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}, .origin = {0, 0, -1}};
  rig_def def = rig_default();
  size_t size = 0;
  def.shape = 0.01;
  rig *body = f->bodies + n;
  rig_make(body, &def);
  memcpy(body->m.vertices, cube, sizeof cube);
  body->environment.obstacle_count = 0;
  body->translation.position[2] = 0.02;
  body->translation.velocity[2] = -1 - 0.02 * n;
  assert_int_equal(thrum_skin_size(&body->m.model, cube_faces, 12, &size, NULL), THRUM_OK);
  assert_int_equal(
      thrum_skin_init(room_of(size), size, &body->m.model, cube_faces, 12, f->skins + n, NULL),
      THRUM_OK);

  // the cube and its solid are a group
  f->solids[n] = (thrum_contact_solid){.now = still, .next = still, .restitution = 0.5};
  f->members[n][0] = (thrum_contact_member){.model = &body->m.model,
                                            .state = body->state,
                                            .contact = body->contact,
                                            .environment = &body->environment,
                                            .skin = f->skins[n],
                                            .number = n};
  f->members[n][1] =
      (thrum_contact_member){.skin = f->solid_skin, .solid = f->solids + n, .number = GROUPS + n};
}

static void make_falls(falls *f) {
  size_t size = 0;
  assert_int_equal(thrum_skin_solid_size(cube, 8, cube_faces, 12, &size, NULL), THRUM_OK);
  assert_int_equal(
      thrum_skin_solid_init(room_of(size), size, cube, 8, cube_faces, 12, &f->solid_skin, NULL),
      THRUM_OK);
  for (int n = 0; n < GROUPS; n++)
    add_fall(f, n);

  // room for one group and its solid, once for each thread
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  def.member_max = 2;
  def.vertex_max = 16;
  def.node_max = thrum_skin_node_count(f->skins[0]) + thrum_skin_node_count(f->solid_skin);
  def.rank_max = RIG_RANK;
  def.touch_max = 64;
  assert_int_equal(thrum_contact_pairs_size(&def, &size, NULL), THRUM_OK);
  for (int n = 0; n < GROUPS; n++)
    assert_int_equal(thrum_contact_pairs_init(room_of(size), size, &def, f->rooms + n, NULL),
                     THRUM_OK);
}

static void free_falls(falls *f) {
  for (int n = 0; n < GROUPS; n++) {
    rig_free(f->bodies + n);
    free(f->skins[n]);
    free(f->rooms[n]);
  }
  free(f->solid_skin);
}

static void *step_fall(void *context) {
  fall *own = context;
  falls *f = own->of;
  own->status = thrum_contact_pairs_step_beside(f->rooms[0], f->rooms[own->room], GROUPS,
                                                f->members[own->group], 2, NULL,
                                                f->groups + own->group, NULL);
  return NULL;
}

/* A step of all groups, by a thread each or one after the other in one room. */
static void step_falls(falls *f, bool threads) {
  pthread_t ids[GROUPS];
  fall own[GROUPS];
  for (int n = 0; n < GROUPS; n++)
    thrum_contact_pairs_begin(f->rooms[n]);

  // each group in a room of its own, or all in the first
  for (int n = 0; n < GROUPS; n++) {
    own[n] = (fall){.of = f, .group = n, .room = threads ? n : 0};
    if (threads)
      assert_int_equal(pthread_create(ids + n, NULL, step_fall, own + n), 0);
    else
      step_fall(own + n);
  }

  // their outcomes come together
  for (int n = 0; n < GROUPS; n++) {
    if (threads)
      assert_int_equal(pthread_join(ids[n], NULL), 0);
    assert_int_equal(own[n].status, THRUM_OK);
  }
  thrum_contact_pairs_gather(f->rooms[0], f->groups, GROUPS);
}

static void groups_step_on_threads_to_the_bits_of_one(void **context) {
  (void)context;
  static falls f[2];
  int64_t both = 0;
  for (int n = 0; n < 2; n++)
    make_falls(f + n);

  // bodies, reports and touches are the same after each step
  for (int k = 0; k < FALLS; k++) {
    thrum_contact_pairs_report reports[2];
    thrum_pair_touch touches[2];
    for (int n = 0; n < 2; n++) {
      step_falls(f + n, n == 1);
      reports[n] = thrum_contact_pairs_report_get(f[n].rooms[0]);
    }
    assert_memory_equal(reports, reports + 1, sizeof *reports);
    both += f[0].groups[0].report.touching > 0 && f[0].groups[1].report.touching > 0;
    for (int64_t m = 0; m < reports[0].touching; m++) {
      for (int n = 0; n < 2; n++)
        assert_int_equal(thrum_contact_pairs_touch_get(f[n].rooms[0], m, touches + n, NULL),
                         THRUM_OK);
      assert_memory_equal(touches, touches + 1, sizeof *touches);
    }
    for (int m = 0; m < GROUPS; m++)
      assert_memory_equal(&f[0].bodies[m].translation, &f[1].bodies[m].translation,
                          sizeof(thrum_translation));
  }
  assert_true(both > 0);
  for (int n = 0; n < 2; n++)
    free_falls(f + n);
}

/* A number that is no group, and a room of another def, are refused with nothing done. */
static void a_group_beside_others_needs_a_room_of_the_same_def(void **context) {
  (void)context;
  static falls f;
  make_falls(&f);
  thrum_contact_pairs_def def = thrum_default_contact_pairs_def();
  size_t size = 0;
  thrum_contact_pairs *other = NULL;
  def.member_max = def.rank_max = 4;
  def.vertex_max = def.node_max = 64;
  assert_int_equal(thrum_contact_pairs_size(&def, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_pairs_init(room_of(size), size, &def, &other, NULL), THRUM_OK);

  // each of the calls with one thing wrong
  thrum_contact_pairs *pairs = f.rooms[0];
  thrum_contact_group group = {.first_touch = 7};
  const thrum_status wrong[] = {
      thrum_contact_pairs_step_beside(NULL, pairs, 1, f.members[0], 2, NULL, &group, NULL),
      thrum_contact_pairs_step_beside(pairs, NULL, 1, f.members[0], 2, NULL, &group, NULL),
      thrum_contact_pairs_step_beside(pairs, pairs, 0, f.members[0], 2, NULL, &group, NULL),
      thrum_contact_pairs_step_beside(pairs, pairs, 1, f.members[0], 2, NULL, NULL, NULL),
      thrum_contact_pairs_step_beside(pairs, pairs, 1, f.members[0], 3, NULL, &group, NULL),
      thrum_contact_pairs_step_beside(pairs, other, 1, f.members[0], 2, NULL, &group, NULL)};
  for (size_t n = 0; n < sizeof wrong / sizeof wrong[0]; n++)
    assert_int_equal(wrong[n], THRUM_INVALID_ARGUMENT);
  assert_true(group.room == NULL && f.bodies[0].translation.position[2] == 0.02);

  // such a group adds nothing, as do none
  thrum_contact_pairs_gather(pairs, &group, 1);
  thrum_contact_pairs_gather(pairs, NULL, 1);
  thrum_contact_pairs_gather(NULL, &group, 1);
  assert_int_equal(thrum_contact_pairs_report_get(pairs).touching, 0);
  free(other);
  free_falls(&f);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(threads_that_share_a_model_step_to_the_bits_of_a_run_alone),
      cmocka_unit_test(threads_lend_their_scratch_to_the_states_that_they_step),
      cmocka_unit_test(groups_step_on_threads_to_the_bits_of_one),
      cmocka_unit_test(a_group_beside_others_needs_a_room_of_the_same_def),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
