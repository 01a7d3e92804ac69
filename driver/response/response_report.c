/* What `thrum response` says of a curve; see response_report.h. SPDX-License-Identifier: Apache-2.0
 */
#include "driver/response/response_report.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "config/message.h"
#include "core/base/pi.h"
#include "io/json.h"

#define TWIN 1e-3         /* of a frequency: modes that near are one pair */
#define RESONANCES_MOST 3 /* that the table names */
#define ORDER_PRINTED 3   /* of the normal form of two modes */
#define TAIL_WARNED 1e-3  /* of the kinetic energy in the last two harmonics */

/* How many there are on the curve. */
static int64_t branch_points(const response_curve *c) {
  int64_t count = 0;
  for (int64_t n = 0; n < c->count; n++)
    count += c->rows[n].point.kind == THRUM_RESPONSE_BRANCH;
  return count;
}

/* The last two harmonics tell whether these are enough, where a multiple of the load's own is among
 * them and the first two are before them. */
static bool tail_tells(const response_curve *c) {
  const int64_t periods = c->request->periods;
  return c->harmonics >= 3 * periods && c->harmonics % periods < 2;
}

const char *response_flag(const response_curve *curve, const response_worth *worth) {
  switch (curve->report.end) {
  case THRUM_RESPONSE_END_LOST:
    return "lost";
  case THRUM_RESPONSE_END_POINTS:
    return "points";
  case THRUM_RESPONSE_END_STOPPED:
    return "stopped";
  case THRUM_RESPONSE_END_ARRIVED:
  case THRUM_RESPONSE_END_LEFT:
  case THRUM_RESPONSE_END_AMPLITUDE:
  case THRUM_RESPONSE_END_CLOSED:
    break;
  }
  if (branch_points(curve) < curve->request->branch)
    return "unbranched";
  if (worth->stopped)
    return "stopped";
  if (!tail_tells(curve) || curve->report.tail > TAIL_WARNED)
    return "coarse";
  return worth->count > 0 && !(worth->largest <= curve->request->check_error) ? "missed" : NULL;
}

static const char *word_of(const response_curve *curve, const response_worth *worth) {
  const char *flag = response_flag(curve, worth);
  return flag ? flag : "done";
}

static double hertz(double omega) {
  return omega / THRUM_TWO_PI;
}

/* The row of the largest displacement of the first target; -1: there is none. */
static int64_t peak_row(const response_curve *c) {
  int64_t best = -1;
  for (int64_t n = 0; n < c->count && c->target_count > 0; n++)
    if (best < 0 || c->peak[n * c->target_count] > c->peak[best * c->target_count])
      best = n;
  return best;
}

static void add_special(const response_curve *c, cJSON *object) {
  cJSON *list = cJSON_AddArrayToObject(object, "special");
  for (int64_t n = 0; n < c->count; n++) {
    const response_row *row = &c->rows[n];
    if (row->point.kind == THRUM_RESPONSE_REGULAR)
      continue;
    cJSON *item = json_add_row(list);
    json_number(item, "point", (double)n + 1);
    json_string(item, "kind", thrum_response_kind_name(row->point.kind));
    json_number(item, "frequency_hz", hertz(row->point.omega));
    json_number(item, "relative_to_mode",
                row->point.omega /
                    sqrt(c->stepped->omega2[c->request->mode > 0 ? c->request->mode - 1 : 0]));
    json_number(item, "energy_j", row->point.energy);
    json_numbers(item, "peak_m", c->peak + n * c->target_count, c->target_count);
  }
}

/* Where a multiple of the frequency meets that of a mode at rest: `each` is told, lowest multiples
 * first. */
static void each_resonance(const response_curve *c,
                           void (*each)(void *context, double multiple, int64_t mode, double omega),
                           void *context) {
  double low = INFINITY, high = 0;
  for (int64_t n = 0; n < c->count; n++) {
    low = fmin(low, c->rows[n].point.omega);
    high = fmax(high, c->rows[n].point.omega);
  }
  for (int64_t k = c->request->periods + 1; k <= c->harmonics; k++)
    for (int64_t mode = 0; mode < c->stepped->rank; mode++) {
      const double multiple = (double)k / (double)c->request->periods;
      const double omega = sqrt(c->stepped->omega2[mode]) / multiple;
      if (omega >= low && omega <= high)
        each(context, multiple, mode + 1, omega);
    }
}

