/* The search beyond the recipes: trained bases of higher and higher rank, each also condensed, and
 * untrained ones while they come near, until one does what is wanted.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "precompute/estimate.h"
#include "precompute/polynomial/cubature.h"
#include "validation/tradeoff/tradeoff_private.h"

#define NEAR 3.0            /* times the error asked for: an untrained basis so near may reach it */
#define UNTRAINED_MOST 60   /* rank up to which those are tried */
#define TRAINED_TIMES 2.5   /* a trained basis over an untrained one: made twice, and its shapes */
#define ITERATIONS 3.0      /* of a step of the tight run over one of the fastest setting */
#define POLYNOMIAL_MOST 100 /* rank up to which polynomials are tried */
#define FAR_CHEAPER                                                                                \
  0.33 /* cost of points over the polynomial, which is then tried where they fail */

static const int64_t ranks[] = {20, 30, 45, 60, 80, 100, 140, 200};
#define RANK_COUNT ((int64_t)(sizeof ranks / sizeof ranks[0]))

/* The rank of this number can be tried: there is room beside the modes, and the limit allows it. */
static bool is_open(const tradeoff_problem *problem, int64_t number) {
  return ranks[number] > problem->modes && ranks[number] <= problem->rank_max;
}

/* The cost of a force by as many points as bodies usually take, over that by the polynomial. */
static double points_cost(const tradeoff_problem *problem, int64_t rank) {
  const int64_t usual =
      problem->cubature_refine > 0 ? THRUM_CUBATURE_POINTS_LEARNED : THRUM_CUBATURE_POINTS_USUAL;
  return thrum_cubature_cost(usual * rank, rank);
}

int64_t tradeoff_points(const tradeoff_problem *problem, const tradeoff_recipe *basis,
                        tradeoff_recipe *recipes) {
  if (!problem->points_alone && !(points_cost(problem, basis->rank) < 1))
    return 0;
  for (int64_t n = 0; n < problem->cubature_count; n++) {
    recipes[n] = *basis;
    recipes[n].cubature_error = problem->cubature_errors[n];
  }
  return problem->cubature_count;
}

/* A basis of the search with points, and with the polynomial; returns how many. Those that are not
 * trained have points where no polynomials are: their polynomials alone take long enough to miss.
 */
static int64_t forms_of(const tradeoff_problem *problem, const tradeoff_recipe *basis,
                        tradeoff_recipe *forms) {
  const bool points = basis->trained || problem->points_alone;
  int64_t count = points ? tradeoff_points(problem, basis, forms) : 0;
  if (!problem->points_alone && basis->rank <= POLYNOMIAL_MOST)
    forms[count++] = *basis;
  return count;
}
#define FORMS_MAX (TRADEOFF_POINTS_MAX + 1)

static tradeoff_recipe trained_recipe(const tradeoff_problem *problem, int64_t number) {
  return (tradeoff_recipe){.modes = problem->modes, .rank = ranks[number], .trained = true};
}

/* The untrained recipe of that rank, and whether there is one. */
static tradeoff_recipe higher_recipe(int64_t number) {
  return (tradeoff_recipe){.modes = ranks[number] / 2, .rank = ranks[number]};
}
static bool has_higher(int64_t number) {
  return ranks[number] > 30 && ranks[number] <= UNTRAINED_MOST;
}

int64_t tradeoff_search_recipes(const tradeoff_problem *problem, tradeoff_recipe *recipes) {
  int64_t count = 0;
  for (int64_t n = 0; n < RANK_COUNT && problem->rank_max > 0; n++) {
    if (!is_open(problem, n))
      continue;
    const tradeoff_recipe trained = trained_recipe(problem, n), higher = higher_recipe(n);
    count += forms_of(problem, &trained, recipes + count);
    if (has_higher(n) && !isnan(problem->error))
      count += forms_of(problem, &higher, recipes + count);
  }
  return count;
}

int64_t tradeoff_recipes(const tradeoff_problem *problem, tradeoff_recipe *recipes) {
  memcpy(recipes, problem->recipes, (size_t)problem->recipe_count * sizeof *recipes);
  return problem->recipe_count + tradeoff_search_recipes(problem, recipes + problem->recipe_count);
}

/* Processor time of a step by a polynomial, from the dearest run of the highest rank that is known;
 * from one by points where no other is. */
static double step_seconds(const tradeoff_solution *s, int64_t rank) {
  double known = 0, scale = 0;
  for (int64_t n = 0; n < s->result.run_count; n++) {
    const tradeoff_run *run = &s->result.runs[n];
    const tradeoff_basis *basis = &s->result.bases[run->basis];
    const double by = basis->points > 0 ? points_cost(s->problem, basis->rank) : 1;
    if (basis->recipe.masters == 0 && (double)basis->rank >= scale) {
      scale = (double)basis->rank;
      known = fmax(known, 1e-6 * run->us_per_step / by);
    }
  }

  // coefficients grow with the fourth power, and leave the caches
  return known * pow((double)rank / fmax(scale, 1), 4);
}

