/* How the forms of imexv and the other integrators compare on one model: their errors against a
 * fine reference, their energy in long runs, and what a step costs. Writes CSV to stdout.
 *
 *   thrum_integrator_comparison errors|energy|cost|matching BODY MODEL.npz GROUP [STEPS [METHOD]]
 *
 * Starts: smooth has momentum in the first mode alone, impulse that of an impulse on the group,
 * both scaled so that the group swings by a share of the body's length within 3 s. An error is the
 * root mean square of q - q_ref over 0.6 s relative to that of q_ref, which `energy` steps at h/32.
 * METHOD is one of errors and energy in place of all.
 * Methods named alone run without monitor and fallback. SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "platform/clock.h"
#include "validation/experiments/experiment_body.h"

#define FINER 32
#define ERROR_SECONDS 0.6
#define SWING_SECONDS 3.0
#define SWING_STEP 0.003
#define TENTHS 10
#define COST_ROUNDS 15
#define COST_STEPS 200

typedef struct method {
  const char *name;
  thrum_integrator integrator;
  thrum_split_form form;
  int32_t guarded;   /* 1: with monitor and fallback */
  int32_t unmatched; /* 1: energy without frequency matching */
} method;

static const method methods[] = {
    {"position alone", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION, 0, 0},
    {"position", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_POSITION, 1, 0},
    {"thesis alone", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS, 0, 0},
    {"thesis", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_THESIS, 1, 0},
    {"quadratic alone", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_QUADRATIC, 0, 0},
    {"quadratic", THRUM_INTEGRATOR_IMEXV, THRUM_FORM_QUADRATIC, 1, 0},
    {"newmark", THRUM_INTEGRATOR_NEWMARK, THRUM_FORM_THESIS, 1, 0},
    {"fox-goodwin alone", THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_THESIS, 0, 0},
    {"fox-goodwin", THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_THESIS, 1, 0},
    {"energy", THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 1, 0},
};
enum { METHODS = sizeof methods / sizeof methods[0], NEWMARK = 6 };

/* energy without frequency matching and with it, and what both are compared with. */
static const method matching[] = {
    {"trapezoidal", THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 1, 1},
    {"matched", THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 1, 0},
};
static const method fine = {"fox-goodwin alone", THRUM_INTEGRATOR_FOX_GOODWIN, THRUM_FORM_THESIS, 0,
                            0};

static const char *const starts[] = {"smooth", "impulse"};
static const double shares[] = {0.02, 0.05, 0.1, 0.2, 0.3, 0.4};
static const double time_steps[] = {0.003, 0.01};
enum { SHARES = sizeof shares / sizeof shares[0] };

/* One model with its momenta; a call that fails ends the program. */
typedef struct subject {
  const char *name;
  const char *only; /* method; NULL: all */
  experiment_body body;
  double momenta[2][SHARES][THRUM_RANK_MAX];
} subject;

static thrum_error error;

static bool is_wanted(const subject *s, const method *m) {
  return s->only == NULL || strcmp(s->only, m->name) == 0;
}

static void must(thrum_status status) {
  if (status >= 0)
    return;
  fprintf(stderr, "%s\n", error.message);
  exit(1);
}

static thrum_state *make(const subject *s, const method *m, double dt, const double *p) {
  thrum_state_def def = thrum_default_state_def();
  def.integrator = m->integrator;
  def.split_form = m->form;
  def.adaptive = def.fallback = m->guarded;
  def.frequency_matched = !m->unmatched;
  def.dt = dt;
  thrum_state *state = NULL;
  must(thrum_state_create(s->body.model, &def, &state, &error));
  must(thrum_state_set(s->body.model, state, NULL, p, &error));
  return state;
}

static double total_energy(const subject *s, thrum_state *state) {
  thrum_energies energies;
  return thrum_state_energies(s->body.model, state, &energies, NULL) < 0 ? INFINITY
                                                                         : energies.total;
}

/* --- starts ----------------------------------------------------------------------------------- */

