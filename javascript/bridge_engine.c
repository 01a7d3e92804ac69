/* The functions that JavaScript calls: libthrum and its scenes, with numbers and addresses.
 *
 * Objects are addresses in the module's memory, 0 stands for a js_failure, and js_message says why
 * it failed. Functions that return a thrum_status return it as it is. Arguments of several numbers
 * lie in the array of js_numbers, in the order that each function names, and so do results.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "javascript/bridge.h"

double js_number[NUMBERS];
thrum_error js_failure;

/* A model, and the memory that it lies in. */
typedef struct js_model {
  const thrum_model *model;
  void *memory;
} js_model;

double *EXPORT(js_numbers)(void) {
  return js_number;
}

const char *EXPORT(js_message)(void) {
  return js_failure.message;
}

const char *EXPORT(js_version)(void) {
  return thrum_version();
}

/* Aligned to 64; NULL where there is no memory left. */
void *EXPORT(js_alloc)(size_t bytes) {
  return aligned_alloc(64, (bytes + 63) / 64 * 64 + 64);
}

void EXPORT(js_free)(void *memory) {
  free(memory);
}

// memory of that size for an object to be laid into; a failure is kept for js_message
static void *room(thrum_status status, size_t size) {
  void *memory = status >= 0 ? js_alloc(size) : NULL;
  if (status >= 0 && memory == NULL)
    thrum_error_set(&js_failure, THRUM_OUT_OF_MEMORY, "there is no memory left");
  return memory;
}

// an object in its memory; frees that when the object was not made
static void *laid(thrum_status status, void *memory) {
  if (status >= 0)
    return memory;
  free(memory);
  return NULL;
}

/* --- models ------------------------------------------------------------------------------------
 */

// takes the memory over
static js_model *model_of(thrum_status status, void *memory, const thrum_model *model) {
  js_model *made = laid(status, memory) != NULL ? malloc(sizeof *made) : NULL;
  if (made != NULL)
    *made = (js_model){.model = model, .memory = memory};
  return made;
}

/* The model in the `size` bytes of a file, which may go afterwards. */
js_model *EXPORT(js_model_load)(const void *file, size_t size) {
  size_t needed = 0;
  const thrum_model *model = NULL;
  void *memory = room(thrum_model_size(file, size, &needed, &js_failure), needed);
  if (memory == NULL)
    return NULL;
  return model_of(thrum_model_init(memory, needed, file, size, &model, &js_failure), memory, model);
}

js_model *EXPORT(js_model_condense)(const js_model *of, int32_t masters) {
  size_t needed = 0;
  const thrum_model *model = NULL;
  void *memory = room(thrum_model_condense_size(of->model, masters, &needed, &js_failure), needed);
  if (memory == NULL)
    return NULL;
  return model_of(thrum_model_condense(memory, needed, of->model, masters, &model, &js_failure),
                  memory, model);
}

js_model *EXPORT(js_model_scale)(const js_model *of, double length, double stiffness,
                                 double density) {
  const thrum_model_scaling by = {length, stiffness, density};
  size_t needed = 0;
  const thrum_model *model = NULL;
  void *memory = room(thrum_model_scale_size(of->model, &needed, &js_failure), needed);
  if (memory == NULL)
    return NULL;
  return model_of(thrum_model_scale(memory, needed, of->model, &by, &model, &js_failure), memory,
                  model);
}

/* What scenes take: the model alone. */
const thrum_model *EXPORT(js_model_pointer)(const js_model *of) {
  return of->model;
}

/* States, scenes and models made from it must be gone. */
void EXPORT(js_model_destroy)(js_model *model) {
  free(model->memory);
  free(model);
}

/* numbers: rank, coordinates that show it, masters, vertices, tetrahedra, regions, groups, bytes of
 * their names, vertices of all groups, bytes of meta, laws of regions, bytes of the one law. */
void EXPORT(js_model_sizes)(const js_model *of) {
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  js_number[0] = (double)of->model->rank;
  js_number[1] = (double)shape->rank;
  js_number[2] = (double)thrum_model_masters(of->model);
  js_number[3] = (double)shape->vertex_count;
  js_number[4] = (double)shape->tet_count;
  js_number[5] = (double)shape->region_count;
  js_number[6] = (double)shape->group_count;
  js_number[7] = (double)shape->group_name_bytes;
  js_number[8] = (double)shape->group_vertex_count;
  js_number[9] = (double)shape->meta_bytes;
  js_number[10] = (double)shape->law_count;
  js_number[11] = (double)shape->law_bytes;
}

