/* SPDX-License-Identifier: BSD-3-Clause */
/* Files and folders. Paths are pointer + length, without terminator. Functions return 0 or an errno unless they say
 * otherwise. */
#ifndef SIG_FILE_SYSTEM_H
#define SIG_FILE_SYSTEM_H

#include <stddef.h>

/* Kinds of what a path leads to: nothing, a file, a folder, or something else, such as a device or a pipe. */
enum sig_file_kind { SIG_NO_FILE = 0, SIG_PLAIN_FILE = 1, SIG_DIRECTORY = 2, SIG_OTHER_FILE = 3 };

/* Returns a value of enum sig_file_kind; links are followed. SIG_NO_FILE also if the path cannot be looked at. */
int sig_file_kind(const char *path, size_t length);

/* Makes a folder and the missing folders above it, as mkdir -p does. An existing folder is no error. */
int sig_make_directories(const char *path, size_t length);

/* Reads a whole file into a new block of `*size` bytes. The caller frees it with sig_free. */
int sig_read_file(const char *path, size_t length, char **bytes, size_t *size);

/* Read a file, a device or a pipe piece by piece. sig_read_some reads the bytes that are there now, at most `size`;
 * *n_read is 0 at the end of the file. */
int sig_open_to_read(const char *path, size_t length, int *descriptor);
int sig_read_some(int descriptor, char *bytes, size_t size, size_t *n_read);
void sig_close_descriptor(int descriptor);

/* Writes `<path>.partial`, fsyncs it, renames it to `path`; on failure `path` is as it was and the partial file is
 * gone. Symbolic links are followed first; a device or a pipe is written to as it is. */
int sig_write_file(const char *path, size_t length, const char *bytes, size_t size);

/* fsyncs `from`, renames it to `to` (replacing it) and fsyncs the folder. */
int sig_commit_file(const char *from, size_t from_length, const char *to, size_t to_length);

/* Writes the folder of a renamed file to the disk, so that the new name survives a crash. `name` is null-terminated. */
void sig_sync_folder_of(const char *name);

/* Removes a file, but no folder. A missing file is an error (ENOENT). */
int sig_remove_file(const char *path, size_t length);

/* Locks the file `path`, which it makes if it is missing, without waiting, and writes the process number into it.
 * Several processes may hold a shared lock, none of which leaves its number. The lock ends with the descriptor or with
 * the process. EWOULDBLOCK: another process holds the lock; `*process` is its number, 0 if unknown. ELOOP: the file is
 * a link or not a plain file. */
int sig_lock_file(const char *path, size_t length, int is_shared, int *descriptor, long *process);

/* Ends a lock; its file stays. Does nothing for a negative descriptor. */
void sig_unlock_file(int descriptor);

/* Lists the files of a folder whose names start with `prefix`, in byte order. Each name ends with a null; all stand in
 * one block of `*size` bytes, which the caller frees with sig_free. Folders and names with a leading dot are left out.
 */
int sig_list_files(const char *path, size_t length, const char *prefix, size_t prefix_length, char **names,
                   size_t *size);

/* Gives the path of the running program with links resolved, null-terminated. Returns ENAMETOOLONG where the path needs
 * more than `size` bytes. */
int sig_program_path(char *path, size_t size);

#endif
