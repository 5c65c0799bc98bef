/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* flock */
#include "signorom/file_system.h"

#include "signorom/output_stream.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "signorom/partial_files.h"
#include "signorom/system.h"

int sig_file_kind(const char *path, size_t length) {
  struct stat status;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_NO_FILE;
  const int failed = stat(name, &status);
  free(name);
  if (failed) return SIG_NO_FILE;
  if (S_ISDIR(status.st_mode)) return SIG_DIRECTORY;
  return S_ISREG(status.st_mode) ? SIG_PLAIN_FILE : SIG_OTHER_FILE;
}

int sig_program_path(char *path, size_t size) {
  const ssize_t length = readlink("/proc/self/exe", path, size);
  if (length < 0) return errno;
  if ((size_t)length >= size) return ENAMETOOLONG;
  path[length] = '\0';
  return 0;
}

static int make_directory(const char *name) {
  if (mkdir(name, 0777) == 0) return 0;
  const int code = errno;
  struct stat status;
  /* Another process may have made the folder meanwhile. */
  if (stat(name, &status) == 0) return S_ISDIR(status.st_mode) ? 0 : ENOTDIR;
  return code;
}

int sig_make_directories(const char *path, size_t length) {
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  int code = length ? 0 : ENOENT;
  for (size_t i = 1; i < length && !code; i++) {
    if (name[i] != '/') continue;
    name[i] = '\0';
    code = make_directory(name);
    name[i] = '/';
  }
  if (!code) code = make_directory(name);
  free(name);
  return code;
}

static int read_all(int descriptor, char **bytes, size_t *size) {
  size_t capacity = 1 << 16;
  char *block = malloc(capacity);
  if (!block) return ENOMEM;
  *size = 0;
  for (;;) {
    const ssize_t n = read(descriptor, block + *size, capacity - *size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int code = errno;
      free(block);
      return code;
    }
    if (n == 0) break;
    *size += (size_t)n;
    if (*size < capacity) continue;
    capacity *= 2;
    char *larger = realloc(block, capacity);
    if (!larger) {
      free(block);
      return ENOMEM;
    }
    block = larger;
  }
  *bytes = block;
  return 0;
}

int sig_read_file(const char *path, size_t length, char **bytes, size_t *size) {
  *bytes = NULL;
  *size = 0;
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  const int descriptor = open(name, O_RDONLY | O_CLOEXEC);
  const int open_error = errno;
  free(name);
  if (descriptor < 0) return open_error;
  const int code = read_all(descriptor, bytes, size);
  close(descriptor);
  return code;
}

int sig_open_to_read(const char *path, size_t length, int *descriptor) {
  char *name = sig_copy_text(path, length);
  *descriptor = -1;
  if (!name) return ENOMEM;
  *descriptor = open(name, O_RDONLY | O_CLOEXEC);
  const int code = *descriptor < 0 ? errno : 0;
  free(name);
  return code;
}

int sig_read_some(int descriptor, char *bytes, size_t size, size_t *n_read) {
  ssize_t n;
  do {
    n = read(descriptor, bytes, size);
  } while (n < 0 && errno == EINTR);
  *n_read = n < 0 ? 0 : (size_t)n;
  return n < 0 ? errno : 0;
}

void sig_close_descriptor(int descriptor) {
  if (descriptor >= 0) close(descriptor);
}

/* The new name of a renamed file survives a crash only if its folder has been written to the disk. Some file systems
 * cannot do this; a failure is ignored. */
void sig_sync_folder_of(const char *name) {
  char *folder = sig_copy_text(name, strlen(name));
  if (!folder) return;
  char *slash = strrchr(folder, '/');
  if (slash) slash[slash == folder] = '\0';
  const int descriptor = open(slash ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor >= 0) {
    fsync(descriptor);
    close(descriptor);
  }
  free(folder);
}

int sig_write_file(const char *path, size_t length, const char *bytes, size_t size) {
  sig_output_stream *stream = NULL;
  const int code = sig_output_open(path, length, &stream);
  if (code) return code;
  sig_output_write(stream, bytes, size);
  return sig_output_close(stream, 1);
}

