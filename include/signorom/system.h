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

#endif
