/* A haptic loop at 1 kHz: each millisecond a device says where the hand is, a spring ties the body
 * to it, one step is made, and the spring's force goes back to the hand. Here the device is a sine
 * of 2 Hz. The program prints how long steps took and how many came late.
 *
 *   haptic beam.npz SECONDS
 *
 * SPDX-License-Identifier: Apache-2.0 */
#define _POSIX_C_SOURCE 200809L /* clock_nanosleep */

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "thrum/thrum.h"

#define PERIOD_NS 1000000
#define SPRING 200.0 /* [N/m] */

static double seconds_between(struct timespec a, struct timespec b) {
  return (double)(b.tv_sec - a.tv_sec) + 1e-9 * (double)(b.tv_nsec - a.tv_nsec);
}

static void sleep_until_next(struct timespec *moment) {
  moment->tv_nsec += PERIOD_NS;
  if (moment->tv_nsec >= 1000000000) {
    moment->tv_nsec -= 1000000000;
    moment->tv_sec++;
  }
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, moment, NULL);
}

/* One millisecond: from the place of the hand [m] to the force on it [N]. */
static double touch(const thrum_model *model, thrum_state *state, const int32_t *tip, int64_t count,
                    double hand, thrum_error *error) {
  double q[THRUM_RANK_MAX], reduced[THRUM_RANK_MAX] = {0}, moved[3] = {0};

  // where the tip is, and the pull of the spring between it and the hand
  if (thrum_state_get(model, state, q, NULL, error) < 0 ||
      thrum_displacement_mean(model, tip, count, q, moved, error) < 0)
    return NAN;
  const double pull = SPRING * (hand - moved[2]);
  const double force[3] = {0, 0, pull};

  // one step under that pull
  if (thrum_load_add_shared(model, tip, count, force, reduced, error) < 0 ||
      thrum_state_set_force(model, state, reduced, error) < 0 ||
      thrum_step(model, state, error) < 0)
    return NAN;

  return -pull;
}

int main(int argc, char **argv) {
  thrum_error error = {0};
  const thrum_model *model;
  thrum_state *state;
  const int32_t *tip;
  int64_t count;
  thrum_state_def def = thrum_default_state_def();
  def.dt = 1e-9 * PERIOD_NS;
  def.damping_alpha = 1;

  // the model, its group, and a state that steps at the rate of the device
  const int steps = argc == 3 ? (int)(1000 * strtod(argv[2], NULL)) : 0;
  if (steps < 1 || thrum_model_load(argv[1], &model, &error) < 0 ||
      thrum_model_group(model, "tip", &tip, &count, &error) < 0)
    return fprintf(stderr, "usage: haptic MODEL.npz SECONDS\n%s\n", error.message), 1;
  if (thrum_state_create(model, &def, &state, &error) < 0)
    return fprintf(stderr, "haptic: %s\n", error.message), 1;

  // each period: read the device, step, return the force, sleep until the next
  double longest = 0, strongest = 0;
  int late = 0;
  struct timespec next, before, after;
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (int step = 0; step < steps; step++) {
    const double hand = 0.05 * sin(2 * 3.14159265358979 * 2 * step * def.dt);
    clock_gettime(CLOCK_MONOTONIC, &before);
    const double force = touch(model, state, tip, count, hand, &error);
    clock_gettime(CLOCK_MONOTONIC, &after);

    if (!isfinite(force))
      return fprintf(stderr, "haptic: step %d: %s\n", step, error.message), 1;
    strongest = fmax(strongest, fabs(force));
    longest = fmax(longest, seconds_between(before, after));
    late += seconds_between(next, after) > def.dt;
    sleep_until_next(&next);
  }

  printf("%d steps: the longest took %.0f us, %d came late; at most %.2f N\n", steps, 1e6 * longest,
         late, strongest);
  thrum_state_destroy(state);
  thrum_model_destroy(model);
  return strongest > 0 ? 0 : 1;
}
