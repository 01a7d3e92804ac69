/* Messages that the subcommands share, and the nearest of names.
 * SPDX-License-Identifier: Apache-2.0 */
#include "config/message.h"

#include <getopt.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "core/base/plain_text.h"
#include "thrum/thrum.h"

#define NEAREST_LENGTH_MAX 31
#define NEAREST_DISTANCE_MAX 3
#define OPTION_COUNT_MAX 64

int config_refuse(const thrum_error *error) {
  const char *message = error->message[0] != 0 ? error->message : thrum_status_text(error->status);
  fprintf(stderr, "thrum: %s\n", message);
  return COMMAND_REFUSED;
}

int config_end(thrum_status status, bool flagged, const thrum_error *error) {
  if (status < 0)
    return config_refuse(error);
  return flagged ? COMMAND_FLAGGED : COMMAND_DONE;
}

void config_one_line(char *text) {
  thrum_plain_text(text);
}

int config_usage(const char *command, const char *format, ...) {
  char line[1200];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  config_one_line(line);
  const char *blank = command[0] != 0 ? " " : "";
  fprintf(stderr, "thrum%s%s: %s (try: thrum%s%s --help)\n", blank, command, line, blank, command);
  return COMMAND_USAGE;
}

/* config_warn_under sets both. */
static const char *warn_place;
static void (*warn_words)(char *line, size_t size);

void config_warn_under(const char *place, void (*words)(char *line, size_t size)) {
  warn_place = place;
  warn_words = words;
}

void config_warn(const char *format, ...) {
  char line[1200];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  config_one_line(line);
  if (warn_words != NULL)
    warn_words(line, sizeof line);
  fprintf(stderr, "thrum: warning: %s%s%s\n", warn_place != NULL ? warn_place : "",
          warn_place != NULL ? ": " : "", line);
}

/* How many letters to change, add, drop or swap with their neighbour (the restricted distance of
 * Damerau), for texts of at most NEAREST_LENGTH_MAX bytes; two rows at a time. */
static size_t edit_distance(const char *a, const char *b) {
  size_t rows[3][NEAREST_LENGTH_MAX + 1];
  const size_t length = strlen(b);
  for (size_t j = 0; j <= length; j++)
    rows[0][j] = j;

  // each row costs one more letter of a; the row before the last serves swapped neighbours
  size_t i = 0;
  for (; a[i] != 0; i++) {
    const size_t *before = rows[(i + 2) % 3], *above = rows[i % 3];
    size_t *row = rows[(i + 1) % 3];
    row[0] = i + 1;

    // the cheapest of four: change or keep a letter, drop one, add one, swap two
    for (size_t j = 1; j <= length; j++) {
      size_t best = above[j - 1] + (a[i] == b[j - 1] ? 0 : 1);
      if (above[j] + 1 < best)
        best = above[j] + 1;
      if (row[j - 1] + 1 < best)
        best = row[j - 1] + 1;
      if (i > 0 && j > 1 && a[i] == b[j - 2] && a[i - 1] == b[j - 1] && before[j - 2] + 1 < best)
        best = before[j - 2] + 1;
      row[j] = best;
    }
  }
  return rows[i % 3][length];
}

const char *config_nearest(const char *text, const char *const *names, int64_t count) {
  const char *nearest = NULL;
  size_t least = NEAREST_DISTANCE_MAX + 1;
  const size_t length = strlen(text);
  if (length == 0 || length > NEAREST_LENGTH_MAX)
    return NULL;

  // names that are too long for the distance are near to nothing
  for (int64_t n = 0; n < count; n++) {
    if (strlen(names[n]) > NEAREST_LENGTH_MAX)
      continue;
    // a short text is near to everything, so about a third may differ; a beginning is near
    const size_t distance =
        strncmp(text, names[n], length) == 0 ? 1 : edit_distance(text, names[n]);
    if (distance < least && 3 * distance <= length + 2) {
      nearest = names[n];
      least = distance;
    }
  }
  return nearest;
}

int config_usage_option(const char *command, char **argv, const struct option *options) {
  const char *text = argv[optind - 1];
  // a long option is named as typed, a short one by the letter that getopt kept
  if (strncmp(text, "--", 2) != 0) {
    for (const struct option *option = options; option->name != NULL; option++)
      if (option->val == optopt && option->has_arg == required_argument)
        return config_usage(command, "option '-%c' needs a value", optopt);
    return config_usage(command, "unknown option '-%c'", optopt);
  }

  // a long option may have its value behind '='
  char name[NEAREST_LENGTH_MAX + 1];
  const size_t length = strcspn(text + 2, "=");
  if (length > NEAREST_LENGTH_MAX)
    return config_usage(command, "unknown option '%s'", text);
  memcpy(name, text + 2, length);
  name[length] = 0;

  // an option that exists lacks its value, or has one too many; the others are unknown
  const char *names[OPTION_COUNT_MAX];
  int64_t count = 0;
  for (const struct option *option = options; option->name != NULL; option++) {
    if (strcmp(option->name, name) == 0) {
      return config_usage(command,
                          option->has_arg == required_argument ? "option '--%s' needs a value"
                                                               : "option '--%s' takes no value",
                          name);
    }
    if (count < OPTION_COUNT_MAX)
      names[count++] = option->name;
  }
  const char *nearest = config_nearest(name, names, count);
  if (nearest != NULL)
    return config_usage(command, "unknown option '--%s'; did you mean '--%s'?", name, nearest);
  return config_usage(command, "unknown option '--%s'", name);
}
