/* SPDX-License-Identifier: BSD-3-Clause */
/* Files and folders. Paths are pointer + length, without terminator. Functions return 0 or an errno unless they say
 * otherwise. */
#ifndef SIG_FILE_SYSTEM_H
#define SIG_FILE_SYSTEM_H

#include <stddef.h>

/* What stands at a path. */
enum sig_file_kind { SIG_NO_FILE = 0, SIG_PLAIN_FILE = 1, SIG_DIRECTORY = 2, SIG_OTHER_FILE = 3 };

int sig_file_kind(const char *path, size_t length);

/* mkdir -p. */
int sig_make_directories(const char *path, size_t length);

/* Whole file into a new block of `*size` bytes; give it back to sig_free. */
int sig_read_file(const char *path, size_t length, char **bytes, size_t *size);

/* A file, a device or a pipe piece by piece: as many bytes as are there now, up to `size`; none at its end. */
int sig_open_to_read(const char *path, size_t length, int *descriptor);
int sig_read_some(int descriptor, char *bytes, size_t size, size_t *n_read);
void sig_close_descriptor(int descriptor);

/* Writes `<path>.partial`, fsyncs it, renames it to `path`; on failure `path` is as it was and the partial file is
 * gone. Symbolic links are followed first; a device or a pipe is written to as it is. */
int sig_write_file(const char *path, size_t length, const char *bytes, size_t size);

/* fsyncs `from`, renames it to `to` (replacing it) and fsyncs the folder. */
int sig_commit_file(const char *from, size_t from_length, const char *to, size_t to_length);

/* Makes the new name of a renamed file safe; null-terminated. */
void sig_sync_folder_of(const char *name);

int sig_remove_file(const char *path, size_t length);

/* Takes `<path>/.lock` without waiting and notes the process number in it. The lock goes with the descriptor or the
 * process. EWOULDBLOCK: another process has it, `*process` is its number, 0 if unknown. ELOOP: it is a link, or no
 * plain file. */
int sig_lock_directory(const char *path, size_t length, int *descriptor, long *process);
void sig_unlock_directory(int descriptor);

/* Names in a folder that start with `prefix`, in byte order, each ended by a null, in one block of `*size` bytes for
 * sig_free. Folders and names with a leading dot are left out. */
int sig_list_files(const char *path, size_t length, const char *prefix, size_t prefix_length, char **names,
                   size_t *size);

/* Path of the running program with links resolved, null-terminated; ENAMETOOLONG where it needs more than `size`. */
int sig_program_path(char *path, size_t size);

#endif
