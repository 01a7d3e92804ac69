/* Estimates what a precompute will take, see estimate.h. Memory is counted array by array, stage by
 * stage; the numbers of the factor come from its symbolic analysis, so they are exact. Times are
 * work over speed: the speed of DGEMM and of reading memory are probed, the shares of them that the
 * stages reach were measured on one machine (docs/precompute.md).
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/estimate.h"

#include <cblas.h>
#include <math.h>
#include <stdlib.h>

#include "platform/clock.h"
#include "platform/memory_limit.h"
#include "platform/threads.h"
#include "precompute/basis/orthonormal.h"
#include "precompute/fem/fem_forces.h"
#include "precompute/options_check.h"
#include "precompute/polynomial/cubature.h"
#include "precompute/polynomial/cubature_refine.h"

#define MARGIN 1.05 /* heap and library buffers that are not counted one by one */
#define COUNT_SHARE                                                                                \
  0.5                   /* of the factor's memory that MUMPS takes: 0.2 (slender) to 0.65 (small)  \
                         */
#define GRID_WIDTH 0.75 /* treewidth of a grid over the vertices of its smallest section */
#define CG_ENTRY_BYTES 12.0  /* a number and its column */
#define CG_STEPS 40.0        /* of a solve: 30 to 70 (docs/scale.md) */
#define CG_PASSES 0.7        /* of a step over the matrix for one of the columns that share it */
#define CG_SETUP_PASSES 60.0 /* of the multigrid */
#define SOON_FLOPS 3e9       /* that take a second or so on any machine, */
#define SOON_BYTES 1e10      /* and that are read in a few */
#define PROBE_SIZE 384
#define PROBE_LENGTH (4 << 20)

/* States to learn on. */
static double refine_states(const thrum_precompute_options *options, double points) {
  return fmax(THRUM_REFINE_STATES * points, (double)options->cubature_refine);
}

/* The learning of gradients holds states with their forces and the coefficients by which they are
 * drawn, what it remembers of steps, and three scratches of a batch, of which one is in single
 * precision. There are as many points as may be. */
static double refine_bytes(const thrum_precompute_options *options, double points, double r) {
  const double n = fmin(points, (double)options->cubature_points), k = (double)options->modes;
  const double states = 2 * refine_states(options, n) * r + k * (k + 1) / 2 * r;
  const double steps = (9 + 5 * 4.5) * n * r + 2 * r * r;
  const double batch = 2.5 * THRUM_REFINE_BATCH * (27 * n + r);
  return options->cubature_refine > 0 ? 8 * (states + steps + batch) : 0;
}

// what the last stage holds: products of columns, or products of cubature points and their
// gradients
static double reduced_bytes(const thrum_fem *fem, const thrum_precompute_options *options,
                            double columns) {
  const double r = options->imported ? (double)options->imported->rank : (double)options->rank;
  if (!options->cubature)
    return 8 * columns * (columns + 800);
  const double points = fmin((double)thrum_fem_points(fem), THRUM_CUBATURE_CANDIDATES);
  return 8 * points * (2 * points + 18 * r) +
         (72 + 48 * THRUM_FEM_LANES) * (double)fem->vertex_count + refine_bytes(options, points, r);
}

// c3 and c4, or the gradients of points
static double coefficient_bytes(const thrum_precompute_options *options, double r) {
  return options->cubature ? 72 * (double)options->cubature_points * r : 8 * r * r * r * r / 24;
}

/* The options with the rank that the parameters make. */
static thrum_precompute_options with_parameters(const thrum_fem *fem,
                                                const thrum_precompute_options *options) {
  thrum_precompute_options made = *options;
  made.rank += thrum_options_added(options, fem);
  return made;
}

/* Changes of the body that the shapes of the parameters answer: solves, with what drives them. */
static double parameter_solves(const thrum_fem *fem, const thrum_precompute_options *options) {
  return options->parameters ? 9 * (double)fem->region_count : 0;
}

