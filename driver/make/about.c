/* States about which models are made. SPDX-License-Identifier: Apache-2.0 */
#include "driver/make/about.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/npy_file.h"
#include "io/text.h"
#include "mesh/elastic.h"
#include "mesh/formats/file_suffix.h"
#include "platform/allocate.h"
#include "precompute/fem/about_state.h"

/* A length that shrinks to a third or grows threefold is none of these materials. */
#define STRAIN_MOST 0.66

typedef struct about_text {
  bool stretches, heats;
  double numbers[3];
} about_text;

/* Reads so many numbers with commas between them. */
static bool scan(const char *text, int count, double *numbers) {
  const char *end = text + strlen(text);
  for (int n = 0; n < count; n++) {
    const size_t used = thrum_text_scan_number(text, end, &numbers[n]);
    text += used;
    if (used == 0 || *text != (n < count - 1 ? ',' : '\0'))
      return false;
    text++;
  }
  return true;
}

static bool parse(const char *text, about_text *made) {
  static const char stretch[] = "stretch:", heat[] = "temperature:";
  *made = (about_text){.stretches = strncmp(text, stretch, sizeof stretch - 1) == 0,
                       .heats = strncmp(text, heat, sizeof heat - 1) == 0};
  if (made->stretches && scan(text + sizeof stretch - 1, 3, made->numbers))
    return fabs(made->numbers[0]) < STRAIN_MOST && fabs(made->numbers[1]) < STRAIN_MOST &&
           fabs(made->numbers[2]) < STRAIN_MOST;
  if (made->heats && scan(text + sizeof heat - 1, 2, made->numbers))
    return fabs(made->numbers[0] * made->numbers[1]) < STRAIN_MOST;
  return !made->stretches && !made->heats && thrum_file_has_suffix(text, ".npy");
}

thrum_status about_option_check(const config_given *given) {
  about_text made;
  if (parse(given->text, &made))
    return THRUM_OK;
  return config_given_refuse(given,
                             "'%.100s' is no state; write stretch:EX,EY,EZ (strains of what "
                             "is held), temperature:DT,ALPHA or a FILE.npy of thrum static "
                             "--displacements",
                             given->text);
}

/* The displacements of a file. */
static thrum_status read_file(const char *path, thrum_mesh *mesh, thrum_error *error) {
  double *values = NULL;
  int64_t rows = 0, columns = 0;
  THRUM_TRY(thrum_npy_read_f8(path, &values, &rows, &columns, error));
  if (rows != mesh->vertex_count || columns != 3) {
    free(values);
    return thrum_error_set(error, THRUM_BAD_SHAPE,
                           "%.200s holds %lld x %lld numbers, and the mesh has %lld vertices: it "
                           "is of thrum static --displacements, of a model of the same mesh",
                           path, (long long)rows, (long long)columns,
                           (long long)mesh->vertex_count);
  }
  mesh->about = values;
  return THRUM_OK;
}

/* The body that is free of stress where it is warm, of the same mass. */
static void grow(double share, thrum_mesh *mesh) {
  for (int64_t c = 0; c < 3 * mesh->vertex_count; c++)
    mesh->vertices[c] *= 1 + share;
  for (int64_t i = 0; i < mesh->region_count; i++)
    mesh->materials[i].density /= pow(1 + share, 3);
}

static bool is_any_held(const uint8_t *fixed, const thrum_mesh *mesh) {
  bool any = false;
  for (int64_t v = 0; v < mesh->vertex_count; v++)
    any = any || fixed[v] != 0;
  return any;
}

thrum_status about_find(const char *text, const uint8_t *fixed, thrum_mesh *mesh,
                        thrum_error *error) {
  about_text made;
  parse(text, &made);

  // the loads of a file do not turn with a body, so a free one would have no rigid modes
  if (!is_any_held(fixed, mesh))
    return thrum_error_set_field(error, "--about", THRUM_INVALID_ARGUMENT,
                                 ": nothing is held, and a free body has no state: give --fix");
  THRUM_TRY(thrum_mesh_make_solids(mesh, error));
  if (!made.stretches && !made.heats)
    return read_file(text, mesh, error);

  // what is held goes to where the state has it, and all else follows
  const int64_t all = 3 * mesh->vertex_count;
  const double share = made.heats ? made.numbers[0] * made.numbers[1] : 0;
  double *field = NULL, *state = NULL;
  thrum_fem fem = {0};
  THRUM_TRY(thrum_reserve(&field, all, sizeof *field, "the state", error));
  thrum_status status = thrum_reserve(&state, all, sizeof *state, "the state", error);
  for (int64_t c = 0; c < all; c++)
    field[c] = mesh->vertices[c] * (made.heats ? -share : made.numbers[c % 3]);
  grow(share, mesh);
  THRUM_THEN(status, thrum_fem_create(mesh, fixed, &fem, error));
  THRUM_THEN(status, thrum_about_state(&fem, field, state, error));
  thrum_fem_free(&fem);
  free(field);
  if (status < 0) {
    free(state);
    return status;
  }
  mesh->about = state;
  return THRUM_OK;
}

thrum_status about_loads(const thrum_mesh *mesh, const uint8_t *fixed, double loads[3],
                         thrum_error *error) {
  thrum_fem fem = {0};
  double *force = NULL;
  thrum_status status =
      thrum_reserve(&force, 3 * mesh->vertex_count, sizeof *force, "the loads of a state", error);
  THRUM_THEN(status, thrum_fem_create(mesh, fixed, &fem, error));
  if (status >= 0) {
    memset(loads, 0, 3 * sizeof *loads);
    thrum_fem_energy(&fem, mesh->about, force);
    for (int64_t i = 0; i < fem.free_count; i++)
      loads[fem.component[i] % 3] += force[fem.component[i]];
  }
  thrum_fem_free(&fem);
  free(force);
  return status < 0 ? status : THRUM_OK;
}
