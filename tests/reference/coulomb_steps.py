# SPDX-License-Identifier: BSD-3-Clause
"""Steps of a condensed problem with Coulomb friction by long block Gauss-Seidel sweeps with exact local solutions.

Contact k has a gap w >= 0 and a force lambda >= 0 along its normal, and along its zero to two tangents the position s of
its first side relative to its second one and the force tau on the second side. All forces together give

    w = q + W_nn lambda + W_nt tau,    s = b - W_tn lambda - W_tt tau,

and with the origin s0 of this step 0 <= lambda, 0 = lambda w, |tau| <= f lambda, and s - s0 = rho tau with a rho >= 0
that is 0 where |tau| < f lambda. An open contact has tau = 0, and its s is the next origin.

For one contact, with everything else fixed, this is one equation in one unknown. With w = 0 the normal force goes:
s - s0 = beta - A tau, where A is what W_tt leaves behind the elimination of lambda. So tau(rho) = (A + rho)^-1 beta, and
|tau(rho)| - f lambda(tau(rho)) changes sign between rho = 0, if the contact cannot stick, and infinity.

`python3 tests/reference/coulomb_steps.py` compares small cases with solutions by hand.
"""

import math
from dataclasses import dataclass

import numpy as np

# [-] change of the forces that is still to come, relative to the largest force
REACHED = 1e-13
# [-] changes that are rounding, relative to the largest force
ROUNDING = 1e-15
# [-] conditions at the head of this file, relative to the sizes of their terms
VERIFIED = 1e-11
MOST_SWEEPS = 50_000
#: states
OPEN, STICKS, SLIPS = 0, 1, 2


def slipping_1(beta, ratio, free, friction):
    """(tau, lambda) of a contact with one tangent that slips towards beta."""
    sign = math.copysign(1.0, beta)
    force = free / (1 + sign * friction * ratio)
    return sign * friction * force, force


def slipping_2(beta, eigenvalues, ratio, free, friction):
    """(tau, lambda) of a contact with two tangents that slips; all by the eigenvectors of A."""
    (b1, b2), (a1, a2), (c1, c2) = beta, eigenvalues, ratio

    def excess(rho):
        """|tau| - f lambda, its derivative, tau."""
        x, y = b1 / (a1 + rho), b2 / (a2 + rho)
        size = math.hypot(x, y)
        value = size - friction * (free - c1 * x - c2 * y)
        dx, dy = -x / (a1 + rho), -y / (a2 + rho)
        return value, (x * dx + y * dy) / size + friction * (c1 * dx + c2 * dy), x, y

    low, high = 0.0, max(a1, a2)
    while excess(high)[0] > 0:
        low, high = high, 4 * high
    rho = 0.5 * (low + high)
    for _ in range(200):
        value, slope, x, y = excess(rho)
        if value > 0:
            low = rho
        else:
            high = rho
        following = rho - value / slope if slope < 0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - rho) <= 4e-16 * (rho + a1):
            break
        rho = following
    return (x, y), free - c1 * x - c2 * y


@dataclass
class Contact:
    """Rows of one contact in W (normal, then tangents), and what its local problem needs."""

    rows: np.ndarray
    friction: float
    stiff: float
    ratio: np.ndarray
    eigenvalues: np.ndarray
    vectors: np.ndarray

    @classmethod
    def of_rows(cls, compliance, rows, friction):
        """A by the rows' block of W: its eigenvalues and vectors; ratio = W_tn / W_nn by these."""
        block = compliance[np.ix_(rows, rows)]
        ratio = block[1:, 0] / block[0, 0]
        own = block[1:, 1:] - np.outer(block[1:, 0], ratio)
        eigenvalues, vectors = np.linalg.eigh(own) if len(rows) > 1 else (np.zeros(0), np.zeros((0, 0)))
        return cls(rows, friction, block[0, 0], vectors.T @ ratio, eigenvalues, vectors)

    def solve(self, gap, position):
        """Forces (lambda, tau) for the gap and s - s0 that all others leave."""
        forces = np.zeros(len(self.rows))
        free = -gap / self.stiff
        if free <= 0:
            return forces, OPEN
        forces[0] = free
        if len(forces) == 1 or self.friction <= 0:
            return forces, SLIPS
        # W_tn by the eigenvectors of A is ratio times W_nn
        beta = self.vectors.T @ position - self.ratio * self.stiff * free
        tau = beta / self.eigenvalues
        normal = free - self.ratio @ tau
        state = STICKS
        if np.sqrt(tau @ tau) > self.friction * normal:
            state = SLIPS
            if len(beta) == 1:
                tau, normal = slipping_1(beta[0], self.ratio[0], free, self.friction)
                tau = np.array([tau])
            else:
                tau, normal = slipping_2(
                    beta.tolist(), self.eigenvalues.tolist(), self.ratio.tolist(), free, self.friction
                )
        forces[0], forces[1:] = normal, self.vectors @ tau
        return forces, state


