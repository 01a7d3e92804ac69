/* The whole mesh of a model on a device (thrum/accelerator.h).
 *
 * A step is solved for its increment d = u' - u. With a and b by the scheme,
 *
 *   midpoint        0 = f - R(u + d/2) - M (a d - b v),  a = 2/h^2 + alpha/h,  b = 2/h,  v' = 2 d/h
 * - v implicit Euler  0 = f - R(u + d) - M (a d - b v),    a = 1/h^2 + alpha/h,  b = 1/h,  v' = d/h
 *
 * by Newton: (a M + share K) c = r, d := d + c, K the tangent there and share 1/2 or 1. Conjugate
 * gradients take K times a vector tetrahedron by tetrahedron, and scale by the diagonal of
 * a M + share K at rest. Sums over all vertices go by SUMS partial sums in a fixed order.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accelerator/device.h"
#include "accelerator/device_mesh.h"
#include "core/base/def.h"
#include "thrum/actuation.h"

#define SUMS 1024 /* partial sums, as many as a large device adds up at a time */
#define LOOK_EVERY                                                                                 \
  16              /* iterations of conjugate gradients between two looks at how far they are       \
                   */
#define NUMBERS 8 /* that conjugate gradients keep, see mesh_body.cl */

static const char source[] = {
#include "mesh_body_program.inc"
};

/* X(name): the passes, by their names in mesh_body.cl. */
#define PASSES(X)                                                                                  \
  X(elements)                                                                                      \
  X(residual)                                                                                      \
  X(apply)                                                                                         \
  X(blend)                                                                                         \
  X(scale)                                                                                         \
  X(hold)                                                                                          \
  X(partial_sums)                                                                                  \
  X(first_direction) X(first_numbers) X(step_length) X(go) X(next_numbers) X(next_direction)

/* X(name): the arrays of the mesh, and those of a step. */
#define MESH_ARRAYS(X)                                                                             \
  X(node)                                                                                          \
  X(gradients)                                                                                     \
  X(volume)                                                                                        \
  X(moduli)                                                                                        \
  X(slopes)                                                                                        \
  X(shares) X(around_ends) X(around) X(mass_ends) X(mass_columns) X(mass) X(fixed) X(diagonal)
#define FIELDS(X) X(u) X(v) X(load) X(d) X(place) X(r) X(z) X(p) X(product) X(correction)

struct thrum_mesh_body {
  thrum_accelerator *accelerator;
  thrum_mesh_body_def def;
  thrum_mesh_body_report report;
  int64_t vertices, tets;
  double a, b, share; /* of the scheme */
  opencl_program program;
#define X(name) opencl_kernel pass_##name;
  PASSES(X)
#undef X
#define X(name) opencl_buffer name;
  MESH_ARRAYS(X)
  FIELDS(X)
#undef X
  opencl_buffer forces, sums, numbers;
  void *staging; /* 3 x vertices numbers of the device's precision */
  double *field; /* as many */
};

void thrum_mesh_body_def_init(thrum_mesh_body_def *def, size_t size) {
  const thrum_mesh_body_def defaults = {.cookie = sizeof(thrum_mesh_body_def),
                                        .iterations = 12,
                                        .dt = 0.003,
                                        .solver_iterations = 2000};
  thrum_def_fill(def, size, &defaults, sizeof defaults);
}

/* --- what is asked for ------------------------------------------------------------------------ */

