/* Zip archives of stored members, the subset of APPNOTE.TXT 6.3.x that docs/model_format.md allows:
 *
 *   local record, data, local record, data, ... | central records | end record (22 bytes)
 *
 * The local records must tile the file from 0 to the central directory in the directory's order, so
 * that every byte of a file belongs to exactly one thing and two readers cannot see two files.
 * Every sum of sizes is checked by comparing with what is left, never by adding first.
 * Cost: one pass of CRC-32 over the data.
 *
 * SPDX-License-Identifier: Apache-2.0 */
#include "core/model/zip.h"

#include <string.h>

#define END_SIZE 22u
#define CENTRAL_SIZE 46u
#define LOCAL_SIZE 30u
#define FLAG_DESCRIPTOR 0x0008u
#define FLAG_ENCRYPTED 0x0001u
#define EXTRA_PADDING 0xD935u
#define EXTRA_ZIP64 0x0001u
#define IN_EXTRA 0xFFFFFFFFu

static unsigned get16(const unsigned char *p) {
  return (unsigned)p[0] | (unsigned)p[1] << 8;
}

static uint32_t get32(const unsigned char *p) {
  return (uint32_t)get16(p) | (uint32_t)get16(p + 2) << 16;
}

static uint64_t get64(const unsigned char *p) {
  return (uint64_t)get32(p) | (uint64_t)get32(p + 4) << 32;
}

void thrum_zip_name_text(char text[48], const char *name, size_t name_size) {
  size_t shown = name_size < 40 ? name_size : 40;
  for (size_t i = 0; i < shown; i++)
    text[i] = name[i] >= 0x20 && name[i] < 0x7F ? name[i] : '?';
  text[shown] = '\0';
  if (shown < name_size)
    memcpy(text + shown, "...", 4);
}

// says why the last 22 bytes are not the end record of an archive
static thrum_status refuse_end(const unsigned char *file, size_t size, thrum_error *error) {
  if (size >= 6 && memcmp(file, "\x93NUMPY", 6) == 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "this is a single .npy array, not an .npz model file");
  if (size < 4 || memcmp(file, "PK\3\4", 4) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "not a model file (an uncompressed .npz)");
  return thrum_error_set(error, THRUM_BAD_FORMAT,
                         "no zip end record in the last 22 bytes: the file is cut short, or it has "
                         "a zip comment, which a model file must not have");
}

thrum_status thrum_zip_open(const void *file, size_t file_size, thrum_zip *zip,
                            thrum_error *error) {
  // the end record stands at the very end
  const unsigned char *bytes = file;
  if (file_size < END_SIZE || memcmp(bytes + file_size - END_SIZE, "PK\5\6", 4) != 0)
    return refuse_end(bytes, file_size, error);
  size_t end = file_size - END_SIZE;
  const unsigned char *record = bytes + end;

  // without comment, and of one disk
  if (get16(record + 20) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "the zip end record announces a comment, which a model file must not "
                           "have, or the file is cut short");
  if (get16(record + 4) != 0 || get16(record + 6) != 0 || get16(record + 8) != get16(record + 10))
    return thrum_error_set(error, THRUM_UNSUPPORTED, "zip archive of more than one disk");

  // the directory lies right before it
  uint32_t directory_size = get32(record + 12);
  uint32_t directory = get32(record + 16);
  if (directory == IN_EXTRA || directory_size == IN_EXTRA || get16(record + 10) == 0xFFFFu)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "zip64 archive: a model file must be smaller than 4 GiB");
  if (directory > end || directory_size != end - directory)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "the zip directory (%lu bytes at %lu) does not end where the end record "
                           "begins (%lu): the file is damaged or cut short",
                           (unsigned long)directory_size, (unsigned long)directory,
                           (unsigned long)end);

  if (get16(record + 10) > THRUM_ZIP_MEMBERS_MAX)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "%u members, more than the %d allowed",
                           get16(record + 10), THRUM_ZIP_MEMBERS_MAX);

  // the walk begins at the first member
  zip->bytes = bytes;
  zip->directory = directory;
  zip->end = end;
  zip->count = get16(record + 10);
  zip->index = 0;
  zip->central = directory;
  zip->local = 0;
  thrum_crc32_prepare(&zip->table);
  return THRUM_OK;
}

// refuses everything but plain stored members, with the reason a numpy user can act on
static thrum_status check_kind(unsigned flags, unsigned method, const char *name,
                               thrum_error *error) {
  // each refusal says what to do about it
  if ((flags & FLAG_ENCRYPTED) != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED, "member '%s' is encrypted", name);

  if (method != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "member '%s' is compressed: use numpy.savez, not savez_compressed",
                           name);

  if ((flags & FLAG_DESCRIPTOR) != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "member '%s' has its sizes behind its data, as numpy.savez writes to a "
                           "pipe: save to a file on disk",
                           name);

  if (flags != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "member '%s' has zip flags 0x%04x: use numpy.savez", name, flags);
  return THRUM_OK;
}

