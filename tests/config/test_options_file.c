/* Options files mean the same as the command line, yield to it, and name the line of a mistake; the
 * committed schemas equal the program's.
 * SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "tests/support/test_folder.h"

static void write_file(const char *name, const char *text) {
  char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  assert_true(text_file_write(path, text));
}

static bool is_there(const char *name) {
  char path[128];
  snprintf(path, sizeof path, "%s/%s", folder, name);
  return file_exists(path);
}

static cJSON *run_done(program_result run) {
  if (run.exit_code != 0)
    fail_msg("exit %d: %s", run.exit_code, run.err);
  cJSON *object = cJSON_Parse(run.out);
  assert_non_null(object);
  program_result_free(&run);
  return object;
}

static double number(const cJSON *object, const char *key) {
  const cJSON *item = cJSON_GetObjectItem(object, key);
  assert_true(cJSON_IsNumber(item));
  return item->valuedouble;
}

static int make_model(void **state) {
  (void)state;
  if (test_folder_make(folder) == NULL)
    return -1;

  // a folder of its own, so that paths in the file are relative to the file
  char path[128];
  snprintf(path, sizeof path, "%s/sub", folder);
  if (mkdir(path, 0777) != 0)
    return -1;

  // every kind of value: texts, lists, numbers, flags
  write_file("sub/p.json", "{\"mesh\": \"m.veg\", \"output\": \"b.npz\", \"fix\": [\"held.bou\"],\n"
                           "\"young\": 2e6, \"modes\": 4.0, \"rank\": 6, \"json\": true,\n"
                           "\"dry_run\": false, \"mass\": \"lumped\", \"quiet\": true}\n");

  // the mesh, and the vertices of its face at x = 0, which is all that the file holds
  program_result run = thrum_run(folder, "convert", "beam:4x2x2@1x0.3x0.3", "sub/m.veg", NULL);
  const bool made = run.exit_code == 0;
  program_result_free(&run);
  write_file("sub/held.bou", "1, 2, 3, 4, 5, 6, 7, 8, 9\n");

  // a model made from the options file alone
  run = thrum_run(folder, "precompute", "--options", "sub/p.json", NULL);
  if (run.exit_code != 0)
    print_error("%s", run.err);
  const bool good = made && run.exit_code == 0;

  program_result_free(&run);
  return good ? 0 : -1;
}

static int remove_model(void **state) {
  (void)state;
  test_folder_remove(folder);
  return 0;
}

static void paths_are_relative_to_the_file(void **state) {
  (void)state;
  assert_true(is_there("sub/b.npz"));
  assert_false(is_there("b.npz"));
  write_file(
      "sub/s.json",
      "{\"model\": \"b.npz\", \"output\": \"run\", \"time\": 0.03,\n"
      "\"start\": [\"mode:1,0.01\"], \"json\": true, \"adaptive\": false,\n"
      "\"damping\": [0.1, 0.001], \"integrator\": \"imexv\", \"split\": 3, \"quiet\": true}");

  // the model is found beside the file, and the run is written there
  cJSON *object = run_done(thrum_run(folder, "simulate", "--options", "sub/s.json", NULL));
  assert_true(number(object, "steps") == 10);
  cJSON_Delete(object);
  assert_true(is_there("sub/run/run.json"));

  // a start that is a file is looked up beside the options file as well
  write_file("sub/again.json", "{\"model\": \"b.npz\", \"output\": \"run2\", \"time\": 0.03,\n"
                               "\"start\": \"run/end.npy\", \"json\": true}");
  cJSON_Delete(run_done(thrum_run(folder, "simulate", "--options", "sub/again.json", NULL)));
}

static void a_table_of_base_motion_lies_beside_the_file(void **state) {
  (void)state;

  // four modes cannot show a jolt of so short a time
  write_file("sub/base.csv", "0,0,0,0\n0.02,0,0,1\n0.04,0,0,0\n");
  write_file("sub/base_motion.json",
             "{\"model\": \"b.npz\", \"output\": \"shaken\", \"time\": 0.03,\n"
             "\"base-motion\": [\"base.csv\", \"sine:0,0,1,f=2\"], \"json\": true,\n"
             "\"accept-error\": \"100%\"}");
  cJSON_Delete(run_done(thrum_run(folder, "simulate", "--options", "sub/base_motion.json", NULL)));
}

static void an_equilibrium_takes_its_options_from_a_file_too(void **state) {
  (void)state;
  write_file("sub/e.json", "{\"model\": \"b.npz\", \"output\": \"sag.npy\", \"json\": true,\n"
                           "\"load\": \"gravity:0,0,-1\", \"factor\": 2, \"at\": [\"vertex=5\"]}");
  cJSON_Delete(run_done(thrum_run(folder, "static", "--options", "sub/e.json", NULL)));
  assert_true(is_there("sub/sag.npy"));
}

static void the_command_line_comes_first(void **state) {
  (void)state;

  // a run of 0.06 s, too short for what four modes show well
  write_file("over.json", "{\"model\": \"no.npz\", \"output\": \"one\", \"time\": 0.03,\n"
                          "\"load\": [\"constant:0,0,-1@nowhere\"], \"json\": true,\n"
                          "\"accept-error\": \"100%\"}");
  cJSON *object =
      run_done(thrum_run(folder, "simulate", "sub/b.npz", "--options", "over.json", "--time",
                         "0.06", "--load", "gravity:0,0,-1", "-o", "two", NULL));
  assert_true(number(object, "steps") == 20);
  cJSON_Delete(object);
  assert_true(is_there("two/run.json"));
  assert_false(is_there("one"));
}

static void a_mistake_is_named_by_file_line_and_key(void **state) {
  (void)state;
  static const struct {
    const char *command, *text, *words;
  } cases[] = {
      // unknown keys and ranges of precompute's values
      {"precompute", "{\n\n\"yuong\": 1}",
       "t.json:3: the file has no key \"yuong\"; did you mean \"young\"?"},
      {"precompute", "{\n\"young\": -1}",
       "t.json:2: young: wants a number from 1e-30 to 1e+30 Pa, not -1"},
      {"precompute", "{\n\"poisson\": 0.5}",
       "t.json:2: poisson: wants a number above -1 and below 0.5, not 0.5"},
      {"precompute", "{\"density\": 0}", "t.json:1: density: wants a number from 1e-30"},
      {"precompute", "{\"scale\": 0}", "t.json:1: scale: wants a number above 0, not 0"},
      {"precompute",
       "{\"mesh\": \"beam:2x2x2@1x1x1\", \"dry-run\": true, \"quiet\": true,\n"
       "\"fix\": [\"x<0.1\",\n\"y>\"]}",
       "t.json:3: fix: 'y>' is no predicate"},
      {"precompute",
       "{\"mesh\": \"beam:2x2x2@1x1x1\", \"fix\": \"x<0.1\", \"output\": \"h.npz\",\n"
       "\"quiet\": true,\n\"handles\": [\n\"nogroup\"]}",
       "t.json:4: handles: "},

      // unknown and repeated keys, and types of simulate's values
      {"simulate", "{\"help\": true}",
       "t.json:1: the file has no key \"help\" (try: thrum simulate --help)"},
      {"simulate", "{\"options\": \"x\"}", "t.json:1: the file has no key \"options\""},
      {"simulate", "{\n\"dt\": \"0.1\"}", "t.json:2: dt: wants a number above 0 s, not \"0.1\""},
      {"simulate", "{\n\"dt\": -1}", "t.json:2: dt: wants a number above 0 s, not -1"},
      {"simulate", "{\"dt\": 1e400}", "dt: wants a number above 0 s, not 1e400"},
      {"simulate", "{\"rank\": 2.5}", "rank: wants a whole number from 1 to 512, not 2.5"},
      {"simulate", "{\"dt\": 1,\n\"dt\": 2}", "t.json:2: \"dt\" is there twice; first in line 1"},
      {"simulate", "{\"record_every\": 1,\n\"record-every\": 2}",
       "t.json:2: record-every: it is there twice, in two spellings; first in line 1"},
      {"simulate", "{\"dt\": 1,\n}", "t.json:2: a comma stands before '}'"},
      {"simulate", "{\"dt\": null}", "dt: wants a number above 0 s, not null"},
      {"simulate", "{\"quiet\": 1}", "quiet: wants true or false, not 1"},
      {"simulate", "{\"fallback\": 1}", "fallback: wants true or false, not 1"},
      {"simulate", "{\"integrator\": \"imex\"}", "integrator: wants imexv, newmark"},
      {"simulate", "{\"damping\": [1]}", "damping: wants A, or A and B"},
      {"simulate", "{\"damping\": [1, \"2\"]}", "damping: wants A, or A and B"},
      {"simulate", "{\"load\": [\n\"impulse:1\"]}", "t.json:2: load[0]: "},
      {"simulate", "{\"load\": [[]]}", "load[0]: wants a text, not a list"},
      {"simulate", "{\"output\": [\"a\"]}", "output: wants a text, not a list"},

      // control characters in keys and texts
      {"simulate", "{\"dt\\nx\" 1}", "t.json:1: expected ':' after the key"},
      {"simulate", "{\"dt\\nx\": 1}", "t.json:1: the file has no key \"dt"},
      {"simulate", "{\"integrator\": \"a\\nb\"}", "integrator: wants"},
      {"simulate", "{\"load\": \"a\\nb\"}", "load: "},
      {"simulate", "{\"start\": \"mode:\\n\"}", "start: "},

      // texts that are no JSON object
      {"simulate", "", "t.json:1: expected a value, not the end of the file"},
      {"simulate", "[]", "t.json:1: options stand in { }"},
      {"simulate", "// x\n{}", "t.json:1: JSON has no comments"},
      {"simulate", "{\n\"load\": \"\xff\"}", "t.json:2: byte 0xff does not belong in a text"},
      {"simulate", "\xff\xfe{", "t.json"},
      {"simulate", "{\"a\": [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
       "t.json:1: nested more than 32 deep"}};

  // one line on standard error, nothing on standard output
  for (size_t n = 0; n < sizeof cases / sizeof *cases; n++) {
    write_file("t.json", cases[n].text);
    program_result run = thrum_run(folder, cases[n].command, "--options", "t.json", NULL);
    if (run.exit_code != 1 || strstr(run.err, cases[n].words) == NULL)
      fail_msg("%s: exit %d, %s", cases[n].text, run.exit_code, run.err);
    assert_true(line_count_is(run.err, 1));
    assert_string_equal(run.out, "");
    program_result_free(&run);
  }
}

static void files_that_cannot_be_read_are_refused(void **state) {
  (void)state;

  // a file beyond the limit of size
  char *huge = malloc(1100001);
  assert_non_null(huge);
  memset(huge, ' ', 1100000);
  huge[1100000] = 0;
  write_file("huge.json", huge);
  free(huge);

  // the message names the file and the reason
  const char *const names[] = {"huge.json", "sub", "nothing.json"};
  const char *const words[] = {"huge.json: 1100000 bytes", "sub: cannot be read: it is a folder",
                               "nothing.json: cannot be read: No such file"};
  for (int n = 0; n < 3; n++) {
    program_result run = thrum_run(folder, "simulate", "--options", names[n], NULL);
    assert_int_equal(run.exit_code, 1);
    assert_non_null(strstr(run.err, words[n]));
    assert_true(line_count_is(run.err, 1));
    program_result_free(&run);
  }
}

static void a_message_is_one_line_whatever_was_typed(void **state) {
  (void)state;
  static const char *const cases[][5] = {{"simulate", "sub/b.npz", "--load", "a\nb"},
                                         {"simulate", "sub/b.npz", "--start", "mode:\n"},
                                         {"simulate", "sub/b.npz", "--dt", "1\n2"},
                                         {"simulate", "a\nb", "-o", "r"},
                                         {"precompute", "sub/m.veg", "--fix", "a\nb", "--dry-run"},
                                         {"info", "a\nb"},
                                         {"in\nfo"},
                                         {"info", "--a\nb"}};

  // control characters are replaced, so that the message stays in one line
  for (size_t n = 0; n < sizeof cases / sizeof cases[0]; n++) {
    const char *const *c = cases[n];
    program_result run = thrum_run(folder, c[0], c[1], c[2], c[3], c[4], NULL);
    assert_true(run.exit_code == 1 || run.exit_code == 2);
    if (!line_count_is(run.err, 1))
      fail_msg("case %d: %s", (int)n, run.err);
    program_result_free(&run);
  }
}

static void a_byte_order_mark_is_skipped(void **state) {
  (void)state;
  write_file("bom.json", "\xef\xbb\xbf{\"mesh\": \"beam:2x2x2@1x1x1\", \"fix\": \"x<0.1\",\r\n"
                         "\"dry-run\": true, \"json\": true}\r\n");
  cJSON_Delete(run_done(thrum_run(folder, "precompute", "--options", "bom.json", NULL)));
}

static void one_file_at_a_time(void **state) {
  (void)state;
  program_result run = thrum_run(folder, "simulate", "--options", "a", "--options", "b", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "one --options at a time"));
  program_result_free(&run);
}

/* Whether --NAME is followed in the help by a character that ends a name. */
static bool helps_with(const char *help, const char *name) {
  char option[80];
  snprintf(option, sizeof option, "--%s", name);
  for (const char *at = strstr(help, option); at != NULL; at = strstr(at + 1, option)) {
    const char next = at[strlen(option)];
    if (next == ' ' || next == '\n' || next == ',')
      return true;
  }
  return false;
}

