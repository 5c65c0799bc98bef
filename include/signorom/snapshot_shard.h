/* SPDX-License-Identifier: BSD-3-Clause */
/* Append-only file of snapshots that outlives a kill: a header, then records of one size, each with its checksum.

   Header, 72 bytes: "SIGSHARD", format version and byte-order mark (uint32), provenance (16 characters), four sizes
   (int64), FNV-1a of what stands before (uint64). Record: as many doubles as the sizes add up to, then their hash
   (sig_hash_of_doubles, uint64). Numbers are in the machine's byte order; a shard lives beside the run that wrote it,
   never travels.

   Functions return 0, an errno (> 0), or one of the negative codes below. */
#ifndef SIG_SNAPSHOT_SHARD_H
#define SIG_SNAPSHOT_SHARD_H

#include <stddef.h>
#include <stdint.h>

enum {
  SIG_SHARD_FOREIGN = -1,    /* no shard at all */
  SIG_SHARD_VERSION = -2,    /* of another format version or byte order */
  SIG_SHARD_PROVENANCE = -3, /* of another deck or mesh */
  SIG_SHARD_SIZES = -4,      /* of other sizes */
  SIG_SHARD_SHORT = -5,      /* a record that is cut off or damaged */
  SIG_SHARD_GONE = -6        /* no longer where it was opened */
};

typedef struct sig_shard sig_shard;

/* Opens the file at path (length characters, no terminator). provenance: 16 characters; sizes: numbers of doubles of
   the four parts of a record. is_writing: makes the file where it is missing, checks every record up to the first bad
   one, cuts what stands behind the good ones and appends there. *n_records: good records, or (reading) as many as the
   length of the file gives, the last one perhaps a piece, unchecked; *n_dropped: records, the last one perhaps a piece,
   that were cut (0 when reading). A file whose header was cut off has no records; writing gives it a new header. *shard
   is for sig_shard_close, null on failure. */
int sig_shard_open(const char *path, size_t length, const char *provenance, const int64_t *sizes, int is_writing,
                   sig_shard **shard, int64_t *n_records, int64_t *n_dropped);

/* Reads record i_record (0-based) and its hash into values, an array of one double more than the sizes add up to.
 * Returns SIG_SHARD_SHORT for a bad record. */
int sig_shard_read(const sig_shard *shard, int64_t i_record, double *values);

/* Writes n_records records at once. The system has them when the call returns, so that a killed process loses nothing;
 * they go to the disk unless the last time was less than a second ago. values holds the records one after the other,
 * each followed by one more double, where the hash is put. After a failure the earlier records are unchanged.
 * SIG_SHARD_GONE: the file is no longer at its path; nothing was written. */
int sig_shard_append(sig_shard *shard, int64_t n_records, double *values);

/* Writes the appended records to the disk and frees the handle, even after a failure; null is allowed. SIG_SHARD_GONE:
 * a file that was opened for writing is no longer at its path. */
int sig_shard_close(sig_shard *shard);
#endif
