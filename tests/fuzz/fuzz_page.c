/* Fuzz target of what the viewer's page does with its archive: the arrays of a model and a scene as
 * the page hands them over (docs/viewer.md), behind the checks that the page makes of them. An
 * input is decisions and numbers.
 * sources: scene/*.c javascript/bridge_*.c viewer/page.c viewer/page_touches.c viewer/pick.c
 * core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c contact/*.c SPDX-License-Identifier: Apache-2.0 */
#include <float.h>

#include "tests/fuzz/fuzz_draw.h"
#include "tests/fuzz/fuzz_file.h"

// a page has its models for as long as it lives, and an input only for itself
#include "viewer/page_model.c"

#define RANK_MOST 6
#define VERTICES_MOST 8
#define TRIANGLES_MOST 8

// what the page imports of the module
void *js_def(int32_t record);
thrum_scene *js_scene_create(double dt);
void js_scene_destroy(thrum_scene *scene);
int32_t page_add_body(thrum_scene *scene, int32_t model, int32_t integrator, double alpha,
                      const double *q, const double *p);
int32_t js_scene_set_collisions(thrum_scene *scene, int32_t on);
int32_t js_obstacle_turn(void);
int32_t js_scene_obstacle(thrum_scene *scene, int32_t number);
int32_t js_scene_load(thrum_scene *scene, int32_t body);
int32_t js_scene_base_motion(thrum_scene *scene);
int32_t js_scene_base_record(thrum_scene *scene, thrum_base_motion *memory, int32_t count,
                             const double *samples);
int32_t js_scene_gravity(thrum_scene *scene);
int32_t js_scene_wind(thrum_scene *scene);
int32_t js_scene_dt(thrum_scene *scene, double dt);
int32_t js_body_damping(thrum_scene *scene, int32_t body, double alpha, double beta);
int32_t js_body_stiffness(thrum_scene *scene, int32_t body, double stiffness);
int32_t js_body_integrator(thrum_scene *scene, int32_t body, int32_t integrator);
int32_t js_body_rank(thrum_scene *scene, int32_t body, int32_t rank);
int32_t js_scene_reset(thrum_scene *scene);
int32_t js_scene_step(thrum_scene *scene);
int32_t page_shape(thrum_scene *scene, int32_t body, float *out);
int32_t js_body_coordinates(thrum_scene *scene, int32_t body, double *q, double *p);
int32_t js_body_energies(thrum_scene *scene, int32_t body);
int32_t js_scene_account(thrum_scene *scene);
int32_t js_body_info(const thrum_scene *scene, int32_t body);
void js_body_matrix(const thrum_scene *scene, int32_t body);
const double *page_omega2(const thrum_scene *scene, int32_t body);
const double *page_stepped_frequencies(const thrum_scene *scene, int32_t body);
int32_t page_pull_start(thrum_scene *scene, int32_t body, int32_t vertex, double strength);
int32_t js_pull_move(thrum_scene *scene, int32_t pull);
int32_t js_pull_end(thrum_scene *scene, int32_t pull);
int32_t js_pull_get(thrum_scene *scene, int32_t pull);
const float *page_touches(thrum_scene *scene);
int32_t page_touch_count(void);
int32_t page_pick(thrum_scene *scene);

#define MOTIONS_MAX 16

static thrum_scene *scene;
static thrum_base_motion motions[MOTIONS_MAX];
static double *motion_samples[MOTIONS_MAX];
static int32_t motion_count;

const char *__asan_default_options(void);

/* The page returns no memory of models that it refuses. */
const char *__asan_default_options(void) {
  return "detect_leaks=0";
}

static void forget_models(void) {
  for (int32_t n = 0; n <= model_count && n < MODELS_MAX; n++) {
    page_model *made = &models[n];
    void *owned[] = {(void *)made->model.vertices,
                     (void *)made->model.basis,
                     (void *)made->model.rigid,
                     (void *)made->model.packed,
                     (void *)made->surface,
                     made->positions,
                     made->touch};
    for (size_t k = 0; k < sizeof owned / sizeof *owned; k++)
      free(owned[k]);
    *made = (page_model){0};
  }
  model_count = 0;
}

