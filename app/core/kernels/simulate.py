"""Beams of a virtual scanner against leaves, stems and walls, sub-ray by sub-ray.

One file: numba's cache does not see a change in another file that a kernel calls.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

MARCH = 0.004
"""Sideways step, metres, in which a curved leaf is searched for its first crossing."""
REFINEMENTS = 12
CLOSE = 1e-9
"""Metres from a leaf's height at which its crossing counts as found."""
NOTHING = -1


class LeafTable(NamedTuple):
    """Leaves as arrays, one row each."""

    centre: Any  # (n, 3) m
    frame: Any  # (n, 3, 3): rows along, across, normal
    outline: Any  # (n, 3): half length, half width, taper
    bend: Any  # (n, 3): curvature, cos and sin of its direction in the leaf
    wrinkle: Any  # (n, 5): height, wave numbers along and across, phases
    slab: Any  # (n, 2): lowest and highest height over the local plane


class StemTable(NamedTuple):
    """Stems: cylinders with round ends."""

    start: Any  # (n, 3) m
    end: Any  # (n, 3) m
    radius: Any  # (n,) m


class WallTable(NamedTuple):
    """Plane rectangles."""

    centre: Any  # (n, 3) m
    frame: Any  # (n, 3, 3): rows across, up, normal
    half: Any  # (n, 2): half width and half height, m


class SceneTable(NamedTuple):
    """All surfaces; their index runs over leaves, then stems, then walls."""

    leaves: LeafTable
    stems: StemTable
    walls: WallTable
    sphere: Any  # (leaves + stems, 4): centre and radius of the bounding spheres
    optics: Any  # (surfaces, channels, 3): rho, k_d, m


class BeamTable(NamedTuple):
    """Bundle of sub-rays and the way in which their echoes become a range."""

    subrays: Any  # (k, 3): offsets in units of the beam radius, share of the energy
    exit_radius: float  # m
    spread: float  # tan of the half divergence
    wavelengths: Any  # (w,) m, coarse to fine
    octaves: Any  # (w,) how often each wavelength is half of the one before
    ranging_channel: int
    threshold: float  # least reflectance times share that gives a return


class TileTable(NamedTuple):
    """Surfaces that the beams of each square tile of the grid can meet."""

    size: int
    columns: int
    start: Any  # (tiles + 1,)
    surface: Any


