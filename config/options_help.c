/* Prints what people read of the tables: the help of a command, the reference, the manual page, and
 * what a shell completes. SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "config/options.h"

#define WIDTH 96          /* of lines of the help */
#define HEAD_MAX 30       /* wider heads have the text in the next line */
#define TEXT_MAX 1200     /* of what is said of one option */
#define FALLBACK_BRIEF 25 /* longer defaults are left to --help-all */

#define EXITS "0 done, 1 refused, 2 usage"

/* --- texts ------------------------------------------------------------------------------------ */

__attribute__((format(printf, 3, 4))) static void append(char *text, size_t size,
                                                         const char *format, ...) {
  const size_t used = strlen(text);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text + used, size - used, format, arguments);
  va_end(arguments);
}

static const char *value_name(const config_option *o) {
  static const char *const names[] = {
      [CONFIG_SWITCH] = "on|off",  [CONFIG_NUMBER] = "X",     [CONFIG_COUNT] = "N",
      [CONFIG_PAIR] = "A[,B]",     [CONFIG_VECTOR] = "X,Y,Z", [CONFIG_CHOICE] = "NAME",
      [CONFIG_WORD] = "VALUE",     [CONFIG_TEXT] = "TEXT",    [CONFIG_TEXTS] = "TEXT",
      [CONFIG_FILE] = "FILE.json",
  };
  return o->kind == CONFIG_FLAG ? "" : o->value != NULL ? o->value : names[o->kind];
}

/* "-o, --output FILE" */
static void head_text(const config_option *o, char *text, size_t size, bool align) {
  text[0] = 0;
  if (o->letter != 0)
    append(text, size, "-%c, ", o->letter);
  else if (align)
    append(text, size, "    ");
  append(text, size, "--%s%s%s", o->name, o->kind == CONFIG_FLAG ? "" : " ", value_name(o));
}

/* "a, b or c: about [UNIT]; repeatable (default FALLBACK)" */
static const char *about_text(const config_option *o, char *text, size_t size) {
  text[0] = 0;
  for (int n = 0; o->kind == CONFIG_CHOICE && o->names[n] != NULL; n++)
    append(text, size, "%s%s", n == 0 ? "" : o->names[n + 1] == NULL ? " or " : ", ", o->names[n]);
  append(text, size, "%s%s", text[0] != 0 ? ": " : "", o->about);
  if (o->unit != NULL)
    append(text, size, " [%s]", o->unit);
  if (o->repeats)
    append(text, size, "; repeatable");
  if (o->fallback != NULL)
    append(text, size, " (default %s)", o->fallback);
  return text;
}

/* Prints a text with its words wrapped at WIDTH; lines after the first begin with `indent` blanks,
 * and `column` is where the first begins. */
static void print_wrapped(const char *text, int indent, int column) {
  for (bool first = true; *text != 0; first = false) {
    const int length = (int)strcspn(text, " \n");
    if (!first && column + 1 + length > WIDTH) {
      printf("\n%*s", indent, "");
      column = indent;
    } else if (!first && column > indent) {
      putchar(' ');
      column++;
    }

    // the ends of lines in the text begin paragraphs
    printf("%.*s", length, text);
    column += length;
    text += length;
    for (; *text == ' ' || *text == '\n'; text++) {
      if (*text == '\n' && text[1] != 0) {
        printf("\n%*s", indent, "");
        column = indent;
      }
    }
  }
  putchar('\n');
}

/* Calls `line` with each line of a text, without its end. */
static void each_line(const char *text, void (*line)(const char *text, int length)) {
  while (text != NULL && *text != 0) {
    const int length = (int)strcspn(text, "\n");
    line(text, length);
    text += length + (text[length] == '\n');
  }
}

/* Calls `option` for each row and `heading` for each heading, those of groups too. */
typedef struct visitor {
  void (*heading)(const char *text);
  void (*option)(const config_option *option);
} visitor;

static void visit(const config_option *table, const visitor *v) {
  for (const config_option *o = table; o->about != NULL; o++) {
    if ((o->kind == CONFIG_HEADING || o->kind == CONFIG_GROUP) && o->about[0] != 0)
      v->heading(o->about);
    if (o->kind == CONFIG_GROUP)
      visit(o->keys, v);
    else if (o->kind != CONFIG_HEADING && !o->argument)
      v->option(o);
  }
}

/* --- help ------------------------------------------------------------------------------------- */

static int help_column;

static void measure_option(const config_option *o) {
  char head[120];
  head_text(o, head, sizeof head, true);
  const int width = (int)strlen(head);
  if (width > help_column && width <= HEAD_MAX)
    help_column = width;
}

static void no_heading(const char *text) {
  (void)text;
}

static void help_heading(const char *text) {
  printf("\n%s:\n", text);
}

