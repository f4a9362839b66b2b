"""Kernels of the fixed-order filter against the paper's problem, coded again.

The cost is computed here from Kronecker products of the augmented system, with every
pair of multiplicative noise, and gradients from its differences.
"""

import numpy as np
import pytest
from projection_worlds import SIZES, definite, stable, stationary, stein
from scipy.optimize import minimize
from worlds import Numbers

from luenberger import kernels
from luenberger.kernels import run
from luenberger.papers.haddad_bernstein import derivation as lists
from luenberger.papers.haddad_bernstein.derivation import counterexamples
from luenberger.papers.haddad_bernstein.derivation.letters import estimator as letters
from luenberger.stage_list import stage_lists
from matrixproof import Solve

LISTS = {name: make() for name, make in stage_lists(lists.__name__).items()}
GAINS = ("Ae", "Be", "Ce", "De")
EQUATIONS = ("riccati", "estimate", "adjoint", "idempotent", "aligned_Q", "aligned_P")


@pytest.mark.parametrize("name", LISTS)
def test_kernel_agrees_with_its_formulas(name):
    """Compiled NumPy against the same formulas evaluated by other code."""
    derivation = LISTS[name]
    symmetric = {"Q1", "Q2", "Q", "P2", "V1", "V2", "V2s", "R", "Qyy", "Czy", "X"}
    symmetric |= {"Qh", "Ph", "dQ2", "dP2", "W_1", "W_2", "X_0", "X_1"}
    known = [s for s in derivation.given if s.name in symmetric]
    given = Numbers(SIZES, 3, known)
    if name == "best_output":  # a covariance of x, x_e and w2 together
        rng = np.random.default_rng(1)
        n, l, r = (SIZES[k] for k in ("n", "l", "n_e"))
        joint, C = definite(rng, n + r), rng.normal(size=(l, n))
        given.values = {
            "Q12": joint[:n, n:], "Q2": joint[n:, n:], "C": C,
            "Qxy": joint[:n, :n] @ C.T,
            "Qyy": C @ joint[:n, :n] @ C.T + np.eye(l),
        }  # fmt: skip
    if name == "projection_product":  # Q12 is G' Q2
        rng = np.random.default_rng(1)
        G = rng.normal(size=(SIZES["n_e"], SIZES["n"]))
        given.values = {"G": G, "Q12": G.T @ definite(rng, len(G))}
    stacks = "differential" in name
    step = kernels.compiled(getattr(lists, name), stacks=stacks)
    found = step(**{s.name: given.symbol(s) for s in derivation.given})
    for stage in derivation.stages:
        formula = stage.formula
        formula = formula.as_inverse() if isinstance(formula, Solve) else formula
        given.known[stage.target] = value = given.value(formula)
        if stage.symmetric:
            np.testing.assert_allclose(value, value.T, atol=1e-9)
            np.testing.assert_array_equal(found[stage.target.name],
                                          found[stage.target.name].T)  # fmt: skip
        np.testing.assert_allclose(
            found[stage.target.name],
            value,
            rtol=0,
            atol=1e-12 * (1 + np.abs(value).max()),
            err_msg=stage.target.name,
        )