@njit(cache=True, nogil=True)
def dot(a, b):  # type: ignore[no-untyped-def]
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True)
def minus(a, b):  # type: ignore[no-untyped-def]
    """Difference of two vectors."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit(cache=True, nogil=True)
def along(o, d, t):  # type: ignore[no-untyped-def]
    """Point of a ray at t."""
    return (o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2])


@njit(cache=True, nogil=True)
def take(table, i):  # type: ignore[no-untyped-def]
    """Row of three as a tuple: a view of the array would be counted at every use."""
    return (table[i, 0], table[i, 1], table[i, 2])


@njit(cache=True, nogil=True)
def turn(frames, i, a):  # type: ignore[no-untyped-def]
    """Vector in the frame of surface i."""
    return (
        frames[i, 0, 0] * a[0] + frames[i, 0, 1] * a[1] + frames[i, 0, 2] * a[2],
        frames[i, 1, 0] * a[0] + frames[i, 1, 1] * a[1] + frames[i, 1, 2] * a[2],
        frames[i, 2, 0] * a[0] + frames[i, 2, 1] * a[1] + frames[i, 2, 2] * a[2],
    )


@njit(cache=True, nogil=True)
def localise(centres, frames, i, axes):  # type: ignore[no-untyped-def]
    """Origin, direction, left and up of a beam in the frame of a surface."""
    origin, d, left, up = axes
    o = turn(frames, i, minus(origin, take(centres, i)))
    return o, turn(frames, i, d), turn(frames, i, left), turn(frames, i, up)


@njit(cache=True, nogil=True)
def split(axes, beam, k):  # type: ignore[no-untyped-def]
    """Start and direction of sub-ray k of a beam."""
    o, d, left, up = axes
    a, b = beam.subrays[k, 0], beam.subrays[k, 1]
    offset = (a * left[0] + b * up[0], a * left[1] + b * up[1], a * left[2] + b * up[2])
    return along(o, offset, beam.exit_radius), along(d, offset, beam.spread)


@njit(cache=True, nogil=True)
def keep(hits, k, t, facing, surface):  # type: ignore[no-untyped-def]
    """Remember a crossing of sub-ray k where it is the nearest so far."""
    if 0.0 < t < hits[k, 0]:
        hits[k, 0] = t
        hits[k, 1] = min(facing, 1.0)
        hits[k, 2] = surface


@njit(cache=True, nogil=True)
def height(shape, x, y):  # type: ignore[no-untyped-def]
    """Height of a leaf over its plane, and the two slopes."""
    bend, wrinkle = shape
    h, hx, hy = 0.0, 0.0, 0.0
    if bend[0] != 0.0:
        s = bend[0] * (x * bend[1] + y * bend[2])
        root = math.sqrt(max(1.0 - s * s, 0.05))
        h = (1.0 - root) / bend[0]
        hx = s / root * bend[1]
        hy = s / root * bend[2]
    if wrinkle[0] != 0.0:
        u = wrinkle[1] * x + wrinkle[3]
        v = wrinkle[2] * y + wrinkle[4]
        su, sv = math.sin(u), math.sin(v)
        h += wrinkle[0] * su * sv
        hx += wrinkle[0] * wrinkle[1] * math.cos(u) * sv
        hy += wrinkle[0] * wrinkle[2] * su * math.cos(v)
    return h, hx, hy


@njit(cache=True, nogil=True)
def within(outline, x, y):  # type: ignore[no-untyped-def]
    """Whether a place of the local plane lies inside the egg-shaped outline."""
    s = x / outline[0]
    if s * s >= 1.0:
        return False
    w = outline[1] * (1.0 - outline[2] * s)
    return y * y <= w * w * (1.0 - s * s)


@njit(cache=True, nogil=True)
def gap(shape, o, d, t):  # type: ignore[no-untyped-def]
    """Height of a ray over a leaf at t, and its change with t."""
    h, hx, hy = height(shape, o[0] + t * d[0], o[1] + t * d[1])
    return o[2] + t * d[2] - h, d[2] - hx * d[0] - hy * d[1]


@njit(cache=True, nogil=True)
def refine(shape, o, d, low, high, f_low):  # type: ignore[no-untyped-def]
    """Newton steps kept inside a bracket, so that a grazing ray cannot run away."""
    t = 0.5 * (low + high)
    for _ in range(REFINEMENTS):
        f, slope = gap(shape, o, d, t)
        if abs(f) < CLOSE:
            break
        if (f > 0.0) == (f_low > 0.0):
            low = t
        else:
            high = t
        step = t - f / slope if slope != 0.0 else low
        t = step if low < step < high else 0.5 * (low + high)
    return t


@njit(cache=True, nogil=True)
def meet_slab(slab, radius, o, d):  # type: ignore[no-untyped-def]
    """Stretch of a ray inside a leaf's bounding sphere and slab; empty when high < low."""
    middle = -dot(o, d)
    half = middle * middle - dot(o, o) + radius * radius
    if half <= 0.0:
        return 1.0, 0.0
    half = math.sqrt(half)
    low, high = middle - half, middle + half
    if d[2] != 0.0:
        a, b = (slab[0] - o[2]) / d[2], (slab[1] - o[2]) / d[2]
        low, high = max(low, min(a, b)), min(high, max(a, b))
    return low, high