static void print_option(const config_option *o, const char *text) {
  char head[120];
  head_text(o, head, sizeof head, true);
  const int indent = help_column + 4;
  if ((int)strlen(head) > help_column)
    printf("  %s\n%*s", head, indent, "");
  else
    printf("  %-*s  ", help_column, head);
  print_wrapped(text, indent, indent);
}

static void help_option(const config_option *o) {
  char text[TEXT_MAX];
  print_option(o, about_text(o, text, sizeof text));
}

/* What is said first of an option: up to a semicolon, and few names of many. */
static void help_briefly(const config_option *o) {
  char text[TEXT_MAX] = "";
  append(text, sizeof text, "%.*s", (int)strcspn(o->about, ";"), o->about);
  if (o->unit != NULL)
    append(text, sizeof text, " [%s]", o->unit);
  if (o->fallback != NULL && strlen(o->fallback) < FALLBACK_BRIEF)
    append(text, sizeof text, " (default %s)", o->fallback);
  print_option(o, text);
}

static void help_example(const char *text, int length) {
  printf("  thrum %.*s\n", length, text);
}

static void print_usage(const config_command *command) {
  const char *between = "usage:";
  for (const char *at = command->usage; *at != 0; between = "      ") {
    const int length = (int)strcspn(at, "\n");
    printf("%s thrum %s %.*s\n", between, command->name, length, at);
    at += length + (at[length] == '\n');
  }
  putchar('\n');
}

/* Is the option one of those that are used often? */
static bool is_often(const config_command *command, const config_option *o) {
  const size_t length = strlen(o->name);
  for (const char *at = command->often; *at != 0; at += strspn(at, " ")) {
    const size_t word = strcspn(at, " ");
    if (word == length && strncmp(at, o->name, length) == 0)
      return true;
    at += word;
  }
  return o->helps;
}

/* What a command does in its first sentences, the options that are used often, one example. */
static void print_short(const config_command *command) {
  config_row rows[CONFIG_OPTION_MAX];
  char about[TEXT_MAX];
  print_usage(command);
  const char *end = strstr(command->about, "\n\n");
  snprintf(about, sizeof about, "%.*s",
           end != NULL ? (int)(end - command->about) : (int)strlen(command->about), command->about);
  print_wrapped(about, 0, 0);
  putchar('\n');

  const int count = config_rows(command->options, rows);
  help_column = 0;
  for (int n = 0; n < count; n++)
    if (is_often(command, rows[n].option))
      measure_option(rows[n].option);
  for (int n = 0; n < count; n++)
    if (is_often(command, rows[n].option))
      help_briefly(rows[n].option);
  printf("\nexamples:\n");
  help_example(command->examples, (int)strcspn(command->examples, "\n"));
}

void config_print_help(const config_command *command, bool all) {
  if (command->often != NULL && !all) {
    print_short(command);
    return;
  }
  print_usage(command);
  print_wrapped(command->about, 0, 0);

  // the texts of all options begin in one column
  const visitor measure = {no_heading, measure_option}, print = {help_heading, help_option};
  help_column = 0;
  visit(command->options, &measure);
  // a heading brings its own blank line
  const config_option *first = command->options;
  if ((first->kind != CONFIG_HEADING && first->kind != CONFIG_GROUP) || first->about[0] == 0)
    putchar('\n');
  visit(command->options, &print);
  if (command->notes != NULL)
    printf("\n%s", command->notes);
  fputs("\nexamples:\n", stdout);
  each_line(command->examples, help_example);
  printf("\nexit codes: %s\n", command->exits != NULL ? command->exits : EXITS);
}

/* --- Markdown --------------------------------------------------------------------------------- */

/* A cell of a table: '|' ends it, and '<' and '*' mean something. */
static void print_cell(const char *text) {
  for (; *text != 0; text++) {
    if (strchr("|<*_[\\", *text) != NULL)
      putchar('\\');
    putchar(*text);
  }
}

static void markdown_heading(const char *text) {
  printf("| **");
  print_cell(text);
  printf("** | | | |\n");
}

static void markdown_option(const config_option *o) {
  char head[120], wants[300], text[TEXT_MAX] = "";
  head_text(o, head, sizeof head, false);
  printf("| `");
  for (const char *c = head; *c != 0; c++)
    printf(*c == '|' ? "\\|" : "%c", *c);
  printf("` | ");
  print_cell(o->kind == CONFIG_FLAG ? "" : config_wants(o, wants, sizeof wants));
  printf(" | ");
  print_cell(o->fallback != NULL ? o->fallback : "");
  append(text, sizeof text, "%s%s", o->about, o->repeats ? "; repeatable" : "");
  printf(" | ");
  print_cell(text);
  printf(" |\n");
}

static void plain_example(const char *text, int length) {
  printf("thrum %.*s\n", length, text);
}

