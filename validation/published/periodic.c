/* Periodic motions: the normal form of a clamped beam, and the folds and tori of a shallow panel
 * whose second mode has about twice the frequency of the first.
 *
 * Beam: 1000 x 10 x 24, E 160e3, nu 0.22, rho 2.32e-3, both ends held; d omega/c^2 and e
 * omega^2/c^3 of its first mode in z' = i (omega + c |z|^2 + ...) z (Vizzaccaro, Opreni, Salles,
 * Frangi and Touze 2022, doi:10.1007/s11071-022-07651-9). Panel: 1 x 2 m, 10 mm thick, rise 41 mm
 * over the 2 m, its curved direction's ends hinged, E 70e9, nu 0.33, rho 2700, 0.2 % of critical
 * damping in the first two modes by Rayleigh, 10 N at a quarter of the length (Li, Jain and Haller
 * 2023, Nonlinear analysis of forced mechanical systems with internal resonance using spectral
 * submanifolds, Part I, doi:10.1007/s11071-022-07714-x), from a mesh of 1,320 unknowns of flat
 * triangles. Arches: 640 x 6.4 x 32 of the beam's material, held at both ends, a cosine with a rise
 * of 3.84, and a sine of the rise at which its first mode neither hardens nor softens (the same
 * source as the beam; and by Ritz's method, validation/arch_ritz.py). Plate: clamped, 1 x 1 x 0.01,
 * nu 0.3, the frequency at which its middle swings by the thickness, over that at rest; beside a
 * Ritz solution of von Karman's plate (validation/plate_ritz.py).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "core/base/pi.h"
#include "platform/allocate.h"
#include "thrum/condensed_model.h"
#include "thrum/response.h"
#include "validation/published/published.h"

#define FORCE 10.0
#define RATIO 0.002

/* --- the beam --------------------------------------------------------------------------------- */

static thrum_status beam_rows(const published_sink *sink, int64_t modes, thrum_error *error) {
  const published_body body = {.mesh = "beam:40x1x2@1000x10x24",
                               .fix = {"x<1e-3", "x>999.999"},
                               .material = {160e3, 0.22, 2.32e-3},
                               .order = 2};
  thrum_precomputed made = {0};
  THRUM_TRY(
      published_precompute(&body, modes, modes + modes * (modes + 1) / 2, false, &made, error));
  size_t size = 0;
  void *memory = NULL;
  thrum_normal_form form = {0};
  thrum_status status = thrum_normal_form_size(&made.model, 0, &size, error);
  THRUM_THEN(status, thrum_reserve_aligned(&memory, size, "the normal form", error));
  THRUM_THEN(status, thrum_normal_form_find(&made.model, 0, 30, memory, size, &form, error));
  free(memory);
  thrum_precomputed_free(&made);
  if (status < 0)
    return status;

  // the basis is what is refined: the derivatives of so many modes, all of them
  char setting[40];
  snprintf(setting, sizeof setting, "%d modes, all derivatives", (int)modes);
  const double *c = form.coefficients;
  published_add(sink, "periodic", "beam: d omega/c^2", setting, (double)modes, -1.5886,
                c[1] * form.omega / (c[0] * c[0]));
  published_add(sink, "periodic", "beam: e omega^2/c^3", setting, (double)modes, 4.0504,
                c[2] * form.omega * form.omega / (c[0] * c[0] * c[0]));
  return THRUM_OK;
}

/* --- the panels ------------------------------------------------------------------------------- */

enum { PANEL_MODES = 8, PANEL_RANK = 44, PANEL_MOVE = 5 };

/* One panel: its rise over the length, whether Rayleigh damps it or a ratio of each mode, and where
 * the curve goes, over the first frequency. */
typedef struct panel {
  double rise;
  bool rayleigh;
  double from, to;
} panel;

static double panel_rise;

static void bend(double x[3]) {
  x[1] += panel_rise * x[0] * (2 - x[0]);
}

/* Special points in their order, as shares of the first frequency. */
typedef struct specials {
  double omega, share[8];
  thrum_response_kind kind[8];
  int count;
} specials;

