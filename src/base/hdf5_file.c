/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/hdf5_file.h"

#include "signorom/file_system.h"

#include <hdf5.h>
#include <stdlib.h>
#include <string.h>

struct sig_h5_file {
  hid_t id;
};

/* An address cut at its @: the object's path and, for attributes, the name in it. */
struct address {
  char *object;
  const char *attribute; /* null for a dataset */
};

/* A dataset or an attribute that is open. */
struct item {
  hid_t id;
  int is_attribute;
};

static int cut_address(const char *text, size_t length, struct address *address) {
  address->attribute = NULL;
  address->object = sig_copy_text(text, length);
  if (!address->object) return 0;
  char *at = strchr(address->object, '@');
  if (at) {
    *at = '\0';
    address->attribute = at + 1;
  }
  return 1;
}

static int is_root(const char *path) { return path[0] == '\0' || strcmp(path, "/") == 0; }

/* H5Lexists fails, rather than answers, where a group on the way is missing. */
static int object_exists(hid_t file, const char *path) {
  if (is_root(path)) return 1;
  char *part = sig_copy_text(path, strlen(path));
  if (!part) return 0;
  int exists = 1;
  for (char *slash = strchr(part + 1, '/'); slash && exists; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    exists = H5Lexists(file, part, H5P_DEFAULT) > 0;
    *slash = '/';
  }
  exists = exists && H5Lexists(file, part, H5P_DEFAULT) > 0;
  sig_free(part);
  return exists;
}

static herr_t find_lock_message(unsigned depth, const H5E_error2_t *entry, void *is_locked) {
  (void)depth;
  if (entry->desc && strstr(entry->desc, "unable to lock file")) *(int *)is_locked = 1;
  return 0;
}

static int open_failure(const char *name) {
  int is_locked = 0;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, find_lock_message, &is_locked);
  if (is_locked) return SIG_H5_LOCKED;
  return H5Fis_hdf5(name) > 0 ? SIG_H5_DAMAGED : SIG_H5_NOT_HDF5;
}

static int wrap_file(hid_t id, sig_h5_file **file) {
  *file = malloc(sizeof **file);
  if (!*file) {
    H5Fclose(id);
    return SIG_H5_NO_READ;
  }
  (*file)->id = id;
  return SIG_H5_OK;
}

static int create_or_open(const char *path, size_t length, int is_new, sig_h5_file **file) {
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_H5_NO_READ;
  const hid_t id =
      is_new ? H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT) : H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
  int status;
  if (id >= 0)
    status = wrap_file(id, file);
  else
    status = is_new ? SIG_H5_NO_CREATE : open_failure(name);
  sig_free(name);
  return status;
}

/* On a full disk HDF5 cannot close a file, tries again at exit and crashes in it. Counts before its first use only. */
static void forbid_work_at_exit(void) { H5dont_atexit(); }

int sig_h5_create(const char *path, size_t length, sig_h5_file **file) {
  int status;
  *file = NULL;
  forbid_work_at_exit();
  H5E_BEGIN_TRY { status = create_or_open(path, length, 1, file); }
  H5E_END_TRY;
  return status;
}

int sig_h5_open(const char *path, size_t length, sig_h5_file **file) {
  int status;
  *file = NULL;
  forbid_work_at_exit();
  H5E_BEGIN_TRY { status = create_or_open(path, length, 0, file); }
  H5E_END_TRY;
  return status;
}

