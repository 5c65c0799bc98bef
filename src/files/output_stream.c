/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* readlink */
#include "signorom/output_stream.h"

#include "signorom/file_system.h"
#include "signorom/partial_files.h"
#include "signorom/system.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { most_links = 40, buffer_size = 1 << 16 };

struct sig_output_stream {
  int descriptor;
  int code;               /* errno of the first failure */
  char *target, *partial; /* null if no file is renamed at the end */
  size_t n;
  char buffer[buffer_size];
};

/* Returns the path to which a symbolic link leads; a relative one starts in the folder of the link. Returns null when
 * out of memory.
 */
static char *next_of(const char *name, const char *link) {
  const char *slash = strrchr(name, '/');
  if (link[0] == '/' || !slash) return sig_copy_text(link, strlen(link));
  return sig_join_text(name, (size_t)(slash - name) + 1, link);
}

/* Replaces *name by the path to which its links lead, step by step, because realpath fails for a file that does not
 * exist yet. Links in /proc, such as /proc/self/fd/1, may stand for open files and are not followed. */
static int follow_links(char **name, int *is_direct) {
  char link[PATH_MAX];
  for (int i = 0; i < most_links; i++) {
    struct stat status;
    if (strncmp(*name, "/proc/", strlen("/proc/")) == 0) *is_direct = 1;
    if (*is_direct || lstat(*name, &status) != 0 || !S_ISLNK(status.st_mode)) return 0;
    const ssize_t n = readlink(*name, link, sizeof link - 1);
    if (n < 0) return errno;
    link[n] = '\0';
    char *next = next_of(*name, link);
    if (!next) return ENOMEM;
    free(*name);
    *name = next;
  }
  return ELOOP;
}

int sig_find_target(const char *path, size_t length, char **target, int *is_direct) {
  struct stat status;
  *is_direct = 0;
  *target = sig_copy_text(path, length);
  if (!*target) return ENOMEM;
  int code = 0;
  const int is_there = stat(*target, &status) == 0;
  if (is_there && S_ISDIR(status.st_mode))
    code = EISDIR;
  else if (is_there && !S_ISREG(status.st_mode))
    *is_direct = 1;
  else
    code = follow_links(target, is_direct);
  if (!code) return 0;
  free(*target);
  *target = NULL;
  return code;
}

static int open_direct(const char *target) { return open(target, O_WRONLY | O_APPEND | O_NOCTTY | O_CLOEXEC); }

/* Makes the partial file anew, and never follows a link. Returns its descriptor, or -1 and an errno. */
static int open_partial(const char *partial, const char *target) {
  struct stat status;
  const int is_there = stat(target, &status) == 0;
  unlink(partial); /* a file of a run that was killed, or a link that somebody put there */
  /* The new file gets the permissions of the file that it will replace, so that a private file stays private. */
  const mode_t mode = is_there ? status.st_mode & 0777 : 0666;
  const int descriptor = open(partial, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  /* Adds permissions that the umask removed. A failure is ignored, because some file systems have no permissions. */
  if (descriptor >= 0 && is_there) (void)fchmod(descriptor, mode);
  return descriptor;
}

static int open_target(sig_output_stream *stream, const char *path, size_t length) {
  int is_direct;
  int code = sig_find_target(path, length, &stream->target, &is_direct);
  if (code) return code;
  if (!is_direct) {
    stream->partial = sig_join_text(stream->target, strlen(stream->target), ".partial");
    if (!stream->partial) return ENOMEM;
  }
  if (!is_direct) sig_note_partial_file(stream->partial, strlen(stream->partial));
  stream->descriptor = is_direct ? open_direct(stream->target) : open_partial(stream->partial, stream->target);
  return stream->descriptor < 0 ? errno : 0;
}

static void free_stream(sig_output_stream *stream) {
  if (stream->partial) sig_forget_partial_file(stream->partial, strlen(stream->partial));
  free(stream->partial);
  free(stream->target);
  free(stream);
}

int sig_output_open(const char *path, size_t length, sig_output_stream **stream) {
  *stream = calloc(1, sizeof **stream);
  if (!*stream) return ENOMEM;
  (*stream)->descriptor = STDOUT_FILENO;
  const int code = length > 0 ? open_target(*stream, path, length) : 0;
  if (!code) return 0;
  free_stream(*stream);
  *stream = NULL;
  return code;
}

static void empty_buffer(sig_output_stream *stream) {
  if (!stream->code) stream->code = sig_write_all(stream->descriptor, stream->buffer, stream->n);
  stream->n = 0;
}

int sig_output_write(sig_output_stream *stream, const char *text, size_t size) {
  while (size > 0 && !stream->code) {
    const size_t room = buffer_size - stream->n, n = size < room ? size : room;
    memcpy(stream->buffer + stream->n, text, n);
    stream->n += n;
    text += n;
    size -= n;
    if (stream->n == buffer_size) empty_buffer(stream);
  }
  return stream->code;
}

int sig_output_close(sig_output_stream *stream, int is_kept) {
  empty_buffer(stream);
  int code = stream->code;
  if (stream->partial && !code && is_kept && fsync(stream->descriptor) != 0) code = errno;
  if (stream->descriptor != STDOUT_FILENO && close(stream->descriptor) != 0 && !code) code = errno;
  if (stream->partial && !code && is_kept && rename(stream->partial, stream->target) != 0) code = errno;
  if (stream->partial && !code && is_kept) sig_sync_folder_of(stream->target);
  if (stream->partial && (code || !is_kept)) unlink(stream->partial);
  free_stream(stream);
  if (code) sig_let_end_pass();
  return code;
}
