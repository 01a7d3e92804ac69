/* Steps bodies for a long time while everything that a program may do to them happens at random:
 * kicks, loads, pulls, obstacles, changes of dt, of damping, of rank and of integrator, snapshots
 * and restores, condensed bodies, batches, scenes. After each stretch of steps it looks at what
 * must hold:
 *
 *   - no number of a state is NaN or infinite;
 *   - a snapshot that is put back leads to the same bits;
 *   - energy that neither start nor loads explain does not come without a status that says so;
 *   - `energy` keeps its balance, in free motion and under loads, to BALANCE_ENERGY of the largest
 *     energy that start and loads explain.
 *
 *   soak STEPS SEED MODEL.npz...
 *
 * Prints a table of steps and of the worst balance for each integrator and the steps of each model,
 * and ends with 1 at the first thing that does not hold, after a line that says what and where.
 * SPDX-License-Identifier: Apache-2.0 */
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/support/random_model.h"
#include "tests/support/scene_wind_def.h"
#include "thrum/scene.h"

enum { RANK_MOST = 16, MODELS_MOST = 16, BATCH = 6, STRETCHES = 12, SKIN_TETS = 12 };

/* Every integrator; the last one steps condensed bodies alone. */
#define X(name, value, text) +1
enum { INTEGRATORS = 0 THRUM_INTEGRATOR_LIST(X) };
#undef X
_Static_assert(THRUM_INTEGRATOR_MANIFOLD == INTEGRATORS - 1, "manifold is the last");

/* The balance that `energy` promises, and how much more energy than explained the others may
 * have without a word: the status comes when it is as much again, some steps late. */
#define BALANCE_ENERGY 1e-6
#define SILENT_MOST 1.5
#define LOOKS_LATE 3

#define LEAST_ENERGY 1e-300 /* [J], below which there is no motion to speak of */

/* Energy that obstacles may give back beyond what they took, as a share of the energies that went
 * through them. */
#define CONTACT_GAIN 1e-6
#define CONTACT_ROUNDING 1e-10 /* of the force of obstacles times the depth */

typedef struct soak {
  random_state random;
  int64_t steps, wanted, episodes;
  int64_t by_integrator[INTEGRATORS], grown[INTEGRATORS], failed[INTEGRATORS];
  int64_t by_model[MODELS_MOST];
  int64_t contacts, collisions, batches, scenes, condensed, restores, kicks, dt_changes;
  double worst[INTEGRATORS];
  const thrum_model *models[MODELS_MOST];
  const char *names[MODELS_MOST];
  int model_count, model; /* that of the episode */
  char what[256];         /* the episode, for the line of a finding */
} soak;

static _Noreturn void fail(const soak *s, const char *what) {
  printf("finding after %" PRId64 " steps, episode %" PRId64 ": %s: %s\n", s->steps, s->episodes,
         s->what, what);
  exit(1);
}

static void must(const soak *s, thrum_status status, const thrum_error *error) {
  if (status < 0)
    fail(s, error->message);
}

static bool chance(soak *s, int64_t in) {
  return random_index(&s->random, in) == 0;
}

/* 10^a to 10^b. */
static double between(soak *s, double a, double b) {
  return pow(10, a + (b - a) * 0.5 * (1 + random_uniform(&s->random)));
}

static void *block(size_t size) {
  void *memory = aligned_alloc(64, (size + 63) / 64 * 64);
  if (memory == NULL) {
    puts("out of memory");
    exit(2);
  }
  return memory;
}

/* A velocity that carries this energy, in random directions. */
static void random_momentum(soak *s, int64_t rank, double energy, double *p) {
  double square = 0;
  random_vector(&s->random, rank, 1, p);
  for (int64_t n = 0; n < rank; n++)
    square += p[n] * p[n];
  for (int64_t n = 0; n < rank; n++)
    p[n] *= sqrt(2 * energy / square);
}

