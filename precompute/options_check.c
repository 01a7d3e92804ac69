/* Judges what is asked of a precompute before it starts, see options_check.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include "precompute/options_check.h"

#include <math.h>

#include "precompute/basis/mode_check.h"
#include "precompute/basis/parameter_shapes.h"
#include "precompute/fem/constraints.h"
#include "precompute/fem/quadrature.h"
#include "precompute/fem/rigid_modes.h"
#include "thrum/model.h"

#define USUAL_DERIVATIVES                                                                          \
  30 /* directions of the derivatives at most in a usual rank, where modes are fewer */
#define FILE_MOST 4294967295.0 /* bytes of a model file */
#define COUNT_MAX 30000        /* free components up to which modes are counted unasked */

int64_t thrum_options_responses(const thrum_precompute_options *options) {
  return 3 * options->handle_count + options->actuator_count;
}

int64_t thrum_options_shapes(const thrum_precompute_options *options) {
  return options->modes + thrum_options_responses(options);
}

int64_t thrum_options_squared(const thrum_precompute_options *options) {
  const bool some = options->condensed && !options->imported && options->modes < options->rank;
  return some ? options->modes : options->rank;
}

double thrum_options_columns(const thrum_precompute_options *options) {
  const double squared = (double)thrum_options_squared(options);
  return (double)options->rank + squared * (squared + 1) / 2;
}

int64_t thrum_options_added(const thrum_precompute_options *options, const thrum_fem *fem) {
  if (!options->parameters)
    return 0;
  const int64_t rigid = fem->free_count == 3 * fem->vertex_count ? THRUM_RIGID_COUNT : 0;
  const int64_t most = thrum_parameter_shape_count(fem->region_count, options->modes);
  const int64_t room = fem->free_count - rigid - options->rank;
  const int64_t added = most < room ? most : room;
  return added > 0 ? added : 0;
}

double thrum_options_share_bytes(const thrum_precompute_options *options, const thrum_fem *fem,
                                 double rank) {
  if (!options->parameters)
    return 0;
  const double r = rank, cubics = r * (r + 1) * (r + 2) / 6, quartics = cubics * (r + 3) / 4;
  return 8 * (double)fem->region_count * (2 * (r * r + cubics + quartics) + r * (r + 3));
}

int64_t thrum_options_usual_rank(int64_t modes) {
  // two directions of the derivatives for each mode, as far as there are so many and they are worth
  // their cost; never fewer than one
  const int64_t half = modes * (modes + 1) / 4, two = 2 * modes;
  int64_t derivatives = two < USUAL_DERIVATIVES ? two : USUAL_DERIVATIVES;
  derivatives = derivatives < half ? derivatives : half;
  return modes + (derivatives > modes ? derivatives : modes);
}

static int64_t default_rank(const thrum_precompute_options *options) {
  return thrum_options_usual_rank(options->modes) + 2 * thrum_options_responses(options);
}

thrum_precompute_options thrum_options_complete(const thrum_precompute_options *options) {
  thrum_precompute_options complete = *options;
  if (options->imported) {
    complete.modes = complete.handle_count = 0;
    complete.rank = options->imported->rank;
  }
  // no rank given: the usual one, which k (k + 3) / 2 never falls short of, and two a response
  if (complete.rank == 0)
    complete.rank = default_rank(&complete);
  return complete;
}

static thrum_status check_counts(const thrum_precompute_options *options, thrum_error *error) {
  const int64_t k = options->modes, r = options->rank;
  if (k < 1 || k > 10000)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "modes is %lld; it must lie between 1 and 10000", (long long)k);

  // a rank that was not given is the usual one
  if (r > THRUM_RANK_MAX && r == default_rank(options))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld modes make a rank of %lld unless --rank says otherwise; it must "
                           "lie between 1 and %d: lower --modes or give --rank",
                           (long long)k, (long long)r, THRUM_RANK_MAX);
  if (r < 1 || r > THRUM_RANK_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank is %lld; it must lie between 1 and %d", (long long)r,
                           THRUM_RANK_MAX);

  // the candidates are k modes and k (k + 1) / 2 derivatives, beside responses and what is trained
  const int64_t beside = options->trained_count + 2 * thrum_options_responses(options);
  if (r - beside > k * (k + 3) / 2)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "rank %lld is more than %lld modes and their derivatives give (%lld); "
                           "lower --rank or raise --modes",
                           (long long)(r - 2 * thrum_options_responses(options)), (long long)k,
                           (long long)(k * (k + 3) / 2));

  return THRUM_OK;
}

// NaN is in no range
static bool has_cubature_bounds(const thrum_precompute_options *options) {
  return options->cubature_error > 0 && options->cubature_error <= THRUM_CUBATURE_ERROR_MOST &&
         options->cubature_range > 0 && options->cubature_range <= THRUM_CUBATURE_RANGE_MOST &&
         options->cubature_points >= 1 && options->cubature_points <= THRUM_CUBATURE_COUNT_MOST;
}