static thrum_status check_def(const thrum_mesh_body_def *def, thrum_error *error) {
  if (def->scheme != THRUM_MESH_MIDPOINT && def->scheme != THRUM_MESH_IMPLICIT_EULER)
    return thrum_error_set_field(error, "scheme", THRUM_INVALID_ARGUMENT,
                                 " is neither midpoint nor implicit Euler");
  if (def->law != THRUM_MESH_STVK && def->law != THRUM_MESH_NEO_HOOKEAN)
    return thrum_error_set_field(error, "law", THRUM_INVALID_ARGUMENT,
                                 " is neither Saint Venant-Kirchhoff nor neo-Hookean");
  if (!(def->dt > 0) || !isfinite(def->dt))
    return thrum_error_set_field(error, "dt", THRUM_INVALID_ARGUMENT, " is not above 0 and finite");
  if (!(def->damping >= 0) || !isfinite(def->damping))
    return thrum_error_set_field(error, "damping", THRUM_INVALID_ARGUMENT,
                                 " is not 0 or more and finite");
  if (!(def->tolerance >= 0) || !isfinite(def->tolerance))
    return thrum_error_set_field(error, "tolerance", THRUM_INVALID_ARGUMENT,
                                 " is not 0 or more and finite");
  if (!(def->solver_tolerance >= 0) || !(def->solver_tolerance < 1))
    return thrum_error_set_field(error, "solver_tolerance", THRUM_INVALID_ARGUMENT,
                                 " is not from 0 to below 1");
  if (def->iterations < 1)
    return thrum_error_set_field(error, "iterations", THRUM_INVALID_ARGUMENT, " is below 1");
  if (def->solver_iterations < 1)
    return thrum_error_set_field(error, "solver_iterations", THRUM_INVALID_ARGUMENT, " is below 1");
  return def->reserved == 0
             ? THRUM_OK
             : thrum_error_set_field(error, "reserved", THRUM_INVALID_ARGUMENT, " is not 0");
}

/* --- numbers of the device -------------------------------------------------------------------- */

// a field of the caller's into an array of the device
static thrum_status send_field(thrum_mesh_body *body, const char *name, const double *from,
                               opencl_buffer buffer, thrum_error *error) {
  const thrum_accelerator *a = body->accelerator;
  const int64_t count = 3 * body->vertices;
  const double most = device_real_most(a);
  for (int64_t i = 0; i < count; i++) {
    const double value = from ? from[i] : 0;
    if (!(fabs(value) <= most))
      return thrum_error_set(error, THRUM_BAD_VALUE,
                             "%s of vertex %lld is %g: it is not finite or beyond %g", name,
                             (long long)(i / 3), value, most);
    device_real_put(a, body->staging, i, value);
  }
  return device_write(a, buffer, body->staging, (size_t)count * device_real(a), error);
}

// so many numbers of an array of the device, by way of `raw`, which has room for them
static thrum_status get_numbers(const thrum_accelerator *a, opencl_buffer buffer, int64_t count,
                                void *raw, double *to, thrum_error *error) {
  THRUM_TRY(device_read(a, buffer, raw, (size_t)count * device_real(a), error));
  for (int64_t i = 0; i < count; i++)
    to[i] = device_real_get(a, raw, i);
  return THRUM_OK;
}

static thrum_status get_field(thrum_mesh_body *body, opencl_buffer buffer, double *to,
                              thrum_error *error) {
  return get_numbers(body->accelerator, buffer, 3 * body->vertices, body->staging, to, error);
}

/* --- a body's life ---------------------------------------------------------------------------- */