/* Largest swing within SWING_SECONDS after this momentum, by `energy`. */
static double swing_of(const subject *s, const double *p) {
  const method by_energy = {"energy", THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 1, 0};
  thrum_state *state = make(s, &by_energy, SWING_STEP, p);
  double q[THRUM_RANK_MAX], most = 0.0;
  for (int k = 0; k < (int)(SWING_SECONDS / SWING_STEP); k++) {
    must(thrum_step(s->body.model, state, &error));
    must(thrum_state_get(s->body.model, state, q, NULL, &error));
    most = fmax(most, experiment_body_amplitude(&s->body, q));
  }
  thrum_state_destroy(state);
  return most;
}

/* Momenta along a direction under which the body swings by each share. */
static void scale_momenta(subject *s, const double *direction, double momenta[][THRUM_RANK_MAX]) {
  const int64_t rank = s->body.model->rank;
  double factor = 1.0;
  for (int n = 0; n < SHARES; n++)
    for (int round = 0; round < 8; round++) {
      for (int64_t i = 0; i < rank; i++)
        momenta[n][i] = factor * direction[i];
      if (round < 7)
        factor *= shares[n] / swing_of(s, momenta[n]);
    }
}

static void make_momenta(subject *s) {
  double first[THRUM_RANK_MAX] = {1.0};
  scale_momenta(s, first, s->momenta[0]);
  scale_momenta(s, s->body.push, s->momenta[1]);
}

/* --- errors ----------------------------------------------------------------------------------- */

/* Steps a state and adds the squares of its deviations from the rows of the reference to *square,
 * those of the reference to *whole; false when it is lost. */
static bool deviate(const subject *s, thrum_state *state, const double *rows, int count,
                    double *square, double *whole) {
  const int64_t rank = s->body.model->rank;
  for (int k = 0; k < count; k++) {
    double q[THRUM_RANK_MAX];
    if (thrum_step(s->body.model, state, NULL) < 0 ||
        thrum_state_get(s->body.model, state, q, NULL, NULL) < 0)
      return false;
    for (int64_t i = 0; i < rank; i++) {
      const double reference = rows[(int64_t)k * rank + i];
      *square += (q[i] - reference) * (q[i] - reference);
      *whole += reference * reference;
    }
  }
  return true;
}

static double *reference_rows(const subject *s, const method *by, double dt, int count,
                              const double *p) {
  const int64_t rank = s->body.model->rank;
  double *rows = malloc((size_t)count * (size_t)rank * sizeof *rows);
  if (!rows)
    must(thrum_error_set(&error, THRUM_OUT_OF_MEMORY, "no memory for a reference"));
  thrum_state *state = make(s, by, dt / FINER, p);
  for (int k = 0; k < count; k++) {
    for (int n = 0; n < FINER; n++)
      must(thrum_step(s->body.model, state, &error));
    must(thrum_state_get(s->body.model, state, rows + (int64_t)k * rank, NULL, &error));
  }
  thrum_state_destroy(state);
  return rows;
}

static void print_error(const subject *s, const method *m, int start, int share, double dt,
                        const double *rows, int count) {
  thrum_state *state = make(s, m, dt, s->momenta[start][share]);
  double square = 0.0, whole = 0.0;
  const bool there = deviate(s, state, rows, count, &square, &whole);
  const double error_now = sqrt(square / whole);

  // an error as large as the motion is no motion any more
  printf("%s,%d,%g,%s,%g,%s,", s->name, (int)s->body.model->rank, dt, starts[start], shares[share],
         m->name);
  if (there && error_now < 1.0)
    printf("%.4g,", error_now);
  else
    printf("lost,");
  const thrum_state_report r = thrum_state_report_get(state);
  const double steps = r.steps > 0 ? (double)r.steps : 1.0;
  printf("%.3f,%.3f,%lld\n", (double)r.iterations / steps, (double)r.factorisations / steps,
         (long long)(r.switched_steps + r.energy_steps + r.substep_steps));
  fflush(stdout);
  thrum_state_destroy(state);
}