/* The energy of the lowest mode at a displacement of about a tenth of the body: the measure of all
 * kicks and loads. */
static double measure(const thrum_model *model) {
  double least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
  double q[RANK_MOST] = {0}, square = 0;
  for (int64_t v = 0; v < model->vertex_count; v++)
    for (int axis = 0; axis < 3; axis++) {
      least[axis] = fmin(least[axis], model->vertices[3 * v + axis]);
      most[axis] = fmax(most[axis], model->vertices[3 * v + axis]);
    }
  for (int axis = 0; axis < 3; axis++)
    square += (most[axis] - least[axis]) * (most[axis] - least[axis]);
  if (thrum_mode_add(model, 0, 0.1 * sqrt(square), q, NULL) < 0)
    return 1;
  return 0.5 * model->omega2[0] * q[0] * q[0];
}

static thrum_state_def random_def(soak *s, const thrum_model *model) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = (thrum_integrator)random_index(&s->random, INTEGRATORS - 1);

  // from steps that resolve all modes to those that resolve none; explicit ones fail beyond theirs
  const double fastest = sqrt(model->omega2[model->rank - 1]);
  def.dt = between(s, -1.5, 1.5) / fastest;
  if (chance(s, 3))
    def.damping_alpha = between(s, -3, 0) * sqrt(model->omega2[0]);
  if (chance(s, 3))
    def.damping_beta = between(s, -3, -1) / fastest;
  if (chance(s, 6))
    def.damping_form = THRUM_DAMPING_TANGENT;
  if (chance(s, 4))
    def.solver = THRUM_SOLVER_NEWTON;
  if (chance(s, 4))
    def.split_form = (thrum_split_form)random_index(&s->random, 3);
  def.frequency_matched = !chance(s, 4);
  return def;
}

/* --- one state -------------------------------------------------------------------------------- */

/* The account of a state: what its energy should be. */
typedef struct account {
  double q[RANK_MOST], p[RANK_MOST], force[RANK_MOST]; /* at the last look; the load since then */
  double explained;                                    /* energy of start, kicks and loads [J] */
  double dissipated;                                   /* the report's, at the last look [J] */
  double largest;                                      /* of what was explained */
  double put, put_most; /* energy of start and loads alone, which damping can only lessen [J] */
  int64_t grown;        /* the report's, at the last look */
  bool flagged;         /* since the account began */
  int late;             /* looks with too much energy, unsaid */
} account;

static double energy_of(soak *s, const thrum_model *model, thrum_state *state) {
  thrum_energies energies;
  thrum_error error;
  const thrum_status status = thrum_state_energies(model, state, &energies, &error);
  if (status == THRUM_NOT_FINITE)
    return INFINITY;
  must(s, status, &error);
  return energies.total;
}

/* Begins an account at the present q and p. */
static void open_account(soak *s, const thrum_model *model, thrum_state *state, account *a) {
  thrum_error error;
  const thrum_state_report report = thrum_state_report_get(state);
  must(s, thrum_state_get(model, state, a->q, a->p, &error), &error);
  a->explained = a->largest = energy_of(s, model, state);
  a->dissipated = report.dissipated;
  a->grown = report.grown_steps;
  a->flagged = false;
  a->late = 0;
  a->put = a->put_most = a->explained;
}

