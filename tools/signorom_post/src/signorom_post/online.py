# SPDX-License-Identifier: BSD-3-Clause
"""Asks a trained model: `Model("model.h5").query(P1=170.0, h1=3.2)`, in the deck's units.

The answers are those of the library `libsignorom_online`.
"""

import os
from collections.abc import Callable, Sequence
from ctypes import byref, c_char_p, c_double, c_int, c_void_p, sizeof
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from signorom_post.answer import (
    Answer,
    Cells,
    ContactNodes,
    Fields,
    Gradient,
    NoAnswerError,
    Parameter,
    Resultants,
)
from signorom_post.answers import Answers, with_time_axis
from signorom_post.arrays import FloatArray, IntArray
from signorom_post.handles import Handles
from signorom_post.history import History, NoHistoryError, Step
from signorom_post.library import METHODS, CAnswer, CSizes, doubles, ints, known, text_of
from signorom_post.many import answers_at
from signorom_post.model_fields import cells_of, fields_of
from signorom_post.points import point_of, points_of, range_of, warn_inaccurate, warn_outside, warn_unheld

#: asks a context for an answer; returns whether there is none
Asker = Callable[[c_void_p, int], bool]
#: entries of Model.displacement_sources
DISPLACEMENT_NONE, DISPLACEMENT_BY_MODES, DISPLACEMENT_EXACT = 0, 1, 2


