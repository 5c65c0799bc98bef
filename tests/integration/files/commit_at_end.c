/* SPDX-License-Identifier: BSD-3-Clause */
/* usage: commit_at_end FILE NEW_NAME [ends]
 * Removes FILE and gives it its new name, which fails; with "ends" the removal is that of a process which is being
 * ended. Prints what the failure was where the call returns. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "signorom/file_system.h"
#include "signorom/partial_files.h"

static void *end(void *nothing) {
  sig_remove_partial_files(5.0);
  pause();
  return nothing;
}

int main(int argc, char **argv) {
  pthread_t thread;
  if (argc < 3) return 2;
  sig_note_partial_file(argv[1], strlen(argv[1]));
  if (argc > 3 && pthread_create(&thread, NULL, end, NULL) != 0) return 2;
  if (argc == 3) unlink(argv[1]);
  while (access(argv[1], F_OK) == 0) usleep(1000);
  alarm(2); /* the end of the process */
  printf("%d\n", sig_commit_file(argv[1], strlen(argv[1]), argv[2], strlen(argv[2])));
  return 0;
}
