/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/signals.h"

#include <signal.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Second of the first signal, counted from an arbitrary start; 0 = none came. A handler can reach nothing but a static.
 */
static volatile sig_atomic_t stop_second = 0;

static void note_stop(int number) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  /* Never 0, and small enough for any sig_atomic_t. */
  const int second = 1 + (int)(now.tv_sec % 1000000);
  if (stop_second == 0) {
    stop_second = second;
    return;
  }
  /* mpirun and timeout send a signal twice in a row; a person who asks again has waited. */
  if (second - stop_second >= 0 && second - stop_second < 2) return;
  signal(number, SIG_DFL);
  raise(number);
}

void sig_install_stop_signals(void) {
  struct sigaction action;
  memset(&action, 0, sizeof action);
  action.sa_handler = note_stop;
  action.sa_flags = SA_RESTART; /* reads and writes in progress go on */
  sigemptyset(&action.sa_mask);
  stop_second = 0;
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);
  // A file that may not grow any more is an error of write, which the caller reports, and no reason to die.
  signal(SIGXFSZ, SIG_IGN);
}

int sig_is_stop_requested(void) { return stop_second != 0; }

int sig_is_terminal(int descriptor) { return isatty(descriptor) == 1; }
