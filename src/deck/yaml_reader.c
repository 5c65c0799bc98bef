/* SPDX-License-Identifier: BSD-3-Clause */
/* Makes a flat table of nodes from libfyaml's events. We do not use libfyaml's document, because only events give the
   place of every mapping and sequence, and because the message about a duplicate key needs the place of the first one.
 */
#include "signorom/yaml_reader.h"

#include <libfyaml.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Limits far above what any real deck needs, so that a harmful text cannot use up memory or time. */
enum { MAX_DEPTH = 32, MAX_NODES = 10000, MAX_FAULTS = 20, MAX_MESSAGE = 240 };

typedef struct {
  int kind, parent, line, column, key_line, key_column, is_quoted;
  size_t key_start, key_length, text_start, text_length;
} node_t;

typedef struct {
  int kind, line, column;
  char message[MAX_MESSAGE];
} fault_t;

struct sig_yaml {
  node_t *nodes;
  int n_nodes, max_nodes;
  fault_t *faults;
  int n_faults;
  char *pool; /* texts of keys and scalars, one after the other */
  size_t pool_length, pool_size;
};

typedef struct {
  int line, column;
} place_t;

/* A mapping or sequence whose end has not been read yet. A mapping waits for a key, or it holds the key whose value
   comes next. */
typedef struct {
  int node;
  bool has_key;
  place_t key_place;
  size_t key_start, key_length;
} frame_t;

typedef struct {
  sig_yaml *reading;
  frame_t frames[MAX_DEPTH];
  int depth, n_documents;
  bool is_over, is_out_of_memory;
} builder_t;

