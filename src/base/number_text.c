/* SPDX-License-Identifier: BSD-3-Clause */
#include "signorom/number_text.h"

#include <stdio.h>
#include <stdlib.h>

enum { room = 32 };

void sig_shortest_decimal(double number, char *text, int *length) {
  /* 15 digits give back a number that was written with 15 digits or fewer; 17 digits give back every number */
  for (int n_digits = 15; n_digits <= 17; n_digits++) {
    *length = snprintf(text, room, "%.*e", n_digits - 1, number);
    if (n_digits == 17 || strtod(text, NULL) == number) break;
  }
  for (char *c = text; *c; c++)
    if (*c == ',') *c = '.'; /* some locales write a comma */
}
