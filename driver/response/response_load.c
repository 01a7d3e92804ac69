/* Loads of forced curves: those of thrum simulate without a frequency, which is what the curve goes
 * through, and with a phase. SPDX-License-Identifier: Apache-2.0 */
#include "driver/response/response_load.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "config/message.h"
#include "config/parse.h"
#include "core/base/pi.h"

static const char sine_prefix[] = "sine:";
static const char phase_key[] = ",phase=";

/* Copies the text without its phase, which goes into *phase. */
static thrum_status take_phase(const char *text, const char *option, char body[LOAD_TEXT_MAX],
                               double *phase, thrum_error *error) {
  double degrees = 0;
  if (strlen(text) + 8 >= LOAD_TEXT_MAX)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT, "%s '%.60s...': longer than %d bytes",
                           option, text, LOAD_TEXT_MAX - 9);
  snprintf(body, LOAD_TEXT_MAX, "%s", text);
  char *pair = strstr(body, phase_key);
  if (pair != NULL && !config_parse_number(pair + sizeof phase_key - 1, &degrees))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s '%.200s': phase= is a number of degrees, and the last", option,
                           text);
  if (pair != NULL)
    *pair = 0;
  *phase = degrees * THRUM_PI / 180;
  if (strstr(body, ",f=") != NULL || strstr(body, ",from=") != NULL ||
      strstr(body, ",until=") != NULL)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "%s '%.200s': f=, from= and until= are of thrum simulate: the "
                           "frequency goes from --from to --to, and the load acts for ever",
                           option, text);
  return THRUM_OK;
}

thrum_status response_load_parse(const char *text, response_load *load, thrum_error *error) {
  char body[LOAD_TEXT_MAX];
  response_load parsed = {.text = text, .swings = strncmp(text, sine_prefix, 5) == 0};
  THRUM_TRY(take_phase(text, "--load", body, &parsed.phase, error));
  if (parsed.swings)
    snprintf(body + strlen(body), 5, ",f=1");
  THRUM_TRY(load_spec_parse(body, &parsed.spec, error));
  parsed.spec.text = text;
  if (!parsed.swings &&
      (parsed.spec.course.shape != THRUM_LOAD_CONSTANT || isfinite(parsed.spec.course.until)))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--load '%.200s': a periodic motion has loads that swing, sine:, or "
                           "that are always there, constant:, gravity: or traction:",
                           text);
  if (!parsed.swings && parsed.phase != 0)
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--load '%.200s': a load that is always there has no phase", text);
  if (parsed.spec.target.vertex > 0)
    snprintf(parsed.vertex, sizeof parsed.vertex, "vertex=%lld",
             (long long)parsed.spec.target.vertex);
  *load = parsed;
  return THRUM_OK;
}

thrum_status response_base_parse(const char *text, response_load *load, thrum_error *error) {
  char body[LOAD_TEXT_MAX];
  response_load parsed = {.text = text, .base = true, .swings = true};
  THRUM_TRY(take_phase(text, "--base-motion", body, &parsed.phase, error));
  if (strncmp(body, sine_prefix, sizeof sine_prefix - 1) != 0 ||
      !config_parse_vector3(body + sizeof sine_prefix - 1, parsed.vector))
    return thrum_error_set(error, THRUM_INVALID_ARGUMENT,
                           "--base-motion '%.200s': it is sine:AX,AY,AZ[,phase=DEGREES] with "
                           "AX,AY,AZ in m/s^2",
                           text);
  *load = parsed;
  return THRUM_OK;
}

thrum_status response_load_add(const thrum_model *model, const response_load *load, double *mean,
                               double *cosine, double *sine, double *reduced, thrum_error *error) {
  memset(reduced, 0, (size_t)model->rank * sizeof *reduced);
  if (load->base)
    THRUM_TRY(config_error_in(error, thrum_base_motion_load(model, load->vector, reduced, error),
                              "--base-motion '%.100s'", load->text));
  else
    THRUM_TRY(load_spec_reduce(model, &load->spec, reduced, error));

  // sin(Omega t + phase)
  for (int64_t i = 0; i < model->rank; i++) {
    if (!load->swings)
      mean[i] += reduced[i];
    cosine[i] += load->swings ? sin(load->phase) * reduced[i] : 0;
    sine[i] += load->swings ? cos(load->phase) * reduced[i] : 0;
  }
  return THRUM_OK;
}
