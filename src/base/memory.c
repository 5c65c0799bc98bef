/* SPDX-License-Identifier: BSD-3-Clause */
#define _DEFAULT_SOURCE /* setitimer */
#include "signorom/memory.h"

#include <malloc.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

enum { EXIT_USER = 2 };

/* [s] Limit of the processor time between begin and end of the watch; normally it is less than a millisecond. */
static const long longest_wait = 1;
/* Text that the signal handler writes; a handler can use static variables only. */
static char sentence[256];

void sig_memory_use(double *peak, double *limit) {
  struct rlimit bounds;
  char line[128];
  *peak = *limit = 0;
  if (getrlimit(RLIMIT_AS, &bounds) == 0 && bounds.rlim_cur != RLIM_INFINITY) *limit = (double)bounds.rlim_cur;
  FILE *status = fopen("/proc/self/status", "r");
  if (!status) return;
  while (fgets(line, sizeof line, status))
    if (sscanf(line, "VmPeak: %lf", peak) == 1) *peak *= 1024;
  fclose(status);
}

void sig_return_large_blocks(void) { mallopt(M_MMAP_THRESHOLD, 1 << 20); }

static void give_up(int number) {
  (void)number;
  (void)!write(STDERR_FILENO, sentence, strlen(sentence));
  _exit(EXIT_USER);
}

static void set_timer(long seconds) {
  const struct itimerval timer = {.it_value.tv_sec = seconds};
  setitimer(ITIMER_PROF, &timer, NULL);
}

void sig_begin_memory_watch(void) {
  struct sigaction action;
  double peak, limit;
  sig_memory_use(&peak, &limit);
  if (limit > 0)
    snprintf(sentence, sizeof sentence,
             "error: too little memory: this process may take %.0f MB of address space (ulimit -v) and takes %.0f MB; "
             "the linear algebra library (BLAS) needs more, OpenBLAS 128 MB\n",
             limit / 1e6, peak / 1e6);
  else
    snprintf(sentence, sizeof sentence, "error: too little memory for the linear algebra library (BLAS)\n");
  memset(&action, 0, sizeof action);
  action.sa_handler = give_up;
  sigemptyset(&action.sa_mask);
  sigaction(SIGPROF, &action, NULL);
  set_timer(longest_wait);
}

void sig_end_memory_watch(void) {
  set_timer(0);
  signal(SIGPROF, SIG_DFL);
}

void sig_need_memory(double n_bytes) {
  double peak, limit;
  sig_memory_use(&peak, &limit);
  if (limit <= 0 || limit - peak >= n_bytes) return;
  snprintf(sentence, sizeof sentence,
           "error: too little memory: this process may take %.0f MB of address space (ulimit -v), takes %.0f MB before "
           "any work and needs at least %.0f MB more\n",
           limit / 1e6, peak / 1e6, n_bytes / 1e6);
  give_up(0);
}