static void add_resonance(void *context, double multiple, int64_t mode, double omega) {
  cJSON *item = json_add_row(context);
  json_number(item, "harmonic", multiple);
  json_number(item, "mode", (double)mode);
  json_number(item, "frequency_hz", hertz(omega));
}

static void print_resonance(void *context, double multiple, int64_t mode, double omega) {
  int *printed = context;
  if (++*printed <= RESONANCES_MOST)
    printf("%s%g x %.6g Hz is mode %" PRId64, *printed == 1 ? "internal     " : ", ", multiple,
           hertz(omega), mode);
}

/* The first of them, where the motion may go over to another mode. */
static void print_resonances(const response_curve *c) {
  int printed = 0;
  each_resonance(c, print_resonance, &printed);
  if (printed > RESONANCES_MOST)
    printf(", %d more", printed - RESONANCES_MOST);
  if (printed > 0)
    printf("\n");
}

/* The two numbers that do not depend on the scale of the mode. */
static double form_second(const thrum_normal_form *form) {
  const double *c = form->coefficients;
  return c[1] * form->omega / (c[0] * c[0]);
}
static double form_third(const thrum_normal_form *form) {
  const double *c = form->coefficients;
  return c[2] * form->omega * form->omega / (c[0] * c[0] * c[0]);
}

static void add_form(const response_curve *c, cJSON *object) {
  cJSON *form = json_section(object, "normal_form", c->form.omega > 0);
  if (form == NULL)
    return;
  json_number(form, "omega", c->form.omega);
  json_numbers(form, "coefficients", c->form.coefficients, 3);
  json_number(form, "second_ratio", form_second(&c->form));
  json_number(form, "third_ratio", form_third(&c->form));
  json_numbers(form, "good_to_m", c->form_amplitudes, 2);
}

static void add_pair(const response_curve *c, cJSON *object) {
  cJSON *form = json_section(object, "normal_form_pair", c->pair.count > 0);
  if (form == NULL)
    return;
  json_numbers(form, "modes",
               (const double[]){(double)c->pair_modes[0] + 1, (double)c->pair_modes[1] + 1}, 2);
  json_number(form, "ratio", c->pair_ratio);
  json_numbers(form, "omega", c->pair.omega, 2);
  json_number(form, "order", c->pair_order);
  json_numbers(form, "good_to_m", c->pair_amplitudes, 2);
  cJSON *list = cJSON_AddArrayToObject(form, "terms");
  for (int n = 0; n < c->pair.count; n++) {
    const thrum_normal_form_term *term = &c->pair.terms[n];
    double powers[4];
    for (int v = 0; v < 4; v++)
      powers[v] = term->powers[v];
    cJSON *item = json_add_row(list);
    json_number(item, "mode", (double)c->pair_modes[term->of] + 1);
    json_numbers(item, "powers", powers, 4);
    json_number(item, "coefficient", term->coefficient);
  }
}

/* How far a form is good, and the order up to which all agree there. */
static void print_good(const double amplitudes[2]) {
  static const char *const orders[] = {"3 and 5", "5 and 7"};
  bool any = false;
  for (int n = 0; n < 2; n++) {
    if (isfinite(amplitudes[n]))
      printf("%s %s at %.3g m", any ? "," : "orders", orders[n], amplitudes[n]);
    any = any || isfinite(amplitudes[n]);
  }
  printf(any ? " are 1 %% apart\n" : "one order\n");
}

static void print_form(const response_curve *c) {
  printf("normal form  %s; d omega/c^2 = %.6g, e omega^2/c^3 = %.6g; ",
         c->form.coefficients[0] > 0 ? "hardening" : "softening", form_second(&c->form),
         form_third(&c->form));
  print_good(c->form_amplitudes);
}