class Model:
    """The paper's problem coded again: Kronecker products of the augmented system."""

    def __init__(self, seed, n=4, l=2, r=2, q=2, pairs=2):
        rng = np.random.default_rng(seed)
        self.rng, self.sizes = rng, (n, l, r, q)
        self.A, self.C = stable(rng, n, 0.7), rng.normal(size=(l, n))
        joint = definite(rng, n + l)
        self.V1, self.V12, self.V2 = joint[:n, :n], joint[:n, n:], joint[n:, n:]
        self.L, self.R = rng.normal(size=(q, n)), definite(rng, q)
        self.pairs = [
            (0.1 * rng.normal(size=(n, n)), 0.3 * rng.normal(size=(l, n)))
            for _ in range(pairs)
        ]
        maps = [self.A, *(a for a, _ in self.pairs)]
        radius = np.abs(np.linalg.eigvals(sum(np.kron(a, a) for a in maps))).max()
        assert radius < 0.95

    def estimator(self):
        n, l, r, q = self.sizes
        draw = self.rng.normal
        return [stable(self.rng, r, 0.5), draw(size=(r, l)), draw(size=(q, r)),
                draw(size=(q, l))]  # fmt: skip

    def moments(self, gains):
        """Q~ and P~, by one linear system each, and the cost."""
        n, l, r, q = self.sizes
        Ae, Be, Ce, De = gains
        put = lambda a, c, e: np.block([[a, np.zeros((n, r))], [Be @ c, e]])  # noqa: E731
        maps = [put(self.A, self.C, Ae)]
        maps += [put(a, c, np.zeros((r, r))) for a, c in self.pairs]
        drive = np.block([[np.eye(n), np.zeros((n, l))], [np.zeros((r, n)), Be]])
        noise = np.block([[self.V1, self.V12], [self.V12.T, self.V2]])
        errors = [np.hstack([self.L - De @ self.C, -Ce])]
        errors += [np.hstack([-De @ c, np.zeros((q, r))]) for _, c in self.pairs]
        weight = sum(e.T @ self.R @ e for e in errors)
        kron = sum(np.kron(f, f) for f in maps)
        one = np.eye(len(kron))
        V = drive @ noise @ drive.T
        Qt = np.linalg.solve(one - kron, V.ravel()).reshape(V.shape)
        Pt = np.linalg.solve(one - kron.T, weight.ravel()).reshape(V.shape)
        return Qt, Pt, np.trace(Qt @ weight) + np.trace(De @ self.V2 @ De.T @ self.R)

    def known(self, gains):
        """Everything the kernels are given, on the equivalent plant."""
        n = self.sizes[0]
        Qt, Pt, _ = self.moments(gains)
        found = dict(zip(GAINS, gains))
        found |= dict(A=self.A, C=self.C, L=self.L, R=self.R, Q1=Qt[:n, :n])
        found |= dict(Q12=Qt[:n, n:], Q2=Qt[n:, n:], P12=Pt[:n, n:], P2=Pt[n:, n:])
        found |= dict(V1=self.V1, V12=self.V12, V2=self.V2)
        for A1, C1 in self.pairs:
            added = run(lists.equivalent_noise, dict(A1=A1, C1=C1, X=found["Q1"]))
            for name in ("V1", "V12", "V2"):
                found[name] = found[name] + added[f"d{name}"]
        return found | run(lists.output_moments, found)

    def slope(self, gains, move, h=1e-5):
        ahead, back = (
            self.moments([g + sign * h * m for g, m in zip(gains, move)])[2]
            for sign in (1, -1)
        )
        return (ahead - back) / (2 * h)


@pytest.mark.parametrize("pairs", [0, 1, 2])
def test_moments_solve_their_equations(pairs):
    model = Model(1, pairs=pairs)
    known = model.known(model.estimator())
    A, Ae = known["A"], known["Ae"]
    ahead, back = (
        run(lists.estimator_moments, known),
        run(lists.adjoint_moments, known, "M12", "M2"),
    )
    Q1, Q12, Q2 = known["Q1"], known["Q12"], known["Q2"]
    P12, P2 = known["P12"], known["P2"]
    np.testing.assert_allclose(Q1, A @ Q1 @ A.T + known["V1"], atol=1e-11)
    np.testing.assert_allclose(Q12, A @ Q12 @ Ae.T + ahead["N12"], atol=1e-11)
    np.testing.assert_allclose(Q2, Ae @ Q2 @ Ae.T + ahead["N2"], atol=1e-11)
    np.testing.assert_allclose(P12, A.T @ P12 @ Ae + back["M12"], atol=1e-11)
    np.testing.assert_allclose(P2, Ae.T @ P2 @ Ae + back["M2"], atol=1e-11)


