/* The files of a curve. SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_DRIVER_RESPONSE_RESPONSE_FILES_H
#define THRUM_DRIVER_RESPONSE_RESPONSE_FILES_H

#include "driver/response/response_curve.h"

#define RESPONSE_JSON "response.json"
#define RESPONSE_CSV "response.csv"
#define RESPONSE_COEFFICIENTS "coefficients.npy"
#define RESPONSE_MOTIONS "motions.npy" /* of all coordinates, where some follow */

/* Writes these files, with `text` as response.json, the starts and the plot into the folder of the
 * request; none where it names no folder. */
thrum_status response_files_write(const response_curve *curve, const char *text,
                                  thrum_error *error);

#endif
