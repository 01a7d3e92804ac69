/* How far the bases of bodies are wrong on which others act: the scene is made again with richer
 * models, and the shapes of its bodies are compared in their own axes.
 *
 * The mesh of each model is asked what it lacks at the row of the largest shape of each part of the
 * run (precompute/model/basis_judge.h), under what acted on it then. With these directions, and
 * those in which it follows these forces, as further coordinates, all bodies of the scene are
 * stepped again, up to a time. A free body is compared as long as it is where it was in the run:
 * from where the two part, each meets what the other does not, and what differs says nothing of the
 * basis any more.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_run_judge.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/vec3.h"
#include "driver/record/run_placement.h"
#include "driver/run/basis_rerun.h"
#include "driver/scene/scene_run_build.h"
#include "driver/scene/scene_run_crossed.h"
#include "driver/scene/scene_run_forces.h"
#include "driver/scene/scene_run_link.h"
#include "platform/allocate.h"
#include "platform/clock.h"

#define DISTURBANCE 1e-6 /* of the largest shape of a body, by which its start is off */
#define ROUNDING 1e-12   /* of the motion of a body: less is left over by sums */
#define GROWTH_MOST 10   /* of the disturbance, beyond which the runs of a body have parted */
#define FLOPS_MOST 1e11  /* of the polynomials of all models: about seven seconds */
#define FLOPS_ASKED 1e12 /* the same where "judge": "on" asks for it */
#define LOADS_MOST 3     /* looks whose forces the mesh follows */

/* --- rows ------------------------------------------------------------------------------------- */

static bool has_static_start(const scene_body_spec *spec) {
  bool any = false;
  for (int64_t n = 0; n < spec->start.count; n++)
    any = any || strncmp(spec->start.texts[n], "static", strlen("static")) == 0;
  return any;
}

static bool is_scaled(const scene_body_spec *spec) {
  return spec->scale != 1 || spec->stiffness != 1 || spec->density != 1;
}

const char *scene_run_why_not_judged(const scene_run *run, int32_t n) {
  const scene_body_spec *spec = run->bodies[n].spec;
  if (is_scaled(spec) && has_static_start(spec))
    return "the body is scaled and starts at an equilibrium";
  for (int64_t k = 0; k < run->spec.bodies.count; k++) {
    const scene_body_spec *other = run->bodies[k].spec;
    if (other->detail.jump > 0 || other->error > 0 || other->budget > 0)
      return "a body of the scene steps fewer coordinates at times";
  }
  if (run->bodies[n].request.condense > 0 || thrum_model_masters(run->bodies[n].model) > 0)
    return "the body is condensed";
  return basis_rerun_why_not(run->bodies[n].model, run->bodies[n].request.def.integrator);
}

static basis_record *record_of(const scene_run *run, int32_t n) {
  return &run->run.bodies[n].measures.basis;
}

/* Is the body judged with its scene? */
static bool is_judged(const scene_run *run, int32_t n) {
  return run->bodies[n].request.basis.together && record_of(run, n)->memory != NULL;
}

static thrum_status open_looks(const scene_run *run, int32_t n, scene_looks *looks,
                               thrum_error *error) {
  const thrum_model *model = run->bodies[n].model;
  const int64_t size = model->rank + 3 * model->vertex_count;
  THRUM_TRY(thrum_reserve(&looks->memory, SCENE_LOOKS * size, sizeof *looks->memory,
                          "the judgement of the basis", error));
  for (int64_t k = 0; k < SCENE_LOOKS; k++)
    looks->items[k] = (scene_look){.q = looks->memory + k * size,
                                   .forces = looks->memory + k * size + model->rank};
  return THRUM_OK;
}

static thrum_status note_body(scene_run *run, int32_t n, int64_t step, thrum_error *error) {
  const scene_body_spec *spec = run->bodies[n].spec;
  const int64_t rank = run->bodies[n].model->rank;
  scene_looks *looks = &run->looks[run->models.of_body[n]];
  double q[THRUM_RANK_MAX];
  if (looks->memory == NULL)
    THRUM_TRY(open_looks(run, n, looks, error));

  // the largest shape of a part of the run, of all bodies of this model
  const int64_t part = (step - 1) * SCENE_LOOKS / run->steps;
  scene_look *look = &looks->items[part < SCENE_LOOKS ? part : SCENE_LOOKS - 1];
  THRUM_TRY(thrum_scene_body_shape(run->scene, n, q, error));
  const double size = cblas_ddot((int)rank, q, 1, q, 1);
  if (!(size > look->size) || !isfinite(size))
    return THRUM_OK;
  look->size = size;
  look->rate = sqrt(spec->stiffness / spec->density) / spec->scale;
  memcpy(look->q, q, (size_t)rank * sizeof *q);
  return scene_run_forces(run, n, step, look->forces, look->acceleration, error);
}

