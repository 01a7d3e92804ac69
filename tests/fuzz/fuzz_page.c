/* Fuzz target of what the viewer's page does with its archive: the arrays of a model and a scene as
 * the page hands them over (docs/viewer.md), behind the checks that the page makes of them. An
 * input is decisions and numbers.
 * sources: scene/*.c viewer/page.c viewer/page_effects.c viewer/page_touches.c viewer/pick.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include <float.h>

#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"

// a page has its models for as long as it lives, and an input only for itself
#include "viewer/page_model.c"

#define RANK_MOST 6
#define VERTICES_MOST 8
#define TRIANGLES_MOST 8

// what the page imports of the module
int32_t bridge_begin(double dt);
int32_t bridge_add_body(int32_t model, int32_t integrator, int32_t rank, int32_t free_body,
                        const double *q, const double *p);
int32_t bridge_set_collisions(int32_t touches);
int32_t bridge_add_obstacle(int32_t shape, int32_t inside);
int32_t bridge_add_load(int32_t body, int32_t shape, const double *reduced, const double *parts);
int32_t bridge_add_base_motion(int32_t shape);
int32_t bridge_add_motion(int32_t count, double *samples);
int32_t bridge_set_gravity(double x, double y, double z);
int32_t bridge_set_wind(void);
int32_t bridge_set_dt(double dt);
int32_t bridge_set_damping(int32_t body, double alpha, double beta);
int32_t bridge_set_stiffness(int32_t body, double stiffness);
int32_t bridge_set_integrator(int32_t body, int32_t integrator);
int32_t bridge_set_rank(int32_t body, int32_t rank);
int32_t bridge_reset(void);
int32_t bridge_step(void);
int32_t bridge_shape(int32_t body, float *out);
int32_t bridge_coordinates(int32_t body);
int32_t bridge_energies(int32_t body);
int32_t bridge_account(void);
int32_t bridge_body(int32_t body);
void bridge_matrix(int32_t body);
const double *bridge_omega2(int32_t body);
const double *bridge_stepped_frequencies(int32_t body);
int32_t bridge_pull_start(int32_t body, int32_t vertex, double strength);
int32_t bridge_pull_move(int32_t pull);
int32_t bridge_pull_end(int32_t pull);
int32_t bridge_pull(int32_t pull);
const float *bridge_touches(void);
int32_t bridge_touch_count(void);
int32_t bridge_pick(void);

const char *__asan_default_options(void);

/* The page returns no memory of models that it refuses. */
const char *__asan_default_options(void) {
  return "detect_leaks=0";
}

static void forget_models(void) {
  for (int32_t n = 0; n <= model_count && n < MODELS_MAX; n++) {
    bridge_model *made = &models[n];
    void *owned[] = {(void *)made->model.vertices,
                     (void *)made->model.basis,
                     (void *)made->model.rigid,
                     (void *)made->model.packed,
                     (void *)made->surface,
                     made->positions,
                     made->touch};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
      free(owned[k]);
    *made = (bridge_model){0};
  }
  model_count = 0;
}

/* Numbers as in a body of this size, in memory of the page. */
static double *numbers(fuzz_draw *draw, int64_t count, double size) {
  double *made = bridge_alloc((size_t)count * sizeof *made);
  for (int64_t n = 0; n < count; n++)
    made[n] = draw_about(draw, size);
  return made;
}

static float *small_numbers(fuzz_draw *draw, int64_t count) {
  float *made = bridge_alloc((size_t)count * sizeof *made);
  for (int64_t n = 0; n < count; n++)
    made[n] = (float)draw_about(draw, 1);
  return made;
}

/* Memory of a model of the page, given back at the end of an input. */
typedef struct kept {
  void *memory[8];
  int count;
} kept;

static void *keep(kept *list, void *memory) {
  return list->memory[list->count++] = memory;
}

static int32_t add_model(fuzz_draw *draw, kept *list, int32_t *rank, int32_t *vertices) {
  const int32_t r = *rank = 1 + (int32_t)draw_index(draw, RANK_MOST);
  const int32_t v = *vertices = 1 + (int32_t)draw_index(draw, VERTICES_MOST);
  const int32_t t = (int32_t)draw_index(draw, TRIANGLES_MOST);
  const bool is_free = draw_byte(draw) % 2 == 0;

  // frequencies ascend, unless the archive was made wrong
  double *omega2 = keep(list, numbers(draw, r, 100));
  if (draw_byte(draw) % 8 != 0)
    for (int32_t n = 0; n < r; n++)
      omega2[n] = 100.0 * (n + 1);
  const double *c3 = keep(list, numbers(draw, thrum_c3_count(r), 1));
  double *c4 = keep(list, numbers(draw, thrum_c4_count(r), 1));
  const double *axis_mass = keep(list, numbers(draw, 3 * r, 1));
  uint8_t *fixed = keep(list, bridge_alloc((size_t)v));
  for (int32_t n = 0; n < v; n++)
    fixed[n] = (uint8_t)draw_byte(draw);
  int32_t *triangles = keep(list, bridge_alloc((size_t)t * 3 * sizeof *triangles));
  for (int32_t n = 0; n < 3 * t; n++)
    triangles[n] = (int32_t)draw_index(draw, v);

  // these are copied
  float *positions = small_numbers(draw, 3 * v), *basis = small_numbers(draw, 3 * v * r);
  double *tet = is_free ? numbers(draw, 12, 1) : NULL;
  double *tet_rigid = is_free ? numbers(draw, 72, 1) : NULL;
  bridge_number[0] = draw_above(draw, 64);
  bridge_number[1] = draw_above(draw, 64);
  // a model of a polynomial, without points of a cubature
  const int32_t number =
      bridge_add_model(r, v, t, 0, 0, 0, omega2, c3, c4, NULL, NULL, NULL, NULL, NULL, NULL, NULL,
                       axis_mass, NULL, fixed, triangles, positions, basis, tet, tet_rigid);
  free(positions);
  free(basis);
  free(tet);
  free(tet_rigid);
  return number;
}

