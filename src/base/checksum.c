/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/checksum.h"

#include "signorom/file_system.h"

#include <errno.h>
#include <stdio.h>

uint64_t sig_fnv1a(const void *bytes, size_t size, uint64_t seed) {
  const unsigned char *byte = bytes;
  uint64_t hash = seed;
  for (size_t i = 0; i < size; i++) {
    hash ^= byte[i];
    hash *= UINT64_C(0x100000001b3);
  }
  return hash;
}

int sig_fnv1a_of_file(const char *path, size_t length, uint64_t seed, uint64_t *hash) {
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  FILE *file = fopen(name, "rb");
  const int open_error = file ? 0 : errno;
  sig_free(name);
  if (!file) return open_error;

  unsigned char block[1 << 16];
  *hash = seed;
  size_t n;
  errno = 0;
  while ((n = fread(block, 1, sizeof block, file)) > 0) *hash = sig_fnv1a(block, n, *hash);
  const int status = ferror(file) ? (errno ? errno : EIO) : 0;
  fclose(file);
  return status;
}
