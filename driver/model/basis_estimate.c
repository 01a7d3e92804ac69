/* How the error that a basis makes is told. All that is found is a lower bound: what the mesh asks
 * for may lead to more. SPDX-License-Identifier: Apache-2.0 */
#include "driver/model/basis_estimate.h"

#include <math.h>

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

/* "about", or "at least". */
static const char *size_of(const basis_estimate *estimate) {
  return estimate->about ? "about" : "at least";
}

/* Why it is known to less than the end of the run; NULL: it is known to there. */
static const char *ended(const basis_estimate *estimate, double end) {
  if (!(estimate->until < BASIS_WHOLE * end))
    return NULL;
  return estimate->parted ? "the motion hangs on the last digits" : "it takes long";
}

void basis_estimate_json(const basis_estimate *estimate, double end, cJSON *object) {
  cJSON *made = cJSON_AddObjectToObject(object, "error_estimate");
  const bool again = estimate->added > 0;
  json_number(made, "share", estimate->share);
  json_string(made, "kind", estimate->why != NULL ? "not judged" : size_of(estimate));
  json_string(made, "by",
              estimate->why != NULL       ? NULL
              : again                     ? "richer run"
              : estimate->corrections > 0 ? "mesh"
                                          : "residual");
  json_number(made, "velocity_share", estimate->velocity);
  json_number(made, "shape_share", estimate->shape);
  json_number(made, "instants", (double)estimate->instants);
  json_number(made, "corrections", (double)estimate->corrections);
  json_number(made, "added", (double)estimate->added);
  json_number(made, "until_s", estimate->until);
  json_string(made, "ended", ended(estimate, end));
  json_number(made, "seconds", estimate->seconds);
  json_string(made, "why", estimate->why);
}

#define WHO "{name?{name}: }"
#define HOW_TO_JUDGE "{name?\"judge\": \"on\" in \"outputs\"|--judge on}"

const report_line basis_estimate_lines[] = {
    // it is not known, and how to ask for it where it would take long
    REPORT_LINE("error",
                WHO "not judged: {error_estimate.why}{error_estimate.seconds?, which would take "
                    "about {error_estimate.seconds:.2g} s: " HOW_TO_JUDGE " does it}"),

    // what was done for it stands behind it
    REPORT_LINE("error",
                WHO BASIS_ESTIMATE_WRONG
                " by the basis, by the {name?scene|run} again to {error_estimate.until_s:.3g} s "
                "with {error_estimate.added} coordinate{error_estimate.added#|s} more",
                .when = "error_estimate.by=richer run"),
    REPORT_LINE("error",
                WHO BASIS_ESTIMATE_WRONG " by the basis, by the mesh that goes on from there in "
                                         "{error_estimate.corrections} "
                                         "correction{error_estimate.corrections#|s}",
                .when = "error_estimate.by=mesh"),
    REPORT_LINE("error",
                WHO BASIS_ESTIMATE_WRONG " by the basis, by the residual of the mesh at "
                                         "{error_estimate.instants} "
                                         "instant{error_estimate.instants#|s}",
                .when = "error_estimate.by=residual"),
    REPORT_LINE("", "{error_estimate.kind} {error_estimate.velocity_share:%} of the velocity"),

    // a scene may be chaotic, and each run has its time
    REPORT_LINE("",
                "known up to {error_estimate.until_s:.3g} s of {simulated_s:.4g} s: "
                "{error_estimate.ended=it takes long?more takes long (" HOW_TO_JUDGE
                ")|beyond it {error_estimate.ended}}",
                .when = "error_estimate.ended"),
    {0}};

void basis_estimate_warn(const basis_estimate *estimate, const basis_asked *asked, const char *who,
                         const char *of) {
  char share[PERCENT_MAX];
  if (!basis_estimate_is_large(estimate, asked))
    return;
  config_warn(
      "%sthe basis cannot show this %s: %s %s %% of it is wrong, beside the whole "
      "mesh; make it with thrum precompute --rank and --modes of more, with --handles where "
      "it is pulled, or with --train on its load; --accept-error takes it as it is",
      who, of, size_of(estimate), percent_text(estimate->share, share));
}