/* Looks at a state after a stretch of steps under one load. */
static void look(soak *s, const thrum_model *model, thrum_state *state, thrum_integrator integrator,
                 account *a) {
  double q[RANK_MOST], p[RANK_MOST];
  thrum_error error;
  const thrum_status status = thrum_state_get(model, state, q, p, &error);
  if (status == THRUM_NOT_FINITE)
    return;
  must(s, status, &error);
  for (int64_t n = 0; n < model->rank; n++)
    if (!isfinite(q[n]) || !isfinite(p[n]))
      fail(s, "a coordinate is not finite");

  // the load is constant between looks, so that its work is exact
  const thrum_state_report report = thrum_state_report_get(state);
  const double work = thrum_load_work(a->force, a->q, q, model->rank);
  const double loss = report.dissipated - a->dissipated;
  a->explained += work - loss;
  a->put += work;
  a->put_most = fmax(a->put_most, fabs(a->put));
  a->dissipated = report.dissipated;
  a->largest = fmax(a->largest, fabs(a->explained));
  memcpy(a->q, q, sizeof q);
  if (report.grown_steps > a->grown || report.energy_steps + report.substep_steps > 0)
    a->flagged = true;
  s->grown[integrator] += report.grown_steps - a->grown;
  a->grown = report.grown_steps;

  // the balance with damping is exact for `energy` alone: the others know their dissipation to
  // second order, so it only tells what a body must not have
  const double energy = energy_of(s, model, state);
  const double over = (energy - a->explained) / fmax(a->largest, LEAST_ENERGY);
  const double made = (energy - a->put) / fmax(a->put_most, LEAST_ENERGY);
  double *worst = &s->worst[integrator];
  if (integrator == THRUM_INTEGRATOR_ENERGY && !a->flagged) {
    *worst = fmax(*worst, fabs(over));
    if (!(fabs(over) <= BALANCE_ENERGY)) {
      char text[160];
      snprintf(text, sizeof text, "energy is off its balance by %g of %g J", over, a->largest);
      fail(s, text);
    }
  } else if (!a->flagged) {
    *worst = fmax(*worst, made);
  }
  a->late = made > SILENT_MOST && !a->flagged ? a->late + 1 : 0;
  if (a->late > LOOKS_LATE) {
    char text[160];
    snprintf(text, sizeof text,
             "%g times the largest energy of start and loads, %g J, is more than that, and no "
             "status says so",
             made, a->put_most);
    fail(s, text);
  }
}

/* A load that stands may do and take back more work between two looks than they show. */
static void follow(const thrum_model *model, thrum_state *state, account *a) {
  double q[RANK_MOST];
  if (thrum_state_get(model, state, q, NULL, NULL) >= 0)
    a->put_most = fmax(a->put_most, fabs(a->put + thrum_load_work(a->force, a->q, q, model->rank)));
}

/* Steps; a state that fails stays as it was, and begins anew at rest. False: it did. */
static bool stretch(soak *s, const thrum_model *model, thrum_state *state,
                    thrum_integrator integrator, int64_t count, account *a) {
  thrum_error error = {0};
  for (int64_t n = 0; n < count; n++) {
    const thrum_status status = thrum_step(model, state, &error);
    if (status < 0 && (error.status != status || error.message[0] == 0))
      fail(s, "a failure without a message");
    if (status < 0) {
      s->failed[integrator]++;
      must(s, thrum_state_set(model, state, NULL, NULL, &error), &error);
      return false;
    }
    s->steps++;
    s->by_integrator[integrator]++;
    s->by_model[s->model]++;
    follow(model, state, a);
  }
  return true;
}

/* The steps from a snapshot have the same bits again. */
static void step_twice(soak *s, const thrum_model *model, thrum_state *state,
                       thrum_integrator integrator, int64_t count, account *a) {
  thrum_error error;
  double q[RANK_MOST], again[RANK_MOST];
  const size_t size = thrum_state_snapshot_size(state);
  void *snapshot = block(size);
  must(s, thrum_state_snapshot(state, snapshot, size, &error), &error);
  if (stretch(s, model, state, integrator, count, a) &&
      thrum_state_get(model, state, q, NULL, &error) >= 0) {
    must(s, thrum_state_restore(model, state, snapshot, size, &error), &error);
    if (!stretch(s, model, state, integrator, count, a))
      fail(s, "a step fails after a restore");
    must(s, thrum_state_get(model, state, again, NULL, &error), &error);
    if (memcmp(q, again, (size_t)model->rank * sizeof *q) != 0)
      fail(s, "other bits after a restore");
  }
  s->restores++;
  free(snapshot);
}