/* About how long a basis of the search takes to make and to run [s]. */
static double guess(const tradeoff_solution *s, const tradeoff_recipe *recipe) {
  const tradeoff_problem *problem = s->problem;
  thrum_precompute_options options = thrum_default_precompute_options();
  thrum_estimate estimate = {0};
  const bool points = recipe->cubature_error > 0;
  options.modes = recipe->modes;
  options.rank = recipe->rank;
  options.cubature = points;
  options.cubature_refine = points ? problem->cubature_refine : 0;

  // making it
  double seconds = 0, shortest = problem->full_dt, steps = 0;
  if (thrum_precompute_estimate(&s->reference.body.mesh, problem->model->fixed, &options, &estimate,
                                NULL) >= 0)
    for (int stage = 0; stage < THRUM_STAGE_COUNT; stage++)
      seconds += TRAINED_TIMES * estimate.seconds[stage];

  // its runs, and the finest one that they are judged by
  for (int64_t n = 0; n < problem->dt_count; n++) {
    shortest = fmin(shortest, problem->dts[n]);
    steps += 3 * (double)problem->tolerance_count * problem->script.time / problem->dts[n];
  }
  return seconds + step_seconds(s, recipe->rank) *
                       (points ? points_cost(problem, recipe->rank) : 1) *
                       (steps + ITERATIONS * 8 * problem->script.time / shortest);
}

static bool is_met(const tradeoff_solution *s) {
  const tradeoff_result *result = &s->result;
  if (result->chosen < 0)
    return false;

  // a budget alone asks for the most accurate, which a better basis may be
  const tradeoff_run *run = &result->runs[result->chosen];
  return !isnan(s->problem->error) &&
         !(run->cancels && tradeoff_judged(&result->bases[run->basis].error, s->problem->by_worse) >
                               s->problem->error);
}

thrum_status tradeoff_try_recipe(tradeoff_solution *s, const tradeoff_recipe *recipe,
                                 thrum_error *error) {
  const int64_t first = s->result.basis_count;
  thrum_error detail = {0};
  thrum_status status = tradeoff_space_make(s, recipe, &detail);
  if (status == THRUM_OUT_OF_MEMORY || status == THRUM_INTERRUPTED) {
    *error = detail;
    return status;
  }
  if (status < 0) {
    s->result.dropped++;
    s->result.dropped_reason = detail;
    return THRUM_OK;
  }

  // the linear modes alone, which costs next to nothing to look at
  int64_t masters[2];
  const int64_t found = s->problem->condense ? tradeoff_masters(s, first, masters) : 0;
  status = THRUM_OK;
  for (int64_t n = 0; n < found && status >= 0; n++) {
    tradeoff_recipe fewer = s->result.bases[first].recipe;
    fewer.masters = masters[n];
    status = tradeoff_space_make(s, &fewer, error);
  }
  THRUM_THEN(status, tradeoff_try(s, first, error));
  return status;
}

/* The same of the search, run here or taken from where it was. */
static thrum_status go_on(tradeoff_solution *s, const tradeoff_recipe *recipe, thrum_error *error) {
  const int64_t first = s->result.basis_count;
  const thrum_status status = s->problem->take != NULL ? tradeoff_take_recipe(s, recipe, error)
                                                       : tradeoff_try_recipe(s, recipe, error);
  s->result.searched += s->result.basis_count - first;
  s->result.chosen = tradeoff_choose(&s->result, s->problem->error, s->problem->cost);
  return status;
}

/* The least error of an untrained basis. */
static double untrained_error(const tradeoff_solution *s) {
  double least = INFINITY;
  for (int64_t b = 0; b < s->result.basis_count; b++)
    if (!s->result.bases[b].recipe.trained)
      least = fmin(least, tradeoff_judged(&s->result.bases[b].error, s->problem->by_worse));
  return least;
}

/* Whether the last basis had a run within the budget; one of a higher rank costs more. */
static bool within_budget(const tradeoff_solution *s) {
  if (isnan(s->problem->cost))
    return true;
  for (int64_t n = 0; n < s->result.run_count; n++) {
    const tradeoff_run *run = &s->result.runs[n];
    const tradeoff_basis *basis = &s->result.bases[run->basis],
                         *last = &s->result.bases[s->result.basis_count - 1];
    if (basis->recipe.masters == 0 && basis->rank == last->rank && run->cost <= s->problem->cost)
      return true;
  }
  return false;
}

/* Whether the last trained basis is no larger than one of a lower rank: neither the loads nor the
 * modes have more shapes. */
static bool is_exhausted(const tradeoff_solution *s) {
  const tradeoff_basis *last = &s->result.bases[s->result.basis_count - 1];
  if (!last->recipe.trained || last->rank == last->recipe.rank)
    return false;
  for (int64_t b = 0; b < s->result.basis_count; b++) {
    const tradeoff_basis *other = &s->result.bases[b];
    if (other->recipe.trained && other->recipe.rank < last->recipe.rank &&
        other->rank >= last->rank)
      return true;
  }
  return false;
}

