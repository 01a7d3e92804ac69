/* A run of a reduced model beside the whole mesh.
 *
 * Both are stepped side by side, with the same loads, time step and damping, by the same method: a
 * mode that one of them turns at its own frequency and the other late would be taken for an error
 * of the basis. Rows are taken at the rows of the run; what is between them is not looked at. With
 * w = u - U q the errors are sqrt(sum w^T M w / sum u^T M u) and the same of velocities. Cost: that
 * of the mesh. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/against_mesh.h"

#include <cblas.h>
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "config/message.h"
#include "config/progress.h"
#include "driver/record/run_plot.h"
#include "driver/run/stepper.h"
#include "platform/allocate.h"
#include "platform/clock.h"
#include "platform/stop_request.h"
#include "precompute/model/model_fem.h"

/* Both steppers, and the sums of squares so far. */
typedef struct side_by_side {
  const thrum_model *shape;
  driver_stepper model, mesh;
  thrum_model_fem body;
  double *whole, *part;       /* fields of all components; owned, with the next two */
  double *gathered, *product; /* of the free ones */
  double mass;                /* of the body [kg] */
  double apart, moved, apart_v, moved_v;
  FILE *rows;
} side_by_side;

/* The integrator that steps both: the run's, where the mesh has it and any step is stable. */
static thrum_integrator integrator_of_mesh(thrum_integrator integrator) {
  return integrator == THRUM_INTEGRATOR_NEWMARK || integrator == THRUM_INTEGRATOR_MIDPOINT
             ? integrator
             : THRUM_INTEGRATOR_ENERGY;
}

static thrum_status open_both(const simulate_request *request, const simulate_request *of_mesh,
                              const thrum_model *stepped, side_by_side *s, thrum_error *error) {
  const int64_t all = 3 * s->shape->vertex_count;
  THRUM_TRY(thrum_model_fem_create(s->shape, &s->body, error));
  THRUM_TRY(thrum_reserve(&s->whole, 4 * all, sizeof *s->whole, "the mesh", error));
  s->part = s->whole + all;
  s->gathered = s->part + all;
  s->product = s->gathered + all;
  thrum_fem_vertex_mass(&s->body.fem, s->body.kind, s->whole);
  for (int64_t v = 0; v < s->shape->vertex_count; v++)
    s->mass += s->whole[v];
  THRUM_TRY(driver_stepper_reduced(request, stepped, &s->model, error));
  return driver_stepper_full(of_mesh, s->shape, &s->mesh, error);
}

static void close_both(side_by_side *s) {
  driver_stepper_close(&s->model);
  driver_stepper_close(&s->mesh);
  thrum_model_fem_free(&s->body);
  free(s->whole);
}

/* The mean square of a field over the mass. */
static double square(side_by_side *s, const double *field) {
  const int64_t n = s->body.fem.free_count;
  thrum_fem_gather(&s->body.fem, field, s->gathered);
  thrum_sparse_product(&s->body.mass, s->gathered, 1, s->product);
  return fmax(0, cblas_ddot((int)n, s->gathered, 1, s->product, 1)) / s->mass;
}

/* part = part - whole */
static void subtract(side_by_side *s) {
  for (int64_t c = 0; c < 3 * s->shape->vertex_count; c++)
    s->part[c] -= s->whole[c];
}

/* What differs now, into the sums and a row. */
static thrum_status compare(side_by_side *s, int64_t step, double time, thrum_error *error) {
  double q[THRUM_RANK_MAX], p[THRUM_RANK_MAX];
  const int64_t count = s->shape->vertex_count;
  THRUM_TRY(s->mesh.kind->displacements(s->mesh.self, 0, s->whole, error));
  THRUM_TRY(s->model.kind->displacements(s->model.self, 0, s->part, error));
  const double moved = square(s, s->whole);
  subtract(s);
  const double apart = square(s, s->part);

  // the velocities in the same way
  THRUM_TRY(s->mesh.kind->velocities(s->mesh.self, s->whole));
  THRUM_TRY(s->model.kind->snapshot(s->model.self, 0, q, p, error));
  THRUM_TRY(thrum_displacement(s->shape, p, 0, count, s->part, error));
  const double moved_v = square(s, s->whole);
  subtract(s);
  const double apart_v = square(s, s->part);
  s->apart += apart;
  s->moved += moved;
  s->apart_v += apart_v;
  s->moved_v += moved_v;

  // root mean squares now, and the shares so far
  errno = 0;
  if (fprintf(s->rows, "%" PRId64 ",%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", step, time,
              sqrt(apart), sqrt(moved), sqrt(apart_v), sqrt(moved_v),
              s->moved > 0 ? sqrt(s->apart / s->moved) : 0,
              s->moved_v > 0 ? sqrt(s->apart_v / s->moved_v) : 0) < 0 ||
      fflush(s->rows) != 0)
    return thrum_error_set(error, THRUM_IO, AGAINST_MESH_CSV " could not be written");
  return THRUM_OK;
}

