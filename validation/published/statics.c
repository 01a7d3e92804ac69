/* Large deflections at rest: the elastica, and the beam of Turek and Hron under gravity
 * (doi:10.1007/3-540-34596-5_15, CSM1 and CSM2), solved in the reduced coordinates; Euler's column.
 * A second row takes out what linear tets lock: the load is scaled so that the small deflection is
 * right.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/base/pi.h"
#include "platform/allocate.h"
#include "precompute/full/full.h"
#include "thrum/equilibrium.h"
#include "thrum/external_load.h"
#include "validation/published/published.h"

#define SLENDER 0.02 /* thickness over length of the elastica */

/* q at rest under `load`; critical (may be NULL): the factor at which stability was lost. */
static thrum_status rest(const thrum_model *model, const double *load, double *q, double *critical,
                         thrum_error *error) {
  size_t size = 0;
  const thrum_equilibrium_def def = thrum_default_equilibrium_def();
  thrum_equilibrium_report report;
  THRUM_TRY(thrum_equilibrium_size(model, &size, error));
  void *workspace = NULL;
  THRUM_TRY(thrum_reserve_aligned(&workspace, size, "an equilibrium", error));
  memset(q, 0, (size_t)model->rank * sizeof *q);
  const thrum_status status =
      thrum_equilibrium(model, &def, load, q, workspace, size, &report, error);
  free(workspace);
  if (status >= 0 && critical != NULL)
    *critical = report.critical;
  return status;
}

/* Mean displacement of the right face along an axis is the transpose of a force on it. */
static thrum_status face_force(const thrum_model *model, int axis, double *reduced,
                               thrum_error *error) {
  const int32_t *vertices;
  int64_t count;
  const double unit[3] = {axis == 0, axis == 1, axis == 2};
  memset(reduced, 0, (size_t)model->rank * sizeof *reduced);
  const thrum_status status = thrum_model_group(model, "right", &vertices, &count, error);
  return status < 0 ? status : thrum_load_add_shared(model, vertices, count, unit, reduced, error);
}

/* Mean displacement of the right face along z at rest under `forces` in the full order. */
static thrum_status full_tip(const thrum_model *model, bool gravity, double load, double *tip,
                             thrum_error *error) {
  const thrum_full_def def = thrum_default_full_def();
  const int64_t components = 3 * model->vertex_count;
  const int32_t *vertices;
  int64_t count;
  thrum_full *full = NULL;
  thrum_full_equilibrium found;
  double *forces = NULL;
  THRUM_TRY(thrum_reserve(&forces, 2 * components, sizeof *forces, "the full order", error));

  // the load is shared by the vertices of the face, or it is the weight
  thrum_status status = thrum_model_group(model, "right", &vertices, &count, error);
  THRUM_THEN(status, thrum_full_create(model, NULL, &def, &full, error));
  if (status >= 0 && gravity)
    thrum_full_add_gravity(full, (const double[3]){0, 0, load}, forces);
  for (int64_t n = 0; status >= 0 && !gravity && n < count; n++)
    forces[3 * vertices[n] + 2] = load / (double)count;
  THRUM_THEN(status, thrum_full_rest(full, forces, NULL, &found, error));

  // the mean over that face is what the beam theory speaks of
  if (status >= 0) {
    double *u = forces + components;
    thrum_full_get(full, u, NULL);
    *tip = 0;
    for (int64_t n = 0; n < count; n++)
      *tip += u[3 * vertices[n] + 2] / (double)count;
  }
  thrum_full_free(full);
  free(forces);
  return status < 0 ? status : THRUM_OK;
}

static double product(const thrum_model *model, const double *a, const double *b) {
  double sum = 0;
  for (int64_t i = 0; i < model->rank; i++)
    sum += a[i] * b[i];
  return sum;
}

/* Deflection and shortening of the tip under P L^2/(E I) = load; `scaled`: of what the mesh has for
 * E I. */
static thrum_status tip_of(const thrum_model *model, double load, double width, bool scaled,
                           double *deflection, double *shortening, thrum_error *error) {
  double up[THRUM_RANK_MAX], along[THRUM_RANK_MAX], force[THRUM_RANK_MAX], q[THRUM_RANK_MAX];
  double compliance = 0;
  THRUM_TRY(face_force(model, 2, up, error));
  THRUM_TRY(face_force(model, 0, along, error));
  for (int64_t i = 0; i < model->rank; i++)
    compliance += up[i] * up[i] / model->omega2[i];
  // w = P L^3 / (3 E I) at small loads
  const double stiffness = scaled ? 1 / (3 * compliance) : width * pow(SLENDER, 3) / 12;
  for (int64_t i = 0; i < model->rank; i++)
    force[i] = load * stiffness * up[i];

  thrum_status status = rest(model, force, q, NULL, error);
  *deflection = product(model, up, q);
  *shortening = -product(model, along, q);
  return status;
}

