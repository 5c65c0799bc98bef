/* SPDX-License-Identifier: BSD-3-Clause */
#include "hdf5_address.h"

#include "signorom/file_system.h"
#include "signorom/system.h"

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

static enum sig_h5_path find_link(hid_t file, const char *path) {
  H5L_info_t link;
  if (H5Lexists(file, path, H5P_DEFAULT) <= 0) return SIG_H5_PATH_NONE;
  if (H5Lget_info(file, path, &link, H5P_DEFAULT) < 0) return SIG_H5_PATH_NONE;
  return link.type == H5L_TYPE_HARD ? SIG_H5_PATH_PLAIN : SIG_H5_PATH_LINK;
}

/* Goes down the path group by group: H5Lexists fails if a group of the path is missing, and it follows any link. */
enum sig_h5_path sig_h5_find_object(hid_t file, const char *path) {
  if (sig_h5_is_root(path)) return SIG_H5_PATH_PLAIN;
  char *part = sig_copy_text(path, strlen(path));
  if (!part) return SIG_H5_PATH_NONE;
  enum sig_h5_path found = SIG_H5_PATH_PLAIN;
  for (char *slash = strchr(part + 1, '/'); slash && found == SIG_H5_PATH_PLAIN; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    found = find_link(file, part);
    *slash = '/';
  }
  if (found == SIG_H5_PATH_PLAIN) found = find_link(file, part);
  sig_free(part);
  return found;
}

/* HDF5 1.12 gave the names without a number another meaning. */
#if !H5_VERSION_GE(1, 12, 0)
typedef H5L_info_t H5L_info1_t;
typedef H5O_info_t H5O_info1_t;
#define H5Lget_info1 H5Lget_info
#endif

int sig_h5_place_of(hid_t file, const char *path, uint64_t *address) {
  H5L_info1_t link;
  H5O_info1_t object;
  if (sig_h5_is_root(path)) {
    if (H5Oget_info2(file, &object, H5O_INFO_BASIC) < 0) return 0;
    *address = object.addr;
    return 1;
  }
  if (H5Lget_info1(file, path, &link, H5P_DEFAULT) < 0 || link.type != H5L_TYPE_HARD) return 0;
  *address = link.u.address;
  return 1;
}

hid_t sig_h5_text_type(H5T_cset_t character_set) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, H5T_VARIABLE);
  H5Tset_cset(type, character_set);
  return type;
}
