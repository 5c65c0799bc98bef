/* SPDX-License-Identifier: BSD-3-Clause */
#include "hdf5_address.h"
#include "signorom/file_system.h"
#include "signorom/system.h"

#include <stdlib.h>
#include <string.h>

/* Finds the object at an address. Groups, links and damaged objects count, too: reading them fails later with a reason.
 */
static enum sig_h5_path find_item(const struct sig_h5_file *file, const struct sig_h5_address *address) {
  uint64_t place;
  const enum sig_h5_path found = sig_h5_find_object(file->id, address->object);
  if (found != SIG_H5_PATH_PLAIN) return found;
  if (!sig_h5_place_of(file->id, address->object, &place) || !sig_h5_check_header(file, place))
    return SIG_H5_PATH_DAMAGED;
  if (!address->attribute) return found;
  const char *object = sig_h5_is_root(address->object) ? "/" : address->object;
  const htri_t exists = H5Aexists_by_name(file->id, object, address->attribute, H5P_DEFAULT);
  return exists > 0 ? SIG_H5_PATH_PLAIN : SIG_H5_PATH_NONE;
}

int sig_h5_has(sig_h5_file *file, const char *address, size_t length) {
  struct sig_h5_address cut;
  int exists = 0;
  if (!sig_h5_cut_address(address, length, &cut)) return 0;
  H5E_BEGIN_TRY { exists = find_item(file, &cut) != SIG_H5_PATH_NONE; }
  H5E_END_TRY;
  sig_free(cut.object);
  return exists;
}

static void close_item(const struct sig_h5_item *item) {
  if (item->is_attribute)
    H5Aclose(item->id);
  else
    H5Dclose(item->id);
}

static int open_found(const sig_h5_file *file, const struct sig_h5_address *address, struct sig_h5_item *item) {
  const char *object = sig_h5_is_root(address->object) ? "/" : address->object;
  item->is_attribute = address->attribute != NULL;
  item->id = item->is_attribute ? H5Aopen_by_name(file->id, object, address->attribute, H5P_DEFAULT, H5P_DEFAULT)
                                : H5Dopen2(file->id, object, H5P_DEFAULT);
  if (item->id < 0) return SIG_H5_MISSING; /* a group is no dataset */
  const int status = sig_h5_check_item(file, item);
  if (status) close_item(item);
  return status;
}

static int open_item(const sig_h5_file *file, const char *text, size_t length, struct sig_h5_item *item) {
  struct sig_h5_address address;
  if (!sig_h5_cut_address(text, length, &address)) return SIG_H5_NO_READ;
  int status = SIG_H5_MISSING;
  switch (find_item(file, &address)) {
  case SIG_H5_PATH_NONE:
    break;
  case SIG_H5_PATH_LINK:
    status = SIG_H5_ELSEWHERE;
    break;
  case SIG_H5_PATH_DAMAGED:
    status = SIG_H5_NO_READ;
    break;
  case SIG_H5_PATH_PLAIN:
    status = open_found(file, &address, item);
    break;
  }
  sig_free(address.object);
  return status;
}

