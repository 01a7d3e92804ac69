/* The tables of the core alone (core/schemes/schemes.h, core/polynomial/kernel_private.h), for a
 * library of this folder and nothing else: imexv, newmark and energy in plain C, without guards. A
 * def that asks for one of them is refused. The whole library has runtime/extensions/extensions.c
 * in place of this file. SPDX-License-Identifier: Apache-2.0 */
#include "core/polynomial/kernel_private.h"
#include "core/schemes/discrete_gradient.h"
#include "core/schemes/imexv.h"
#include "core/schemes/newmark.h"
#include "core/schemes/position_split.h"

const thrum_pass_set thrum_passes = {.kernel = NULL};

const thrum_scheme_set thrum_schemes = {
    .rows =
        {
            [THRUM_SCHEME_THESIS] = &thrum_thesis_scheme,
            [THRUM_SCHEME_POSITION] = &thrum_position_scheme,
            [THRUM_SCHEME_ENERGY] = &thrum_energy_scheme,
            [THRUM_SCHEME_NEWMARK] = &thrum_newmark_scheme,
        },
};
