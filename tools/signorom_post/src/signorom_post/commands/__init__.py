# SPDX-License-Identifier: BSD-3-Clause
"""The commands of signorom-post: a module each, with `add_arguments(parser)` and `run(options)`."""