static bool note(void *context, const thrum_response_point *point) {
  specials *s = context;
  if (point->kind != THRUM_RESPONSE_REGULAR && s->count < 8) {
    s->kind[s->count] = point->kind;
    s->share[s->count++] = 100 * (point->omega / s->omega - 1);
  }
  return true;
}

static int64_t vertex_near(const thrum_model *model, const double at[3]) {
  int64_t best = 0;
  double least = INFINITY;
  for (int64_t v = 0; v < model->vertex_count; v++) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++)
      square += pow(model->vertices[3 * v + axis] - at[axis], 2);
    if (square < least) {
      least = square;
      best = v;
    }
  }
  return best;
}

/* Rayleigh's by the first two modes; or twice the ratio times the frequency of each mode, and the
 * least of them for what follows the modes. */
static void damp(const panel *of, const thrum_model *whole, double *damping) {
  const double first = sqrt(whole->omega2[0]), second = sqrt(whole->omega2[1]);
  const double beta = 2 * RATIO / (first + second), alpha = beta * first * second;
  for (int64_t i = 0; i < whole->rank; i++)
    damping[i] = of->rayleigh ? alpha + beta * whole->omega2[i]
                              : 2 * RATIO * (i < PANEL_MODES ? sqrt(whole->omega2[i]) : first);
}

static thrum_status follow(const panel *of, const thrum_model *whole, const thrum_model *stepped,
                           specials *found, thrum_error *error) {
  double load[PANEL_RANK] = {0}, damping[PANEL_RANK];
  const double force[3] = {0, FORCE, 0}, at[3] = {0.5, of->rise * 0.75, 0};
  damp(of, whole, damping);
  THRUM_TRY(thrum_load_add_vertex(whole, vertex_near(whole, at), force, load, error));
  thrum_response_def def = thrum_default_response_def();
  found->omega = sqrt(whole->omega2[0]);
  def.harmonics = 7;
  def.from = of->from * found->omega;
  def.to = of->to * found->omega;
  def.damping = damping;
  def.slave_damping = damping + stepped->rank;
  def.load_sine = load;
  size_t size = 0;
  void *memory = NULL;
  thrum_response_report report;
  THRUM_TRY(thrum_response_size(stepped, &def, &size, error));
  THRUM_TRY(thrum_reserve_aligned(&memory, size, "the curve", error));
  const thrum_status status =
      thrum_response(stepped, &def, NULL, memory, size, note, found, &report, error);
  free(memory);
  return status;
}

/* The special points of a panel of 2 cells x cells hexahedra, two through its thickness. */
static thrum_status panel_specials(const panel *of, int cells, char mesh[64], specials *found,
                                   thrum_error *error) {
  published_body body = {.fix = {"x<1e-6&y>-1e-6&y<1e-6", "x>1.999999&y>-1e-6&y<1e-6"},
                         .material = {70e9, 0.33, 2700},
                         .map = bend,
                         .shell = true};
  panel_rise = of->rise;
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx2x%d@2x0.01x1,hex", 2 * cells, cells);
  snprintf(mesh, 64, "%s", body.mesh);
  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(&body, PANEL_MODES, PANEL_RANK, false, &made, error));
  const thrum_model *stepped = NULL;
  void *memory = NULL;
  size_t size = 0;
  thrum_status status = thrum_model_condense_size(&made.model, PANEL_MOVE, &size, error);
  THRUM_THEN(status, thrum_reserve_aligned(&memory, size, "the condensed model", error));
  THRUM_THEN(status, thrum_model_condense(memory, size, &made.model, PANEL_MOVE, &stepped, error));
  THRUM_THEN(status, follow(of, &made.model, stepped, found, error));
  free(memory);
  thrum_precomputed_free(&made);
  return status;
}

typedef struct panel_quantity {
  const char *name;
  double published;
} panel_quantity;

/* Rows of special points in the order of the curve. */
static void add_specials(const published_sink *sink, const panel_quantity *rows, int count,
                         const char *mesh, int cells, const specials *found) {
  for (int n = 0; n < count; n++)
    published_add(sink, "periodic", rows[n].name, mesh, cells, rows[n].published,
                  found->count == count ? found->share[n] : NAN);
}