/* Something happens to a state between two stretches; the account goes on or begins anew. */
static void disturb(soak *s, const thrum_model *model, thrum_state *state, double size,
                    thrum_state_def *def, account *a) {
  thrum_error error;
  switch (random_index(&s->random, 4)) {
  case 0: // a kick
    random_momentum(s, model->rank, size * between(s, -3, 1), a->p);
    must(s, thrum_state_set(model, state, a->q, a->p, &error), &error);
    open_account(s, model, state, a);
    s->kicks++;
    break;
  case 1: // another load, or none
    random_momentum(s, model->rank, 1, a->force);
    for (int64_t n = 0; n < model->rank; n++)
      a->force[n] *= chance(s, 4) ? 0 : between(s, -2, 0) * sqrt(size * model->omega2[n]);
    must(s, thrum_state_set_force(model, state, a->force, &error), &error);
    break;
  case 2: // another step
    def->dt *= between(s, -0.3, 0.3);
    if (thrum_state_set_dt(model, state, def->dt, &error) >= 0)
      s->dt_changes++;
    break;
  default:
    break;
  }
}

static void run_state(soak *s, const thrum_model *model, double size) {
  thrum_error error;
  thrum_state *state;
  thrum_state_def def = random_def(s, model);
  account a = {0};
  snprintf(s->what, sizeof s->what, "%s, rank %" PRId64 ", %s, dt %g, damping %g %g %s",
           s->names[s->model], model->rank, thrum_integrator_name(def.integrator), def.dt,
           def.damping_alpha, def.damping_beta, thrum_damping_form_name(def.damping_form));

  // a momentum drawn over four powers of ten
  must(s, thrum_state_create(model, &def, &state, &error), &error);
  random_momentum(s, model->rank, size * between(s, -3, 1), a.p);
  must(s, thrum_state_set(model, state, NULL, a.p, &error), &error);
  open_account(s, model, state, &a);

  // stretches of steps; after a failure the account begins anew
  for (int n = 0; n < STRETCHES; n++) {
    const int64_t count = 16 + random_index(&s->random, 500);
    bool goes_on = true;
    if (chance(s, 4))
      step_twice(s, model, state, def.integrator, 16, &a);
    else
      goes_on = stretch(s, model, state, def.integrator, count, &a);
    if (!goes_on)
      open_account(s, model, state, &a);
    look(s, model, state, def.integrator, &a);
    if (chance(s, 2))
      disturb(s, model, state, size, &def, &a);
  }
  thrum_state_destroy(state);
}

/* --- batches ---------------------------------------------------------------------------------- */

/* States of several defs in one batch end with the bits of states that are stepped one by one. */
static void run_batch(soak *s, const thrum_model *model, double size) {
  thrum_error error;
  thrum_state *together[BATCH], *alone[BATCH];
  thrum_integrator integrators[BATCH];
  size_t work;
  double p[RANK_MOST], q[RANK_MOST], other[RANK_MOST];
  snprintf(s->what, sizeof s->what, "%s, rank %" PRId64 ", a batch", s->names[s->model],
           model->rank);

  // pairs of states that start alike
  for (int n = 0; n < BATCH; n++) {
    const thrum_state_def def = random_def(s, model);
    integrators[n] = def.integrator;
    must(s, thrum_state_create(model, &def, &together[n], &error), &error);
    must(s, thrum_state_create(model, &def, &alone[n], &error), &error);
    random_momentum(s, model->rank, size * between(s, -3, 0), p);
    must(s, thrum_state_set(model, together[n], NULL, p, &error), &error);
    must(s, thrum_state_set(model, alone[n], NULL, p, &error), &error);
  }

  // each step gives both the same status
  must(s, thrum_batch_size(model, &work, &error), &error);
  void *workspace = block(work);
  const int64_t count = 64 + random_index(&s->random, 200);
  for (int64_t k = 0; k < count; k++) {
    thrum_status statuses[BATCH];
    thrum_batch_step(model, together, BATCH, statuses, workspace, work, &error);

    for (int n = 0; n < BATCH; n++) {
      if (thrum_step(model, alone[n], &error) != statuses[n])
        fail(s, "another status than alone");
      s->failed[integrators[n]] += statuses[n] < 0;
      s->steps += 2;
      s->by_integrator[integrators[n]] += 2;
      s->by_model[s->model] += 2;
    }
  }

  // both end with the same finite coordinates
  for (int n = 0; n < BATCH; n++) {
    if (thrum_state_get(model, together[n], q, NULL, &error) >= 0) {
      must(s, thrum_state_get(model, alone[n], other, NULL, &error), &error);
      if (memcmp(q, other, (size_t)model->rank * sizeof *q) != 0)
        fail(s, "other bits than alone");
      for (int64_t i = 0; i < model->rank; i++)
        if (!isfinite(q[i]))
          fail(s, "a coordinate of a batch is not finite");
    }
    thrum_state_destroy(together[n]);
    thrum_state_destroy(alone[n]);
  }
  free(workspace);
  s->batches++;
}

