/* `thrum view`: models and scenes as one HTML page, which the browser opens from the disk.
 *
 * The page lies in the present folder and not in a temporary or hidden one, since browsers that run
 * in a sandbox (snap, flatpak) may not read those.
 * SPDX-License-Identifier: Apache-2.0 */
#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "app/cmd.h"
#include "app/view/view_archive_make.h"
#include "app/view/viewer_page.h"
#include "config/message.h"
#include "config/options.h"
#include "driver/record/run_read.h"
#include "driver/scene/scene_read.h"
#include "driver/spec/model_names.h"
#include "io/json.h"
#include "io/paths.h"
#include "mesh/formats/mesh_read.h"
#include "mesh/formats/surface_read.h"
#include "platform/folder_swap.h"
#include "platform/program.h"

#define DEFAULT_OUTPUT "thrum_view.html"
#define FPS_DEFAULT 60

typedef struct view_request {
  const char *names[VIEW_MODELS_MAX];
  int64_t count;
  const char *output, *surface;
  double fps; /* of a run */
  bool opens; /* the browser, after the page is written */
  bool no_open, quiet, json;
} view_request;

#define AT(member) CONFIG_AT(view_request, member)

static const config_option options[] = {
    OPTION_TEXT("output", "FILE", DEFAULT_OUTPUT, "the page; it is then not opened", .letter = 'o',
                AT(output)),
    OPTION_TEXT("surface", "FILE", NULL,
                "show this surface in place of the one model's own: what thrum embed wrote, or an "
                ".obj or .stl in metres",
                AT(surface)),
    OPTION_NUMBER("fps", "1/s", "60",
                  "rows of a run that go into the page, at most; 0: all that it recorded", AT(fps),
                  CONFIG_FROM(0)),
    OPTION_FLAG("no-open", "do not open the page, which is done where there is a display",
                AT(no_open)),
    OPTION_FLAG("json", "print {\"status\", \"file\", \"url\"} as one line", AT(json)),
    OPTION_QUIET(view_request),
    OPTION_HELP,
    OPTION_END,
};

const config_command command_view = {
    .name = "view",
    .summary = "show models or a scene in the browser, to be pulled at, or play a run or a curve",
    .usage = "[MODEL...|SCENE.json|RUN|CURVE] [OPTIONS]",
    .about =
        "Shows models, or a scene, in the browser, where bodies move as they are pulled at: writes "
        "one HTML page, which needs nothing else, and opens it. MODEL is a model file, or the name "
        "(beam, basket, bridge, horse, tower, heart) of a model that is precomputed once and "
        "cached, with touch modes, so that it follows pulls anywhere; without any, all six. "
        "SCENE.json is what thrum simulate takes too. RUN is the folder of a finished run, of a "
        "model or of a scene, which the page plays. CURVE is the folder that thrum response wrote: "
        "the page has its curve, and the body moves as in the point that is picked.",
    .options = options,
    .examples = "view\n"
                "view beam.npz --no-open\n"
                "view horse tower -o models.html\n"
                "view scene.json\n"
                "view fallen --fps 0\n"
                "view forced",
};

/* Is it the folder of a run, of a model or of a scene? */
static bool is_run(const char *name) {
  return is_run_folder(name) || is_scene_folder(name);
}

/* Does it have the page for itself, a run or a curve? */
static bool is_played(const char *name) {
  return is_run(name) || is_curve_folder(name);
}

/* Refuses what is no model and no scene, and what would overwrite its own source. */
static int check_names(const view_request *request) {
  for (int64_t n = 0; n < request->count; n++) {
    const char *name = request->names[n];

    // nothing is written over what is read
    if (path_same_file(request->output, name))
      return config_usage("view", "%s is what is to be shown: write to another file",
                          request->output);

    // one scene or one run has the page for itself
    if (request->count > 1 && is_scene_name(name))
      return config_usage("view", "one scene at a time, and no models beside it");
    if (request->count > 1 && is_played(name))
      return config_usage("view", "one run or curve at a time, and no models beside it");

    thrum_error error = {0};
    if (!is_curve_folder(name) && recorded_folder_check(name, "", &error) < 0)
      return config_refuse(&error);

    // these become something that can be shown by another command
    if (thrum_mesh_is_named(name))
      return config_usage("view", "%s is a mesh: make a model of it with thrum precompute", name);
    if (thrum_surface_mesh_is_named(name))
      return config_usage("view", "%s is a surface: show it on its model with --surface", name);
  }

  // a surface belongs to one model; in a scene each body names its own
  if (request->surface != NULL && (request->count != 1 || is_scene_name(request->names[0]) ||
                                   is_scene_folder(request->names[0])))
    return config_usage("view", "--surface goes with one model, or the run or curve of one");
  if (request->fps != FPS_DEFAULT && !(request->count == 1 && is_run(request->names[0])))
    return config_usage("view", "--fps goes with the folder of a run");
  return COMMAND_DONE;
}

/* Refuses a name that no browser would open as a page. */
static int check_form(const char *output) {
  const char *dot = strrchr(output, '.');
  if (dot != NULL && (strcasecmp(dot, ".html") == 0 || strcasecmp(dot, ".htm") == 0))
    return COMMAND_DONE;
  return config_usage("view", "a page is written: give '%s' a name that ends with .html", output);
}

