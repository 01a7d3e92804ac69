/* The lines and numbers of Gmsh files, text or bytes of either order; see mesh_read_msh.h.
 * SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <string.h>

#include "mesh/formats/mesh_read_msh.h"

thrum_status thrum_msh_bad_bytes(msh_reader *r, const char *what) {
  return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "in the binary data behind this line: %s",
                         what);
}

thrum_status thrum_msh_text_line(msh_reader *r, const char *what) {
  THRUM_TRY(thrum_text_need_line(&r->text, what));
  if (*r->text.start == '$')
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, "expected %s, found '%s'", what,
                           thrum_text_excerpt(thrum_text_line(&r->text)).text);
  return THRUM_OK;
}

thrum_status thrum_msh_line(msh_reader *r, const char *what) {
  return r->binary ? THRUM_OK : thrum_msh_text_line(r, what);
}

thrum_status thrum_msh_count(msh_reader *r, const char *what, int64_t *count) {
  THRUM_TRY(thrum_msh_text_line(r, what));
  return thrum_text_integer(&r->text, what, 0, INT64_MAX, count);
}

/* Takes the next `size` bytes as a number. */
static thrum_status take_bits(msh_reader *r, int size, uint64_t *bits) {
  if (r->text.stop - r->text.next < size)
    return thrum_msh_bad_bytes(r, "the file ends too early; is it cut short?");
  const unsigned char *bytes = (const unsigned char *)r->text.next;
  r->text.next += size;
  *bits = 0;
  for (int i = 0; i < size; i++)
    *bits = *bits << 8 | bytes[r->little ? size - 1 - i : i];
  return THRUM_OK;
}

thrum_status thrum_msh_whole(msh_reader *r, const char *what, int size, int64_t low, int64_t high,
                             int64_t *value) {
  uint64_t bits = 0;
  if (!r->binary)
    return thrum_text_integer(&r->text, what, low, high, value);
  THRUM_TRY(take_bits(r, size, &bits));

  // a count near 2^63 is damage, and sizes computed from it would overflow
  if (size == 8 && bits > INT64_MAX / 64)
    return thrum_msh_bad_bytes(r, "a count or a tag is out of range");

  // numbers of 4 bytes are signed
  const int64_t number =
      size == 4 && bits >> 31 ? (int64_t)bits - (INT64_C(1) << 32) : (int64_t)bits;
  if (number < low || number > high)
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT,
                           "in the binary data behind this line: %s is %lld, which is out of range",
                           what, (long long)number);
  *value = number;
  return THRUM_OK;
}

thrum_status thrum_msh_real(msh_reader *r, const char *what, double *value) {
  uint64_t bits = 0;
  if (!r->binary)
    return thrum_text_number(&r->text, what, value);
  THRUM_TRY(take_bits(r, 8, &bits));
  memcpy(value, &bits, sizeof *value);
  return isfinite(*value) ? THRUM_OK
                          : thrum_msh_bad_bytes(r, "a coordinate is not a finite number");
}

thrum_status thrum_msh_byte_order(msh_reader *r) {
  uint64_t one = 0;
  r->binary = r->little = true;
  THRUM_TRY(take_bits(r, 4, &one));
  r->little = one == 1;
  return one == 1 || one == 16777216
             ? THRUM_OK
             : thrum_msh_bad_bytes(r, "there is no 1 to tell the order of the bytes");
}
