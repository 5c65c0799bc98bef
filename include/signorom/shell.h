/* SPDX-License-Identifier: BSD-3-Clause */
/* Runs another program. */
#ifndef SIG_SHELL_H
#define SIG_SHELL_H

/* Runs a command by the shell, waits for it and returns its exit code: 128 + number where a signal ended it, 127 where
 * it could not be started. Unlike system(), a signal to stop also ends the command (signals.h). */
int sig_run_shell(const char *command);

#endif
