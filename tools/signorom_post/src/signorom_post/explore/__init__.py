# SPDX-License-Identifier: BSD-3-Clause
"""The command `signorom-post explore`: a model in a browser. `exploration` knows no browser, `scene` no page."""
