/* Frames of a run for ParaView: .vtu (VTK XML unstructured grid) and .pvd (the list of them).
 *
 * A .vtu is XML whose arrays lie raw behind the '_' of its AppendedData, each after its length in
 * bytes as one UInt64; the XML names an array by its offset from the '_'. All the offsets follow
 * from the mesh's sizes, so a frame is written front to back without going back.
 * Format: "VTK XML formats", https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
 * SPDX-License-Identifier: Apache-2.0 */
#include "io/vtu.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/file.h"

#define VTK_TETRA 10
#define VTU_NAME_SIZE 48
#define CHUNK 4096 /* generated values are written in pieces of this many */

/* The arrays in file order. X(name, XML type, bytes of one value, components, tuples); VTK wants
 * the connectivity as one plain list. */
#define VTU_ARRAYS(X)                                                                              \
  X(points, "Float64", 8, 3, model->vertex_count)                                                  \
  X(connectivity, "Int32", 4, 1, 4 * model->tet_count)                                             \
  X(offsets, "Int64", 8, 1, model->tet_count)                                                      \
  X(types, "UInt8", 1, 1, model->tet_count)                                                        \
  X(fixed, "UInt8", 1, 1, model->vertex_count)                                                     \
  X(region, "Int32", 4, 1, model->tet_count)

enum {
#define X(name, type, bytes, columns, rows) ARRAY_##name,
  VTU_ARRAYS(X)
#undef X
      ARRAY_COUNT
};

/* Point vectors, which stand behind the other arrays, and behind them at most one cell scalar. */
typedef struct vtu_vectors {
  int64_t count;
  const double *const *values; /* each vertex_count x 3 */
  char (*names)[VTU_NAME_SIZE];
  const double *von_mises; /* tet_count; NULL: none */
} vtu_vectors;

typedef struct vtu_array {
  const char *type;
  uint64_t bytes;
  uint64_t offset; /* of its length, from the '_' */
  int columns;
} vtu_array;