/* Array `which` of a model, NULL where it has none: omega2, vertices, tets, fixed, material, basis,
 * group names, ends, vertices, meta, laws of regions, the name of the one law. */
const void *EXPORT(js_model_array)(const js_model *of, int32_t which) {
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  const void *const arrays[] = {of->model->omega2,  shape->vertices,   shape->tets,
                                shape->fixed,       shape->material,   shape->basis,
                                shape->group_names, shape->group_ends, shape->group_vertices,
                                shape->meta,        shape->region_law, shape->point_law};
  return which >= 0 && which < (int32_t)(sizeof arrays / sizeof *arrays) ? arrays[which] : NULL;
}

/* reduced (as many as show the model) += a force (numbers: x, y, z) that `count` vertices share,
 * all of the body for NULL. */
int32_t EXPORT(js_load_force)(const js_model *of, const int32_t *vertices, int32_t count,
                              double *reduced) {
  return thrum_load_add_shared(thrum_condensed_shape_model(of->model), vertices, count, js_number,
                               reduced, &js_failure);
}

/* reduced += an acceleration (numbers: x, y, z). */
int32_t EXPORT(js_load_gravity)(const js_model *of, double *reduced) {
  return thrum_load_add_gravity(thrum_condensed_shape_model(of->model), js_number, reduced,
                                &js_failure);
}

/* The force on the stepped coordinates at x of a load on all that show the model. */
void EXPORT(js_condensed_load)(const js_model *of, const double *x, const double *load,
                               double *reduced) {
  thrum_condensed_load(of->model, x, load, reduced);
}

/* All coordinates that show the model at the stepped ones. */
void EXPORT(js_condensed_shape)(const js_model *of, const double *x, const double *load,
                                double *q) {
  thrum_condensed_shape(of->model, x, load, q);
}

/* q += the multiple of a basis vector under which no vertex moves further than the amplitude. */
int32_t EXPORT(js_mode_add)(const js_model *of, int32_t mode, double amplitude, double *q) {
  return thrum_mode_add(thrum_condensed_shape_model(of->model), mode, amplitude, q, &js_failure);
}

/* Displacements of all vertices at q. */
int32_t EXPORT(js_displacement)(const js_model *of, const double *q, double *out) {
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  return thrum_displacement(shape, q, 0, shape->vertex_count, out, &js_failure);
}

/* Stress at the nodes of a model, which must stay. numbers: how many there are, 1 where stress is
 * extrapolated to them. */
void *EXPORT(js_stress_nodes_create)(const js_model *of) {
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  size_t size = 0;
  const thrum_stress_nodes *nodes = NULL;
  void *memory = room(thrum_stress_nodes_size(shape, &size, &js_failure), size);
  if (memory == NULL)
    return NULL;
  void *made = laid(thrum_stress_nodes_init(memory, size, shape, &nodes, &js_failure), memory);
  js_number[0] = (double)thrum_stress_nodes_count(nodes);
  js_number[1] = thrum_stress_nodes_extrapolated(nodes);
  return made;
}

/* The vertex and the region of each node. */
void EXPORT(js_stress_nodes_places)(const thrum_stress_nodes *nodes, int32_t *vertices,
                                    int32_t *regions) {
  for (int64_t n = 0; n < thrum_stress_nodes_count(nodes); n++) {
    vertices[n] = thrum_stress_nodes_vertex(nodes, n);
    regions[n] = thrum_stress_nodes_region(nodes, n);
  }
}

/* Seven numbers a node at q: the Cauchy stress of all nodes, then von Mises' of all. */
int32_t EXPORT(js_stress_nodes_read)(const js_model *of, const thrum_stress_nodes *nodes,
                                     const double *q, double *out) {
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  double *u = room(THRUM_OK, 3 * (size_t)shape->vertex_count * sizeof *u);
  if (u == NULL)
    return THRUM_OUT_OF_MEMORY;
  thrum_status status = thrum_displacement(shape, q, 0, shape->vertex_count, u, &js_failure);
  THRUM_THEN(status, thrum_stress_nodes_read(
                         nodes, u, out, out + 6 * thrum_stress_nodes_count(nodes), &js_failure));
  free(u);
  return status;
}