class Steps:
    """Steps of one problem, one after the other: the origins of slip go from one to the next."""

    def __init__(self, compliance, rows, friction):
        """W of all rows; rows of each contact, the normal one first; f of each contact."""
        self.compliance = compliance
        self.contacts = [
            Contact.of_rows(compliance, np.array(own), f) for own, f in zip(rows, friction, strict=True)
        ]
        self.signs = np.full(len(compliance), -1.0)
        self.signs[[contact.rows[0] for contact in self.contacts]] = 1.0
        self.forces = np.zeros(len(compliance))
        self.origins = np.zeros(len(compliance))
        self.states = np.full(len(self.contacts), OPEN)
        self.n_sweeps = 0

    def solve(self, free, start=None):
        """Forces for gaps and positions without forces (q and b): sweeps until nothing changes; origins stay.

        `start`: forces to begin with; by default those of the step before.
        """
        signed = self.signs[:, None] * self.compliance
        free = free - self.origins
        forces = (self.forces if start is None else start).copy()
        states = np.full(len(self.contacts), OPEN)
        before = np.inf
        n_good = n_idle = 0
        for self.n_sweeps in range(1, MOST_SWEEPS + 1):
            change = 0.0
            for k, contact in enumerate(self.contacts):
                rows = contact.rows
                old = forces[rows].copy()
                forces[rows] = 0
                rest = free[rows] + signed[rows] @ forces
                forces[rows], states[k] = contact.solve(rest[0], rest[1:])
                change = max(change, np.abs(forces[rows] - old).max())
            size = np.abs(forces).max()
            rate = min(change / before, 1 - 1e-6) if before > 0 else 0.0
            n_good = n_good + 1 if change * max(1.0, rate / (1 - rate)) <= REACHED * size else 0
            n_idle = n_idle + 1 if change <= ROUNDING * size else 0
            if n_good == 3 or n_idle == 10 or change <= 0:
                break
            before = change
        else:
            raise ArithmeticError(f"no answer after {MOST_SWEEPS} sweeps, last change {change / size}")
        self.verify(free, forces)
        return forces, states

    def verify(self, free, forces):
        """The conditions at the head of this file, without the local solutions."""
        signed = self.signs[:, None] * self.compliance
        positions = free + signed @ forces
        sizes = np.abs(free) + np.abs(signed) @ np.abs(forces)
        largest = np.abs(forces).max()
        for contact in self.contacts:
            normal, tangents = contact.rows[0], contact.rows[1:]
            closed = forces[normal] > 0
            limit = contact.friction * forces[normal]
            tau, slip = forces[tangents], positions[tangents]
            width = VERIFIED * sizes[contact.rows].max()
            assert forces[normal] >= 0
            assert positions[normal] >= -width
            assert not closed or positions[normal] <= width
            size = np.linalg.norm(tau)
            assert size <= limit + VERIFIED * largest
            if not closed or len(tau) == 0 or contact.friction <= 0:
                continue
            if size < limit - VERIFIED * largest:
                assert np.linalg.norm(slip) <= width
            elif size > VERIFIED * largest:
                assert tau @ slip >= -width * size
                assert np.linalg.norm(slip - (slip @ tau) / size**2 * tau) <= width

    def accept(self, free, forces, states):
        """Take the forces as those of the step; returns the slip of all tangential rows (0 where open)."""
        positions = free + (self.signs[:, None] * self.compliance) @ forces
        slip = np.zeros(len(free))
        for contact, state in zip(self.contacts, states, strict=True):
            tangents = contact.rows[1:]
            if state != OPEN:
                slip[tangents] = positions[tangents] - self.origins[tangents]
            self.origins[tangents] = positions[tangents]
        self.forces, self.states = forces, states
        return slip

    def step(self, free):
        """Solve a step and take it; returns forces, states and slips."""
        forces, states = self.solve(free)
        return forces, states, self.accept(free, forces, states)


