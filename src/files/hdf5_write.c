/* SPDX-License-Identifier: BSD-3-Clause */
#include "hdf5_address.h"
#include "signorom/file_system.h"
#include "signorom/system.h"

#include <stdlib.h>
#include <string.h>

static hid_t open_or_make_group(hid_t file, const char *path, hid_t links) {
  if (sig_h5_is_root(path)) return H5Oopen(file, "/", H5P_DEFAULT);
  if (sig_h5_find_object(file, path) == SIG_H5_PATH_PLAIN) return H5Oopen(file, path, H5P_DEFAULT);
  return H5Gcreate2(file, path, links, H5P_DEFAULT, H5P_DEFAULT);
}

static int write_attribute(hid_t object, const char *name, const hid_t types[2], hid_t space, const void *values) {
  const hid_t attribute = H5Acreate2(object, name, types[0], space, H5P_DEFAULT, H5P_DEFAULT);
  const int failed = attribute < 0 || H5Awrite(attribute, types[1], values) < 0;
  if (attribute >= 0) H5Aclose(attribute);
  return failed ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

static hid_t create_dataset(hid_t file, const char *path, hid_t links, hid_t type, hid_t space) {
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_obj_track_times(creation, 0); /* no times in the file, so that the same content gives the same bytes */
  const hid_t dataset = H5Dcreate2(file, path, type, space, links, creation, H5P_DEFAULT);
  H5Pclose(creation);
  return dataset;
}

static int write_dataset(hid_t file, const char *path, hid_t links, const hid_t types[2], hid_t space,
                         const void *values) {
  const hid_t dataset = create_dataset(file, path, links, types[0], space);
  const int failed = dataset < 0 || H5Dwrite(dataset, types[1], H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0;
  if (dataset >= 0) H5Dclose(dataset);
  return failed ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

/* Writes a dataset or an attribute. types: the type in the file, and the type in memory. */
static int write_item(hid_t file, const struct sig_h5_address *address, const hid_t types[2], hid_t space,
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

static int write_at(hid_t file, const char *text, size_t length, const hid_t types[2], int rank, const int64_t *shape,
                    const void *values) {
  struct sig_h5_address address;
  if (!sig_h5_cut_address(text, length, &address)) return SIG_H5_NO_WRITE;
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
    const hid_t singles[2] = {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT};
    const hid_t integers[2] = {H5T_STD_I32LE, H5T_NATIVE_INT};
    const hid_t *types = type == SIG_H5_REAL ? reals : type == SIG_H5_SINGLE ? singles : integers;
    status = write_at(file->id, address, length, types, rank, shape, values);
  }
  H5E_END_TRY;
  return status;
}

static int fill_rows(hid_t dataset, hid_t space, const hsize_t shape[2], const double *const *rows) {
  const hsize_t one_row[2] = {1, shape[1]};
  const hid_t row_space = H5Screate_simple(2, one_row, NULL);
  int failed = 0;
  for (hsize_t i = 0; i < shape[0] && shape[1] > 0 && !failed; i++) {
    const hsize_t start[2] = {i, 0};
    failed = H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, one_row, NULL) < 0 ||
             H5Dwrite(dataset, H5T_NATIVE_DOUBLE, row_space, space, H5P_DEFAULT, rows[i]) < 0;
  }
  H5Sclose(row_space);
  return failed ? SIG_H5_NO_WRITE : SIG_H5_OK;
}

int sig_h5_write_rows(sig_h5_file *file, const char *address, size_t length, int64_t n_rows, int64_t row_size,
                      const double *const *rows) {
  const hsize_t shape[2] = {(hsize_t)n_rows, (hsize_t)row_size};
  struct sig_h5_address cut;
  int status = SIG_H5_NO_WRITE;
  if (!sig_h5_cut_address(address, length, &cut)) return status;
  H5E_BEGIN_TRY {
    const hid_t links = H5Pcreate(H5P_LINK_CREATE);
    H5Pset_create_intermediate_group(links, 1);
    const hid_t space = H5Screate_simple(2, shape, NULL);
    const hid_t dataset = create_dataset(file->id, cut.object, links, H5T_IEEE_F64LE, space);
    if (dataset >= 0) status = fill_rows(dataset, space, shape, rows);
    if (dataset >= 0 && H5Dclose(dataset) < 0) status = SIG_H5_NO_WRITE;
    H5Sclose(space);
    H5Pclose(links);
  }
  H5E_END_TRY;
  sig_free(cut.object);
  return status;
}

/* Returns one block with pointers to null-terminated copies of `n` texts, and the copies behind the pointers. */
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
    const hid_t type = sig_h5_text_type(H5T_CSET_UTF8);
    const hid_t types[2] = {type, type};
    status = write_at(file->id, address, length, types, rank, &n, texts);
    H5Tclose(type);
  }
  H5E_END_TRY;
  free(texts);
  return status;
}
