/* Elasticity with directions, for people and as JSON. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_SPEC_ELASTIC_REPORT_H
#define THRUM_DRIVER_SPEC_ELASTIC_REPORT_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>

/* Adds "elastic", a row for each layer of a region among all rows (elastic.h), where it has any. */
void elastic_json(cJSON *material, const double *rows, int64_t count, int64_t region);

/* Prints what a region is made of, without an end of the line; false where it has no layers. */
bool elastic_print(const double *rows, int64_t count, int64_t region);

#endif
