# SPDX-License-Identifier: BSD-3-Clause
"""Trains the random forest that chooses the cluster of a parameter point; the program evaluates its trees."""

import csv
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from signorom_post import __version__
from signorom_post.arrays import FloatArray, IntArray
from signorom_post.errors import InputError, MissingFileError

LABEL_COLUMN = "cluster"
FORMAT_VERSION = 2
#: version of scikit-learn that is needed, as in pyproject.toml
REQUIREMENT = "scikit-learn>=1.3"


def train_forest(labels_path: Path, output: Path, n_trees: int, seed: int) -> float | None:
    """Trains a forest of `n_trees` trees on the table `labels_path`, and writes it to the file `output`.

    Returns the out-of-bag accuracy: the share, from 0 to 1, of the points whose cluster is found by those trees that
    were trained without the point. A point with which every tree was trained does not count; None if no point counts.
    InputError if the table is missing or not valid, if scikit-learn is missing, or if the file cannot be written.
    """
    names, points, labels = read_labels(labels_path)
    classifier = fit(features_of(points, points), labels, n_trees, seed)
    write_forest(output, names, points, flat_arrays(classifier, int(labels.max())))
    votes = classifier.oob_decision_function_
    is_judged = votes.sum(axis=1) > 0
    if not is_judged.any():
        return None
    return float(np.mean(classifier.classes_[votes.argmax(axis=1)][is_judged] == labels[is_judged]))


def read_labels(path: Path) -> tuple[list[str], FloatArray, IntArray]:
    """Returns parameter names, points of shape (n_points, n_parameters), and clusters from 1 of shape (n_points).

    Empty lines and lines that start with # are left out. The column `cluster` may have any place. InputError if the
    table is missing, cannot be read or is not valid.
    """
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.reader(file) if row and not row[0].lstrip().startswith("#")]
    except FileNotFoundError as error:
        raise MissingFileError(path, "there is no such file") from error
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(path, f"the table cannot be read ({error})") from error
    header = [name.strip() for name in rows[0]] if rows else []
    if header.count(LABEL_COLUMN) != 1 or len(header) < 2:
        raise InputError(path, f"the first line must name the parameters and one column '{LABEL_COLUMN}'")
    if len(rows) < 2:
        raise InputError(path, "the table has no points")
    try:
        table = np.array([[float(value) for value in row] for row in rows[1:]])
    except ValueError as error:
        raise InputError(
            path, f"the table is not made of numbers in lines of equal length ({error})"
        ) from error
    if table.ndim != 2 or table.shape[1] != len(header) or not np.isfinite(table).all():
        raise InputError(path, f"each line needs {len(header)} finite numbers")
    column = header.index(LABEL_COLUMN)
    labels = table[:, column].astype(int)
    if (labels != table[:, column]).any() or labels.min() < 1:
        raise InputError(path, f"the values of '{LABEL_COLUMN}' must be whole numbers from 1")
    return header[:column] + header[column + 1 :], np.delete(table, column, axis=1), labels


def features_of(points: FloatArray, training: FloatArray) -> FloatArray:
    """Returns parameters from 0 to 1 between the smallest and the largest of the training points; 0 if these are equal.

    scikit-learn takes values that differ by less than 1e-7 as equal, whatever their unit is.
    """
    lowest, highest = training.min(axis=0), training.max(axis=0)
    ranges = np.where(highest > lowest, highest - lowest, np.inf)
    return (points - lowest) / ranges


def fit(points: FloatArray, labels: IntArray, n_trees: int, seed: int) -> Any:
    """Returns a trained RandomForestClassifier; the same seed gives the same trees. InputError without scikit-learn.

    `points` are the features of those of `read_labels`, and `labels` are theirs.
    """
    classifier = random_forest_class()(n_estimators=n_trees, random_state=seed, oob_score=True)
    with warnings.catch_warnings():  # about points that every tree has drawn
        warnings.simplefilter("ignore", UserWarning)
        classifier.fit(points, labels)
    return classifier


def random_forest_class() -> Any:
    """Returns the class RandomForestClassifier; InputError, which tells how to install it, if it cannot be imported."""
    need_scikit_learn()
    try:
        from sklearn.ensemble import RandomForestClassifier
    except ImportError as error:
        raise no_scikit_learn(f"cannot be imported ({error})") from error
    return RandomForestClassifier


def need_scikit_learn() -> None:
    """Raises InputError if scikit-learn is not installed. It imports nothing, and so does not notice a damaged one."""
    if find_spec("sklearn") is None:
        raise no_scikit_learn("is not installed")


def no_scikit_learn(reason: str) -> InputError:
    """Returns an error that says why scikit-learn cannot be used and how to install it.

    `reason` follows the word scikit-learn in the message, such as `is not installed`.
    """
    return InputError(
        "signorom-post forest",
        f"scikit-learn {reason}; hint: {sys.executable} -m pip install '{REQUIREMENT}'",
    )


def flat_arrays(classifier: Any, n_clusters: int) -> dict[str, np.ndarray]:
    """Returns name -> array of the nodes of all trees, one after the other, as in include/signorom/forest.h.

    The array `shares`, shape (n_nodes, n_clusters), is the member `values` there: the share of each cluster at a node.
    A cluster without points has the share 0.
    """
    trees = [estimator.tree_ for estimator in classifier.estimators_]
    features = np.concatenate([tree.feature for tree in trees])
    shares = np.zeros((len(features), n_clusters))
    shares[:, classifier.classes_ - 1] = np.concatenate([tree.value[:, 0, :] for tree in trees])
    return {
        "tree_starts": np.cumsum([0, *(tree.node_count for tree in trees)], dtype=np.int32),
        "feature": np.maximum(features, -1).astype(np.int32),
        "threshold": np.concatenate([tree.threshold for tree in trees]),
        "left": np.concatenate([tree.children_left for tree in trees]).astype(np.int32),
        "right": np.concatenate([tree.children_right for tree in trees]).astype(np.int32),
        "shares": shares,
    }


def write_forest(path: Path, names: list[str], training: FloatArray, arrays: dict[str, np.ndarray]) -> None:
    """Writes the file that the program reads: parameter names, ends of their ranges, and the arrays of `flat_arrays`.

    The file gets the name `path` when it is complete. InputError if it cannot be written.
    """
    partial = path.with_name(path.name + ".partial")
    try:
        with h5py.File(partial, "w") as file:
            file.attrs["format"] = "signorom forest"
            file.attrs["format_version"] = np.int32(FORMAT_VERSION)
            file.attrs["code_version"] = __version__
            file.create_dataset("parameter_names", data=names, dtype=h5py.string_dtype())
            file["lowest"] = training.min(axis=0)
            file["highest"] = training.max(axis=0)
            for name, values in arrays.items():
                file[name] = values
        partial.replace(path)
    except OSError as error:
        raise InputError(path, f"the forest cannot be written ({error})") from error
