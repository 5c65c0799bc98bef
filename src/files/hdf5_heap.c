/* SPDX-License-Identifier: BSD-3-Clause */
/* Reads texts of variable length. They stand in collections of objects, the "global heap" of a file (section III.E of
 * the format's specification 3.0). HDF5 1.10 does not check the sizes in a collection and the number of an object, and
 * ends the program if they are wrong. So collections are read and checked here. */
#define _DEFAULT_SOURCE /* pread */
#include "hdf5_address.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEAD = 16 }; /* [byte] size of the head of a collection and of an object */
static const uint64_t smallest_collection = 4096, most_objects = 1 << 16;

struct object {
  uint64_t index; /* must be the first member, because compare_keys compares it */
  uint64_t size;
  const unsigned char *bytes;
};

struct sig_h5_collection {
  uint64_t address; /* must be the first member, too; from the beginning of HDF5's part of the file */
  uint64_t size;
  unsigned char *bytes;
  size_t n_objects;
  struct object *objects; /* by index */
};

static int compare_keys(const void *a, const void *b) {
  const uint64_t key_a = *(const uint64_t *)a, key_b = *(const uint64_t *)b;
  return key_a < key_b ? -1 : key_a > key_b;
}

uint64_t sig_h5_decode(const unsigned char *bytes, int n) {
  uint64_t value = 0;
  while (n-- > 0) value = value << 8 | bytes[n];
  return value;
}

int sig_h5_read_bytes(const struct sig_h5_file *file, uint64_t address, uint64_t size, void *bytes) {
  void *handle = NULL;
  if (file->head > file->size || address > file->size - file->head || size > file->size - file->head - address)
    return 0;
  const uint64_t position = file->head + address;
  if (file->id < 0) return pread(file->descriptor, bytes, size, (off_t)position) == (ssize_t)size;
  if (H5Fget_vfd_handle(file->id, H5P_DEFAULT, &handle) < 0) return 0;
  if (!file->is_image) return pread(*(int *)handle, bytes, size, (off_t)position) == (ssize_t)size;
  memcpy(bytes, *(unsigned char **)handle + position, size);
  return 1;
}

/* Lists the objects of a collection. Object 0 is free space, and its size includes its head. Returns 0 if an object
 * does not fit into the collection, if two objects have the same index, if there are too many, or when out of memory.
 */
static int list_objects(struct sig_h5_collection *collection) {
  const uint64_t most = collection->size / HEAD < most_objects ? collection->size / HEAD : most_objects;
  collection->objects = malloc(most * sizeof *collection->objects);
  if (!collection->objects) return 0;
  size_t n = 0;
  for (uint64_t at = HEAD; collection->size - at >= HEAD; n++) {
    const unsigned char *head = collection->bytes + at;
    const uint64_t index = sig_h5_decode(head, 2), size = sig_h5_decode(head + 8, 8);
    const uint64_t room = collection->size - at - (index == 0 ? 0 : HEAD);
    if (n == most || size > room || (index == 0 && size < HEAD)) return 0;
    const uint64_t padded = (size + 7) / 8 * 8;
    if (padded > room) return 0;
    collection->objects[n] = (struct object){index, size, head + HEAD};
    at += padded + (index == 0 ? 0 : HEAD);
  }
  qsort(collection->objects, n, sizeof *collection->objects, compare_keys);
  for (size_t i = 1; i < n; i++)
    if (collection->objects[i].index == collection->objects[i - 1].index) return 0;
  collection->n_objects = n;
  return 1;
}

/* Gives the place in the list where a new collection of `size` bytes belongs. Returns 0 if it overlaps another
 * collection in the file. So all collections together are not larger than the file. */
static int find_place(const struct sig_h5_file *file, uint64_t address, uint64_t size, size_t *i) {
  const struct sig_h5_collection *known = file->collections;
  *i = file->n_collections;
  while (*i > 0 && known[*i - 1].address > address) --*i;
  if (*i > 0 && known[*i - 1].size > address - known[*i - 1].address) return 0;
  return *i == file->n_collections || size <= known[*i].address - address;
}

static int read_collection(const struct sig_h5_file *file, struct sig_h5_collection *collection, size_t *i) {
  static const unsigned char mark[] = {'G', 'C', 'O', 'L', 1};
  unsigned char head[HEAD];
  if (!sig_h5_read_bytes(file, collection->address, HEAD, head) || memcmp(head, mark, sizeof mark) != 0) return 0;
  collection->size = sig_h5_decode(head + 8, 8);
  if (collection->size < smallest_collection || collection->size > file->size || collection->size % 8 != 0) return 0;
  if (!find_place(file, collection->address, collection->size, i)) return 0;
  collection->bytes = malloc(collection->size);
  return collection->bytes && sig_h5_read_bytes(file, collection->address, collection->size, collection->bytes) &&
         list_objects(collection);
}

static int add_collection(struct sig_h5_file *file, uint64_t address, size_t *i) {
  struct sig_h5_collection collection = {.address = address};
  struct sig_h5_collection *more = NULL;
  if (read_collection(file, &collection, i))
    more = realloc(file->collections, (file->n_collections + 1) * sizeof *more);
  if (!more) {
    free(collection.objects);
    free(collection.bytes);
    return 0;
  }
  memmove(more + *i + 1, more + *i, (file->n_collections - *i) * sizeof *more);
  more[*i] = collection;
  file->collections = more;
  file->n_collections++;
  return 1;
}

int sig_h5_find_object_of_heap(struct sig_h5_file *file, uint64_t address, uint64_t index, const unsigned char **bytes,
                               uint64_t *size) {
  const struct sig_h5_collection *found = NULL;
  if (file->n_collections > 0)
    found = bsearch(&address, file->collections, file->n_collections, sizeof *found, compare_keys);
  if (!found) {
    size_t i;
    if (!add_collection(file, address, &i)) return 0;
    found = file->collections + i;
  }
  const struct object *object = bsearch(&index, found->objects, found->n_objects, sizeof *object, compare_keys);
  if (!object || index == 0) return 0;
  *bytes = object->bytes;
  *size = object->size;
  return 1;
}

void sig_h5_free_heap(struct sig_h5_file *file) {
  for (size_t i = 0; i < file->n_collections; i++) {
    free(file->collections[i].objects);
    free(file->collections[i].bytes);
  }
  free(file->collections);
}
