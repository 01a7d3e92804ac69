/* Rows of equilibria, see static_path.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/statics/static_path.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static void put_line(static_path *path, const char *line) {
  if (path->status >= 0)
    path->status = thrum_file_writer_put(&path->writer, line, strlen(line), &path->error);
}

thrum_status static_path_open(const static_request *request, static_path_mean *mean,
                              static_path *path, thrum_error *error) {
  char text[80];
  *path = (static_path){.request = request, .mean = mean};
  if (request->path == NULL)
    return THRUM_OK;
  THRUM_TRY(thrum_file_writer_open(request->path, &path->writer, error));
  put_line(path, "factor,energy_j,least_eigenvalue,jumped");
  for (int64_t n = 1; n <= request->target_count; n++) {
    snprintf(text, sizeof text, ",x%lld_m,y%lld_m,z%lld_m", (long long)n, (long long)n,
             (long long)n);
    put_line(path, text);
  }
  put_line(path, "\n");
  return THRUM_OK;
}

void static_path_put(static_path *path, const static_path_point *point, const void *context) {
  char text[160], least[40] = "nan";
  if (path->request->path == NULL)
    return;
  if (isfinite(point->least))
    snprintf(least, sizeof least, "%.17g", point->least);
  snprintf(text, sizeof text, "%.17g,%.17g,%s,%d", point->factor, point->energy, least,
           (int)point->jumped);
  put_line(path, text);
  for (int64_t n = 0; n < path->request->target_count && path->status >= 0; n++) {
    double mean[3];
    path->status = path->mean(context, &path->request->targets[n], mean, &path->error);
    snprintf(text, sizeof text, ",%.17g,%.17g,%.17g", mean[0], mean[1], mean[2]);
    put_line(path, text);
  }
  put_line(path, "\n");
}

thrum_status static_path_close(static_path *path, thrum_error *error) {
  if (path->request->path == NULL)
    return THRUM_OK;
  if (path->status >= 0)
    return thrum_file_writer_commit(&path->writer, error);
  if (error != NULL)
    *error = path->error;
  return path->status;
}

void static_path_abandon(static_path *path) {
  thrum_file_writer_abandon(&path->writer);
}
