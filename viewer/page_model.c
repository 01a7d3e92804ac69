/* The models of a page, of arrays that JavaScript brings.
 * SPDX-License-Identifier: Apache-2.0 */
#include "page.h"
#include "thrum/polynomial.h"

#include <string.h>

#define MODELS_MAX 64

static page_model models[MODELS_MAX];
static int32_t model_count;

const page_model *page_model_at(int32_t number) {
  return number >= 0 && number < model_count ? &models[number] : NULL;
}

int32_t page_model_add(const page_model *made) {
  if (model_count == MODELS_MAX)
    return thrum_error_set(&js_failure, THRUM_UNSUPPORTED, "a page has at most %d models",
                           MODELS_MAX);
  models[model_count] = *made;
  return model_count++;
}

static thrum_status no_memory(void) {
  return thrum_error_set(&js_failure, THRUM_OUT_OF_MEMORY, "the page has no memory left");
}

// widens an array, with zeros after it; NULL when there is no memory
static double *widen(const float *from, int64_t count, int64_t zeros) {
  double *to = js_alloc((size_t)(count + zeros) * sizeof *to);
  for (int64_t i = 0; to != NULL && i < count + zeros; i++)
    to[i] = i < count ? from[i] : 0.0;
  return to;
}

// the coefficients once more, in the order of the steps
static thrum_status pack(thrum_model *model) {
  size_t size = thrum_model_pack_size(model);
  void *memory = js_alloc(size);
  if (memory == NULL)
    return no_memory();
  return thrum_model_pack(model, memory, size, &js_failure);
}

static thrum_status make_surface(page_model *made) {
  thrum_surface_def def = {.triangles = made->triangles, .triangle_count = made->triangle_count};
  size_t size;
  THRUM_TRY(thrum_surface_size(&made->model, &def, &size, &js_failure));
  void *memory = js_alloc(size);
  made->positions = js_alloc((size_t)made->model.vertex_count * 3 * sizeof(float));
  if (memory == NULL || made->positions == NULL)
    return no_memory();
  return thrum_surface_init(memory, size, &made->model, &def, &made->surface, &js_failure);
}

// what a free body's mass and inertia are taken from: the mass from the first shift, the inertia
// from the rigid modes at the corners
static thrum_status make_rigid(page_model *made, const double *tet, const double *tet_rigid) {
  thrum_model *model = &made->model;
  const int64_t first = model->vertex_count - CORNERS;

  // the corners come behind the vertices that are shown
  double *rigid = js_alloc((size_t)model->vertex_count * 18 * sizeof *rigid);
  if (rigid == NULL)
    return no_memory();
  memset(rigid, 0, (size_t)model->vertex_count * 18 * sizeof *rigid);
  memcpy(rigid + 18 * first, tet_rigid, CORNERS * 18 * sizeof *rigid);

  // a vertex that moves by 1/sqrt(m) under the first shift, as all do, stands for the mass
  rigid[0] = tet_rigid[0];
  memcpy((double *)model->vertices + 3 * first, tet, CORNERS * 3 * sizeof *tet);
  for (int32_t n = 0; n < CORNERS; n++)
    made->corners[n] = (int32_t)first + n;

  // one tetrahedron of these corners carries the inertia
  model->rigid = rigid;
  model->tets = made->corners;
  model->tet_count = 1;
  return THRUM_OK;
}

static thrum_status list_touch(page_model *made) {
  const thrum_model *model = &made->model;
  made->touch = js_alloc((size_t)model->vertex_count * sizeof *made->touch);
  if (made->touch == NULL)
    return no_memory();
  for (int32_t v = 0; v < model->vertex_count - CORNERS; v++)
    if (model->fixed[v] == 0)
      made->touch[made->touch_count++] = v;
  return THRUM_OK;
}

// the mesh that is left of a model: positions, rows of the basis, material
static thrum_status make_mesh(page_model *made, const float *positions, const float *basis) {
  thrum_model *model = &made->model;
  const int64_t shown = model->vertex_count - CORNERS;
  model->vertices = widen(positions, 3 * shown, 3 * CORNERS);
  model->basis = widen(basis, 3 * shown * model->rank, 3 * CORNERS * model->rank);
  model->material = made->material;
  model->region_count = 1;
  return model->vertices != NULL && model->basis != NULL ? THRUM_OK : no_memory();
}

