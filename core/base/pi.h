/* The number pi, which C11 does not name. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_BASE_PI_H
#define THRUM_CORE_BASE_PI_H

#define THRUM_PI 3.14159265358979323846
#define THRUM_TWO_PI 6.28318530717958647693

#endif
