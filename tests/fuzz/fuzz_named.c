/* Fuzz target of what is read by the name of a file, and of loads and starts with a model: the
 * first byte says what, the second how, and behind a line of two @ begins a second file, beside the
 * first one. What can be written is written and read again.
 *
 * sources: mesh/*.c mesh/formats/*.c io/text.c io/file.c io/npy_file.c io/npz.c io/zip_write.c
 * io/paths.c io/json_read.c platform/*.c driver/scene/scene_spec.c driver/scene/scene_keys.c
 * driver/spec/shared_options.c driver/spec/basis_asked.c config/options.c config/options_json.c
 * config/options_command.c config/parse.c config/message.c config/message_error.c
 * driver/spec/load_spec.c driver/spec/actuate_spec.c driver/spec/base_motion_spec.c
 * driver/spec/start_spec.c driver/spec/static_solve.c driver/make/mesh_model.c
 * driver/make/named_model.c driver/spec/model_names.c driver/spec/region_material.c
 * driver/spec/region_elastic.c driver/record/run_entries.c driver/scene/scene_words.c
 * precompute/vega_reduced.c precompute/model/load_share.c precompute/model/traction.c
 * precompute/fem/solid_face.c core/[a-z]*[a-z]/*.c runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier:
 * Apache-2.0 */
#define _GNU_SOURCE // memmem
#include <sys/stat.h>

#include "driver/scene/scene_spec.h"
#include "driver/spec/base_motion_spec.h"
#include "driver/spec/load_spec.h"
#include "driver/spec/start_spec.h"
#include "io/npy_file.h"
#include "io/npz.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/surface_read.h"
#include "precompute/model/model_fem.h"
#include "precompute/vega_reduced.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_mesh.h"
#include "tests/fuzz/fuzz_random.h"
#include "thrum/thrum.h"

#define RANK 3
#define VERTICES 6

static const char *const suffixes[] = {".veg",  ".msh", ".mesh", ".vtk", ".vtu", ".inp", ".ele",
                                       ".node", ".stl", ".obj",  ".npy", ".csv", ".npz"};

// --- files
// ----------------------------------------------------------------------------------------

static char folder[64], first[100], second[100];

static void remove_files(void) {
  unlink(first);
  unlink(second);
}

static void leave(void) {
  remove_files();
  rmdir(folder);
}

static void put(const char *path, const uint8_t *data, size_t size) {
  FILE *file = fopen(path, "wb");
  if (file == NULL || fwrite(data, 1, size, file) != size || fclose(file) != 0)
    abort();
}

