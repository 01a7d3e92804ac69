/* Draws files and command lines from the tables of options (config/options.h): most of what is
 * drawn is right, so that readers are reached behind their first checks, and some of it is spoiled.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_FUZZ_FUZZ_TABLE_H
#define THRUM_TESTS_FUZZ_FUZZ_TABLE_H

#include <stdarg.h>
#include <stdio.h>

#include "config/options.h"
#include "tests/fuzz/fuzz_draw.h"

#define DRAWN_BYTES 16384
#define DRAWN_DEPTH 5

typedef struct drawn_text {
  char bytes[DRAWN_BYTES];
  size_t used;
} drawn_text;

/* Adds to the text as long as there is room. */
__attribute__((format(printf, 2, 3))) static inline void drawn_add(drawn_text *text,
                                                                   const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const size_t left = sizeof text->bytes - text->used;
  const int length = vsnprintf(text->bytes + text->used, left, format, arguments);
  va_end(arguments);
  text->used += (size_t)length < left ? (size_t)length : left - 1;
}

/* One of 16 draws spoils what it is about. */
static inline bool draw_spoils(fuzz_draw *draw) {
  return draw_byte(draw) >= 240;
}

/* Texts that some option takes: names, files, meshes, loads, starts, motions, targets, vertices. */
static inline void draw_words(fuzz_draw *draw, char *text, size_t size) {
  static const char *const words[] = {"body1",
                                      "a",
                                      "beam",
                                      "tower",
                                      "m.npz",
                                      "beam:1x1x1@1x1x1",
                                      "part.veg",
                                      "s.obj",
                                      "run",
                                      "made.npz",
                                      "q.npy",
                                      "path.csv",
                                      "frame.vtu",
                                      "all",
                                      "tip",
                                      "none",
                                      "surface",
                                      "vertex=1",
                                      "impulse:1,2,3@all",
                                      "constant:0,0,-1@tip",
                                      "sine:0,0,1@vertex=2,f=2,from=1,until=2",
                                      "square:1,0,0@all,until=1",
                                      "gravity:0,0,-9.81",
                                      "traction:0,0,1@top,from=1",
                                      "mode:1,0.1",
                                      "static:gravity:0,0,-1",
                                      "sine:1,0,0,f=2",
                                      "quake.csv,scale=2",
                                      "x<0.001",
                                      "x<0.1&&y>0",
                                      "left",
                                      "held.bou:x",
                                      "#aabbcc",
                                      "#AABB0",
                                      "0,0,1@tip",
                                      "0,-20,0@all",
                                      "steel:2e11,0.3,7800",
                                      "5%",
                                      "every-3",
                                      "60",
                                      "cfl",
                                      "sampling",
                                      "mm-t-s",
                                      "m-kg-s",
                                      "base-motion:sine:3,0,0,f=2",
                                      "start:mode:1,0.3",
                                      "a;b",
                                      ""};
  snprintf(text, size, "%s", words[draw_index(draw, sizeof words / sizeof *words)]);

  // a byte of it becomes another, or it ends early, or begins anew
  const size_t length = strlen(text);
  if (!draw_spoils(draw) || length == 0)
    return;
  const size_t at = (size_t)draw_index(draw, (int64_t)length);
  const unsigned byte = draw_byte(draw);
  if (byte % 3 == 0)
    text[at] = 0;
  else if (byte % 3 == 1 && 2 * length < size)
    memmove(text + length, text, length + 1);
  else if (byte != 0)
    text[at] = (char)byte;
}

static inline double draw_in_range(fuzz_draw *draw, const config_option *option) {
  const bool limited = option->least != 0 || option->most != 0;
  const double least = limited ? option->least : -100;
  const double most = limited && isfinite(option->most) ? option->most : fabs(least) + 100;
  if (draw_spoils(draw))
    return draw_any(draw);
  const double value = least + (most - least) * (draw_byte(draw) + 1) / 258;
  return option->kind == CONFIG_COUNT ? floor(fmin(value, least + draw_byte(draw))) : value;
}

/* A value of an option as it stands on a command line. */
static inline void draw_value_text(fuzz_draw *draw, const config_option *option, char *text,
                                   size_t size) {
  const unsigned which = draw_byte(draw);
  int names = 0;
  switch (option->kind) {
  case CONFIG_SWITCH:
    snprintf(text, size, "%s", which % 2 ? "on" : "off");
    return;
  case CONFIG_NUMBER:
  case CONFIG_COUNT:
    snprintf(text, size, "%.9g", draw_in_range(draw, option));
    return;
  case CONFIG_PAIR:
    snprintf(text, size, which % 2 ? "%.9g" : "%.9g,%.9g", draw_in_range(draw, option),
             draw_in_range(draw, option));
    return;
  case CONFIG_VECTOR:
    snprintf(text, size, "%.9g,%.9g,%.9g", draw_in_range(draw, option), draw_in_range(draw, option),
             draw_in_range(draw, option));
    return;
  case CONFIG_CHOICE:
    while (option->names[names] != NULL)
      names++;
    snprintf(text, size, "%s", option->names[which % (unsigned)names]);
    return;
  default:
    draw_words(draw, text, size);
  }
}

