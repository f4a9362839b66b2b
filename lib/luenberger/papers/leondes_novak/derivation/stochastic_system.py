"""The plant and its statistics.

The mean of the state moves without the noises, and its covariance with one of them.
What each assumption of the paper is good for is seen in the reasons of the lines.

Source: Leondes and Novak (1974), section I, (1)-(6).
"""

from matrixproof import Page, ZeroMatrix

from .letters import SOURCE, letters, n, p
from .letters.plant import A, B, C, E, Q, R, d, u, v, w, x, x_bar, x_next, y
from .letters.step import Sigma

page = Page(letters=letters, source=f"{SOURCE}, section I")

page("""The plant is linear, and what is measured of it as well. The paper has no
    feedthrough, `E = 0`; carrying it along costs nothing.""")
plant = page.let(x_next, A * x + B * u + w, "1")
measured = page.let(y, C * x + E * u + v, "2")

page("""Both noises have mean zero and are white. The state has a mean and deviates from
    it. At the start its mean and the covariance of its deviation are given.""")
mean_w = page.moment(w, ZeroMatrix(n, 1), "3")
mean_v = page.moment(v, ZeroMatrix(p, 1), "3")
mean_x = page.moment(x, x_bar, "6")
page(
    letters.derive("1, 3", "the mean of the state moves without the noise", x_next)
    .put(plant)
    .expect(mean_x, mean_w)
)
page(
    letters.derive("2, 3", "the mean of the measurement", y)
    .put(measured)
    .expect(mean_x, mean_v)
)

page("So the deviation moves with the plant, and noise is added to it.")
is_d = page.let(d, x - x_bar, "6")
deviation = page(
    letters.derive("1, 6", "the deviation from the mean", x_next - (A * x_bar + B * u))
    .put(plant)
    .fold(is_d)
)

page("""The noise of an instant is independent of all that was before it. The covariance
    is then a sum of two terms.""")
is_Sigma_x = page.moment(d * d.T, Sigma, "6")
is_Q = page.moment(w * w.T, Q, "4")
white = page.moment(d * w.T, ZeroMatrix(n, n), "4")
page(
    letters.derive(
        "4, 6", "the covariance of the state", (A * d + w) * (A * d + w).T
    ).expect(is_Sigma_x, is_Q, white)
)

page("""A measurement has the covariance of what it shows and of its noise. The two are
    independent, because the measurement noise is white and independent of the process
    noise.""")
is_R = page.moment(v * v.T, R, "4")
apart = page.moment(d * v.T, ZeroMatrix(n, p), "5")
page(
    letters.derive(
        "4, 5", "the covariance of the measurement", (C * d + v) * (C * d + v).T
    ).expect(is_Sigma_x, is_R, apart)
)