/* Writes the input as one file or two, with suffixes of the kind. */
static void write_files(unsigned kind, const uint8_t *data, size_t size) {
  if (folder[0] == 0) {
    snprintf(folder, sizeof folder, "%s/thrum-fuzz-XXXXXX",
             access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp");
    if (mkdtemp(folder) == NULL)
      abort();
    atexit(leave);
  }
  static const char mark[] = "@@\n";
  const uint8_t *other = memmem(data, size, mark, sizeof mark - 1);
  const size_t length = other != NULL ? (size_t)(other - data) : size;
  remove_files();

  // TetGen's two files have one name
  const char *suffix = suffixes[kind % (sizeof suffixes / sizeof *suffixes)];
  const char *beside = strcmp(suffix, ".ele") == 0    ? "a.node"
                       : strcmp(suffix, ".node") == 0 ? "a.ele"
                                                      : "b.veg";
  snprintf(first, sizeof first, "%s/a%s", folder, suffix);
  snprintf(second, sizeof second, "%s/%s", folder, beside);
  put(first, data, length);
  if (other != NULL)
    put(second, other + sizeof mark - 1, size - length - (sizeof mark - 1));
}

// --- what is read
// ---------------------------------------------------------------------------------

static void read_mesh(const char *name, unsigned how) {
  static const char *const regions[] = {NULL, "region", "mat_id", "none"};
  static const char *const units[] = {NULL, "mm-t-s", "m-kg-s", "in-slug-ms", ""};
  thrum_mesh mesh = {0};
  thrum_error error = {0};
  const thrum_mesh_read_options options = {.scale = how % 4 == 3 ? 1e-3 : 1,
                                           .order = (int)(how / 4 % 3),
                                           .unit = units[how / 16 % 5],
                                           .regions = regions[how / 8 % 4]};
  const thrum_status status = thrum_mesh_read_with(name, &options, &mesh, &error);
  fuzz_mesh_examine(status, &mesh, &error);
}

/* A generator with counts of one digit, or a name without a reader; a slash could name a file of
 * this machine. */
static bool is_small_name(const char *text) {
  for (const char *c = text; *c != 0; c++)
    if (*c == '/' || (c[0] >= '0' && c[0] <= '9' && c[1] >= '0' && c[1] <= '9'))
      return false;
  return strlen(text) < 48 && strchr(text, 'e') != NULL && access(text, F_OK) != 0;
}

static void read_surface(void) {
  thrum_surface_mesh surface = {0};
  thrum_error error = {0};
  fuzz_check(thrum_surface_mesh_read(first, 1, &surface, &error), &error);
  thrum_surface_mesh_free(&surface);
}

/* An array that was written is read again with the same numbers. */
static void read_array(void) {
  double *values = NULL, *again = NULL;
  int64_t rows = 0, columns = 0, rows_again = 0, columns_again = 0;
  thrum_error error = {0};
  const thrum_status status = thrum_npy_read_f8(first, &values, &rows, &columns, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;
  const size_t bytes = (size_t)(rows * (columns > 0 ? columns : 1)) * sizeof *values;
  if (thrum_npy_write_f8(second, values, rows, columns, &error) < 0 ||
      thrum_npy_read_f8(second, &again, &rows_again, &columns_again, &error) < 0 ||
      rows != rows_again || columns != columns_again || memcmp(values, again, bytes) != 0)
    abort();
  free(values);
  free(again);
}

/* The masses of a body are no matter of readers, and need the libraries of sparse matrices. */
thrum_status thrum_model_fem_create(const thrum_model *model, thrum_model_fem *body,
                                    thrum_error *error) {
  (void)model;
  (void)body;
  return thrum_error_set(error, THRUM_MISSING, "no masses");
}

thrum_status thrum_model_borrow_mesh(const thrum_model *model, thrum_mesh *mesh,
                                     thrum_error *error) {
  (void)model;
  (void)mesh;
  return thrum_error_set(error, THRUM_MISSING, "no mesh");
}

void thrum_model_fem_free(thrum_model_fem *body) {
  (void)body;
}

/* A load or a start, which may name the first file as FILE. */
static void use_spec(char *text, bool starts) {
  const thrum_model *model = fuzz_random_model(RANK, VERTICES);
  double forces[3 * VERTICES] = {0}, q[RANK] = {0}, p[RANK] = {0};
  thrum_error error = {0};
  load_spec load = {0};
  start_spec start = {0};
  thrum_status status =
      starts ? start_spec_parse(text, &start, &error) : load_spec_parse(text, &load, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;

  // what was parsed is put onto a model
  if (starts && start.kind == START_FILE)
    start.path = first;
  status = starts ? start_specs_make(model, &start, 1, q, p, &error)
                  : load_spec_fill(model, &load, forces, &error);
  fuzz_check(status, &error);
  if (!starts && status >= 0)
    fuzz_check(load_spec_reduce(model, &load, q, &error), &error);
}

static void read_motion(void) {
  base_motion_spec motion = {0};
  thrum_error error = {0};
  thrum_status status = base_motion_parse(first, &motion, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;
  status = base_motion_read(&motion, &error);
  fuzz_check(status, &error);

  // what was read is asked for as a run asks
  double mean[3], position[3];
  for (int64_t step = 0; status >= 0 && step < 3; step++)
    base_motions_mean(&motion, 1, step, 0.01, mean);
  if (status >= 0) {
    base_motions_position(&motion, 1, 0.02, position);
    base_motion_end(&motion);
  }
  base_motion_close(&motion);
}

/* A basis and its polynomial; what a model exports is read again. */
static void read_vega(unsigned how) {
  thrum_imported_basis imported = {0};
  thrum_error error = {0};

  // one draw in four reads what Thrum wrote, the others what was drawn
  if (how % 4 == 0) {
    const thrum_model *model = fuzz_random_model(RANK, VERTICES);
    if (thrum_vega_basis_write(first, model, how / 4 % 2, &error) < 0 ||
        thrum_vega_cubic_write(second, model, &error) < 0 ||
        thrum_vega_basis_read(first, &imported, &error) < 0 ||
        thrum_vega_cubic_read(second, &imported, &error) < 0 || imported.rank != RANK)
      abort();
  } else {
    if (how % 4 != 1)
      fuzz_check(thrum_vega_basis_read(first, &imported, &error), &error);
    fuzz_check(thrum_vega_cubic_read(how % 4 == 3 ? second : first, &imported, &error), &error);
  }
  thrum_imported_basis_free(&imported);
}

/* A model that was loaded is the same after it was saved. */
static void read_model(void) {
  const thrum_model *model = NULL, *again = NULL;
  thrum_error error = {0};
  const thrum_status status = thrum_model_load(first, &model, &error);
  fuzz_check(status, &error);
  if (status < 0)
    return;
  if (thrum_model_save(second, model, &error) < 0 || thrum_model_load(second, &again, &error) < 0 ||
      again->identity != model->identity || again->rank != model->rank ||
      again->vertex_count != model->vertex_count)
    abort();
  thrum_model_destroy(model);
  thrum_model_destroy(again);
}

static void read_scene(void) {
  scene_spec spec = {0};
  thrum_error error = {0};
  fuzz_check(scene_spec_read(first, &spec, &error), &error);
  scene_spec_free(&spec);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  if (size < 2)
    return 0;

  // the first byte says what the files are, the second what is done with them
  const unsigned kind = data[0] % 18, how = data[1];
  write_files(kind, data + 2, size - 2);
  char *text = fuzz_text(data + 2, size - 2);

  // the kinds below 8 are the formats of meshes
  switch (kind) {
  case 8:
  case 9:
    read_surface();
    break;
  case 10:
    read_array();
    break;
  case 11:
    read_motion();
    break;
  case 12:
    read_model();
    break;
  case 13:
    if (is_small_name(text))
      read_mesh(text, how);
    break;
  case 14:
  case 15:
    if (strchr(text, '\n') == NULL)
      use_spec(text, kind == 15);
    break;
  case 16:
    read_vega(how);
    break;
  case 17:
    read_scene();
    break;
  default:
    read_mesh(first, how);
  }
  free(text);
  return 0;
}