/* Von Mises' stress at the centres of all tetrahedra at q. */
int32_t EXPORT(js_von_mises)(const js_model *of, const double *q, double *out) {
  const thrum_stress_points_def def = {0};
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  size_t size = 0;
  THRUM_TRY(thrum_stress_points_size(shape, &def, &size, &js_failure));
  void *memory = room(THRUM_OK, size);
  if (memory == NULL)
    return THRUM_OUT_OF_MEMORY;

  const thrum_stress_points *points = NULL;
  const thrum_stress_points_output output = {.von_mises = out};
  thrum_status status = thrum_stress_points_init(memory, size, shape, &def, &points, &js_failure);
  THRUM_THEN(status, thrum_stress_points_read(points, q, NULL, &output, &js_failure));
  free(memory);
  return status;
}

/* The equilibrium under a load, from q and into q. numbers: factor, energy, least eigenvalue,
 * critical factor. */
int32_t EXPORT(js_equilibrium)(const js_model *of, const double *load, double *q) {
  const thrum_equilibrium_def def = thrum_default_equilibrium_def();
  size_t size = 0;
  THRUM_TRY(thrum_equilibrium_size(of->model, &size, &js_failure));
  void *workspace = room(THRUM_OK, size);
  if (workspace == NULL)
    return THRUM_OUT_OF_MEMORY;

  // q stays as it was when the search fails
  thrum_equilibrium_report report;
  const thrum_status status =
      thrum_equilibrium(of->model, &def, load, q, workspace, size, &report, &js_failure);
  free(workspace);
  if (status < 0)
    return status;
  js_number[0] = report.factor;
  js_number[1] = report.energy;
  js_number[2] = report.least;
  js_number[3] = report.critical;
  return status;
}

/* --- states ------------------------------------------------------------------------------------
 */

// numbers from `at` on: dt, alpha, beta, tolerance, safety, adaptive, fallback; < 0 or NaN in those
// after beta leaves the default
static thrum_state_def state_def(int32_t integrator, const double *at) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = (thrum_integrator)integrator;
  def.dt = at[0];
  def.damping_alpha = at[1];
  def.damping_beta = at[2];
  if (at[3] >= 0.0)
    def.tolerance = at[3];
  if (at[4] >= 0.0)
    def.split_safety = at[4];
  if (at[5] >= 0.0)
    def.adaptive = at[5] > 0.0;
  if (at[6] >= 0.0)
    def.fallback = at[6] > 0.0;
  return def;
}

/* The number of an integrator's name; below 0: none of that name. */
int32_t EXPORT(js_integrator)(const char *name) {
  thrum_integrator found;
  const thrum_status status = thrum_integrator_from_name(name, &found, &js_failure);
  return status < 0 ? (int32_t)status : (int32_t)found;
}

/* Name of an integrator or, `scheme` set, of a scheme; NULL for a number that names none. */
const char *EXPORT(js_name)(int32_t number, int32_t scheme) {
  return scheme ? thrum_scheme_name((thrum_scheme)number)
                : thrum_integrator_name((thrum_integrator)number);
}

/* numbers: as state_def. */
thrum_state *EXPORT(js_state_create)(const js_model *of, int32_t integrator) {
  const thrum_state_def def = state_def(integrator, js_number);
  thrum_state *state = NULL;
  return thrum_state_create(of->model, &def, &state, &js_failure) < 0 ? NULL : state;
}

void EXPORT(js_state_destroy)(thrum_state *state) {
  thrum_state_destroy(state);
}

int32_t EXPORT(js_state_set)(const js_model *of, thrum_state *state, const double *q,
                             const double *p) {
  return thrum_state_set(of->model, state, q, p, &js_failure);
}

int32_t EXPORT(js_state_get)(const js_model *of, thrum_state *state, double *q, double *p) {
  return thrum_state_get(of->model, state, q, p, &js_failure);
}

int32_t EXPORT(js_state_force)(const js_model *of, thrum_state *state, const double *force) {
  return thrum_state_set_force(of->model, state, force, &js_failure);
}

