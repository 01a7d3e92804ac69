/* The inertia of a free body as a function of its shape (thrum/inertia.h, design 20).
 *
 * With D_i = sum m x U_i^T = A_i + sum_j q_j sum m U_j U_i^T and x = X + U q,
 *
 *   sum m x x^T = sum m X X^T + sum_i q_i (D_i + A_i^T),   I = tr(.) 1 - (.),
 *   dI/dq_i = 2 tr(D_i) 1 - D_i - D_i^T,   column i of G = the cross product in D_i.
 *
 * The mass matrix is that of precompute/fem: consistent, of ten-node tetrahedra by its rule, or
 * lumped, of ten-node ones by scaling the diagonal. Which of the two it was shows in the basis.
 * Cost: r^2 numbers a vertex, once; 18 r^2 operations for all D_i.
 *
 * Source: Shabana 2013, doi:10.1017/CBO9781107337213, 5.3.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/base/fp_contract.h"

#include "runtime/frames/inertia_private.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/finite.h"
#include "core/base/model_law.h"
#include "core/base/quadratic_tet.h"
#include "core/base/vec3.h"

#define DEFECT_MOST 1e-6 /* of orthonormality, and of orthogonality to the rigid modes */

/* The inputs of the sums. */
typedef struct sums {
  const thrum_model *model;
  bool lumped;
  const thrum_quadratic_point *rule; /* of ten-node tetrahedra; NULL: they have four nodes */
  int point_count;
  double *mass;   /* vertices: M 1 */
  double *places; /* vertices x 3: M X */
  double *images; /* 3 vertices x rank: M U */
} sums;

/* --- the mass matrix of a tetrahedron --------------------------------------------------------- */

static int32_t node_of(const thrum_model *model, int64_t tet, int a) {
  return a < 4 ? model->tets[4 * tet + a] : model->midsides[6 * tet + a - 4];
}

static int node_count(const thrum_model *model) {
  return model->midsides ? THRUM_QUADRATIC_NODES : 4;
}

static void read_nodes(const thrum_model *model, int64_t tet,
                       double places[THRUM_QUADRATIC_NODES][3]) {
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
    memcpy(places[a], model->vertices + 3 * (int64_t)node_of(model, tet, a), sizeof places[a]);
}

/* Masses between the nodes of a linear tetrahedron. */
static void linear_masses(const sums *s, int64_t tet, double density,
                          double masses[THRUM_QUADRATIC_NODES][THRUM_QUADRATIC_NODES]) {
  double edges[3][3];
  thrum_tet_edges(s->model->vertices, s->model->tets + 4 * tet, edges);
  const double mass = density * thrum_triple3(edges[0], edges[1], edges[2]) / 6;
  for (int a = 0; a < 4; a++)
    for (int b = 0; b < 4; b++)
      masses[a][b] = a == b ? mass / (s->lumped ? 4 : 10) : s->lumped ? 0 : mass / 20;
}

/* The same of a ten-node one, by the rule. */
static void quadratic_masses(const sums *s, int64_t tet, double density,
                             double masses[THRUM_QUADRATIC_NODES][THRUM_QUADRATIC_NODES]) {
  double places[THRUM_QUADRATIC_NODES][3], diagonal = 0, mass = 0;
  read_nodes(s->model, tet, places);
  memset(masses, 0, sizeof(double[THRUM_QUADRATIC_NODES][THRUM_QUADRATIC_NODES]));
  for (int p = 0; p < s->point_count; p++) {
    double shape[THRUM_QUADRATIC_NODES], slopes[THRUM_QUADRATIC_NODES][3], gradients[9];
    thrum_quadratic_shape(s->rule[p].place, shape);
    thrum_quadratic_slopes(s->rule[p].place, slopes);
    const double weight =
        density * s->rule[p].weight * thrum_quadratic_map(places, slopes, gradients) / 6;
    mass += weight;
    for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
      for (int b = 0; b < THRUM_QUADRATIC_NODES; b++)
        masses[a][b] += weight * (shape[a] * shape[b]);
  }

  // lumped: the diagonal, scaled so that the masses of all nodes add up to that of the tet
  for (int a = 0; a < THRUM_QUADRATIC_NODES; a++)
    diagonal += masses[a][a];
  for (int a = 0; a < THRUM_QUADRATIC_NODES && s->lumped; a++)
    for (int b = 0; b < THRUM_QUADRATIC_NODES; b++)
      masses[a][b] = a == b ? masses[a][b] * (mass / diagonal) : 0;
}

