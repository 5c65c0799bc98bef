/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom.h"

const char *signorom_version(void) { return SIGNOROM_VERSION; }