// the most of what the stages hold beyond the mesh, the fem, K and M
static double most_bytes(const thrum_fem *fem, double entries, const thrum_factor *factor,
                         const thrum_precompute_options *options) {
  // the sizes that everything below is counted in
  const double n = (double)fem->free_count, vertices = (double)fem->vertex_count;
  const double r = (double)options->rank;
  const double k = (double)thrum_options_shapes(options);
  const double candidates = k + k * (k + 1) / 2, columns = thrum_options_columns(options);
  const double block = THRUM_SOLVE_BLOCK;
  const double factored = thrum_factor_bytes(factor);

  // a copy of K is permuted before it is factorised
  const double factor_stage = factored + thrum_factor_work_bytes(factor) + 16 * entries;

  // the modes: the factor, the shapes, and the largest of what Lanczos, refinement and search add
  const double lanczos = 2 * k + 15, refining = k + 2 * block,
               searching = 3 * block + THRUM_GRAM_WORK;

  // modes are counted when the work arrays of the search are gone
  const double counting =
      thrum_options_counted(options, fem->free_count) ? COUNT_SHARE * factored + 16 * entries : 0;

  // in single precision two arrays of a space of four blocks, and a block more, take the place of
  // Lanczos vectors
  const bool single = thrum_factor_is_single(factor);
  const double davidson = 9 * (k + 4) + k + THRUM_PRODUCT_WORK;
  const double most = single ? fmax(davidson, searching) : fmax(fmax(lanczos, refining), searching);
  const double modes = factored + fmax(8 * n * (k + most), 8 * n * k + counting);

  // the derivatives stand beside the modes and the factor; refined solves have three blocks more
  const double derivatives =
      factored +
      8 * n * (candidates + (single ? 4.5 : 2) * block + 2 * parameter_solves(fem, options));

  // the factor and K are gone by then
  const double basis =
      8 * n * (candidates + THRUM_GRAM_WORK + r) + 24 * vertices * r - 16 * entries;

  // the polynomial needs the basis, its products of columns and its coefficients
  const double polynomial = 24 * vertices * r + reduced_bytes(fem, options, columns) - 16 * entries;
  const double model = coefficient_bytes(options, r) + thrum_options_share_bytes(options, fem, r) +
                       24 * vertices + 24 * (double)thrum_fem_elements(fem);
  const double kept = options->keep_modes ? 24 * vertices * (double)options->modes : 0;

  // stages follow each other, so the largest of them counts
  return fmax(fmax(fmax(factor_stage, modes), fmax(derivatives, basis)), polynomial) + model + kept;
}

// the same for an imported basis, which needs no factor: U, a copy and two of its free rows while
// it is turned, and what an imported polynomial is turned in
static double most_bytes_given(const thrum_fem *fem, double entries,
                               const thrum_precompute_options *options) {
  const double n = (double)fem->free_count, vertices = (double)fem->vertex_count;
  const double r = (double)options->imported->rank, columns = r + r * (r + 1) / 2;
  const double basis = 48 * vertices * r + 8 * n * (2 * r + THRUM_GRAM_WORK);
  const double polynomial = options->imported->linear
                                ? 24 * columns * columns
                                : reduced_bytes(fem, options, columns) - 16 * entries;
  const double model =
      coefficient_bytes(options, r) + 24 * vertices + 24 * (double)thrum_fem_elements(fem);
  return fmax(basis, 24 * vertices * r + polynomial) + model;
}

// compares the bytes that will be taken with those that are available
static void judge(const thrum_precompute_options *options, double more, thrum_estimate *estimate) {
  estimate->more = MARGIN * more;
  estimate->memory = thrum_memory_resident() + estimate->more;
  estimate->available = thrum_memory_available(&estimate->whose);
  if (options->memory_limit > 0) {
    // the limit is of the whole process
    estimate->available = fmax(0, options->memory_limit - thrum_memory_resident());
    estimate->whose = "of the limit given";
  }
  estimate->fits = estimate->more <= estimate->available;
}

// finds what else than a coarser mesh or fewer modes lowers the memory; half the rank counts where
// it saves at least a tenth
static void find_ways(const thrum_fem *fem, double entries, const thrum_factor *factor,
                      const thrum_precompute_options *options, thrum_estimate *estimate) {
  thrum_precompute_options lower = *options, plain = *options;
  if (estimate->fits)
    return;
  lower.rank = (options->rank + 1) / 2;
  plain.cubature_refine = 0;
  if (options->imported) {
    const double most = most_bytes_given(fem, entries, options);
    estimate->by_refine = most_bytes_given(fem, entries, &plain) < most;
    return;
  }
  const double most = most_bytes(fem, entries, factor, options);
  estimate->by_refine = most_bytes(fem, entries, factor, &plain) < most;
  estimate->by_rank = most_bytes(fem, entries, factor, &lower) < 0.9 * most;
}