static thrum_status panel_rows(const published_sink *sink, int cells, thrum_error *error) {
  // up, down, out of the pit, the two tori, and over the other peak
  static const panel_quantity low[] = {
      {"panel: fold 1, % of omega", -2.111},  {"panel: fold 2, % of omega", -5.388},
      {"panel: torus 1, % of omega", -0.476}, {"panel: torus 2, % of omega", 0.576},
      {"panel: fold 3, % of omega", 3.270},   {"panel: fold 4, % of omega", 2.037}};
  static const panel_quantity high[] = {{"panel of 100 mm: upper fold, % of omega", -0.60},
                                        {"panel of 100 mm: lower fold, % of omega", -0.85}};
  const panel shallow = {0.041, true, 0.925, 1.06}, deep = {0.1, false, 0.96, 1.01};
  specials found = {0};
  char mesh[64];
  THRUM_TRY(panel_specials(&shallow, cells, mesh, &found, error));
  published_add(sink, "periodic", "panel: first frequency, rad/s", mesh, cells, 149.22,
                found.omega);
  add_specials(sink, low, 6, mesh, cells, &found);
  found = (specials){0};
  THRUM_TRY(panel_specials(&deep, cells, mesh, &found, error));
  add_specials(sink, high, 2, mesh, cells, &found);
  return THRUM_OK;
}

/* --- arches ----------------------------------------------------------------------------------- */

#define ARCH_LENGTH 640.0
#define ARCH_THICKNESS 6.4

static double sine_rise; /* over the thickness */

static void bend_by_cosine(double x[3]) {
  x[1] += 1.92 * (1 - cos(THRUM_TWO_PI * x[0] / ARCH_LENGTH));
}
static void bend_by_sine(double x[3]) {
  x[1] += sine_rise * ARCH_THICKNESS * sin(THRUM_PI * x[0] / ARCH_LENGTH);
}

/* The normal form of the first mode of an arch that is held at both ends. */
static thrum_status arch_form(int cells, int64_t modes, void (*map)(double x[3]), char mesh[64],
                              thrum_normal_form *form, thrum_error *error) {
  published_body body = {.fix = {"x<1e-3", "x>639.999"},
                         .material = {160e3, 0.22, 2.32e-3},
                         .map = map,
                         .shell = true};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@640x6.4x32,hex", cells, cells / 16);
  snprintf(mesh, 64, "%s", body.mesh);
  thrum_precomputed made = {0};
  THRUM_TRY(
      published_precompute(&body, modes, modes + modes * (modes + 1) / 2, false, &made, error));
  size_t size = 0;
  void *memory = NULL;
  thrum_status status = thrum_normal_form_size(&made.model, 0, &size, error);
  THRUM_THEN(status, thrum_reserve_aligned(&memory, size, "the normal form", error));
  THRUM_THEN(status, thrum_normal_form_find(&made.model, 0, 30, memory, size, form, error));
  free(memory);
  thrum_precomputed_free(&made);
  return status;
}

static thrum_status arch_rows(const published_sink *sink, int cells, thrum_error *error) {
  thrum_normal_form form, low, high;
  char mesh[64];
  THRUM_TRY(arch_form(cells, 12, bend_by_cosine, mesh, &form, error));
  const double *c = form.coefficients;
  published_add(sink, "periodic", "cosine arch: first frequency, rad/s", mesh, cells, 1.032742,
                form.omega);
  published_add(sink, "periodic", "cosine arch: d omega/c^2", mesh, cells, 7.503,
                c[1] * form.omega / (c[0] * c[0]));

  // c is next to linear in the rise around its zero
  sine_rise = 0.46;
  THRUM_TRY(arch_form(cells, 6, bend_by_sine, mesh, &low, error));
  sine_rise = 0.48;
  THRUM_TRY(arch_form(cells, 6, bend_by_sine, mesh, &high, error));
  const double share = low.coefficients[0] / (low.coefficients[0] - high.coefficients[0]);
  published_add(sink, "periodic", "sine arch: rise/thickness where hardening ends", mesh, cells,
                0.476, 0.46 + 0.02 * share);
  published_add(sink, "periodic", "sine arch: the same, of a beam", mesh, cells, 0.463117,
                0.46 + 0.02 * share);
  return THRUM_OK;
}

/* --- a plate ---------------------------------------------------------------------------------- */

