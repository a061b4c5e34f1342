"""One degree of freedom by the scheme of Hilber, Hughes and Taylor."""


def oscillator(
    omega: float, step_s: float, steps: int, alpha: float, speed: float
) -> tuple[float, float]:
    """Displacement, and part of the energy that is left, of one degree of freedom.

    These are the scheme's own equations (Hughes, The Finite Element Method, 1987, section 9.3).
    """
    beta, gamma = (1 - alpha) ** 2 / 4, 0.5 - alpha
    u, v, a = 0.0, speed, 0.0
    for _ in range(steps):
        ahead = u + step_s * v + step_s**2 * (0.5 - beta) * a
        then = -(omega**2) * ((1 + alpha) * ahead - alpha * u)
        then /= 1 + (1 + alpha) * beta * (omega * step_s) ** 2
        v += step_s * ((1 - gamma) * a + gamma * then)
        u, a = ahead + beta * step_s**2 * then, then
    return u, (v**2 + omega**2 * u**2) / speed**2
