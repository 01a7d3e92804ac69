/* Contact between bodies and what it is given: definitions, skins, members and bytes that are to
 * become contact again, each with one thing wrong. SPDX-License-Identifier: Apache-2.0 */
#include "tests/support/contact_support.h"

#include "contact/contact_pairs_energy.h"
#include "contact/contact_pairs_private.h"
#include "contact/contact_pairs_rows.h"

/* A tetrahedron, as the surface of a solid. */
static const double corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const int32_t faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

/* Contact with room for two solids, as small as it can be, and the skin of such a solid. */
typedef struct fixture {
  thrum_contact_pairs_def def;
  thrum_contact_pairs *pairs;
  thrum_skin *skin;
  unsigned char *copy;
  size_t size;
} fixture;

static void *memory_of(size_t size) {
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  assert_non_null(memory);
  return memory;
}

/* Where the first touch lies in the bytes. */
static size_t first_touch(const fixture *f) {
  return (size_t)((const unsigned char *)thrum_pairs_view_of(f->pairs).touches -
                  (const unsigned char *)f->pairs);
}

static int setup(void **context) {
  fixture *f = calloc(1, sizeof *f);
  if (f == NULL)
    return -1;
  *context = f;

  // the solid first, whose counts are the room
  size_t size = 0;
  assert_int_equal(thrum_skin_solid_size(corners, 4, faces, 4, &size, NULL), THRUM_OK);
  assert_int_equal(
      thrum_skin_solid_init(memory_of(size), size, corners, 4, faces, 4, &f->skin, NULL), THRUM_OK);

  f->def = thrum_default_contact_pairs_def();
  f->def.member_max = 2;
  f->def.vertex_max = 2 * thrum_skin_vertex_count(f->skin);
  f->def.node_max = 2 * thrum_skin_node_count(f->skin);
  f->def.rank_max = 1;
  f->def.touch_max = 3;
  f->def.thickness = 0.01;
  assert_int_equal(thrum_contact_pairs_size(&f->def, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_pairs_init(memory_of(size), size, &f->def, &f->pairs, NULL),
                   THRUM_OK);

  // a copy with a touch, which a step between bodies would leave
  f->size = thrum_contact_pairs_kept_bytes(f->pairs);
  f->copy = memory_of(f->size);
  memcpy(f->copy, f->pairs, f->size);
  ((thrum_contact_pairs *)(void *)f->copy)->history.touch_count = 1;
  const thrum_pair_touching touch = {.key = {.bodies = {1, 2}}, .normal = {0, 0, 1}, .force = 3};
  memcpy(f->copy + first_touch(f), &touch, sizeof touch);
  assert_int_equal(thrum_contact_pairs_copy_check(f->pairs, f->copy, NULL), THRUM_OK);
  return 0;
}

static int teardown(void **context) {
  fixture *f = *context;
  free(f->pairs);
  free(f->skin);
  free(f->copy);
  free(f);
  return 0;
}

/* --- definitions ------------------------------------------------------------------------------ */

static void refuse_def(const thrum_contact_pairs_def *def, thrum_status expected) {
  size_t size = 77;
  thrum_error error = {0};
  assert_int_equal(thrum_contact_pairs_size(def, &size, &error), expected);
  assert_int_equal(size, 77);
  assert_true(error.message[0] != 0);
}

static void each_number_of_a_def_has_its_range(void **context) {
  const fixture *f = *context;
  refuse_def(NULL, THRUM_UNINITIALISED_DEF);
  refuse_def(&(thrum_contact_pairs_def){0}, THRUM_UNINITIALISED_DEF);

  // counts: none, and one more than the most
  const struct {
    size_t offset;
    int64_t most;
  } counts[] = {
      {offsetof(thrum_contact_pairs_def, member_max), INT64_C(1) << 20},
      {offsetof(thrum_contact_pairs_def, vertex_max), INT64_C(1) << 31},
      {offsetof(thrum_contact_pairs_def, node_max), INT64_C(1) << 31},
      {offsetof(thrum_contact_pairs_def, rank_max), THRUM_RANK_MAX},
      {offsetof(thrum_contact_pairs_def, touch_max), INT64_C(1) << 24},
  };
  for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++)
    for (int high = 0; high < 2; high++) {
      thrum_contact_pairs_def wrong = f->def;
      const int64_t value = high ? counts[n].most + 1 : 0;
      memcpy((unsigned char *)&wrong + counts[n].offset, &value, sizeof value);
      refuse_def(&wrong, THRUM_INVALID_ARGUMENT);
    }
  thrum_contact_pairs_def wrong = f->def;
  wrong.sweeps_max = 0;
  refuse_def(&wrong, THRUM_INVALID_ARGUMENT);

  // other numbers: no number, below the least, above the most
  const struct {
    size_t offset;
    double below, above;
  } numbers[] = {
      {offsetof(thrum_contact_pairs_def, thickness), -1, 1.1e30},
      {offsetof(thrum_contact_pairs_def, friction), -1, 1.1e30},
      {offsetof(thrum_contact_pairs_def, restitution), -0.1, 1.1},
      {offsetof(thrum_contact_pairs_def, tolerance), 0, 1.1e-2},
  };
  for (size_t n = 0; n < sizeof numbers / sizeof numbers[0]; n++) {
    const double values[3] = {NAN, numbers[n].below, numbers[n].above};
    for (int k = 0; k < 3; k++) {
      wrong = f->def;
      memcpy((unsigned char *)&wrong + numbers[n].offset, &values[k], sizeof values[k]);
      refuse_def(&wrong, THRUM_INVALID_ARGUMENT);
    }
  }

  // the largest tolerance is one
  size_t size = 0;
  wrong = f->def;
  wrong.tolerance = 1e-2;
  assert_int_equal(thrum_contact_pairs_size(&wrong, &size, NULL), THRUM_OK);
}