/* Numbers as in a body of this size, in memory of the page. */
static double *numbers(fuzz_draw *draw, int64_t count, double size) {
  double *made = js_alloc((size_t)count * sizeof *made);
  for (int64_t n = 0; n < count; n++)
    made[n] = draw_about(draw, size);
  return made;
}

static float *small_numbers(fuzz_draw *draw, int64_t count) {
  float *made = js_alloc((size_t)count * sizeof *made);
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
  uint8_t *fixed = keep(list, js_alloc((size_t)v));
  for (int32_t n = 0; n < v; n++)
    fixed[n] = (uint8_t)draw_byte(draw);
  int32_t *triangles = keep(list, js_alloc((size_t)t * 3 * sizeof *triangles));
  for (int32_t n = 0; n < 3 * t; n++)
    triangles[n] = (int32_t)draw_index(draw, v);

  // these are copied
  float *positions = small_numbers(draw, 3 * v), *basis = small_numbers(draw, 3 * v * r);
  double *tet = is_free ? numbers(draw, 12, 1) : NULL;
  double *tet_rigid = is_free ? numbers(draw, 72, 1) : NULL;
  js_number[0] = draw_above(draw, 64);
  js_number[1] = draw_above(draw, 64);
  // a model of a polynomial, without points of a cubature
  const page_arrays arrays = {.omega2 = omega2,
                              .c3 = c3,
                              .c4 = c4,
                              .axis_mass = axis_mass,
                              .fixed = fixed,
                              .triangles = triangles,
                              .positions = positions,
                              .basis = basis,
                              .tet = tet,
                              .tet_rigid = tet_rigid};
  const int32_t number = page_add_model(r, v, t, 0, 0, 0, &arrays);
  free(positions);
  free(basis);
  free(tet);
  free(tet_rigid);
  return number;
}

/* Draws the first `count` shared numbers, which the page sets before a call. */
static void set_numbers(fuzz_draw *draw, int count, double size) {
  for (int n = 0; n < count; n++)
    js_number[n] = draw_about(draw, size);
}

/* Fills the fields of a def that are numbers, some with what no def may have. */
static void fill_def(fuzz_draw *draw, thrum_scene_record record) {
  char *def = js_def((int32_t)record);
  int64_t count;
  const thrum_field *fields = thrum_scene_fields(record, &count);
  for (const thrum_field *field = fields; field < fields + count; field++) {
    void *at = def + field->offset;
    const bool factor = field->above != 0;
    for (int32_t n = 0; field->kind == THRUM_FIELD_DOUBLE && n < field->width; n++)
      ((double *)at)[n] = factor ? draw_above(draw, 64) : draw_about(draw, 1);
    if (field->kind == THRUM_FIELD_FLAG || field->kind == THRUM_FIELD_CHOICE)
      *(int32_t *)at = (int32_t)draw_index(draw, field->kind == THRUM_FIELD_FLAG ? 2 : 4);
  }
}

static int32_t add_body(fuzz_draw *draw, int32_t model, int32_t rank) {
  double *q = draw_byte(draw) % 2 == 0 ? numbers(draw, rank, 0.1) : NULL;
  fill_def(draw, THRUM_SCENE_RECORD_BODY);
  thrum_scene_body_def *def = js_def_made();
  def->condense = draw_byte(draw) % 4 == 0 ? draw_index(draw, rank + 2) : 0;
  def->rank = draw_byte(draw) % 4 == 0 ? draw_index(draw, rank + 2) : 0;
  const double alpha = draw_byte(draw) % 4 == 0 ? draw_above(draw, 1) : 0;
  const int32_t body = page_add_body(scene, model, (int32_t)draw_index(draw, 10), alpha, q, NULL);
  free(q);
  return body;
}

