/* SPDX-License-Identifier: BSD-3-Clause */
/* Requests to stop by SIGINT or SIGTERM, the forced end of a process that does not stop in time, and whether a
 * descriptor is a terminal. */
#ifndef SIG_SIGNALS_H
#define SIG_SIGNALS_H

#include <stddef.h>
#include <sys/types.h>

/* Exit code of a process that a signal ended. */
enum { SIG_EXIT_STOPPED = 130 };

/* Catches SIGINT and SIGTERM from now on; an earlier request is forgotten. A process that still runs `grace` seconds
 * after the first signal ends with SIG_EXIT_STOPPED, whatever it does then: partial files are removed
 * (partial_files.h), a helper is killed, and the last words are written. SIGXFSZ is ignored from now on, so that a
 * write beyond the largest size of a file fails with an errno. */
void sig_install_stop_signals(double grace);

/* Changes the time [s] between the next signal and the forced end. */
void sig_set_stop_grace(double grace);

/* Returns 1 after a signal has come, else 0. Any thread may call it. */
int sig_is_stop_requested(void);

/* Sets the text that a process writes to a descriptor when its grace time is over; empty = no text. The text is cut
 * after 254 bytes. A line end follows. */
void sig_set_last_words(const char *text, size_t length, int descriptor);

/* Sets a function that is called before the forced end of the process, so that it can end other processes that wait for
 * this one. It is not called if the parent process (a launcher such as mpirun) has sent the signal. */
void sig_set_end_of_others(void (*end_others)(void));

/* Sets the helper process: it gets SIGTERM with the request to stop, and SIGKILL at the forced end; 0 = none. */
void sig_set_stop_helper(pid_t helper);

/* Returns 1 if the file descriptor is a terminal, else 0. */
int sig_is_terminal(int descriptor);

#endif