@pytest.mark.parametrize("pairs", [0, 1, 2])
def test_cost_and_gradients_against_the_independent_cost(pairs):
    model = Model(2, pairs=pairs)
    gains = model.estimator()
    known = model.known(gains)
    J = np.trace(run(lists.projection_cost, known, "J")["J"])
    assert J == pytest.approx(model.moments(gains)[2], rel=1e-12)
    gradient = run(lists.projection_gradient, known)
    for k, name in enumerate(GAINS):
        for index in np.ndindex(*gains[k].shape):
            move = [np.zeros_like(g) for g in gains]
            move[k][index] = 1
            slope = model.slope(gains, move)
            assert gradient[f"grad{name}"][index] == pytest.approx(slope, rel=1e-5)


def test_differential_against_differences_of_gradients():
    model = Model(3)
    gains = model.estimator()
    known, move = model.known(gains), [model.rng.normal(size=g.shape) for g in gains]
    known |= dict(zip(("dAe", "dBe", "dCe", "dDe"), move))
    A, Ae = known["A"], known["Ae"]
    for name, sides, right in (
        ("dQ12", (A, Ae.T), "dN12"),
        ("dQ2", (Ae, Ae.T), "dN2"),
        ("dP2", (Ae.T, Ae), "dM2"),
        ("dP12", (A.T, Ae), "dM12"),
    ):
        rest = run(lists.projection_differential, known, right)[right]
        known[name] = stein(*sides, rest)
    h = 1e-5
    ahead, back = (
        model.known([g + sign * h * m for g, m in zip(gains, move)]) for sign in (1, -1)
    )
    for name in ("Q12", "Q2", "P12", "P2"):
        slope = (ahead[name] - back[name]) / (2 * h)
        np.testing.assert_allclose(known[f"d{name}"], slope, rtol=1e-6, atol=1e-7)
    moved = run(lists.projection_differential, known, *(f"dgrad{X}" for X in GAINS))
    ahead, back = (run(lists.projection_gradient, k) for k in (ahead, back))
    for X in GAINS:
        slope = (ahead[f"grad{X}"] - back[f"grad{X}"]) / (2 * h)
        scale = np.abs(slope).max()
        np.testing.assert_allclose(moved[f"dgrad{X}"], slope, atol=1e-7 * scale)


def test_best_output_is_the_best():
    model = Model(4)
    Ae, Be, Ce, De = model.estimator()
    known = model.known([Ae, Be, Ce, De])
    r = len(Ae)
    both = run(lists.best_output, known, "CeDe")["CeDe"]
    alone = run(lists.best_output, known, "Ce")["Ce"]
    cost = lambda Ce, De: model.moments([Ae, Be, Ce, De])[2]  # noqa: E731
    best, silent = cost(both[:, :r], both[:, r:]), cost(alone, 0 * De)
    assert best < silent
    for _ in range(10):
        a, b = (0.1 * model.rng.normal(size=X.shape) for X in (Ce, De))
        assert cost(both[:, :r] + a, both[:, r:] + b) > best
        assert cost(alone + a, 0 * De) > silent


def test_best_output_differential_against_differences():
    model = Model(5)
    gains = model.estimator()
    move = [model.rng.normal(size=g.shape) for g in gains[:2]]
    zero = [0 * g for g in gains[2:]]

    def best(step):
        at = [g + step * m for g, m in zip(gains, [*move, *zero])]
        known = model.known(at)
        return known, run(lists.best_output, known)

    h = 1e-5
    (known, now), (ahead, up), (back, down) = best(0), best(h), best(-h)
    known |= {f"d{k}": (ahead[k] - back[k]) / (2 * h) for k in ("Q12", "Q2")}
    r = len(known["Ae"])
    known |= {"Czy": now["Czy"], "Ce": now["CeDe"][:, :r], "De": now["CeDe"][:, r:]}
    moved = run(lists.best_output_differential, known, "dCeDe")["dCeDe"]
    slope = (up["CeDe"] - down["CeDe"]) / (2 * h)
    np.testing.assert_allclose(moved, slope, atol=1e-7 * np.abs(slope).max())
    known |= {"Ce": now["Ce"], "De": 0 * known["De"]}
    moved = run(lists.best_output_differential, known, "dCe")["dCe"]
    slope = (up["Ce"] - down["Ce"]) / (2 * h)
    np.testing.assert_allclose(moved, slope, atol=1e-7 * np.abs(slope).max())