/* A row for each term of the normal form of two modes, to order 3: the report has the others. */
static void print_pair(const response_curve *c) {
  static const char *const names[4] = {"z1", "z1*", "z2", "z2*"};
  printf("two modes    z1 of mode %" PRId64 " and z2 of mode %" PRId64
         " near 1:%d (%.5g): z' = i (omega z + sum of f z^p)\n",
         c->pair_modes[0] + 1, c->pair_modes[1] + 1, (int)c->pair_ratio,
         c->pair.omega[1] / c->pair.omega[0]);
  int left_out = 0;
  for (int n = 0; n < c->pair.count; n++) {
    const thrum_normal_form_term *term = &c->pair.terms[n];
    if (term->powers[0] + term->powers[1] + term->powers[2] + term->powers[3] > ORDER_PRINTED) {
      left_out++;
      continue;
    }
    printf("             z%d'  %+.6g ", (int)term->of + 1, term->coefficient);
    for (int v = 0; v < 4; v++)
      for (int power = 0; power < term->powers[v]; power++)
        printf(" %s", names[v]);
    printf("\n");
  }
  if (left_out > 0)
    printf("             and %d terms to order %d in the report of --json\n", left_out,
           (int)c->pair_order);
  printf("             both furthest vertices displaced: ");
  print_good(c->pair_amplitudes);
}

/* How far the mesh misses the orbits. */
static void add_worth(const response_curve *c, const response_worth *worth, cJSON *object) {
  cJSON *list = cJSON_AddArrayToObject(object, "mesh");
  for (int64_t n = 0; n < worth->count; n++) {
    const response_worth_point *point = &worth->points[n];
    cJSON *item = json_add_row(list);
    json_number(item, "point", (double)point->row + 1);
    json_number(item, "frequency_hz", hertz(c->rows[point->row].point.omega));
    json_number(item, "missed", point->mesh);
    json_number(item, "missed_by_model", point->model);
    json_number(item, "gain", point->gain);
  }
  cJSON_AddBoolToObject(object, "check_left_out", worth->left_out);
  json_number(object, "check_seconds", worth->seconds);
}

cJSON *response_report_object(const response_curve *curve, const response_worth *worth) {
  const response_request *request = curve->request;
  cJSON *object = json_report("response", word_of(curve, worth));
  json_string(object, "model", request->model_path);
  model_hash_json(object, &curve->hash);
  json_number(object, "rank", (double)curve->shape->rank);
  json_number(object, "coordinates", (double)curve->stepped->rank);
  json_number(object, "mode", request->mode > 0 ? (double)request->mode : NAN);
  cJSON *loads = cJSON_AddArrayToObject(object, "loads");
  for (int64_t n = 0; n < request->load_count; n++)
    json_add_string(loads, request->loads[n].text);
  json_numbers(object, "damping", (const double[]){request->damping.alpha, request->damping.beta},
               2);
  json_numbers(object, "damping_ratios", request->damping.ratios, request->damping.ratio_count);
  json_number(object, "from_hz", curve->from);
  json_number(object, "to_hz", curve->to);
  json_number(object, "harmonics", (double)curve->harmonics);
  json_number(object, "periods", (double)request->periods);
  json_number(object, "branch", request->branch > 0 ? (double)request->branch : NAN);
  json_strings(object, "at", curve->at, curve->target_count);
  double frequencies[8];
  const int64_t shown = curve->stepped->rank < 8 ? curve->stepped->rank : 8;
  for (int64_t i = 0; i < shown; i++)
    frequencies[i] = hertz(sqrt(curve->stepped->omega2[i]));
  json_numbers(object, "mode_hz", frequencies, shown);

  // the curve
  const thrum_response_report *report = &curve->report;
  json_string(object, "end", thrum_response_end_name(report->end));
  json_number(object, "end_hz",
              curve->count > 0 ? hertz(curve->rows[curve->count - 1].point.omega) : NAN);
  json_number(object, "points", (double)curve->count);
  json_number(object, "folds", report->folds);
  const int64_t peak = peak_row(curve);
  json_number(object, "peak_point", peak >= 0 ? (double)peak + 1 : NAN);
  json_number(object, "peak_hz", peak >= 0 ? hertz(curve->rows[peak].point.omega) : NAN);
  json_number(object, "peak_m", peak >= 0 ? curve->peak[peak * curve->target_count] : NAN);
  add_special(curve, object);
  each_resonance(curve, add_resonance, cJSON_AddArrayToObject(object, "internal_resonances"));

  add_form(curve, object);
  add_pair(curve, object);
  add_worth(curve, worth, object);

  // how well it was found, and at what cost
  json_number(object, "tail", tail_tells(curve) ? report->tail : NAN);
  json_number(object, "balance", report->balance);
  json_number(object, "iterations", report->iterations);
  json_number(object, "factorisations", report->factorisations);
  json_string(object, "output", request->output);
  json_number(object, "seconds", curve->seconds);
  return object;
}

