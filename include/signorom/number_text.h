/* SPDX-License-Identifier: BSD-3-Clause */
/* Numbers as text, whatever the locale and the threads. */
#ifndef SIG_NUMBER_TEXT_H
#define SIG_NUMBER_TEXT_H

/* Fewest digits, but at least 15, that read back as the same number, as d.ddde+dd; `text` has room for 32. */
void sig_shortest_decimal(double number, char *text, int *length);

#endif
