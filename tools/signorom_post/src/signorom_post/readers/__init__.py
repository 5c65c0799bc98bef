# SPDX-License-Identifier: BSD-3-Clause
"""Readers of the files in a results folder, one module per file."""