/* One curved tetrahedron is enough for the finer rule. */
static void choose_rule(sums *s) {
  const thrum_model *model = s->model;
  bool curved = false;
  for (int64_t t = 0; t < model->tet_count && model->midsides && !curved; t++) {
    double places[THRUM_QUADRATIC_NODES][3];
    read_nodes(model, t, places);
    curved = thrum_quadratic_is_curved(places);
  }
  s->rule = model->midsides ? thrum_quadratic_rule(curved, &s->point_count) : NULL;
}

/* --- products with the mass matrix ------------------------------------------------------------ */

/* Adds a mass between the nodes a and b to row a of the products. */
static void add_mass(const sums *s, double mass, int64_t a, int64_t b) {
  const thrum_model *model = s->model;
  const int64_t columns = 3 * model->rank;
  s->mass[a] += mass;
  for (int axis = 0; axis < 3; axis++)
    s->places[3 * a + axis] += mass * model->vertices[3 * b + axis];
  for (int64_t n = 0; n < columns; n++)
    s->images[columns * a + n] += mass * model->basis[columns * b + n];
}

/* M 1, M X and M U. */
static void multiply(const sums *s) {
  const thrum_model *model = s->model;
  const size_t vertices = (size_t)model->vertex_count;
  memset(s->mass, 0, vertices * sizeof *s->mass);
  memset(s->places, 0, 3 * vertices * sizeof *s->places);
  memset(s->images, 0, 3 * vertices * (size_t)model->rank * sizeof *s->images);

  // tetrahedron by tetrahedron, each pair of its nodes in turn
  for (int64_t t = 0; t < model->tet_count; t++) {
    double masses[THRUM_QUADRATIC_NODES][THRUM_QUADRATIC_NODES];
    const double density = model->material[3 * (int64_t)model->tet_region[t] + 2];
    if (s->rule)
      quadratic_masses(s, t, density, masses);
    else
      linear_masses(s, t, density, masses);
    for (int a = 0; a < node_count(model); a++)
      for (int b = 0; b < node_count(model); b++)
        if (masses[a][b] != 0)
          add_mass(s, masses[a][b], node_of(model, t, a), node_of(model, t, b));
  }
}

/* --- the numbers of an inertia ---------------------------------------------------------------- */

/* Mass and centre, and sum m X X^T about it. */
static double find_rest(const sums *s, double centre[3], double rest[9]) {
  const int64_t count = s->model->vertex_count;
  double mass = 0;
  memset(centre, 0, 3 * sizeof *centre);
  memset(rest, 0, 9 * sizeof *rest);

  // the first moments give the centre
  for (int64_t v = 0; v < count; v++) {
    mass += s->mass[v];
    for (int axis = 0; axis < 3; axis++)
      centre[axis] += s->places[3 * v + axis];
  }
  for (int axis = 0; axis < 3; axis++)
    centre[axis] /= mass;

  // with X from the centre of mass, M X is less by M 1 centre
  for (int64_t v = 0; v < count; v++)
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        rest[3 * a + b] += (s->model->vertices[3 * v + a] - centre[a]) *
                           (s->places[3 * v + b] - s->mass[v] * centre[b]);
  return mass;
}

/* A_i, and how far sum m U_i is from zero. */
static double find_linear(const sums *s, const double centre[3], thrum_inertia *inertia) {
  const int64_t full = s->model->rank;
  double worst = 0;

  // mode by mode, over all vertices
  for (int64_t i = 0; i < inertia->rank; i++) {
    double *moment = inertia->linear + 9 * i, shift[3] = {0};
    memset(moment, 0, 9 * sizeof *moment);
    for (int64_t v = 0; v < s->model->vertex_count; v++)
      for (int b = 0; b < 3; b++) {
        const double image = s->images[(3 * v + b) * full + i];
        shift[b] += image;
        for (int a = 0; a < 3; a++)
          moment[3 * a + b] += (s->model->vertices[3 * v + a] - centre[a]) * image;
      }
    worst = fmax(worst, sqrt(thrum_dot3(shift, shift)));
  }
  return worst;
}

/* sum m U_j U_i^T for all pairs; each of them once, so that the table is symmetric to the bit. */
static void find_pairs(const sums *s, thrum_inertia *inertia) {
  const int64_t full = s->model->rank, r = inertia->rank;
  memset(inertia->pairs, 0, (size_t)(9 * r * r) * sizeof *inertia->pairs);
  for (int64_t v = 0; v < s->model->vertex_count; v++)
    for (int a = 0; a < 3; a++) {
      const double *modes = s->model->basis + (3 * v + a) * full;
      for (int b = 0; b < 3; b++) {
        const double *images = s->images + (3 * v + b) * full;
        for (int64_t j = 0; j < r; j++)
          for (int64_t i = j; i < r; i++)
            inertia->pairs[9 * (j * r + i) + 3 * a + b] += modes[j] * images[i];
      }
    }

  // the other half is the transpose
  for (int64_t j = 0; j < r; j++)
    for (int64_t i = j; i < r; i++) {
      double *moment = inertia->pairs + 9 * (j * r + i), *mirror = inertia->pairs + 9 * (i * r + j);
      for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
          // the moment of a mode with itself is symmetric; here it becomes so to the last bit
          if (i == j && a < b)
            moment[3 * a + b] = moment[3 * b + a];
          mirror[3 * b + a] = moment[3 * a + b];
        }
      thrum_inertia_cross(moment, inertia->crosses + 3 * (j * r + i));
      thrum_inertia_cross(mirror, inertia->crosses + 3 * (i * r + j));
    }
}

