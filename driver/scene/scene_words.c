/* Messages of what a scene has done, in the words of scene files.
 * SPDX-License-Identifier: Apache-2.0 */
#include "driver/scene/scene_words.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define MESSAGE_MAX 1200 /* longer ones stay as they are */
#define NAME_LETTERS "abcdefghijklmnopqrstuvwxyz-"

/* Options whose keys in a scene file have another name; all others have that of the option, with
 * '_'. */
static const char *const renamed[][2] = {{"material", "regions"}, {"load", "loads"}};

/* Options with a key of a scene, of a body or of its material. */
static const char *const keys[] = {
    "fix",          "young",      "poisson",      "density",  "law",
    "yield",        "creep",      "rank",         "condense", "largest-plastic-strain",
    "start",        "spin",       "base-motion",  "dt",       "time",
    "integrator",   "damping",    "damping-form", "split",    "split-form",
    "safety",       "adaptive",   "fallback",     "newmark",  "solver",
    "tolerance",    "iterations", "stress",       "frames",   "frequency-matching",
    "record-every", "monitor",    "accept-error", "judge",    "untrained-flow",
};

/* The key of an option, `length` bytes; false where scenes have none. */
static bool find_key(const char *option, size_t length, char key[40]) {
  const char *name = NULL;
  for (size_t n = 0; n < sizeof renamed / sizeof renamed[0] && name == NULL; n++)
    if (strlen(renamed[n][0]) == length && memcmp(renamed[n][0], option, length) == 0)
      name = renamed[n][1];
  for (size_t n = 0; n < sizeof keys / sizeof keys[0] && name == NULL; n++)
    if (strlen(keys[n]) == length && memcmp(keys[n], option, length) == 0)
      name = keys[n];
  if (name == NULL)
    return false;

  // files spell names with '_'
  snprintf(key, 40, "%s", name);
  for (char *c = key; *c != 0; c++)
    *c = *c == '-' ? '_' : *c;
  return true;
}

/* Whether a word begins here, and not in the middle of one. */
static bool begins(const char *message, const char *at, const char *word) {
  return strncmp(at, word, strlen(word)) == 0 &&
         (at == message || strchr(" ('`\"", at[-1]) != NULL);
}

/* Whether the words of a command begin here, whose options are its own. */
static bool is_command(const char *message, const char *at) {
  return begins(message, at, "precompute ") || begins(message, at, "thrum ");
}

void scene_words(char *message, size_t size) {
  char made[MESSAGE_MAX];
  size_t used = 0;
  bool command = false;
  if (strlen(message) >= sizeof made / 2 || size > sizeof made)
    return;

  for (const char *at = message; *at != 0 && used + 80 < sizeof made;) {
    // a command ends with its clause
    command = is_command(message, at) || (command && strchr("`);:", *at) == NULL);
    const size_t length = begins(message, at, "--") ? strspn(at + 2, NAME_LETTERS) : 0;
    char key[40];
    if (length == 0 || length >= sizeof key || command) {
      made[used++] = *at++;
      continue;
    }
    used += (size_t)(find_key(at + 2, length, key)
                         ? snprintf(made + used, sizeof made - used, "\"%s\"", key)
                         : snprintf(made + used, sizeof made - used, "thrum precompute --%.*s",
                                    (int)length, at + 2));
    at += 2 + length;
  }
  made[used] = 0;
  snprintf(message, size, "%s", made);
}