/* --- scenes ----------------------------------------------------------------------------------- */

static void look_at_scene(soak *s, thrum_scene *scene) {
  for (int32_t n = 0; n < thrum_scene_body_count(scene); n++) {
    thrum_scene_body_info info;
    thrum_scene_energies energies;
    thrum_error error;
    double q[RANK_MOST];

    // all that is read is finite
    must(s, thrum_scene_body(scene, n, &info, &error), &error);
    const thrum_status status = thrum_scene_body_shape(scene, n, q, &error);
    for (int64_t i = 0; status >= 0 && i < info.model->rank; i++)
      if (!isfinite(q[i]))
        fail(s, "a coordinate of a scene is not finite");
    if (thrum_scene_body_energies(scene, n, &energies, &error) < 0)
      continue;
    if (!isfinite(energies.total))
      fail(s, "an energy of a scene is not finite");

    // obstacles take energy and give none but by rounding, which also a body that hardly moves has
    // where it is pressed
    const double scale = fabs(info.contact.driven) + fabs(info.contact.lost) +
                         fabs(info.contact.granted) + fabs(info.contact.pulled) +
                         fabs(energies.kinetic) + fabs(energies.potential);
    const double rounding = CONTACT_ROUNDING * info.contact.normal * info.contact.depth;

    // a body that is said to have grown, or was since its report began anew, has no such balance
    if (info.report.grown_steps == 0 && !(info.contact.lost >= -CONTACT_GAIN * scale - rounding)) {
      char text[160];
      snprintf(text, sizeof text, "obstacles gave back %g J more than they took, of %g J, with %s",
               -info.contact.lost, scale, thrum_integrator_name(info.integrator));
      fail(s, text);
    }
  }
}