/* Ten nodes: the deflection at the largest load, reduced and in the full order. */
static thrum_status elastica_rows(const published_sink *sink, int cells, thrum_error *error) {
  const double load = 5;
  published_body body = {.fix = {"x<1e-9", "y>-1e9:y"}, .material = {1, 0, 1}, .order = 2};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x%.9gx%.9g", 50 * cells, cells,
           SLENDER / cells, SLENDER);

  // the theory has no locking, and neither have ten nodes
  double deflection, shortening, found[2], tip = 0;
  thrum_precomputed made = {0};
  published_elastica_tip(load, &deflection, &shortening);
  THRUM_TRY(published_precompute(&body, 6, 20, false, &made, error));
  thrum_status status =
      tip_of(&made.model, load, SLENDER / cells, false, &found[0], &found[1], error);
  if (status >= 0)
    published_add(sink, "elastica", "deflection at P = 5, ten nodes", body.mesh, cells, deflection,
                  found[0]);
  THRUM_THEN(status, full_tip(&made.model, false, load * SLENDER / cells * pow(SLENDER, 3) / 12,
                              &tip, error));
  if (status >= 0)
    published_add(sink, "elastica", "deflection at P = 5, ten nodes, full order", body.mesh, cells,
                  deflection, tip);
  thrum_precomputed_free(&made);
  return status < 0 ? status : THRUM_OK;
}

thrum_status published_elastica(const published_sink *sink, thrum_error *error) {
  static const double loads[] = {1, 2, 5};
  static const char *const names[2][2][3] = {
      {{"deflection at P = 1", "deflection at P = 2", "deflection at P = 5"},
       {"shortening at P = 1", "shortening at P = 2", "shortening at P = 5"}},
      {{"deflection at P = 1, mesh's own EI", "deflection at P = 2, mesh's own EI",
        "deflection at P = 5, mesh's own EI"},
       {"shortening at P = 1, mesh's own EI", "shortening at P = 2, mesh's own EI",
        "shortening at P = 5, mesh's own EI"}}};
  for (int level = 0; level <= sink->level + (sink->level > 0 ? 2 : 1); level++) {
    const int cells = 1 << level;
    published_body body = {.fix = {"x<1e-9", "y>-1e9:y"}, .material = {1, 0, 1}};
    snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x%.9gx%.9g", 50 * cells, cells,
             SLENDER / cells, SLENDER);

    thrum_precomputed made = {0};
    thrum_status status = THRUM_OK;
    THRUM_TRY(published_precompute(&body, 6, 20, false, &made, error));

    // once with the stiffness of the theory, and once with the bending stiffness of the mesh
    for (int scaled = 0; scaled < 2 && status >= 0; scaled++)
      for (int n = 0; n < 3 && status >= 0; n++) {
        double known[2], found[2];
        published_elastica_tip(loads[n], &known[0], &known[1]);
        status = tip_of(&made.model, loads[n], SLENDER / cells, scaled == 1, &found[0], &found[1],
                        error);
        for (int what = 0; what < 2; what++)
          published_add(sink, "elastica", names[scaled][what][n], body.mesh, cells, known[what],
                        found[what]);
      }

    // the same mesh unreduced, where that is soon done
    double deflection, shortening, tip;
    if (status >= 0 && cells <= 8) {
      published_elastica_tip(loads[2], &deflection, &shortening);
      status = full_tip(&made.model, false, loads[2] * SLENDER / cells * pow(SLENDER, 3) / 12, &tip,
                        error);
      if (status >= 0)
        published_add(sink, "elastica", "deflection at P = 5, full order", body.mesh, cells,
                      deflection, tip);
    }

    thrum_precomputed_free(&made);
    THRUM_TRY(status);
  }

  // ten nodes need fewer cells
  for (int level = 0; level <= sink->level; level++)
    THRUM_TRY(elastica_rows(sink, 1 << level, error));
  return THRUM_OK;
}