/* Returns where the point vectors begin. */
static uint64_t plan_arrays(const thrum_model *model, vtu_array arrays[ARRAY_COUNT]) {
  uint64_t offset = 0;
#define X(name, xml_type, value_bytes, value_columns, rows)                                        \
  arrays[ARRAY_##name].type = xml_type;                                                            \
  arrays[ARRAY_##name].bytes = (uint64_t)(rows)*value_columns * value_bytes;                       \
  arrays[ARRAY_##name].columns = value_columns;                                                    \
  arrays[ARRAY_##name].offset = offset;                                                            \
  offset += sizeof(uint64_t) + arrays[ARRAY_##name].bytes;
  VTU_ARRAYS(X)
#undef X
  return offset;
}

/* Sizes and places of the point vectors. */
static vtu_array plan_vector(const thrum_model *model, uint64_t begin, int64_t index) {
  vtu_array array = {.type = "Float64", .columns = 3};
  array.bytes = (uint64_t)model->vertex_count * 3 * sizeof(double);
  array.offset = begin + (uint64_t)index * (sizeof(uint64_t) + array.bytes);
  return array;
}

/* The cell scalar behind `count` vectors. */
static vtu_array plan_scalar(const thrum_model *model, uint64_t begin, int64_t count) {
  vtu_array array = {.type = "Float64", .columns = 1};
  array.bytes = (uint64_t)model->tet_count * sizeof(double);
  array.offset = plan_vector(model, begin, count).offset;
  return array;
}

static void put_array_tag(FILE *file, const vtu_array *array, const char *name) {
  fprintf(file,
          "        <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" "
          "format=\"appended\" offset=\"%" PRIu64 "\"/>\n",
          array->type, name, array->columns, array->offset);
}

static bool is_little_endian(void) {
  const uint16_t probe = 1;
  unsigned char first;
  memcpy(&first, &probe, 1);
  return first == 1;
}

static void put_xml(FILE *file, const thrum_model *model, const vtu_array *arrays,
                    const vtu_vectors *vectors, uint64_t begin, double time) {
  fprintf(file,
          "<?xml version=\"1.0\"?>\n"
          "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"%s\" "
          "header_type=\"UInt64\">\n"
          "  <UnstructuredGrid>\n"
          "    <FieldData>\n"
          "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
          "format=\"ascii\">%.17g</DataArray>\n"
          "    </FieldData>\n"
          "    <Piece NumberOfPoints=\"%" PRId64 "\" NumberOfCells=\"%" PRId64 "\">\n"
          "      <Points>\n",
          is_little_endian() ? "LittleEndian" : "BigEndian", time, model->vertex_count,
          model->tet_count);
  put_array_tag(file, &arrays[ARRAY_points], "Points");
  fputs("      </Points>\n      <Cells>\n", file);
  put_array_tag(file, &arrays[ARRAY_connectivity], "connectivity");
  put_array_tag(file, &arrays[ARRAY_offsets], "offsets");
  put_array_tag(file, &arrays[ARRAY_types], "types");
  fprintf(file, "      </Cells>\n      <PointData Vectors=\"%s\">\n", vectors->names[0]);
  for (int64_t n = 0; n < vectors->count; n++) {
    const vtu_array array = plan_vector(model, begin, n);
    put_array_tag(file, &array, vectors->names[n]);
  }
  put_array_tag(file, &arrays[ARRAY_fixed], "fixed");
  fputs("      </PointData>\n      <CellData>\n", file);
  put_array_tag(file, &arrays[ARRAY_region], "region");
  if (vectors->von_mises != NULL) {
    const vtu_array array = plan_scalar(model, begin, vectors->count);
    put_array_tag(file, &array, "von_mises");
  }
  fputs("      </CellData>\n    </Piece>\n  </UnstructuredGrid>\n"
        "  <AppendedData encoding=\"raw\">\n_",
        file);
}

static void put_array(FILE *file, const vtu_array *array, const void *data) {
  fwrite(&array->bytes, sizeof array->bytes, 1, file);
  fwrite(data, 1, array->bytes, file);
}

/* Every cell is a tetrahedron: offsets 4, 8, 12, ... and one type. */
static void put_generated(FILE *file, const vtu_array *arrays, int64_t tet_count) {
  int64_t ends[CHUNK];
  unsigned char types[CHUNK];
  fwrite(&arrays[ARRAY_offsets].bytes, sizeof(uint64_t), 1, file);
  for (int64_t first = 0; first < tet_count; first += CHUNK) {
    const int64_t count = tet_count - first < CHUNK ? tet_count - first : CHUNK;
    for (int64_t n = 0; n < count; n++)
      ends[n] = 4 * (first + n + 1);
    fwrite(ends, sizeof *ends, (size_t)count, file);
  }
  memset(types, VTK_TETRA, sizeof types);
  fwrite(&arrays[ARRAY_types].bytes, sizeof(uint64_t), 1, file);
  for (int64_t first = 0; first < tet_count; first += CHUNK)
    fwrite(types, 1, (size_t)(tet_count - first < CHUNK ? tet_count - first : CHUNK), file);
}

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

/* The whole of a file; what goes wrong leaves its mark on the stream. */
static void put_file(FILE *file, const thrum_model *model, const vtu_vectors *vectors,
                     double time) {
  vtu_array arrays[ARRAY_COUNT];
  const uint64_t begin = plan_arrays(model, arrays);
  put_xml(file, model, arrays, vectors, begin, time);
  put_array(file, &arrays[ARRAY_points], model->vertices);
  put_array(file, &arrays[ARRAY_connectivity], model->tets);
  put_generated(file, arrays, model->tet_count);
  put_array(file, &arrays[ARRAY_fixed], model->fixed);
  put_array(file, &arrays[ARRAY_region], model->tet_region);
  for (int64_t n = 0; n < vectors->count; n++) {
    const vtu_array array = plan_vector(model, begin, n);
    put_array(file, &array, vectors->values[n]);
  }
  if (vectors->von_mises != NULL) {
    const vtu_array array = plan_scalar(model, begin, vectors->count);
    put_array(file, &array, vectors->von_mises);
  }
  fputs("\n  </AppendedData>\n</VTKFile>\n", file);
}

thrum_status cli_vtu_write(const char *path, const thrum_model *model, const double *displacement,
                           const double *von_mises, double time, thrum_error *error) {
  char name[1][VTU_NAME_SIZE] = {"displacement"};
  const thrum_status status = check_mesh(model, error);
  if (status < 0)
    return status;
  errno = 0;
  FILE *file = fopen(path, "wb");
  if (file == NULL)
    return write_failed(path, error);
  put_file(file, model, &(vtu_vectors){1, &displacement, name, von_mises}, time);
  const bool failed = ferror(file) != 0;
  // nothing but closing comes between the failure and its reason
  return fclose(file) != 0 || failed ? write_failed(path, error) : THRUM_OK;
}

/* Beside its place first, then renamed. */
static thrum_status write_whole(const char *path, const thrum_model *model,
                                const vtu_vectors *vectors, thrum_error *error) {
  thrum_file_writer writer = {NULL, NULL, NULL};
  thrum_status status = check_mesh(model, error);
  if (status >= 0)
    status = thrum_file_writer_open(path, &writer, error);
  if (status < 0)
    return status;
  put_file(writer.stream, model, vectors, 0);
  return thrum_file_writer_commit(&writer, error);
}

thrum_status cli_vtu_write_whole(const char *path, const thrum_model *model,
                                 const double *displacement, thrum_error *error) {
  char name[1][VTU_NAME_SIZE] = {"displacement"};
  return write_whole(path, model, &(vtu_vectors){1, &displacement, name, NULL}, error);
}

thrum_status cli_vtu_write_modes(const char *path, const thrum_model *model, int64_t count,
                                 const double *hertz, const double *modes, thrum_error *error) {
  const double **values = malloc((size_t)count * sizeof *values);
  char(*names)[VTU_NAME_SIZE] = malloc((size_t)count * sizeof *names);
  thrum_status status = THRUM_OUT_OF_MEMORY;
  if (values == NULL || names == NULL) {
    thrum_error_set(error, status, "out of memory");
  } else {
    for (int64_t n = 0; n < count; n++) {
      values[n] = modes + n * 3 * model->vertex_count;
      snprintf(names[n], VTU_NAME_SIZE, "mode_%02" PRId64 "_%.6g_Hz", n + 1, hertz[n]);
    }
    status = write_whole(path, model, &(vtu_vectors){count, values, names, NULL}, error);
  }
  free(values);
  free(names);
  return status;
}

thrum_status cli_pvd_open(const char *path, cli_pvd *pvd, thrum_error *error) {
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

thrum_status cli_pvd_add(cli_pvd *pvd, const char *file, double time, thrum_error *error) {
  if (fprintf(pvd->stream, "    <DataSet timestep=\"%.17g\" part=\"0\" file=\"%s\"/>\n", time,
              file) < 0) {
    return write_failed(pvd->path, error);
  }
  return THRUM_OK;
}

thrum_status cli_pvd_close(cli_pvd *pvd, thrum_error *error) {
  FILE *file = pvd->stream;
  pvd->stream = NULL;
  fputs("  </Collection>\n</VTKFile>\n", file);
  const bool failed = ferror(file) != 0;
  if (fclose(file) != 0 || failed)
    return write_failed(pvd->path, error);
  return THRUM_OK;
}

void cli_pvd_abandon(cli_pvd *pvd) {
  if (pvd->stream != NULL)
    fclose(pvd->stream);
  pvd->stream = NULL;
}