/* Something happens in a scene between two stretches. */
static void disturb_scene(soak *s, thrum_scene *scene, double size, int32_t *pull) {
  thrum_error error;
  const int32_t body = (int32_t)random_index(&s->random, thrum_scene_body_count(scene));
  thrum_scene_body_info info;
  double point[3] = {0}, velocity[3];
  must(s, thrum_scene_body(scene, body, &info, &error), &error);
  const int64_t vertex = random_index(&s->random, info.model->vertex_count);

  // what a change cannot do it refuses, and the scene goes on
  switch (random_index(&s->random, 9)) {
  case 0:
    thrum_scene_set_dt(scene, thrum_scene_dt(scene) * between(s, -0.3, 0.3), &error);
    s->dt_changes++;
    break;
  case 1:
    thrum_scene_set_damping(scene, body, between(s, -3, 0), chance(s, 2) ? 0 : between(s, -6, -4),
                            &error);
    break;
  case 2:
    thrum_scene_set_integrator(scene, body, (thrum_integrator)random_index(&s->random, INTEGRATORS),
                               &error);
    break;
  case 3:
    thrum_scene_set_rank(scene, body, 1 + random_index(&s->random, info.model->rank), &error);
    break;
  case 4:
    thrum_scene_set_stiffness(scene, body, between(s, -1, 1), &error);
    break;
  case 5:
    if (*pull >= 0) {
      thrum_scene_pull_end(scene, *pull, &error);
      *pull = -1;
    } else if (thrum_scene_body_vertex(scene, body, vertex, point, velocity, &error) >= 0) {
      for (int axis = 0; axis < 3; axis++)
        point[axis] += 0.1 * random_uniform(&s->random);
      thrum_scene_pull_start(scene, body, vertex, point, size * between(s, 0, 3), -1, pull, &error);
    }
    break;
  case 6:
    thrum_scene_reset(scene, &error);
    break;
  case 7:
    for (int axis = 0; axis < 3; axis++)
      point[axis] = 10 * random_uniform(&s->random);
    thrum_scene_set_wind(scene, (thrum_scene_wind_def[1]){wind_of(point, 1.2, 1)}, &error);
    break;
  default:
    for (int axis = 0; axis < 3; axis++)
      point[axis] = 10 * random_uniform(&s->random);
    thrum_scene_set_gravity(scene, point, &error);
  }
}

static bool scene_stretch(soak *s, thrum_scene *scene, int64_t count) {
  thrum_error error;
  bool stopped = false;
  for (int64_t n = 0; n < count; n++) {
    stopped = thrum_scene_step(scene, &error) < 0 || stopped;

    // the scene's steps count for the integrator of each body
    for (int32_t body = 0; body < thrum_scene_body_count(scene); body++) {
      thrum_scene_body_info info;
      must(s, thrum_scene_body(scene, body, &info, &error), &error);
      s->by_integrator[info.integrator] += info.status >= 0;
      s->by_model[s->model] += info.status >= 0;
      s->steps += info.status >= 0;
      s->failed[info.integrator] += info.status < 0 && stopped;
    }

    if (stopped)
      break;
  }
  return !stopped;
}

/* The same bytes of a snapshot after the same steps again. */
static void scene_twice(soak *s, thrum_scene *scene, int64_t count) {
  thrum_error error;
  const size_t size = thrum_scene_snapshot_size(scene);
  void *before = block(size), *after = block(size), *again = block(size);
  must(s, thrum_scene_snapshot(scene, before, size, &error), &error);

  // the steps again from the restored snapshot
  if (scene_stretch(s, scene, count)) {
    must(s, thrum_scene_snapshot(scene, after, size, &error), &error);
    must(s, thrum_scene_restore(scene, before, size, &error), &error);
    scene_stretch(s, scene, count);
    must(s, thrum_scene_snapshot(scene, again, size, &error), &error);
    for (size_t n = 0; n < size; n++)
      if (((char *)after)[n] != ((char *)again)[n]) {
        char text[160];
        snprintf(text, sizeof text, "byte %zu of %zu of the scene is another after a restore", n,
                 size);
        fail(s, text);
      }
  }

  s->restores++;
  free(before);
  free(after);
  free(again);
}

/* The faces of some tetrahedra as a surface, and how wide the body is in x at rest [m]. */
static double draw_surface(soak *s, const thrum_model *model, int32_t triangles[12 * SKIN_TETS]) {
  static const int faces[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  for (int t = 0; t < SKIN_TETS; t++) {
    const int32_t *tet = model->tets + 4 * random_index(&s->random, model->tet_count);
    for (int k = 0; k < 12; k++)
      triangles[12 * t + k] = tet[faces[k]];
  }
  double least = INFINITY, most = -INFINITY;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    least = fmin(least, model->vertices[3 * v]);
    most = fmax(most, model->vertices[3 * v]);
  }
  return most - least;
}