/* Largest departure from an orthonormal basis. */
static double orthonormality_defect(const thrum_inertia *inertia) {
  double worst = 0;
  for (int64_t j = 0; j < inertia->rank; j++)
    for (int64_t i = j; i < inertia->rank; i++) {
      const double *moment = inertia->pairs + 9 * (j * inertia->rank + i);
      worst = fmax(worst, fabs(moment[0] + moment[4] + moment[8] - (i == j)));
    }
  return worst;
}

/* All numbers, and the largest defect of the basis for this mass matrix. */
static double fill(const sums *s, thrum_inertia *inertia) {
  double centre[3];
  multiply(s);
  const double mass = find_rest(s, centre, inertia->rest);
  double defect = find_linear(s, centre, inertia) / sqrt(mass);
  find_pairs(s, inertia);
  defect = fmax(defect, orthonormality_defect(inertia));

  // no mode turns the body
  const double size = sqrt(inertia->rest[0] + inertia->rest[4] + inertia->rest[8]);
  for (int64_t i = 0; i < inertia->rank; i++) {
    double turn[3];
    thrum_inertia_cross(inertia->linear + 9 * i, turn);
    defect = fmax(defect, sqrt(thrum_dot3(turn, turn)) / size);
  }
  return defect;
}

/* The numbers of the body scaled as thrum_model_scale does; the pairs have no unit. */
static void scale(const thrum_model_scaling *by, thrum_inertia *inertia) {
  const double s = by->length, inertias = by->density * (s * s * s * s * s), root = sqrt(inertias);
  for (int n = 0; n < 9; n++)
    inertia->rest[n] *= inertias;
  for (int64_t n = 0; n < 9 * inertia->rank; n++)
    inertia->linear[n] *= root;
}

/* --- the public functions --------------------------------------------------------------------- */

static thrum_status check(const thrum_model *model, int64_t rank, const thrum_model_scaling *by,
                          thrum_inertia **inertia, thrum_error *error) {
  if (!model || !inertia || rank < 0 || rank > model->rank)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "an inertia needs a model, a place for it, and a rank of 0 to the "
                           "model's");
  if (by && !(isfinite(by->length) && by->length > 0 && isfinite(by->density) && by->density > 0))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "an inertia is scaled by factors that are finite and > 0");
  if (!model->inertia && (!model->vertices || !model->tets || !model->tet_region || !model->basis ||
                          !model->material || !model->rigid))
    return thrum_error_set(error, THRUM_MISSING,
                           "the inertia of a body's shape needs a model with a mesh that nothing "
                           "holds: precompute it without --fix");
  if (model->solid_count > 0 && !model->inertia)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "the mass of hexahedra and wedges is not known here: a model of them is "
                           "coupled to its rotation by the numbers of `inertia`, which thrum "
                           "makes, or as tetrahedra (--element tet)");
  if (thrum_law_of_model(model) != THRUM_LAW_STVK)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "cubature points of another law than Saint Venant-Kirchhoff are not "
                           "coupled to the rotation of their body");
  if (model->slave_count > 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "a condensed body is not coupled to its rotation: step all of its "
                           "coordinates");
  return THRUM_OK;
}

/* Room for the numbers behind the struct. */
static thrum_inertia *make_room(int64_t rank) {
  const size_t r = (size_t)rank, count = 9 * r + 12 * r * r;
  thrum_inertia *made = calloc(1, sizeof *made + count * sizeof(double));
  if (!made)
    return NULL;
  made->rank = rank;
  made->linear = made->numbers;
  made->pairs = made->linear + 9 * r;
  made->crosses = made->pairs + 9 * r * r;
  return made;
}

/* The mass matrix is the one for which the basis is orthonormal. */
static thrum_status fill_by_either_mass(sums *s, thrum_inertia *inertia, thrum_error *error) {
  choose_rule(s);
  const double defect = fill(s, inertia);
  if (defect <= DEFECT_MOST)
    return THRUM_OK;
  s->lumped = true;
  if (fill(s, inertia) <= DEFECT_MOST)
    return THRUM_OK;
  return thrum_error_set(error, THRUM_UNSUPPORTED,
                         "the basis is not orthonormal for the mass of the mesh and orthogonal to "
                         "its rigid modes: it is off by %.1e, where 1e-6 is needed to couple shape "
                         "and rotation",
                         defect);
}

