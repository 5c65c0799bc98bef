/* SPDX-License-Identifier: BSD-3-Clause */
/* FNV-1a checksums with 64 bits. They detect changed files; they do not protect against intended changes. */
#ifndef SIG_CHECKSUM_H
#define SIG_CHECKSUM_H

#include <stddef.h>
#include <stdint.h>

/* The seed of the first call (FNV's offset basis). */
#define SIG_FNV1A_SEED UINT64_C(0xcbf29ce484222325)

/* Returns the hash of `size` bytes. Pass the result as the seed of the next call to get the hash of both pieces
 * together. */
uint64_t sig_fnv1a(const void *bytes, size_t size, uint64_t seed);

/* Returns a hash of doubles, taken word by word. It is many times as fast as sig_fnv1a of the same bytes, and its value
 * differs from that one. */
uint64_t sig_hash_of_doubles(const double *values, size_t n);

#endif
