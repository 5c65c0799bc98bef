/* SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE /* RTLD_DEFAULT */
#include "signorom/blas_kernels.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if defined(__x86_64__) && defined(__linux__)

enum { MOST_ARGUMENTS = 1000, LONGEST_LINE = 1 << 17 };

/* Splits the arguments of this process, as the kernel knows them, into words; 0 where they do not fit. */
static int read_arguments(char *line, char **words) {
  FILE *file = fopen("/proc/self/cmdline", "rb");
  if (!file) return 0;
  const size_t size = fread(line, 1, LONGEST_LINE, file);
  fclose(file);
  if (size == 0 || size == LONGEST_LINE || line[size - 1] != '\0') return 0;
  int n = 0;
  for (char *word = line; word < line + size; word += strlen(word) + 1) {
    if (n == MOST_ARGUMENTS) return 0;
    words[n++] = word;
  }
  words[n] = NULL;
  return n;
}

void sig_choose_blas_kernels(void) {
  /* OpenBLAS knows processors by their models, and takes kernels of 2004 for those that are younger than itself. It
     reads the variable when it is loaded, which has happened by now. */
  static char line[LONGEST_LINE];
  static char *words[MOST_ARGUMENTS + 1];
  const char *(*name)(void);
  *(void **)&name = dlsym(RTLD_DEFAULT, "openblas_get_corename");
  if (!name || strcmp(name(), "Prescott") != 0 || getenv("OPENBLAS_CORETYPE")) return;
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return;
  if (read_arguments(line, words) == 0 || setenv("OPENBLAS_CORETYPE", "Haswell", 1) != 0) return;
  execv("/proc/self/exe", words); /* returns only if it fails */
}

#else

void sig_choose_blas_kernels(void) {}

#endif
