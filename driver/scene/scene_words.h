/* Messages of what a scene has done, in the words of scene files.
 *
 * The code that makes and steps the bodies of a scene serves the command line as well, and its
 * messages name options: "give --young". Where a scene file has a key for the same, the message is
 * to name that.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SCENE_SCENE_WORDS_H
#define THRUM_DRIVER_SCENE_SCENE_WORDS_H

#include <stddef.h>

/* Rewrites a message of at most `size` bytes with its 0 in place: options that are keys of a scene
 * become those ("young"), others those of the command that makes a model, which the scene may then
 * name (thrum precompute --order). Commands that are written out stay as they are, and what finds
 * no room is cut off. */
void scene_words(char *message, size_t size);

#endif