int32_t EXPORT(js_state_dt)(const js_model *of, thrum_state *state, double dt) {
  return thrum_state_set_dt(of->model, state, dt, &js_failure);
}

int32_t EXPORT(js_state_step)(const js_model *of, thrum_state *state, double count) {
  return thrum_steps(of->model, state, (int64_t)count, NULL, &js_failure);
}

/* numbers: kinetic, potential, total. */
int32_t EXPORT(js_state_energies)(const js_model *of, thrum_state *state) {
  thrum_energies energies;
  THRUM_TRY(thrum_state_energies(of->model, state, &energies, &js_failure));
  js_number[0] = energies.kinetic;
  js_number[1] = energies.potential;
  js_number[2] = energies.total;
  return THRUM_OK;
}

// numbers from `at` on: steps, time, iterations, switched steps, steps that grew, scheme, explicit
// modes, implicit modes, dissipated energy
static void put_report(const thrum_state_report *report, double *at) {
  at[0] = (double)report->steps;
  at[1] = report->time;
  at[2] = (double)report->iterations;
  at[3] = (double)report->switched_steps;
  at[4] = (double)report->grown_steps;
  at[5] = report->scheme;
  at[6] = report->explicit_modes;
  at[7] = report->implicit_modes;
  at[8] = report->dissipated;
}

/* numbers: as put_report. */
void EXPORT(js_state_report)(const thrum_state *state) {
  const thrum_state_report report = thrum_state_report_get(state);
  put_report(&report, js_number);
}

size_t EXPORT(js_state_snapshot_size)(const thrum_state *state) {
  return thrum_state_snapshot_size(state);
}

int32_t EXPORT(js_state_snapshot)(const thrum_state *state, void *memory, size_t size) {
  return thrum_state_snapshot(state, memory, size, &js_failure);
}

int32_t EXPORT(js_state_restore)(const js_model *of, thrum_state *state, const void *memory,
                                 size_t size) {
  return thrum_state_restore(of->model, state, memory, size, &js_failure);
}

/* --- batches -----------------------------------------------------------------------------------
 */

/* Workspace of a batch, and its bytes into js_number[0]; freed by js_free. */
void *EXPORT(js_batch_create)(const js_model *of) {
  size_t size = 0;
  void *workspace = room(thrum_batch_size(of->model, &size, &js_failure), size);
  js_number[0] = (double)size;
  return workspace;
}

int32_t EXPORT(js_batch_step)(const js_model *of, thrum_state *const *states, int32_t count,
                              thrum_status *statuses, void *workspace, size_t size) {
  return thrum_batch_step(of->model, states, count, statuses, workspace, size, &js_failure);
}

/* --- surfaces ----------------------------------------------------------------------------------
 */

/* vertices (0-based; NULL: all) and triangles over their places (NULL: none); freed by js_free. */
void *EXPORT(js_surface_create)(const js_model *of, const int32_t *vertices, int32_t vertex_count,
                                const int32_t *triangles, int32_t triangle_count) {
  const thrum_surface_def def = {.vertices = vertices,
                                 .vertex_count = vertex_count,
                                 .triangles = triangles,
                                 .triangle_count = triangle_count};
  const thrum_model *shape = thrum_condensed_shape_model(of->model);
  size_t size = 0;
  const thrum_surface *surface = NULL;
  void *memory = room(thrum_surface_size(shape, &def, &size, &js_failure), size);
  if (memory == NULL)
    return NULL;
  return laid(thrum_surface_init(memory, size, shape, &def, &surface, &js_failure), memory);
}

int32_t EXPORT(js_surface_count)(const thrum_surface *surface) {
  return (int32_t)thrum_surface_vertex_count(surface);
}

/* Positions of all its vertices at q, three floats each. */
int32_t EXPORT(js_surface_positions)(const thrum_surface *surface, const double *q, float *out) {
  return thrum_surface_positions(surface, THRUM_SURFACE_POSITIONS, q, 0,
                                 thrum_surface_vertex_count(surface), out, 3, &js_failure);
}

int32_t EXPORT(js_surface_normals)(const thrum_surface *surface, const float *positions,
                                   float *normals) {
  return thrum_surface_normals(surface, positions, 3, normals, 3, &js_failure);
}
