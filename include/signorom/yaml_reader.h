/* SPDX-License-Identifier: BSD-3-Clause */
/* YAML text -> flat node table with the place of every key and value. */
#ifndef SIG_YAML_READER_H
#define SIG_YAML_READER_H

#include <stddef.h>

/* Kinds of nodes. */
enum { SIG_YAML_SCALAR = 1, SIG_YAML_MAPPING = 2, SIG_YAML_SEQUENCE = 3 };

/* Kinds of faults: the text is not valid YAML; a key occurs twice; the YAML is valid but not allowed in a deck. */
enum { SIG_YAML_SYNTAX = 1, SIG_YAML_DUPLICATE = 2, SIG_YAML_REFUSED = 3 };

/* Opaque result of a reading: nodes in the order of the text (a parent before its children) and faults. */
typedef struct sig_yaml sig_yaml;

/* One node. Lines and columns are 1-based, 0 = unknown. Texts are not null-terminated and live as long as the reading.
 */
typedef struct {
  int kind;
  int parent; /* [-] 0-based index of the parent, -1 for the root */
  int line;   /* place of the value; that of the key where the value is empty */
  int column;
  int key_line; /* place of the key; that of the value in a sequence and for the root */
  int key_column;
  int is_quoted; /* 1 for a quoted or block scalar */
  const char *key;
  size_t key_length; /* 0 in a sequence and for the root */
  const char *text;
  size_t text_length;
} sig_yaml_node;

/* One fault with its place; message is null-terminated and lives as long as the reading. */
typedef struct {
  int kind;
  int line;
  int column;
  const char *message;
} sig_yaml_fault;

/* Reads a whole text of `length` bytes (no NUL needed at its end).
   Returns 0 and a reading to be freed with sig_yaml_free (with faults, the nodes are incomplete and of no use),
   or 1 when memory is exhausted. An empty text has no nodes. Faults of kind SIG_YAML_REFUSED: bytes that are not UTF-8
   text, control characters, tabs as indentation, anchors, aliases, tags, second documents, more than 32 levels or
   10000 nodes, and keys that are empty, a mapping or a list, or have a line break or a tab. At most 20 faults are kept.
 */
int sig_yaml_read(const char *text, size_t length, sig_yaml **reading);

int sig_yaml_n_nodes(const sig_yaml *reading);
int sig_yaml_n_faults(const sig_yaml *reading);

/* Copies node or fault number `i` (0-based, not checked). */
void sig_yaml_get_node(const sig_yaml *reading, int i, sig_yaml_node *node);
void sig_yaml_get_fault(const sig_yaml *reading, int i, sig_yaml_fault *fault);

void sig_yaml_free(sig_yaml *reading);

#endif