static void print_worth(const response_curve *c, const response_worth_point *point) {
  printf("mesh         misses its orbit at %.6g Hz, point %" PRId64
         ", by %.2g %% (all coordinates of the model: %.2g %%)",
         hertz(c->rows[point->row].point.omega), point->row + 1, 100 * point->mesh,
         100 * point->model);
  if (isfinite(point->gain))
    printf(", and gains %.2g %% of what damping takes", 100 * point->gain);
  printf("\n");
}

/* Where the first target is, if it is one vertex. */
static void print_place(const response_curve *c) {
  if (c->request->target_count == 0)
    return;
  const int64_t vertex = load_target_only(c->shape, &c->request->targets[0]);
  const double *at = vertex >= 0 ? c->shape->vertices + 3 * vertex : NULL;
  if (at != NULL)
    printf(" (vertex %" PRId64 " at %g, %g, %g)", vertex + 1, at[0], at[1], at[2]);
}

void response_report_table(const response_curve *curve, const response_worth *worth) {
  const response_request *request = curve->request;
  const thrum_response_report *report = &curve->report;
  const int64_t mode = request->mode > 0 ? request->mode - 1 : 0;
  const double omega = sqrt(curve->stepped->omega2[mode]);
  printf("model        %" PRId64 " coordinates move, %" PRId64 " follow; mode %" PRId64
         " at %.6g Hz\n",
         curve->stepped->rank, curve->shape->rank - curve->stepped->rank, mode + 1, hertz(omega));
  printf("curve        %" PRId64 " points, %.6g to %.6g Hz, %s; %" PRId64 " harmonic%s",
         curve->count, hertz(curve->rows[0].point.omega),
         hertz(curve->rows[curve->count - 1].point.omega), thrum_response_end_name(report->end),
         curve->harmonics, curve->harmonics > 1 ? "s" : "");
  if (tail_tells(curve))
    printf(", the last two with %.1e of the energy", report->tail);
  printf("\n");
  if (request->mode == 0 && (request->from == 0 || request->to == 0))
    printf("range        %.6g to %.6g Hz, as --from and --to are not both given\n", curve->from,
           curve->to);
  const int64_t peak = peak_row(curve);
  if (peak >= 0) {
    printf("peak         %.6g m at %s", curve->peak[peak * curve->target_count], curve->at[0]);
    print_place(curve);
    printf(", %.6g Hz, point %" PRId64 "\n", hertz(curve->rows[peak].point.omega), peak + 1);
  }

  // what happens on the way
  for (int64_t n = 0; n < curve->count; n++) {
    const response_row *row = &curve->rows[n];
    if (row->point.kind != THRUM_RESPONSE_REGULAR)
      printf("%-12s %.8g Hz, %+.4f %% of mode %" PRId64 ", point %" PRId64 "\n",
             row->point.kind == THRUM_RESPONSE_PERIOD_DOUBLING ? "doubling"
             : row->point.kind == THRUM_RESPONSE_NEIMARK_SACKER
                 ? "torus"
                 : thrum_response_kind_name(row->point.kind),
             hertz(row->point.omega), 100 * (row->point.omega / omega - 1), mode + 1, n + 1);
  }
  print_resonances(curve);
  if (curve->form.omega > 0)
    print_form(curve);
  if (curve->pair.count > 0)
    print_pair(curve);
  if (report->balance > 0)
    printf("balance      work of the load and dissipation agree to %.1e\n", report->balance);
  for (int64_t n = 0; n < worth->count; n++)
    print_worth(curve, &worth->points[n]);
  printf("cost         %.3g s, %d iterations, %d factorisations\n", curve->seconds,
         (int)report->iterations, (int)report->factorisations);
  printf("status       %s\n", word_of(curve, worth));
  if (request->output != NULL)
    printf("files        %s\n", request->output);
}

/* A mode of the frequency of another; -1: there is none. */
static int64_t twin_of(const thrum_model *model, int64_t mode) {
  for (int64_t i = 0; mode >= 0 && i < model->rank; i++)
    if (i != mode && fabs(sqrt(model->omega2[i] / model->omega2[mode]) - 1) < TWIN)
      return i;
  return -1;
}