static inline void draw_record(fuzz_draw *draw, const config_option *keys, bool dashes, int depth,
                               drawn_text *out);

/* JSON that no option wants. */
static inline void draw_odd_json(fuzz_draw *draw, drawn_text *out) {
  // well-formed of another type, numbers out of range, and what is no JSON
  static const char *const odd[] = {"null",
                                    "[]",
                                    "{}",
                                    "true",
                                    "\"\"",
                                    "-0",
                                    "1e999",
                                    "[[[[]]]]",
                                    "\"\\u0000\"",
                                    "\"\\ud800\"",
                                    "[1,2]",
                                    "{\"a\":{\"a\":1}}",
                                    "12345678901234567890",
                                    "[true]",
                                    "\"x\\n\"",
                                    "",
                                    ",",
                                    "}"};

  drawn_add(out, "%s", odd[draw_index(draw, sizeof odd / sizeof *odd)]);
}

static inline void draw_value_json(fuzz_draw *draw, const config_option *option, bool dashes,
                                   int depth, drawn_text *out) {
  char text[256];
  if (draw_spoils(draw)) {
    draw_odd_json(draw, out);
    return;
  }

  const unsigned which = draw_byte(draw);
  switch (option->kind) {
  case CONFIG_FLAG:
  case CONFIG_SWITCH:
    drawn_add(out, which % 2 ? "true" : "false");
    return;
  case CONFIG_NUMBER:
  case CONFIG_COUNT:
    drawn_add(out, "%.9g", draw_in_range(draw, option));
    return;
  case CONFIG_VECTOR:
  case CONFIG_PAIR:
    draw_value_text(draw, option, text, sizeof text);
    drawn_add(out, strchr(text, ',') != NULL ? "[%s]" : "%s", text);
    return;
  case CONFIG_OBJECT:
    if (depth < DRAWN_DEPTH)
      draw_record(draw, option->keys, dashes, depth + 1, out);
    else
      draw_odd_json(draw, out);
    return;
  case CONFIG_TEXTS:
  case CONFIG_LIST:
    drawn_add(out, "[");
    for (unsigned n = 0; n < which % 4; n++) {
      drawn_add(out, n > 0 ? "," : "");
      if (option->kind == CONFIG_LIST && depth < DRAWN_DEPTH) {
        draw_record(draw, option->keys, dashes, depth + 1, out);
      } else {
        draw_words(draw, text, sizeof text);
        drawn_add(out, "\"%s\"", text);
      }
    }
    drawn_add(out, "]");
    return;
  case CONFIG_WORD:
    // a number, a list of them, or a rotation
    if (which % 4 != 0) {
      static const char *const forms[] = {"%d", "[1,0,%d]", "[1,0,0,%d]",
                                          "{\"axis\":[0,0,1],\"angle\":%d}"};
      const int number = (int)draw_byte(draw) - 2;
      switch (which / 4 % 4) {
      case 0:
        drawn_add(out, forms[0], number);
        return;
      case 1:
        drawn_add(out, forms[1], number);
        return;
      case 2:
        drawn_add(out, forms[2], number);
        return;
      default:
        drawn_add(out, forms[3], number);
        return;
      }
    }
    draw_words(draw, text, sizeof text);
    drawn_add(out, "\"%s\"", text);
    return;
  default:
    draw_value_text(draw, option, text, sizeof text);
    drawn_add(out, "\"%s\"", text);
  }
}

/* An object with keys of the table: those that are needed, and some of the others. */
static inline void draw_record(fuzz_draw *draw, const config_option *keys, bool dashes, int depth,
                               drawn_text *out) {
  config_row rows[CONFIG_OPTION_MAX];
  const int count = config_rows(keys, rows);
  bool first = true;
  drawn_add(out, "{");
  for (int n = 0; n < count; n++) {
    const config_option *option = rows[n].option;
    const unsigned byte = draw_byte(draw);
    if (option->kind == CONFIG_FILE || option->letter == 'h')
      continue;
    if (option->needed ? byte >= 250 : byte % 4 != 1)
      continue;

    // either spelling is right, a letter too many is not, and twice is once too often
    for (int twice = 0; twice < (byte == 5 ? 2 : 1); twice++) {
      drawn_add(out, first ? "\"" : ",\n\"");
      for (const char *c = option->name; *c != 0; c++)
        drawn_add(out, "%c", *c == '-' && !dashes ? '_' : *c);
      drawn_add(out, byte == 9 ? "x\":" : "\":");
      draw_value_json(draw, option, dashes, depth, out);
      first = false;
    }
  }
  drawn_add(out, "}");
}

#endif