static void what_is_null_is_refused_or_nothing(void **context) {
  fixture *f = *context;
  thrum_contact_pairs *pairs = NULL;
  size_t size = 0;
  assert_int_equal(thrum_contact_pairs_size(&f->def, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pairs_size(&f->def, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_pairs_init(NULL, size, &f->def, &pairs, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pairs_init(f->copy, f->size, &f->def, NULL, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_null(pairs);

  // what is read from no contact is nothing
  thrum_pair_touch touch;
  assert_int_equal(thrum_contact_pairs_kept_bytes(NULL), 0);
  assert_int_equal(thrum_contact_pairs_report_get(NULL).steps, 0);
  thrum_contact_pairs_begin(NULL);
  thrum_contact_pairs_reset(NULL);
  assert_int_equal(thrum_contact_pairs_touch_get(NULL, 0, &touch, NULL), THRUM_INVALID_ARGUMENT);

  // touches that there are, and no others
  f->pairs->history.touch_count = 1;
  assert_int_equal(thrum_contact_pairs_touch_get(f->pairs, 0, &touch, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_pairs_touch_get(f->pairs, 0, NULL, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pairs_touch_get(f->pairs, 1, &touch, NULL),
                   THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pairs_touch_get(f->pairs, -1, &touch, NULL),
                   THRUM_INVALID_ARGUMENT);
}

/* --- skins ------------------------------------------------------------------------------------ */

static void refuse_solid(const double *vertices, int64_t vertex_count, const int32_t *triangles,
                         int64_t triangle_count, thrum_status expected) {
  size_t size = 77;
  assert_int_equal(
      thrum_skin_solid_size(vertices, vertex_count, triangles, triangle_count, &size, NULL),
      expected);
  assert_int_equal(size, 77);
}

static void a_skin_needs_vertices_and_triangles_of_them(void **context) {
  (void)context;
  refuse_solid(NULL, 4, faces, 4, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, 2, faces, 4, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, INT64_C(1) << 31, faces, 4, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, 4, NULL, 4, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, 4, faces, 0, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, 4, faces, (INT64_C(1) << 28) + 1, THRUM_INVALID_ARGUMENT);
  refuse_solid((const double[9]){0, 0, 0, NAN}, 3, faces, 1, THRUM_BAD_VALUE);
  refuse_solid(corners, 4, (const int32_t[3]){0, 1, 4}, 1, THRUM_INVALID_ARGUMENT);
  refuse_solid(corners, 4, (const int32_t[3]){0, -1, 2}, 1, THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_skin_solid_size(corners, 4, faces, 4, NULL, NULL), THRUM_INVALID_ARGUMENT);

  // a body's skin needs its mesh and its material
  thrum_model bare = {.vertex_count = 4, .vertices = (double *)(uintptr_t)corners};
  size_t size = 77;
  assert_int_equal(thrum_skin_size(NULL, faces, 4, &size, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_skin_size(&bare, faces, 4, &size, NULL), THRUM_MISSING);
  bare.basis = bare.vertices;
  assert_int_equal(thrum_skin_size(&bare, faces, 4, &size, NULL), THRUM_MISSING);
  assert_int_equal(size, 77);

  // no skin has nothing
  assert_int_equal(thrum_skin_vertex_count(NULL), 0);
  assert_int_equal(thrum_skin_node_count(NULL), 0);
  assert_true(thrum_skin_diagonal(NULL) == 0);
}

/* The angle between the two faces of an edge, with the vertices at x [rad]. */
static double angle_at(const thrum_skin_edge *edge, const double *x) {
  double along[3], normals[2][3], cross[3];
  const double *first = x + 3 * (int64_t)edge->ends[0];
  thrum_subtract3(x + 3 * (int64_t)edge->ends[1], first, along);
  for (int n = 0; n < 2; n++) {
    double way[3];
    thrum_subtract3(x + 3 * (int64_t)edge->opposite[n], first, way);
    thrum_cross3(along, way, normals[n]);
  }
  thrum_cross3(normals[0], normals[1], cross);
  return atan2(sqrt(thrum_dot3(cross, cross)), -thrum_dot3(normals[0], normals[1]));
}

/* The largest angle over all edges that have two faces. */
static double largest_angle(const thrum_skin *skin, const double *q) {
  const thrum_skin_view view = thrum_skin_view_of(skin);
  double x[3 * 16], most = 0;
  for (int64_t v = 0; v < skin->vertex_count; v++)
    for (int axis = 0; axis < 3; axis++) {
      x[3 * v + axis] = view.rest[3 * v + axis];
      for (int64_t i = 0; i < skin->rank; i++)
        x[3 * v + axis] += view.rows[(3 * v + axis) * skin->rank + i] * q[i];
    }
  for (int64_t e = 0; e < skin->edge_count; e++)
    if (view.edges[e].opposite[1] >= 0)
      most = fmax(most, angle_at(view.edges + e, x));
  return most;
}

/* The skin of a body of any material. */
static thrum_skin *skin_of(thrum_model *model, const int32_t *triangles, int64_t count) {
  double material[3] = {1e6, 0.3, 1};
  size_t size = 0;
  thrum_skin *skin = NULL;
  model->material = material;
  model->region_count = 1;
  assert_int_equal(thrum_skin_size(model, triangles, count, &size, NULL), THRUM_OK);
  assert_int_equal(thrum_skin_init(memory_of(size), size, model, triangles, count, &skin, NULL),
                   THRUM_OK);
  model->material = NULL;
  return skin;
}

enum { SIDE = 4, RANK = 3 };

static void a_flat_face_bends_by_what_its_skin_says(void **context) {
  (void)context;
  random_state random = {11};
  double vertices[3 * SIDE * SIDE] = {0}, basis[3 * SIDE * SIDE * RANK];
  int32_t triangles[6 * (SIDE - 1) * (SIDE - 1)], count = 0;

  // a square in the plane z = 0 whose vertices are off their grid
  for (int32_t v = 0; v < SIDE * SIDE; v++) {
    vertices[3 * v] = v % SIDE + 0.2 * random_uniform(&random);
    vertices[3 * v + 1] = v / SIDE + 0.2 * random_uniform(&random);
  }
  for (int32_t v = 0; v < SIDE * (SIDE - 1); v++) {
    const int32_t both[6] = {v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE};
    if (v % SIDE == SIDE - 1)
      continue;
    memcpy(triangles + 3 * count, both, sizeof both);
    count += 2;
  }
  random_vector(&random, 3 * SIDE * SIDE * RANK, 1, basis);
  thrum_model model = {
      .rank = RANK, .vertex_count = SIDE * SIDE, .vertices = vertices, .basis = basis};
  thrum_skin *skin = skin_of(&model, triangles, count);
  const thrum_skin_view view = thrum_skin_view_of(skin);

  // one coordinate alone reaches the bound, and all together stay within it
  for (int i = 0; i < RANK; i++) {
    double q[RANK] = {0};
    q[i] = 1e-5;
    assert_true(fabs(largest_angle(skin, q) / (view.bends[i] * q[i]) - 1) < 1e-3);
  }
  for (int n = 0; n < 1000; n++) {
    double q[RANK], bent = 0, tilted = 0;
    random_vector(&random, RANK, n % 2 ? 1e-3 : 0.1, q);
    for (int i = 0; i < RANK; i++) {
      bent += view.bends[i] * fabs(q[i]);
      tilted += view.tilts[i] * fabs(q[i]);
    }
    assert_true(largest_angle(skin, q) < bent + tilted * tilted);
  }

  // all inner edges are in the face, each with one of its triangles
  int inner = 0;
  for (int64_t t = 0; t < skin->triangle_count; t++)
    for (int n = 0; n < 3; n++)
      inner += (view.triangles[t].tried & (THRUM_SKIN_IN_FACE << n)) != 0;
  assert_int_equal(inner, (SIDE - 1) * (SIDE - 1) + 2 * (SIDE - 1) * (SIDE - 2));
  free(skin);
}

/* A square that is turned, of which one half is stretched: neither bends it alone, both do. */
static void what_is_turned_is_bent_by_a_stretch(void **context) {
  (void)context;
  double vertices[18], basis[36] = {0};
  const int32_t triangles[12] = {0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4};
  for (int v = 0; v < 6; v++) {
    const double x = v % 3 - 1.0, y = v / 3;
    vertices[3 * v] = x;
    vertices[3 * v + 1] = y;
    vertices[3 * v + 2] = 0;

    // the first coordinate lifts by x, the second draws out what is right of the middle
    basis[6 * v + 4] = x;
    basis[6 * v + 1] = fmax(x, 0);
  }
  thrum_model model = {.rank = 2, .vertex_count = 6, .vertices = vertices, .basis = basis};
  thrum_skin *skin = skin_of(&model, triangles, 4);
  const thrum_skin_view view = thrum_skin_view_of(skin);
  const double q[2] = {0.5, 0.3};
  const double bent = view.bends[0] * q[0] + view.bends[1] * q[1];
  const double tilted = view.tilts[0] * q[0] + view.tilts[1] * q[1];
  assert_true(bent < 1e-12 && largest_angle(skin, q) > 5 * THRUM_SKIN_FLAT);
  assert_true(largest_angle(skin, q) < bent + tilted * tilted);
  free(skin);
}

/* --- members ---------------------------------------------------------------------------------- */

static void refuse_step(fixture *f, thrum_contact_member *members, int64_t count,
                        const char *says) {
  thrum_error error = {0};
  assert_int_equal(thrum_contact_pairs_step(f->pairs, members, count, &error),
                   THRUM_INVALID_ARGUMENT);
  if (strstr(error.message, says) == NULL)
    fail_msg("'%s' does not say '%s'", error.message, says);
}

static void members_of_a_step_must_fit(void **context) {
  fixture *f = *context;
  static const thrum_contact_solid still = {.now = {.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                            .next = {.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}}};
  const thrum_contact_member one = {.skin = f->skin, .solid = &still, .number = 1};
  thrum_contact_member members[3] = {one, one, one};
  members[1].number = 2;
  members[2].number = 3;

  // how many
  refuse_step(f, NULL, 1, "there is room for 1 to 2");
  refuse_step(f, members, 0, "there is room for 1 to 2");
  refuse_step(f, members, 3, "there is room for 1 to 2");
  assert_int_equal(thrum_contact_pairs_step(NULL, members, 1, NULL), THRUM_INVALID_ARGUMENT);

  // parts and numbers of a member
  members[0].skin = NULL;
  refuse_step(f, members, 2, "member 0 lacks a part");
  members[0] = one;
  members[1].solid = NULL;
  refuse_step(f, members, 2, "member 1 lacks a part");
  members[1].solid = &still;
  members[1].number = 1;
  refuse_step(f, members, 2, "must ascend");
  members[1].number = 2;
  members[0].number = -1;
  refuse_step(f, members, 2, "must ascend");
  members[0].number = 1;

  // the rank of a skin, and the room for vertices and nodes
  f->skin->rank = 1;
  refuse_step(f, members, 2, "of another rank");
  f->skin->rank = 0;
  f->pairs->vertex_max--;
  refuse_step(f, members, 2, "there is room for 7");
  f->pairs->vertex_max++;
  f->pairs->node_max--;
  refuse_step(f, members, 2, "there is room for");
}

/* --- bytes of a contact ----------------------------------------------------------------------- */

/* The copy with other bytes at an offset is refused with that status, and then mended. */
static void refuse(fixture *f, size_t offset, const void *bytes, size_t size,
                   thrum_status expected) {
  unsigned char kept[16];
  memcpy(kept, f->copy + offset, size);
  memcpy(f->copy + offset, bytes, size);
  const thrum_status status = thrum_contact_pairs_copy_check(f->pairs, f->copy, NULL);
  if (status != expected)
    fail_msg("bytes at %zu: %s", offset, thrum_status_text(status));
  memcpy(f->copy + offset, kept, size);
}

static void a_copy_of_another_def_is_refused(void **context) {
  fixture *f = *context;
  assert_int_equal(thrum_contact_pairs_copy_check(f->pairs, f->copy, NULL), THRUM_OK);
  assert_int_equal(thrum_contact_pairs_copy_check(NULL, f->copy, NULL), THRUM_INVALID_ARGUMENT);
  assert_int_equal(thrum_contact_pairs_copy_check(f->pairs, NULL, NULL), THRUM_INVALID_ARGUMENT);

  // all that init sets stands in front: one bit of each byte of it
  for (size_t byte = 0; byte < offsetof(thrum_contact_pairs, history.touch_count); byte++) {
    const unsigned char other = f->copy[byte] ^ (unsigned char)(1U << (byte % 8));
    refuse(f, byte, &other, 1, THRUM_MODEL_MISMATCH);
  }
}

static void counts_and_numbers_of_a_copy_have_their_range(void **context) {
  fixture *f = *context;
  const int64_t touch_max = f->pairs->touch_max, most = INT64_C(1) << 62;
  const struct {
    size_t offset;
    int64_t most;
  } counts[] = {
      {offsetof(thrum_contact_pairs, history.touch_count), touch_max},
      {offsetof(thrum_contact_pairs, history.before_count), touch_max},
      {offsetof(thrum_contact_pairs, history.steps), most},
      {offsetof(thrum_contact_pairs, history.redone), most},
      {offsetof(thrum_contact_pairs, history.declined), most},
      {offsetof(thrum_contact_pairs, history.dropped), most},
      {offsetof(thrum_contact_pairs, history.sweeps), most},
      {offsetof(thrum_contact_pairs, history.impacts), most},
      {offsetof(thrum_contact_pairs, history.struck), touch_max - 1},
      {offsetof(thrum_contact_pairs, filled), 0},
      {offsetof(thrum_contact_pairs, listed), 0},
  };
  for (size_t n = 0; n < sizeof counts / sizeof counts[0]; n++) {
    const int64_t wrong[2] = {-1, counts[n].most + 1};
    refuse(f, counts[n].offset, &wrong[0], sizeof wrong[0], THRUM_BAD_VALUE);
    refuse(f, counts[n].offset, &wrong[1], sizeof wrong[1], THRUM_BAD_VALUE);
  }

  // energies and depths of the header
  const double bad[2] = {NAN, INFINITY};
  for (size_t at = offsetof(thrum_contact_pairs, history.stored);
       at < offsetof(thrum_contact_pairs, history.steps); at += sizeof(double))
    refuse(f, at, &bad[at / sizeof(double) % 2], sizeof(double), THRUM_BAD_VALUE);
}

static void each_number_of_a_touch_of_a_copy_is_looked_at(void **context) {
  fixture *f = *context;
  const size_t touch = first_touch(f);

  // which way it points, and what touches what
  const int32_t wrong[2] = {-1, 3};
  for (int n = 0; n < 2; n++) {
    refuse(f, touch + offsetof(thrum_pair_touching, towards), &wrong[n], sizeof wrong[n],
           THRUM_BAD_VALUE);
    refuse(f, touch + offsetof(thrum_pair_touching, key.kind), &wrong[n], sizeof wrong[n],
           THRUM_BAD_VALUE);
  }

  // bodies: numbers from 0 on, the first below the second, or twice the same, which has one order
  const int32_t bodies[3][3] = {{-1, 2, 0}, {3, 2, 0}, {2, 2, THRUM_PAIR_REVERSE}};
  for (int n = 0; n < 3; n++)
    refuse(f, touch + offsetof(thrum_pair_touching, key.bodies), bodies[n], sizeof bodies[n],
           THRUM_BAD_VALUE);

  // an impact at the end of the list is looked at as a touch is
  thrum_contact_pairs *header = (void *)f->copy;
  header->history.struck = 1;
  const size_t last = touch + (size_t)(f->pairs->touch_max - 1) * sizeof(thrum_pair_touching);
  refuse(f, last + offsetof(thrum_pair_touching, key.kind), &wrong[0], sizeof wrong[0],
         THRUM_BAD_VALUE);
  header->history.struck = 0;

  // forces, distances and places
  const double bad[2] = {NAN, INFINITY};
  for (size_t at = offsetof(thrum_pair_touching, normal); at < sizeof(thrum_pair_touching);
       at += sizeof(double))
    refuse(f, touch + at, &bad[at / sizeof(double) % 2], sizeof(double), THRUM_BAD_VALUE);
}

/* --- steps ------------------------------------------------------------------------------------ */

/* Which of two bodies fails where one of them moves by x in the step, and their touch takes this
 * work. */
static int64_t beyond(const fixture *f, int mover, double x, double work) {
  const thrum_contact_environment environment = {.obstacles = NULL};
  thrum_contact none = {.rank = 0};
  thrum_contact_member members[2] = {{.number = 0}, {.number = 1}};
  thrum_pairs_run run = {.pairs = f->pairs,
                         .members = members,
                         .count = 2,
                         .view = thrum_pairs_view_of(f->pairs),
                         .row_count = 1};
  for (int n = 0; n < 2; n++)
    run.view.runs[n] = (thrum_contact_run){.contact = &none,
                                           .environment = &environment,
                                           .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                           .moved = {n == mover ? x : 0.5}};

  // the row as the step left it
  run.view.rows[0] = (thrum_pair_row){
      .members = {0, 1}, .row = {.stiffness = 1e12, .work = work, .touch = {.gap = -fabs(x)}}};
  return thrum_pairs_beyond(&run);
}

static void the_body_that_flies_apart_is_the_one_that_fails(void **context) {
  const fixture *f = *context;
  for (int mover = 0; mover < 2; mover++) {
    assert_int_equal(beyond(f, mover, 1e3, 1), -1);
    assert_int_equal(beyond(f, mover, 1e152, 1), mover);
    assert_int_equal(beyond(f, mover, 1e3, NAN), mover);
    assert_int_equal(beyond(f, mover, NAN, 1), mover);
  }
}

/* Two places of two bodies, the vertex of the first 'apart' from a face of the second [m]. */
static thrum_pair_candidate candidate_of(int32_t vertex, double apart) {
  return (thrum_pair_candidate){.key = {{0, 1}, THRUM_PAIR_VERTEX, vertex, 0},
                                .members = {0, 1},
                                .vertices = {vertex, faces[0], faces[1], faces[2]},
                                .weights = {1, 1.0 / 3, 1.0 / 3, 1.0 / 3},
                                .normal = {0, 0, 1},
                                .apart = apart,
                                .inside = 1,
                                .slow = 1};
}

/* A place that has waited and closes gets its row in the middle of a step, when forces are those
 * that were solved for: what it says to the others is its own force alone. */
static void a_place_that_wakes_leaves_the_ceilings_of_others(void **context) {
  fixture *f = *context;
  const thrum_contact_environment environment = {.obstacles = NULL};
  thrum_contact none = {.rank = 0};
  thrum_contact_member members[2] = {{.skin = f->skin, .number = 0},
                                     {.skin = f->skin, .number = 1}};
  thrum_pairs_run run = {.pairs = f->pairs,
                         .history = &f->pairs->history,
                         .members = members,
                         .count = 2,
                         .view = thrum_pairs_view_of(f->pairs),
                         .candidate_count = 2};
  f->skin->young = 1e6;
  for (int n = 0; n < 2; n++) {
    run.view.runs[n] = (thrum_contact_run){.contact = &none,
                                           .environment = &environment,
                                           .axes = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                           .dt = 0.01,
                                           .mass_weight = 1e-4,
                                           .unloaded = {0, 0, n == 0 ? -1e-5 : 0}};
    run.view.first_vertex[n + 1] = 4 * (n + 1);
  }

  // one place is pressed in without a force so far, another one is apart and waits
  const double depth = 0.002;
  run.view.candidates[0] = candidate_of(0, f->def.thickness - depth);
  run.view.candidates[1] = candidate_of(1, f->def.thickness + 1e-4);
  run.view.order[0] = 0;
  run.view.order[1] = 1;
  assert_int_equal(thrum_pairs_add_rows(&run), 1);
  assert_int_equal(run.idle_count, 1);

  // its spring goes out of that depth, as no force of the last step says that it has to be there
  thrum_contact_row *row = &run.view.rows[0].row;
  const double ceiling = row->ceiling;
  assert_true(ceiling > -depth);
  row->touch.force = 0.7 * row->stiffness * depth;
  assert_int_equal(thrum_pairs_wake(&run, true), 1);
  assert_int_equal(run.row_count, 2);
  assert_true(row->ceiling == ceiling);
}

/* The bound of the tetrahedron turned by an angle about an axis through its first corner, at x. */
static thrum_skin_bound bound_of(const fixture *f, const double x[3], int axis, double angle,
                                 double way, double axes[9]) {
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  memset(axes, 0, 9 * sizeof *axes);
  axes[4 * axis] = 1;
  axes[4 * a] = axes[4 * b] = cos(angle);
  axes[3 * a + b] = -sin(angle);
  axes[3 * b + a] = sin(angle);
  thrum_contact_solid solid = {.friction = 0};
  memcpy(solid.now.axes, axes, 9 * sizeof *axes);
  memcpy(solid.now.origin, x, 3 * sizeof *x);
  solid.next = solid.now;
  solid.next.origin[0] += way;
  const thrum_contact_member member = {.skin = f->skin, .solid = &solid};
  return thrum_contact_member_bound(&member);
}

/* Bodies that are not near are further apart than the default thickness, however they lie; those
 * side by side are not near, unless one of them moves. */
static void what_is_not_near_does_not_touch(void **context) {
  const fixture *f = *context;
  enum { DRAWS = 3000 };
  double axes[2][9], at[3], least = INFINITY;
  const double none[3] = {0, 0, 0}, beside[3] = {1.1, 0, 0};
  const thrum_skin_bound first = bound_of(f, none, 0, 0, 0, axes[0]);
  const thrum_skin_bound still = bound_of(f, beside, 0, 0, 0, axes[1]);
  const thrum_skin_bound moves = bound_of(f, beside, 0, 0, -0.1, axes[1]);
  assert_false(thrum_contact_pairs_near(&first, &still));
  assert_true(thrum_contact_pairs_near(&first, &moves));

  // distances of points of both that are drawn
  unsigned seed = 5;
  int apart = 0;
  for (int n = 0; n < DRAWS; n++) {
    double draw[6];
    for (int k = 0; k < 6; k++) {
      seed = 1664525 * seed + 1013904223;
      draw[k] = (double)(seed >> 8) / (1 << 24) - 0.5;
    }
    const double x[3] = {3 * draw[0], 3 * draw[1], 3 * draw[2]};
    const thrum_skin_bound a = bound_of(f, none, n % 3, 6 * draw[3], 0, axes[0]);
    const thrum_skin_bound b = bound_of(f, x, n / 3 % 3, 6 * draw[4], 0, axes[1]);
    if (thrum_contact_pairs_near(&a, &b))
      continue;
    apart++;
    for (int p = 0; p < 16; p++) {
      double from[3], to[3];
      for (int axis = 0; axis < 3; axis++) {
        const double u = 0.5 * (corners[3 * (p % 4) + axis] + corners[3 * (n % 4) + axis]);
        const double v = 0.5 * (corners[3 * (p / 4) + axis] + corners[3 * (n / 4 % 4) + axis]);
        from[axis] = u;
        to[axis] = v;
      }
      thrum_apply3(axes[0], from, at);
      thrum_apply3(axes[1], to, from);
      for (int axis = 0; axis < 3; axis++)
        at[axis] -= from[axis] + x[axis];
      least = fmin(least, sqrt(thrum_dot3(at, at)));
    }
  }
  print_message("%d of %d apart, by %.4f at least\n", apart, DRAWS, least);
  assert_in_range(apart, DRAWS / 4, DRAWS);
  assert_true(least > 0.004 * f->skin->diagonal);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

int main(void) {
  const struct CMUnitTest tests[] = {
      TEST(each_number_of_a_def_has_its_range),
      TEST(what_is_null_is_refused_or_nothing),
      TEST(a_skin_needs_vertices_and_triangles_of_them),
      cmocka_unit_test(a_flat_face_bends_by_what_its_skin_says),
      cmocka_unit_test(what_is_turned_is_bent_by_a_stretch),
      TEST(members_of_a_step_must_fit),
      TEST(a_copy_of_another_def_is_refused),
      TEST(counts_and_numbers_of_a_copy_have_their_range),
      TEST(each_number_of_a_touch_of_a_copy_is_looked_at),
      TEST(the_body_that_flies_apart_is_the_one_that_fails),
      TEST(what_is_not_near_does_not_touch),
      TEST(a_place_that_wakes_leaves_the_ceilings_of_others),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
