/* The functions that steppers of all kinds have in common. SPDX-License-Identifier: Apache-2.0 */
#include "driver/run/stepper.h"

#include <stddef.h>

void driver_stepper_close(driver_stepper *stepper) {
  if (stepper->kind != NULL && stepper->kind->close != NULL)
    stepper->kind->close(stepper->self);
  *stepper = (driver_stepper){0};
}
