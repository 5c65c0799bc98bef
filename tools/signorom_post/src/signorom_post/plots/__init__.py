# SPDX-License-Identifier: BSD-3-Clause
"""One module per figure; each takes what the readers give and returns a matplotlib figure."""