/* Draws the first `count` shared numbers, which the page sets before a call. */
static void set_numbers(fuzz_draw *draw, int count, double size) {
  for (int n = 0; n < count; n++)
    bridge_number[n] = draw_about(draw, size);
}

static int32_t add_body(fuzz_draw *draw, int32_t model, int32_t rank) {
  double *q = draw_byte(draw) % 2 == 0 ? numbers(draw, rank, 0.1) : NULL;
  set_numbers(draw, 18, 1);
  for (int n = 7; n < 10; n++)
    bridge_number[n] = draw_above(draw, 64);
  bridge_number[10] = draw_byte(draw) % 4 == 0 ? draw_above(draw, 1) : 0;
  bridge_number[11] = 0;
  bridge_number[18] = draw_byte(draw) % 4 == 0 ? (double)draw_index(draw, rank + 2) : 0;
  bridge_number[19] = bridge_number[18] == 0;
  const int32_t body =
      bridge_add_body(model, (int32_t)draw_index(draw, 10), (int32_t)draw_index(draw, rank + 2),
                      (int32_t)draw_index(draw, 2), q, NULL);
  free(q);
  return body;
}

static void act(fuzz_draw *draw, int32_t body, int32_t rank, int32_t vertices) {
  static float shape[THRUM_RANK_MAX];
  double *reduced, *parts;
  int64_t count;

  // one call of the page; three of twenty are steps
  switch (draw_byte(draw) % 20) {
  case 0:
    bridge_set_gravity(0, 0, draw_about(draw, 10));
    break;
  case 1:
    bridge_set_dt(draw_above(draw, 0.01));
    break;
  case 2:
    bridge_set_damping(body, draw_above(draw, 1), 0);
    break;
  case 3:
    bridge_set_stiffness(body, draw_above(draw, 64));
    break;
  case 4:
    bridge_set_integrator(body, (int32_t)draw_index(draw, 11) - 1);
    break;
  case 5:
    bridge_set_rank(body, (int32_t)draw_index(draw, rank + 3) - 1);
    break;
  case 6:
    bridge_reset();
    break;
  case 7:
    set_numbers(draw, 3, 1);
    bridge_pull_start(body, (int32_t)draw_index(draw, vertices + 6) - 1, draw_above(draw, 64));
    break;
  case 8:
    set_numbers(draw, 3, 1);
    bridge_pull_move((int32_t)draw_index(draw, 4) - 1);
    break;
  case 9:
    bridge_pull((int32_t)draw_index(draw, 4) - 1);
    bridge_pull_end((int32_t)draw_index(draw, 4) - 1);
    break;
  case 10:
    set_numbers(draw, 6, 1);
    bridge_pick();
    bridge_touches();
    bridge_touch_count();
    break;
  case 11:
    set_numbers(draw, 21, 1);
    bridge_add_obstacle((int32_t)draw_index(draw, 4), (int32_t)draw_index(draw, 2));
    break;
  case 12:
    set_numbers(draw, 15, 1);
    reduced = numbers(draw, rank, 1);
    parts = draw_byte(draw) % 2 == 0 ? numbers(draw, 9 * rank, 1) : NULL;
    bridge_add_load(body, (int32_t)draw_index(draw, 3), reduced, parts);
    free(reduced);
    free(parts);
    break;
  case 13:
    set_numbers(draw, 6, 1);
    bridge_add_base_motion((int32_t)draw_index(draw, 3));
    break;
  case 14:
    count = draw_index(draw, 4);
    reduced = numbers(draw, 10 * count, 1);
    for (int64_t n = 0; n < count; n++)
      reduced[n] = draw_byte(draw) % 8 != 0 ? (double)n : reduced[n];
    bridge_add_motion((int32_t)count, reduced);
    break;
  case 15:
    set_numbers(draw, 5, 10);
    bridge_set_wind();
    break;
  case 16:
    set_numbers(draw, 3, 1);
    bridge_set_collisions((int32_t)draw_index(draw, 64) - 1);
    break;
  case 17:
    bridge_stepped_frequencies(body);
    break;
  default:
    bridge_step();
    if (bridge_shape(body, shape) >= 0)
      bridge_energies(body);
    bridge_account();
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  fuzz_draw draw = {data, size};
  kept list = {0};
  int32_t rank, vertices;
  const int32_t model = add_model(&draw, &list, &rank, &vertices);
  if (model >= 0 && bridge_begin(draw_above(&draw, 0.01)) >= 0) {
    const int32_t body = add_body(&draw, model, rank);
    if (body >= 0 && draw_byte(&draw) % 2 == 0)
      add_body(&draw, model, rank);
    while (body >= 0 && draw.left > 0)
      act(&draw, body, rank, vertices);

    // what the page reads after a step
    if (body >= 0) {
      bridge_coordinates(body);
      bridge_body(body);
      bridge_matrix(body);
      bridge_omega2(body);
    }
  }

  // an empty scene in its place, since bodies use the arrays of the model
  if (bridge_begin(0.01) < 0)
    abort();
  forget_models();
  while (list.count > 0)
    free(list.memory[--list.count]);
  return 0;
}