/* The errors of energy without and with frequency matching, against fox-goodwin at dt/32. */
static void print_matching(const subject *s) {
  static const double lengths[] = {0.001, 0.003, 0.01};
  puts("body,rank,dt_s,start,swing,error_trapezoidal,error_matched,ratio,iterations_trapezoidal,"
       "iterations_matched");
  for (size_t h = 0; h < sizeof lengths / sizeof lengths[0]; h++)
    for (int start = 0; start < 2; start++)
      for (int share = 1; share < (lengths[h] == SWING_STEP ? SHARES : 4); share++) {
        // the reference serves both
        const double dt = lengths[h], *p = s->momenta[start][share];
        const int count = (int)(ERROR_SECONDS / dt + 0.5);
        double *rows = reference_rows(s, &fine, dt, count, p), errors[2], iterations[2];
        for (int m = 0; m < 2; m++) {
          thrum_state *state = make(s, &matching[m], dt, p);
          double square = 0.0, whole = 0.0;
          const bool there = deviate(s, state, rows, count, &square, &whole);
          const thrum_state_report r = thrum_state_report_get(state);
          errors[m] = there ? sqrt(square / whole) : NAN;
          iterations[m] = (double)r.iterations / (double)r.steps;
          thrum_state_destroy(state);
        }

        // a line of the table as soon as it is known
        printf("%s,%d,%g,%s,%g,%.4g,%.4g,%.3f,%.3f,%.3f\n", s->name, (int)s->body.model->rank, dt,
               starts[start], shares[share], errors[0], errors[1], errors[1] / errors[0],
               iterations[0], iterations[1]);
        fflush(stdout);
        free(rows);
      }
}

static void print_errors(const subject *s) {
  const method by_energy = {"energy", THRUM_INTEGRATOR_ENERGY, THRUM_FORM_THESIS, 1, 0};
  puts("body,rank,dt_s,start,swing,method,error,iterations,factorisations,steps_by_energy");
  for (size_t h = 0; h < sizeof time_steps / sizeof time_steps[0]; h++)
    for (int start = 0; start < 2; start++)
      for (int share = 0; share < SHARES; share++) {
        const double dt = time_steps[h];
        const int count = (int)(ERROR_SECONDS / dt + 0.5);
        double *rows = reference_rows(s, &by_energy, dt, count, s->momenta[start][share]);
        for (int m = 0; m < METHODS; m++)
          if (is_wanted(s, &methods[m]))
            print_error(s, &methods[m], start, share, dt, rows, count);
        free(rows);
      }
}

/* --- energy in long runs ---------------------------------------------------------------------- */

static void print_energy(const subject *s, const method *m, int start, int share, int64_t steps) {
  thrum_state *state = make(s, m, SWING_STEP, s->momenta[start][share]);
  const double first = total_energy(s, state);
  double sum = 0.0, first_mean = 0.0, last_mean = 0.0, worst = 0.0;
  int64_t done = 0, counted = 0;
  bool lost = false;
  for (; done < steps && !lost; done++) {
    lost = thrum_step(s->body.model, state, NULL) < 0;
    if (lost || done % 5 != 0)
      continue;

    // growth to twice the energy counts as lost too
    const double change = total_energy(s, state) / first - 1.0;
    lost = !(fabs(change) < 1.0);
    worst = fmax(worst, fabs(change));
    sum += change;
    counted++;

    // means over tenths of the run
    if (counted * 5 * TENTHS < steps)
      continue;
    last_mean = sum / (double)counted;
    if (done < steps / 5)
      first_mean = last_mean;
    sum = 0.0;
    counted = 0;
  }

  const thrum_state_report r = thrum_state_report_get(state);
  printf("%s,%d,%g,%s,%g,%s,%s,%lld,", s->name, (int)s->body.model->rank, SWING_STEP, starts[start],
         shares[share], m->name, lost ? "lost" : "done", (long long)r.steps);
  if (lost)
    printf(",,");
  else
    printf("%.3e,%.3e,", last_mean - first_mean, worst);
  printf("%lld,%lld,%lld\n", (long long)r.switched_steps, (long long)r.corrections,
         (long long)r.split_changes);
  fflush(stdout);
  thrum_state_destroy(state);
}

