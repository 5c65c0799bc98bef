/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/signals.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "signorom/partial_files.h"

/* [s] Longest waits at the end of the grace time: for a write in progress, and for the end of the other processes. */
static const double longest_write = 0.2;
static const unsigned longest_farewell = 1;

/* A signal handler can use static variables only. The other variables here are shared by the watching thread and the
 * threads that it ends. */
static volatile sig_atomic_t is_stop_wished = 0;
static volatile sig_atomic_t has_watcher = 0;
static volatile sig_atomic_t has_launcher_asked = 0;
static volatile sig_atomic_t stop_helper = 0;
static sem_t stop_wish;
static double stop_grace = 1;
static void (*end_of_others)(void) = NULL;
static char last_words[256];
static int words_descriptor = STDOUT_FILENO;
static pthread_mutex_t words_lock = PTHREAD_MUTEX_INITIALIZER;

/* Ends the process without removing files or writing the last words; also used where there is no watching thread. */
static void end_at_once(int number) {
  (void)number;
  if (stop_helper) kill((pid_t)stop_helper, SIGKILL);
  _exit(SIG_EXIT_STOPPED);
}

static void note_stop(int number, siginfo_t *info, void *context) {
  const int code = errno;
  (void)number, (void)context;
  if (!is_stop_wished) {
    is_stop_wished = 1;
    has_launcher_asked = info->si_code == SI_USER && info->si_pid == getppid();
    if (stop_helper) kill((pid_t)stop_helper, SIGTERM);
    if (has_watcher)
      sem_post(&stop_wish);
    else
      alarm(1);
  }
  errno = code;
}

static void say_last_words(void) {
  pthread_mutex_lock(&words_lock);
  /* the line of the terminal may hold a progress bar */
  if (last_words[0] && isatty(STDERR_FILENO)) (void)!write(STDERR_FILENO, "\n", 1);
  (void)!write(words_descriptor, last_words, strlen(last_words));
  pthread_mutex_unlock(&words_lock);
}

/* The watching thread: sleeps until a signal comes, and then for the grace time. If the process still runs then, it has
 * not stopped by itself, and this thread ends it. */
static void *watch(void *nothing) {
  (void)nothing;
  while (sem_wait(&stop_wish) != 0) continue;
  struct timespec rest = {.tv_sec = (time_t)stop_grace};
  rest.tv_nsec = (long)(1e9 * (stop_grace - (double)rest.tv_sec));
  while (nanosleep(&rest, &rest) != 0) continue;
  alarm(longest_farewell);
  sig_remove_partial_files(longest_write);
  say_last_words();
  /* A launcher like mpirun ends the other processes itself. */
  if (end_of_others && !has_launcher_asked) end_of_others();
  end_at_once(0);
  return NULL;
}

/* Starts the watching thread, which receives no signals and has a small stack. Returns 1 if it has started. */
static int start_watcher(void) {
  const size_t stack_size = 256 * 1024;
  pthread_t thread;
  pthread_attr_t attributes;
  sigset_t all, before;
  if (sem_init(&stop_wish, 0, 0) != 0 || pthread_attr_init(&attributes) != 0) return 0;
  pthread_attr_setstacksize(&attributes, stack_size);
  pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const int is_started = pthread_create(&thread, &attributes, watch, NULL) == 0;
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  pthread_attr_destroy(&attributes);
  return is_started;
}

static void install_handlers(void) {
  struct sigaction stop, end;
  memset(&stop, 0, sizeof stop);
  stop.sa_sigaction = note_stop;
  stop.sa_flags = SA_RESTART | SA_SIGINFO; /* reads and writes in progress go on */
  sigemptyset(&stop.sa_mask);
  memset(&end, 0, sizeof end);
  end.sa_handler = end_at_once;
  sigemptyset(&end.sa_mask);
  sigaction(SIGALRM, &end, NULL);
  sigaction(SIGINT, &stop, NULL);
  sigaction(SIGTERM, &stop, NULL);
}

void sig_install_stop_signals(double grace) {
  is_stop_wished = 0;
  stop_grace = grace;
  if (!has_watcher) has_watcher = start_watcher();
  install_handlers();
  // A file at the limit of its size makes write() fail, and the caller reports this. The signal must not end the
  // process.
  signal(SIGXFSZ, SIG_IGN);
}

void sig_set_stop_grace(double grace) { stop_grace = grace; }

int sig_is_stop_requested(void) { return is_stop_wished != 0; }

void sig_set_last_words(const char *text, size_t length, int descriptor) {
  const size_t n = length < sizeof last_words - 2 ? length : sizeof last_words - 2;
  pthread_mutex_lock(&words_lock);
  memcpy(last_words, text, n);
  if (n > 0) last_words[n] = '\n';
  last_words[n > 0 ? n + 1 : 0] = '\0';
  words_descriptor = descriptor;
  pthread_mutex_unlock(&words_lock);
}

void sig_set_end_of_others(void (*end_others)(void)) { end_of_others = end_others; }

void sig_set_stop_helper(pid_t helper) { stop_helper = (sig_atomic_t)helper; }

int sig_is_terminal(int descriptor) { return isatty(descriptor) == 1; }
