/* How the error that a basis makes is told. All that is found is a lower bound: what the mesh asks
 * for may lead to more. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/basis_estimate.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "config/message.h"
#include "io/json.h"
#include "io/percent.h"
#include "precompute/estimate.h"

basis_estimate basis_estimate_none(const char *why) {
  return (basis_estimate){.share = NAN, .velocity = NAN, .shape = NAN, .until = NAN, .why = why};
}

thrum_status basis_estimate_judge(const thrum_model *model, int64_t looks, const basis_asked *asked,
                                  thrum_basis_judge **judge, basis_estimate *estimate,
                                  thrum_error *error) {
  thrum_basis_judge *made = NULL;
  THRUM_TRY(thrum_basis_judge_create(model, looks, &made, error));
  const thrum_model_statics *statics = thrum_basis_judge_statics(made);
  const double seconds = thrum_estimate_solves(statics->factor, statics->body.fem.free_count,
                                               THRUM_BASIS_LOOK_SOLVES * looks);

  // a factor that nobody expects is not computed unasked
  if (asked->judging != BASIS_JUDGE_ON && seconds > BASIS_SECONDS_MOST) {
    *estimate = basis_estimate_none("the mesh is large");
    estimate->seconds = seconds;
    thrum_basis_judge_free(made);
    return THRUM_OK;
  }
  const thrum_status status = thrum_basis_judge_begin(made, error);
  if (status >= 0)
    *judge = made;
  else
    thrum_basis_judge_free(made);
  return status;
}

bool basis_estimate_is_large(const basis_estimate *estimate, const basis_asked *asked) {
  // an error may be larger than the motion, as where two swings are against each other
  return estimate->why == NULL && asked->accepted < 1 && estimate->share > asked->accepted;
}

const char *basis_estimate_size(const basis_estimate *estimate) {
  return estimate->about ? "about" : "at least";
}

void basis_estimate_json(const basis_estimate *estimate, cJSON *object) {
  cJSON *made = cJSON_AddObjectToObject(object, "error_estimate");
  const bool again = estimate->added > 0;
  json_number(made, "share", estimate->share);
  json_string(made, "kind", estimate->why != NULL ? "not judged" : basis_estimate_size(estimate));
  json_string(made, "by",
              estimate->why != NULL       ? NULL
              : again                     ? "richer run"
              : estimate->corrections > 0 ? "mesh"
                                          : "residual");
  json_number(made, "velocity_share", estimate->velocity);
  json_number(made, "shape_share", estimate->shape);
  json_number(made, "instants", (double)estimate->instants);
  json_number(made, "added", (double)estimate->added);
  json_number(made, "until_s", estimate->until);
  json_number(made, "seconds", estimate->seconds);
  json_string(made, "why", estimate->why);
}

/* It is not known, and how to ask for it where it would take long. */
static void print_why(const basis_estimate *estimate, bool scene) {
  printf("not judged: %s", estimate->why);
  if (estimate->seconds > BASIS_SECONDS_MOST)
    printf(", which would take about %.2g s: %s does it", estimate->seconds,
           scene ? "\"judge\": \"on\" in \"outputs\"" : "--judge on");
  puts("");
}

void basis_estimate_print(const basis_estimate *estimate, const char *who, const char *of) {
  char share[PERCENT_MAX];
  fputs("error        ", stdout);
  if (who != NULL)
    printf("%s: ", who);
  if (estimate->why != NULL) {
    print_why(estimate, who != NULL);
    return;
  }

  // of a free body the shape is said beside the motion, which is mostly that of the whole
  printf("%s %s %% of the %s", basis_estimate_size(estimate), percent_text(estimate->share, share),
         of);
  if (!isnan(estimate->shape))
    printf(" and %s %% of the shape", percent_text(estimate->shape, share));

  // what was done for it stands behind it
  if (estimate->added > 0)
    printf(" by the basis, by the %s again to %.3g s with %" PRId64 " coordinate%s more\n",
           who != NULL ? "scene" : "run", estimate->until, estimate->added,
           estimate->added == 1 ? "" : "s");
  else if (estimate->corrections > 0)
    printf(" by the basis, by the mesh that goes on from there in %" PRId64 " correction%s\n",
           estimate->corrections, estimate->corrections == 1 ? "" : "s");
  else
    printf(" by the basis, by the residual of the mesh at %" PRId64 " instant%s\n",
           estimate->instants, estimate->instants == 1 ? "" : "s");
}

void basis_estimate_warn(const basis_estimate *estimate, const basis_asked *asked, const char *who,
                         const char *of) {
  char share[PERCENT_MAX];
  if (!basis_estimate_is_large(estimate, asked))
    return;
  config_warn(
      "%sthe basis cannot show this %s: %s %s %% of it is wrong, beside the whole "
      "mesh; make it with thrum precompute --rank and --modes of more, with --handles where "
      "it is pulled, or with --train on its load; --accept-error takes it as it is",
      who, of, basis_estimate_size(estimate), percent_text(estimate->share, share));
}