static void check_schema(const char *command, const char *argument) {
  // the committed schema equals the one that the program prints
  char path[256];
  snprintf(path, sizeof path, THRUM_TEST_DATA "/../../docs/schema/%s.schema.json", command);
  char *committed = text_file_read(path);
  assert_non_null(committed);
  program_result made = thrum_run(folder, "schema", command, NULL);
  assert_int_equal(made.exit_code, 0);

  // if this fails: thrum schema COMMAND > docs/schema/COMMAND.schema.json
  assert_string_equal(committed, made.out);

  // every key of the schema is an option in the help
  program_result help = thrum_run(folder, command, "--help-all", NULL);
  cJSON *schema = cJSON_Parse(made.out);
  int keys = 0;
  for (cJSON *key = cJSON_GetObjectItem(schema, "properties")->child; key; key = key->next) {
    if (strcmp(key->string, "$schema") == 0 || strcmp(key->string, argument) == 0)
      continue;
    keys++;
    if (!helps_with(help.out, key->string))
      fail_msg("thrum %s --help does not name --%s", command, key->string);
  }

  // every option that the help lists, "      --name" or "  -n, --name", is in the schema
  for (const char *at = help.out; (at = strstr(at, " --")) != NULL;) {
    char name[40];
    const bool listed =
        at - help.out > 6 && (memcmp(at - 6, "\n     ", 6) == 0 || memcmp(at - 6, "\n  -", 4) == 0);
    at += 3;
    if (!listed)
      continue;
    const size_t length = strspn(at, "abcdefghijklmnopqrstuvwxyz-");
    snprintf(name, sizeof name, "%.*s", (int)length, at);
    if (strncmp(name, "help", 4) != 0 && strcmp(name, "options") != 0 &&
        cJSON_GetObjectItem(cJSON_GetObjectItem(schema, "properties"), name) == NULL)
      fail_msg("the schema of thrum %s does not know %s", command, name);
  }

  // the loop compared something
  assert_true(keys > 10);

  cJSON_Delete(schema);
  program_result_free(&help);
  program_result_free(&made);
  free(committed);
}

