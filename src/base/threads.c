/* SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE /* sched_getaffinity */
#include "signorom/threads.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct {
  pthread_t thread;
  int is_started;
  int i;
  void (*work)(int i, void *data);
  void *data;
} share_t;

static void *do_share(void *argument) {
  const share_t *share = argument;
  share->work(share->i, share->data);
  return NULL;
}

void sig_run_threads(int n, void (*work)(int i, void *data), void *data) {
  share_t *shares = n > 1 ? calloc((size_t)n, sizeof *shares) : NULL;
  for (int i = 1; i < n && shares; i++) {
    shares[i] = (share_t){.i = i, .work = work, .data = data};
    shares[i].is_started = pthread_create(&shares[i].thread, NULL, do_share, &shares[i]) == 0;
  }
  work(0, data);
  for (int i = 1; i < n; i++) {
    if (shares && shares[i].is_started)
      pthread_join(shares[i].thread, NULL);
    else
      work(i, data);
  }
  free(shares);
}

int sig_processor_count(void) {
  cpu_set_t mine; /* a queue of a cluster, mpirun or taskset may give less than the machine has */
  if (sched_getaffinity(0, sizeof mine, &mine) == 0) return CPU_COUNT(&mine);
  const long n = sysconf(_SC_NPROCESSORS_ONLN);
  return n > 0 ? (int)n : 1;
}
