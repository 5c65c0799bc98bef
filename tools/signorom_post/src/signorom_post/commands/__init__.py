# SPDX-License-Identifier: BSD-3-Clause
"""The commands of signorom-post, a module each. `run(options)` does the work and returns the exit code."""
