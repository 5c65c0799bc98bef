# SPDX-License-Identifier: BSD-3-Clause
"""Case b of the paper (section 5.2): runs the program, and sets its numbers and figures beside the published ones."""
