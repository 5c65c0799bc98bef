/* SPDX-License-Identifier: BSD-3-Clause */
/* Address space of the process and its limit (ulimit -v). */
#ifndef SIG_MEMORY_H
#define SIG_MEMORY_H

/* Most that the process ever took, and what it may take [bytes]; the limit is 0 where there is none. */
void sig_memory_use(double *peak, double *limit);

/* Between these two some library asks for memory, perhaps again and again without an end. After seconds of processor
 * time in it the process ends with exit code 2 and a sentence. */
void sig_begin_memory_watch(void);
void sig_end_memory_watch(void);

/* Ends the process with exit code 2 and a sentence where less than so many bytes are left below the limit. */
void sig_need_memory(double n_bytes);

#endif
