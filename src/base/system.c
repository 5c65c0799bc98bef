/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/system.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

char *sig_copy_text(const char *text, size_t length) {
  char *copy = malloc(length + 1);
  if (!copy) return NULL;
  memcpy(copy, text, length);
  copy[length] = '\0';
  return copy;
}

char *sig_join_text(const char *first, size_t length, const char *second) {
  char *joined = malloc(length + strlen(second) + 1);
  if (!joined) return NULL;
  memcpy(joined, first, length);
  strcpy(joined + length, second);
  return joined;
}

void sig_free(void *block) { free(block); }

void sig_error_text(int code, char *text, size_t size) {
  if (strerror_r(code, text, size) != 0) snprintf(text, size, "system error %d", code);
}

int sig_write_all(int descriptor, const char *bytes, size_t size) {
  while (size > 0) {
    const ssize_t n = write(descriptor, bytes, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    bytes += n;
    size -= (size_t)n;
  }
  return 0;
}

int sig_open_to_append(const char *path, size_t length, int *descriptor) {
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  *descriptor = open(name, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  const int code = *descriptor < 0 ? errno : 0;
  free(name);
  return code;
}

int sig_terminal_columns(int descriptor) {
  struct winsize size;
  return ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}
