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
