/* SPDX-License-Identifier: BSD-3-Clause */
/* What every layer needs of the system: texts and blocks in memory, errors in words, bytes to a descriptor. */
#ifndef SIG_SYSTEM_H
#define SIG_SYSTEM_H

#include <stddef.h>

/* The system's words for an errno, null-terminated, cut at `size` bytes. */
void sig_error_text(int code, char *text, size_t size);

/* Null-terminated copy, for sig_free; null when out of memory. */
char *sig_copy_text(const char *text, size_t length);

/* `length` characters of the first text, then the second one; for sig_free; null when out of memory. */
char *sig_join_text(const char *first, size_t length, const char *second);

void sig_free(void *block);

/* All the bytes, whatever a single write takes. */
int sig_write_all(int descriptor, const char *bytes, size_t size);

/* Opens a file to write behind what it holds; it is made where it is missing. 0, or an errno. */
int sig_open_to_append(const char *path, size_t length, int *descriptor);

/* Columns of the terminal of a descriptor; 0 where it is none or does not tell. */
int sig_terminal_columns(int descriptor);

#endif
