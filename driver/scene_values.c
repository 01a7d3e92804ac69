/* Reads the values of scene files that are more than a number, a text or a list.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene_values.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "config/parse.h"
#include "driver/scene_spec.h"
#include "thrum/thrum.h"

#define TAKE(name)                                                                                 \
  thrum_status scene_take_##name(const config_record_file *file, const config_record *record,      \
                                 const config_key *key, const json_node *value, void *to)

static bool is_number(const json_node *value, double *number) {
  return value->type == JSON_NUMBER && config_parse_number(value->text, number);
}

static bool is_whole(const json_node *value, double most, int32_t *count) {
  double number = 0;
  if (!is_number(value, &number) || !(number >= 0 && number <= most) || number != floor(number))
    return false;
  *count = (int32_t)number;
  return true;
}

TAKE(damping) {
  thrum_state_def *def = &((scene_settings *)to)->def;
  double pair[2] = {0, 0};
  if ((!is_number(value, pair) && !config_record_numbers(file, value, 2, pair)) || pair[0] < 0 ||
      pair[1] < 0)
    return config_record_wrong(file, record, key, value, "A or [A, B], none negative");
  def->damping_alpha = pair[0];
  def->damping_beta = pair[1];
  return THRUM_OK;
}

TAKE(newmark) {
  thrum_state_def *def = &((scene_settings *)to)->def;
  double pair[2];
  if (!config_record_numbers(file, value, 2, pair) || pair[0] < 0 || pair[1] < 0 || pair[1] > 1)
    return config_record_wrong(file, record, key, value,
                               "[BETA, GAMMA] with BETA >= 0 and GAMMA in [0, 1]");
  def->newmark_beta = pair[0];
  def->newmark_gamma = pair[1];
  return THRUM_OK;
}

TAKE(split) {
  thrum_state_def *def = &((scene_settings *)to)->def;
  if (value->type == JSON_STRING && strcmp(value->text, "cfl") == 0)
    def->split_rule = THRUM_SPLIT_CFL;
  else if (value->type == JSON_STRING && strcmp(value->text, "sampling") == 0)
    def->split_rule = THRUM_SPLIT_SAMPLING;
  else if (is_whole(value, THRUM_RANK_MAX, &def->explicit_count))
    def->split_rule = THRUM_SPLIT_COUNT;
  else
    return config_record_wrong(file, record, key, value,
                               "\"cfl\", \"sampling\" or the number of explicit modes");
  return THRUM_OK;
}

static thrum_status take_switch(const config_record_file *file, const config_record *record,
                                const config_key *key, const json_node *value, int32_t *on) {
  if (value->type != JSON_TRUE && value->type != JSON_FALSE)
    return config_record_wrong(file, record, key, value, "true or false");
  *on = value->type == JSON_TRUE;
  return THRUM_OK;
}

TAKE(adaptive) {
  return take_switch(file, record, key, value, &((scene_settings *)to)->def.adaptive);
}

TAKE(fallback) {
  return take_switch(file, record, key, value, &((scene_settings *)to)->def.fallback);
}

TAKE(iterations) {
  int32_t count = 0;
  if (!is_whole(value, 1e6, &count) || count < 1)
    return config_record_wrong(file, record, key, value, "a whole number from 1 to 1e+06");
  ((scene_settings *)to)->def.iterations_max = count;
  return THRUM_OK;
}

/* A quaternion of the turn by `angle` [degrees] about `axis`; false for an axis of no length. */
static bool axis_angle(const double axis[3], double angle, double rotation[4]) {
  const double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  const double half = 0.5 * SCENE_DEGREE * fmod(angle, 720.0);
  if (!isnormal(length))
    return false;
  rotation[0] = cos(half);
  for (int n = 0; n < 3; n++)
    rotation[1 + n] = sin(half) * axis[n] / length;
  return true;
}

TAKE(rotation) {
  static const char wants[] =
      "{\"axis\": [X, Y, Z], \"angle\": DEGREES} or a quaternion [W, X, Y, Z], not zero";
  double *rotation = (double *)(void *)((char *)to + key->field);
  double numbers[4], axis[3], angle = 0;
  if (config_record_numbers(file, value, 4, numbers)) {
    const double square = numbers[0] * numbers[0] + numbers[1] * numbers[1] +
                          numbers[2] * numbers[2] + numbers[3] * numbers[3];
    if (!isnormal(square))
      return config_record_wrong(file, record, key, value, wants);
    memcpy(rotation, numbers, sizeof numbers);
    return THRUM_OK;
  }
  const config_record here = {.node = value};
  const json_node *axis_node = config_record_member(file, &here, "axis");
  const json_node *angle_node = config_record_member(file, &here, "angle");
  int members = 0;
  for (int64_t n = value->type == JSON_OBJECT ? value->first : -1; n >= 0;
       n = file->document.nodes[n].next)
    members++;
  if (axis_node == NULL || angle_node == NULL || members != 2 ||
      !config_record_numbers(file, axis_node, 3, axis) || !is_number(angle_node, &angle) ||
      !axis_angle(axis, angle, rotation))
    return config_record_wrong(file, record, key, value, wants);
  return THRUM_OK;
}

/* "#rrggbb"; false when it is none. */
static bool hex_colour(const char *text, float colour[3]) {
  unsigned values[6];
  if (text[0] != '#' || strlen(text) != 7)
    return false;
  for (int n = 0; n < 6; n++) {
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *digit = strchr(digits, text[n + 1]);
    if (digit == NULL)
      return false;
    values[n] = (unsigned)(digit - digits) % 16;
  }
  for (int n = 0; n < 3; n++)
    colour[n] = (float)(16 * values[2 * n] + values[2 * n + 1]) / 255.0f;
  return true;
}

TAKE(colour) {
  float *colour = (float *)(void *)((char *)to + key->field);
  double numbers[3] = {-1, -1, -1};
  if (value->type == JSON_STRING && hex_colour(value->text, colour))
    return THRUM_OK;
  const bool list = config_record_numbers(file, value, 3, numbers);
  for (int n = 0; n < 3; n++)
    if (!list || !(numbers[n] >= 0 && numbers[n] <= 1))
      return config_record_wrong(file, record, key, value,
                                 "\"#rrggbb\", or [red, green, blue] from 0 to 1");
  for (int n = 0; n < 3; n++)
    colour[n] = (float)numbers[n];
  return THRUM_OK;
}

TAKE(frames) {
  static const char every[] = "every-";
  scene_outputs_spec *outputs = to;
  outputs->frames_rate = 0;
  outputs->frames_every = 0;
  if (is_number(value, &outputs->frames_rate) && outputs->frames_rate > 0)
    return THRUM_OK;
  if (value->type == JSON_STRING && strncmp(value->text, every, sizeof every - 1) == 0 &&
      config_parse_integer(value->text + sizeof every - 1, &outputs->frames_every) &&
      outputs->frames_every > 0)
    return THRUM_OK;
  return config_record_wrong(file, record, key, value,
                             "frames a second such as 60, or \"every-N\" steps");
}
