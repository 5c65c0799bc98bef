/* SPDX-License-Identifier: BSD-3-Clause */
/* Checks the headers of groups and datasets before HDF5 reads them. A header is a list of messages in one or more
 * blocks of the file (section IV.A of the format's specification 3.0). HDF5 1.10 does not check the sizes of the parts
 * of an attribute and the number of its dimensions. If they are wrong, it reads behind the message, even for an
 * attribute that nobody asked for. Our files have headers of version 1. */
#include "hdf5_address.h"

#include <stdlib.h>
#include <string.h>

enum { HEADER_HEAD = 16, MESSAGE_HEAD = 8, WORD = 8, MAX_BLOCKS = 256, MAX_DIMENSIONS = 32 }; /* heads in bytes */
enum { SPACE_MESSAGE = 0x01, TYPE_MESSAGE = 0x03, LAYOUT_MESSAGE = 0x08, ATTRIBUTE_MESSAGE = 0x0c };
enum { CONTINUATION_MESSAGE = 0x10, IS_SHARED = 2, HAS_MAXIMA = 1, NULL_SPACE = 2 };
enum { LAYOUT_VERSION = 3, COMPACT_LAYOUT = 0, CONTIGUOUS_LAYOUT = 1, CHUNKED_LAYOUT = 2 };
enum { VIRTUAL_VERSION = 4, VIRTUAL_LAYOUT = 3 };
enum { VARIABLE_CLASS = 9, REFERENCE_SIZE = 16 };

struct block {
  uint64_t address, size;
};

/* All blocks that were found so far, and the number of bytes that further blocks may have together. */
struct blocks {
  struct block list[MAX_BLOCKS];
  size_t n;
  uint64_t n_left;
};

static int add_block(struct blocks *blocks, uint64_t address, uint64_t size) {
  if (blocks->n == MAX_BLOCKS || size > blocks->n_left) return 0;
  blocks->n_left -= size;
  blocks->list[blocks->n++] = (struct block){address, size};
  return 1;
}

/* Returns whether a data space ends within `size` bytes, and gives the number of its values. */
static int check_space(const unsigned char *space, uint64_t size, uint64_t *n_values) {
  if (size < 4 || space[0] < 1 || space[0] > 2) return 0;
  const uint64_t rank = space[1], start = space[0] == 1 ? 8 : 4, n_lists = space[2] & HAS_MAXIMA ? 2 : 1;
  if (rank > MAX_DIMENSIONS || size < start + n_lists * rank * WORD) return 0;
  *n_values = space[0] == 2 && space[3] == NULL_SPACE ? 0 : 1;
  for (uint64_t i = 0; i < rank; i++) {
    const uint64_t n = sig_h5_decode(space + start + i * WORD, WORD);
    if (n > 0 && *n_values > UINT64_MAX / n) return 0;
    *n_values *= n;
  }
  return 1;
}

/* Checks a type: its class (4 bits), 28 other bits, the size of a value (4 bytes), then data of the class. A value
 * without a fixed length is a reference of 16 bytes, and HDF5 always reads 16 bytes, whatever the size says. */
static int check_type(const unsigned char *type, uint64_t size) {
  return size >= 8 && ((type[0] & 0x0f) != VARIABLE_CLASS || sig_h5_decode(type + 4, 4) == REFERENCE_SIZE);
}

/* Checks an attribute: a head, its name, its type, its data space and its values. In version 1 name, type and data
 * space are filled up to whole words. */
static int check_attribute(const unsigned char *attribute, uint64_t size) {
  if (size < MESSAGE_HEAD + 1 || attribute[0] < 1 || attribute[0] > 3) return 0;
  if (attribute[0] > 1 && attribute[1] != 0) return 0; /* parts at other places */
  uint64_t sizes[3], starts[3], at = attribute[0] == 3 ? 9 : 8, n_values;
  for (int i = 0; i < 3; i++) {
    sizes[i] = sig_h5_decode(attribute + 2 + 2 * i, 2);
    starts[i] = at;
    at += attribute[0] == 1 ? (sizes[i] + WORD - 1) / WORD * WORD : sizes[i];
  }
  if (at > size || sizes[0] == 0 || !check_type(attribute + starts[1], sizes[1])) return 0;
  if (attribute[starts[0] + sizes[0] - 1] != '\0') return 0;
  if (!check_space(attribute + starts[2], sizes[2], &n_values)) return 0;
  const uint64_t value_size = sig_h5_decode(attribute + starts[1] + 4, 4);
  return value_size > 0 && n_values <= (size - at) / value_size;
}

