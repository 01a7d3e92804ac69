/* Exponential and logarithm of numbers near 1 with the same bits on every machine, where libm
 * rounds differently. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_RUNTIME_MATERIAL_ELEMENTARY_H
#define THRUM_RUNTIME_MATERIAL_ELEMENTARY_H

/* x - log(1 + x) for x > -1, without cancellation. */
double thrum_beyond_logarithm(double x);

/* exp(x) - 1 to a few roundings beside itself; infinite beyond the range of numbers. */
double thrum_exponential_growth(double x);

#endif