/* The errors so far, which stand should the user stop a step that takes long. */
static void note_errors(const side_by_side *s, int64_t step, double time, against_mesh *against) {
  against->steps = step;
  against->time = time;
  if (s->moved > 0)
    against->displacement = sqrt(s->apart / s->moved);
  if (s->moved_v > 0)
    against->velocity = sqrt(s->apart_v / s->moved_v);
}

/* Steps both until the end, the time or the user says so. */
static thrum_status step_both(const simulate_request *request, side_by_side *s,
                              config_progress *progress, double began, against_mesh *against,
                              thrum_error *error) {
  int64_t step = 0;
  thrum_error detail = {0};
  THRUM_TRY(compare(s, 0, 0, error));
  while (step < request->steps && against->ended == NULL) {
    const double spent = clock_seconds() - began;
    const double done = (double)step / (double)request->steps;
    config_progress_update(progress, "against the mesh", fmax(done, spent / request->against_mesh));

    // a step of the mesh may take long, so each looks at the clock
    if (thrum_stop_requested())
      against->ended = "stopped";
    else if (spent > request->against_mesh)
      against->ended = "the time is over";
    else if (s->mesh.kind->advance(s->mesh.self, step, &detail) < 0)
      against->ended = "the mesh could not be stepped further";
    else if (s->model.kind->advance(s->model.self, step, &detail) < 0)
      against->ended = "the model could not be stepped further";
    else
      step++;
    const double time = (double)step * request->def.dt;
    if (against->ended == NULL && (step % request->record_every == 0 || step == request->steps))
      THRUM_TRY(compare(s, step, time, error));
    note_errors(s, step, time, against);
  }
  against->whole = step == request->steps;
  return THRUM_OK;
}

thrum_status against_mesh_run(const simulate_request *request, const thrum_model *shape,
                              const thrum_model *stepped, const run_folder *folder,
                              against_mesh *against, thrum_error *error) {
  *against = (against_mesh){.displacement = NAN, .velocity = NAN};
  if (!(request->against_mesh > 0))
    return THRUM_OK;
  const double began = clock_seconds();
  side_by_side s = {.shape = shape};
  config_progress progress = config_progress_make(request->quiet);
  simulate_request alike = *request, of_mesh;
  against->asked = true;

  // what the mesh cannot be stepped by is left out for both, so that what differs is of the basis;
  // manifold is energy with the inertia of what follows, which the mesh has by itself
  if (alike.def.integrator != THRUM_INTEGRATOR_MANIFOLD)
    alike.def.integrator = integrator_of_mesh(request->def.integrator);
  alike.def.frequency_matched = 0;
  alike.def.damping_form = THRUM_DAMPING_REST;
  of_mesh = alike;
  of_mesh.def.integrator = integrator_of_mesh(request->def.integrator);
  of_mesh.full = true;
  against->stepped_by = thrum_integrator_name(of_mesh.def.integrator);

  // rows are whole at any time, and the mesh may take long to set up
  thrum_status status = THRUM_OK;
  errno = 0;
  s.rows = run_folder_create(folder, AGAINST_MESH_CSV);
  if (s.rows == NULL ||
      fputs("step,time_s,apart_m,moved_m,apart_m_s,moved_m_s,displacement_share,velocity_share\n",
            s.rows) < 0 ||
      fflush(s.rows) != 0)
    status = run_folder_write_failed(folder, AGAINST_MESH_CSV, error);
  THRUM_THEN(status, open_both(&alike, &of_mesh, stepped, &s, error));
  THRUM_THEN(status, step_both(request, &s, &progress, began, against, error));
  config_progress_end(&progress, status >= 0 && against->whole);
  if (s.rows != NULL && !run_folder_close_file(&s.rows) && status >= 0)
    status = run_folder_write_failed(folder, AGAINST_MESH_CSV, error);

  against->seconds = clock_seconds() - began;
  close_both(&s);
  return status;
}

/* --- the plot --------------------------------------------------------------------------------- */

void against_mesh_plot(const run_folder *folder, const char *title, against_mesh *against) {
  if (!against->asked || against->steps == 0)
    return;

  // the share so far tells the verdict, the two curves how it came about
  against->plot = run_plot_draw(
      folder->work,
      &(run_plot){.script = "against_mesh.gp",
                  .png = "against_mesh.png",
                  .svg = "against_mesh.svg",
                  .title = title,
                  .vertical = "error against the mesh so far [%]",
                  .settings = "set yrange [0:*]\n",
                  .curves = "'" AGAINST_MESH_CSV
                            "' using 2:(100*$7) every ::1 with lines lw 2 lc rgb '#08306b' "
                            "title 'displacement', \\\n"
                            "  '' using 2:(100*$8) every ::1 with lines dt (8,4) lc rgb '#d2600a' "
                            "title 'velocity'"});
}
