/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/partial_files.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* Names of the partial files of the process. They are removed when a signal ends the process by force. There are never
 * more than a few at a time. A file for which the list has no room is not removed. */
enum { MAX_FILES = 16 };
static char *partial_files[MAX_FILES];
static pthread_mutex_t files_lock = PTHREAD_MUTEX_INITIALIZER;

void sig_note_partial_file(const char *name, size_t length) {
  char *copy = malloc(length + 1);
  if (!copy) return;
  memcpy(copy, name, length);
  copy[length] = '\0';
  pthread_mutex_lock(&files_lock);
  for (int i = 0; i < MAX_FILES && copy; i++) {
    if (partial_files[i]) continue;
    partial_files[i] = copy;
    copy = NULL;
  }
  pthread_mutex_unlock(&files_lock);
  free(copy);
}

void sig_forget_partial_file(const char *name, size_t length) {
  pthread_mutex_lock(&files_lock);
  for (int i = 0; i < MAX_FILES; i++) {
    char *noted = partial_files[i];
    if (!noted || strlen(noted) != length || memcmp(noted, name, length) != 0) continue;
    partial_files[i] = NULL;
    free(noted);
    break;
  }
  pthread_mutex_unlock(&files_lock);
}

void sig_begin_writing(void) { pthread_mutex_lock(&files_lock); }

void sig_end_writing(void) { pthread_mutex_unlock(&files_lock); }

/* Does not return if another thread ends the process, because that thread keeps the lock. */
void sig_let_end_pass(void) {
  pthread_mutex_lock(&files_lock);
  pthread_mutex_unlock(&files_lock);
}

void sig_remove_partial_files(double seconds) {
  struct timespec until;
  clock_gettime(CLOCK_REALTIME, &until);
  const long nanoseconds = until.tv_nsec + (long)(seconds * 1e9);
  until.tv_sec += nanoseconds / 1000000000;
  until.tv_nsec = nanoseconds % 1000000000;
  /* A thread that holds the lock for a longer time waits for the file system, and does not change the names. */
  (void)pthread_mutex_timedlock(&files_lock, &until);
  for (int i = 0; i < MAX_FILES; i++)
    if (partial_files[i]) unlink(partial_files[i]);
}
