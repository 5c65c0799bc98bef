/* SPDX-License-Identifier: BSD-3-Clause */
/* Numbers as text, independent of the locale and safe for several threads. */
#ifndef SIG_NUMBER_TEXT_H
#define SIG_NUMBER_TEXT_H

/* Writes a number as d.ddde+dd with the fewest digits, but at least 15, that read back as the same number; `inf` or
 * `nan`, perhaps with a sign, where it is not finite. `text` has room for 32 characters; *length is the number of
 * characters without the null behind them. */
void sig_shortest_decimal(double number, char *text, int *length);

#endif