static thrum_status send_mesh(thrum_mesh_body *body, const thrum_model *model, const device_mesh *m,
                              thrum_error *error) {
  const thrum_accelerator *a = body->accelerator;
  const int64_t all = m->tets * m->nodes, masses = m->mass_ends[m->vertices - 1];
  const size_t index = sizeof(int32_t);

  // which nodes and elements belong together, then their numbers
  THRUM_TRY(device_buffer(a, (size_t)all * index, m->node, &body->node, error));
  THRUM_TRY(device_buffer(a, (size_t)all * index, m->around, &body->around, error));
  THRUM_TRY(
      device_buffer(a, (size_t)m->vertices * index, m->around_ends, &body->around_ends, error));
  THRUM_TRY(device_buffer(a, (size_t)m->vertices * index, m->mass_ends, &body->mass_ends, error));
  THRUM_TRY(device_buffer(a, (size_t)masses * index, m->mass_columns, &body->mass_columns, error));
  THRUM_TRY(device_reals(a, m->mass, masses, &body->mass, error));
  THRUM_TRY(device_reals(a, m->gradients, 9 * m->tets, &body->gradients, error));
  THRUM_TRY(device_reals(a, m->volume, m->tets, &body->volume, error));
  THRUM_TRY(device_reals(a, m->moduli, 2 * m->tets, &body->moduli, error));
  THRUM_TRY(device_reals(a, m->slopes, 3 * (int64_t)m->nodes * m->points, &body->slopes, error));
  THRUM_TRY(device_reals(a, m->shares, m->points, &body->shares, error));

  // what is held, and the diagonal by which conjugate gradients scale
  uint8_t *const fixed = calloc((size_t)m->vertices, 1);
  if (!fixed)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the vertices of a mesh");
  if (model->fixed)
    memcpy(fixed, model->fixed, (size_t)m->vertices);
  thrum_status status = device_buffer(a, (size_t)m->vertices, fixed, &body->fixed, error);
  free(fixed);
  if (status != THRUM_OK)
    return status;
  for (int64_t i = 0; i < 3 * m->vertices; i++) {
    const double entry = body->a * m->diagonal_mass[i] + body->share * m->diagonal_stiffness[i];
    body->field[i] = entry > 0 ? entry : 1; // a vertex that no tetrahedron has does not move
  }
  return device_reals(a, body->field, 3 * m->vertices, &body->diagonal, error);
}

static thrum_status make_fields(thrum_mesh_body *body, const device_mesh *m, thrum_error *error) {
  const thrum_accelerator *a = body->accelerator;
  const size_t real = device_real(a), field = 3 * (size_t)body->vertices * real;
#define X(name) THRUM_TRY(device_buffer(a, field, NULL, &body->name, error));
  FIELDS(X)
#undef X
  THRUM_TRY(device_buffer(a, 3 * (size_t)(m->tets * m->nodes) * real, NULL, &body->forces, error));
  THRUM_TRY(device_buffer(a, SUMS * real, NULL, &body->sums, error));
  return device_buffer(a, NUMBERS * real, NULL, &body->numbers, error);
}