/* Checks the layout of chunks: their rank, an address and their sizes. HDF5 1.10 divides by the sizes, even by 0. */
static int check_chunks(const unsigned char *chunks, uint64_t size) {
  enum { CHUNK_HEAD = 1 + WORD, CHUNK_WORD = 4 };
  const uint64_t rank = chunks[0];
  if (rank < 2 || rank > MAX_DIMENSIONS + 1 || size < CHUNK_HEAD + rank * CHUNK_WORD) return 0;
  for (uint64_t i = 0; i < rank; i++)
    if (sig_h5_decode(chunks + CHUNK_HEAD + i * CHUNK_WORD, CHUNK_WORD) == 0) return 0;
  return 1;
}

/* Checks a layout message. Values in our files stand in one piece. Other layouts that are harmless here are refused
 * later, when the dataset is open, with a message about them. */
static int check_layout(const unsigned char *layout, uint64_t size) {
  if (size < 4) return 0;
  if (layout[0] == VIRTUAL_VERSION) return layout[1] == VIRTUAL_LAYOUT;
  if (layout[0] != LAYOUT_VERSION) return 0;
  if (layout[1] == COMPACT_LAYOUT) return sig_h5_decode(layout + 2, 2) <= size - 4;
  if (layout[1] == CONTIGUOUS_LAYOUT) return size >= 2 + 2 * WORD;
  return layout[1] == CHUNKED_LAYOUT && check_chunks(layout + 2, size - 2);
}

static int check_message(struct blocks *blocks, uint64_t type, int flags, const unsigned char *body, uint64_t size) {
  uint64_t n_values;
  const int is_ours =
      type == SPACE_MESSAGE || type == TYPE_MESSAGE || type == LAYOUT_MESSAGE || type == ATTRIBUTE_MESSAGE;
  if (is_ours && flags & IS_SHARED) return 0;
  if (type == SPACE_MESSAGE) return check_space(body, size, &n_values);
  if (type == TYPE_MESSAGE) return check_type(body, size);
  if (type == LAYOUT_MESSAGE) return check_layout(body, size);
  if (type == ATTRIBUTE_MESSAGE) return check_attribute(body, size);
  if (type != CONTINUATION_MESSAGE) return 1;
  return size >= 2 * WORD && add_block(blocks, sig_h5_decode(body, WORD), sig_h5_decode(body + WORD, WORD));
}

static int check_messages(struct blocks *blocks, const unsigned char *bytes, uint64_t size) {
  uint64_t at = 0;
  while (size - at >= MESSAGE_HEAD) {
    const uint64_t type = sig_h5_decode(bytes + at, 2), body_size = sig_h5_decode(bytes + at + 2, 2);
    const int flags = bytes[at + 4];
    at += MESSAGE_HEAD;
    if (body_size > size - at || !check_message(blocks, type, flags, bytes + at, body_size)) return 0;
    at += body_size;
  }
  return 1;
}

int sig_h5_check_header(const struct sig_h5_file *file, uint64_t address) {
  unsigned char head[HEADER_HEAD];
  struct blocks blocks = {.n = 0, .n_left = file->size};
  if (!sig_h5_read_bytes(file, address, sizeof head, head) || head[0] != 1) return 0;
  int is_fine = add_block(&blocks, address + HEADER_HEAD, sig_h5_decode(head + 8, 4));
  for (size_t i = 0; i < blocks.n && is_fine; i++) {
    const struct block block = blocks.list[i];
    unsigned char *bytes = malloc(block.size + 1);
    is_fine = bytes && sig_h5_read_bytes(file, block.address, block.size, bytes) &&
              check_messages(&blocks, bytes, block.size);
    free(bytes);
  }
  return is_fine;
}

/* HDF5's part of a file begins after 0, 512, 1024, 2048 ... bytes. When HDF5 opens a file, it reads the header of the
 * root group. */
int sig_h5_check_root(int descriptor, uint64_t size) {
  static const unsigned char mark[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
  enum { VERSION = 8, OFFSET_SIZE = 13, LENGTH_SIZE = 14, ROOT_HEADER = 64, SUPERBLOCK = 96 };
  unsigned char bytes[SUPERBLOCK];
  struct sig_h5_file file = {.id = H5I_INVALID_HID, .descriptor = descriptor, .size = size};
  for (uint64_t head = 0; head < size; head = head ? 2 * head : 512) {
    file.head = head;
    if (!sig_h5_read_bytes(&file, 0, SUPERBLOCK, bytes)) return 1; /* HDF5 says what is missing */
    if (memcmp(bytes, mark, sizeof mark) != 0) continue;
    /* our files do not have other versions, whose headers are different */
    if (bytes[VERSION] != 0 || bytes[OFFSET_SIZE] != WORD || bytes[LENGTH_SIZE] != WORD) return 0;
    return sig_h5_check_header(&file, sig_h5_decode(bytes + ROOT_HEADER, WORD));
  }
  return 1;
}