def check(text, found, expected, tolerance=1e-12):
    """Print a comparison and fail where it fails."""
    difference = np.abs(np.asarray(found, float) - np.asarray(expected, float)).max()
    print(text, difference)
    assert difference <= tolerance, text


def check_one_contact():
    """One contact in the plane: W = [[2, c], [c, 1]], f = 0.5, q = -4, b given; by hand, with and without coupling."""
    for c in (0.0, 0.4, -0.4):
        compliance = np.array([[2.0, c], [c, 1.0]])
        # stick: 2 n + c t = 4, c n + t = b
        steps = Steps(compliance, [(0, 1)], [0.5])
        n, t = np.linalg.solve(compliance, [4.0, 0.3 + c * 1.9])
        forces, states, slip = steps.step(np.array([-4.0, 0.3 + c * 1.9]))
        check(f"one contact, c = {c}: sticks", [*forces, states[0], slip[1]], [n, t, STICKS, 0])
        # slip forward: t = n / 2, 2 n + c n / 2 = 4, s = b - c n - n / 2
        n = 4 / (2 + c / 2)
        forces, states, slip = steps.step(np.array([-4.0, 5.0]))
        origin = 5 - c * n - n / 2
        check(f"one contact, c = {c}: slips", [*forces, states[0], slip[1]], [n, n / 2, SLIPS, origin])
        # back to b = 4.9: sticks at the new origin: s = b - c n - t = origin
        n, t = np.linalg.solve(compliance, [4.0, 4.9 - origin])
        forces, states, slip = steps.step(np.array([-4.0, 4.9]))
        check(f"one contact, c = {c}: sticks elsewhere", [*forces, states[0]], [n, t, STICKS])
        # reversed: t = -n / 2
        n = 4 / (2 - c / 2)
        forces, states, slip = steps.step(np.array([-4.0, -3.0]))
        moved = -3 - c * n + n / 2 - origin
        check(f"one contact, c = {c}: reversed", [*forces, states[0], slip[1]], [n, -n / 2, SLIPS, moved])
        # open at b = 7, then closed there: no force until b changes, whatever was before
        forces, states, slip = steps.step(np.array([1.0, 7.0]))
        check(f"one contact, c = {c}: open", [*forces, states[0], slip[1]], [0, 0, OPEN, 0])
        n, t = np.linalg.solve(compliance, [0.5, 0.02])
        forces, states, slip = steps.step(np.array([-0.5, 7.02]))
        check(f"one contact, c = {c}: closed again", [*forces, states[0]], [n, t, STICKS])


def check_one_contact_in_space():
    """Without coupling and W_tt = a I the slip follows the free position; then along an eigenvector with coupling."""
    compliance = np.diag([2.0, 3.0, 3.0])
    steps = Steps(compliance, [(0, 1, 2)], [0.4])
    forces, _, slip = steps.step(np.array([-10.0, 6.0, 8.0]))
    # n = 5, radius 2 along (0.6, 0.8), slip 10 - 3 * 2
    check("one contact in space: slips", [*forces, *slip[1:]], [5, 1.2, 1.6, 2.4, 3.2])
    forces, _, slip = steps.step(np.array([-10.0, 6.0, 8.0]) + np.array([0, 0.3, -0.6]))
    check("one contact in space: sticks", [*forces, *slip[1:]], [5, 1.3, 1.4, 0, 0])
    # from the origin (2.4, 3.2) straight back: free position (-9.6, -12.8) is (-12, -16) away
    forces, _, slip = steps.step(np.array([-10.0, -9.6, -12.8]))
    check("one contact in space: back", [*forces, *slip[1:]], [5, -1.2, -1.6, -12 + 3.6, -16 + 4.8])
    compliance = np.array([[2.0, 0.5, 0.0], [0.5, 3.0, 0.0], [0.0, 0.0, 1.0]])
    forces, _, slip = Steps(compliance, [(0, 1, 2)], [0.4]).step(np.array([-10.0, 9.0, 0.0]))
    # t = 0.4 n: 2 n + 0.2 n = 10
    n = 10 / 2.2
    check("one contact in space: coupled", [*forces, slip[1]], [n, 0.4 * n, 0, 9 - 0.5 * n - 1.2 * n])
    # any direction: rho solves a quartic, whose roots are found by an eigenvalue problem
    compliance = np.array([[2.0, 0.5, -0.3], [0.5, 3.0, 0.7], [-0.3, 0.7, 1.0]])
    free, f = np.array([-10.0, 9.0, 7.0]), 0.6
    forces, _, slip = Steps(compliance, [(0, 1, 2)], [f]).step(free)
    angle = quartic_angle(compliance, free, f)
    n = 10 / (2 + f * (0.5 * np.cos(angle) - 0.3 * np.sin(angle)))
    expected = [n, f * n * np.cos(angle), f * n * np.sin(angle)]
    check("one contact in space: any direction", forces, expected)


