/* What stands in front of the names of FMI in a body that is linked statically; nothing in a shared
 * one. `thrum export` writes it anew. SPDX-License-Identifier: Apache-2.0 */
#ifndef FMU_PREFIX_H
#define FMU_PREFIX_H

#endif
