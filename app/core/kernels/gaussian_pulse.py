"""A Gaussian through the samples of a return: start from a parabola, then Levenberg–Marquardt."""

import math

from numba import njit

from app.core.kernels import INNER

STEPS = 30
"""Steps of the fit, accepted or not."""
SETTLED = 1e-10
"""Share of a step in the height and width below which the fit has ended."""
NARROWEST = 0.4
"""σ of a pulse in samples: of a narrower one a single sample holds nearly all."""
ROOT = math.sqrt(2.0 * math.pi)


@njit(**INNER)
def fit_gaussian(samples, bounds, feet, quiet, ceiling):  # type: ignore[no-untyped-def]
    """Area under the Gaussian, in sample steps, and its σ; NaN where none fits.

    Saturated samples are left out: what the others tell of the pulse stands for them.
    """
    level, sigma, error = quiet[0], quiet[1], quiet[2]
    data = (feet[0], feet[1], level, ceiling)
    pulse = start_gaussian(samples, bounds, level, ceiling)
    damp = 1e-3
    normal = form_equations(samples, data, pulse)
    if normal[10] < 3:
        return math.nan, math.nan
    for _ in range(STEPS):
        step = solve(normal, (normal[6], normal[7], normal[8]), damp)
        trial = (pulse[0] + step[0], pulse[1] + step[1], pulse[2] + step[2])
        nearer = False
        if trial[0] > 0.0 and trial[2] > 0.5 * NARROWEST:
            other = form_equations(samples, data, trial)
            nearer = other[9] <= normal[9]
        if nearer:
            pulse, normal, damp = trial, other, max(0.1 * damp, 1e-12)
            if abs(step[0]) < SETTLED * pulse[0] and abs(step[2]) < SETTLED * pulse[2]:
                break
        else:
            damp *= 10.0
            if damp > 1e8:
                break
    height, middle, width = pulse
    if not (feet[0] - 1.0 < middle < feet[1] and NARROWEST < width < feet[1] - feet[0]):
        return math.nan, math.nan
    slope = solve(normal, (width * ROOT, 0.0, height * ROOT), 0.0)
    variance = ROOT * (slope[0] * width + slope[2] * height) * sigma * sigma
    shift = slope[0] * normal[11] + slope[1] * normal[12] + slope[2] * normal[13]
    return height * width * ROOT, math.sqrt(variance + (shift * error) ** 2)


@njit(**INNER)
def start_gaussian(samples, bounds, level, ceiling):  # type: ignore[no-untyped-def]
    """Height, middle and σ from a parabola through the logarithms (Guo 2011).

    Weights are the squares of the samples, as the noise of a logarithm is one over the sample.
    """
    low, high, _ = bounds
    top, total = low, 0.0
    for i in range(low, high):
        total += samples[i] - level
        top = i if samples[i] > samples[top] else top
    a = b = c = d = e = f = g = h = 0.0
    for i in range(low, high):
        y = samples[i] - level
        if y <= 0.0 or samples[i] >= ceiling:
            continue
        x, w, z = float(i - top), y * y, math.log(y)
        a, b, c, d, e = a + w, b + w * x, c + w * x**2, d + w * x**3, e + w * x**4
        f, g, h = f + w * z, g + w * x * z, h + w * x * x * z
    p, q, r = solve((a, b, c, c, d, e), (f, g, h), 0.0)
    if r < 0.0:
        middle, width = -0.5 * q / r, math.sqrt(-0.5 / r)
        if abs(middle) < high - low and NARROWEST < width < high - low:
            return math.exp(p - 0.25 * q * q / r), top + middle, width
    height = samples[top] - level
    return height, float(top), max(total / (height * ROOT), 2.0 * NARROWEST)


@njit(**INNER)
def form_equations(samples, data, pulse):  # type: ignore[no-untyped-def]
    """JᵀJ (six), Jᵀr (three), rᵀr, number of samples, Jᵀ1 (three)."""
    first, end, level, ceiling = data
    height, middle, width = pulse
    aa = am = aw = mm = mw = ww = ra = rm = rw = rr = sa = sm = sw = 0.0
    count = 0
    for i in range(first, end):
        if samples[i] >= ceiling:
            continue
        x = (i - middle) / width
        a = math.exp(-0.5 * x * x)
        m = height * a * x / width
        w = m * x
        r = samples[i] - level - height * a
        aa, am, aw = aa + a * a, am + a * m, aw + a * w
        mm, mw, ww = mm + m * m, mw + m * w, ww + w * w
        ra, rm, rw, rr = ra + r * a, rm + r * m, rw + r * w, rr + r * r
        sa, sm, sw = sa + a, sm + m, sw + w
        count += 1
    return aa, am, aw, mm, mw, ww, ra, rm, rw, rr, count, sa, sm, sw


@njit(**INNER)
def solve(normal, right, damp):  # type: ignore[no-untyped-def]
    """Solve the symmetric equations, with their diagonal raised by a share; NaN if singular."""
    aa, am, aw, mm, mw, ww = normal[0], normal[1], normal[2], normal[3], normal[4], normal[5]
    aa, mm, ww = aa * (1.0 + damp), mm * (1.0 + damp), ww * (1.0 + damp)
    p, q, r = mm * ww - mw * mw, aw * mw - am * ww, am * mw - aw * mm
    s, t, u = aa * ww - aw * aw, am * aw - aa * mw, aa * mm - am * am
    det = aa * p + am * q + aw * r
    if abs(det) <= 1e-13 * abs(aa * mm * ww):
        return math.nan, math.nan, math.nan
    x, y, z = right
    return (
        (p * x + q * y + r * z) / det,
        (q * x + s * y + t * z) / det,
        (r * x + t * y + u * z) / det,
    )
