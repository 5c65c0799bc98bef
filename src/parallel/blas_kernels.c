/* SPDX-License-Identifier: BSD-3-Clause */
#define _GNU_SOURCE
#include "signorom/blas_kernels.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char variable[] = "OPENBLAS_CORETYPE";
/* What OpenBLAS takes for a processor that it does not know. */
static const char unknown[] = "Prescott";

/* Returns the name of the kernels that OpenBLAS uses; NULL with another BLAS. */
static const char *kernels_in_use(void) {
  const char *(*name)(void) = NULL;
  void *symbol = dlsym(RTLD_DEFAULT, "openblas_get_corename");
  /* ISO C has no conversion from an object pointer to a function pointer */
  memcpy(&name, &symbol, sizeof name);
  return name ? name() : NULL;
}

/* Returns the name of kernels that suit the processor; NULL if those for unknown processors do. */
static const char *suitable_kernels(void) {
#if defined __x86_64__
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return "SkylakeX";
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return "Haswell";
#endif
  return NULL;
}

/* Returns the arguments of this process, as exec wants them; NULL if the system does not tell them. */
static char **own_arguments(void) {
  char *text = NULL, **arguments = NULL;
  size_t room = 0;
  int n = 0;
  FILE *file = fopen("/proc/self/cmdline", "r");
  if (!file) return NULL;
  while (getdelim(&text, &room, '\0', file) > 0) {
    char **more = realloc(arguments, (size_t)(n + 2) * sizeof *arguments);
    if (!more) break;
    arguments = more;
    arguments[n++] = text;
    arguments[n] = text = NULL;
    room = 0;
  }
  free(text);
  fclose(file);
  return arguments;
}

void sig_take_fast_blas(void) {
  char program[4096];
  const char *used = kernels_in_use(), *suitable = suitable_kernels();
  if (getenv(variable) || !used || strcmp(used, unknown) != 0 || !suitable) return;
  char **arguments = own_arguments();
  /* the path itself, because tools such as top show the last word of what was started */
  const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
  if (!arguments || length < 0 || setenv(variable, suitable, 0) != 0) return;
  program[length] = '\0';
  execv(program, arguments);
  /* it returns only if it failed; the slower kernels do the work */
}
