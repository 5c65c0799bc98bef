/* SPDX-License-Identifier: BSD-3-Clause */
/* What reading and writing of HDF5 files share; for src/files/hdf5_*.c only. */
#ifndef SIG_HDF5_ADDRESS_H
#define SIG_HDF5_ADDRESS_H

#include "signorom/hdf5_file.h"

#include <hdf5.h>

struct sig_h5_collection;

struct sig_h5_file {
  hid_t id;
  int is_image;
  int descriptor;                        /* of a file that HDF5 has not opened yet, with id < 0 */
  uint64_t size;                         /* [byte] of a file that is read */
  uint64_t head;                         /* [byte] before HDF5's part of it, the caller's */
  uint64_t n_left;                       /* [byte] that may still be read from it, see sig_h5_take */
  struct sig_h5_collection *collections; /* of texts that were read, by address */
  size_t n_collections;
};

/* An address cut at its @: the object's path and, for attributes, the name in it. */
struct sig_h5_address {
  char *object;          /* for sig_free */
  const char *attribute; /* null for a dataset */
};

/* 0 without memory. */
int sig_h5_cut_address(const char *text, size_t length, struct sig_h5_address *address);

/* The file itself. */
int sig_h5_is_root(const char *path);

/* What a path leads to. Links other than the plain ones of groups lead out of the file, or round about in it. */
enum sig_h5_path { SIG_H5_PATH_NONE, SIG_H5_PATH_PLAIN, SIG_H5_PATH_LINK, SIG_H5_PATH_DAMAGED };
enum sig_h5_path sig_h5_find_object(hid_t file, const char *path);

/* The place of the header of an object that was found. 0 where there is none. */
int sig_h5_place_of(hid_t file, const char *path, uint64_t *address);

/* Whether HDF5 may open the object whose header stands there, and its attributes. */
int sig_h5_check_header(const struct sig_h5_file *file, uint64_t address);

/* Whether it may open a file of so many bytes at all; 1, too, for what is no HDF5 file. */
int sig_h5_check_root(int descriptor, uint64_t size);

/* A dataset or an attribute that is open. */
struct sig_h5_item {
  hid_t id;
  int is_attribute;
};

hid_t sig_h5_type_of(const struct sig_h5_item *item);
hid_t sig_h5_space_of(const struct sig_h5_item *item);

/* Whether the values of an item stand in the file itself and as many as its shape says: SIG_H5_OK, SIG_H5_ELSEWHERE,
 * SIG_H5_TOO_LARGE or SIG_H5_NO_READ. */
int sig_h5_check_item(const struct sig_h5_file *file, const struct sig_h5_item *item);

/* Books what is read: 0 where a file of this size cannot hold so much, however often it points at the same bytes. */
int sig_h5_take(struct sig_h5_file *file, uint64_t n_bytes);

/* What a text of any length refers to: an object of a collection in the file. The bytes live until the file is closed.
 * 0 where there is none, or where the collection is damaged. */
int sig_h5_find_object_of_heap(struct sig_h5_file *file, uint64_t address, uint64_t index, const unsigned char **bytes,
                               uint64_t *size);
void sig_h5_free_heap(struct sig_h5_file *file);

/* Bytes from an address on; 0 where the file does not hold them. */
int sig_h5_read_bytes(const struct sig_h5_file *file, uint64_t address, uint64_t size, void *bytes);

/* An integer of `n` bytes, the lowest first. */
uint64_t sig_h5_decode(const unsigned char *bytes, int n);

/* Texts of any length in memory and in the file; for H5Tclose. */
hid_t sig_h5_text_type(H5T_cset_t character_set);

#endif
