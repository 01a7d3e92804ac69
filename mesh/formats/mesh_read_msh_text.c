/* Reads the lines and numbers of Gmsh files in text for their sections; see mesh_read_msh.c.
 * SPDX-License-Identifier: Apache-2.0 */
#include "mesh/formats/mesh_read_msh.h"

thrum_status thrum_msh_no_memory(msh_reader *r) {
  return thrum_text_fail(&r->text, THRUM_OUT_OF_MEMORY, r->error, "not enough memory");
}

/* Moves to the next line of a section; its end, or that of the file, is refused. */
thrum_status thrum_msh_line(msh_reader *r, const char *what) {
  if (!thrum_text_next_line(&r->text))
    return thrum_text_fail(&r->text, THRUM_BAD_FORMAT, r->error,
                           "the file ends before %s; is it cut short?", what);
  if (*r->text.start == '$')
    return thrum_text_fail(
        &r->text, THRUM_BAD_FORMAT, r->error, "expected %s, found '%s'", what,
        thrum_text_excerpt(r->text.start, (size_t)(r->text.end - r->text.start)).text);
  return THRUM_OK;
}

/* Goes on to the next line when the present one is used up. */
thrum_status thrum_msh_word(msh_reader *r, const char *what) {
  return thrum_text_more(&r->text) ? THRUM_OK : thrum_msh_line(r, what);
}

thrum_status thrum_msh_integer(msh_reader *r, const char *what, int64_t low, int64_t *value) {
  return thrum_text_integer(&r->text, what, low, INT64_MAX, value, r->error);
}
