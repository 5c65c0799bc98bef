# SPDX-License-Identifier: BSD-3-Clause
"""One module per file of a results folder."""
