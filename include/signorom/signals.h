/* SPDX-License-Identifier: BSD-3-Clause */
/* Wish to stop, by SIGINT or SIGTERM; the end of a process that cannot fulfill it in time; and whether somebody
 * watches. */
#ifndef SIG_SIGNALS_H
#define SIG_SIGNALS_H

#include <stddef.h>
#include <sys/types.h>

/* Exit code of a process that a signal ended. */
enum { SIG_EXIT_STOPPED = 130 };

/* Catches SIGINT and SIGTERM from now on; a wish that came before is forgotten. A process that still lives `grace`
 * seconds after the first signal ends with SIG_EXIT_STOPPED, whatever it does then: half-written files are removed
 * (partial_files.h), a helper is killed, the last words are said. */
void sig_install_stop_signals(double grace);

/* Another time [s] for the end that the next signal brings. */
void sig_set_stop_grace(double grace);

/* 1 once a signal came, else 0. For any thread. */
int sig_is_stop_requested(void);

/* What a process says on a descriptor when its grace is over; empty = nothing. Cut after some 200 bytes. */
void sig_set_last_words(const char *text, size_t length, int descriptor);

/* Called before a process ends whose grace is over, so that it may end others that wait for it. */
void sig_set_end_of_others(void (*end_others)(void));

/* Process that SIGTERM reaches with the wish to stop, and SIGKILL at the end; 0 = none. */
void sig_set_stop_helper(pid_t helper);

/* 1 if the file descriptor is a terminal, else 0. */
int sig_is_terminal(int descriptor);

#endif
