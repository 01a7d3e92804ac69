/* Natural frequencies: closed forms of bars, beams and the cube, published ones of the sphere
 * (Code_Aster SDLV401, after Lamb 1882, On the vibrations of an elastic sphere,
 * doi:10.1112/plms/s1-13.1.189) and of the tapered membrane (NAFEMS FV32).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>

#include "core/base/pi.h"
#include "validation/published/published.h"

/* A bar of unit length in the plane y = 0 with E = rho = 1, nu = 0: beam theory without Poisson's
 * effect. One cell wide, everything held in y. */
static published_body planar_beam(int cells, double thickness) {
  published_body body = {.fix = {"x<1e-9", "y>-1e9:y"}, .material = {1, 0, 1}};
  const int along = (int)lround(cells / thickness);
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx1x%d@1x%.9gx%.9g", along, cells, thickness / cells,
           thickness);
  return body;
}

static void axial_field(const double x[3], double u[3]) {
  u[0] = sin(0.5 * THRUM_PI * x[0]);
  u[1] = u[2] = 0;
}

/* The rows of one mesh of the beam. */
static thrum_status beam_rows(const published_sink *sink, int cells, int order,
                              thrum_error *error) {
  static const double thickness = 0.1;
  static const char *const names[2][3] = {
      {"bending 1, Hz", "bending 2, Hz", "axial 1, Hz"},
      {"bending 1, ten nodes, Hz", "bending 2, ten nodes, Hz", "axial 1, ten nodes, Hz"}};
  published_body body = planar_beam(cells, thickness);
  body.order = order;
  thrum_precomputed made = {0};
  THRUM_TRY(published_precompute(&body, 4, 4, true, &made, error));

  // the lowest modes bend; the axial one lies among them and is found by its shape
  const char *const *name = names[order == 2];
  for (int n = 0; n < 2; n++)
    published_add(sink, "beam", name[n], body.mesh, cells,
                  published_timoshenko(thickness, n + 1) / (2 * THRUM_PI),
                  sqrt(made.mode_omega2[n]) / (2 * THRUM_PI));
  published_add(sink, "beam", name[2], body.mesh, cells, 0.25,
                published_frequency_of(&made, axial_field));
  thrum_precomputed_free(&made);
  return THRUM_OK;
}

thrum_status published_beam(const published_sink *sink, thrum_error *error) {
  // each level halves the cells; ten nodes begin with one and end sooner
  for (int level = 0; level <= sink->level + 1; level++)
    THRUM_TRY(beam_rows(sink, 2 << level, 0, error));
  for (int level = 0; level <= sink->level + 1; level++)
    THRUM_TRY(beam_rows(sink, 1 << level, 2, error));
  return THRUM_OK;
}

static void torsion_field(const double x[3], double u[3]) {
  const double angle = sin(0.5 * THRUM_PI * x[0]);
  u[0] = 0;
  u[1] = -angle * x[2];
  u[2] = angle * x[1];
}

thrum_status published_torsion(const published_sink *sink, thrum_error *error) {
  // Saint-Venant: G J / (rho I_p) with J = 0.140577 a^4 and I_p = a^4 / 6; G = 1/2
  const double exact = 0.25 * sqrt(0.5 * 0.140577 * 6);

  for (int level = 0; level <= sink->level; level++) {
    const int cells = 2 << level;
    published_body body = {.fix = {"x<1e-9"}, .material = {1, 0, 1}};
    thrum_precomputed made = {0};
    snprintf(body.mesh, sizeof body.mesh, "beam:%dx%dx%d@1x0.1x0.1", 10 * cells, cells, cells);
    THRUM_TRY(published_precompute(&body, 8, 8, true, &made, error));

    // the mode is found by its shape: others lie close
    published_add(sink, "torsion", "torsion 1, Hz", body.mesh, cells, exact,
                  published_frequency_of(&made, torsion_field));
    thrum_precomputed_free(&made);
  }
  return THRUM_OK;
}

/* Lame's mode of a cube of unit side, x from 0, y and z about 0. */
static void lame_field(const double x[3], double u[3]) {
  const double a = THRUM_PI * x[0], b = THRUM_PI * (x[1] + 0.5);
  u[0] = cos(a) * sin(b);
  u[1] = -sin(a) * cos(b);
  u[2] = 0;
}

