/* SPDX-License-Identifier: BSD-3-Clause */
/* HDF5 files of real, integer and text arrays. No hid_t crosses this border, and HDF5 prints nothing of its own.
 *
 * An address names a dataset (`/clusters/1/basis`) or, with an @, an attribute of a group or dataset
 * (`/clusters/1@rank`). Groups on the way are made. Texts without terminator: pointer and length. Shapes are C's: the
 * last index runs fastest. Functions return a value of sig_h5_status unless they say otherwise. */
#ifndef SIG_HDF5_FILE_H
#define SIG_HDF5_FILE_H

#include <stddef.h>
#include <stdint.h>

typedef struct sig_h5_file sig_h5_file;

#define SIG_H5_MAX_RANK 8

enum sig_h5_type { SIG_H5_OTHER = 0, SIG_H5_REAL = 1, SIG_H5_INTEGER = 2, SIG_H5_TEXT = 3, SIG_H5_SINGLE = 4 };
/* SIG_H5_SINGLE: real numbers in single precision in memory; sig_h5_describe calls them SIG_H5_REAL. */

enum sig_h5_status {
  SIG_H5_OK = 0,
  SIG_H5_NOT_HDF5 = 1, /* the file does not start as HDF5 does, is missing or cannot be read */
  SIG_H5_DAMAGED = 2,  /* it does, but cannot be opened: cut off or overwritten */
  SIG_H5_LOCKED = 3,   /* another program has it open for writing */
  SIG_H5_NO_CREATE = 4,
  SIG_H5_NO_WRITE = 5,
  SIG_H5_NO_READ = 6,
  SIG_H5_MISSING = 7,   /* no such dataset or attribute */
  SIG_H5_ELSEWHERE = 8, /* a link, or values that do not stand in the file in one piece */
  SIG_H5_TOO_LARGE = 9  /* more values than the file can hold */
};

/* Creates a file; one of this name is replaced. `n_free` bytes at its head are left to the caller: 0 or a power of 2
 * from 512. */
int sig_h5_create(const char *path, size_t length, size_t n_free, sig_h5_file **file);

/* Opens a file for reading. The functions below do not follow links or values in other files, and read no more than a
 * file of this size can hold. In these cases they return SIG_H5_ELSEWHERE or SIG_H5_TOO_LARGE. */
int sig_h5_open(const char *path, size_t length, sig_h5_file **file);

/* Create a file that exists in memory only, or open the bytes of such a file for reading; the bytes are copied. */
int sig_h5_create_image(sig_h5_file **file);
int sig_h5_open_image(const void *bytes, size_t size, sig_h5_file **file);

/* sig_h5_image_size returns the number of bytes of a file in memory, or -1 on a failure. sig_h5_get_image copies these
 * bytes; `bytes` has room for `size` of them. */
int64_t sig_h5_image_size(sig_h5_file *file);
int sig_h5_get_image(sig_h5_file *file, size_t size, void *bytes);

/* Closes the file; null is allowed. The handle is no longer valid, even after a failure. */
int sig_h5_close(sig_h5_file *file);

/* Writes an array. `values` are double or int, as `type` says; `shape` has `rank` entries, and rank 0 is a scalar.
 * SIG_H5_NO_WRITE also where the address exists already. */
int sig_h5_write(sig_h5_file *file, const char *address, size_t length, int type, int rank, const int64_t *shape,
                 const void *values);

/* Writes a matrix of reals whose `n_rows` rows of `row_size` values stand at separate places in memory. */
int sig_h5_write_rows(sig_h5_file *file, const char *address, size_t length, int64_t n_rows, int64_t row_size,
                      const double *const *rows);

/* Writes one text (`rank` 0) or `n` texts (`rank` 1). Text i is characters[ends[i - 1] .. ends[i]); the first one
 * starts at 0. */
int sig_h5_write_texts(sig_h5_file *file, const char *address, size_t length, int rank, int64_t n,
                       const char *characters, const int64_t *ends);

/* Returns 1 where the group, dataset or attribute exists, else 0. A link and a damaged object exist, too: reading them
 * fails. */
int sig_h5_has(sig_h5_file *file, const char *address, size_t length);

/* Gives type and shape of an array. `shape` has room for SIG_H5_MAX_RANK entries; a larger rank returns SIG_H5_NO_READ.
 */
int sig_h5_describe(sig_h5_file *file, const char *address, size_t length, int *type, int *rank, int64_t *shape);

/* Reads an array as double or int; integers may be read as double. `values` has room for the array that sig_h5_describe
 * described. */
int sig_h5_read(sig_h5_file *file, const char *address, size_t length, int type, void *values);

/* Reads a block of a dataset of rank 2 with numbers, row by row into `values`. Rows and columns count from 0. A block
 * outside of the matrix gives SIG_H5_NO_READ. For an empty block nothing is looked at. */
int sig_h5_read_part(sig_h5_file *file, const char *address, size_t length, int64_t first_row, int64_t n_rows,
                     int64_t first_column, int64_t n_columns, double *values);

/* Reads texts. `*characters` and `*ends` are as in sig_h5_write_texts; the caller frees them with sig_free. They are
 * null on a failure. */
int sig_h5_read_texts(sig_h5_file *file, const char *address, size_t length, int64_t *n, char **characters,
                      int64_t **ends);

#endif
