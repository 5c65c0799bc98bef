/* SPDX-License-Identifier: BSD-3-Clause */
#include "hdf5_address.h"

#include "signorom/file_system.h"

#include <string.h>

int sig_h5_cut_address(const char *text, size_t length, struct sig_h5_address *address) {
  address->attribute = NULL;
  address->object = sig_copy_text(text, length);
  if (!address->object) return 0;
  char *at = strchr(address->object, '@');
  if (at) {
    *at = '\0';
    address->attribute = at + 1;
  }
  return 1;
}

int sig_h5_is_root(const char *path) { return path[0] == '\0' || strcmp(path, "/") == 0; }

/* H5Lexists fails, rather than answers, where a group on the way is missing. */
int sig_h5_object_exists(hid_t file, const char *path) {
  if (sig_h5_is_root(path)) return 1;
  char *part = sig_copy_text(path, strlen(path));
  if (!part) return 0;
  int exists = 1;
  for (char *slash = strchr(part + 1, '/'); slash && exists; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    exists = H5Lexists(file, part, H5P_DEFAULT) > 0;
    *slash = '/';
  }
  exists = exists && H5Lexists(file, part, H5P_DEFAULT) > 0;
  sig_free(part);
  return exists;
}

hid_t sig_h5_text_type(H5T_cset_t character_set) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, character_set);
  return type;
}