class Model:
    """A trained model that answers queries. `with` closes it, and so does the garbage collector.

    Threads may share it. A copy, also in another process by pickle, reads the file again, which must still exist.
    A closed model raises ValueError, except for `parameters`, `n_given`, `times`, `contact_areas` and `repr`.

    With a history in the deck, `parameters` are those of the deck, then `time`, then the tables of the time, and `times`
    are those of the deck's steps; without one, `times` is empty. The first `n_given` parameters are those of the deck.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        """Opens a model file; ModelError if it is missing, damaged, no model, newer than the library, or cannot answer.

        LibraryError if the library is missing or unusable. NotAcceptedWarning if validation did not accept the model.
        """
        self._path = str(Path(path).absolute())
        self._handles = Handles(os.fspath(path))
        self._library = self._handles.library
        self._sizes = CSizes()
        with self._handles.model() as model:
            self._library.signorom_get_sizes(model, byref(self._sizes))
            self.parameters = [self._parameter(model, i) for i in range(self._sizes.n_parameters)]
            self.n_given, self.times = self._history(model)
            self._areas = np.zeros(self._sizes.n_contacts)
            self._library.signorom_get_contact_areas(model, doubles(self._areas))
        self._n_normal = self._count_normal()
        self._summary = self._summarize()

    def __reduce__(self) -> tuple[type["Model"], tuple[str]]:
        """Makes copies and other processes open the file, as a handle is not valid there; ValueError if closed."""
        with self._handles.model():
            return type(self), (self._path,)

    def _parameter(self, model: c_void_p, i: int) -> Parameter:
        name, unit, minimum, maximum = c_char_p(), c_char_p(), c_double(), c_double()
        self._library.signorom_get_parameter(
            model, i, byref(name), byref(unit), byref(minimum), byref(maximum)
        )
        return Parameter(text_of(name.value), text_of(unit.value), minimum.value, maximum.value)

    def _history(self, model: c_void_p) -> tuple[int, FloatArray]:
        """Returns the number of parameters without time and tables, and the times of the deck's steps (or none)."""
        n_given, n_times = c_int(), c_int()
        self._library.signorom_get_history(model, byref(n_given), byref(n_times), None)
        times = np.zeros(n_times.value)
        self._library.signorom_get_history(model, None, None, doubles(times))
        return n_given.value, times

    def close(self) -> None:
        """Closes the model, and frees it as soon as no other thread uses it. Later queries raise ValueError."""
        self._handles.close()

    def __repr__(self) -> str:
        """Returns title, parameters with their ranges, contacts and kind, also of a closed model."""
        return self._summary

    def _summarize(self) -> str:
        ranges = ", ".join(f"{parameter.name} {range_of(parameter)}" for parameter in self.parameters)
        contacts = ", ".join(self.contact_names) or "no names of contacts"
        return f"<Model '{self.title}': {ranges}; {contacts} ({self._sizes.n_contacts} contact forces); {self.kind}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_handles"):
            self.close()

    def _told(self, kind: int) -> str:
        with self._handles.model() as model:
            return text_of(self._library.signorom_text(model, kind))

    @property
    def title(self) -> str:
        """Title of the deck."""
        return self._told(0)

    @property
    def length_unit(self) -> str:
        """Unit of displacements and coordinates."""
        return self._told(1)

    @property
    def force_unit(self) -> str:
        """Unit of contact forces; in plane models a force per length."""
        return self._told(2)

    @property
    def deck(self) -> str:
        """Effective deck of the training, YAML."""
        return self._told(4)

    @property
    def kind(self) -> str:
        """Kind of reduced model: condensed, interpolated, tied, inelastic or hhr."""
        return self._told(8)

    @property
    def verdict(self) -> str:
        """Verdict of the validation on forces and fields, begins with `NOT accepted` or `accepted`; empty: none yet."""
        return self._told(9)

    @property
    def stress_unit(self) -> str:
        """Unit of stresses and pressures; empty if the model keeps no mesh."""
        return self._told(6)

    @property
    def area_unit(self) -> str:
        """Unit of contact areas; empty if the model keeps no mesh."""
        return self._told(7)

    def describe(self) -> str:
        """Returns the text that `signorom describe` prints."""
        return self._told(5)

    @property
    def contact_sides(self) -> tuple[ContactNodes, ContactNodes]:
        """Nodes of the contacts on the side that carries the forces, and on the other side.

        The forces are on the first surface of a contact in the deck, or on the second one if that has the mortar rows.
        """
        return self._side(0), self._side(1)

    def _side(self, side: int) -> ContactNodes:
        starts = np.zeros(self._sizes.n_contacts + 1, dtype=np.intc)
        with self._handles.model() as model:
            get = self._library.signorom_get_contact_nodes
            get(model, side, ints(starts), None, None, None)
            tags = np.zeros(starts[-1], dtype=np.intc)
            weights = np.zeros(starts[-1])
            coordinates = np.zeros((starts[-1], self._sizes.n_dimensions))
            get(model, side, None, ints(tags), doubles(weights), doubles(coordinates))
        return ContactNodes(starts.astype(np.int64), tags.astype(np.int64), weights, coordinates)

    @property
    def contact_areas(self) -> FloatArray:
        """Area of each contact, in plane models a length, 0 of tangential forces; shape (n_contacts).

        Pressure = contact force / area.
        """
        return self._areas.copy()

    @property
    def remembers(self) -> bool:
        """Whether an answer of a history depends on those before it, as friction does."""
        n = c_int()
        with self._handles.model() as model:
            self._library.signorom_get_memory_size(model, byref(n))
        return n.value > self.n_given + 1

    @property
    def force_contacts(self) -> IntArray:
        """Contact, from 0, of each contact force: itself for a normal force; shape (n_contacts).

        With friction the tangential forces come behind the normal ones. They count as contacts in all other arrays,
        where their area is 0. Empty for a file of an earlier version that does not name its contacts.
        """
        return self._force_directions()[0]

    @property
    def force_directions(self) -> FloatArray:
        """Force on the first surface of the deck's entry for each multiplier of 1, (n_contacts, n_dimensions)."""
        return self._force_directions()[1]

    def _count_normal(self) -> int:
        """Returns the number of normal forces, which stand before the tangential ones."""
        contacts = self.force_contacts
        return int(np.sum(contacts == np.arange(len(contacts)))) if len(contacts) else self._sizes.n_contacts

    def _force_directions(self) -> tuple[IntArray, FloatArray]:
        contacts = np.zeros(self._sizes.n_contacts, dtype=np.intc)
        directions = np.zeros((self._sizes.n_contacts, self._sizes.n_dimensions))
        with self._handles.model() as model:
            if self._library.signorom_get_force_directions(model, ints(contacts), doubles(directions)):
                contacts, directions = contacts[:0], directions[:0]
        return contacts.astype(np.int64), directions

    @property
    def contact_names(self) -> list[str]:
        """Surfaces of each contact of the deck, such as `lower - upper`; empty if an earlier version wrote the file."""
        with self._handles.model() as model:
            n_entries, _ = self._n_entries(model)
            names = [self._library.signorom_contact_entry_name(model, i) for i in range(n_entries)]
        return [text_of(name) for name in names]

    @property
    def contact_entries(self) -> IntArray:
        """Number, from 0, of the deck's contact to which each force belongs, (n_contacts); empty for an older file."""
        with self._handles.model() as model:
            n_entries, _ = self._n_entries(model)
            entries = np.zeros(self._sizes.n_contacts if n_entries else 0, dtype=np.intc)
            self._library.signorom_get_contact_entries(model, None, None, ints(entries))
        return entries.astype(np.int64)

    def _n_entries(self, model: c_void_p) -> tuple[int, int]:
        """Returns the number of contacts of the deck (0 in files of earlier versions) and of components of a moment."""
        n_entries, n_moments = c_int(), c_int()
        self._library.signorom_get_contact_entries(model, byref(n_entries), byref(n_moments), None)
        return n_entries.value, n_moments.value

    def resultants(self, multipliers: FloatArray) -> Resultants:
        """Returns the area that touches, the resultant force and the moment of each contact of the deck.

        `multipliers`: contact forces [force unit], shape (n_contacts) or (n_points, n_contacts), else ValueError. A
        force that is NaN makes the results of its contact of the deck NaN.
        """
        given = np.ascontiguousarray(multipliers, dtype=float)
        if given.ndim not in (1, 2) or given.shape[-1] != self._sizes.n_contacts:
            raise ValueError(
                f"multipliers must have the shape ({self._sizes.n_contacts},) or (n_points, {self._sizes.n_contacts}), "
                f"not {given.shape}"
            )
        points = given.reshape(-1, self._sizes.n_contacts)
        with self._handles.model() as model:
            n_entries, n_moments = self._n_entries(model)
            areas = np.zeros((len(points), n_entries))
            forces = np.zeros((len(points), n_entries, self._sizes.n_dimensions))
            moments = np.zeros((len(points), n_entries, n_moments))
            for i, point in enumerate(points):
                self._library.signorom_get_resultants(
                    model, doubles(point), doubles(areas[i]), doubles(forces[i]), doubles(moments[i])
                )
        one = given.ndim == 1
        return Resultants(*(values[0] if one else values for values in (areas, forces, moments)))

    @property
    def nodes(self) -> tuple[IntArray, FloatArray]:
        """Numbers in the mesh file, (n_nodes), and coordinates, (n_nodes, n_dimensions); all 0 if no nodes are kept."""
        tags = np.zeros(self._sizes.n_nodes, dtype=np.intc)
        coordinates = np.zeros((self._sizes.n_nodes, self._sizes.n_dimensions))
        with self._handles.model() as model:
            self._library.signorom_get_nodes(model, ints(tags), doubles(coordinates))
        return tags.astype(np.int64), coordinates

    @property
    def displacement_sources(self) -> IntArray:
        """Where the displacement of each node comes from: DISPLACEMENT_NONE, _BY_MODES or _EXACT; shape (n_nodes).

        If the full-order operator of a hyper-reduced model answers (method `condensed`), all of them may be exact.
        """
        sources = np.zeros(self._sizes.n_nodes, dtype=np.intc)
        with self._handles.model() as model:
            self._library.signorom_get_displacement_sources(model, ints(sources))
        return sources.astype(np.int64)

    @property
    def cells(self) -> Cells:
        """Cells, regions and contact facets of the mesh; NoAnswerError if the model keeps no mesh for fields."""
        with self._handles.model() as model:
            return cells_of(self._library, model)

    def fields(self, **values: float) -> Fields:
        """Returns displacement, stresses and contact on the whole mesh at a point, a keyword per parameter.

        NoAnswerError if the model has no answer, if an elastic constant, an imposed strain or Hooke's matrix is not
        finite at the point, or if the model gives no fields: it needs `reduction: {fields: true}` and displacements of
        all nodes; where the model remembers, History.fields gives them. TypeError, ValueError and ExtrapolationWarning
        as for `query`; FreeMotionWarning if a body is free; InaccurateFieldsWarning if the
        relative_displacement_bound is above 0.01.
        """
        point = point_of(self.parameters, values)
        with self._handles.model() as model, self._handles.context() as context:
            told, multipliers = self._ask(context, point)
            return self._fields(model, context, point, multipliers, told, stack_level=4)

    def query(self, *, nodes: Sequence[int] | IntArray | None = None, **values: float) -> Answer:
        """Returns the answer at a point, a keyword per parameter.

        `nodes` (numbers of the mesh file) are the nodes whose displacement is wanted; default: all. NoAnswerError if
        the model has no answer, TypeError if a parameter is missing or unknown, ValueError if a value is not finite or
        a node is unknown; ExtrapolationWarning if the point lies outside of the trained box.
        """
        point = point_of(self.parameters, values)
        indices = None if nodes is None else self._indices_of(nodes)
        with self._handles.context() as context:
            told, multipliers = self._ask(context, point)
            return self._answer(context, point, indices, told, multipliers, partial(self._query, point))

    def start(self, **values: float) -> History:
        """Begins a history at the time 0 for the deck's parameters, a keyword per parameter; see History.

        NoHistoryError if the model has no history; TypeError and ValueError as for `query`, ValueError also if a table
        is not valid at the point.
        """
        given = point_of(self._given(), values)
        self._need_history()
        names = [parameter.name for parameter in self.parameters]
        return History(self._handles, given, names, self._answer_at, self._fields_at)

    def states(self, points: FloatArray) -> FloatArray:
        """Returns the states of `points` at the times of the deck's steps, shape (n_points, n_times, n_parameters).

        `points` has the deck's parameters only, without time and tables; shape (n_points, n_given). A state has the
        values of all parameters of the model. NoHistoryError if the model has no history, ValueError if points have
        another shape, a value is not finite, or a table is not valid at a point.
        """
        given = points_of(self._given(), points)
        self._need_history()
        states = np.zeros((len(given), len(self.times), len(self.parameters)))
        with self._handles.context() as context:
            for point, found in zip(given, states, strict=True):
                if self._library.signorom_get_states(context, doubles(point), doubles(found)):
                    raise ValueError(text_of(self._library.signorom_message(context)))
        return states

    def query_history(self, points: FloatArray, nodes: Sequence[int] | IntArray | None = ()) -> Answers:
        """Returns the answers of `points` at the times of the deck's steps, with the time as second axis of all arrays.

        `points` are as for `states`; nodes, errors and warnings are those of `query_many` and `states`. The arrays of
        the result begin with (n_points, n_times); its `points` are the states.
        """
        states = self.states(points)
        answers = self.query_many(states.reshape(-1, len(self.parameters)), nodes)
        return with_time_axis(answers, states.shape[:2])

    def _given(self) -> list[Parameter]:
        """Returns the parameters without the time and the tables of a history."""
        return self.parameters[: self.n_given]

    def _need_history(self) -> None:
        if not len(self.times):
            raise NoHistoryError("the model has no history: its deck has no times")

    def _answer_at(
        self,
        context: c_void_p,
        state: FloatArray,
        nodes: Sequence[int] | IntArray | None,
        told: CAnswer,
        steps: tuple[Step, ...],
    ) -> Answer:
        """Returns the last answer of a context, which `told` describes, at a state of a history with these steps."""
        indices = None if nodes is None else self._indices_of(nodes)
        warn_outside(self.parameters, state[None], np.array([bool(told.is_inside_box)]), stack_level=4)
        multipliers = self._get(context, "signorom_get_multipliers", self._sizes.n_contacts)
        ask = partial(self._replay, state, steps if self.remembers else steps[-1:])
        return self._answer(context, state, indices, told, multipliers, ask)

    def _fields_at(self, context: c_void_p, state: FloatArray, told: CAnswer) -> Fields:
        """Returns the fields of the last answer of a context, which `told` describes, at a state of a history."""
        multipliers = self._get(context, "signorom_get_multipliers", self._sizes.n_contacts)
        with self._handles.model() as model:
            return self._fields(model, context, state, multipliers, told, stack_level=5)

    def _fields(
        self,
        model: c_void_p,
        context: c_void_p,
        point: FloatArray,
        multipliers: FloatArray,
        told: CAnswer,
        stack_level: int,
    ) -> Fields:
        warn_unheld(told.n_free_motions, stack_level)
        warn_inaccurate(known(told.relative_displacement_bound), stack_level)
        area = self.resultants(multipliers).areas
        return fields_of(self._library, model, context, self._sizes, self._named(point), area, told)

    def _query(self, point: FloatArray, context: c_void_p, _direction: int) -> bool:
        """Asks a context at a point; returns whether there is no answer."""
        return bool(self._library.signorom_query(context, doubles(point), None))

    def _replay(self, state: FloatArray, steps: tuple[Step, ...], context: c_void_p, direction: int) -> bool:
        """Asks a context at the steps of a history, with derivatives at those before the last one.

        `state` is that of the last step. Returns whether there is no answer.
        """
        library, given = self._library, np.ascontiguousarray(state[: self.n_given])
        if library.signorom_start(context, doubles(given)):
            return True
        for k, (time, tables) in enumerate(steps):
            if k > 0:
                # where this fails, the last call of the caller fails, too, if it has to
                library.signorom_differentiate(context, direction, None, None)
            # tables of the model change with the parameters; other values stand for themselves
            if library.signorom_advance(context, time, None if tables is None else doubles(tables), None):
                return True
        return False

    def _answer(
        self,
        context: c_void_p,
        point: FloatArray,
        indices: IntArray | None,
        told: CAnswer,
        multipliers: FloatArray,
        ask: Asker,
    ) -> Answer:
        """Returns the last answer of a context; nodes from 0, None: all. `ask` asks for it again."""
        with self._handles.model() as model:
            return Answer(
                point=self._named(point),
                multipliers=multipliers,
                resultants=self.resultants(multipliers),
                domain_multipliers=self._get(
                    context, "signorom_get_domain_multipliers", told.n_domain_contacts
                ),
                domain_contacts=self._domain_contacts(model, told),
                displacement=self._displacement(context, indices),
                coordinates=self._get(context, "signorom_get_coordinates", told.n_modes),
                method=METHODS[told.method],
                cluster=told.cluster,
                next_cluster=self._next_cluster(model, point),
                n_iterations=told.n_iterations,
                is_inside_box=bool(told.is_inside_box),
                distance=told.distance,
                residual=told.residual,
                n_solutions=told.n_solutions,
                bound=known(told.bound),
                relative_bound=known(told.relative_bound),
                displacement_bound=known(told.displacement_bound),
                relative_displacement_bound=known(told.relative_displacement_bound),
                n_free_motions=told.n_free_motions,
                error_estimate=known(told.error_estimate),
                _differentiate=partial(self._gradient, ask, indices),
                _areas=self._areas,
                _n_normal=self._n_normal,
            )

    def _ask(self, context: c_void_p, point: FloatArray) -> tuple[CAnswer, FloatArray]:
        """Returns what the library tells about the answer, and its contact forces; errors and warnings of `query`."""
        told = CAnswer(size=sizeof(CAnswer))
        has_failed = self._library.signorom_query(context, doubles(point), byref(told))
        warn_outside(self.parameters, point[None], np.array([bool(told.is_inside_box)]), stack_level=4)
        if has_failed:
            raise NoAnswerError(text_of(self._library.signorom_message(context)))
        return told, self._get(context, "signorom_get_multipliers", self._sizes.n_contacts)

    def _named(self, point: FloatArray) -> dict[str, float]:
        """Returns the values of a point by the names of the parameters."""
        names = [parameter.name for parameter in self.parameters]
        return dict(zip(names, point.tolist(), strict=True))

    def _gradient(self, ask: Asker, indices: IntArray | None, direction: int) -> Gradient:
        """Returns the derivatives towards larger (`direction` 1) or smaller (-1) values; nodes from 0, None: all."""
        n_grazing = c_int()
        is_one_sided = np.zeros(len(self.parameters), dtype=np.intc)
        with self._handles.model() as model, self._handles.context() as context:
            library, n_dimensions = self._library, self._sizes.n_dimensions
            if ask(context, direction) or library.signorom_differentiate(
                context, direction, byref(n_grazing), ints(is_one_sided)
            ):
                raise NoAnswerError(text_of(library.signorom_message(context)))
            n_entries, n_moments = self._n_entries(model)
            n = len(self.parameters)
            multipliers = np.zeros((n, self._sizes.n_contacts))
            forces = np.zeros((n, n_entries, n_dimensions))
            moments = np.zeros((n, n_entries, n_moments))
            library.signorom_get_multiplier_gradient(context, doubles(multipliers))
            library.signorom_get_resultant_gradient(context, doubles(forces), doubles(moments))
            errors = np.zeros(n)
            library.signorom_get_displacement_gradient_errors(context, doubles(errors))
            return Gradient(
                parameters=[parameter.name for parameter in self.parameters],
                multipliers=multipliers,
                forces=forces,
                moments=moments,
                displacement=self._displacement_gradient(context, n, indices),
                displacement_errors=errors,
                is_one_sided=is_one_sided.astype(bool),
                n_grazing=n_grazing.value,
            )

    def _displacement_gradient(
        self, context: c_void_p, n_parameters: int, indices: IntArray | None
    ) -> FloatArray:
        """Returns the derivatives of the displacement of nodes (from 0; None: all) as in Gradient."""
        chosen = np.arange(self._sizes.n_nodes, dtype=np.intc) if indices is None else indices
        has_some = self.displacement_sources[chosen] != DISPLACEMENT_NONE
        known = np.ascontiguousarray(chosen[has_some], dtype=np.intc)
        values = np.zeros((n_parameters, len(known), self._sizes.n_dimensions))
        code = self._library.signorom_get_displacement_gradient_at(
            context, len(known), ints(known), doubles(values)
        )
        gradient = np.full((n_parameters, len(chosen), self._sizes.n_dimensions), np.nan)
        if not code:
            gradient[:, has_some] = values
        return gradient

    def query_many(self, points: FloatArray, nodes: Sequence[int] | IntArray | None = ()) -> Answers:
        """Returns the answers at `points`, shape (n_points, n_parameters), in one call of the library.

        `nodes` (numbers of the mesh file) are the nodes whose displacement is wanted; None: all. ValueError if
        points have another shape, a value is not finite, or a node is unknown; one ExtrapolationWarning if points lie
        outside of the trained box. A point without an answer is no error: see Answers.has_answer.
        """
        given = points_of(self.parameters, points)
        indices = self._indices_of(self.nodes[0] if nodes is None else nodes)
        with self._handles.model() as model, self._handles.context() as context:
            n_entries = self._n_entries(model)
            answers = answers_at(
                self._library, context, self._sizes, n_entries, given, indices, self._areas, self._n_normal
            )
        warn_outside(self.parameters, given, answers.is_inside_box)
        return answers

    def _domain_contacts(self, model: c_void_p, told: CAnswer) -> IntArray:
        contacts = np.zeros(told.n_domain_contacts, dtype=np.intc)
        self._library.signorom_get_domain_contacts(model, told.cluster, None, ints(contacts))
        return contacts.astype(np.int64)

    def _next_cluster(self, model: c_void_p, point: FloatArray) -> int | None:
        cluster = c_int()
        self._library.signorom_get_next_cluster(model, doubles(point), byref(cluster))
        return cluster.value if cluster.value >= 0 else None

    def _indices_of(self, nodes: Sequence[int] | IntArray) -> IntArray:
        """Returns the positions, from 0, of nodes (numbers of the mesh file); ValueError if a node is unknown."""
        if not len(nodes):
            return np.zeros(0, dtype=np.intc)
        tags = self.nodes[0]
        if not tags.any():
            raise ValueError("the model keeps no numbers of nodes")
        order = np.argsort(tags)
        places = np.searchsorted(tags, nodes, sorter=order)
        chosen = order[np.minimum(places, len(tags) - 1)]
        missing = np.asarray(nodes)[tags[chosen] != nodes]
        if len(missing):
            raise ValueError(f"the mesh has no node {missing[0]}")
        return chosen.astype(np.intc)

    def _displacement(self, context: c_void_p, indices: IntArray | None) -> FloatArray:
        """Returns the displacement of nodes (from 0; None: all), NaN at nodes without one."""
        n = self._sizes.n_dimensions
        displacement = np.zeros((self._sizes.n_nodes if indices is None else len(indices), n))
        if indices is None:
            code = self._library.signorom_get_displacement(context, doubles(displacement))
        else:
            code = self._library.signorom_get_displacement_at(
                context, len(indices), ints(indices), doubles(displacement)
            )
            if code:  # one of the nodes has no displacement; the others may have one
                return self._displacement(context, None)[indices]
        if code:
            displacement[:] = np.nan
        return displacement

    def _get(self, context: c_void_p, name: str, n: int) -> FloatArray:
        values = np.zeros(max(n, 1))
        if getattr(self._library, name)(context, doubles(values)):
            raise NoAnswerError(text_of(self._library.signorom_message(context)))
        return values[:n]
