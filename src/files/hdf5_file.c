/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* unlink */
#include "signorom/hdf5_file.h"

#include "hdf5_address.h"
#include "signorom/file_system.h"
#include "signorom/partial_files.h"
#include "signorom/system.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

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

/* Sets size and head of the file, and how many bytes may be read from it in all (n_left). Each value is read once,
 * integers perhaps as reals, and texts need a little more than their characters, so a few times the size of the file is
 * enough. */
static void measure(sig_h5_file *file) {
  const uint64_t times = 8, for_texts = 1 << 20;
  hsize_t size = 0, head = 0;
  if (H5Fget_filesize(file->id, &size) < 0) size = 0;
  const hid_t properties = H5Fget_create_plist(file->id);
  H5Pget_userblock(properties, &head);
  H5Pclose(properties);
  file->size = size;
  file->head = head;
  file->n_left = times * size + for_texts;
}

static int wrap_file(hid_t id, sig_h5_file **file) {
  *file = calloc(1, sizeof **file);
  if (!*file) {
    H5Fclose(id);
    return SIG_H5_NO_READ;
  }
  (*file)->id = id;
  measure(*file);
  return SIG_H5_OK;
}

static hid_t create(const char *name, size_t n_free) {
  const hid_t properties = H5Pcreate(H5P_FILE_CREATE);
  hid_t id = H5I_INVALID_HID;
  if (H5Pset_userblock(properties, n_free) >= 0) id = H5Fcreate(name, H5F_ACC_TRUNC, properties, H5P_DEFAULT);
  H5Pclose(properties);
  return id;
}

/* On a full disk HDF5 cannot close a file. It tries again when the program ends, and then crashes. This call forbids
 * that; it has an effect only before the first use of HDF5. */
static void forbid_work_at_exit(void) { H5dont_atexit(); }

int sig_h5_create(const char *path, size_t length, size_t n_free, sig_h5_file **file) {
  int status = SIG_H5_NO_CREATE;
  *file = NULL;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_H5_NO_READ;
  sig_note_partial_file(path, length);
  forbid_work_at_exit();
  unlink(name); /* so that a link with this name is not followed */
  H5E_BEGIN_TRY {
    const hid_t id = create(name, n_free);
    if (id >= 0) status = wrap_file(id, file);
  }
  H5E_END_TRY;
  if (status != SIG_H5_OK) sig_forget_partial_file(path, length);
  sig_free(name);
  return status;
}

/* Returns 1 if HDF5 may open the file. Also 1 for a file that is not plain or cannot be opened: HDF5 gives the reason.
 */
static int has_fine_root(const char *name) {
  struct stat status;
  const int descriptor = open(name, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return 1;
  const int is_plain = fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  const int is_fine = !is_plain || sig_h5_check_root(descriptor, (uint64_t)status.st_size);
  close(descriptor);
  return is_fine;
}

int sig_h5_open(const char *path, size_t length, sig_h5_file **file) {
  int status;
  *file = NULL;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_H5_NO_READ;
  forbid_work_at_exit();
  H5E_BEGIN_TRY {
    const int is_fine = has_fine_root(name);
    const hid_t id = is_fine ? H5Fopen(name, H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID;
    status = id >= 0 ? wrap_file(id, file) : is_fine ? open_failure(name) : SIG_H5_DAMAGED;
  }
  H5E_END_TRY;
  sig_free(name);
  return status;
}

static hid_t create_core(const char *name, hid_t properties) {
  return H5Fcreate(name, H5F_ACC_TRUNC, H5P_DEFAULT, properties);
}

static hid_t open_core(const char *name, hid_t properties) { return H5Fopen(name, H5F_ACC_RDONLY, properties); }

/* Makes an HDF5 file in memory from a copy of `bytes`, or an empty one. Two such files must not have the same name. */
static int start_image(hid_t (*start)(const char *, hid_t), const void *bytes, size_t size, sig_h5_file **file) {
  const size_t increment = 1 << 20;
  char name[32];
  *file = calloc(1, sizeof **file);
  if (!*file) return SIG_H5_NO_READ;
  (*file)->is_image = 1;
  snprintf(name, sizeof name, "%p", (void *)*file);
  forbid_work_at_exit();
  H5E_BEGIN_TRY {
    const hid_t properties = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(properties, increment, 0);
    /* HDF5 declares the bytes as writable, but only copies them. */
    if (size > 0) H5Pset_file_image(properties, (void *)(uintptr_t)bytes, size);
    (*file)->id = start(name, properties);
    if ((*file)->id >= 0) measure(*file);
    H5Pclose(properties);
  }
  H5E_END_TRY;
  if ((*file)->id >= 0) return SIG_H5_OK;
  free(*file);
  *file = NULL;
  return SIG_H5_DAMAGED;
}

int sig_h5_create_image(sig_h5_file **file) {
  return start_image(create_core, NULL, 0, file) == SIG_H5_OK ? SIG_H5_OK : SIG_H5_NO_CREATE;
}

int sig_h5_open_image(const void *bytes, size_t size, sig_h5_file **file) {
  return start_image(open_core, bytes, size, file);
}

int64_t sig_h5_image_size(sig_h5_file *file) {
  ssize_t size = -1;
  H5E_BEGIN_TRY {
    if (H5Fflush(file->id, H5F_SCOPE_LOCAL) >= 0) size = H5Fget_file_image(file->id, NULL, 0);
  }
  H5E_END_TRY;
  return size;
}

int sig_h5_get_image(sig_h5_file *file, size_t size, void *bytes) {
  ssize_t written = -1;
  H5E_BEGIN_TRY { written = H5Fget_file_image(file->id, bytes, size); }
  H5E_END_TRY;
  return written == (ssize_t)size ? SIG_H5_OK : SIG_H5_NO_READ;
}

int sig_h5_close(sig_h5_file *file) {
  herr_t failed = 0;
  if (!file) return SIG_H5_OK;
  H5E_BEGIN_TRY { failed = H5Fclose(file->id); }
  H5E_END_TRY;
  sig_h5_free_heap(file);
  free(file);
  return failed < 0 ? SIG_H5_NO_WRITE : SIG_H5_OK;
}
