/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are being written beside the place they will take. A signal that ends the process removes them. Names are
 * pointer + length. For any thread. */
#ifndef SIG_PARTIAL_FILES_H
#define SIG_PARTIAL_FILES_H

#include <stddef.h>

/* Notes a file as incomplete from now on. There is space for 16 files; a file beyond them is not noted. */
void sig_note_partial_file(const char *name, size_t length);

/* Forgets a file that has its final name now or was removed. A name that was never noted is no error. */
void sig_forget_partial_file(const char *name, size_t length);

/* A process that a signal ends does not end between these two calls, unless the wait of sig_remove_partial_files is
 * over. They protect writes into a file that must stay. Keep the time between them short. */
void sig_begin_writing(void);
void sig_end_writing(void);

/* Call this after a failed operation on a file. If a signal is ending the process, it does not return: the operation
 * may have failed only because the partial files were removed. */
void sig_let_end_pass(void);

/* Removes all noted files. It waits up to `seconds` for threads that are between sig_begin_writing and sig_end_writing.
 * The process must end afterwards. */
void sig_remove_partial_files(double seconds);

#endif