// the local extra field: nothing, our padding, or the zip64 record that numpy.savez always writes
static int extra_is_good(const unsigned char *extra, size_t size, uint32_t data_size,
                         int *sizes_inside) {
  *sizes_inside = 0;
  if (size == 0)
    return 1;

  // a field says how long it is
  if (size < 4 || get16(extra + 2) != size - 4)
    return 0;

  // zip64 repeats the sizes
  if (get16(extra) == EXTRA_ZIP64) {
    *sizes_inside = 1;
    return size == 20 && get64(extra + 4) == data_size && get64(extra + 12) == data_size;
  }

  // padding is zeros
  if (get16(extra) != EXTRA_PADDING)
    return 0;
  for (size_t i = 4; i < size; i++)
    if (extra[i] != 0)
      return 0;
  return 1;
}

// the fields that a local and a central record both hold
static int headers_agree(const unsigned char *local, const unsigned char *central,
                         int sizes_inside) {
  uint32_t size = get32(central + 20);
  int sizes = get32(local + 18) == size && get32(local + 22) == size;
  // python from 3.11.4 on leaves the sizes to the zip64 record, earlier ones write both
  if (sizes_inside)
    sizes = sizes || (get32(local + 18) == IN_EXTRA && get32(local + 22) == IN_EXTRA);
  return sizes && get16(local + 6) == get16(central + 8) &&
         get16(local + 8) == get16(central + 10) && get32(local + 14) == get32(central + 16);
}

// checks the local record that `central` points to and finds the data behind it
static thrum_status check_local(const thrum_zip *zip, const unsigned char *central,
                                const char *text, thrum_zip_member *member, thrum_error *error) {
  // members follow each other
  if (get32(central + 42) != zip->local)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "member '%s' is said to begin at byte %lu, where %lu is right: members "
                           "must follow each other without a gap or an overlap",
                           text, (unsigned long)get32(central + 42), (unsigned long)zip->local);

  // the local record lies within the file
  const unsigned char *local = zip->bytes + zip->local;
  size_t left = zip->directory - zip->local;
  if (left < LOCAL_SIZE || memcmp(local, "PK\3\4", 4) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "member '%s' has no local record", text);
  left -= LOCAL_SIZE;

  // so do its name, its extra field and the data
  size_t name_size = get16(local + 26), extra_size = get16(local + 28);
  uint32_t size = get32(central + 24);
  if (name_size > left || extra_size > left - name_size || size > left - name_size - extra_size)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "member '%s' runs into the zip directory: the file is damaged", text);

  const unsigned char *extra = local + LOCAL_SIZE + name_size;
  int sizes_inside = 0;
  if (!extra_is_good(extra, extra_size, size, &sizes_inside))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "member '%s' has an extra field that is neither padding nor the one of "
                           "numpy.savez",
                           text);

  // the directory and the local record say the same
  if (name_size != member->name_size || memcmp(local + LOCAL_SIZE, member->name, name_size) != 0 ||
      !headers_agree(local, central, sizes_inside))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "member '%s': its local record and the zip directory disagree", text);

  member->data = extra + extra_size;
  member->size = size;
  return THRUM_OK;
}

// after the last member both cursors must stand at the end of their part
static thrum_status finish(const thrum_zip *zip, thrum_zip_member *member, thrum_error *error) {
  if (zip->central != zip->end || zip->local != zip->directory)
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "bytes that belong to no member stand %s the zip directory",
                           zip->central != zip->end ? "in" : "before");
  member->name = NULL;
  return THRUM_OK;
}

thrum_status thrum_zip_next(thrum_zip *zip, thrum_zip_member *member, thrum_error *error) {
  if (zip->index == zip->count)
    return finish(zip, member, error);

  // the next record of the directory, with its name
  const unsigned char *central = zip->bytes + zip->central;
  size_t left = zip->end - zip->central;
  if (left < CENTRAL_SIZE || memcmp(central, "PK\1\2", 4) != 0)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "the zip directory is damaged at member %lu",
                           (unsigned long)zip->index + 1);
  left -= CENTRAL_SIZE;
  thrum_zip_member found = {(const char *)central + CENTRAL_SIZE, get16(central + 28), NULL, 0};
  if (found.name_size > left)
    return thrum_error_set(error, THRUM_BAD_FORMAT, "the zip directory is damaged at member %lu",
                           (unsigned long)zip->index + 1);

  // only stored members without extras: what numpy.savez writes
  char text[48];
  thrum_zip_name_text(text, found.name, found.name_size);
  THRUM_TRY(check_kind(get16(central + 8), get16(central + 10), text, error));
  if (get16(central + 30) != 0 || get16(central + 32) != 0 || get16(central + 34) != 0)
    return thrum_error_set(error, THRUM_UNSUPPORTED,
                           "member '%s' has an extra field, a comment or a disk in the zip "
                           "directory: use numpy.savez",
                           text);
  if (get32(central + 20) != get32(central + 24))
    return thrum_error_set(error, THRUM_BAD_FORMAT,
                           "member '%s' is stored, yet its two sizes differ", text);

  // the data is where the directory says and has the checksum that it says
  THRUM_TRY(check_local(zip, central, text, &found, error));
  if (thrum_crc32(&zip->table, 0, found.data, found.size) != get32(central + 16))
    return thrum_error_set(error, THRUM_BAD_CHECKSUM,
                           "member '%s' does not match its CRC-32: the file is damaged", text);

  // one member further
  zip->local = (size_t)(found.data - zip->bytes) + found.size;
  zip->central += CENTRAL_SIZE + found.name_size;
  zip->index++;
  *member = found;
  return THRUM_OK;
}
