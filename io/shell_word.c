/* See shell_word.h. SPDX-License-Identifier: Apache-2.0 */
#include "io/shell_word.h"

#include <string.h>

#define PLAIN "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:,@=%+-"

void shell_word_put(FILE *stream, const char *word) {
  if (word[0] != 0 && word[strspn(word, PLAIN)] == 0) {
    fputs(word, stream);
    return;
  }
  fputc('\'', stream);
  for (const char *at = word; *at != 0; at++)
    fputs(*at == '\'' ? "'\\''" : (char[]){*at, 0}, stream);
  fputc('\'', stream);
}
