/* The words of --judge. SPDX-License-Identifier: Apache-2.0 */
#include "driver/spec/basis_asked.h"

const char *const basis_judging_names[] = {"auto", "on", "off", NULL};