int sig_h5_close(sig_h5_file *file) {
  herr_t failed = 0;
  if (!file) return SIG_H5_OK;
  H5E_BEGIN_TRY { failed = H5Fclose(file->id); }
  H5E_END_TRY;
  free(file);
  return failed < 0 ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

static hid_t open_or_make_group(hid_t file, const char *path, hid_t links) {
  if (is_root(path)) return H5Oopen(file, "/", H5P_DEFAULT);
  if (object_exists(file, path)) return H5Oopen(file, path, H5P_DEFAULT);
  return H5Gcreate2(file, path, links, H5P_DEFAULT, H5P_DEFAULT);
}

static int write_attribute(hid_t object, const char *name, const hid_t types[2], hid_t space, const void *values) {
  const hid_t attribute = H5Acreate2(object, name, types[0], space, H5P_DEFAULT, H5P_DEFAULT);
  const int failed = attribute < 0 || H5Awrite(attribute, types[1], values) < 0;
  if (attribute >= 0) H5Aclose(attribute);
  return failed ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

static int write_dataset(hid_t file, const char *path, hid_t links, const hid_t types[2], hid_t space,
                         const void *values) {
  const hid_t dataset = H5Dcreate2(file, path, types[0], space, links, H5P_DEFAULT, H5P_DEFAULT);
  const int failed = dataset < 0 || H5Dwrite(dataset, types[1], H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0;
  if (dataset >= 0) H5Dclose(dataset);
  return failed ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

/* types: in the file, in memory. */
static int write_item(hid_t file, const struct address *address, const hid_t types[2], hid_t space,
                      const void *values) {
  int status = SIG_H5_NO_WRITE;
  const hid_t links = H5Pcreate(H5P_LINK_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  if (!address->attribute) {
    status = write_dataset(file, address->object, links, types, space, values);
  } else {
    const hid_t object = open_or_make_group(file, address->object, links);
    if (object >= 0) {
      status = write_attribute(object, address->attribute, types, space, values);
      H5Oclose(object);
    }
  }
  H5Pclose(links);
  return status;
}

static hid_t make_space(int rank, const int64_t *shape) {
  if (rank == 0) return H5Screate(H5S_SCALAR);
  hsize_t sizes[SIG_H5_MAX_RANK];
  for (int i = 0; i < rank; i++) sizes[i] = (hsize_t)shape[i];
  return H5Screate_simple(rank, sizes, NULL);
}

static hid_t make_text_type(H5T_cset_t character_set) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, character_set);
  return type;
}

static int write_at(hid_t file, const char *text, size_t length, const hid_t types[2], int rank, const int64_t *shape,
                    const void *values) {
  struct address address;
  if (!cut_address(text, length, &address)) return SIG_H5_NO_WRITE;
  const hid_t space = make_space(rank, shape);
  const int status = write_item(file, &address, types, space, values);
  H5Sclose(space);
  sig_free(address.object);
  return status;
}

int sig_h5_write(sig_h5_file *file, const char *address, size_t length, int type, int rank, const int64_t *shape,
                 const void *values) {
  int status = SIG_H5_NO_WRITE;
  if (rank > SIG_H5_MAX_RANK) return status;
  H5E_BEGIN_TRY {
    const hid_t reals[2] = {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
    const hid_t integers[2] = {H5T_STD_I32LE, H5T_NATIVE_INT};
    status = write_at(file->id, address, length, type == SIG_H5_REAL ? reals : integers, rank, shape, values);
  }
  H5E_END_TRY;
  return status;
}

/* Pointers to null-terminated copies, in one block behind them. */
static char **terminated_texts(int64_t n, const char *characters, const int64_t *ends) {
  const size_t n_bytes = n > 0 ? (size_t)(ends[n - 1] + n) : 0;
  char **texts = malloc((size_t)(n + 1) * sizeof *texts + n_bytes);
  if (!texts) return NULL;
  char *next = (char *)(texts + n + 1);
  for (int64_t i = 0, start = 0; i < n; start = ends[i++]) {
    const size_t size = (size_t)(ends[i] - start);
    texts[i] = next;
    memcpy(next, characters + start, size);
    next[size] = '\0';
    next += size + 1;
  }
  return texts;
}

int sig_h5_write_texts(sig_h5_file *file, const char *address, size_t length, int rank, int64_t n,
                       const char *characters, const int64_t *ends) {
  int status;
  char **texts = terminated_texts(n, characters, ends);
  if (!texts) return SIG_H5_NO_WRITE;
  H5E_BEGIN_TRY {
    const hid_t type = make_text_type(H5T_CSET_UTF8);
    const hid_t types[2] = {type, type};
    status = write_at(file->id, address, length, types, rank, &n, texts);
    H5Tclose(type);
  }
  H5E_END_TRY;
  free(texts);
  return status;
}

static int has_at(hid_t file, const struct address *address) {
  if (!object_exists(file, address->object)) return 0;
  if (!address->attribute) return 1;
  return H5Aexists_by_name(file, is_root(address->object) ? "/" : address->object, address->attribute, H5P_DEFAULT) > 0;
}

int sig_h5_has(sig_h5_file *file, const char *address, size_t length) {
  struct address cut;
  int exists = 0;
  if (!cut_address(address, length, &cut)) return 0;
  H5E_BEGIN_TRY { exists = has_at(file->id, &cut); }
  H5E_END_TRY;
  sig_free(cut.object);
  return exists;
}

static int open_item(hid_t file, const char *text, size_t length, struct item *item) {
  struct address address;
  if (!cut_address(text, length, &address)) return SIG_H5_NO_READ;
  item->is_attribute = address.attribute != NULL;
  int status = SIG_H5_MISSING;
  if (has_at(file, &address)) {
    const char *object = is_root(address.object) ? "/" : address.object;
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
    const hid_t type = make_text_type(H5Tget_cset(file_type));
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