static thrum_status no_memory(thrum_error *error) {
  return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for the inertia of a body");
}

/* All numbers, of the mesh. */
static thrum_status fill_by_mesh(const thrum_model *model, thrum_inertia *inertia,
                                 thrum_error *error) {
  const size_t vertices = (size_t)model->vertex_count;
  sums s = {.model = model};
  s.mass = malloc(vertices * (4 + 3 * (size_t)model->rank) * sizeof *s.mass);
  if (!s.mass)
    return no_memory(error);

  // the products share one block
  s.places = s.mass + vertices;
  s.images = s.places + 3 * vertices;
  const thrum_status status = fill_by_either_mass(&s, inertia, error);
  free(s.mass);
  return status;
}

/* The same, of the numbers that come with the model for all of its coordinates. */
static thrum_status fill_by_numbers(const thrum_model *model, thrum_inertia *inertia,
                                    thrum_error *error) {
  const int64_t full = model->rank, r = inertia->rank;
  if (!thrum_all_finite(model->inertia, thrum_inertia_number_count(full)))
    return thrum_error_set(error, THRUM_NOT_FINITE, "the model's inertia is not finite");

  // those of the first coordinates
  const double *linear = model->inertia + 9, *pairs = linear + 9 * full;
  memcpy(inertia->rest, model->inertia, sizeof inertia->rest);
  memcpy(inertia->linear, linear, (size_t)(9 * r) * sizeof *linear);
  for (int64_t j = 0; j < r; j++)
    memcpy(inertia->pairs + 9 * r * j, pairs + 9 * full * j, (size_t)(9 * r) * sizeof *pairs);
  for (int64_t n = 0; n < r * r; n++)
    thrum_inertia_cross(inertia->pairs + 9 * n, inertia->crosses + 3 * n);
  return THRUM_OK;
}

thrum_status thrum_inertia_create(const thrum_model *model, int64_t rank,
                                  const thrum_model_scaling *by, thrum_inertia **inertia,
                                  thrum_error *error) {
  THRUM_TRY(check(model, rank, by, inertia, error));
  thrum_inertia *made = make_room(rank > 0 ? rank : model->rank);
  if (!made)
    return no_memory(error);
  const thrum_status status =
      model->inertia ? fill_by_numbers(model, made, error) : fill_by_mesh(model, made, error);
  if (status < 0) {
    free(made);
    return status;
  }

  if (by)
    scale(by, made);
  *inertia = made;
  return THRUM_OK;
}

void thrum_inertia_destroy(thrum_inertia *inertia) {
  free(inertia);
}

int64_t thrum_inertia_rank(const thrum_inertia *inertia) {
  return inertia ? inertia->rank : 0;
}

void thrum_inertia_numbers(const thrum_inertia *inertia, double *numbers) {
  const size_t r = (size_t)inertia->rank;
  memcpy(numbers, inertia->rest, sizeof inertia->rest);
  memcpy(numbers + 9, inertia->linear, 9 * r * sizeof *numbers);
  memcpy(numbers + 9 + 9 * r, inertia->pairs, 9 * r * r * sizeof *numbers);
}

void thrum_inertia_of_moments(const thrum_inertia *inertia, const double *q, const double *moments,
                              double tensor[9]) {
  double sum[9];
  memcpy(sum, inertia->rest, sizeof sum);
  for (int64_t i = 0; i < inertia->rank; i++) {
    const double *at = moments + 9 * i, *rest = inertia->linear + 9 * i;
    for (int a = 0; a < 3; a++)
      for (int b = 0; b < 3; b++)
        sum[3 * a + b] += q[i] * (at[3 * a + b] + rest[3 * b + a]);
  }

  // the trace less the matrix, whose two triangles differ by rounding
  const double trace = sum[0] + sum[4] + sum[8];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++)
      tensor[3 * a + b] = (a == b ? trace : 0) - 0.5 * (sum[3 * a + b] + sum[3 * b + a]);
}

void thrum_inertia_tensor(const thrum_inertia *inertia, const double *q, double tensor[9],
                          double *work) {
  const int64_t r = inertia->rank;
  memcpy(work, inertia->linear, (size_t)(9 * r) * sizeof *work);
  for (int64_t j = 0; j < r; j++)
    for (int64_t n = 0; n < 9 * r; n++)
      work[n] += q[j] * inertia->pairs[9 * r * j + n];
  thrum_inertia_of_moments(inertia, q, work, tensor);
}
