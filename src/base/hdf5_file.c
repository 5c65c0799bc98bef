/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/hdf5_file.h"

#include "hdf5_address.h"
#include "signorom/file_system.h"

#include <stdlib.h>
#include <string.h>

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

static hid_t create(const char *name, size_t n_free) {
  const hid_t properties = H5Pcreate(H5P_FILE_CREATE);
  hid_t id = H5I_INVALID_HID;
  if (H5Pset_userblock(properties, n_free) >= 0) id = H5Fcreate(name, H5F_ACC_TRUNC, properties, H5P_DEFAULT);
  H5Pclose(properties);
  return id;
}

/* On a full disk HDF5 cannot close a file, tries again at exit and crashes in it. Counts before its first use only. */
static void forbid_work_at_exit(void) { H5dont_atexit(); }

int sig_h5_create(const char *path, size_t length, size_t n_free, sig_h5_file **file) {
  int status = SIG_H5_NO_CREATE;
  *file = NULL;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_H5_NO_READ;
  forbid_work_at_exit();
  H5E_BEGIN_TRY {
    const hid_t id = create(name, n_free);
    if (id >= 0) status = wrap_file(id, file);
  }
  H5E_END_TRY;
  sig_free(name);
  return status;
}

int sig_h5_open(const char *path, size_t length, sig_h5_file **file) {
  int status;
  *file = NULL;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_H5_NO_READ;
  forbid_work_at_exit();
  H5E_BEGIN_TRY {
    const hid_t id = H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT);
    status = id >= 0 ? wrap_file(id, file) : open_failure(name);
  }
  H5E_END_TRY;
  sig_free(name);
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