thrum_status scene_run_judge_note(scene_run *run, int64_t step, thrum_error *error) {
  for (int32_t n = 0; n < run->run.body_count && step > 0; n++) {
    if (!is_judged(run, n))
      continue;
    if (run->looks == NULL)
      THRUM_TRY(thrum_reserve(&run->looks, run->models.count, sizeof *run->looks,
                              "the judgement of the basis", error));
    THRUM_TRY(note_body(run, n, step, error));
  }
  return THRUM_OK;
}

void scene_run_judge_close(scene_run *run) {
  for (int64_t n = 0; run->looks != NULL && n < run->models.count; n++)
    free(run->looks[n].memory);
  free(run->looks);
  run->looks = NULL;
}

/* --- richer models ---------------------------------------------------------------------------- */

/* A scene that is made again. */
typedef struct copy {
  scene_run run;
  double *starts; /* 2 THRUM_RANK_MAX of each body, one behind the other */
} copy;

typedef struct again {
  scene_run *run;             /* the one that was made */
  copy richer_run;            /* with richer models, */
  copy disturbed;             /* and with the same ones, from starts that are a little off */
  thrum_richer_model *richer; /* of each model; no change: it stays as it is */
  double *mass;               /* of each model in its file [kg] */
  double flops;               /* of the polynomials that may be made yet */
  int64_t instants;
} again;

/* The square of the rate of the motion of all bodies of a model, in its own time. */
static double rate_of(const scene_run *run, int64_t model) {
  double speed = 0, size = 0;
  for (int32_t n = 0; n < run->run.body_count; n++) {
    const basis_record *record = record_of(run, n);
    const scene_body_spec *spec = run->bodies[n].spec;
    const double s = spec->scale;
    if (run->models.of_body[n] != model || !is_judged(run, n))
      continue;

    // p is of the scaled body, q of the model in its file
    for (int64_t k = 0; k < record->count; k++) {
      size += record->rows[k].size;
      speed += cblas_ddot((int)record->model->rank, record->rows[k].p, 1, record->rows[k].p, 1) /
               (s * s * s * spec->stiffness);
    }
  }
  return size > 0 ? speed / size : 0;
}

/* Looks at all rows of a model, and makes its richer one of what they lack. */
static thrum_status look_at_all(again *a, int64_t n, thrum_basis_judge *judge, int64_t added,
                                thrum_error *error) {
  const scene_looks *looks = &a->run->looks[n];
  const thrum_model *model = a->run->models.items[n].model;
  const int64_t all = 3 * model->vertex_count;
  const double *masses = thrum_basis_judge_masses(judge), rate2 = rate_of(a->run, n);
  double *loads = NULL;
  int64_t count = 0;
  THRUM_TRY(
      thrum_reserve(&loads, LOADS_MOST * all, sizeof *loads, "the judgement of the basis", error));

  a->mass[n] = cblas_dasum((int)model->vertex_count, masses, 1);
  thrum_status status = THRUM_OK;
  for (int64_t k = 0; k < SCENE_LOOKS && status >= 0; k++) {
    const scene_look *look = &looks->items[k];
    double moved, lacking;
    if (!(look->size > 0))
      continue;
    for (int64_t c = 0; c < all; c++)
      look->forces[c] += masses[c / 3] * look->acceleration[c % 3];
    status = thrum_basis_judge_look(judge, look->q, look->forces, rate2, &moved, &lacking, error);
    a->instants++;

    // the forces of the first, the middle and the last part are followed
    if (k % ((SCENE_LOOKS - 1) / (LOADS_MOST - 1)) == 0 && count < LOADS_MOST)
      memcpy(loads + count++ * all, look->forces, (size_t)all * sizeof *loads);
  }
  THRUM_THEN(status,
             thrum_richer_model_make(model, judge, loads, count, added, &a->richer[n], error));
  free(loads);
  return status;
}