static thrum_status make_passes(thrum_mesh_body *body, const device_mesh *m, thrum_error *error) {
  const thrum_accelerator *a = body->accelerator;
  char options[192];
  int32_t code;
  snprintf(options, sizeof options,
           "-cl-std=CL1.2 %s -DTETS=%d -DNODES=%d -DPOINTS=%d -DLAW=%d -DSUMS=%d",
           a->info.single ? "" : "-DWITH_DOUBLE", (int)m->tets, m->nodes, m->points,
           (int)body->def.law, SUMS);
  THRUM_TRY(device_program(a, source, sizeof source, options, &body->program, error));
#define X(name)                                                                                    \
  body->pass_##name = a->cl.clCreateKernel(body->program, #name, &code);                           \
  if (!body->pass_##name)                                                                          \
    return device_failure(code, "the pass " #name " is made", error);
  PASSES(X)
#undef X
  return THRUM_OK;
}

static thrum_status make_body(thrum_mesh_body *body, const thrum_model *model, thrum_error *error) {
  const double h = body->def.dt;
  const bool middle = body->def.scheme == THRUM_MESH_MIDPOINT;
  body->share = middle ? 0.5 : 1;
  body->b = (middle ? 2 : 1) / h;
  body->a = body->b / h + body->def.damping / h;
  body->vertices = model->vertex_count;
  body->tets = model->tet_count;
  body->staging = malloc(3 * (size_t)body->vertices * sizeof(double));
  body->field = malloc(3 * (size_t)body->vertices * sizeof *body->field);
  if (!body->staging || !body->field)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for %lld vertices",
                           (long long)body->vertices);
  device_mesh mesh = {0};
  THRUM_TRY(device_mesh_make(model, &mesh, error));
  thrum_status status = send_mesh(body, model, &mesh, error);
  if (status == THRUM_OK)
    status = make_fields(body, &mesh, error);
  if (status == THRUM_OK)
    status = make_passes(body, &mesh, error);
  device_mesh_free(&mesh);
  if (status == THRUM_OK)
    status = thrum_mesh_body_set_forces(body, NULL, error);
  return status == THRUM_OK ? thrum_mesh_body_set(body, NULL, NULL, error) : status;
}

thrum_status thrum_mesh_body_create(thrum_accelerator *accelerator, const thrum_model *model,
                                    const thrum_mesh_body_def *def, thrum_mesh_body **body,
                                    thrum_error *error) {
  if (!accelerator || !model || !body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the accelerator, the model or body is NULL");
  thrum_mesh_body_def defaults = thrum_default_mesh_body_def();
  def = thrum_def_whole(def, &defaults, sizeof defaults);
  if (!def)
    return thrum_error_set(error, THRUM_UNINITIALISED_DEF,
                           "the def was not made by thrum_mesh_body_def_init");
  THRUM_TRY(check_def(def, error));
  if (thrum_model_actuators(model) > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a device has no actuators, and this model has some");

  thrum_mesh_body *const made = calloc(1, sizeof *made);
  if (!made)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a body");
  made->accelerator = accelerator;
  made->def = *def;
  if (def->tolerance == 0)
    made->def.tolerance = accelerator->info.single ? 1e-4 : 1e-8;
  if (def->solver_tolerance == 0)
    made->def.solver_tolerance = accelerator->info.single ? 1e-4 : 1e-6;
  const thrum_status status = make_body(made, model, error);
  if (status != THRUM_OK) {
    thrum_mesh_body_destroy(made);
    return status;
  }
  *body = made;
  return THRUM_OK;
}

void thrum_mesh_body_destroy(thrum_mesh_body *body) {
  if (!body)
    return;
  const opencl_library *cl = &body->accelerator->cl;
#define X(name) device_release(body->accelerator, &body->name);
  MESH_ARRAYS(X)
  FIELDS(X)
  X(forces)
  X(sums)
  X(numbers)
#undef X
#define X(name)                                                                                    \
  if (body->pass_##name)                                                                           \
    cl->clReleaseKernel(body->pass_##name);
  PASSES(X)
#undef X
  if (body->program)
    cl->clReleaseProgram(body->program);
  free(body->staging);
  free(body->field);
  free(body);
}

/* --- passes ----------------------------------------------------------------------------------- */

#define A(x) DEVICE_ARGUMENT(x)

static device_argument real_of(const thrum_mesh_body *body, device_number *kept, double value) {
  return device_number_of(body->accelerator, kept, value);
}

static thrum_status run(const thrum_mesh_body *body, opencl_kernel kernel,
                        const device_argument *arguments, uint32_t count, int64_t items,
                        thrum_error *error) {
  const size_t global[2] = {(size_t)items, 1};
  return device_run(body->accelerator, kernel, arguments, count, global, error);
}

#define RUN(body, name, items, ...)                                                                \
  run(body, (body)->pass_##name, (const device_argument[]){__VA_ARGS__},                           \
      (uint32_t)(sizeof((const device_argument[]){__VA_ARGS__}) / sizeof(device_argument)), items, \
      error)

// R at `place`, or with `change` K x there, by tetrahedra
static thrum_status elements(thrum_mesh_body *b, opencl_buffer x, int32_t change,
                             thrum_error *error) {
  return RUN(b, elements, b->tets, A(b->place), A(x), A(change), A(b->node), A(b->gradients),
             A(b->volume), A(b->moduli), A(b->slopes), A(b->shares), A(b->forces));
}

static thrum_status blend(thrum_mesh_body *b, opencl_buffer x, opencl_buffer y, double share,
                          opencl_buffer out, thrum_error *error) {
  device_number kept;
  const device_argument by = real_of(b, &kept, share);
  return RUN(b, blend, 3 * b->vertices, A(x), A(y), by, A(out));
}

static thrum_status scale(thrum_mesh_body *b, opencl_buffer x, double share, opencl_buffer out,
                          thrum_error *error) {
  device_number kept;
  const device_argument by = real_of(b, &kept, share);
  return RUN(b, scale, 3 * b->vertices, A(x), by, A(out));
}

static thrum_status sums(thrum_mesh_body *b, opencl_buffer x, opencl_buffer y, thrum_error *error) {
  const int32_t count = (int32_t)(3 * b->vertices);
  return RUN(b, partial_sums, SUMS, A(x), A(y), A(count), A(b->sums));
}

// the same, for the host
static thrum_status product_of(thrum_mesh_body *b, opencl_buffer x, opencl_buffer y,
                               double *product, thrum_error *error) {
  double raw[SUMS], parts[SUMS];
  THRUM_TRY(sums(b, x, y, error));
  THRUM_TRY(get_numbers(b->accelerator, b->sums, SUMS, raw, parts, error));
  *product = 0;
  for (int i = 0; i < SUMS; i++)
    *product += parts[i];
  return THRUM_OK;
}

static thrum_status residual(thrum_mesh_body *b, thrum_error *error) {
  device_number kept_a, kept_b;
  const device_argument by_a = real_of(b, &kept_a, b->a), by_b = real_of(b, &kept_b, b->b);
  THRUM_TRY(blend(b, b->u, b->d, b->share, b->place, error));
  THRUM_TRY(elements(b, b->d, 0, error));
  return RUN(b, residual, b->vertices, A(b->forces), A(b->around_ends), A(b->around),
             A(b->mass_ends), A(b->mass_columns), A(b->mass), A(b->fixed), A(b->load), A(b->d),
             A(b->v), by_a, by_b, A(b->r));
}

/* --- conjugate gradients ---------------------------------------------------------------------- */

// one iteration, which does nothing once they have ended
static thrum_status iterate(thrum_mesh_body *b, thrum_error *error) {
  const int64_t n = 3 * b->vertices;
  device_number kept_a, kept_b, kept;
  const device_argument by_a = real_of(b, &kept_a, b->a), by_b = real_of(b, &kept_b, b->share);
  const device_argument tolerance = real_of(b, &kept, b->def.solver_tolerance);
  THRUM_TRY(elements(b, b->p, 1, error));
  THRUM_TRY(RUN(b, apply, b->vertices, A(b->forces), A(b->around_ends), A(b->around),
                A(b->mass_ends), A(b->mass_columns), A(b->mass), A(b->fixed), A(b->p), by_a, by_b,
                A(b->product)));
  THRUM_TRY(sums(b, b->p, b->product, error));
  THRUM_TRY(RUN(b, step_length, 1, A(b->sums), A(b->numbers)));
  THRUM_TRY(RUN(b, go, n, A(b->p), A(b->product), A(b->diagonal), A(b->numbers), A(b->correction),
                A(b->r), A(b->z)));
  THRUM_TRY(sums(b, b->r, b->z, error));
  THRUM_TRY(RUN(b, next_numbers, 1, A(b->sums), tolerance, A(b->numbers)));
  return RUN(b, next_direction, n, A(b->z), A(b->numbers), A(b->p));
}

static thrum_status read_numbers(thrum_mesh_body *b, double numbers[NUMBERS], thrum_error *error) {
  double raw[NUMBERS];
  return get_numbers(b->accelerator, b->numbers, NUMBERS, raw, numbers, error);
}

// the correction for the residual r; *ended: to the tolerance, not by a matrix that is not positive
static thrum_status solve(thrum_mesh_body *b, bool *ended, thrum_error *error) {
  const int64_t n = 3 * b->vertices;
  double numbers[NUMBERS] = {0};
  THRUM_TRY(
      RUN(b, first_direction, n, A(b->r), A(b->diagonal), A(b->z), A(b->p), A(b->correction)));
  THRUM_TRY(sums(b, b->r, b->z, error));
  THRUM_TRY(RUN(b, first_numbers, 1, A(b->sums), A(b->numbers)));
  for (int32_t k = 0; k < b->def.solver_iterations; k++) {
    THRUM_TRY(iterate(b, error));
    if (k % LOOK_EVERY != LOOK_EVERY - 1)
      continue;
    THRUM_TRY(read_numbers(b, numbers, error));
    if (numbers[3] != 0)
      break;
  }
  THRUM_TRY(read_numbers(b, numbers, error));
  b->report.solver_iterations += (int64_t)numbers[4];
  *ended = numbers[7] != 0;
  return THRUM_OK;
}

/* --- steps ------------------------------------------------------------------------------------ */

static thrum_status step(thrum_mesh_body *b, thrum_error *error) {
  // the first increment is that without forces
  const double h = b->def.dt;
  const double rounding = b->accelerator->info.single ? 1e-6 : 1e-12;
  double corrected = 0, moved = 0, size = 0;
  THRUM_TRY(scale(b, b->v, h, b->d, error));
  bool solved = false, ended = false;
  for (int32_t k = 0; k < b->def.iterations && !solved; k++) {
    THRUM_TRY(residual(b, error));
    THRUM_TRY(solve(b, &ended, error));
    THRUM_TRY(blend(b, b->d, b->correction, 1, b->d, error));
    THRUM_TRY(product_of(b, b->correction, b->correction, &corrected, error));
    THRUM_TRY(product_of(b, b->d, b->d, &moved, error));
    THRUM_TRY(product_of(b, b->place, b->place, &size, error));
    b->report.iterations++;

    // a body that has come to rest has increments of rounding alone
    const double most = fmax(b->def.tolerance * sqrt(moved), rounding * sqrt(size));
    solved = ended && isfinite(most) && sqrt(corrected) <= most;
  }
  if (!solved)
    return thrum_error_set(
        error, THRUM_NOT_CONVERGED,
        "step %lld is not solved after %d iterations, the last of which "
        "corrected %.1e of it%s: take a smaller dt, or more %siterations",
        (long long)b->report.steps + 1, (int)b->def.iterations, sqrt(corrected / moved),
        ended ? "" : ", by conjugate gradients that did not end", ended ? "" : "solver_");

  // v' = 2 d/h - v, or d/h
  const bool middle = b->def.scheme == THRUM_MESH_MIDPOINT;
  THRUM_TRY(blend(b, b->u, b->d, 1, b->u, error));
  THRUM_TRY(scale(b, b->d, (middle ? 2 : 1) / h, b->d, error));
  b->report.steps++;
  return blend(b, b->d, b->v, middle ? -1 : 0, b->v, error);
}

thrum_status thrum_mesh_body_step(thrum_mesh_body *body, int64_t steps, thrum_error *error) {
  if (!body || steps < 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body is NULL, or steps is below 0");
  for (int64_t k = 0; k < steps; k++)
    THRUM_TRY(step(body, error));
  return THRUM_OK;
}

/* --- in and out ------------------------------------------------------------------------------- */

thrum_status thrum_mesh_body_set(thrum_mesh_body *body, const double *u, const double *v,
                                 thrum_error *error) {
  if (!body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body is NULL");

  // into other arrays first, as the second may be refused
  THRUM_TRY(send_field(body, "the displacement", u, body->d, error));
  THRUM_TRY(send_field(body, "the velocity", v, body->place, error));
  THRUM_TRY(RUN(body, hold, body->vertices, A(body->d), A(body->fixed), A(body->u)));
  return RUN(body, hold, body->vertices, A(body->place), A(body->fixed), A(body->v));
}

thrum_status thrum_mesh_body_set_forces(thrum_mesh_body *body, const double *forces,
                                        thrum_error *error) {
  if (!body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body is NULL");
  return send_field(body, "the force", forces, body->load, error);
}

thrum_status thrum_mesh_body_get(thrum_mesh_body *body, double *u, double *v, thrum_error *error) {
  if (!body)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body is NULL");
  if (u)
    THRUM_TRY(get_field(body, body->u, u, error));
  return v ? get_field(body, body->v, v, error) : THRUM_OK;
}

thrum_status thrum_mesh_body_get_report(const thrum_mesh_body *body, thrum_mesh_body_report *report,
                                        thrum_error *error) {
  if (!body || !report)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "the body or report is NULL");
  *report = body->report;
  return THRUM_OK;
}
