/* SPDX-License-Identifier: BSD-3-Clause */
/* Wish to stop, by SIGINT or SIGTERM; and whether somebody watches. */
#ifndef SIG_SIGNALS_H
#define SIG_SIGNALS_H

/* Catches SIGINT and SIGTERM. The same wish repeated two seconds later or more ends the process as if nothing caught
 * it. */
void sig_install_stop_signals(void);

/* 1 once a signal came, else 0. */
int sig_is_stop_requested(void);

/* 1 if the file descriptor is a terminal, else 0. */
int sig_is_terminal(int descriptor);

#endif