def riccati(known):
    """Q, Qs, V2s of the Kalman filter of the equivalent plant."""
    Q = known["V1"]
    for _ in range(2000):
        known["Q"] = Q
        known |= run(lists.projection_innovation, known)
        K = known["Qs"] @ np.linalg.inv(known["V2s"])
        Q = known["A"] @ Q @ known["A"].T + known["V1"] - K @ known["Qs"].T
    return known


@pytest.mark.parametrize("feedthrough", [True, False])
def test_excess_over_the_kalman_filter(feedthrough):
    model = Model(6)
    gains = model.estimator()
    if not feedthrough:
        gains[3] = 0 * gains[3]
    known = riccati(model.known(gains))
    best = run(lists.feedthrough_gain, known)["De"] if feedthrough else gains[3]
    least = np.trace(run(lists.projection_trace, known | {"De": best})["J"])
    other = run(lists.innovations_plant, known | {"De": best})
    there = Model(6, pairs=0)
    there.V1, there.V12, there.V2 = other["V1i"], known["Qs"], known["V2s"]
    there.L = other["Lq"]
    excess = there.moments([*gains[:3], gains[3] - best])[2]
    assert model.moments(gains)[2] == pytest.approx(least + excess, rel=1e-10)


def test_full_order_is_kalman_on_the_equivalent_plant():
    """G = Gam = I and the Riccati equation: every gradient vanishes, (3.27) is J."""
    model = Model(7, r=4)
    known = riccati(model.known(model.estimator()))
    one = np.eye(4)
    known |= {"G": one, "Gam": one, "De": run(lists.feedthrough_gain, known)["De"]}
    gains = run(lists.projection_gains, known)
    known = known | model.known([gains[k] for k in ("Ae", "Be", "Ce")] + [known["De"]])
    for name, value in run(lists.projection_gradient, known).items():
        np.testing.assert_allclose(value, 0, atol=1e-9, err_msg=name)
    J = model.moments([known[k] for k in GAINS])[2]
    formula = np.trace(run(lists.projection_trace, known)["J"])
    assert formula == pytest.approx(J, rel=1e-10)


# -- the settled question, in floating point ----------------------------------------


def minimum(model, seed):
    """A stationary estimator: BFGS with exact gradients and nothing else."""
    n, l, r, q = model.sizes
    shapes = [(r, r), (r, l), (q, r), (q, l)]
    ends = np.cumsum([a * b for a, b in shapes])[:-1]
    unpack = lambda v: [  # noqa: E731
        x.reshape(d) for x, d in zip(np.split(v, ends), shapes)
    ]

    def cost(v):
        gains = unpack(v)
        if np.abs(np.linalg.eigvals(gains[0])).max() >= 1:
            return 1e6, v
        known = model.known(gains)
        slopes = run(lists.projection_gradient, known)
        J = np.trace(run(lists.projection_cost, known, "J")["J"])
        return J, np.concatenate([slopes[f"grad{X}"].ravel() for X in GAINS])

    model.rng = np.random.default_rng(seed)
    start = np.concatenate([g.ravel() for g in model.estimator()])
    found = minimize(cost, start, jac=True, method="BFGS", options=dict(gtol=1e-10))
    return unpack(found.x)


def theorem_of(model, gains):
    """tau, Qh, Ph and residuals of (3.6), (3.14)-(3.17) at an estimator."""
    known = model.known(gains)
    known |= run(lists.projection_factors, known)
    known |= run(lists.projection_product, known)
    known |= run(lists.projection_innovation, known)
    known |= run(lists.projection_scripts, known, "Qh", "Ph")
    return known, run(lists.projection_equations, known)


