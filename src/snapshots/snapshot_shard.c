// SPDX-License-Identifier: BSD-3-Clause
#include "signorom/snapshot_shard.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "signorom/checksum.h"
#include "signorom/file_system.h"
#include "signorom/partial_files.h"
#include "signorom/system.h"

enum { N_SIZES = 4, FORMAT_VERSION = 2, BYTE_ORDER_MARK = 0x01020304 };

typedef struct {
  char magic[8];
  uint32_t format_version;
  uint32_t byte_order_mark;
  char provenance[16];
  int64_t sizes[N_SIZES];
  uint64_t checksum;
} shard_header;

_Static_assert(sizeof(shard_header) == 72, "the header has no padding");

struct sig_shard {
  int descriptor;
  // path of the file when it was opened
  char *name;
  int is_writing;
  int is_dirty;
  // number of doubles of a record, without its hash
  size_t n_values;
  size_t record_bytes;
  // end of the last good record
  off_t end;
  struct timespec last_sync;
};

_Static_assert(sizeof(double) == sizeof(uint64_t), "the hash of a record takes the place of a double");

static const double seconds_between_syncs = 1.0;

static int read_at(int descriptor, void *bytes, size_t size, off_t offset, size_t *n_read) {
  *n_read = 0;
  while (*n_read < size) {
    const ssize_t n = pread(descriptor, (char *)bytes + *n_read, size - *n_read, offset + (off_t)*n_read);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    if (n == 0) break;
    *n_read += (size_t)n;
  }
  return 0;
}

static int write_at(int descriptor, const void *bytes, size_t size, off_t offset) {
  size_t n_written = 0;

  while (n_written < size) {
    const ssize_t n = pwrite(descriptor, (const char *)bytes + n_written, size - n_written, offset + (off_t)n_written);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    n_written += (size_t)n;
  }
  return 0;
}

static int sync_shard(sig_shard *shard) {
  if (fsync(shard->descriptor) != 0) return errno;
  shard->is_dirty = 0;
  clock_gettime(CLOCK_MONOTONIC, &shard->last_sync);
  return 0;
}

static shard_header make_header(const char *provenance, const int64_t *sizes) {
  shard_header header = {.format_version = FORMAT_VERSION, .byte_order_mark = BYTE_ORDER_MARK};

  memcpy(header.magic, "SIGSHARD", sizeof header.magic);
  memcpy(header.provenance, provenance, sizeof header.provenance);
  memcpy(header.sizes, sizes, sizeof header.sizes);
  header.checksum = sig_fnv1a(&header, offsetof(shard_header, checksum), SIG_FNV1A_SEED);
  return header;
}

static int compare_headers(const shard_header *found, const shard_header *wanted) {
  if (memcmp(found->magic, wanted->magic, sizeof wanted->magic) != 0) return SIG_SHARD_FOREIGN;
  if (found->format_version != wanted->format_version || found->byte_order_mark != wanted->byte_order_mark)
    return SIG_SHARD_VERSION;
  if (found->checksum != sig_fnv1a(found, offsetof(shard_header, checksum), SIG_FNV1A_SEED)) return SIG_SHARD_FOREIGN;
  if (memcmp(found->provenance, wanted->provenance, sizeof wanted->provenance) != 0) return SIG_SHARD_PROVENANCE;
  if (memcmp(found->sizes, wanted->sizes, sizeof wanted->sizes) != 0) return SIG_SHARD_SIZES;
  return 0;
}

// Checks the file's header. If a run was killed while it wrote the header, the file gets a new one, or, for reading,
// counts as empty.
static int check_header(sig_shard *shard, const shard_header *wanted, int is_writing) {
  shard_header found;
  size_t n_read;
  int code = read_at(shard->descriptor, &found, sizeof found, 0, &n_read);

  if (code) return code;
  shard->end = sizeof found;
  if (n_read == sizeof found) return compare_headers(&found, wanted);
  if (memcmp(&found, wanted, n_read < sizeof wanted->magic ? n_read : sizeof wanted->magic) != 0)
    return SIG_SHARD_FOREIGN;
  if (!is_writing) return 0;
  if (ftruncate(shard->descriptor, 0) != 0) return errno;
  code = write_at(shard->descriptor, wanted, sizeof *wanted, 0);
  return code ? code : sync_shard(shard);
}

// Reads a record and its hash; SIG_SHARD_SHORT if the record is not complete or the hash is wrong.
static int read_record(const sig_shard *shard, off_t offset, double *values) {
  uint64_t hash;
  size_t n_read;
  const int code = read_at(shard->descriptor, values, shard->record_bytes, offset, &n_read);

  if (code) return code;
  if (n_read < shard->record_bytes) return SIG_SHARD_SHORT;
  memcpy(&hash, values + shard->n_values, sizeof hash);
  return hash == sig_hash_of_doubles(values, shard->n_values) ? 0 : SIG_SHARD_SHORT;
}