static herr_t read_raw(const struct sig_h5_item *item, hid_t memory_type, void *values) {
  if (item->is_attribute) return H5Aread(item->id, memory_type, values);
  return H5Dread(item->id, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
}

/* HDF5 has numbers of any width and layout. For safety only the usual ones are accepted. */
static int kind_of(hid_t type) {
  const H5T_class_t kind = H5Tget_class(type);
  const size_t size = H5Tget_size(type);
  if (kind == H5T_STRING) return SIG_H5_TEXT;
  if (kind == H5T_INTEGER && size <= sizeof(int64_t)) return SIG_H5_INTEGER;
  const hid_t reals[] = {H5T_IEEE_F64LE, H5T_IEEE_F64BE, H5T_IEEE_F32LE, H5T_IEEE_F32BE};
  for (size_t i = 0; i < sizeof reals / sizeof *reals && kind == H5T_FLOAT; i++)
    if (H5Tequal(type, reals[i]) > 0) return SIG_H5_REAL;
  return SIG_H5_OTHER;
}

static int describe_item(const struct sig_h5_item *item, int *type, int *rank, int64_t *shape) {
  const hid_t file_type = sig_h5_type_of(item);
  *type = kind_of(file_type);
  H5Tclose(file_type);

  const hid_t space = sig_h5_space_of(item);
  *rank = H5Sget_simple_extent_ndims(space);
  hsize_t sizes[SIG_H5_MAX_RANK];
  int status = SIG_H5_NO_READ;
  if (*rank >= 0 && *rank <= SIG_H5_MAX_RANK && H5Sget_simple_extent_dims(space, sizes, NULL) >= 0) {
    for (int i = 0; i < *rank; i++) shape[i] = sizes[i] < INT64_MAX ? (int64_t)sizes[i] : INT64_MAX;
    status = SIG_H5_OK;
  }
  H5Sclose(space);
  return status;
}

int sig_h5_describe(sig_h5_file *file, const char *address, size_t length, int *type, int *rank, int64_t *shape) {
  int status;
  *type = SIG_H5_OTHER;
  *rank = 0;
  H5E_BEGIN_TRY {
    struct sig_h5_item item;
    status = open_item(file, address, length, &item);
    if (!status) {
      status = describe_item(&item, type, rank, shape);
      close_item(&item);
    }
  }
  H5E_END_TRY;
  return status;
}

static int64_t count_of(const struct sig_h5_item *item) {
  const hid_t space = sig_h5_space_of(item);
  const int64_t n = (int64_t)H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  return n < 0 ? 0 : n;
}

static int read_numbers(sig_h5_file *file, const struct sig_h5_item *item, int type, void *values) {
  const int is_real = type == SIG_H5_REAL || type == SIG_H5_SINGLE;
  const size_t size = type == SIG_H5_REAL ? sizeof(double) : type == SIG_H5_SINGLE ? sizeof(float) : sizeof(int);
  const hid_t file_type = sig_h5_type_of(item);
  const int found = kind_of(file_type);
  H5Tclose(file_type);
  if (found != SIG_H5_INTEGER && found != (is_real ? SIG_H5_REAL : type)) return SIG_H5_NO_READ;
  if (!sig_h5_take(file, (uint64_t)count_of(item) * size)) return SIG_H5_TOO_LARGE;
  const hid_t memory_type = type == SIG_H5_REAL     ? H5T_NATIVE_DOUBLE
                            : type == SIG_H5_SINGLE ? H5T_NATIVE_FLOAT
                                                    : H5T_NATIVE_INT;
  return read_raw(item, memory_type, values) < 0 ? SIG_H5_NO_READ : SIG_H5_OK;
}

int sig_h5_read(sig_h5_file *file, const char *address, size_t length, int type, void *values) {
  int status;
  H5E_BEGIN_TRY {
    struct sig_h5_item item;
    status = open_item(file, address, length, &item);
    if (!status) {
      status = read_numbers(file, &item, type, values);
      close_item(&item);
    }
  }
  H5E_END_TRY;
  return status;
}

/* Reads a part of a matrix: count[0] rows from start[0] on, and of each row count[1] numbers from start[1] on. */
static int read_part(sig_h5_file *file, const struct sig_h5_item *item, const hsize_t start[2], const hsize_t count[2],
                     double *values) {
  hsize_t sizes[2];
  const hid_t file_type = sig_h5_type_of(item), space = sig_h5_space_of(item);
  const int kind = kind_of(file_type);
  H5Tclose(file_type);
  int status = SIG_H5_NO_READ;
  if (!item->is_attribute && (kind == SIG_H5_REAL || kind == SIG_H5_INTEGER) &&
      H5Sget_simple_extent_ndims(space) == 2 && H5Sget_simple_extent_dims(space, sizes, NULL) >= 0 &&
      start[0] <= sizes[0] && count[0] <= sizes[0] - start[0] && start[1] <= sizes[1] &&
      count[1] <= sizes[1] - start[1])
    status = sig_h5_take(file, count[0] * count[1] * sizeof *values) ? SIG_H5_OK : SIG_H5_TOO_LARGE;
  if (!status) {
    const hid_t memory = H5Screate_simple(2, count, NULL);
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, count, NULL) < 0 ||
        H5Dread(item->id, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values) < 0)
      status = SIG_H5_NO_READ;
    H5Sclose(memory);
  }
  H5Sclose(space);
  return status;
}