/* The critical load of a clamped and free column of length 1, over pi^2 E I/(4 L^2). */
static thrum_status column_row(const published_sink *sink, int cells, int order,
                               thrum_error *error) {
  const double thickness = 0.05, width = thickness / cells;
  const double euler = THRUM_PI * THRUM_PI / 4 * width * pow(thickness, 3) / 12;
  published_body body = {
      .fix = {"x<1e-9", "y>-1e9:y"}, .material = {1, 0, 1}, .order = order == 2 ? 2 : 0};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x%.9gx%.9g", 20 * cells, cells, width,
           thickness);
  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(&body, 6, 16, false, &made, error));

  // linear tets resist up to seven times the load of the theory
  double along[THRUM_RANK_MAX], q[THRUM_RANK_MAX], critical = NAN;
  thrum_status status = face_force(&made.model, 0, along, error);
  for (int64_t i = 0; i < made.model.rank; i++)
    along[i] *= -8 * euler;
  THRUM_THEN(status, rest(&made.model, along, q, &critical, error));
  if (status >= 0)
    published_add(sink, "column", order == 2 ? "critical load, ten nodes" : "critical load",
                  body.mesh, cells, 1, 8 * critical);
  thrum_precomputed_free(&made);
  return status < 0 ? status : THRUM_OK;
}

thrum_status published_column(const published_sink *sink, thrum_error *error) {
  for (int level = 0; level <= sink->level + 1; level++)
    THRUM_TRY(column_row(sink, 1 << level, 1, error));
  for (int level = 0; level <= sink->level; level++)
    THRUM_TRY(column_row(sink, 1 << level, 2, error));
  return THRUM_OK;
}

/* The clamped end of the beam of Turek and Hron lies on a cylinder of radius 0.05 m; the shift
 * fades out to the tip. */
static void clamp_on_cylinder(double p[3]) {
  const double radius = 0.05, length = 0.35;
  p[0] += (1 - p[0] / length) * (sqrt(radius * radius - p[2] * p[2]) - radius);
}

/* The rows of one case and one mesh, reduced and in the full order. */
static thrum_status gravity_rows(const published_sink *sink, int second, int cells, int order,
                                 thrum_error *error) {
  static const struct {
    double mu, tip;
    const char *reduced[2], *full[2];
  } cases[2] = {{0.5e6,
                 -66.10,
                 {"CSM1 tip, mm", "CSM1 tip, ten nodes, mm"},
                 {"CSM1 tip, full order, mm", "CSM1 tip, ten nodes, full order, mm"}},
                {2e6,
                 -16.97,
                 {"CSM2 tip, mm", "CSM2 tip, ten nodes, mm"},
                 {"CSM2 tip, full order, mm", "CSM2 tip, ten nodes, full order, mm"}}};
  const int ten = order == 2;
  const double known = cases[second].tip;
  published_body body = {.fix = {"x<1e-9", "y>-1e9:y"},
                         .material = {2.8 * cases[second].mu, 0.4, 1000},
                         .map = clamp_on_cylinder,
                         .order = order};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@0.35x%.9gx0.02", 35 * cells / 2, cells,
           0.02 / cells);

  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(&body, 6, 20, false, &made, error));

  // the reduced model at rest under its weight
  double load[THRUM_RANK_MAX] = {0}, up[THRUM_RANK_MAX], q[THRUM_RANK_MAX];
  thrum_status status =
      thrum_load_add_gravity(&made.model, (const double[3]){0, 0, -2}, load, error);
  THRUM_THEN(status, face_force(&made.model, 2, up, error));
  THRUM_THEN(status, rest(&made.model, load, q, NULL, error));
  if (status >= 0)
    published_add(sink, "gravity_beam", cases[second].reduced[ten], body.mesh, cells, known,
                  1e3 * product(&made.model, up, q));

  // the same mesh unreduced
  double tip = 0;
  THRUM_THEN(status, full_tip(&made.model, true, -2, &tip, error));
  if (status >= 0)
    published_add(sink, "gravity_beam", cases[second].full[ten], body.mesh, cells, known,
                  1e3 * tip);
  thrum_precomputed_free(&made);
  return status < 0 ? status : THRUM_OK;
}

thrum_status published_gravity_beam(const published_sink *sink, thrum_error *error) {
  // each level halves the cells; ten nodes end sooner
  for (int level = 0; level <= sink->level + 1; level++)
    for (int second = 0; second < 2; second++)
      THRUM_TRY(gravity_rows(sink, second, 2 << level, 0, error));
  for (int level = 0; level <= (sink->level > 0 ? 2 : 0); level++)
    for (int second = 0; second < 2; second++)
      THRUM_TRY(gravity_rows(sink, second, 2 << level, 2, error));
  return THRUM_OK;
}