static void add_fault(sig_yaml *reading, int kind, place_t place, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static void add_fault(sig_yaml *reading, int kind, place_t place, const char *format, ...) {
  if (reading->n_faults == MAX_FAULTS) return;
  fault_t *fault = &reading->faults[reading->n_faults++];
  fault->kind = kind;
  fault->line = place.line;
  fault->column = place.column;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(fault->message, sizeof fault->message, format, arguments);
  va_end(arguments);
}

/* Returns the length of the UTF-8 character at text[i] [bytes]. It is 0 for an ASCII control character other than a tab
   and a line end, and where the first byte or those behind it have the wrong form. */
static size_t character_length(const unsigned char *text, size_t i, size_t length) {
  unsigned char first = text[i];
  if (first < 0x80) return (first >= 0x20 && first != 0x7f) || first == '\n' || first == '\r' || first == '\t';
  size_t n = first >= 0xf0 && first < 0xf5   ? 4
             : first >= 0xe0 && first < 0xf0 ? 3
             : first >= 0xc2 && first < 0xe0 ? 2
                                             : 0;
  if (n == 0 || i + n > length) return 0;
  for (size_t k = 1; k < n; k++)
    if ((text[i + k] & 0xc0) != 0x80) return 0;
  return n;
}

/* Reports the first byte that is not UTF-8 text, or the first tab as indentation of a line that is neither blank nor a
   comment, whichever comes first: libfyaml ignores them or gives a bad message. */
static void check_characters(sig_yaml *reading, const char *text, size_t length) {
  const unsigned char *bytes = (const unsigned char *)text;
  place_t place = {1, 1};
  bool is_indentation = true;
  int tab_column = 0;
  for (size_t i = 0; i < length; place.column++) {
    size_t n = character_length(bytes, i, length);
    if (n == 0) {
      add_fault(reading, SIG_YAML_REFUSED, place, "byte 0x%02x is no text; a deck is UTF-8 text", bytes[i]);
      return;
    }
    if (bytes[i] == '\n') {
      place.line++;
      place.column = 0;
      is_indentation = true;
      tab_column = 0;
    } else if (is_indentation && bytes[i] == '\t') {
      tab_column = tab_column > 0 ? tab_column : place.column;
    } else if (is_indentation && bytes[i] != ' ') {
      is_indentation = false;
      if (tab_column > 0 && bytes[i] != '#' && bytes[i] != '\r') {
        add_fault(reading, SIG_YAML_REFUSED, (place_t){place.line, tab_column},
                  "a tab stands in the indentation; YAML takes spaces only");
        return;
      }
    }
    i += n;
  }
}

static size_t keep_text(builder_t *builder, const char *text, size_t length) {
  sig_yaml *reading = builder->reading;
  if (reading->pool_length + length > reading->pool_size) {
    size_t size = 2 * (reading->pool_length + length) + 256;
    char *pool = realloc(reading->pool, size);
    if (!pool) {
      builder->is_out_of_memory = true;
      return 0;
    }
    reading->pool = pool;
    reading->pool_size = size;
  }
  size_t start = reading->pool_length;
  if (length > 0) memcpy(reading->pool + start, text, length);
  reading->pool_length += length;
  return start;
}

/* Appends an empty node to the innermost open mapping or sequence. Returns NULL when there are too many nodes (a fault
   is added) or when out of memory. */
static node_t *add_node(builder_t *builder, int kind, place_t place) {
  sig_yaml *reading = builder->reading;
  if (reading->n_nodes == MAX_NODES) {
    add_fault(reading, SIG_YAML_REFUSED, place, "more than %d entries; a deck has at most that many", (int)MAX_NODES);
    builder->is_over = true;
    return NULL;
  }
  if (reading->n_nodes == reading->max_nodes) {
    int max_nodes = 2 * reading->max_nodes + 64;
    node_t *nodes = realloc(reading->nodes, (size_t)max_nodes * sizeof *nodes);
    if (!nodes) {
      builder->is_out_of_memory = true;
      return NULL;
    }
    reading->nodes = nodes;
    reading->max_nodes = max_nodes;
  }
  node_t *node = &reading->nodes[reading->n_nodes++];
  *node = (node_t){.kind = kind, .parent = -1};
  frame_t *frame = builder->depth > 0 ? &builder->frames[builder->depth - 1] : NULL;
  place_t key_place = place;
  if (frame) {
    node->parent = frame->node;
    if (frame->has_key) {
      key_place = frame->key_place;
      node->key_start = frame->key_start;
      node->key_length = frame->key_length;
      frame->has_key = false;
    }
  }
  if (place.line == 0) place = key_place;
  node->line = place.line;
  node->column = place.column;
  node->key_line = key_place.line;
  node->key_column = key_place.column;
  return node;
}

static bool expects_key(const builder_t *builder) {
  if (builder->depth == 0) return false;
  const frame_t *frame = &builder->frames[builder->depth - 1];
  return builder->reading->nodes[frame->node].kind == SIG_YAML_MAPPING && !frame->has_key;
}

static void take_key(builder_t *builder, place_t place, const char *text, size_t length) {
  sig_yaml *reading = builder->reading;
  frame_t *frame = &builder->frames[builder->depth - 1];
  if (length == 0) {
    add_fault(reading, SIG_YAML_REFUSED, place, "this entry has no key");
    builder->is_over = true;
    return;
  }
  if (memchr(text, '\n', length) || memchr(text, '\t', length)) {
    add_fault(reading, SIG_YAML_REFUSED, place, "this key has a line break or a tab in it");
    builder->is_over = true;
    return;
  }
  for (int i = frame->node + 1; i < reading->n_nodes; i++) {
    const node_t *node = &reading->nodes[i];
    if (node->parent == frame->node && node->key_length == length &&
        memcmp(reading->pool + node->key_start, text, length) == 0) {
      add_fault(reading, SIG_YAML_DUPLICATE, place, "duplicate key '%.*s'; it stands on line %d already",
                (int)(length < 80 ? length : 80), text, node->key_line);
      break;
    }
  }
  frame->key_start = keep_text(builder, text, length);
  frame->key_length = length;
  frame->key_place = place;
  frame->has_key = true;
}

static void take_scalar(builder_t *builder, place_t place, struct fy_token *token) {
  enum fy_scalar_style style = fy_token_scalar_style(token);
  if (style == FYSS_SINGLE_QUOTED || style == FYSS_DOUBLE_QUOTED)
    place.column--; /* libfyaml gives the place behind the quote */
  size_t length = 0;
  const char *text = fy_token_get_text(token, &length);
  if (!text) length = 0;
  for (size_t i = 0; i < length; i++)
    if (((unsigned char)text[i] < 0x20 && text[i] != '\n' && text[i] != '\t') || text[i] == 0x7f) {
      add_fault(builder->reading, SIG_YAML_REFUSED, place, "this text has a control character");
      builder->is_over = true;
      return;
    }
  if (expects_key(builder)) {
    take_key(builder, place, text, length);
    return;
  }
  const bool is_missing = length == 0 && style == FYSS_PLAIN && builder->depth > 0;
  if (is_missing && builder->frames[builder->depth - 1].has_key)
    place = (place_t){0, 0}; /* then the key's place counts; some releases of libfyaml give that behind the colon */
  node_t *node = add_node(builder, SIG_YAML_SCALAR, place);
  if (!node) return;
  node->is_quoted = style != FYSS_PLAIN;
  node->text_length = length;
  node->text_start = keep_text(builder, text, length);
}

static void open_collection(builder_t *builder, int kind, place_t place) {
  if (expects_key(builder)) {
    add_fault(builder->reading, SIG_YAML_REFUSED, place,
              "this key is itself a mapping or a list; a key must be a text");
    builder->is_over = true;
    return;
  }
  if (builder->depth == MAX_DEPTH) {
    add_fault(builder->reading, SIG_YAML_REFUSED, place, "nested deeper than %d levels", (int)MAX_DEPTH);
    builder->is_over = true;
    return;
  }
  if (!add_node(builder, kind, place)) return;
  builder->frames[builder->depth++] = (frame_t){.node = builder->reading->n_nodes - 1};
}

static void start_document(builder_t *builder, place_t place) {
  if (++builder->n_documents == 1) return;
  add_fault(builder->reading, SIG_YAML_REFUSED, place, "a second YAML document begins; a deck is one document");
  builder->is_over = true;
}

static place_t place_of(const struct fy_mark *mark) {
  return mark ? (place_t){mark->line + 1, mark->column + 1} : (place_t){0, 0};
}

/* Refuses anchors, aliases and tags: no deck needs them, and they can hide values from a person who reads the deck. */
static bool refuse_decoration(builder_t *builder, struct fy_event *event) {
  bool is_alias = event->type == FYET_ALIAS;
  bool is_node = event->type == FYET_SCALAR || event->type == FYET_MAPPING_START || event->type == FYET_SEQUENCE_START;
  struct fy_token *anchor = is_alias ? event->alias.anchor : is_node ? fy_event_get_anchor_token(event) : NULL;
  struct fy_token *tag = is_node ? fy_event_get_tag_token(event) : NULL;
  if (!anchor && !tag) return false;
  place_t place = place_of(fy_token_start_mark(anchor ? anchor : tag));
  if (anchor) {
    place.column--; /* libfyaml gives the place behind the & or * */
    add_fault(builder->reading, SIG_YAML_REFUSED, place,
              "anchors and aliases (&name, *name) are not for decks; write the values out");
  } else {
    add_fault(builder->reading, SIG_YAML_REFUSED, place, "tags (!name) are not for decks");
  }
  builder->is_over = true;
  return true;
}

static void take_event(builder_t *builder, struct fy_event *event) {
  if (refuse_decoration(builder, event)) return;
  place_t place = place_of(fy_event_start_mark(event));
  switch (event->type) {
  case FYET_DOCUMENT_START:
    start_document(builder, place);
    break;
  case FYET_SCALAR:
    take_scalar(builder, place, event->scalar.value);
    break;
  case FYET_MAPPING_START:
    open_collection(builder, SIG_YAML_MAPPING, place);
    break;
  case FYET_SEQUENCE_START:
    open_collection(builder, SIG_YAML_SEQUENCE, place);
    break;
  case FYET_MAPPING_END:
  case FYET_SEQUENCE_END:
    builder->depth--;
    break;
  default:
    break;
  }
}

static void collect_syntax_error(sig_yaml *reading, struct fy_diag *diagnostics) {
  void *position = NULL;
  struct fy_diag_error *error = fy_diag_errors_iterate(diagnostics, &position);
  if (error)
    add_fault(reading, SIG_YAML_SYNTAX, (place_t){error->line, error->column}, "%s", error->msg);
  else if (fy_diag_got_error(diagnostics))
    add_fault(reading, SIG_YAML_SYNTAX, (place_t){0, 0}, "the reader gives no reason");
}

/* Parses the text; returns false when memory is exhausted. */
static bool parse(sig_yaml *reading, const char *text, size_t length) {
  struct fy_diag_cfg diagnostics_configuration;
  fy_diag_cfg_default(&diagnostics_configuration);
  diagnostics_configuration.fp = NULL;
  struct fy_diag *diagnostics = fy_diag_create(&diagnostics_configuration);
  if (!diagnostics) return false;
  fy_diag_set_collect_errors(diagnostics, true);
  struct fy_parse_cfg configuration = {.flags = FYPCF_QUIET | FYPCF_JSON_NONE | FYPCF_COLLECT_DIAG,
                                       .diag = diagnostics};
  struct fy_parser *parser = fy_parser_create(&configuration);
  builder_t builder = {.reading = reading};
  bool is_ready = parser && fy_parser_set_string(parser, text, length) == 0;
  while (is_ready && !builder.is_over && !builder.is_out_of_memory) {
    struct fy_event *event = fy_parser_parse(parser);
    if (!event) break;
    take_event(&builder, event);
    fy_parser_event_free(parser, event);
  }
  if (!builder.is_over) collect_syntax_error(reading, diagnostics);
  if (parser) fy_parser_destroy(parser);
  fy_diag_destroy(diagnostics);
  return is_ready && !builder.is_out_of_memory;
}

int sig_yaml_read(const char *text, size_t length, sig_yaml **reading) {
  *reading = calloc(1, sizeof **reading);
  if (!*reading) return 1;
  (*reading)->faults = calloc(MAX_FAULTS, sizeof *(*reading)->faults);
  if ((*reading)->faults) {
    check_characters(*reading, text, length);
    if ((*reading)->n_faults > 0 || length == 0 || parse(*reading, text, length)) return 0;
  }
  sig_yaml_free(*reading);
  *reading = NULL;
  return 1;
}

int sig_yaml_n_nodes(const sig_yaml *reading) { return reading->n_nodes; }

int sig_yaml_n_faults(const sig_yaml *reading) { return reading->n_faults; }

void sig_yaml_get_node(const sig_yaml *reading, int i, sig_yaml_node *node) {
  const node_t *own = &reading->nodes[i];
  const char *pool = reading->pool ? reading->pool : "";
  *node = (sig_yaml_node){.kind = own->kind,
                          .parent = own->parent,
                          .line = own->line,
                          .column = own->column,
                          .key_line = own->key_line,
                          .key_column = own->key_column,
                          .is_quoted = own->is_quoted,
                          .key = pool + own->key_start,
                          .key_length = own->key_length,
                          .text = pool + own->text_start,
                          .text_length = own->text_length};
}

void sig_yaml_get_fault(const sig_yaml *reading, int i, sig_yaml_fault *fault) {
  const fault_t *own = &reading->faults[i];
  *fault = (sig_yaml_fault){.kind = own->kind, .line = own->line, .column = own->column, .message = own->message};
}

void sig_yaml_free(sig_yaml *reading) {
  if (!reading) return;
  free(reading->nodes);
  free(reading->faults);
  free(reading->pool);
  free(reading);
}