/* Makes a model of the coefficients of its first `masters` coordinates one whose others follow. */
static bool take_slaves(thrum_model *model, int64_t masters, const double *slave_map) {
  if (masters >= model->rank || slave_map == NULL || model->c3 == NULL || model->c4 == NULL)
    return false;
  model->slave_map = slave_map;
  model->slave_count = model->rank - masters;
  model->slave_pairs = masters * (masters + 1) / 2;
  model->condensed_c3 = model->c3;
  model->condensed_c3_count = thrum_c3_count(masters);
  model->condensed_c4 = model->c4;
  model->condensed_c4_count = thrum_c4_count(masters);
  model->c3 = model->c4 = NULL;
  model->c3_count = model->c4_count = 0;
  return true;
}

/* The arrays of a model, in the order in which the page hands their addresses over. */
typedef struct page_arrays {
  const double *omega2, *c3, *c4, *slave_map, *point_weights, *point_moduli, *point_gradients;
  const uint8_t *point_law;
  const int32_t *point_region;
  const uint8_t *region_law;
  const double *axis_mass, *inertia;
  const uint8_t *fixed;
  const int32_t *triangles;
  const float *positions, *basis;
  const double *tet, *tet_rigid;
} page_arrays;

/* Adds a model of arrays from js_alloc, which it keeps, `positions`, `basis` and the last two
 * apart; their shapes are those of the pack (docs/viewer.md). tet and tet_rigid are NULL for a
 * model that is held; c3 and c4 for one of cubature points, and those of points, point_count of
 * them, for any other, and point_law, ended by a 0, for Saint Venant-Kirchhoff material;
 * point_region and region_law, law_count of them, where regions have no laws of their own; inertia
 * where no body couples rotation and shape. masters: 0; or the first coordinates, whose c3 and c4
 * these are, and which the others follow by slave_map (thrum/condensed_model.h). numbers: Young's
 * modulus [Pa], and the energy at strains of 1 [J]. Returns its number, or a status below 0. */
int32_t EXPORT(page_add_model)(int32_t rank, int32_t vertex_count, int32_t triangle_count,
                               int32_t point_count, int32_t law_count, int32_t masters,
                               const page_arrays *of) {
  if (model_count == MODELS_MAX)
    return thrum_error_set(&js_failure, THRUM_UNSUPPORTED, "a page has at most %d models",
                           MODELS_MAX);

  // the model borrows the page's arrays
  page_model *made = &models[model_count];
  *made = (page_model){.triangles = of->triangles, .triangle_count = triangle_count};
  made->material[0] = js_number[0];
  made->model = (thrum_model){
      .rank = rank,
      .c3_count = of->c3 ? thrum_c3_count(rank) : 0,
      .c4_count = of->c4 ? thrum_c4_count(rank) : 0,
      .point_count = point_count,
      .vertex_count = (int64_t)vertex_count + CORNERS,
      .omega2 = of->omega2,
      .c3 = of->c3,
      .c4 = of->c4,
      .point_weights = of->point_weights,
      .point_moduli = of->point_moduli,
      .point_gradients = of->point_gradients,
      .point_law = of->point_law,
      .law_bytes = of->point_law ? (int64_t)strlen((const char *)of->point_law) + 1 : 0,
      .law_count = law_count,
      .point_region = of->point_region,
      .region_law = of->region_law,
      .axis_mass = of->axis_mass,
      .fixed = of->fixed,
      .inertia = of->inertia,
      .unit_energy = js_number[1]};

  // what follows has no coefficients of its own
  if (masters > 0 && !take_slaves(&made->model, masters, of->slave_map))
    return thrum_error_set(&js_failure, THRUM_INVALID_ARGUMENT,
                           "%d of %d coordinates cannot be followed by the others", (int)masters,
                           (int)rank);

  // what the runtime wants besides: a mesh, a pack, a surface, and what touches
  thrum_status status = make_mesh(made, of->positions, of->basis);
  if (status == THRUM_OK && of->tet != NULL)
    status = make_rigid(made, of->tet, of->tet_rigid);
  if (status == THRUM_OK && masters == 0)
    status = pack(&made->model);
  if (status == THRUM_OK)
    status = make_surface(made);
  if (status == THRUM_OK)
    status = list_touch(made);
  return status == THRUM_OK ? model_count++ : (int32_t)status;
}
