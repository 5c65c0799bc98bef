/* SPDX-License-Identifier: BSD-3-Clause */
#include "hdf5_address.h"
#include "signorom/file_system.h"

#include <stdlib.h>
#include <string.h>

/* A dataset or an attribute that is open. */
struct item {
  hid_t id;
  int is_attribute;
};

static int has_at(hid_t file, const struct sig_h5_address *address) {
  if (!sig_h5_object_exists(file, address->object)) return 0;
  if (!address->attribute) return 1;
  return H5Aexists_by_name(file, sig_h5_is_root(address->object) ? "/" : address->object, address->attribute,
                           H5P_DEFAULT) > 0;
}

int sig_h5_has(sig_h5_file *file, const char *address, size_t length) {
  struct sig_h5_address cut;
  int exists = 0;
  if (!sig_h5_cut_address(address, length, &cut)) return 0;
  H5E_BEGIN_TRY { exists = has_at(file->id, &cut); }
  H5E_END_TRY;
  sig_free(cut.object);
  return exists;
}

static int open_item(hid_t file, const char *text, size_t length, struct item *item) {
  struct sig_h5_address address;
  if (!sig_h5_cut_address(text, length, &address)) return SIG_H5_NO_READ;
  item->is_attribute = address.attribute != NULL;
  int status = SIG_H5_MISSING;
  if (has_at(file, &address)) {
    const char *object = sig_h5_is_root(address.object) ? "/" : address.object;
    item->id = item->is_attribute ? H5Aopen_by_name(file, object, address.attribute, H5P_DEFAULT, H5P_DEFAULT)
                                  : H5Dopen2(file, object, H5P_DEFAULT);
    status = item->id < 0 ? SIG_H5_MISSING : SIG_H5_OK; /* a group is no dataset */
  }
  sig_free(address.object);
  return status;
}

static void close_item(const struct item *item) {
  if (item->is_attribute)
    H5Aclose(item->id);
  else
    H5Dclose(item->id);
}

static hid_t type_of(const struct item *item) {
  return item->is_attribute ? H5Aget_type(item->id) : H5Dget_type(item->id);
}

static hid_t space_of(const struct item *item) {
  return item->is_attribute ? H5Aget_space(item->id) : H5Dget_space(item->id);
}

static herr_t read_raw(const struct item *item, hid_t memory_type, void *values) {
  if (item->is_attribute) return H5Aread(item->id, memory_type, values);
  return H5Dread(item->id, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values);
}

static int describe_item(const struct item *item, int *type, int *rank, int64_t *shape) {
  const hid_t file_type = type_of(item);
  const H5T_class_t kind = H5Tget_class(file_type);
  H5Tclose(file_type);
  *type = kind == H5T_FLOAT     ? SIG_H5_REAL
          : kind == H5T_INTEGER ? SIG_H5_INTEGER
          : kind == H5T_STRING  ? SIG_H5_TEXT
                                : SIG_H5_OTHER;

  const hid_t space = space_of(item);
  *rank = H5Sget_simple_extent_ndims(space);
  hsize_t sizes[SIG_H5_MAX_RANK];
  int status = SIG_H5_NO_READ;
  if (*rank >= 0 && *rank <= SIG_H5_MAX_RANK && H5Sget_simple_extent_dims(space, sizes, NULL) >= 0) {
    for (int i = 0; i < *rank; i++) shape[i] = (int64_t)sizes[i];
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
    struct item item;
    status = open_item(file->id, address, length, &item);
    if (!status) {
      status = describe_item(&item, type, rank, shape);
      close_item(&item);
    }
  }
  H5E_END_TRY;
  return status;
}

int sig_h5_read(sig_h5_file *file, const char *address, size_t length, int type, void *values) {
  int status;
  H5E_BEGIN_TRY {
    struct item item;
    status = open_item(file->id, address, length, &item);
    if (!status) {
      if (read_raw(&item, type == SIG_H5_REAL ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT, values) < 0)
        status = SIG_H5_NO_READ;
      close_item(&item);
    }
  }
  H5E_END_TRY;
  return status;
}

/* Text i of `n` starts at texts[i]; packs them into one block. */
static int pack_texts(int64_t n, char *const *texts, const size_t *sizes, char **characters, int64_t **ends) {
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

/* h5py and others write texts of fixed width too: padded by nulls or blanks. */
static int read_fixed_texts(const struct item *item, hid_t type, int64_t n, char **texts, size_t *sizes, void **block) {
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

static int read_variable_texts(const struct item *item, hid_t type, int64_t n, char **texts, size_t *sizes) {
  if (read_raw(item, type, texts) < 0) return SIG_H5_NO_READ;
  for (int64_t i = 0; i < n; i++) sizes[i] = texts[i] ? strlen(texts[i]) : 0;
  return SIG_H5_OK;
}

static int read_item_texts(const struct item *item, int64_t n, char **characters, int64_t **ends) {
  const hid_t file_type = type_of(item);
  const int is_variable = H5Tis_variable_str(file_type) > 0;
  char **texts = calloc((size_t)(n + 1), sizeof *texts);
  size_t *sizes = calloc((size_t)(n + 1), sizeof *sizes);
  void *block = NULL;
  int status = SIG_H5_NO_READ;
  if (texts && sizes && is_variable) {
    const hid_t type = sig_h5_text_type(H5Tget_cset(file_type));
    const hid_t space = space_of(item);
    status = read_variable_texts(item, type, n, texts, sizes);
    if (!status) status = pack_texts(n, texts, sizes, characters, ends);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, texts);
    H5Sclose(space);
    H5Tclose(type);
  } else if (texts && sizes) {
    status = read_fixed_texts(item, file_type, n, texts, sizes, &block);
    if (!status) status = pack_texts(n, texts, sizes, characters, ends);
  }
  free(block);
  free(sizes);
  free(texts);
  H5Tclose(file_type);
  return status;
}

static int64_t count_of(const struct item *item) {
  const hid_t space = space_of(item);
  const int64_t n = (int64_t)H5Sget_simple_extent_npoints(space);
  H5Sclose(space);
  return n < 0 ? 0 : n;
}

int sig_h5_read_texts(sig_h5_file *file, const char *address, size_t length, int64_t *n, char **characters,
                      int64_t **ends) {
  int status;
  *n = 0;
  *characters = NULL;
  *ends = NULL;
  H5E_BEGIN_TRY {
    struct item item;
    status = open_item(file->id, address, length, &item);
    if (!status) {
      *n = count_of(&item);
      status = read_item_texts(&item, *n, characters, ends);
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