/* About how long all trained bases of the search take [s]. */
static double guess_all(const tradeoff_solution *s) {
  double seconds = 0;
  for (int64_t n = 0; n < RANK_COUNT; n++) {
    tradeoff_recipe forms[FORMS_MAX];
    const tradeoff_recipe trained = trained_recipe(s->problem, n);
    const int64_t count = is_open(s->problem, n) ? forms_of(s->problem, &trained, forms) : 0;
    for (int64_t f = 0; f < count; f++)
      seconds += guess(s, &forms[f]);
  }
  return seconds;
}

/* Whether a run of the bases from `first` on does what is wanted, and not by a cancellation alone.
 * A budget alone asks for the most accurate, so that none does. */
static bool does_it(const tradeoff_solution *s, int64_t first) {
  const tradeoff_problem *problem = s->problem;
  for (int64_t n = 0; n < s->result.run_count && !isnan(problem->error); n++) {
    const tradeoff_run *run = &s->result.runs[n];
    const double basis = tradeoff_judged(&s->result.bases[run->basis].error, problem->by_worse);
    if (run->basis >= first && run->stable && !run->disproved &&
        tradeoff_judged(&run->error, problem->by_worse) <= problem->error &&
        !(run->cost > problem->cost) && !(run->cancels && basis > problem->error))
      return true;
  }
  return false;
}

/* A basis with points, of few to many, until one does it. */
static thrum_status try_points(tradeoff_solution *s, const tradeoff_recipe *forms, int64_t count,
                               thrum_error *error) {
  const int64_t first = s->result.basis_count;
  for (int64_t f = 0; f < count && !does_it(s, first); f++)
    THRUM_TRY(go_on(s, &forms[f], error));
  return THRUM_OK;
}

/* A basis of the search by its polynomial and by points. The polynomial comes first where points
 * are not far cheaper, and says whether they can do it, as they err by more. Else they come first,
 * and it is tried where they fail. */
static thrum_status try_forms(tradeoff_solution *s, const tradeoff_recipe *basis,
                              thrum_error *error) {
  tradeoff_recipe forms[FORMS_MAX];
  int64_t count = forms_of(s->problem, basis, forms);
  const bool polynomial = count > 0 && !(forms[count - 1].cubature_error > 0);
  const bool leads = polynomial && !(points_cost(s->problem, basis->rank) < FAR_CHEAPER);
  const int64_t first = s->result.basis_count;
  if (leads)
    THRUM_TRY(go_on(s, &forms[count - 1], error));
  if (polynomial)
    count--;

  // a budget alone has no error to be missed
  const bool misses =
      leads && s->result.basis_count > first &&
      tradeoff_judged(&s->result.bases[first].error, s->problem->by_worse) > s->problem->error;
  if (!misses)
    THRUM_TRY(try_points(s, forms, count, error));
  return polynomial && !leads && !is_met(s) ? go_on(s, &forms[count], error) : THRUM_OK;
}

/* Where a polynomial does it at a rank at which points are far cheaper, those of the next rank may
 * do it for less. */
static thrum_status try_beyond(tradeoff_solution *s, int64_t number, thrum_error *error) {
  tradeoff_recipe forms[FORMS_MAX];
  if (!is_met(s) || number >= RANK_COUNT || !is_open(s->problem, number))
    return THRUM_OK;
  const tradeoff_basis *chosen = &s->result.bases[s->result.runs[s->result.chosen].basis];
  if (chosen->points > 0 || chosen->recipe.masters > 0 ||
      !(points_cost(s->problem, chosen->rank) < FAR_CHEAPER))
    return THRUM_OK;
  const tradeoff_recipe trained = trained_recipe(s->problem, number);
  return try_points(s, forms, tradeoff_points(s->problem, &trained, forms), error);
}

thrum_status tradeoff_search(tradeoff_solution *s, thrum_error *error) {
  const tradeoff_problem *problem = s->problem;
  if (problem->rank_max == 0 || is_met(s))
    return THRUM_OK;

  // how long it may take is said before it begins
  if (problem->take == NULL && problem->search_begins != NULL)
    problem->search_begins(problem->progress_context, guess_all(s));

  const double untrained = untrained_error(s);
  int64_t n = 0;
  for (; n < RANK_COUNT && !is_met(s) && within_budget(s) && !is_exhausted(s); n++) {
    if (!is_open(problem, n))
      continue;
    const tradeoff_recipe trained = trained_recipe(problem, n);
    THRUM_TRY(try_forms(s, &trained, error));

    // more modes and derivatives alone, where those have come near already
    const tradeoff_recipe higher = higher_recipe(n);
    if (has_higher(n) && untrained <= NEAR * problem->error && !is_met(s))
      THRUM_TRY(try_forms(s, &higher, error));
  }
  return try_beyond(s, n, error);
}