static void the_committed_schemas_are_those_of_the_program(void **state) {
  (void)state;
  check_schema("precompute", "mesh");
  check_schema("simulate", "model");
  check_schema("static", "model");
  program_result run = thrum_run(folder, "schema", "simulat", NULL);
  assert_int_equal(run.exit_code, 2);
  assert_non_null(strstr(run.err, "did you mean 'simulate'"));
  program_result_free(&run);
}

static void help_shows_what_is_used_often_on_one_screen(void **state) {
  (void)state;
  static const struct {
    const char *name;
    int options; /* named as used often, and the two of the help */
  } commands[] = {{"simulate", 13}, {"precompute", 11}, {"static", 8}, {"tradeoff", 8}};
  for (size_t n = 0; n < sizeof commands / sizeof commands[0]; n++) {
    program_result often = thrum_run(folder, commands[n].name, "--help", NULL);
    program_result all = thrum_run(folder, commands[n].name, "--help-all", NULL);
    assert_int_equal(often.exit_code, 0);
    assert_int_equal(all.exit_code, 0);
    int options = 0, lines = 0;
    for (const char *at = often.out; *at != 0; at += strcspn(at, "\n") + 1, lines++) {
      const char *name = strstr(at, "--");
      if (strncmp(at, "      --", 8) != 0 && strncmp(at, "  -", 3) != 0)
        continue;
      char option[40];
      snprintf(option, sizeof option, "%.*s", (int)strspn(name, "abcdefghijklmnopqrstuvwxyz-"),
               name);
      assert_true(helps_with(all.out, option + 2));
      options++;
    }
    assert_int_equal(options, commands[n].options);
    assert_true(lines <= 30);
    assert_true(strlen(all.out) > 2 * strlen(often.out));
    program_result_free(&often);
    program_result_free(&all);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(paths_are_relative_to_the_file),
      cmocka_unit_test(a_table_of_base_motion_lies_beside_the_file),
      cmocka_unit_test(an_equilibrium_takes_its_options_from_a_file_too),
      cmocka_unit_test(the_command_line_comes_first),
      cmocka_unit_test(a_mistake_is_named_by_file_line_and_key),
      cmocka_unit_test(files_that_cannot_be_read_are_refused),
      cmocka_unit_test(a_message_is_one_line_whatever_was_typed),
      cmocka_unit_test(a_byte_order_mark_is_skipped),
      cmocka_unit_test(one_file_at_a_time),
      cmocka_unit_test(help_shows_what_is_used_often_on_one_screen),
      cmocka_unit_test(the_committed_schemas_are_those_of_the_program),
  };
  return cmocka_run_group_tests(tests, make_model, remove_model);
}
