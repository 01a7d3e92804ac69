/* Model files that a person drops on the page. SPDX-License-Identifier: Apache-2.0 */
#include <stdint.h>
#include <stdlib.h>

#include "page.h"

static void *opened;                    // the arrays of the file that was opened last
static const thrum_model *opened_model; // in it; NULL: none

const thrum_model *page_opened_model(void) {
  return opened_model;
}

void page_keep_opened(void) {
  opened = NULL;
  opened_model = NULL;
}

static double address_of(const void *array) {
  return (double)(uintptr_t)array;
}

static void tell_counts(const thrum_model *model) {
  double *n = js_number;
  n[0] = (double)model->rank;
  n[1] = (double)model->vertex_count;
  n[2] = (double)model->tet_count;
  n[3] = (double)model->region_count;
  n[4] = (double)model->c3_count;
  n[5] = (double)model->c4_count;
  n[6] = (double)model->point_count;
  n[7] = (double)model->law_bytes;
  n[8] = (double)thrum_model_masters(model);
  n[9] = (double)model->law_count;
}

static void tell_arrays(const thrum_model *model) {
  const void *const arrays[] = {model->omega2,        model->c3,           model->c4,
                                model->point_weights, model->point_moduli, model->point_gradients,
                                model->point_law,     model->point_region, model->region_law,
                                model->axis_mass,     model->vertices,     model->basis,
                                model->fixed,         model->tets,         model->rigid,
                                model->material,      model->slave_map,    model->condensed_c3,
                                model->condensed_c4};
  for (size_t n = 0; n < sizeof arrays / sizeof *arrays; n++)
    js_number[10 + n] = address_of(arrays[n]);
}

/* The energy of the model that was opened last at strains of 1 [J]. */
double EXPORT(page_unit_energy)(void) {
  return thrum_model_unit_energy(opened_model);
}

/* Reads a model file. numbers: rank, counts of vertices, tetrahedra, regions, c3, c4 and points,
 * bytes of the law, masters, laws of regions; then the addresses of omega2, c3, c4, point_weights,
 * point_moduli, point_gradients, point_law, point_region, region_law, axis_mass, vertices, basis,
 * fixed, tets, rigid, material, slave_map, condensed_c3 and condensed_c4, 0 where the file has
 * none. They hold until the next file. Bodies are elastic on the page, so yields are left out. */
int32_t EXPORT(page_open_model)(const void *file, int32_t size) {
  size_t bytes;
  const thrum_model *model;
  THRUM_TRY(thrum_model_size(file, (size_t)size, &bytes, &js_failure));
  free(opened);
  opened_model = NULL;
  opened = js_alloc(bytes);
  if (opened == NULL)
    return thrum_error_set(&js_failure, THRUM_OUT_OF_MEMORY, "the page has no memory left");
  THRUM_TRY(thrum_model_init(opened, bytes, file, (size_t)size, &model, &js_failure));

  ((thrum_model *)(uintptr_t)model)->region_yield = NULL;

  // what the page cannot show or step
  if (model->tets == NULL || model->basis == NULL || model->axis_mass == NULL)
    return thrum_error_set(
        &js_failure, THRUM_MISSING,
        "the model has no mesh, no basis or no axis_mass, so it cannot be shown");
  opened_model = model;
  tell_counts(model);
  tell_arrays(model);
  return THRUM_OK;
}