/* The richer model of those that are judged, where the mesh asks for one in the time that there is.
 */
static thrum_status enrich(again *a, int64_t n, const basis_asked *asked, basis_estimate *estimate,
                           thrum_error *error) {
  thrum_basis_judge *judge = NULL;
  THRUM_TRY(basis_estimate_judge(a->run->models.items[n].model, SCENE_LOOKS, asked, &judge,
                                 estimate, error));
  if (judge == NULL)
    return THRUM_OK;
  const int64_t added =
      basis_rerun_added(thrum_basis_judge_statics(judge), a->run->models.items[n].model, &a->flops);
  thrum_status status = THRUM_OK;
  if (added > 0)
    status = look_at_all(a, n, judge, added, error);
  if (added == 0)
    *estimate = basis_estimate_none("a richer model would take too long");
  thrum_basis_judge_free(judge);
  return status;
}

/* What keeps the bodies of a model from being judged is said of each. */
static void give_up(const scene_run *run, int64_t model, const basis_estimate *estimate) {
  for (int32_t n = 0; n < run->run.body_count; n++)
    if (is_judged(run, n) && (model < 0 || run->models.of_body[n] == model))
      record_of(run, n)->estimate = *estimate;
}

static thrum_status enrich_all(again *a, thrum_error *error) {
  const scene_run *run = a->run;
  for (int64_t n = 0; n < run->models.count; n++) {
    basis_estimate estimate = basis_estimate_none(NULL);
    thrum_error detail = {0};
    if (run->looks[n].memory == NULL)
      continue;
    const thrum_status status = enrich(a, n, &run->spec.outputs.basis, &estimate, &detail);

    // a mesh that cannot be solved says nothing against the run
    if (status == THRUM_OUT_OF_MEMORY) {
      *error = detail;
      return status;
    }
    if (status < 0)
      estimate = basis_estimate_none("the mesh could not be solved");
    if (estimate.why != NULL)
      give_up(run, n, &estimate);
  }
  return THRUM_OK;
}

/* --- the scene again -------------------------------------------------------------------------- */

/* The richer model of a body that is judged; NULL: it has none. */
static const thrum_richer_model *richer_of(const again *a, int32_t n) {
  const thrum_richer_model *richer = &a->richer[a->run->models.of_body[n]];
  return is_judged(a->run, n) && richer->change != NULL ? richer : NULL;
}

/* q of a scaled body over q of its model in the file [1]. */
static double scale_of_q(const scene_body_spec *spec) {
  const double s = spec->scale;
  return s * sqrt(spec->density * s * s * s);
}

/* The start of a body: where it was in its first row, with the coordinates of its richer model or
 * its own. */
static thrum_status make_start(const again *a, int32_t n, bool richer, double *start,
                               thrum_error *error) {
  const thrum_richer_model *to = richer ? richer_of(a, n) : NULL;
  const scene_body_run *body = &a->run->bodies[n];
  if (to == NULL) {
    memcpy(start, body->start, 2 * (size_t)body->model->rank * sizeof *start);
    return THRUM_OK;
  }
  THRUM_TRY(basis_rerun_start(record_of(a->run, n), to, start, start + to->model.rank, error));

  cblas_dscal((int)to->model.rank, scale_of_q(body->spec), start, 1);
  return THRUM_OK;
}

/* A start that is off by DISTURBANCE of the largest shape of the body in the run. */
static void disturb(const again *a, int32_t n, double *q) {
  const basis_record *record = record_of(a->run, n);
  const double size = scale_of_q(a->run->bodies[n].spec) * sqrt(record->rows[BASIS_ROWS_MAX].size);
  for (int64_t i = 0; i < record->model->rank; i++)
    q[i] += DISTURBANCE * size * (i % 2 == 0 ? 1 : -1) / (double)(i + 1);
}