/* Contact between the bodies takes energy and gives none, and what is said of all is finite. */
static void look_at_collisions(soak *s, thrum_scene *scene) {
  thrum_error error;
  thrum_scene_account all;
  const thrum_contact_pairs_report report = thrum_scene_collisions(scene);
  if (!isfinite(report.lost + report.stored + report.normal + report.deepest))
    fail(s, "a number of the contact between bodies is not finite");
  if (thrum_scene_account_get(scene, &all, &error) < 0)
    return;
  if (!isfinite(all.total))
    fail(s, "the energy of all bodies is not finite");
  if (!(report.lost >=
        -CONTACT_GAIN * (fabs(report.lost) + fabs(all.kinetic) + fabs(all.potential))))
    fail(s, "bodies that touch each other gave back more energy than they took");
}

static void run_scene(soak *s, const thrum_model *model, double size) {
  thrum_error error;
  thrum_scene *scene;
  int32_t touch[64], triangles[12 * SKIN_TETS], pull = -1;
  const int64_t count = 1 + random_index(&s->random, 3);
  const bool has_floor = chance(s, 2), collides = count > 1 && chance(s, 2);
  const double width = draw_surface(s, model, triangles);
  snprintf(s->what, sizeof s->what, "%s, a scene of %d bodies%s%s", s->names[s->model], (int)count,
           has_floor ? " with obstacles" : "", collides ? " that touch each other" : "");
  must(s, thrum_scene_create(between(s, -1, 1) / sqrt(model->omega2[0]) / 10, &scene, &error),
       &error);

  // bodies of any size and integrator; some are condensed
  for (int64_t n = 0; n < count; n++) {
    thrum_scene_body_def def = thrum_default_scene_body_def();
    def.model = model;
    def.state = random_def(s, model);
    def.scale = between(s, -0.5, 0.5);
    def.start_mode = 1;
    def.start_amplitude = 0.05 * random_uniform(&s->random);
    if (chance(s, 4) && model->rank > 2) {
      def.condense = 1 + random_index(&s->random, model->rank - 1);
      def.start_mode = 0;
      def.start_amplitude = 0;
      if (chance(s, 2))
        def.state.integrator = THRUM_INTEGRATOR_MANIFOLD;
      s->condensed++;
    }

    // any vertices may touch
    for (int k = 0; k < 64; k++)
      touch[k] = (int32_t)random_index(&s->random, model->vertex_count);
    def.touch = has_floor ? touch : NULL;
    def.touch_count = has_floor ? 64 : 0;
    def.triangles = collides ? triangles : NULL;
    def.triangle_count = collides ? 4 * SKIN_TETS : 0;
    if (collides)
      def.position[0] = width * (double)n * random_uniform(&s->random);
    must(s, thrum_scene_add_body(scene, &def, NULL, &error), &error);
    const size_t length = strlen(s->what);
    snprintf(s->what + length, sizeof s->what - length, ", %s%s",
             thrum_integrator_name(def.state.integrator), def.condense > 0 ? " condensed" : "");
  }

  // an obstacle somewhere in the unit cube
  if (has_floor) {
    thrum_obstacle obstacle = thrum_default_obstacle();
    obstacle.shape = (thrum_obstacle_shape)random_index(&s->random, 3);
    for (int axis = 0; axis < 3; axis++)
      obstacle.centre[axis] = random_uniform(&s->random);
    obstacle.restitution = 0.5 + 0.5 * random_uniform(&s->random);
    must(s, thrum_scene_add_obstacle(scene, &obstacle, NULL, &error), &error);
    s->contacts++;
  }

  if (collides) {
    thrum_contact_pairs_def contact = thrum_default_contact_pairs_def();
    contact.friction = 0.5 + 0.5 * random_uniform(&s->random);
    contact.restitution = 0.5 + 0.5 * random_uniform(&s->random);
    must(s, thrum_scene_set_collisions(scene, &contact, &error), &error);
    s->collisions++;
  }

  // stretches of steps, with what a user may do between them
  for (int n = 0; n < STRETCHES; n++) {
    if (chance(s, 4))
      scene_twice(s, scene, 16);
    else if (!scene_stretch(s, scene, 16 + random_index(&s->random, 100)))
      must(s, thrum_scene_reset(scene, &error), &error);
    look_at_scene(s, scene);
    look_at_collisions(s, scene);
    disturb_scene(s, scene, size, &pull);
  }
  thrum_scene_destroy(scene);
  s->scenes++;
}