@pytest.mark.parametrize("seed, pairs", [(10, 2), (11, 1), (12, 0)])
def test_a_minimum_satisfies_the_theorem(seed, pairs):
    model = Model(seed, pairs=pairs)
    gains = minimum(model, 2)
    known, equations = theorem_of(model, gains)
    for name in EQUATIONS:
        assert np.abs(equations[name]).max() < 1e-5, name
    np.testing.assert_allclose(known["I_e"], np.eye(2), atol=1e-6)
    formula = np.trace(run(lists.projection_trace, known)["J"])
    assert formula == pytest.approx(model.moments(gains)[2], rel=1e-7)


def test_every_choice_of_eigenprojections_made_for_is_stationary():
    """The converse, by numbers: a plant made for a projection, moments by Kronecker."""
    sizes, w = stationary(np.random.default_rng(4))
    n, r = sizes["n"], sizes["n_e"]
    Q1 = w["Q"] + w["G"].T @ w["Q2"] @ w["G"]
    model = Model(0, n=n, l=n, r=r, q=n, pairs=0)
    model.A, model.C, model.L, model.R = (w[k] for k in "ACLR")
    model.V1 = Q1 - w["A"] @ Q1 @ w["A"].T
    model.V12 = w["Qs"] - w["A"] @ w["Q"] @ w["C"].T
    model.V2 = w["V2s"] - w["C"] @ w["Q"] @ w["C"].T
    gains = [run(lists.projection_gains, w)[k] for k in ("Ae", "Be", "Ce")]
    gains.append(w["De"])
    known = model.known(gains)
    for name, value in run(lists.projection_gradient, known).items():
        assert np.abs(value).max() < 1e-10, name
    np.testing.assert_allclose(known["Q12"], w["G"].T @ w["Q2"], atol=1e-10)
    np.testing.assert_allclose(known["P12"], -w["Gam"].T @ w["P2"], atol=1e-10)
    _, equations = theorem_of(model, gains)
    assert max(np.abs(v).max() for k, v in equations.items() if k in EQUATIONS) < 1e-9


@pytest.mark.parametrize("name", ["neither", "Qh alone", "Ph alone"])
def test_counterexamples_by_other_code(name):
    """The weaker readings, in floating point and with the independent cost."""
    exact, improved = counterexamples.examples()[name]
    value = {X.name: np.array(v.tolist(), dtype=float) for X, v in exact.items()}
    model = Model(0, n=2, l=1, r=1, q=1, pairs=0)
    model.A, model.C, model.L, model.R = (value[k] for k in "ACLR")
    model.V1, model.V12, model.V2 = (value[k] for k in ("V1", "V12", "V2"))
    joint = np.block([[model.V1, model.V12], [model.V12.T, model.V2]])
    assert np.linalg.eigvalsh(joint)[0] > 0
    gains = [value[k] for k in GAINS]
    slopes = run(lists.projection_gradient, model.known(gains))
    assert max(np.abs(slopes[f"grad{X}"]).max() for X in GAINS) > 0.1
    residuals = run(lists.projection_equations, value)
    for key in ("riccati", "estimate", "adjoint", "idempotent"):
        assert np.abs(residuals[key]).max() < 1e-14
    assert (np.abs(residuals["aligned_Q"]).max() < 1e-14) == (name == "Qh alone")
    assert (np.abs(residuals["aligned_P"]).max() < 1e-14) == (name == "Ph alone")
    better = [np.array(improved[X].tolist(), dtype=float) for X in letters.GAINS]
    J, less = model.moments(gains)[2], model.moments(better)[2]
    assert J == pytest.approx(float(counterexamples.price(exact)), rel=1e-12)
    assert less == pytest.approx(float(counterexamples.price(improved)), rel=1e-12)
    assert less < 0.8 * J