/* Models and bodies of a copy, and its scene. */
static thrum_status make_copy(const again *a, bool richer, copy *to, thrum_error *error) {
  const scene_run *run = a->run;
  scene_run *made = &to->run;
  const int64_t count = run->spec.bodies.count;
  made->request = run->request;
  made->spec = run->spec;
  made->steps = run->steps;
  made->dt = run->dt;

  // the same models and the richer ones behind them, whose surfaces are made anew
  const int64_t models = run->models.count;
  THRUM_TRY(thrum_reserve(&made->models.items, 2 * models, sizeof *made->models.items, "the scene",
                          error));
  made->models.count = 2 * models;
  for (int64_t n = 0; n < 2 * models; n++) {
    made->models.items[n] = run->models.items[n % models];
    made->models.items[n].skin = (display_surface){0};
    made->models.items[n].corners = NULL;
    if (n >= models)
      made->models.items[n].model = &a->richer[n - models].model;
  }

  // bodies begin where they were
  THRUM_TRY(thrum_reserve(&made->bodies, count, sizeof *made->bodies, "the scene", error));
  THRUM_TRY(thrum_reserve(&made->models.of_body, count, sizeof *made->models.of_body, "the scene",
                          error));
  THRUM_TRY(thrum_reserve(&to->starts, 2 * THRUM_RANK_MAX * count, sizeof *to->starts, "the scene",
                          error));
  for (int32_t n = 0; n < count; n++) {
    double *start = to->starts + 2 * THRUM_RANK_MAX * n;
    THRUM_TRY(make_start(a, n, richer, start, error));
    if (!richer && is_judged(run, n))
      disturb(a, n, start);
    made->bodies[n].given = start;
    made->models.of_body[n] =
        run->models.of_body[n] + (richer && richer_of(a, n) != NULL ? models : 0);
  }
  return scene_run_make(made, error);
}

static void free_copy(copy *of) {
  for (int64_t n = 0; n < of->run.models.count; n++) {
    display_surface_free(&of->run.models.items[n].skin);
    free(of->run.models.items[n].corners);
  }
  if (of->run.request != NULL)
    scene_run_unmake(&of->run);
  free(of->run.models.items);
  free(of->run.models.of_body);
  free(of->starts);
}

static void free_again(again *a) {
  free_copy(&a->richer_run);
  free_copy(&a->disturbed);
  for (int64_t n = 0; a->richer != NULL && n < a->run->models.count; n++)
    thrum_richer_model_free(&a->richer[n]);
  free(a->richer);
  free(a->mass);
}

/* --- comparison ------------------------------------------------------------------------------- */

#define POINTS 8

/* Sums over the rows of mean squares over a body [m^2, m^2/s^2], of differences and of the richer
 * run; in the world, and of the shape alone in the axes of the body. */
typedef struct sums {
  double lacking, moved, slower, fast, shape_lacking, shape;
  double at[POINTS][3];          /* that move as a homogeneous box does, in the mesh [m] */
  double before[2][POINTS][3];   /* where they were in the last row, of the run and of this one */
  double first[POINTS][3], time; /* at the start, and of the last row [s] */
  double disturbed;              /* how far the disturbance was at the start [m] */
  double until;
  int64_t rows;
  bool parted;
} sums;

/* The points of a body: the second moments of a box about its middle are those of its corners at
 * 1 / sqrt(3) of the way. */
static void place_points(const scene_run *run, int32_t n, sums *to) {
  const thrum_model *model = run->bodies[n].model;
  double least[3], most[3];
  thrum_box3(model->vertices, model->vertex_count, least, most);
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < POINTS; k++)
      to->at[k][axis] = 0.5 * (least[axis] + most[axis]) +
                        ((k >> axis) & 1 ? 0.5 : -0.5) * (most[axis] - least[axis]) / sqrt(3);
}

/* Adds the motion of the axes of a body in both runs. */
static void compare_axes(const double *of_run, const double *of_this, double time, sums *to) {
  double now[2][POINTS][3];
  const double between = to->rows > 0 ? time - to->time : INFINITY;
  for (int k = 0; k < POINTS; k++) {
    run_placement_point(of_run, to->at[k], now[0][k]);
    run_placement_point(of_this, to->at[k], now[1][k]);
    if (to->rows == 0)
      memcpy(to->first[k], now[1][k], sizeof now[1][k]);
    for (int axis = 0; axis < 3; axis++) {
      const double differs = now[1][k][axis] - now[0][k][axis];
      const double way = now[1][k][axis] - to->first[k][axis];
      const double v = (now[1][k][axis] - to->before[1][k][axis]) / between;
      const double dv = v - (now[0][k][axis] - to->before[0][k][axis]) / between;
      to->lacking += differs * differs / POINTS;
      to->moved += way * way / POINTS;
      to->slower += dv * dv / POINTS;
      to->fast += v * v / POINTS;
    }
  }
  memcpy(to->before, now, sizeof now);
  to->time = time;
}

