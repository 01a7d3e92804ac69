/* Files of Thrum's own: an .npz with the arrays of one list, which says their types and shapes. The
 * members are walked and matched by name, their .npy headers parsed, the sizes bound in list order.
 * Nothing is copied, no alignment is assumed.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#ifndef THRUM_CORE_MODEL_ARCHIVE_H
#define THRUM_CORE_MODEL_ARCHIVE_H

#include <limits.h>
#include <stddef.h>
#include <stdint.h>

#include "core/base/alignment_check.h"
#include "thrum/status.h"

// the files are little-endian and used in place
#if defined(__BYTE_ORDER__) && defined(__ORDER_LITTLE_ENDIAN__)
#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "Thrum's files are little-endian; this machine is not supported"
#endif
#endif
_Static_assert(CHAR_BIT == 8 && sizeof(double) == 8 && sizeof(float) == 4,
               "needs bytes of 8 bits, 64-bit doubles and 32-bit floats");

/* A type as .npy spells it, for the X-lists. */
#define THRUM_DESCR_f8 "<f8"
#define THRUM_DESCR_f4 "<f4"
#define THRUM_DESCR_i4 "<i4"
#define THRUM_DESCR_u1 "|u1"

typedef struct thrum_array_info {
  const char *name;
  const char *descr;    /* <f8, <f4, <i4, |u1 */
  size_t item;          /* bytes an entry */
  int dims;             /* 1: a plain vector of `rows` entries */
  int rows, columns;    /* numbers of sizes */
  const char *expected; /* the shape in words, for messages */
  int required;
} thrum_array_info;

/* A size that follows from another one, as `factor` times that; or a literal, `of` below 0. */
typedef struct thrum_derived_size {
  int factor, of;
} thrum_derived_size;

/* The arrays that a kind of file may hold, in file order. Sizes are numbered: the first size_count
 * are bound by the first array that carries them, the rest follow from these or are literals. */
typedef struct thrum_array_list {
  const thrum_array_info *arrays;
  int count;
  int size_count;
  int named_count; /* sizes that have a name for messages, the bound ones first */
  const char *const *size_names;
  const thrum_derived_size *derived; /* the sizes from number size_count on */
} thrum_array_list;

/* Value of a size, and bytes of an array, where `size` has those that are bound. */
int64_t thrum_archive_extent(const thrum_array_list *list, const int64_t *size, int size_id);
size_t thrum_archive_bytes(const thrum_array_list *list, const int64_t *size, int array);

/* Copies the arrays (data: list->count, NULL where absent) to `next`, each at a multiple of 64
 * behind the one before, and points data to the copies; returns their end. */
unsigned char *thrum_archive_copy(const thrum_array_list *list, const int64_t *size,
                                  const unsigned char **data, unsigned char *next);

typedef struct thrum_archive_member {
  const unsigned char *data; /* the .npy; NULL: absent */
  size_t size;
} thrum_archive_member;

/* Fills found (list->count, zeroed before) with the members of the list. Walks the whole archive,
 * so that unknown members are checked too. */
thrum_status thrum_archive_find(const void *file, size_t file_size, const thrum_array_list *list,
                                thrum_archive_member *found, thrum_error *error);

/* The values of one member: its type and shape are those of the list, or become so where a size was
 * not bound before (size: of the list's; bound: size_count, which are known). */
thrum_status thrum_archive_bind(const thrum_array_list *list, int array,
                                thrum_archive_member member, int64_t *size, unsigned char *bound,
                                const unsigned char **data, thrum_error *error);

#endif
