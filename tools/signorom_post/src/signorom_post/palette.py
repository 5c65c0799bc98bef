# SPDX-License-Identifier: BSD-3-Clause
"""The colors of all figures. They are apart from `style`, which takes a second to import, as matplotlib does."""

# the palette of Okabe and Ito: people with any common kind of color vision can tell its colors apart
BLACK = "#000000"
ORANGE = "#E69F00"
SKY_BLUE = "#56B4E9"
GREEN = "#009E73"
YELLOW = "#F0E442"
BLUE = "#0072B2"
VERMILLION = "#D55E00"
PURPLE = "#CC79A7"

CLUSTER_COLORS = (BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY_BLUE)

INK = "#262626"
GRAY = "#8C8C8C"
LIGHT_GRAY = "#D4D4D4"
BODY = "#F1F1F1"

#: color map of quantities >= 0; it is perceptually uniform and suits color-blind readers
SEQUENTIAL = "viridis"