static int sync_file(const char *name) {
  const int descriptor = open(name, O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  const int code = fsync(descriptor) == 0 ? 0 : errno;
  close(descriptor);
  return code;
}

int sig_commit_file(const char *from, size_t from_length, const char *to, size_t to_length) {
  char *old_name = sig_copy_text(from, from_length);
  char *new_name = sig_copy_text(to, to_length);
  int code = old_name && new_name ? sync_file(old_name) : ENOMEM;
  if (!code && rename(old_name, new_name) != 0) code = errno;
  if (!code) sig_forget_partial_file(from, from_length);
  if (!code) sig_sync_folder_of(new_name);
  free(new_name);
  free(old_name);
  if (code) sig_let_end_pass();
  return code;
}

int sig_remove_file(const char *path, size_t length) {
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  const int code = unlink(name) == 0 ? 0 : errno;
  if (!code) sig_forget_partial_file(path, length);
  free(name);
  return code;
}

/* Returns the process number that the holder of the lock has written; 0 if there is none. */
static long noted_process(int descriptor) {
  char text[32];
  const ssize_t n = pread(descriptor, text, sizeof text - 1, 0);
  if (n <= 0) return 0;
  text[n] = '\0';
  return strtol(text, NULL, 10);
}

/* Opens the file of the lock. If somebody put a link there, writing the lock would empty another file. So O_NOFOLLOW
 * and the checks refuse links. */
static int open_lock(const char *name, int *lock) {
  struct stat status;
  *lock = open(name, O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (*lock < 0) return errno;
  int code = fstat(*lock, &status) == 0 ? 0 : errno;
  if (!code && (!S_ISREG(status.st_mode) || status.st_nlink > 1)) code = ELOOP;
  if (!code) return 0;
  close(*lock);
  return code;
}

int sig_lock_file(const char *path, size_t length, int is_shared, int *descriptor, long *process) {
  *descriptor = -1;
  *process = 0;
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  int lock;
  const int open_code = open_lock(name, &lock);
  free(name);
  if (open_code) return open_code;
  if (flock(lock, (is_shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0) {
    const int code = errno;
    if (code == EWOULDBLOCK) *process = noted_process(lock);
    close(lock);
    return code;
  }
  char text[32];
  const int n = is_shared ? 0 : snprintf(text, sizeof text, "%ld\n", (long)getpid());
  /* Another process that finds the lock shows this number in its message. */
  if (ftruncate(lock, 0) == 0) (void)sig_write_all(lock, text, (size_t)n);
  *descriptor = lock;
  return 0;
}

/* The file is not removed, because then two processes could lock two different files of the same name. */
void sig_unlock_file(int descriptor) {
  if (descriptor >= 0) close(descriptor);
}

static int compare_names(const void *first, const void *second) {
  return strcmp(*(char *const *)first, *(char *const *)second);
}

struct name_list {
  char **names;
  size_t n, capacity, n_bytes;
};

static int append_name(struct name_list *list, const char *name) {
  if (list->n == list->capacity) {
    list->capacity = list->capacity ? 2 * list->capacity : 16;
    char **larger = realloc(list->names, list->capacity * sizeof *larger);
    if (!larger) return ENOMEM;
    list->names = larger;
  }
  list->names[list->n] = sig_copy_text(name, strlen(name));
  if (!list->names[list->n]) return ENOMEM;
  list->n_bytes += strlen(name) + 1;
  list->n++;
  return 0;
}

static int gather_names(DIR *folder, const char *prefix, size_t prefix_length, struct name_list *list) {
  for (;;) {
    errno = 0;
    const struct dirent *entry = readdir(folder);
    if (!entry) return errno;
    if (entry->d_name[0] == '.' || strncmp(entry->d_name, prefix, prefix_length) != 0) continue;
    struct stat status;
    if (fstatat(dirfd(folder), entry->d_name, &status, 0) != 0 || S_ISDIR(status.st_mode)) continue;
    const int code = append_name(list, entry->d_name);
    if (code) return code;
  }
}

static char *packed_names(struct name_list *list) {
  char *packed = malloc(list->n_bytes + 1);
  char *end = packed;
  if (list->n > 1) qsort(list->names, list->n, sizeof *list->names, compare_names);
  for (size_t i = 0; i < list->n && packed; i++) {
    strcpy(end, list->names[i]);
    end += strlen(list->names[i]) + 1;
  }
  return packed;
}

int sig_list_files(const char *path, size_t length, const char *prefix, size_t prefix_length, char **names,
                   size_t *size) {
  *names = NULL;
  *size = 0;
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  DIR *folder = opendir(name);
  int code = folder ? 0 : errno;
  free(name);
  if (!folder) return code;

  struct name_list list = {NULL, 0, 0, 0};
  code = gather_names(folder, prefix, prefix_length, &list);
  closedir(folder);
  if (!code) {
    *names = packed_names(&list);
    *size = list.n_bytes;
    if (!*names) code = ENOMEM;
  }
  for (size_t i = 0; i < list.n; i++) free(list.names[i]);
  free(list.names);
  return code;
}
