# SPDX-License-Identifier: BSD-3-Clause
"""One module per figure. Each takes the data that the modules of `readers` return, and returns a matplotlib figure."""
