/* SPDX-License-Identifier: BSD-3-Clause */
/* A seal: the first bytes of a file say how long the rest is and what its checksum is, so that a file that was cut off
 * or changed is known before anything else looks into it. */
#ifndef SIG_FILE_SEAL_H
#define SIG_FILE_SEAL_H

#include <stddef.h>
#include <stdint.h>

/* Number of bytes of the seal. HDF5 does not use a user block of this size. */
#define SIG_SEAL_SIZE 512

enum sig_seal_status {
  SIG_SEAL_FINE = 0,
  SIG_SEAL_NONE = 1,    /* the file does not begin with a seal */
  SIG_SEAL_NEWER = 2,   /* of a version that is not known here */
  SIG_SEAL_LENGTH = 3,  /* the file is shorter or longer than sealed */
  SIG_SEAL_CHANGED = 4, /* other bytes than were sealed */
  SIG_SEAL_NO_READ = 5  /* the file cannot be read, or out of memory */
};

/* Writes the seal over the first SIG_SEAL_SIZE bytes, which the file must have. Returns 0 or an errno. */
int sig_seal_file(const char *path, size_t length);

/* Checks the seal and returns a value of sig_seal_status. *n_found and *n_sealed are the numbers of bytes that the file
 * has behind the seal, and had when it was sealed; 0 where not known. */
int sig_check_seal(const char *path, size_t length, int64_t *n_found, int64_t *n_sealed);

#endif
