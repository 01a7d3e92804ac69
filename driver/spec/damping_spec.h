/* Damping as a user writes it: Rayleigh's, a ratio for each mode, or a quality factor.
 *
 * A ratio is of a linear mode. The other coordinates of a basis have frequencies of kilohertz, but
 * follow the modes at theirs: damped by a ratio they would brake a large motion many times too
 * much. They have the least rate of the modes, so no motion is damped more than its modes are.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_DAMPING_SPEC_H
#define THRUM_DRIVER_SPEC_DAMPING_SPEC_H

#include "config/options.h"

#define DAMPING_RATIOS_MAX 64

typedef struct damping_spec {
  double alpha, beta;                /* of the mass [1/s] and of the stiffness [s] */
  double ratios[DAMPING_RATIOS_MAX]; /* of the modes; the last one is that of all beyond */
  int64_t ratio_count;
  bool by_quality; /* the ratios were given as quality factors */
} damping_spec;

/* For `take` of the options. */
thrum_status damping_spec_take_rayleigh(const config_given *given, damping_spec *damping);
thrum_status damping_spec_take_ratios(const config_given *given, damping_spec *damping);
thrum_status damping_spec_take_quality(const config_given *given, damping_spec *damping);

/* Whether anything damps. */
bool damping_spec_given(const damping_spec *damping);

/* The ratio of a mode, from 0. */
double damping_spec_ratio(const damping_spec *damping, int64_t mode);

/* Which of the modes has the least rate, 2 zeta omega; modes > 0. */
int64_t damping_spec_least(const double *ratios, const double *omega2, int64_t modes);

/* rates (rank) [1/s]: D of each coordinate, alpha + beta omega^2 + 2 zeta omega, where the last is
 * that of the mode for the first `modes` (1 to rank), and the least of those for the others. */
void damping_spec_rates(const damping_spec *damping, const double *omega2, int64_t rank,
                        int64_t modes, double *rates);

#define OPTION_DAMPING_RATIO(taken)                                                                \
  OPTION_WORD(                                                                                     \
      "damping-ratio", "Z1,Z2,...", "none",                                                        \
      "damping over critical damping of each linear mode, such as 0.002; the last one is "         \
      "that of all modes beyond, and other coordinates have the least rate of the modes; adds "    \
      "to --damping",                                                                              \
      .take = taken, CONFIG_RANGE(0, 1),                                                           \
      .wants = "ratios from 0 to 1 (0.5 % is 0.005), with commas between",                         \
      .schema = "{\"anyOf\":[{\"type\":\"number\",\"minimum\":0,\"maximum\":1},"                   \
                "{\"type\":\"array\",\"items\":{\"type\":\"number\",\"minimum\":0,"                \
                "\"maximum\":1}}]}")
#define OPTION_QUALITY(taken)                                                                      \
  OPTION_WORD("q", "Q1,Q2,...", "none",                                                            \
              "quality factor of each mode, 1 over twice its damping ratio, in its place",         \
              .take = taken, CONFIG_FROM(0.5), .wants = "numbers from 0.5, with commas between",   \
              .schema = "{\"anyOf\":[{\"type\":\"number\",\"minimum\":0.5},{\"type\":"             \
                        "\"array\",\"items\":{\"type\":\"number\",\"minimum\":0.5}}]}")

#endif
