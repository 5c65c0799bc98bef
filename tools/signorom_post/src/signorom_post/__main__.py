# SPDX-License-Identifier: BSD-3-Clause
"""`python -m signorom_post` is the same as the command `signorom-post`."""

import sys

from signorom_post.cli import main

sys.exit(main())
