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

/* Waits for the helper and returns its exit code, or NOT_STARTED if the system does not know it. */
static int wait_for(pid_t helper) {
  int status;
  pid_t ended;
  do ended = waitpid(helper, &status, 0);
  while (ended < 0 && errno == EINTR);
  if (ended < 0) return NOT_STARTED;
  return WIFEXITED(status) ? WEXITSTATUS(status) : KILLED + WTERMSIG(status);
}

int sig_run_shell(const char *command) {
  const char *const arguments[] = {"sh", "-c", command, NULL};
  pid_t helper;
  int code = NOT_STARTED;
  /* The program that started this one may have made it ignore SIGCHLD; then the system forgets the exit code of the
   * helper. */
  struct sigaction usual = {.sa_handler = SIG_DFL}, before;
  sigaction(SIGCHLD, &usual, &before);
  /* The arguments of posix_spawn are not const, but it does not write to them. */
  if (posix_spawn(&helper, "/bin/sh", NULL, NULL, (char *const *)(uintptr_t)arguments, environ) == 0) {
    sig_set_stop_helper(helper);
    /* The signal may have come before the helper was set. */
    if (sig_is_stop_requested()) kill(helper, SIGTERM);
    code = wait_for(helper);
    sig_set_stop_helper(0);
  }
  sigaction(SIGCHLD, &before, NULL);
  return code;
}
