/* `thrum view`: models and scenes in the browser, served on this machine or as one file.
 * SPDX-License-Identifier: Apache-2.0 */
#include <fcntl.h>
#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/commands.h"
#include "app/view/http_server.h"
#include "app/view/view_archive_make.h"
#include "app/view/viewer_page.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/named_model.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/mesh.h"
#include "mesh/surface_mesh.h"
#include "platform/interrupt.h"

typedef struct view_request {
  const char *names[CLI_VIEW_MODELS_MAX];
  int64_t count;
  const char *output, *surface;
  int64_t port; /* 0: a free one */
  bool no_open, quiet, json;
} view_request;

static void print_help(void) {
  fputs(
      "usage: thrum view [MODEL...|SCENE.json] [OPTIONS]\n\n"
      "Shows models, or a scene, in the browser, where bodies move as they are pulled at: serves\n"
      "them on 127.0.0.1, which only this machine reaches, until Ctrl-C. MODEL is a model file,\n"
      "or the name (beam, basket, bridge, horse, tower, heart) of a model that is precomputed\n"
      "once and cached; without any, all six. SCENE.json is what `thrum simulate` takes too.\n\n"
      "  -o, --output FILE   write one HTML file that opens from the disk, and serve nothing\n"
      "      --surface FILE  show this surface in place of the one model's own: what `thrum "
      "embed`\n"
      "                      wrote, or an .obj or .stl in metres\n"
      "      --port N        the port to serve on (default: one that is free)\n"
      "      --no-open       do not open the browser, which is done where there is a display\n"
      "      --json          print {\"url\": ...}, or with -o {\"file\": ...}, as one line\n"
      "  -q, --quiet         no progress\n"
      "  -h, --help          this text\n\n"
      "examples:\n"
      "  thrum view\n"
      "  thrum view beam.npz --port 8080 --no-open\n"
      "  thrum view horse tower -o models.html\n"
      "  thrum view scene.json\n",
      stdout);
}

static const config_option table[] = {
    {.name = "output", .letter = 'o', .field = offsetof(view_request, output), .kind = CONFIG_TEXT},
    {.name = "surface", .field = offsetof(view_request, surface), .kind = CONFIG_TEXT},
    {.name = "port",
     .kind = CONFIG_COUNT,
     .field = offsetof(view_request, port),
     .least = 1,
     .most = 65535},
    {.name = "no-open", .kind = CONFIG_FLAG, .field = offsetof(view_request, no_open)},
    CONFIG_OPTION_QUIET(view_request),
    CONFIG_OPTION_JSON(view_request),
    CONFIG_OPTION_HELP(print_help),
    {.name = NULL},
};

static int read_options(int argc, char **argv, view_request *request) {
  const int code = config_options_read("view", table, argc, argv, request);
  if (code != COMMAND_DONE)
    return code;
  if (argc - optind > CLI_VIEW_MODELS_MAX)
    return config_usage("view", "at most %d models at a time", CLI_VIEW_MODELS_MAX);
  while (optind < argc)
    request->names[request->count++] = argv[optind++];
  if (request->output != NULL && (request->port > 0 || request->no_open))
    return config_usage("view",
                        "--port and --no-open are of what is served, and -o serves nothing");
  for (int64_t n = 0; request->output != NULL && n < request->count; n++) {
    if (path_same_file(request->output, request->names[n]))
      return config_usage("view", "%s is what is to be shown: write to another file",
                          request->output);
  }
  for (int64_t n = 0; request->count > 1 && n < request->count; n++) {
    if (cli_scene_is_named(request->names[n]))
      return config_usage("view", "one scene at a time, and no models beside it");
  }
  for (int64_t n = 0; n < request->count; n++) {
    if (thrum_mesh_is_named(request->names[n]))
      return config_usage("view", "%s is a mesh: make a model of it with thrum precompute",
                          request->names[n]);
    if (thrum_surface_mesh_is_named(request->names[n]))
      return config_usage("view", "%s is a surface: show it on its model with --surface",
                          request->names[n]);
  }
  if (request->surface != NULL && (request->count != 1 || cli_scene_is_named(request->names[0])))
    return config_usage("view", "--surface goes with one model");
  if (request->count > 0)
    return COMMAND_DONE;
  for (int n = 0; n < CLI_MODEL_COUNT; n++)
    request->names[request->count++] = cli_model_names[n];
  return COMMAND_DONE;
}

typedef struct view {
  cli_page page;
  cli_pack pack;
} view;

static thrum_status load(const view_request *request, view *shown, thrum_error *error) {
  // without a page there is nothing to precompute for
  const thrum_status status = cli_page_read(&shown->page, error);
  return status >= 0 ? cli_view_pack(request->names, request->count, request->surface,
                                     request->quiet, &shown->pack, error)
                     : status;
}

static thrum_status write_file(const view_request *request, const view *shown, thrum_error *error) {
  const thrum_status status = cli_page_write(request->output, &shown->page, &shown->pack, error);
  if (status < 0)
    return status;
  if (request->json) {
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "status", "done");
    json_string(object, "file", request->output);
    json_print(object);
  } else {
    printf("viewer            %s\n", request->output);
  }
  return status;
}

/* Asks the desktop to show the address; the program that does is nobody's child soon. */
static void open_browser(const char *url) {
  if (getenv("DISPLAY") == NULL && getenv("WAYLAND_DISPLAY") == NULL)
    return;
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    // a session of its own, so that Ctrl-C ends the server alone
    const int null = open("/dev/null", O_RDWR);
    if (setsid() < 0 || fork() != 0 || null < 0)
      _exit(0);
    for (int n = 0; n < 3; n++)
      dup2(null, n);
    execlp("xdg-open", "xdg-open", url, (char *)NULL);
    _exit(0);
  }
  if (child > 0)
    waitpid(child, NULL, 0);
}

static thrum_status serve(const view_request *request, const view *shown, thrum_error *error) {
  const cli_http_file files[] = {
      {"/", "text/html; charset=utf-8", shown->page.html, shown->page.size},
      {"/pack", "application/octet-stream", shown->pack.bytes, shown->pack.size},
  };
  cli_http_server *server = NULL;
  char url[64];
  const thrum_status status = cli_http_open(request->port, &server, error);
  if (status < 0)
    return status;
  snprintf(url, sizeof url, "http://127.0.0.1:%" PRId64 "/", cli_http_port(server));
  if (request->json) {
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "url", url);
    json_print(object);
  } else {
    printf("%s\n", url);
  }
  fflush(stdout);
  if (!request->quiet)
    fputs("thrum: serving on this machine; Ctrl-C ends it\n", stderr);
  if (!request->no_open)
    open_browser(url);
  cli_http_serve(server, files, 2);
  cli_http_close(server);
  return THRUM_OK;
}

int cmd_view(int argc, char **argv) {
  view_request request = {0};
  const int code = read_options(argc, argv, &request);
  if (code != COMMAND_DONE)
    return code;
  thrum_error error = {0};
  view shown = {0};
  thrum_interrupt_clean("\nthrum: stopped; the file being written was removed\n");
  thrum_status status = load(&request, &shown, &error);
  if (status >= 0)
    status = request.output != NULL ? write_file(&request, &shown, &error)
                                    : serve(&request, &shown, &error);
  cli_pack_free(&shown.pack);
  cli_page_free(&shown.page);
  return status < 0 ? config_refuse(&error) : COMMAND_DONE;
}