static int read_options(int argc, char **argv, view_request *request) {
  CONFIG_TRY(config_options_read(&command_view, argc, argv, request));
  if (argc - optind > VIEW_MODELS_MAX)
    return config_usage("view", "at most %d models at a time", VIEW_MODELS_MAX);
  while (optind < argc)
    request->names[request->count++] = argv[optind++];

  // a page with a name of its own is for later, or for another machine
  request->opens = request->output == NULL && !request->no_open;
  if (request->output == NULL)
    request->output = DEFAULT_OUTPUT;
  CONFIG_TRY(check_names(request));
  CONFIG_TRY(check_form(request->output));

  // without a name, all models that come with Thrum
  const int64_t all = request->count == 0 ? MODEL_NAME_COUNT : 0;
  for (int n = 0; n < all; n++)
    request->names[request->count++] = model_names[n];
  return COMMAND_DONE;
}

/* Makes an archive of the run, the curve, the scene or the models that are named. */
static thrum_status make_archive(const view_request *request, view_archive *archive,
                                 thrum_error *error) {
  const view_run_request played = {.path = request->names[0],
                                   .surface = request->surface,
                                   .output = request->output,
                                   .fps = request->fps,
                                   .quiet = request->quiet};
  if (is_run(played.path))
    return view_archive_of_run(&played, archive, error);
  if (is_curve_folder(played.path))
    return view_archive_of_curve(&played, archive, error);
  return view_archive_of_names(request->names, request->count, request->surface, request->quiet,
                               archive, error);
}

/* Writes the page with the models in it. */
static thrum_status write_page(const view_request *request, thrum_error *error) {
  viewer_page page = {0};
  view_archive archive = {0};

  // without the viewer's page there is nothing to precompute for
  thrum_status status = viewer_page_read(&page, error);
  THRUM_THEN(status, make_archive(request, &archive, error));
  THRUM_THEN(status, viewer_page_write(request->output, &page, &archive, error));
  view_archive_free(&archive);
  viewer_page_free(&page);
  return status;
}

/* The address of a file; malloc, NULL without memory or a present folder. Bytes other than letters,
 * digits and "-._~/" are written as %XX (RFC 3986, RFC 8089). */
static char *file_url(const char *given) {
  static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  char folder[4096] = "";

  // without the steps up that a relative path may have
  char *whole = thrum_folder_real_path(given);
  const char *path = whole != NULL ? whole : given;
  if (path[0] != '/' && getcwd(folder, sizeof folder) == NULL)
    return NULL;
  const char *const parts[] = {folder, path[0] != '/' ? "/" : "", path};
  char *url = malloc(sizeof "file://" + 3 * (strlen(folder) + 1 + strlen(path)));

  // each byte takes at most three
  char *at = url != NULL ? url + sprintf(url, "file://") : NULL;
  for (int n = 0; n < 3 && url != NULL; n++)
    for (const char *from = parts[n]; *from != 0; from++)
      at += sprintf(at, strchr(plain, *from) != NULL ? "%c" : "%%%02X", (unsigned char)*from);
  free(whole);
  return url;
}

/* Asks the desktop to show the address, or says that there is none; the browser goes on alone, in a
 * group of its own, so that Ctrl-C in this terminal does not end it. */
static void open_browser(char *url, bool quiet) {
  if (getenv("DISPLAY") == NULL && getenv("WAYLAND_DISPLAY") == NULL) {
    if (!quiet)
      fputs("thrum: no display was found, so no browser was started; open the address in one\n",
            stderr);
    return;
  }

  // the browser's messages are not ours, but that there is none is
  pid_t child;
  char *const argv[] = {"xdg-open", url, NULL};
  if (program_start(argv, &(program_place){.own_group = true}, &child) != 0 && !quiet)
    fputs("thrum: no browser could be started: there is no xdg-open; open the address in one\n",
          stderr);
}

static thrum_status show_page(const view_request *request, thrum_error *error) {
  THRUM_TRY(write_page(request, error));
  char *url = file_url(request->output);
  if (url == NULL)
    return thrum_error_set(error, THRUM_OUT_OF_MEMORY, "%.200s: no memory for its address",
                           request->output);

  // the address is printed for those without a display
  if (request->json) {
    cJSON *object = cJSON_CreateObject();
    cJSON_AddStringToObject(object, "status", "done");
    json_string(object, "file", request->output);
    cJSON_AddStringToObject(object, "url", url);
    json_print(object);
  } else {
    printf("page              %s\naddress           %s\n", request->output, url);
  }
  fflush(stdout);

  if (request->opens)
    open_browser(url, request->quiet);
  free(url);
  return THRUM_OK;
}

int cmd_view(int argc, char **argv) {
  view_request request = {.fps = FPS_DEFAULT};
  CONFIG_TRY(read_options(argc, argv, &request));
  thrum_error error = {0};
  return show_page(&request, &error) < 0 ? config_refuse(&error) : COMMAND_DONE;
}
