/* SPDX-License-Identifier: BSD-3-Clause */
/* What reading and writing of HDF5 files share; for src/base/hdf5_*.c only. */
#ifndef SIG_HDF5_ADDRESS_H
#define SIG_HDF5_ADDRESS_H

#include "signorom/hdf5_file.h"

#include <hdf5.h>

struct sig_h5_file {
  hid_t id;
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

int sig_h5_object_exists(hid_t file, const char *path);

/* Texts of any length in memory and in the file; for H5Tclose. */
hid_t sig_h5_text_type(H5T_cset_t character_set);

#endif