void config_print_markdown(const config_command *command) {
  const visitor v = {markdown_heading, markdown_option};
  printf("\n## thrum %s\n\n```\n", command->name);
  for (const char *at = command->usage; *at != 0;) {
    const int length = (int)strcspn(at, "\n");
    printf("thrum %s %.*s\n", command->name, length, at);
    at += length + (at[length] == '\n');
  }
  printf("```\n\n");
  print_wrapped(command->about, 0, 0);
  printf("\n| option | takes | default | meaning |\n|---|---|---|---|\n");
  visit(command->options, &v);

  // notes and examples stay as they are
  if (command->notes != NULL)
    printf("\n```\n%s```\n", command->notes);
  printf("\n```sh\n");
  each_line(command->examples, plain_example);
  printf("```\n\nExit codes: %s.\n", command->exits != NULL ? command->exits : EXITS);
}

/* The name of a key as a file has it. */
static void print_key(const char *name) {
  for (; *name != 0; name++)
    putchar(*name == '-' ? '_' : *name);
}

static void key_row(const config_option *o) {
  char wants[300], text[TEXT_MAX] = "";
  printf("| `");
  print_key(o->name);
  printf("` | ");
  print_cell(o->kind == CONFIG_SWITCH ? "true or false" : config_wants(o, wants, sizeof wants));
  printf(" | %s | ", o->unit != NULL ? o->unit : "");
  print_cell(o->needed ? "must be there" : o->fallback != NULL ? o->fallback : "");
  append(text, sizeof text, "%s", o->about);
  printf(" | ");
  print_cell(text);
  printf(" |\n");
}

void config_print_keys(const char *title, const config_option *keys) {
  const visitor v = {markdown_heading, key_row};
  config_row rows[CONFIG_OPTION_MAX];
  printf("\n## %s\n\n| key | takes | unit | default | meaning |\n|---|---|---|---|---|\n", title);
  const visitor flat = {no_heading, v.option};
  visit(keys, &flat);

  // records within the record follow, each with its own table
  const int count = config_rows(keys, rows);
  for (int n = 0; n < count; n++)
    if (rows[n].option->kind == CONFIG_OBJECT || rows[n].option->kind == CONFIG_LIST)
      config_print_keys(rows[n].option->name, rows[n].option->keys);
}

/* --- manual page ------------------------------------------------------------------------------ */

static void print_troff(const char *text, int length) {
  if (length > 0 && (text[0] == '.' || text[0] == '\''))
    printf("\\&");
  for (int n = 0; n < length; n++)
    printf(text[n] == '\\' ? "\\e" : text[n] == '-' ? "\\-" : "%c", text[n]);
}

static void troff_line(const char *text, int length) {
  print_troff(text, length);
  putchar('\n');
}

static void man_heading(const char *text) {
  printf(".PP\n");
  troff_line(text, (int)strlen(text));
}

static void man_option(const config_option *o) {
  char head[120], text[TEXT_MAX];
  head_text(o, head, sizeof head, false);
  printf(".TP\n.B ");
  troff_line(head, (int)strlen(head));
  about_text(o, text, sizeof text);
  troff_line(text, (int)strlen(text));
}

static void man_example(const char *text, int length) {
  printf("thrum ");
  print_troff(text, length);
  putchar('\n');
}

void config_print_man(const config_command *command) {
  const visitor v = {man_heading, man_option};
  printf(".SH THRUM %s\n", command->name);
  for (const char *at = command->usage; *at != 0;) {
    const int length = (int)strcspn(at, "\n");
    printf(".br\n.B thrum %s\n", command->name);
    troff_line(at, length);
    at += length + (at[length] == '\n');
  }
  printf(".PP\n");
  each_line(command->about, troff_line);
  visit(command->options, &v);

  // notes and examples keep their lines
  if (command->notes != NULL) {
    printf(".PP\n.nf\n");
    each_line(command->notes, troff_line);
    printf(".fi\n");
  }
  printf(".PP\nExamples:\n.PP\n.nf\n");
  each_line(command->examples, man_example);
  printf(".fi\n.PP\nExit codes: %s.\n", command->exits != NULL ? command->exits : EXITS);
}

/* --- completion ------------------------------------------------------------------------------- */

void config_print_completion(const config_command *command) {
  config_row rows[CONFIG_OPTION_MAX];
  const int count = config_rows(command->options, rows);
  for (int n = 0; n < count; n++) {
    const config_option *o = rows[n].option;
    if (o->kind != CONFIG_CHOICE && o->kind != CONFIG_SWITCH)
      continue;
    printf("  '%s --%s') words='", command->name, o->name);
    for (int k = 0; o->kind == CONFIG_CHOICE && o->names[k] != NULL; k++)
      printf("%s%s", k > 0 ? " " : "", o->names[k]);
    printf("%s' ;;\n", o->kind == CONFIG_SWITCH ? "on off" : "");
  }

  // whatever else stands before: the options of the command
  printf("  '%s '*) words='", command->name);
  for (int n = 0; n < count; n++)
    if (!rows[n].option->argument)
      printf("%s--%s", n > 0 ? " " : "", rows[n].option->name);
  printf("' ;;\n");
}
