# SPDX-License-Identifier: BSD-3-Clause
"""Case b of the paper, section 5.2: runs the program and puts its numbers and figures next to the published ones."""