thrum_status thrum_options_check(const thrum_precompute_options *options, thrum_error *error) {
  THRUM_TRY(options->imported ? THRUM_OK : check_counts(options, error));

  // numbers that hold for models of all kinds
  if (options->threads < 1)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "threads is %d; it must be at least 1",
                           options->threads);
  if (options->quadrature_order != 0 && (options->quadrature_order < THRUM_QUADRATURE_ORDER_MIN ||
                                         options->quadrature_order > THRUM_QUADRATURE_ORDER_MAX))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the order of quadrature is %d; it must lie between %d and %d",
                           options->quadrature_order, THRUM_QUADRATURE_ORDER_MIN,
                           THRUM_QUADRATURE_ORDER_MAX);

  // actuators are those of a whole polynomial, on modes of the body
  if (options->actuator_count < 0 || options->actuator_count > THRUM_ACTUATORS_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "there are %lld actuators; 0 to %d may be",
                           (long long)options->actuator_count, THRUM_ACTUATORS_MAX);
  if (options->actuator_count > 0 &&
      (options->cubature || options->condensed || options->imported || options->parameters ||
       options->trained_count > 0 || options->shared))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "actuators go without cubature, condensing, an imported basis, "
                           "parameters, trained shapes and several processes");

  // points in place of the polynomial
  if (options->cubature && !has_cubature_bounds(options))
    return thrum_error_set(
        error, THRUM_INVALID_ARGUMENT,
        "cubature: an error of %g, %lld points and a range of %g; all must be > 0, and at most %g, "
        "%d and %g",
        options->cubature_error, (long long)options->cubature_points, options->cubature_range,
        THRUM_CUBATURE_ERROR_MOST, THRUM_CUBATURE_COUNT_MOST, THRUM_CUBATURE_RANGE_MOST);

  // a law other than Saint Venant-Kirchhoff's, and flow, need points
  if (options->law < THRUM_LAW_STVK || options->law > THRUM_LAW_BY_REGION)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "there is no law %d of a material",
                           (int)options->law);
  if (!(options->cubature_yield > 0) ||
      (options->cubature_yield < INFINITY && options->law == THRUM_LAW_STVK))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "a yield of %g is not that of points that flow: it is above 0, and the "
                           "law is corotational or neo-hookean",
                           options->cubature_yield);
  if (options->law != THRUM_LAW_STVK && !options->cubature)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the law %s needs cubature: a polynomial cannot hold it",
                           thrum_law_name(options->law));

  // points that flow cannot be learned, and points have no coefficients
  if (options->cubature_refine < 0 || options->cubature_refine > THRUM_CUBATURE_COUNT_MOST ||
      (options->cubature_refine > 0 && (!options->cubature || options->cubature_yield < INFINITY)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "cubature points are refined in %lld steps: that wants 0 to %d, "
                           "cubature, and no yield",
                           (long long)options->cubature_refine, THRUM_CUBATURE_COUNT_MOST);
  if (options->cubature && options->single)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "single precision is of the coefficients of a polynomial, which "
                           "cubature has none of");
  if (options->cubature && options->imported && options->imported->linear)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "cubature takes the place of a polynomial: import the basis alone");

  // shares are those of the polynomial that is made here, whole and in double precision
  if (options->parameters && (options->cubature || options->condensed || options->single ||
                              options->imported || options->trained_count > 0 || options->shared))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "parameters are those of a whole polynomial in double precision: they "
                           "go without cubature, condensing, single precision, an imported or "
                           "trained basis, and several processes");

  // a count that cannot be made says so itself
  if (options->check == THRUM_CHECK_INERTIA && !thrum_inertia_available() && !options->shared)
    return thrum_inertia_count(NULL, NULL, 0, NULL, error);

  if (options->mass != THRUM_MASS_CONSISTENT && options->mass != THRUM_MASS_LUMPED)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "the mass is neither consistent nor lumped");

  return THRUM_OK;
}

/* Lowers the counts to at most a quarter of the room for modes, and the usual rank of
 * these. */
static void lower_counts(thrum_precompute_options *options, int64_t room) {
  if (options->modes <= room / 4)
    return;
  options->modes = room / 4 > 1 ? room / 4 : 1;
  const int64_t most = default_rank(options);
  options->rank = options->rank < most ? options->rank : most;
}

/* What parameters add has a place in the model and in a file. */
static thrum_status check_parameters(const thrum_precompute_options *options, const thrum_fem *fem,
                                     thrum_error *error) {
  const int64_t rank = options->rank + thrum_options_added(options, fem);
  const double bytes = thrum_options_share_bytes(options, fem, (double)rank);
  if (!options->parameters || (rank <= THRUM_RANK_MAX && bytes < FILE_MOST))
    return THRUM_OK;
  return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                         "parameters of %lld regions make a rank of %lld and a file of %.1f GB, "
                         "where %d and %.1f are the most: lower --rank or --modes, or join regions",
                         (long long)fem->region_count, (long long)rank, 1e-9 * bytes,
                         THRUM_RANK_MAX, 1e-9 * FILE_MOST);
}

thrum_status thrum_options_check_body(thrum_precompute_options *options, const thrum_fem *fem,
                                      bool *free_body, thrum_error *error) {
  THRUM_TRY(thrum_constraints_check(fem, free_body, error));

  // the rigid modes of a free body are no room for elastic ones
  const int64_t n = fem->free_count - (*free_body ? THRUM_RIGID_COUNT : 0);
  if (options->fit)
    lower_counts(options, n);

  const int64_t k = options->modes, r = options->rank;
  if (k >= n || r > n)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%lld modes at rank %lld are too many for a mesh of %lld free "
                           "components: lower --modes and "
                           "--rank",
                           (long long)k, (long long)r, (long long)n);
  THRUM_TRY(check_parameters(options, fem, error));
  if (options->cubature_refine > 0 && thrum_fem_has_yield(fem))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "cubature points are not refined where a region has a yield: what flows "
                           "is the strain of a place, which learned points do not have");

  return THRUM_OK;
}

bool thrum_options_count_wanted(thrum_check check, int64_t free_count) {
  return check == THRUM_CHECK_INERTIA || (check == THRUM_CHECK_AUTO && free_count <= COUNT_MAX);
}

bool thrum_options_counted(const thrum_precompute_options *options, int64_t free_count) {
  return !options->imported && thrum_inertia_available() &&
         thrum_options_count_wanted(options->check, free_count);
}
