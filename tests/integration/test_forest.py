# SPDX-License-Identifier: BSD-3-Clause
"""The program's walk through a random forest against scikit-learn, by a library of forest.c alone."""

import ctypes

import numpy as np
import pytest
from signorom_post.forest import fit, flat_arrays

N_POINTS = 100_000


class Forest(ctypes.Structure):
    """`sig_forest` of include/signorom/forest.h."""

    _fields_ = [(name, ctypes.c_int) for name in ("n_features", "n_classes", "n_trees")] + [
        (name, ctypes.c_void_p) for name in ("tree_starts", "feature", "threshold", "left", "right", "shares")
    ]


@pytest.fixture(scope="module")
def library(forest_walk):
    """forest.c of the build under test."""
    return ctypes.CDLL(str(forest_walk))


def votes_of(library, arrays, points):
    """Mean shares (n_points, n_classes) by the program."""
    n_classes = arrays["shares"].shape[1]
    pointers = {name: values.ctypes.data for name, values in arrays.items()}
    forest = Forest(points.shape[1], n_classes, len(arrays["tree_starts"]) - 1, **pointers)
    assert library.sig_forest_check(ctypes.byref(forest)) == 0
    votes = np.empty((len(points), n_classes))
    library.sig_forest_votes.argtypes = [ctypes.c_void_p] * 3
    library.sig_forest_votes.restype = None
    for point, row in zip(
        points.ctypes.data + np.arange(len(points)) * points.strides[0], range(len(votes)), strict=True
    ):
        library.sig_forest_votes(
            ctypes.addressof(forest), int(point), votes.ctypes.data + row * votes.strides[0]
        )
    return votes


@pytest.mark.parametrize("n_parameters", [2, 4])
def test_votes_are_those_of_scikit_learn(library, n_parameters):
    """Clusters with noisy borders, so that the trees disagree; points on thresholds and outside the box too."""
    random = np.random.default_rng(8)
    training = random.uniform([5] * n_parameters, [200] * n_parameters, (400, n_parameters))
    clusters = 1 + ((training[:, 0] + random.normal(scale=20, size=400)) // 70).clip(0, 2).astype(int)
    classifier = fit(training, clusters, 100, 1)
    arrays = flat_arrays(classifier, int(clusters.max()))
    points = random.uniform(0, 220, (N_POINTS, n_parameters))
    points[:400] = training
    points[400:500, 0] = arrays["threshold"][arrays["feature"] == 0][:100]
    votes = votes_of(library, arrays, points)
    expected = classifier.predict_proba(points)
    assert len(np.unique(votes.argmax(axis=1))) == 3
    np.testing.assert_array_equal(votes.argmax(axis=1) + 1, classifier.predict(points))
    np.testing.assert_array_equal(np.sort(votes)[:, -2], np.sort(expected)[:, -2])
    np.testing.assert_array_equal(votes, expected)