/* How far the disturbance of a body is now, over what it was at the start. */
static thrum_status find_growth(const again *a, int32_t n, const basis_row *row, sums *to,
                                thrum_error *error) {
  const int64_t rank = a->run->bodies[n].model->rank;
  const double mass = a->mass[a->run->models.of_body[n]], s = a->run->bodies[n].spec->scale;
  double q[THRUM_RANK_MAX], matrix[16], apart = 0;
  thrum_scene_body_matrix(a->disturbed.run.scene, n, matrix);
  THRUM_TRY(thrum_scene_body_shape(a->disturbed.run.scene, n, q, error));
  for (int64_t i = 0; i < rank; i++)
    apart += s * s / mass * (q[i] - row->q[i]) * (q[i] - row->q[i]);
  for (int k = 0; k < POINTS; k++) {
    double x[3], y[3];
    run_placement_point(row->placement, to->at[k], x);
    run_placement_point(matrix, to->at[k], y);
    for (int axis = 0; axis < 3; axis++)
      apart += (x[axis] - y[axis]) * (x[axis] - y[axis]) / POINTS;
  }
  if (to->rows == 0)
    to->disturbed = sqrt(apart);
  to->parted = !(sqrt(apart) <= GROWTH_MOST * to->disturbed);
  return THRUM_OK;
}

static thrum_status compare(const again *a, int32_t n, const basis_row *row, sums *to,
                            thrum_error *error) {
  const thrum_richer_model *richer = richer_of(a, n);
  const scene_body_spec *spec = a->run->bodies[n].spec;
  thrum_scene *scene = a->richer_run.run.scene;
  const int64_t rank = a->run->bodies[n].model->rank;
  const double time = (double)row->step * a->run->dt, s = spec->scale;
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX], matrix[16];
  if (richer == NULL || to->parted)
    return THRUM_OK;
  if (to->rows == 0)
    place_points(a->run, n, to);
  THRUM_TRY(find_growth(a, n, row, to, error));
  if (to->parted)
    return THRUM_OK;
  thrum_scene_body_matrix(scene, n, matrix);
  compare_axes(row->placement, matrix, time, to);
  THRUM_TRY(thrum_scene_body_shape(scene, n, q, error));
  THRUM_TRY(thrum_scene_body_get(scene, n, NULL, p, error));

  // means over the mass: of q in the model of the file, of p in the body as it is scaled
  const double mass = a->mass[a->run->models.of_body[n]];
  const double of_q = s * s / mass, of_p = 1 / (mass * spec->density * s * s * s);
  double lacking = 0, shape = 0;
  for (int64_t k = 0; k < richer->model.rank; k++) {
    const double *change = richer->change + k * rank;
    const double dq = q[k] - cblas_ddot((int)rank, change, 1, row->q, 1);
    const double dp = p[k] - cblas_ddot((int)rank, change, 1, row->p, 1);
    lacking += of_q * dq * dq;
    shape += of_q * q[k] * q[k];
    to->slower += of_p * dp * dp;
    to->fast += of_p * p[k] * p[k];
  }
  to->lacking += lacking;
  to->moved += shape;
  to->shape_lacking += lacking;
  to->shape += shape;
  to->until = time;
  to->rows++;
  return THRUM_OK;
}

/* The record whose rows are those of all bodies. */
static const basis_record *any_record(const scene_run *run) {
  for (int32_t n = 0; n < run->run.body_count; n++)
    if (is_judged(run, n))
      return record_of(run, n);
  return NULL;
}

/* Steps both copies up to a step; false: one failed, or the time is over. */
static bool step_to(again *a, int64_t target, int64_t *step, double end) {
  for (; *step < target; ++*step)
    if (clock_seconds() > end || thrum_scene_step(a->richer_run.run.scene, NULL) < 0 ||
        thrum_scene_step(a->disturbed.run.scene, NULL) < 0)
      return false;
  return true;
}

