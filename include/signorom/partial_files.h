/* SPDX-License-Identifier: BSD-3-Clause */
/* Files that are being written beside the place they will take. A signal that ends the process removes them. Names are
 * pointer + length. For any thread. */
#ifndef SIG_PARTIAL_FILES_H
#define SIG_PARTIAL_FILES_H

#include <stddef.h>

/* This file is not whole from now on. */
void sig_note_partial_file(const char *name, size_t length);

/* It has its place now, or is gone. A name that nobody noted is no error. */
void sig_forget_partial_file(const char *name, size_t length);

/* The process may not end between these two: for writing into a file that must stay. Keep it short. */
void sig_begin_writing(void);
void sig_end_writing(void);

/* After a failure with a file: does not return where the process is being ended, whose files are gone then. */
void sig_let_end_pass(void);

/* Removes what was noted. Waits up to `seconds` for who is between sig_begin_writing and sig_end_writing. The process
 * must end afterwards. */
void sig_remove_partial_files(double seconds);

#endif
