/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/file_seal.h"

#include "signorom/checksum.h"
#include "signorom/file_system.h"
#include "signorom/partial_files.h"
#include "signorom/system.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static const char mark[] = "SIGNOROM SEAL ";
enum { seal_version = 1 };
static const uint64_t seed = UINT64_C(0xcbf29ce484222325);

/* Gives checksum and number of the bytes from the present position of the file to its end. Returns 0 or an errno. */
static int sum_rest(FILE *file, uint64_t *hash, int64_t *n_bytes) {
  unsigned char block[1 << 16];
  size_t n;
  *hash = seed;
  *n_bytes = 0;
  errno = 0;
  while ((n = fread(block, 1, sizeof block, file)) > 0) {
    *hash = sig_fnv1a(block, n, *hash);
    *n_bytes += (int64_t)n;
  }
  return ferror(file) ? (errno ? errno : EIO) : 0;
}

/* Makes the seal of `n_bytes` bytes with the checksum `hash`. */
static void make_seal(int64_t n_bytes, uint64_t hash, char seal[SIG_SEAL_SIZE]) {
  memset(seal, 0, SIG_SEAL_SIZE);
  snprintf(seal, SIG_SEAL_SIZE, "%s%d\nbytes %" PRId64 "\nfnv1a %016" PRIx64 "\n", mark, seal_version, n_bytes, hash);
}

static int write_seal(FILE *file) {
  char seal[SIG_SEAL_SIZE];
  uint64_t hash;
  int64_t n_bytes;
  if (fseek(file, SIG_SEAL_SIZE, SEEK_SET) != 0) return errno;
  const int status = sum_rest(file, &hash, &n_bytes);
  if (status) return status;
  make_seal(n_bytes, hash, seal);
  if (fseek(file, 0, SEEK_SET) != 0) return errno;
  if (fwrite(seal, 1, sizeof seal, file) != sizeof seal) return errno ? errno : EIO;
  return 0;
}

int sig_seal_file(const char *path, size_t length) {
  char *name = sig_copy_text(path, length);
  if (!name) return ENOMEM;
  FILE *file = fopen(name, "r+b");
  int status = file ? 0 : errno;
  sig_free(name);
  if (file) status = write_seal(file);
  if (file && fclose(file) != 0 && !status) status = errno;
  if (status) sig_let_end_pass();
  return status;
}

/* Reads the number of bytes and the checksum of the seal. Returns a value of sig_seal_status. */
static int read_seal(FILE *file, int64_t *n_sealed, uint64_t *hash) {
  char seal[SIG_SEAL_SIZE + 1] = {0}, expected[SIG_SEAL_SIZE];
  const size_t n = fread(seal, 1, SIG_SEAL_SIZE, file);
  int version = 0;
  if (n < strlen(mark) || memcmp(seal, mark, strlen(mark)) != 0) return SIG_SEAL_NONE;
  if (n < SIG_SEAL_SIZE) return SIG_SEAL_LENGTH;
  const int n_values =
      sscanf(seal + strlen(mark), "%9d\nbytes %20" SCNd64 "\nfnv1a %16" SCNx64, &version, n_sealed, hash);
  if (n_values > 0 && version > seal_version) return SIG_SEAL_NEWER;
  if (n_values < 3) return SIG_SEAL_CHANGED;
  make_seal(*n_sealed, *hash, expected);
  return memcmp(seal, expected, SIG_SEAL_SIZE) == 0 ? SIG_SEAL_FINE : SIG_SEAL_CHANGED;
}

int sig_check_seal(const char *path, size_t length, int64_t *n_found, int64_t *n_sealed) {
  uint64_t hash = 0, sealed_hash = 0;
  *n_found = *n_sealed = 0;
  char *name = sig_copy_text(path, length);
  if (!name) return SIG_SEAL_NO_READ;
  FILE *file = fopen(name, "rb");
  sig_free(name);
  if (!file) return SIG_SEAL_NO_READ;
  int status = read_seal(file, n_sealed, &sealed_hash);
  if (status == SIG_SEAL_FINE && sum_rest(file, &hash, n_found)) status = SIG_SEAL_NO_READ;
  if (status == SIG_SEAL_FINE && *n_found != *n_sealed) status = SIG_SEAL_LENGTH;
  if (status == SIG_SEAL_FINE && hash != sealed_hash) status = SIG_SEAL_CHANGED;
  fclose(file);
  return status;
}
