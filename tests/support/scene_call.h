/* Calls of thrum/scene.h in tests that must succeed: MUST(thrum_scene_step(scene, &failure)). A
 * test includes its support first, which has cmocka. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_TESTS_SUPPORT_SCENE_CALL_H
#define THRUM_TESTS_SUPPORT_SCENE_CALL_H

#include "thrum/scene.h"

/* Why the last call failed. */
static thrum_error failure;

#define MUST(call)                                                                                 \
  do {                                                                                             \
    if ((call) < 0)                                                                                \
      fail_msg("%s", failure.message);                                                             \
  } while (0)

#endif
