/* The files of a run, written as it goes: energy.csv, q.npy, end.npy, the plot, the frames and at
 * last run.json. All go to the work folder, so a failure on the way costs nothing but the work.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/record/run_output.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "driver/record/energy_plot.h"
#include "driver/record/run_placement.h"
#include "io/json.h"
#include "io/npy_file.h"
#include "platform/allocate.h"
#include "thrum/thrum.h"

#define NPY_HEADER_MAX 192

typedef char path_text[RUN_PATH_MAX + 64];

static bool put_npy_header(FILE *file, int64_t rows, int64_t columns, size_t *size) {
  unsigned char header[NPY_HEADER_MAX];
  *size = thrum_npy_header_f8(header, rows, columns);
  return fwrite(header, 1, *size, file) == *size;
}

FILE *run_series_open(const run_folder *folder, const char *name, int64_t columns) {
  size_t size = 0;
  FILE *series = run_folder_create(folder, name);

  // the header is written for no rows now, which keeps its place
  if (series != NULL && !put_npy_header(series, 0, columns, &size)) {
    fclose(series);
    series = NULL;
  }
  return series;
}

bool run_series_close(FILE **series, int64_t rows, int64_t columns) {
  size_t before = 0, after = 0;
  unsigned char header[NPY_HEADER_MAX];
  before = thrum_npy_header_f8(header, 0, columns);
  const bool done = fseek(*series, 0, SEEK_SET) == 0 &&
                    put_npy_header(*series, rows, columns, &after) && before == after;
  return run_folder_close_file(series) && done;
}

static thrum_status open_frames(run_output *output, thrum_error *error) {
  const thrum_model *model = output->model;
  path_text path;
  if (model->vertices == NULL || model->basis == NULL) {
    return thrum_error_set_field(error, "--frames", THRUM_MISSING, ": the model has no %s to show",
                                 model->vertices == NULL ? "mesh" : "basis");
  }

  // room for the displacements of one frame, then the folder and the list of frames
  THRUM_TRY(thrum_reserve(&output->displacement, 3 * model->vertex_count,
                          sizeof *output->displacement, "the frames", error));
  snprintf(path, sizeof path, "%s/" RUN_FRAMES, output->folder.work);
  if (mkdir(path, 0777) != 0)
    return run_folder_write_failed(&output->folder, RUN_FRAMES, error);
  snprintf(path, sizeof path, "%s/frames.pvd", output->folder.work);
  return pvd_open(path, &output->pvd, error);
}

thrum_status run_output_open(const char *path, const thrum_model *model, bool frames, bool inside,
                             run_output *output, thrum_error *error) {
  run_output opened = {.model = model};
  thrum_status status = THRUM_OK;
  if (inside)
    THRUM_TRY(run_folder_open_inside(path, &opened.folder, error));
  else
    THRUM_TRY(run_folder_open(path, RUN_OF_BODY, &opened.folder, error));
  errno = 0;
  opened.energy = run_folder_create(&opened.folder, "energy.csv");
  opened.q = run_series_open(&opened.folder, "q.npy", model->rank);
  if (opened.energy == NULL || opened.q == NULL ||
      fputs("step,time_s,kinetic_j,potential_j,total_j,high_j\n", opened.energy) < 0)
    status = run_folder_write_failed(&opened.folder, "energy.csv or q.npy", error);

  if (status >= 0 && frames)
    status = open_frames(&opened, error);
  if (status < 0) {
    run_output_close(&opened);
    return status;
  }
  *output = opened;
  return THRUM_OK;
}

thrum_status run_output_record(run_output *output, int64_t step, double time, const double *q,
                               const thrum_energies *energies, thrum_error *error) {
  const size_t rank = (size_t)output->model->rank;
  errno = 0;
  if (fprintf(output->energy, "%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g\n", step, time,
              energies->kinetic, energies->potential, energies->total, energies->high) < 0)
    return run_folder_write_failed(&output->folder, "energy.csv", error);
  if (fwrite(q, sizeof *q, rank, output->q) != rank)
    return run_folder_write_failed(&output->folder, "q.npy", error);
  output->rows++;
  return THRUM_OK;
}

thrum_status run_output_open_places(run_output *output, thrum_error *error) {
  errno = 0;
  output->places = run_series_open(&output->folder, RUN_PLACEMENTS, RUN_PLACEMENT_COLUMNS);
  return output->places != NULL ? THRUM_OK
                                : run_folder_write_failed(&output->folder, RUN_PLACEMENTS, error);
}

thrum_status run_output_place(run_output *output, const double matrix[16], thrum_error *error) {
  double place[RUN_PLACEMENT_COLUMNS];
  run_placement_of(matrix, place);
  errno = 0;
  return fwrite(place, sizeof place, 1, output->places) == 1
             ? THRUM_OK
             : run_folder_write_failed(&output->folder, RUN_PLACEMENTS, error);
}

thrum_status run_output_frame(run_output *output, double time, const double base[3],
                              const vtu_stress *stress, thrum_error *error) {
  path_text path, name;
  const thrum_model *model = output->model;
  for (int64_t c = 0; c < 3 * model->vertex_count; c++)
    output->displacement[c] += base[c % 3];

  // the frame, then its line in the list
  snprintf(name, sizeof name, RUN_FRAMES "/frame_%06" PRId64 ".vtu", output->frames);
  snprintf(path, sizeof path, "%s/%.40s", output->folder.work, name);
  thrum_status status = vtu_write(path, model, output->displacement, stress, time, error);
  THRUM_THEN(status, pvd_add(&output->pvd, name, time, error));
  output->frames += status >= 0;
  return status;
}

static bool write_end(const run_output *output, const double *q, const double *p) {
  size_t size = 0;
  const size_t rank = (size_t)output->model->rank;
  FILE *file = run_folder_create(&output->folder, "end.npy");
  if (file == NULL)
    return false;
  const bool done = put_npy_header(file, 2, output->model->rank, &size) &&
                    fwrite(q, sizeof *q, rank, file) == rank &&
                    fwrite(p, sizeof *p, rank, file) == rank;
  return run_folder_close_file(&file) && done;
}

thrum_status run_output_end(run_output *output, const double *q, const double *p,
                            thrum_error *error) {
  errno = 0;
  if (!run_folder_close_file(&output->energy))
    return run_folder_write_failed(&output->folder, "energy.csv", error);

  // the headers of the series get the number of rows
  if (!run_series_close(&output->q, output->rows, output->model->rank))
    return run_folder_write_failed(&output->folder, "q.npy", error);
  output->moved = output->places != NULL;
  if (output->moved && !run_series_close(&output->places, output->rows, RUN_PLACEMENT_COLUMNS))
    return run_folder_write_failed(&output->folder, RUN_PLACEMENTS, error);

  // what the run can be continued from
  if (q != NULL && !write_end(output, q, p))
    return run_folder_write_failed(&output->folder, "end.npy", error);
  output->end = q != NULL;
  return output->pvd.stream != NULL ? pvd_close(&output->pvd, error) : THRUM_OK;
}

void run_output_plot(run_output *output, const char *title) {
  output->plot = energy_plot_draw(output->folder.work, title, output->rows);
}

thrum_status run_output_commit(run_output *output, const cJSON *figures, thrum_error *error) {
  char *text = json_text(figures);
  if (text == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "no memory for " RUN_JSON);

  // run.json last: it says that all else is whole
  errno = 0;
  FILE *file = run_folder_create(&output->folder, RUN_JSON);
  const bool written = file != NULL && fprintf(file, "%s\n", text) > 0;
  free(text);
  if (!run_folder_close_file(&file) || !written)
    return run_folder_write_failed(&output->folder, RUN_JSON, error);
  return run_folder_commit(&output->folder, error);
}

void run_output_close(run_output *output) {
  if (output->energy != NULL)
    fclose(output->energy);
  if (output->q != NULL)
    fclose(output->q);
  if (output->places != NULL)
    fclose(output->places);
  pvd_abandon(&output->pvd);
  free(output->displacement);
  run_folder_abandon(&output->folder);
  memset(output, 0, sizeof *output);
}