void thrum_estimate_memory(const thrum_fem *fem, const thrum_sparse *stiffness,
                           const thrum_factor *factor, const thrum_precompute_options *asked,
                           thrum_estimate *estimate) {
  const thrum_precompute_options made = with_parameters(fem, asked), *options = &made;
  const double entries = (double)stiffness->begin[stiffness->size];
  const double r = (double)(options->imported ? options->imported->rank : options->rank);
  *estimate = (thrum_estimate){.free_dofs = fem->free_count, .rank = (int64_t)r};
  estimate->file = coefficient_bytes(options, r) / (options->single ? 2 : 1) +
                   thrum_options_share_bytes(options, fem, r) +
                   24 * (double)fem->vertex_count * (r + 1) + 20 * (double)fem->tet_count;
  if (options->imported) {
    judge(options, most_bytes_given(fem, entries, options), estimate);
    find_ways(fem, entries, NULL, options, estimate);
    return;
  }
  estimate->factor_nonzeros = thrum_factor_nonzeros(factor);
  estimate->factor_flops = thrum_factor_flops(factor);
  judge(options, most_bytes(fem, entries, factor, options), estimate);
  find_ways(fem, entries, factor, options, estimate);
}

thrum_status thrum_estimate_refuse(const thrum_estimate *estimate, thrum_error *error) {
  return thrum_error_set(
      error, THRUM_OUT_OF_MEMORY,
      "this takes about %.0f MB, %.0f MB more than now, and %.0f MB %s are left: "
      "use a coarser mesh or fewer modes%s%s",
      estimate->memory / 1048576, estimate->more / 1048576, estimate->available / 1048576,
      estimate->whose, estimate->by_rank ? ", or a lower --rank" : "",
      estimate->by_refine ? ", or lower --cubature-points or leave --cubature-refine out" : "");
}

thrum_status thrum_estimate_grid(const int64_t cells[3], const thrum_precompute_options *options,
                                 thrum_error *error) {
  // the largest dense block has at least three quarters of the vertices of the smallest section,
  // about the treewidth of a grid
  double vertices = 1, tets = 6, longest = 1;
  for (int axis = 0; axis < 3; axis++) {
    vertices *= (double)cells[axis] + 1;
    tets *= (double)cells[axis];
    longest = fmax(longest, (double)cells[axis] + 1);
  }
  const double front = GRID_WIDTH * 3 * vertices / longest;

  // the mesh, the shapes with what Lanczos adds, and that block; several processes spread all but
  // the mesh, and what a part of it takes they judge themselves
  const double shapes = (double)thrum_options_shapes(options);
  const double modes = 8 * 3 * vertices * (3 * shapes + 15) + 4 * front * front;
  thrum_estimate estimate = {0};
  const bool meshed = options->imported != NULL || options->shared != NULL;
  judge(options, 24 * vertices + 20 * tets + (meshed ? 0 : modes), &estimate);
  return estimate.fits ? THRUM_OK : thrum_estimate_refuse(&estimate, error);
}

// the best of three: flops a second of DGEMM, and bytes a second of reading; 0 without memory
static void probe(int threads, double *flops, double *bytes) {
  double *data = malloc(sizeof *data * PROBE_LENGTH);
  *flops = *bytes = 0;
  if (!data)
    return;

  // numbers that are touched once, so that every page is there
  for (int64_t i = 0; i < PROBE_LENGTH; i++)
    data[i] = 1e-3 * (double)(i % 7);

  // the best of three passes counts: a sum for the memory, a product for the processor
  const int n = PROBE_SIZE;
  double *a = data, *b = data + n * n, *c = data + 2 * n * n;
  for (int pass = 0; pass < 3; pass++) {
    const double began = clock_process_seconds();
    const volatile double sum = cblas_dasum(PROBE_LENGTH, data, 1);
    const double read = clock_process_seconds();
    (void)sum;
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, n, n, n, 1, a, n, b, n, 0, c, n);
    const double done = clock_process_seconds();
    *bytes = fmax(*bytes, 8.0 * PROBE_LENGTH / (read - began));
    *flops = fmax(*flops, 2.0 * n * n * n * threads / (done - read));
  }

  free(data);
}

