# SPDX-License-Identifier: BSD-3-Clause
"""Models of one problem beside each other: sizes, times, errors."""