@njit(cache=True, nogil=True)
def meet_curved(outline, shape, span, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| of the first crossing of a curved leaf within `span`."""
    low, high = span
    steps = 1 + int((high - low) * math.hypot(d[0], d[1]) / MARCH)
    step = (high - low) / steps
    f_low, _ = gap(shape, o, d, low)
    for k in range(steps):
        stop = low + (k + 1) * step
        f_high, _ = gap(shape, o, d, stop)
        if (f_low > 0.0) != (f_high > 0.0):
            t = refine(shape, o, d, stop - step, stop, f_low)
            x, y = o[0] + t * d[0], o[1] + t * d[1]
            if within(outline, x, y):
                _, hx, hy = height(shape, x, y)
                facing = abs(d[2] - hx * d[0] - hy * d[1])
                return t, facing / math.sqrt(1.0 + hx * hx + hy * hy)
        f_low = f_high
    return np.inf, 0.0


@njit(cache=True, nogil=True)
def meet_leaf(leaves, i, radius, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against one leaf."""
    axes = localise(leaves.centre, leaves.frame, i, axes)
    outline, slab = take(leaves.outline, i), (leaves.slab[i, 0], leaves.slab[i, 1])
    w = leaves.wrinkle
    shape = (take(leaves.bend, i), (w[i, 0], w[i, 1], w[i, 2], w[i, 3], w[i, 4]))
    flat = shape[0][0] == 0.0 and shape[1][0] == 0.0
    for k in range(len(beam.subrays)):
        o, d = split(axes, beam, k)
        if flat:
            t = -o[2] / d[2] if d[2] != 0.0 else -1.0
            if within(outline, o[0] + t * d[0], o[1] + t * d[1]):
                keep(hits, k, t, abs(d[2]), i)
            continue
        span = meet_slab(slab, radius, o, d)
        if span[0] < span[1]:
            t, facing = meet_curved(outline, shape, span, o, d)
            keep(hits, k, t, facing, i)


@njit(cache=True, nogil=True)
def meet_sphere(centre, radius, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a sphere."""
    p = minus(o, centre)
    half = dot(p, d)
    root = half * half - dot(d, d) * (dot(p, p) - radius * radius)
    if root <= 0.0:
        return np.inf, 0.0
    t = (-half - math.sqrt(root)) / dot(d, d)
    return t, abs(dot(minus(along(o, d, t), centre), d)) / radius


@njit(cache=True, nogil=True)
def meet_cylinder(start, axis, radius, o, d):  # type: ignore[no-untyped-def]
    """Distance and |cos ω| on a cylinder without ends."""
    p = minus(o, start)
    length2, ad, ap = dot(axis, axis), dot(axis, d), dot(axis, p)
    a = dot(d, d) - ad * ad / length2
    b = dot(d, p) - ad * ap / length2
    root = b * b - a * (dot(p, p) - ap * ap / length2 - radius * radius)
    if root <= 0.0 or a <= 0.0:
        return np.inf, 0.0
    t = (-b - math.sqrt(root)) / a
    place = (ap + t * ad) / length2
    if place < 0.0 or place > 1.0:
        return np.inf, 0.0
    foot = along(start, axis, place)
    return t, abs(dot(minus(along(o, d, t), foot), d)) / radius


@njit(cache=True, nogil=True)
def meet_stem(stems, i, axes, beam, hits, surface):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a cylinder with round ends."""
    start, end, radius = take(stems.start, i), take(stems.end, i), stems.radius[i]
    axis = minus(end, start)
    for k in range(len(beam.subrays)):
        o, d = split(axes, beam, k)
        t, facing = meet_cylinder(start, axis, radius, o, d)
        keep(hits, k, t, facing, surface)
        t, facing = meet_sphere(start, radius, o, d)
        keep(hits, k, t, facing, surface)
        t, facing = meet_sphere(end, radius, o, d)
        keep(hits, k, t, facing, surface)


@njit(cache=True, nogil=True)
def meet_wall(walls, i, axes, beam, hits, surface):  # type: ignore[no-untyped-def]
    """Sub-rays of a beam against a rectangle."""
    axes = localise(walls.centre, walls.frame, i, axes)
    half_width, half_height = walls.half[i, 0], walls.half[i, 1]
    for k in range(len(beam.subrays)):
        o, d = split(axes, beam, k)
        t = -o[2] / d[2] if d[2] != 0.0 else -1.0
        if abs(o[0] + t * d[0]) <= half_width and abs(o[1] + t * d[1]) <= half_height:
            keep(hits, k, t, abs(d[2]), surface)


@njit(cache=True, nogil=True)
def meet_scene(scene, near, count, axes, beam, hits):  # type: ignore[no-untyped-def]
    """Nearest crossing of each sub-ray into `hits`: distance, |cos ω|, surface."""
    hits[:, 0] = np.inf
    hits[:, 2] = NOTHING
    leaf_count, first_wall = len(scene.leaves.centre), len(scene.sphere)
    for k in range(count):
        i = near[k]
        if i < leaf_count:
            meet_leaf(scene.leaves, i, scene.sphere[i, 3], axes, beam, hits)
        else:
            meet_stem(scene.stems, i - leaf_count, axes, beam, hits, i)
    for i in range(len(scene.walls.centre)):
        meet_wall(scene.walls, i, axes, beam, hits, first_wall + i)


@njit(cache=True, nogil=True)
def reflect(optics, surface, channel, facing):  # type: ignore[no-untyped-def]
    """Lambert–Beckmann reflectance, rho times science.md 3, at cos ω = `facing`."""
    rho = optics[surface, channel, 0]
    k_d, m = optics[surface, channel, 1], optics[surface, channel, 2]
    if k_d == 1.0:
        return rho * facing
    cos2 = max(facing * facing, 1e-12)
    t = (1.0 - cos2) / cos2
    return rho * (k_d * facing + (1.0 - k_d) * math.exp(-t / (m * m) + 2.5 * math.log1p(t)))


@njit(cache=True, nogil=True)
def unwrap(real, imaginary, wavelengths):  # type: ignore[no-untyped-def]
    """Range from the phases of summed echoes: the coarse one picks the finer one's cycle."""
    distance = 0.0
    for k in range(len(wavelengths)):
        interval = 0.5 * wavelengths[k]
        turns = math.atan2(imaginary[k], real[k]) / (2.0 * math.pi)
        if k == 0:
            distance = (turns % 1.0) * interval
        else:
            distance = (turns + np.round(distance / interval - turns)) * interval
    return distance


@njit(cache=True, nogil=True)
def point_beam(origin, elevation, azimuth):  # type: ignore[no-untyped-def]
    """Axes of a beam: origin, direction, and the two directions across it (left, up)."""
    ce, se = math.cos(elevation), math.sin(elevation)
    ca, sa = math.cos(azimuth), math.sin(azimuth)
    o = (origin[0], origin[1], origin[2])
    return o, (ce * ca, ce * sa, se), (-sa, ca, 0.0), (-se * ca, -se * sa, ce)


@njit(cache=True, nogil=True)
def gather(scene, beam, tiles, tile, axes, near):  # type: ignore[no-untyped-def]
    """Surfaces of a tile whose bounding sphere this beam touches, into `near`."""
    o, d = axes[0], axes[1]
    count = 0
    for k in range(tiles.start[tile], tiles.start[tile + 1]):
        i = tiles.surface[k]
        p = minus(take(scene.sphere, i), o)
        t = dot(p, d)
        reach = scene.sphere[i, 3] + beam.exit_radius + max(t, 0.0) * beam.spread
        if dot(p, p) - t * t <= reach * reach:
            near[count] = i
            count += 1
    return count


@njit(cache=True, nogil=True)
def find_surface(touched, count, surface):  # type: ignore[no-untyped-def]
    """Slot of a surface among those touched; `count` when it is new."""
    for k in range(count):
        if touched[k] == surface:
            return k
    return count


@njit(cache=True, nogil=True)
def turn_phases(beam, echo, t, sums):  # type: ignore[no-untyped-def]
    """Add one echo to the sums over modulation wavelengths.

    Finer wavelengths divide coarser ones, so their phasors are powers: one sine instead of many.
    """
    phase = 4.0 * math.pi * t / beam.wavelengths[0]
    re, im = math.cos(phase), math.sin(phase)
    sums[0, 0] += echo * re
    sums[1, 0] += echo * im
    for w in range(1, len(beam.wavelengths)):
        for _ in range(beam.octaves[w]):
            re, im = re * re - im * im, 2.0 * re * im
        sums[0, w] += echo * re
        sums[1, w] += echo * im


@njit(cache=True, nogil=True)
def sum_echoes(optics, beam, hits, touched, met, sums, energy):  # type: ignore[no-untyped-def]
    """Add up the echoes of one beam; returns how many surfaces it touched.

    `touched` gets the surfaces, `met` per surface: share, nearest and farthest distance,
    share-weighted distance, cos ω at the sub-ray nearest to the beam's centre.
    """
    found = 0
    sums[:] = 0.0
    energy[:] = 0.0
    for k in range(len(hits)):
        surface = int(hits[k, 2])
        if surface == NOTHING:
            continue
        t, facing, share = hits[k, 0], hits[k, 1], beam.subrays[k, 2]
        slot = find_surface(touched, found, surface)
        if slot == found:
            touched[slot] = surface
            met[slot] = (0.0, t, t, 0.0, facing)
            found += 1
        met[slot, 0] += share
        met[slot, 1] = min(met[slot, 1], t)
        met[slot, 2] = max(met[slot, 2], t)
        met[slot, 3] += share * t
        for c in range(len(energy)):
            echo = share * reflect(optics, surface, c, facing) / (t * t)
            energy[c] += echo
            if c == beam.ranging_channel:
                turn_phases(beam, echo, t, sums)
    return found


@njit(cache=True, nogil=True)
def judge(met, found, distance):  # type: ignore[no-untyped-def]
    """Slot of the surface with most energy, and how far a range is from any surface met."""
    main, off = 0, np.inf
    for k in range(found):
        if met[k, 0] > met[main, 0]:
            main = k
        off = min(off, max(met[k, 1] - distance, distance - met[k, 2], 0.0))
    return main, off


@njit(cache=True, nogil=True)
def trace(scene, beam, tiles, origin, elevation, azimuth, band, truth, energies, surfaces):  # type: ignore[no-untyped-def]
    """Trace the rows `band` = (first, end) of a grid into the last three arrays.

    Threads take a band each: numba's own parallel loop cannot carry nested tables.
    """
    columns = len(azimuth)
    near = np.empty(len(scene.sphere), np.int64)
    hits = np.empty((len(beam.subrays), 3))
    touched = np.empty(len(beam.subrays), np.int64)
    met = np.empty((len(beam.subrays), 5))
    sums = np.empty((2, len(beam.wavelengths)))
    energy = np.empty(energies.shape[1])
    for row in range(band[0], band[1]):
        for column in range(columns):
            axes = point_beam(origin, elevation[row], azimuth[column])
            tile = (row // tiles.size) * tiles.columns + column // tiles.size
            count = gather(scene, beam, tiles, tile, axes, near)
            meet_scene(scene, near, count, axes, beam, hits)
            found = sum_echoes(scene.optics, beam, hits, touched, met, sums, energy)
            if found == 0:
                continue
            distance = unwrap(sums[0], sums[1], beam.wavelengths)
            if distance <= 0.0 or energy[beam.ranging_channel] * distance**2 < beam.threshold:
                continue
            main, off = judge(met, found, distance)
            cell = row * columns + column
            surfaces[cell] = touched[main]
            energies[cell] = energy * distance**2
            hit = met[main, 3] / met[main, 0]
            angle = math.acos(met[main, 4])
            truth[cell] = (distance, off, distance - hit, met[main, 0], angle)
