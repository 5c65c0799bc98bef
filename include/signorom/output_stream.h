/* SPDX-License-Identifier: BSD-3-Clause */
/* Text on its way to a file, a device, a pipe or the standard output, with every write checked. Functions return 0 or
 * an errno. */
#ifndef SIG_OUTPUT_STREAM_H
#define SIG_OUTPUT_STREAM_H

#include <stddef.h>

typedef struct sig_output_stream sig_output_stream;

/* Finds the file that a path leads to for writing, with its symbolic links followed. *target is a new text for
 * sig_free. *is_direct is 0 for a plain file or a new one, which is replaced as a whole. It is 1 for anything else,
 * such as a device or a pipe, which is written to and never replaced. */
int sig_find_target(const char *path, size_t length, char **target, int *is_direct);

/* Opens a stream. An empty path is the standard output. An existing file keeps its access mode. *stream is null after a
 * failure. */
int sig_output_open(const char *path, size_t length, sig_output_stream **stream);

/* Writes a text. After a failure later writes do nothing and return the first errno again. */
int sig_output_write(sig_output_stream *stream, const char *text, size_t size);

/* Writes what is left and frees the stream. A file gets its name if `is_kept` and nothing failed; else it is removed,
 * and an earlier file of this name stays. */
int sig_output_close(sig_output_stream *stream, int is_kept);

#endif