/* As of the factor and of a column alone in the times of the stages. */
double thrum_estimate_solves(const thrum_factor *factor, int64_t size, int64_t solves) {
  const double flops = thrum_factor_flops(factor);
  const double bytes = 16 * (double)thrum_factor_nonzeros(factor) * (double)solves;
  double gemm, read;
  if (flops < SOON_FLOPS && bytes < SOON_BYTES)
    return 0;
  probe(1, &gemm, &read);
  if (!(gemm > 0 && read > 0))
    return 0;
  return flops / gemm * (1 + cbrt(1e11 / flops)) + 1.5e-5 * (double)size + bytes / read;
}

/* The stress at a point by a law, beyond that of Saint Venant-Kirchhoff's [s]. Of several laws it
 * is that of the dearest. */
static double law_seconds(thrum_law law) {
  return law == THRUM_LAW_STVK ? 0 : law == THRUM_LAW_NEO_HOOKEAN ? 4e-8 : 1e-7;
}

/* Gradients that are learned, of as many points as are usual: one of the three forces of each
 * state, or all of another law, and in each step, in single precision, a stress, a tangent and five
 * products for each of its states, and three products of the gradients and a square matrix. */
static double refine_seconds(const thrum_precompute_options *options, thrum_law law, double state,
                             double gemm) {
  const double r = (double)options->rank, steps = (double)options->cubature_refine;
  const double count = fmin((double)options->cubature_points, THRUM_CUBATURE_POINTS_LEARNED * r);
  if (!(steps > 0))
    return 0;
  const double one = 4e-8 + 2.4 * law_seconds(law) + 90 * r / (1.2 * gemm);
  return refine_states(options, count) * state / (law == THRUM_LAW_STVK ? 3 : 1) +
         steps * count * (THRUM_REFINE_BATCH * one + 54 * r * r / (1.2 * gemm));
}

/* The last stage: one DSYRK of products of columns; or, for cubature, the forces of states, each in
 * three passes over the points and six over the basis, and one DSYRK of candidates. */
static double reduced_seconds(const thrum_precompute_options *options, thrum_law law, double points,
                              double n, double columns, double gemm) {
  if (!options->cubature)
    return 6 * points * columns * columns / (0.9 * gemm);
  const double r = (double)options->rank, states = THRUM_CUBATURE_STATES;
  const double candidates = fmin(points, THRUM_CUBATURE_CANDIDATES);
  const bool flows = options->cubature_yield < INFINITY;
  const double state = flows ? 3e-7 * points + 6e-10 * 6 * n * r
                             : (9e-8 + 3 * law_seconds(law)) * points + 6e-10 * n * r;
  return states * state + states * r * candidates * candidates / (0.8 * gemm) +
         refine_seconds(options, law, state, gemm);
}

void thrum_estimate_times(const thrum_fem *fem, const thrum_precompute_options *asked,
                          thrum_estimate *estimate) {
  const thrum_precompute_options made = with_parameters(fem, asked), *options = &made;
  // two short measurements of this machine: arithmetic, and reading memory
  double gemm, read;
  probe(options->threads, &gemm, &read);
  if (!(gemm > 0 && read > 0))
    return;

  // the sizes of the body and of the basis
  const double n = (double)fem->free_count;
  const double points = (double)thrum_fem_points(fem);
  const thrum_law law = options->law == THRUM_LAW_STVK ? fem->law : options->law;
  const double r = (double)options->rank, columns = thrum_options_columns(options);
  const double k = (double)thrum_options_shapes(options);
  const double pairs = k * (k + 1) / 2;
  const double nonzeros = (double)estimate->factor_nonzeros;

  // a column alone reads the factor twice; in blocks it is arithmetic
  const double alone = 16 * nonzeros / read, blocked = 4 * nonzeros / (0.33 * gemm);
  double *seconds = estimate->seconds;

  // an imported basis replaces every stage between assembly and polynomial
  seconds[THRUM_STAGE_assemble] = 1e-6 * points;
  if (options->imported) {
    // Gram products and rotations of U; then the polynomial, or its change of basis
    seconds[THRUM_STAGE_basis] = 8 * 4 * n * r * r / (0.12 * gemm);
    seconds[THRUM_STAGE_polynomial] = options->imported->linear
                                          ? 4 * columns * columns * columns / (0.33 * gemm)
                                          : reduced_seconds(options, law, points, n, columns, gemm);
    return;
  }

  // the numbers are fits to measured stages, as shares of what the machine reached above
  seconds[THRUM_STAGE_factor] =
      estimate->factor_flops / gemm * (1 + cbrt(1e11 / estimate->factor_flops)) + 1.5e-5 * n;
  seconds[THRUM_STAGE_modes] = (2.5 * k + 12) * alone + (2 * k + 32) * blocked;

  // the inertia count is a factor of its own, on one thread
  if (thrum_options_counted(options, fem->free_count))
    seconds[THRUM_STAGE_modes] += 1.3 * seconds[THRUM_STAGE_factor];

  seconds[THRUM_STAGE_derivatives] =
      pairs * (blocked + 2.5e-8 * points) + parameter_solves(fem, options) * blocked;
  seconds[THRUM_STAGE_basis] = 8 * n * (k + pairs) * (k + pairs) / (0.12 * gemm);

  // one more reduction for each modulus of a region
  const double reductions = 1 + (options->parameters ? 2 * (double)fem->region_count : 0);
  seconds[THRUM_STAGE_polynomial] =
      reductions * reduced_seconds(options, law, points, n, columns, gemm);
}

