/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/checksum.h"

#include <string.h>

uint64_t sig_fnv1a(const void *bytes, size_t size, uint64_t seed) {
  const unsigned char *byte = bytes;
  uint64_t hash = seed;
  for (size_t i = 0; i < size; i++) {
    hash ^= byte[i];
    hash *= UINT64_C(0x100000001b3);
  }
  return hash;
}

// The factor is odd, so that the multiplication loses no information. So two different values never give the same
// result with the same `hash`.
static uint64_t mix(uint64_t hash, const double *value) {
  uint64_t word;

  memcpy(&word, value, sizeof word);
  hash = (hash ^ word) * UINT64_C(0x9e3779b97f4a7c15);
  return hash ^ (hash >> 32);
}

uint64_t sig_hash_of_doubles(const double *values, size_t n) {
  uint64_t a = SIG_FNV1A_SEED, b = a + 1, c = a + 2, d = a + 3;
  size_t i = 0;

  // Four independent hashes at once: within one hash, each multiplication must wait for the result of the one before.
  for (; i + 4 <= n; i += 4) {
    a = mix(a, &values[i]);
    b = mix(b, &values[i + 1]);
    c = mix(c, &values[i + 2]);
    d = mix(d, &values[i + 3]);
  }
  for (; i < n; i++) a = mix(a, &values[i]);
  const uint64_t chains[] = {a, b, c, d};
  return sig_fnv1a(chains, sizeof chains, SIG_FNV1A_SEED);
}
