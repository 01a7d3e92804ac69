/* Writes the frames of a run for ParaView as .vtu files (vtu_grid.h), and .pvd files that list
 * them. SPDX-License-Identifier: Apache-2.0 */
#include "io/vtu.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"
#include "io/vtu_grid.h"

#define VTU_NAME_SIZE 48
#define FRAME_ARRAYS 4 /* besides vectors: fixed, region and two stresses */

/* The point vectors of a frame, and its stresses. */
typedef struct vtu_vectors {
  int64_t count;
  const double *const *values; /* each vertex_count x 3 */
  char (*names)[VTU_NAME_SIZE];
  vtu_stress stress;
} vtu_vectors;

static thrum_status check_mesh(const thrum_model *model, thrum_error *error) {
  if (model->vertices == NULL || model->tets == NULL)
    return thrum_error_set(error, THRUM_MISSING, "the model has no mesh, so it has no frames");
  return THRUM_OK;
}

static thrum_status write_failed(const char *path, thrum_error *error) {
  const int reason = errno != 0 ? errno : EIO;
  return thrum_error_set(error, THRUM_IO, "%.200s: cannot be written (%s)%s", path,
                         strerror(reason), thrum_file_hint(reason));
}

/* Writes a whole .vtu file. Write errors leave their mark on the stream; returns false when there
 * is no memory. */
static bool put_file(FILE *file, const thrum_model *model, const vtu_vectors *vectors,
                     double time) {
  vtu_array *arrays = malloc((size_t)(vectors->count + FRAME_ARRAYS) * sizeof *arrays);
  int32_t *regions = malloc((size_t)model->solid_count * sizeof *regions + 1);
  int64_t count = 0;
  if (arrays == NULL || regions == NULL) {
    free(arrays);
    free(regions);
    return false;
  }

  // a solid has the region of its first tetrahedron
  for (int64_t s = 0; s < model->solid_count; s++)
    regions[s] = model->tet_region[s > 0 ? model->solid_tet_ends[s - 1] : 0];

  // the model's own arrays, then those of the frame
  arrays[count++] = (vtu_array){"fixed", VTU_UINT8, 1, false, model->fixed};
  arrays[count++] = (vtu_array){"region", VTU_INT32, 1, true,
                                model->solid_count > 0 ? regions : model->tet_region};
  for (int64_t n = 0; n < vectors->count; n++)
    arrays[count++] = (vtu_array){vectors->names[n], VTU_FLOAT64, 3, false, vectors->values[n]};
  const vtu_stress *stress = &vectors->stress;
  if (stress->nodes != NULL)
    arrays[count++] = (vtu_array){stress->patches ? "von_mises_patch_average" : "von_mises",
                                  VTU_FLOAT64, 1, false, stress->nodes};
  if (stress->centres != NULL)
    arrays[count++] = (vtu_array){"von_mises_centre", VTU_FLOAT64, 1, true, stress->centres};

  const vtu_grid grid = {.point_count = model->vertex_count,
                         .tet_count = model->tet_count,
                         .points = model->vertices,
                         .tets = model->tets,
                         .midsides = model->midsides,
                         .solid_count = model->solid_count,
                         .solid_form = model->solid_form,
                         .solid_ends = model->solid_ends,
                         .solid_nodes = model->solid_nodes,
                         .arrays = arrays,
                         .array_count = count,
                         .vectors = vectors->names[0],
                         .time = &time};
  vtu_grid_write(file, &grid);
  free(regions);
  free(arrays);
  return true;
}

thrum_status vtu_write(const char *path, const thrum_model *model, const double *displacement,
                       const vtu_stress *stress, double time, thrum_error *error) {
  const vtu_stress none = {0};
  char name[1][VTU_NAME_SIZE] = {"displacement"};
  THRUM_TRY(check_mesh(model, error));

  // a write may fail without setting errno, and then an old value must not be reported
  errno = 0;
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return write_failed(path, error);

  const bool put =
      put_file(file, model, &(vtu_vectors){1, &displacement, name, stress ? *stress : none}, time);
  const bool failed = !put || ferror(file) != 0;
  // nothing but closing comes between the failure and its reason
  return fclose(file) != 0 || failed ? write_failed(path, error) : THRUM_OK;
}

/* Writes a file beside its place first and then renames it, so that no reader sees half of one. */
static thrum_status write_whole(const char *path, const thrum_model *model,
                                const vtu_vectors *vectors, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  THRUM_TRY(check_mesh(model, error));
  THRUM_TRY(thrum_file_writer_open(path, &writer, error));
  const thrum_status status =
      put_file(writer.stream, model, vectors, 0)
          ? THRUM_OK
          : thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for a frame");
  return thrum_file_writer_end(&writer, status, error);
}

thrum_status vtu_write_whole(const char *path, const thrum_model *model, const double *displacement,
                             const vtu_stress *stress, thrum_error *error) {
  const vtu_stress none = {0};
  char name[1][VTU_NAME_SIZE] = {"displacement"};
  return write_whole(path, model, &(vtu_vectors){1, &displacement, name, stress ? *stress : none},
                     error);
}

thrum_status vtu_write_modes(const char *path, const thrum_model *model, int64_t count,
                             const double *hertz, const double *modes, thrum_error *error) {
  const double **values = malloc((size_t)count * sizeof *values);
  char(*names)[VTU_NAME_SIZE] = malloc((size_t)count * sizeof *names);
  thrum_status status = THRUM_OUT_OF_MEMORY;

  if (values == NULL || names == NULL) {
    thrum_error_set(error, status, "out of memory");
  } else {
    // ParaView lists the arrays by name, so two digits keep them in order
    for (int64_t n = 0; n < count; n++) {
      values[n] = modes + n * 3 * model->vertex_count;
      snprintf(names[n], VTU_NAME_SIZE, "mode_%02" PRId64 "_%.6g_Hz", n + 1, hertz[n]);
    }

    status = write_whole(path, model, &(vtu_vectors){count, values, names, {0}}, error);
  }

  free(values);
  free(names);
  return status;
}

thrum_status pvd_open(const char *path, pvd_file *pvd, thrum_error *error) {
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return write_failed(path, error);
  fputs("<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"Collection\" version=\"0.1\">\n"
        "  <Collection>\n",
        file);
  pvd->stream = file;
  snprintf(pvd->path, sizeof pvd->path, "%s", path);
  return THRUM_OK;
}

thrum_status pvd_add(pvd_file *pvd, const char *file, double time, thrum_error *error) {
  if (fprintf(pvd->stream, "    <DataSet timestep=\"%.17g\" part=\"0\" file=\"%s\"/>\n", time,
              file) < 0)
    return write_failed(pvd->path, error);
  return THRUM_OK;
}

thrum_status pvd_close(pvd_file *pvd, thrum_error *error) {
  FILE *file = pvd->stream;
  pvd->stream = NULL;
  fputs("  </Collection>\n</VTKFile>\n", file);
  const bool failed = ferror(file) != 0;
  if (fclose(file) != 0 || failed)
    return write_failed(pvd->path, error);
  return THRUM_OK;
}

void pvd_abandon(pvd_file *pvd) {
  if (pvd->stream != NULL)
    fclose(pvd->stream);
  pvd->stream = NULL;
}
