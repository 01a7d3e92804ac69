/* Options of `thrum simulate SCENE.json`. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_OPTIONS_H
#define THRUM_DRIVER_SCENE_SCENE_OPTIONS_H

/* Reads the command line and runs the scene (scene_run.h); an exit code. */
int scene_run_command(int argc, char **argv);

#endif
