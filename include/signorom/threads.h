/* SPDX-License-Identifier: BSD-3-Clause */
/* Threads that share one piece of work. */
#ifndef SIG_THREADS_H
#define SIG_THREADS_H

/* Calls work(i, data) for i = 0 .. n - 1, n >= 1, each in a thread of its own, and waits for all. Where a thread cannot
 * be started, the calling thread does its share. */
void sig_run_threads(int n, void (*work)(int i, void *data), void *data);

/* Returns the number of processors that this process may use, at least 1. */
int sig_processor_count(void);

#endif
