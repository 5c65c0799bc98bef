/* SPDX-License-Identifier: BSD-3-Clause */
/* FNV-1a with 64 bits: tells changed files apart; no protection against intent. */
#ifndef SIG_CHECKSUM_H
#define SIG_CHECKSUM_H

#include <stddef.h>
#include <stdint.h>

/* The seed of a first call (FNV's offset basis). */
#define SIG_FNV1A_SEED UINT64_C(0xcbf29ce484222325)

/* Hash of `size` bytes. The result as the seed of the next call gives the hash of both pieces one after the other. */
uint64_t sig_fnv1a(const void *bytes, size_t size, uint64_t seed);

/* Hash of doubles, word by word: many times as fast, and another value than sig_fnv1a of the same bytes. */
uint64_t sig_hash_of_doubles(const double *values, size_t n);

#endif
