/* SPDX-License-Identifier: BSD-3-Clause */
/* A few threads that do one piece of work together. */
#ifndef SIG_THREADS_H
#define SIG_THREADS_H

/* Calls work(i, data) for i = 0 .. n - 1 at the same time and waits for all. What cannot have a thread of its own is
 * done by the caller's. */
void sig_run_threads(int n, void (*work)(int i, void *data), void *data);

/* Processors that this process may use. */
int sig_processor_count(void);

#endif
