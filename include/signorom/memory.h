/* SPDX-License-Identifier: BSD-3-Clause */
/* Memory of the machine; address space of the process and its limit (ulimit -v). */
#ifndef SIG_MEMORY_H
#define SIG_MEMORY_H

/* Gives the largest address space that the process has taken so far, and its limit [bytes]. The limit is 0 where there
 * is none, the peak is 0 where the system does not tell it. */
void sig_memory_use(double *peak, double *limit);

/* Call these two before and after a library call that may ask for memory again and again without an end. After one
 * second of processor time between the two, the process ends with exit code 2 and a message. */
void sig_begin_memory_watch(void);
void sig_end_memory_watch(void);

/* Ends the process with exit code 2 and a message if less than `n_bytes` are left below the limit. Does nothing if
 * there is no limit. */
void sig_need_memory(double n_bytes);

/* From here on, freed blocks of 1 MB and more go back to the system at once. Else blocks of many megabytes that come
 * and go, as those of columns of responses do, leave holes among small blocks, and the process grows by the half. */
void sig_return_large_blocks(void);

/* Returns the memory that the processes of this machine may take together [bytes]: that of the machine, or the smallest
 * limit of the control groups of this process (version 2 or 1) if that is less; 0 where the system does not tell it. It
 * does not depend on what is free now. `root` is empty, or, for tests, a folder that holds copies of /proc and /sys. */
double sig_machine_memory(const char *root);

#endif
