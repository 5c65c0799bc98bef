/* SPDX-License-Identifier: BSD-3-Clause */
/* Functions of the system that every layer needs: texts and blocks in memory, error texts, output to a descriptor. */
#ifndef SIG_SYSTEM_H
#define SIG_SYSTEM_H

#include <stddef.h>

/* Gives the system's message for an errno, null-terminated, cut at `size` bytes. */
void sig_error_text(int code, char *text, size_t size);

/* Returns a null-terminated copy of a text, for sig_free; null when out of memory. */
char *sig_copy_text(const char *text, size_t length);

/* Returns the first `length` characters of `first` followed by `second`, for sig_free; null when out of memory. */
char *sig_join_text(const char *first, size_t length, const char *second);

/* Frees a block that a function of this program returned "for sig_free"; null is no error. */
void sig_free(void *block);

/* Writes all the bytes, with several system calls if needed. Returns 0 or an errno. */
int sig_write_all(int descriptor, const char *bytes, size_t size);

/* Opens a file to append to it; a missing file is made. Returns 0 or an errno. */
int sig_open_to_append(const char *path, size_t length, int *descriptor);

/* Returns the number of columns of the terminal of a descriptor; 0 where it is not a terminal or does not tell. */
int sig_terminal_columns(int descriptor);

#endif