static void print_energies(const subject *s, int64_t steps) {
  puts("body,rank,dt_s,start,swing,method,status,steps,drift_of_mean,largest_change,"
       "steps_by_energy,corrections,split_changes");
  for (int start = 0; start < 2; start++)
    for (int share = 1; share < 5; share++)
      for (int m = 0; m < METHODS; m++)
        if (is_wanted(s, &methods[m]))
          print_energy(s, &methods[m], start, share, steps);
}

/* --- cost ------------------------------------------------------------------------------------- */

/* The methods step in turns from snapshots of their own after 100 steps; the least of the rounds
 * counts, relative to newmark's. */
static void print_costs(const subject *s) {
  puts("body,rank,dt_s,start,swing,method,us_per_step,over_newmark,iterations,factorisations");
  for (int start = 0; start < 2; start++)
    for (int share = 0; share < 4; share++) {
      thrum_state *states[METHODS];
      void *kept[METHODS];
      double least[METHODS];
      thrum_state_report before[METHODS];
      bool lost[METHODS];

      // 100 steps, so that predictors and Jacobians are those of a long run
      for (int m = 0; m < METHODS; m++) {
        states[m] = make(s, &methods[m], SWING_STEP, s->momenta[start][share]);
        lost[m] = false;
        for (int k = 0; k < 100 && !lost[m]; k++)
          lost[m] = thrum_step(s->body.model, states[m], NULL) < 0;
        least[m] = INFINITY;
        before[m] = thrum_state_report_get(states[m]);
        kept[m] = malloc(thrum_state_kept_bytes(states[m]));
        if (!kept[m])
          must(thrum_error_set(&error, THRUM_OUT_OF_MEMORY, "no memory for a snapshot"));
        memcpy(kept[m], states[m], thrum_state_kept_bytes(states[m]));
      }

      // in turns, so that a slow moment of the machine meets all methods
      for (int round = 0; round < COST_ROUNDS; round++)
        for (int m = 0; m < METHODS; m++) {
          memcpy(states[m], kept[m], thrum_state_kept_bytes(states[m]));
          const double began = clock_thread_seconds();
          for (int k = 0; k < COST_STEPS && !lost[m]; k++)
            lost[m] = thrum_step(s->body.model, states[m], NULL) < 0;
          least[m] = fmin(least[m], 1e6 * (clock_thread_seconds() - began) / COST_STEPS);
        }

      // relative to newmark, which is what one would use otherwise
      const double newmark = least[NEWMARK];
      for (int m = 0; m < METHODS; m++) {
        const thrum_state_report r = thrum_state_report_get(states[m]);
        printf("%s,%d,%g,%s,%g,%s,", s->name, (int)s->body.model->rank, SWING_STEP, starts[start],
               shares[share], methods[m].name);
        if (lost[m])
          puts("lost,,,");
        else
          printf("%.2f,%.2f,%.2f,%.2f\n", least[m], least[m] / newmark,
                 (double)(r.iterations - before[m].iterations) / COST_STEPS,
                 (double)(r.factorisations - before[m].factorisations) / COST_STEPS);
        free(kept[m]);
        thrum_state_destroy(states[m]);
      }
      fflush(stdout);
    }
}

int main(int argc, char **argv) {
  static subject s;
  const thrum_model *model = NULL;
  const double softest[3] = {0.0, 0.0, 0.0};
  if (argc < 5)
    return fprintf(stderr,
                   "usage: thrum_integrator_comparison errors|energy|cost|matching BODY MODEL.npz "
                   "GROUP [STEPS [METHOD]]\n"),
           2;

  // the body is pushed along the axis in which it is softest
  must(thrum_model_load(argv[3], &model, &error));
  s.name = argv[2];
  s.only = argc > 6 ? argv[6] : NULL;
  must(experiment_body_init(argv[2], model, argv[4], softest, &s.body, &error));
  make_momenta(&s);

  // each table is a program of its own, as it takes minutes to hours
  if (strcmp(argv[1], "errors") == 0)
    print_errors(&s);
  else if (strcmp(argv[1], "matching") == 0)
    print_matching(&s);
  else if (strcmp(argv[1], "energy") == 0)
    print_energies(&s, argc > 5 ? atoll(argv[5]) : 200000);
  else
    print_costs(&s);
  experiment_body_free(&s.body);
  thrum_model_destroy(model);
  return 0;
}