/* --- all of it -------------------------------------------------------------------------------- */

/* One model at some rank, and one kind of life for it. */
static void run_episode(soak *s) {
  thrum_error error;
  s->model = (int)random_index(&s->random, s->model_count);
  const thrum_model *whole = s->models[s->model], *model = NULL;
  const int64_t rank = 1 + random_index(&s->random, whole->rank);
  size_t size;
  must(s, thrum_model_lock_size(whole, rank, &size, &error), &error);
  void *memory = block(size);
  must(s, thrum_model_lock(memory, size, whole, rank, &model, &error), &error);

  // a scene or a batch now and then, else a single state
  const double energy = measure(model);
  const int64_t kind = random_index(&s->random, 20);
  if (kind == 0)
    run_batch(s, model, energy);
  else if (kind < 3)
    run_scene(s, model, energy);
  else
    run_state(s, model, energy);
  free(memory);
  s->episodes++;
}

static void report(const soak *s) {
  printf("%" PRId64 " steps in %" PRId64 " episodes, 0 findings\n\n", s->steps, s->episodes);
  printf("| body | steps |\n|---|---|\n");
  for (int n = 0; n < s->model_count; n++)
    printf("| %s | %" PRId64 " |\n", s->names[n], s->by_model[n]);
  printf("\n| integrator | steps | said to have grown | failed | worst unsaid surplus of energy |\n"
         "|---|---|---|---|---|\n");
  for (int n = 0; n < INTEGRATORS; n++)
    printf("| %s | %" PRId64 " | %" PRId64 " | %" PRId64 " | %.2g |\n",
           thrum_integrator_name((thrum_integrator)n), s->by_integrator[n], s->grown[n],
           s->failed[n], s->worst[n]);

  // what was done between the steps
  printf("\n%" PRId64 " kicks, %" PRId64 " changes of dt, %" PRId64 " restores, %" PRId64
         " batches, %" PRId64 " scenes (%" PRId64 " with obstacles, %" PRId64
         " with bodies that touch each other, %" PRId64 " condensed bodies)\n",
         s->kicks, s->dt_changes, s->restores, s->batches, s->scenes, s->contacts, s->collisions,
         s->condensed);
}

int main(int argc, char **argv) {
  static soak s;
  thrum_error error = {0};
  if (argc < 4 || argc - 3 > MODELS_MOST) {
    fputs("usage: soak STEPS SEED MODEL.npz...\n", stderr);
    return 2;
  }
  s.wanted = strtoll(argv[1], NULL, 10);
  s.random.s = strtoull(argv[2], NULL, 10);
  for (int n = 3; n < argc; n++) {
    const char *slash = strrchr(argv[n], '/');
    s.names[s.model_count] = slash != NULL ? slash + 1 : argv[n];
    if (thrum_model_load(argv[n], &s.models[s.model_count++], &error) < 0) {
      fprintf(stderr, "%s\n", error.message);
      return 2;
    }
    if (s.models[s.model_count - 1]->rank > RANK_MOST) {
      fprintf(stderr, "%s has a rank above %d\n", argv[n], RANK_MOST);
      return 2;
    }
  }

  // episodes until enough steps were made; a finding ends the program
  while (s.steps < s.wanted)
    run_episode(&s);
  report(&s);
  for (int n = 0; n < s.model_count; n++)
    thrum_model_destroy(s.models[n]);
  return 0;
}
