/* SPDX-License-Identifier: BSD-3-Clause */
/* Checks of HDF5 files that somebody else may have made. A few bytes in a file can promise terabytes of values, or
 * values in another file. So the place of the values is checked before memory is allocated and before values are read.
 */
#include "hdf5_address.h"

hid_t sig_h5_type_of(const struct sig_h5_item *item) {
  return item->is_attribute ? H5Aget_type(item->id) : H5Dget_type(item->id);
}

hid_t sig_h5_space_of(const struct sig_h5_item *item) {
  return item->is_attribute ? H5Aget_space(item->id) : H5Dget_space(item->id);
}

/* Accepts only values that stand in one piece, as in our files: no chunks, no other files, no filters. */
static int check_layout(hid_t dataset) {
  const hid_t creation = H5Dget_create_plist(dataset);
  if (creation < 0) return SIG_H5_NO_READ;
  const H5D_layout_t layout = H5Pget_layout(creation);
  const int is_plain = (layout == H5D_CONTIGUOUS || layout == H5D_COMPACT) && H5Pget_external_count(creation) == 0 &&
                       H5Pget_nfilters(creation) == 0;
  H5Pclose(creation);
  return is_plain ? SIG_H5_OK : SIG_H5_ELSEWHERE;
}

/* Checks that the values, as many as the shape says, need no more bytes than are stored in the file. */
static int check_size(const struct sig_h5_file *file, uint64_t n_stored, hid_t type, hid_t space) {
  const size_t size = H5Tget_size(type);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  if (size == 0 || n < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) return SIG_H5_NO_READ;
  if (n_stored > file->size || (uint64_t)n > n_stored / size) return n == 0 ? SIG_H5_OK : SIG_H5_TOO_LARGE;
  return SIG_H5_OK;
}

int sig_h5_check_item(const struct sig_h5_file *file, const struct sig_h5_item *item) {
  int status = item->is_attribute ? SIG_H5_OK : check_layout(item->id);
  if (status) return status;
  const hid_t type = sig_h5_type_of(item), space = sig_h5_space_of(item);
  status = SIG_H5_NO_READ;
  if (type >= 0 && space >= 0)
    status = check_size(file, item->is_attribute ? H5Aget_storage_size(item->id) : H5Dget_storage_size(item->id), type,
                        space);
  if (space >= 0) H5Sclose(space);
  if (type >= 0) H5Tclose(type);
  return status;
}

int sig_h5_take(struct sig_h5_file *file, uint64_t n_bytes) {
  if (n_bytes > file->n_left) return 0;
  file->n_left -= n_bytes;
  return 1;
}