int sig_h5_read_part(sig_h5_file *file, const char *address, size_t length, int64_t first_row, int64_t n_rows,
                     int64_t first_column, int64_t n_columns, double *values) {
  int status;
  if (first_row < 0 || n_rows < 0 || first_column < 0 || n_columns < 0) return SIG_H5_NO_READ;
  const hsize_t start[2] = {(hsize_t)first_row, (hsize_t)first_column};
  const hsize_t count[2] = {(hsize_t)n_rows, (hsize_t)n_columns};
  if (count[0] == 0 || count[1] == 0) return SIG_H5_OK;
  H5E_BEGIN_TRY {
    struct sig_h5_item item;
    status = open_item(file, address, length, &item);
    if (!status) {
      status = read_part(file, &item, start, count, values);
      close_item(&item);
    }
  }
  H5E_END_TRY;
  return status;
}

/* Copies `n` texts, of which text i starts at texts[i] and has sizes[i] bytes, into one block. */
static int pack_texts(int64_t n, const char *const *texts, const size_t *sizes, char **characters, int64_t **ends) {
  size_t total = 0;
  for (int64_t i = 0; i < n; i++) total += sizes[i];
  *characters = malloc(total + 1);
  *ends = malloc((size_t)(n + 1) * sizeof **ends);
  if (!*characters || !*ends) return SIG_H5_NO_READ;
  size_t end = 0;
  for (int64_t i = 0; i < n; i++) {
    if (sizes[i]) memcpy(*characters + end, texts[i], sizes[i]);
    end += sizes[i];
    (*ends)[i] = (int64_t)end;
  }
  return SIG_H5_OK;
}

/* Reads texts of fixed width, which h5py and other programs write; they are padded by nulls or blanks. */
static int read_fixed_texts(const struct sig_h5_item *item, hid_t type, int64_t n, const char **texts, size_t *sizes,
                            void **block) {
  const size_t width = H5Tget_size(type);
  const int is_blank_padded = H5Tget_strpad(type) == H5T_STR_SPACEPAD;
  char *values = malloc((size_t)n * width + 1);
  *block = values;
  if (!values || read_raw(item, type, values) < 0) return SIG_H5_NO_READ;
  for (int64_t i = 0; i < n; i++) {
    texts[i] = values + (size_t)i * width;
    sizes[i] = strnlen(texts[i], width);
    while (is_blank_padded && sizes[i] > 0 && texts[i][sizes[i] - 1] == ' ') sizes[i]--;
  }
  return SIG_H5_OK;
}

/* A text of variable length is stored as a reference: its length, and the address and index of its characters. [bytes]
 */
enum { REFERENCE_SIZE = 4 + 8 + 4, LENGTH_SIZE = 4, ADDRESS_SIZE = 8, INDEX_SIZE = 4 };

/* A conversion function for HDF5 that leaves the references as they are. */
static herr_t keep_references(hid_t from, hid_t to, H5T_cdata_t *data, size_t n, size_t stride, size_t other_stride,
                              void *values, void *background, hid_t transfer) {
  (void)n, (void)stride, (void)other_stride, (void)values, (void)background, (void)transfer;
  if (data->command != H5T_CONV_INIT) return 0;
  data->need_bkg = H5T_BKG_NO;
  return H5Tget_size(from) == REFERENCE_SIZE && H5Tget_size(to) == REFERENCE_SIZE ? 0 : -1;
}

/* Reads the references of texts. HDF5 would follow the references of texts without a check. So it is told that they are
 * opaque bytes, which it gives unchanged. */