def quartic_angle(compliance, free, friction):
    """Direction of slip: the slip across d = (cos, sin) is 0 and along d above 0; roots by x = tan(angle / 2)."""
    polynomial = np.polynomial.Polynomial
    one, cosine, sine = polynomial([1, 0, 1]), polynomial([1, 0, -1]), polynomial([0, 2])
    # times (1 + x^2): n = -q one / (W_nn one + f W_nt.(c, s))
    below = compliance[0, 0] * one + friction * (compliance[0, 1] * cosine + compliance[0, 2] * sine)
    moved = []
    for i in (1, 2):
        own = compliance[i, 0] * one + friction * (compliance[i, 1] * cosine + compliance[i, 2] * sine)
        moved.append(free[i] * below + free[0] * own)
    across = moved[1] * cosine - moved[0] * sine
    roots = across.roots()
    for x in roots[np.abs(roots.imag) < 1e-9].real:
        if (moved[0](x) * cosine(x) + moved[1](x) * sine(x)) / below(x) > 0:
            return 2 * np.arctan(x)
    raise ArithmeticError("no direction of slip")


def check_chain():
    """Blocks on a rough floor, in a chain of springs, pulled at its end: those near the end slip one after the other.

    Each block is pressed by the force N; springs c = 1. The pull P moves the blocks 1 to m, m f N < P <= (m + 1) f N;
    block j by the sum over i = j to m of P - i f N. Unloaded to 0, blocks move back as under 2 f N (Masing).
    """
    n, normal, f = 8, 2.0, 0.3
    # the last block is tied to a wall by a spring; no contact turns its normal force into another one's
    stiffness = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    stiffness[0, 0] = 1
    compliance = np.zeros((2 * n, 2 * n))
    compliance[:n, :n] = np.eye(n)
    compliance[n:, n:] = np.linalg.inv(stiffness)
    steps = Steps(compliance, [(k, n + k) for k in range(n)], [f] * n)

    def moved(pull, limit):
        m = min(int(pull / limit), n)
        moves = np.zeros(n)
        for j in range(m):
            moves[j] = sum(pull - i * limit for i in range(j + 1, m + 1))
        return moves

    def pulled(pull):
        return np.append(np.full(n, -normal), np.linalg.solve(stiffness, np.eye(n)[0] * pull))

    position = np.zeros(n)
    history = []
    for pull in (1.0, 2.5, 3.1, 0.0, -3.1, 3.1):
        forces, _, slip = steps.step(pulled(pull))
        position = position + slip[n:]
        history.append((position.copy(), forces[n:]))
    limit = f * normal
    check("chain: pulled", history[2][0], moved(3.1, limit))
    check("chain: unloaded", history[3][0], moved(3.1, limit) - moved(3.1, 2 * limit))
    check("chain: pushed", history[4][0], -moved(3.1, limit))
    check("chain: loop closes", history[5][0], history[2][0])
    check("chain: forces of the loop", history[5][1], history[2][1])


if __name__ == "__main__":
    check_one_contact()
    check_one_contact_in_space()
    check_chain()
