/* SPDX-License-Identifier: BSD-3-Clause */
/* Another program as a helper. */
#ifndef SIG_SHELL_H
#define SIG_SHELL_H

/* Runs a command by the shell and waits: its exit code, 128 + number where a signal ended it, 127 where it could not be
 * started. Unlike system() it listens to signals meanwhile: a wish to stop ends the helper (signals.h). */
int sig_run_shell(const char *command);

#endif