static void warn_of_harmonics(const response_curve *curve) {
  const int periods = (int)curve->request->periods, harmonics = (int)curve->harmonics;

  // the next number whose last is a multiple of the load's own
  const int least = 3 * periods, next = (harmonics / periods + 1) * periods;
  if (!tail_tells(curve))
    config_warn("--harmonics %d: nothing tells whether these are enough, as the last two have no "
                "multiple of the load's own behind its second; take %d",
                harmonics, harmonics < least ? least : next);
  else if (curve->report.tail > TAIL_WARNED)
    config_warn(
        "too few harmonics: the last two of %d have %.2g %% of the kinetic energy; take more "
        "--harmonics",
        harmonics, 100 * curve->report.tail);
}

static void warn_of_stability(const response_curve *curve) {
  int64_t open = 0;
  for (int64_t n = 0; n < curve->count; n++)
    open += curve->rows[n].point.unstable < 0;
  if (open > 0 && curve->request->stability)
    config_warn("the stability of %" PRId64 " points depends on the steps: take more "
                "--stability-steps",
                open);
}

/* How the curve ended, where it did not simply arrive. */
static void warn_of_end(const response_curve *curve) {
  const double last = hertz(curve->rows[curve->count - 1].point.omega);
  switch (curve->report.end) {
  case THRUM_RESPONSE_END_LOST:
    config_warn("the curve was lost at %.6g Hz: what was found before is kept", last);
    break;
  case THRUM_RESPONSE_END_POINTS:
    config_warn("the curve ends at %.6g Hz after as many --points as were allowed", last);
    break;
  case THRUM_RESPONSE_END_STOPPED:
    config_warn("stopped at %.6g Hz: what was found is kept", last);
    break;
  case THRUM_RESPONSE_END_LEFT:
    if (curve->request->start_from != NULL)
      config_warn("the curve turned back and ends behind --from, at %.6g Hz", last);
    else
      config_warn("the curve turned back and left the range at --from, %.6g Hz", last);
    break;
  case THRUM_RESPONSE_END_CLOSED:
    config_warn("the curve closed on itself at %.6g Hz", last);
    break;
  case THRUM_RESPONSE_END_ARRIVED:
  case THRUM_RESPONSE_END_AMPLITUDE:
    break;
  }
}

/* A backbone that ends before its amplitude. */
static void warn_of_amplitude(const response_curve *c) {
  const int64_t best = peak_row(c);
  if (!isfinite(c->request->amplitude) || c->report.end == THRUM_RESPONSE_END_AMPLITUDE || best < 0)
    return;
  config_warn("--amplitude %g m was not reached: %s moves by %.3g m at most, at %.6g Hz; widen "
              "--from and --to",
              c->request->amplitude, c->at[0], c->peak[best * c->target_count],
              hertz(c->rows[best].point.omega));
}

void response_report_warn(const response_curve *curve, const response_worth *worth) {
  const response_request *request = curve->request;
  const int64_t mode = request->mode - 1, twin = twin_of(curve->stepped, mode);
  if (twin >= 0)
    config_warn("modes %lld and %lld have one frequency to a thousandth: any mix of them begins at "
                "rest, and which backbone is followed may differ with rounding; hold the other, or "
                "take a load",
                (long long)mode + 1, (long long)twin + 1);

  // what the mesh says of it
  if (worth->left_out)
    config_warn("the mesh takes long, so nobody looked whether it follows these orbits: --check 1 "
                "does (--no-check is silent)");
  if (worth->count > 0 && !(worth->largest <= request->check_error))
    config_warn("the mesh misses an orbit by %.2g %% in a period: take more --modes with all their "
                "derivatives, or --condense none",
                100 * worth->largest);

  // what the curve says of itself
  warn_of_harmonics(curve);
  warn_of_stability(curve);
  if (branch_points(curve) < request->branch)
    config_warn("--branch %lld: the curve has %lld branch points, and went straight on",
                (long long)request->branch, (long long)branch_points(curve));
  warn_of_end(curve);
  warn_of_amplitude(curve);
  if (worth->stopped && curve->report.end != THRUM_RESPONSE_END_STOPPED)
    config_warn("stopped after %d motions of the mesh: whether it follows the others is not known",
                (int)worth->count);
}
