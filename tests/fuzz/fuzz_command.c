/* Fuzz target of the options of simulate, static and precompute: command lines and options files
 * that are drawn from their tables.
 *
 * sources: driver/run/simulate_options.c driver/statics/static_options.c
 * driver/model/mesh_of_model.c driver/make/precompute_request.c driver/spec/job_list.c
 * driver/spec/shared_options.c driver/spec/basis_asked.c driver/spec/damping_spec.c
 * config/options.c config/options_json.c config/options_command.c config/parse.c
 * config/message_error.c driver/spec/load_spec.c mesh/vertex_places.c
 * driver/spec/base_motion_spec.c driver/spec/actuate_spec.c driver/spec/start_spec.c
 * driver/make/mesh_model.c driver/make/about.c
 * driver/make/named_model.c driver/spec/model_names.c driver/spec/region_material.c
 * driver/spec/region_elastic.c mesh/elastic.c driver/make/train_case.c platform/allocate.c
 * mesh/formats/surface_read.c io/json_read.c io/text.c io/file.c io/paths.c
 * mesh/formats/mesh_read.c mesh/mesh_units.c precompute/full/full.c
 * precompute/options/precompute_options.c platform/interrupt.c core/[a-z]*[a-z]/*.c
 * runtime/[a-z]*[a-z]/*.c SPDX-License-Identifier: Apache-2.0 */
#include "config/message.h"
#include "driver/make/precompute_request.h"
#include "driver/run/simulate_options.h"
#include "driver/statics/static_options.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_table.h"

#define WORDS_MAX 24
#define WORD_BYTES 300
#define ROOM (WORDS_MAX + CONFIG_FILE_ITEMS_MAX)

// --- messages, which are made and looked at, but not printed
// --------------------------------------

int config_refuse(const thrum_error *error) {
  fuzz_check(error->status, error);
  return COMMAND_REFUSED;
}

int config_usage(const char *command, const char *format, ...) {
  char line[1200];
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  if (command[0] == 0 || length <= 0)
    abort();
  return COMMAND_USAGE;
}

int config_usage_option(const char *command, char **argv, const struct option *options) {
  (void)command;
  (void)argv;
  (void)options;
  return COMMAND_USAGE;
}

const char *config_nearest(const char *text, const char *const *names, int64_t count) {
  (void)text;
  return count > 0 ? names[count - 1] : NULL;
}

void config_warn(const char *format, ...) {
  (void)format;
}

void config_one_line(char *text) {
  for (char *c = text; *c != 0; c++)
    *c = (unsigned char)*c < ' ' ? '?' : *c;
}

// --- the three commands
// ---------------------------------------------------------------------------

/* Lists that the commands own, and a request of each. */
static struct {
  load_spec loads[ROOM];
  actuate_spec actuates[ROOM];
  base_motion_spec base_motions[ROOM];
  start_spec starts[ROOM];
  probe_spec probes[ROOM];
  load_target targets[ROOM];
  static_move moves[ROOM];
  const char *texts[7][ROOM];
} room;

typedef union any_request {
  simulate_request simulate;
  static_request rest;
  precompute_request precompute;
} any_request;

static void prepare(int which, any_request *request) {
  memset(request, 0, sizeof *request);

  // lists and texts lie in room of the caller, as in the commands
  if (which == 0) {
    request->simulate.loads = room.loads;
    request->simulate.actuates = room.actuates;
    request->simulate.base_motions = room.base_motions;
    request->simulate.starts = room.starts;
    request->simulate.probes = room.probes;
  } else if (which == 1) {
    request->rest.loads = room.loads;
    request->rest.actuates = room.actuates;
    request->rest.targets = room.targets;
    request->rest.moves = room.moves;
    request->rest.at = room.texts[0];
  } else {
    request->precompute.fixes = room.texts[0];
    request->precompute.handles = room.texts[1];
    request->precompute.train = room.texts[2];
    request->precompute.tests = room.texts[3];
    request->precompute.materials = room.texts[4];
    request->precompute.springs = room.texts[5];
    request->precompute.actuators = room.texts[6];
  }
}

/* Aborts on a request that no command should have let pass. */
static void check_request(int which, const any_request *request) {
  const simulate_request *simulate = &request->simulate;
  if (which == 0 && !(simulate->model_path != NULL && simulate->run_path != NULL &&
                      simulate->def.dt > 0 && simulate->time > 0 && simulate->steps >= 1 &&
                      simulate->record_every >= 1 && simulate->load_count <= ROOM))
    abort();
  if (which == 1 && !(request->rest.model_path != NULL && request->rest.load_count <= ROOM &&
                      request->rest.load_count + request->rest.move_count > 0))
    abort();
  if (which == 2 &&
      !(request->precompute.mesh_name != NULL && request->precompute.fix_count <= ROOM))
    abort();
}

static void read_arguments(fuzz_draw *draw, int which, const config_command *command) {
  static char words[WORDS_MAX + 1][WORD_BYTES];
  char *argv[WORDS_MAX + 2];
  config_row rows[CONFIG_OPTION_MAX];
  const int row_count = config_rows(command->options, rows);
  int argc = 0;
  snprintf(words[argc++], WORD_BYTES, "%s", command->name);
  while (argc < WORDS_MAX && draw->left > 0) {
    const config_option *option = rows[draw_index(draw, row_count)].option;
    const unsigned byte = draw_byte(draw);

    // files are read below, and help would be printed
    if (option->helps || option->kind == CONFIG_FILE)
      continue;
    if (option->argument || byte >= 240) {
      draw_words(draw, words[argc++], WORD_BYTES);
      continue;
    }
    char value[256];
    draw_value_text(draw, option, value, sizeof value);
    if (option->kind == CONFIG_FLAG)
      snprintf(words[argc++], WORD_BYTES, "--%s", option->name);
    else
      snprintf(words[argc++], WORD_BYTES, "--%s=%s", option->name, value);
  }
  for (int n = 0; n < argc; n++)
    argv[n] = words[n];
  argv[argc] = NULL;

  static any_request request;
  prepare(which, &request);
  const int code = which == 0   ? simulate_options_read(argc, argv, &request.simulate)
                   : which == 1 ? static_options_read(argc, argv, &request.rest)
                                : precompute_options_read(argc, argv, &request.precompute);
  if (code == COMMAND_DONE)
    check_request(which, &request);
}

static void read_file(fuzz_draw *draw, int which, const config_command *command) {
  static drawn_text text;
  static any_request request;
  const bool overridden[CONFIG_OPTION_MAX] = {false};
  thrum_error error = {0};
  config_file file = {0};
  text.used = 0;
  draw_record(draw, command->options, true, 0, &text);
  prepare(which, &request);
  thrum_status status =
      config_file_parse("folder/options.json", text.bytes, text.used, &file, &error);
  if (status >= 0)
    status = config_file_apply(&file, command, overridden, &request);
  fuzz_check(status, &error);
  config_file_free(&file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const config_command *const commands[] = {&command_simulate, &command_static,
                                                   &command_precompute};
  fuzz_draw draw = {data, size};
  const unsigned byte = draw_byte(&draw);
  const int which = (int)(byte % 3);
  if (byte / 3 % 2 == 0)
    read_arguments(&draw, which, commands[which]);
  else
    read_file(&draw, which, commands[which]);
  return 0;
}