static int read_references(const struct sig_h5_item *item, unsigned char *references) {
  const char *name = "signorom references";
  const hid_t text = sig_h5_text_type(H5T_CSET_UTF8), bytes = H5Tcreate(H5T_OPAQUE, REFERENCE_SIZE);
  int status = SIG_H5_NO_READ;
  if (H5Tregister(H5T_PERS_SOFT, name, text, bytes, keep_references) >= 0) {
    if (read_raw(item, bytes, references) >= 0) status = SIG_H5_OK;
    H5Tunregister(H5T_PERS_SOFT, name, text, bytes, keep_references);
  }
  H5Tclose(bytes);
  H5Tclose(text);
  return status;
}

/* Follows the reference of one text. Many texts may refer to the same characters of the file; sig_h5_take counts the
 * characters for each of them. */
static int follow_reference(sig_h5_file *file, const unsigned char *reference, const char **text, size_t *size) {
  const uint64_t length = sig_h5_decode(reference, LENGTH_SIZE);
  const uint64_t address = sig_h5_decode(reference + LENGTH_SIZE, ADDRESS_SIZE);
  const uint64_t index = sig_h5_decode(reference + LENGTH_SIZE + ADDRESS_SIZE, INDEX_SIZE);
  const unsigned char *bytes;
  uint64_t n_bytes;
  if (address == 0) return SIG_H5_OK; /* an empty text */
  if (!sig_h5_find_object_of_heap(file, address, index, &bytes, &n_bytes) || length > n_bytes) return SIG_H5_NO_READ;
  if (!sig_h5_take(file, length)) return SIG_H5_TOO_LARGE;
  *text = (const char *)bytes;
  *size = strnlen(*text, length);
  return SIG_H5_OK;
}

static int read_variable_texts(sig_h5_file *file, const struct sig_h5_item *item, int64_t n, const char **texts,
                               size_t *sizes, void **block) {
  unsigned char *references = malloc((size_t)n * REFERENCE_SIZE + 1);
  *block = references;
  if (!references) return SIG_H5_NO_READ;
  int status = read_references(item, references);
  for (int64_t i = 0; i < n && !status; i++)
    status = follow_reference(file, references + i * REFERENCE_SIZE, texts + i, sizes + i);
  return status;
}

static int read_item_texts(sig_h5_file *file, const struct sig_h5_item *item, int64_t n, char **characters,
                           int64_t **ends) {
  const hid_t type = sig_h5_type_of(item);
  const char **texts = calloc((size_t)(n + 1), sizeof *texts);
  size_t *sizes = calloc((size_t)(n + 1), sizeof *sizes);
  void *block = NULL;
  int status = SIG_H5_NO_READ;
  if (texts && sizes && kind_of(type) == SIG_H5_TEXT)
    status = H5Tis_variable_str(type) > 0 ? read_variable_texts(file, item, n, texts, sizes, &block)
                                          : read_fixed_texts(item, type, n, texts, sizes, &block);
  if (!status) status = pack_texts(n, texts, sizes, characters, ends);
  free(block);
  free(sizes);
  free(texts);
  H5Tclose(type);
  return status;
}

static int64_t bytes_of(const struct sig_h5_item *item) {
  const hid_t type = sig_h5_type_of(item);
  const int64_t n = count_of(item) * (int64_t)H5Tget_size(type);
  H5Tclose(type);
  return n;
}

int sig_h5_read_texts(sig_h5_file *file, const char *address, size_t length, int64_t *n, char **characters,
                      int64_t **ends) {
  int status;
  *n = 0;
  *characters = NULL;
  *ends = NULL;
  H5E_BEGIN_TRY {
    struct sig_h5_item item;
    status = open_item(file, address, length, &item);
    if (!status) {
      *n = count_of(&item);
      status = SIG_H5_TOO_LARGE;
      if (sig_h5_take(file, (uint64_t)bytes_of(&item))) status = read_item_texts(file, &item, *n, characters, ends);
      close_item(&item);
    }
  }
  H5E_END_TRY;
  if (!status) return status;
  sig_free(*characters);
  sig_free(*ends);
  *characters = NULL;
  *ends = NULL;
  return status;
}