// Gives the number of bytes behind the last good record.
static int count_left(const sig_shard *shard, int64_t *n_left) {
  struct stat status;

  if (fstat(shard->descriptor, &status) != 0) return errno;
  *n_left = status.st_size > shard->end ? (int64_t)(status.st_size - shard->end) : 0;
  return 0;
}

// Finds the end of the good records, and removes everything behind it.
static int find_end(sig_shard *shard, int64_t *n_records, int64_t *n_dropped) {
  double *values = malloc(shard->record_bytes);
  int64_t n_left = 0;
  int code;

  if (!values) return ENOMEM;
  *n_records = 0;
  while ((code = read_record(shard, shard->end, values)) == 0) {
    shard->end += (off_t)shard->record_bytes;
    ++*n_records;
  }
  free(values);
  if (code != SIG_SHARD_SHORT) return code;
  code = count_left(shard, &n_left);
  *n_dropped = (n_left + (int64_t)shard->record_bytes - 1) / (int64_t)shard->record_bytes;
  if (!code && n_left > 0 && ftruncate(shard->descriptor, shard->end) != 0) code = errno;
  return code;
}

static int fill_shard(sig_shard *shard, const char *provenance, const int64_t *sizes, int is_writing,
                      int64_t *n_records, int64_t *n_dropped) {
  const shard_header wanted = make_header(provenance, sizes);
  int64_t n_left = 0;
  int code;

  for (int i = 0; i < N_SIZES; i++) shard->n_values += (size_t)sizes[i];
  shard->record_bytes = (shard->n_values + 1) * sizeof(double);
  code = check_header(shard, &wanted, is_writing);
  if (code) return code;
  if (is_writing) {
    code = find_end(shard, n_records, n_dropped);
    return code ? code : sync_shard(shard);
  }
  code = count_left(shard, &n_left);
  *n_records = (n_left + (int64_t)shard->record_bytes - 1) / (int64_t)shard->record_bytes;
  return code;
}

static void free_shard(sig_shard *shard) {
  if (shard->descriptor >= 0) close(shard->descriptor);
  free(shard->name);
  free(shard);
}

int sig_shard_open(const char *path, size_t length, const char *provenance, const int64_t *sizes, int is_writing,
                   sig_shard **shard, int64_t *n_records, int64_t *n_dropped) {
  sig_shard *opened = calloc(1, sizeof *opened);
  int code = opened ? 0 : ENOMEM;

  *shard = NULL;
  *n_records = *n_dropped = 0;
  if (!code) {
    opened->descriptor = -1;
    opened->is_writing = is_writing;
    opened->name = sig_copy_text(path, length);
    if (!opened->name) code = ENOMEM;
  }
  if (!code) {
    opened->descriptor = open(opened->name, is_writing ? O_RDWR | O_CREAT | O_CLOEXEC : O_RDONLY | O_CLOEXEC, 0666);
    code = opened->descriptor < 0 ? errno : fill_shard(opened, provenance, sizes, is_writing, n_records, n_dropped);
  }
  if (!code)
    *shard = opened;
  else if (opened)
    free_shard(opened);
  return code;
}

int sig_shard_read(const sig_shard *shard, int64_t i_record, double *values) {
  return read_record(shard, (off_t)sizeof(shard_header) + (off_t)i_record * (off_t)shard->record_bytes, values);
}

// Checks that the file still has its path. If somebody removes or moves the results folder during a run, records would
// be lost, or the next run would not find them.
static int check_place(const sig_shard *shard) {
  struct stat at_name, open_file;

  if (fstat(shard->descriptor, &open_file) != 0) return errno;
  if (stat(shard->name, &at_name) != 0) return SIG_SHARD_GONE;
  return at_name.st_ino == open_file.st_ino && at_name.st_dev == open_file.st_dev ? 0 : SIG_SHARD_GONE;
}

int sig_shard_append(sig_shard *shard, int64_t n_records, double *values) {
  const size_t size = (size_t)n_records * shard->record_bytes;
  struct timespec now;

  for (int64_t i = 0; i < n_records; i++) {
    double *record = values + (size_t)i * (shard->n_values + 1);
    const uint64_t hash = sig_hash_of_doubles(record, shard->n_values);
    memcpy(record + shard->n_values, &hash, sizeof hash);
  }
  int code = check_place(shard);
  if (code) return code;
  sig_begin_writing();
  code = write_at(shard->descriptor, values, size, shard->end);
  sig_end_writing();
  // After a failure `end` does not move: a part that was written is overwritten by the next records or removed later.
  if (code) return code;
  shard->end += (off_t)size;
  shard->is_dirty = 1;
  clock_gettime(CLOCK_MONOTONIC, &now);
  const double elapsed =
      (double)(now.tv_sec - shard->last_sync.tv_sec) + 1e-9 * (double)(now.tv_nsec - shard->last_sync.tv_nsec);
  return elapsed >= seconds_between_syncs ? sync_shard(shard) : 0;
}

int sig_shard_close(sig_shard *shard) {
  int code;

  if (!shard) return 0;
  code = shard->is_dirty ? sync_shard(shard) : 0;
  if (!code && shard->is_writing) code = check_place(shard);
  free_shard(shard);
  return code;
}