static void act(fuzz_draw *draw, int32_t body, int32_t rank, int32_t vertices) {
  static float shape[THRUM_RANK_MAX];
  double *reduced, *parts;
  thrum_scene_load_def *load;
  int64_t count;

  // one call of the page; three of twenty are steps
  switch (draw_byte(draw) % 20) {
  case 0:
    set_numbers(draw, 3, 10);
    js_scene_gravity(scene);
    break;
  case 1:
    js_scene_dt(scene, draw_above(draw, 0.01));
    break;
  case 2:
    js_body_damping(scene, body, draw_above(draw, 1), 0);
    break;
  case 3:
    js_body_stiffness(scene, body, draw_above(draw, 64));
    break;
  case 4:
    js_body_integrator(scene, body, (int32_t)draw_index(draw, 11) - 1);
    break;
  case 5:
    js_body_rank(scene, body, (int32_t)draw_index(draw, rank + 3) - 1);
    break;
  case 6:
    js_scene_reset(scene);
    break;
  case 7:
    set_numbers(draw, 3, 1);
    page_pull_start(scene, body, (int32_t)draw_index(draw, vertices + 6) - 1, draw_above(draw, 64));
    break;
  case 8:
    set_numbers(draw, 3, 1);
    js_pull_move(scene, (int32_t)draw_index(draw, 4) - 1);
    break;
  case 9:
    js_pull_get(scene, (int32_t)draw_index(draw, 4) - 1);
    js_pull_end(scene, (int32_t)draw_index(draw, 4) - 1);
    break;
  case 10:
    set_numbers(draw, 6, 1);
    page_pick(scene);
    page_touches(scene);
    page_touch_count();
    break;
  case 11:
    set_numbers(draw, 4, 1);
    fill_def(draw, THRUM_SCENE_RECORD_OBSTACLE);
    js_obstacle_turn();
    js_scene_obstacle(scene, -1);
    break;
  case 12:
    fill_def(draw, THRUM_SCENE_RECORD_LOAD);
    load = js_def_made();
    reduced = numbers(draw, rank, 1);
    parts = draw_byte(draw) % 2 == 0 ? numbers(draw, 9 * rank, 1) : NULL;
    load->kind = draw_byte(draw) % 8 == 0 ? load->kind : THRUM_SCENE_REDUCED;
    load->reduced = reduced;
    load->rank = draw_byte(draw) % 8 == 0 ? draw_index(draw, rank + 2) : rank;
    load->parts = parts;
    js_scene_load(scene, body);
    free(reduced);
    free(parts);
    break;
  case 13:
    fill_def(draw, THRUM_SCENE_RECORD_LOAD);
    js_scene_base_motion(scene);
    break;
  case 14:
    if (motion_count == MOTIONS_MAX)
      break;
    count = draw_index(draw, 4);
    reduced = numbers(draw, 10 * count, 1);
    for (int64_t n = 0; n < count; n++)
      reduced[n] = draw_byte(draw) % 8 != 0 ? (double)n : reduced[n];
    motion_samples[motion_count] = reduced;
    js_scene_base_record(scene, &motions[motion_count++], (int32_t)count, reduced);
    break;
  case 15:
    fill_def(draw, THRUM_SCENE_RECORD_WIND);
    js_scene_wind(scene);
    break;
  case 16:
    fill_def(draw, THRUM_SCENE_RECORD_PAIRS);
    js_scene_set_collisions(scene, (int32_t)draw_index(draw, 2));
    break;
  case 17:
    page_stepped_frequencies(scene, body);
    break;
  default:
    js_scene_step(scene);
    if (page_shape(scene, body, shape) >= 0)
      js_body_energies(scene, body);
    js_scene_account(scene);
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  fuzz_draw draw = {data, size};
  kept list = {0};
  int32_t rank, vertices;
  const int32_t model = add_model(&draw, &list, &rank, &vertices);
  scene = js_scene_create(draw_above(&draw, 0.01));
  if (model >= 0 && scene != NULL) {
    const int32_t body = add_body(&draw, model, rank);
    if (body >= 0 && draw_byte(&draw) % 2 == 0)
      add_body(&draw, model, rank);
    while (body >= 0 && draw.left > 0)
      act(&draw, body, rank, vertices);

    // what the page reads after a step
    if (body >= 0) {
      js_body_coordinates(scene, body, js_number, NULL);
      js_body_info(scene, body);
      js_body_matrix(scene, body);
      page_omega2(scene, body);
    }
  }

  // the scene first, since bodies use the arrays of the model
  js_scene_destroy(scene);
  while (motion_count > 0)
    free(motion_samples[--motion_count]);
  forget_models();
  while (list.count > 0)
    free(list.memory[--list.count]);
  return 0;
}