/* Steps as far as there is time, and compares all rows on the way. */
static thrum_status step_all(again *a, sums *of, thrum_error *error) {
  const basis_record *rows = any_record(a->run);
  const double end =
      clock_seconds() + basis_rerun_seconds(&a->run->spec.outputs.basis, a->run->run.seconds_step);
  int64_t step = 0;
  for (int64_t k = 0; k < rows->count && step_to(a, rows->rows[k].step, &step, end); k++)
    for (int32_t n = 0; n < a->run->run.body_count; n++)
      if (is_judged(a->run, n))
        THRUM_TRY(compare(a, n, &record_of(a->run, n)->rows[k], &of[n], error));
  return THRUM_OK;
}

static void conclude(const again *a, const sums *of, double seconds) {
  for (int32_t n = 0; n < a->run->run.body_count; n++) {
    const thrum_richer_model *richer = richer_of(a, n);
    const sums *sum = &of[n];
    if (!is_judged(a->run, n) || richer == NULL)
      continue;
    basis_estimate *estimate = &record_of(a->run, n)->estimate;
    estimate->seconds = seconds;
    estimate->instants = a->instants;
    if (!(sum->moved > 0) || !isfinite(sum->lacking) || !isfinite(sum->moved))
      continue;
    estimate->why = NULL;

    // what meets others is no bound: with another basis it meets them otherwise, and not always
    // nearer to what the mesh would do
    estimate->about = scene_run_is_met(a->run, n);
    estimate->share = sqrt(sum->lacking / sum->moved);

    // a body that nothing deforms has no shape to be wrong
    if (a->run->bodies[n].spec->free && sqrt(sum->shape / sum->moved) > ROUNDING)
      estimate->shape = sqrt(sum->shape_lacking / sum->shape);
    estimate->velocity = sum->fast > 0 ? sqrt(sum->slower / sum->fast) : NAN;
    estimate->until = sum->until;
    estimate->parted = sum->parted;
    estimate->added = richer->model.rank - a->run->bodies[n].model->rank;
  }
}

static thrum_status judge(again *a, thrum_error *error) {
  const scene_run *run = a->run;
  const double began = clock_seconds();
  const bool asked = run->spec.outputs.basis.judging == BASIS_JUDGE_ON;
  sums *of = NULL;
  THRUM_TRY(thrum_reserve(&a->richer, run->models.count, sizeof *a->richer,
                          "the judgement of the basis", error));
  THRUM_TRY(thrum_reserve(&a->mass, run->models.count, sizeof *a->mass,
                          "the judgement of the basis", error));
  a->flops = asked ? FLOPS_ASKED : FLOPS_MOST;
  THRUM_TRY(enrich_all(a, error));
  bool any = false;
  for (int64_t n = 0; n < run->models.count; n++)
    any = any || a->richer[n].change != NULL;
  if (!any)
    return THRUM_OK;

  THRUM_TRY(
      thrum_reserve(&of, run->run.body_count, sizeof *of, "the judgement of the basis", error));
  thrum_status status = make_copy(a, true, &a->richer_run, error);
  THRUM_THEN(status, make_copy(a, false, &a->disturbed, error));
  THRUM_THEN(status, step_all(a, of, error));
  if (status >= 0)
    conclude(a, of, clock_seconds() - began);
  free(of);
  return status;
}

/* Did the energy of a body grow, or surfaces go through each other? */
static bool is_lost(const scene_run *run) {
  bool lost = scene_run_have_crossed(run);
  for (int32_t n = 0; n < run->run.body_count; n++)
    lost = lost || run->run.bodies[n].figures.energy_grew;
  return lost;
}

thrum_status scene_run_judge(scene_run *run, thrum_error *error) {
  again a = {.run = run};
  thrum_error detail = {0};
  if (run->looks == NULL || run->run.status < 0)
    return THRUM_OK;

  // a motion that was lost says nothing of the bases
  if (is_lost(run)) {
    const basis_estimate none = basis_estimate_none("the run of the scene was lost");
    give_up(run, -1, &none);
    return THRUM_OK;
  }
  const thrum_status status = judge(&a, &detail);
  free_again(&a);

  // a scene that cannot be made again is told
  if (status == THRUM_OUT_OF_MEMORY) {
    *error = detail;
    return status;
  }
  if (status < 0) {
    const basis_estimate none = basis_estimate_none("the scene could not be made again");
    give_up(run, -1, &none);
  }
  for (int32_t n = 0; n < run->run.body_count; n++)
    run->run.bodies[n].figures.basis_wrong =
        basis_estimate_is_large(&record_of(run, n)->estimate, &run->bodies[n].request.basis);
  return THRUM_OK;
}
