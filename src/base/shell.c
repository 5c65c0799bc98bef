/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/shell.h"

#include <errno.h>
#include <signal.h>
#include <spawn.h>
#include <stdint.h>
#include <sys/types.h>
#include <sys/wait.h>

#include "signorom/signals.h"

extern char **environ;

enum { NOT_STARTED = 127, KILLED = 128 };

int sig_run_shell(const char *command) {
  /* The arguments of posix_spawn are not const, but it does not write to them. */
  char *const arguments[] = {(char *)(uintptr_t) "sh", (char *)(uintptr_t) "-c", (char *)(uintptr_t)command, NULL};
  pid_t helper;
  int status;
  if (posix_spawn(&helper, "/bin/sh", NULL, NULL, arguments, environ) != 0) return NOT_STARTED;
  sig_set_stop_helper(helper);
  /* The signal may have come before the helper was set. */
  if (sig_is_stop_requested()) kill(helper, SIGTERM);
  while (waitpid(helper, &status, 0) < 0 && errno == EINTR) continue;
  sig_set_stop_helper(0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : KILLED + WTERMSIG(status);
}
