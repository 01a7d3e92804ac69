/* Damping as a user writes it; see damping_spec.h. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/damping_spec.h"

#include <math.h>

#include "thrum/model.h"

thrum_status damping_spec_take_rayleigh(const config_given *given, damping_spec *damping) {
  double pair[2] = {0, 0};
  THRUM_TRY(config_given_numbers(given, 1, 2, pair, NULL));
  damping->alpha = pair[0];
  damping->beta = pair[1];
  return THRUM_OK;
}

/* Ratios and quality factors say the same thing. */
static thrum_status refuse_both(const config_given *given, const damping_spec *damping,
                                bool by_quality) {
  if (damping->ratio_count > 0 && damping->by_quality != by_quality)
    return config_given_refuse(given, "--damping-ratio and --q say the same thing: leave one out");
  return THRUM_OK;
}

thrum_status damping_spec_take_ratios(const config_given *given, damping_spec *damping) {
  THRUM_TRY(refuse_both(given, damping, false));
  damping->by_quality = false;
  return config_given_numbers(given, 1, DAMPING_RATIOS_MAX, damping->ratios, &damping->ratio_count);
}

thrum_status damping_spec_take_quality(const config_given *given, damping_spec *damping) {
  THRUM_TRY(refuse_both(given, damping, true));
  THRUM_TRY(
      config_given_numbers(given, 1, DAMPING_RATIOS_MAX, damping->ratios, &damping->ratio_count));
  damping->by_quality = true;
  for (int64_t n = 0; n < damping->ratio_count; n++)
    damping->ratios[n] = 0.5 / damping->ratios[n];
  return THRUM_OK;
}

bool damping_spec_given(const damping_spec *damping) {
  bool given = damping->alpha > 0 || damping->beta > 0;
  for (int64_t n = 0; n < damping->ratio_count; n++)
    given = given || damping->ratios[n] > 0;
  return given;
}

double damping_spec_ratio(const damping_spec *damping, int64_t mode) {
  const int64_t last = damping->ratio_count - 1;
  return last < 0 ? 0 : damping->ratios[mode < last ? mode : last];
}

int64_t damping_spec_least(const double *ratios, const double *omega2, int64_t modes) {
  int64_t least = 0;
  for (int64_t i = 1; i < modes; i++)
    if (ratios[i] * sqrt(omega2[i]) < ratios[least] * sqrt(omega2[least]))
      least = i;
  return least;
}

void damping_spec_rates(const damping_spec *damping, const double *omega2, int64_t rank,
                        int64_t modes, double *rates) {
  double ratios[THRUM_RANK_MAX];
  for (int64_t i = 0; i < modes; i++)
    ratios[i] = damping_spec_ratio(damping, i);
  const int64_t least = damping_spec_least(ratios, omega2, modes);
  for (int64_t i = 0; i < rank; i++) {
    const int64_t as = i < modes ? i : least;
    rates[i] = damping->alpha + damping->beta * omega2[i] + 2 * ratios[as] * sqrt(omega2[as]);
  }
}
