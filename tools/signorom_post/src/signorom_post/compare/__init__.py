# SPDX-License-Identifier: BSD-3-Clause
"""Comparison of models of one problem: sizes, times, errors."""
