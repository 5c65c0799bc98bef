/* SPDX-License-Identifier: BSD-3-Clause */
#include <stdio.h>
#include <string.h>

#include "signorom/memory.h"

enum { LONGEST_PATH = 1024 };

/* [bytes] Memory of the machine; 0 if unknown. */
static double total_memory(const char *root) {
  char path[LONGEST_PATH], line[256];
  double kilobytes = 0;
  snprintf(path, sizeof path, "%s/proc/meminfo", root);
  FILE *file = fopen(path, "r");
  if (!file) return 0;
  while (fgets(line, sizeof line, file))
    if (sscanf(line, "MemTotal: %lf", &kilobytes) == 1) break;
  fclose(file);
  return 1024 * kilobytes;
}

/* Lowers `least` to the limit in a file, if there is one; the word `max` of version 2 is none. */
static void take_limit(const char *path, double *least) {
  double limit;
  FILE *file = fopen(path, "r");
  if (!file) return;
  if (fscanf(file, "%lf", &limit) == 1 && limit > 0 && limit < *least) *least = limit;
  fclose(file);
}

/* Takes the limits of a group and of all groups above it. In a container the path may be that of another mount, so that
 * only its last step, the root of the mount, exists. */
static void take_limits_of(const char *root, const char *mount, char *group, const char *name, double *least) {
  char path[2 * LONGEST_PATH];
  for (;;) {
    snprintf(path, sizeof path, "%s%s%s/%s", root, mount, group, name);
    take_limit(path, least);
    char *slash = strrchr(group, '/');
    if (!slash) return;
    *slash = '\0';
  }
}

double sig_machine_memory(const char *root) {
  char line[LONGEST_PATH], path[LONGEST_PATH];
  const double total = total_memory(root);
  double least = total > 0 ? total : 1e300;
  snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
  FILE *file = fopen(path, "r");
  while (file && fgets(line, sizeof line, file)) {
    line[strcspn(line, "\n")] = '\0';
    /* number:controllers:path; version 2 names no controllers */
    char *controllers = strchr(line, ':');
    char *group = controllers ? strchr(controllers + 1, ':') : NULL;
    if (!group) continue;
    *group++ = '\0';
    if (controllers[1] == '\0')
      take_limits_of(root, "/sys/fs/cgroup", group, "memory.max", &least);
    else if (strstr(controllers, "memory"))
      take_limits_of(root, "/sys/fs/cgroup/memory", group, "memory.limit_in_bytes", &least);
  }
  if (file) fclose(file);
  return least < 1e300 ? least : 0;
}