void thrum_estimate_times_cg(const thrum_fem *fem, const thrum_precompute_options *options,
                             double entries, thrum_estimate *estimate) {
  double gemm, read;
  probe(options->threads, &gemm, &read);
  if (!(gemm > 0 && read > 0))
    return;

  // every step reads the matrix some times, as the multigrid smooths before and after a coarser
  // grid, for many columns at once
  const double k = (double)thrum_options_shapes(options), pairs = k * (k + 1) / 2;
  const double pass = CG_ENTRY_BYTES * entries / read;
  const double solve = CG_STEPS * CG_PASSES * pass;

  // modes take many rough solves of few steps; the other stages are the same
  double *seconds = estimate->seconds;
  thrum_estimate_times(fem, options, estimate);
  seconds[THRUM_STAGE_factor] = CG_SETUP_PASSES * pass;
  seconds[THRUM_STAGE_modes] = (7 * k + 55) * solve;
  seconds[THRUM_STAGE_derivatives] = pairs * (solve + 2.5e-8 * (double)thrum_fem_points(fem));
}

thrum_status thrum_precompute_estimate(const thrum_mesh *mesh, const uint8_t *fixed,
                                       const thrum_precompute_options *options,
                                       thrum_estimate *estimate, thrum_error *error) {
  thrum_precompute_options asked = thrum_options_complete(options);
  thrum_fem fem = {0};
  thrum_sparse stiffness = {0}, mass = {0};
  thrum_factor *factor = NULL;
  thrum_estimate made = {0};
  bool free_body;

  // what the run itself would refuse is refused here
  THRUM_TRY(thrum_options_check(&asked, error));
  THRUM_TRY(thrum_threads_ready(asked.threads, error));
  const thrum_threads before = thrum_threads_set(asked.threads);

  // the matrices' patterns and the plan of the factor, without a number of either
  thrum_status status = thrum_fem_create(mesh, fixed, &fem, error);
  THRUM_THEN(status, thrum_options_check_body(&asked, &fem, &free_body, error));
  THRUM_THEN(status, thrum_fem_pattern(&fem, &stiffness, error));
  THRUM_THEN(status, thrum_fem_mass(&fem, asked.mass, &stiffness, &mass, error));
  if (status >= 0 && !asked.imported)
    status = thrum_factor_plan(&stiffness, &factor, error);
  if (status >= 0 && factor && thrum_factor_nonzeros(factor) >= THRUM_SINGLE_NONZEROS)
    thrum_factor_set_single(factor, &stiffness);

  if (status >= 0) {
    thrum_estimate_memory(&fem, &stiffness, factor, &asked, &made);
    thrum_estimate_times(&fem, &asked, &made);
    *estimate = made;
  }

  thrum_factor_free(factor);
  thrum_sparse_free(&stiffness);
  thrum_sparse_free(&mass);
  thrum_fem_free(&fem);
  thrum_threads_restore(before);
  return status;
}
