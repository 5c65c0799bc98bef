/* SPDX-License-Identifier: BSD-3-Clause */
/* Types and functions that reading and writing of HDF5 files share; for src/files/hdf5_*.c only. */
#ifndef SIG_HDF5_ADDRESS_H
#define SIG_HDF5_ADDRESS_H

#include "signorom/hdf5_file.h"

#include <hdf5.h>

struct sig_h5_collection;

struct sig_h5_file {
  hid_t id;
  int is_image;
  int descriptor;                        /* descriptor of a file that HDF5 has not opened yet; id < 0 then */
  uint64_t size;                         /* [byte] size of a file that is read */
  uint64_t head;                         /* [byte] length of the caller's part before HDF5's part of the file */
  uint64_t n_left;                       /* [byte] number that may still be read from it, see sig_h5_take */
  struct sig_h5_collection *collections; /* collections of texts that were read, sorted by address */
  size_t n_collections;
};

/* The two parts of an address "path@name": the path of the object and, for an attribute, its name. */
struct sig_h5_address {
  char *object;          /* for sig_free */
  const char *attribute; /* null for a dataset */
};

/* Divides an address at its @. Returns 0 when out of memory. */
int sig_h5_cut_address(const char *text, size_t length, struct sig_h5_address *address);

/* Returns whether the path is that of the root group. */
int sig_h5_is_root(const char *path);

/* Kinds of what a path leads to: nothing, an object, a link, something damaged. LINK: a part of the path is a link that
 * is not a hard link, and so may lead out of the file or in a circle. */
enum sig_h5_path { SIG_H5_PATH_NONE, SIG_H5_PATH_PLAIN, SIG_H5_PATH_LINK, SIG_H5_PATH_DAMAGED };
enum sig_h5_path sig_h5_find_object(hid_t file, const char *path);

/* Gives the place [byte] of the header of an object that was found. Returns 0 if there is none. */
int sig_h5_place_of(hid_t file, const char *path, uint64_t *address);

/* Returns whether HDF5 may safely open the object with the header at this address, and its attributes. */
int sig_h5_check_header(const struct sig_h5_file *file, uint64_t address);

/* Returns whether HDF5 may safely open a file of `size` bytes; also 1 for a file that is not an HDF5 file. */
int sig_h5_check_root(int descriptor, uint64_t size);

/* A dataset or an attribute that is open. */
struct sig_h5_item {
  hid_t id;
  int is_attribute;
};

/* Return the type of the values in the file, and the data space. The caller closes them by H5Tclose and H5Sclose. They
 * are negative on a failure. */
hid_t sig_h5_type_of(const struct sig_h5_item *item);
hid_t sig_h5_space_of(const struct sig_h5_item *item);

/* Checks that the file itself holds the values of an item, as many as its shape says. Returns SIG_H5_OK,
 * SIG_H5_ELSEWHERE, SIG_H5_TOO_LARGE or SIG_H5_NO_READ. */
int sig_h5_check_item(const struct sig_h5_file *file, const struct sig_h5_item *item);

/* Subtracts `n_bytes` from n_left, the number of bytes that may still be read. Returns 0, and subtracts nothing, if
 * they are more than that. So a file that refers many times to the same bytes cannot fill the memory. */
int sig_h5_take(struct sig_h5_file *file, uint64_t n_bytes);

/* Finds the object of a collection in the file to which a text of variable length refers. The bytes exist until the
 * file is closed. Returns 0 if there is no such object or if the collection is damaged. */
int sig_h5_find_object_of_heap(struct sig_h5_file *file, uint64_t address, uint64_t index, const unsigned char **bytes,
                               uint64_t *size);

/* Frees the collections of texts that were read. */
void sig_h5_free_heap(struct sig_h5_file *file);

/* Reads `size` bytes from an address on. Returns 0 if the file does not have them. */
int sig_h5_read_bytes(const struct sig_h5_file *file, uint64_t address, uint64_t size, void *bytes);

/* Returns the integer of `n` bytes, of which the lowest comes first. */
uint64_t sig_h5_decode(const unsigned char *bytes, int n);

/* Returns the HDF5 type of texts of variable length; the caller closes it by H5Tclose. */
hid_t sig_h5_text_type(H5T_cset_t character_set);

#endif
