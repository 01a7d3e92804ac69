/* Memory that was freed, back to the system. Nothing happens where the C library has no say in it.
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_PLATFORM_MEMORY_RETURN_H
#define THRUM_PLATFORM_MEMORY_RETURN_H

/* From here on large arrays go back as soon as they are freed, whatever a library has set: some
 * that PETSc is linked with have the heap keep all it ever had. */
void memory_return_begin(void);

/* Gives back what is free between small arrays that are not. */
void memory_return(void);

#endif