#define PLATE_THICKNESS 0.01
enum { PLATE_MODES = 6, PLATE_HARMONICS = 7 };

/* A backbone where the middle swings by the thickness. */
typedef struct middle {
  double by_coordinate[THRUM_RANK_MAX]; /* displacement of the middle across the plate */
  int64_t rank;
  double omega, width; /* of the point before */
  double at_thickness; /* the frequency asked for */
} middle;

static bool watch(void *context, const thrum_response_point *point) {
  middle *m = context;
  double width = 0;
  for (int64_t k = 0; k <= PLATE_HARMONICS; k++)
    for (int64_t i = 0; i < m->rank; i++)
      width += m->by_coordinate[i] * point->coefficients[k * m->rank + i];
  width = fabs(width) / PLATE_THICKNESS;
  if (width >= 1 && m->width < 1) {
    const double share = (1 - m->width * m->width) / (width * width - m->width * m->width);
    m->at_thickness = m->omega + share * (point->omega - m->omega);
  }
  m->omega = point->omega;
  m->width = width;
  return width < 1;
}

static thrum_status plate_backbone(const thrum_model *whole, middle *m, thrum_error *error) {
  const thrum_model *stepped = NULL;
  void *memory = NULL, *workspace = NULL;
  size_t size = 0;
  thrum_response_report report;
  thrum_status status = thrum_model_condense_size(whole, PLATE_MODES, &size, error);
  THRUM_THEN(status, thrum_reserve_aligned(&memory, size, "the condensed model", error));
  THRUM_THEN(status, thrum_model_condense(memory, size, whole, PLATE_MODES, &stepped, error));
  thrum_response_def def = thrum_default_response_def();
  def.harmonics = PLATE_HARMONICS;
  def.mode = 0;
  def.stability = 0;
  def.step = 0.02;
  def.from = 0.5 * sqrt(whole->omega2[0]);
  def.to = 2 * sqrt(whole->omega2[0]);
  THRUM_THEN(status, thrum_response_size(stepped, &def, &size, error));
  THRUM_THEN(status, thrum_reserve_aligned(&workspace, size, "the curve", error));
  THRUM_THEN(status,
             thrum_response(stepped, &def, NULL, workspace, size, watch, m, &report, error));
  free(workspace);
  free(memory);
  return status;
}

static thrum_status plate_row(const published_sink *sink, int cells, thrum_error *error) {
  published_body body = {.fix = {"x<1e-6", "x>0.999999", "z<-0.499999", "z>0.499999"},
                         .material = {70e9, 0.3, 2700},
                         .shell = true};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x0.01x1,hex", cells, cells);
  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(
      &body, PLATE_MODES, PLATE_MODES + PLATE_MODES * (PLATE_MODES + 1) / 2, false, &made, error));
  middle m = {.rank = PLATE_MODES, .at_thickness = NAN};
  const int64_t vertex = vertex_near(&made.model, (const double[3]){0.5, 0, 0});
  for (int64_t i = 0; i < PLATE_MODES; i++)
    m.by_coordinate[i] = made.model.basis[(3 * vertex + 1) * made.model.rank + i];
  const thrum_status status = plate_backbone(&made.model, &m, error);
  if (status >= 0)
    published_add(sink, "periodic", "clamped plate: omega/omega_1 at w = t", body.mesh, cells,
                  1.1743, m.at_thickness / sqrt(made.model.omega2[0]));
  thrum_precomputed_free(&made);
  return status;
}

thrum_status published_periodic(const published_sink *sink, thrum_error *error) {
  const int64_t modes[] = {5, 8, 12};
  for (int level = 0; level < 3 && level <= sink->level + 1; level++)
    THRUM_TRY(beam_rows(sink, modes[level], error));
  for (int level = 1; level <= sink->level && level <= 2; level++)
    THRUM_TRY(panel_rows(sink, 8 + 8 * level, error));
  for (int level = 1; level <= sink->level && level <= 2; level++)
    THRUM_TRY(arch_rows(sink, 64 << (level - 1), error));
  for (int level = 0; level <= sink->level && level <= 2; level++)
    THRUM_TRY(plate_row(sink, 12 + 8 * level, error));
  return THRUM_OK;
}