thrum_status published_cube(const published_sink *sink, thrum_error *error) {
  // omega = sqrt(2) pi c_T / a whatever nu is; c_T^2 = mu / rho
  const double exact = sqrt(1 / (2 * 1.3)) / sqrt(2);

  for (int level = 0; level <= sink->level + 1; level++) {
    const int cells = 3 << level;
    published_body body = {.material = {1, 0.3, 1}};
    thrum_precomputed made = {0};
    snprintf(body.mesh, sizeof body.mesh, "beam:%dx%dx%d@1x1x1", cells, cells, cells);
    THRUM_TRY(published_precompute(&body, 18, 18, true, &made, error));

    // among equal frequencies the mode is found by its shape
    published_add(sink, "cube", "Lame's mode, Hz", body.mesh, cells, exact,
                  published_frequency_of(&made, lame_field));
    thrum_precomputed_free(&made);
  }
  return THRUM_OK;
}

/* A cube [0,2] x [-1,1]^2 whose shells are blown up to spheres of radius 0.01 m. */
static void to_ball(double p[3]) {
  const double x = p[0] - 1, y = p[1], z = p[2];
  p[0] = 0.01 * x * sqrt(1 - y * y / 2 - z * z / 2 + y * y * z * z / 3);
  p[1] = 0.01 * y * sqrt(1 - z * z / 2 - x * x / 2 + z * z * x * x / 3);
  p[2] = 0.01 * z * sqrt(1 - x * x / 2 - y * y / 2 + x * x * y * y / 3);
}

thrum_status published_sphere(const published_sink *sink, thrum_error *error) {
  static const struct {
    const char *name;
    int times;
    double hertz;
  } clusters[] = {{"5 modes, Hz", 5, 2468.71},
                  {"next 5, Hz", 5, 2611.91},
                  {"next 3, Hz", 3, 3484.23},
                  {"next 7, Hz", 7, 3814.60}};

  // each level halves the cells
  for (int level = 0; level <= sink->level; level++) {
    const int cells = 6 << level;
    published_body body = {.material = {1e8, 0.3, 1e4}, .map = to_ball};
    thrum_precomputed made = {0};
    snprintf(body.mesh, sizeof body.mesh, "beam:%dx%dx%d@2x2x2", cells, cells, cells);
    THRUM_TRY(published_precompute(&body, 20, 20, false, &made, error));
    snprintf(body.mesh, sizeof body.mesh, "ball of %d cells across", cells);

    // a mesh without the symmetry of the sphere splits equal frequencies: compare the means
    for (int c = 0, mode = 0; c < 4; c++) {
      double mean = 0;
      for (int i = 0; i < clusters[c].times; i++, mode++)
        mean += sqrt(made.mode_omega2[mode]) / (2 * THRUM_PI) / clusters[c].times;
      published_add(sink, "sphere", clusters[c].name, body.mesh, cells, clusters[c].hertz, mean);
    }
    thrum_precomputed_free(&made);
  }
  return THRUM_OK;
}

/* 5 m wide at x = 0, 1 m at x = 10 m. */
static void taper(double p[3]) {
  p[1] *= 5 - 0.4 * p[0];
}

/* The rows of one mesh of the membrane. */
static thrum_status membrane_rows(const published_sink *sink, int cells, int order,
                                  thrum_error *error) {
  static const double hertz[] = {44.623, 130.03, 162.70, 246.05, 379.90, 391.44};
  static const char *const names[2][6] = {{"1, Hz", "2, Hz", "3, Hz", "4, Hz", "5, Hz", "6, Hz"},
                                          {"1, ten nodes, Hz", "2, ten nodes, Hz",
                                           "3, ten nodes, Hz", "4, ten nodes, Hz",
                                           "5, ten nodes, Hz", "6, ten nodes, Hz"}};
  published_body body = {.fix = {"x<1e-9", "z<-0.0249:z"},
                         .material = {200e9, 0.3, 8000},
                         .map = taper,
                         .order = order};
  thrum_precomputed made = {0};
  snprintf(body.mesh, sizeof body.mesh, "beam:%dx%dx1@10x1x0.05", 2 * cells, cells);
  THRUM_TRY(published_precompute(&body, 6, 6, false, &made, error));

  // all six in their order
  for (int i = 0; i < 6; i++)
    published_add(sink, "membrane", names[order == 2][i], body.mesh, cells, hertz[i],
                  sqrt(made.mode_omega2[i]) / (2 * THRUM_PI));
  thrum_precomputed_free(&made);
  return THRUM_OK;
}

thrum_status published_membrane(const published_sink *sink, thrum_error *error) {
  // each level halves the cells; ten nodes begin with coarser ones
  for (int level = 0; level <= sink->level + 1; level++)
    THRUM_TRY(membrane_rows(sink, 8 << level, 0, error));
  for (int level = 0; level <= sink->level + 1; level++)
    THRUM_TRY(membrane_rows(sink, 2 << level, 2, error));
  return THRUM_OK;
}
