"""The camera: from pixels to the plane in which a finger bends, and what is not known of that.

One vector of unknowns has lens, pose and the plane of the dots. Each has a prior; the corners of a
printed sheet, or lengths between points, are fitted beside it. What they do not determine stays as
wide as its prior, so a scale of two points says nothing of the camera's tilt, and says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np
from scipy.optimize import least_squares

from dolfingrip.sections.errors import ConfigError

Floats = np.ndarray

UNKNOWNS: Final = (
    "log_focal", "centre_u", "centre_v", "k1", "k2", "turn_u", "turn_v", "turn_w", "at_u", "at_v",
    "log_mm_per_px", "in_front_mm", "plane_turn_v", "plane_turn_u",
)  # fmt: skip
"""Focal length (log of pixels), principal point and distortion; the pose: rotation (rad), place of
the sheet's origin in the picture from its middle (by the longer side), scale there (log of mm/px);
the dots' plane: its distance in front of the sheet (mm), its turn about v and u (rad). A picture
tells place and scale far better than focal length and distance, which so stand for themselves."""

DRAWS: Final = 200
"""Cameras that are drawn for the error of the scale."""

F, K1, TURN, AT, SCALE, FRONT = 0, 3, slice(5, 8), slice(8, 10), 10, 11


@dataclass(frozen=True, slots=True)
class CameraPolicy:
    """Standard deviations of any camera, before a frame is seen.

    Attributes:
        focal: focal length by the longer side of the picture; phones have 0.7 to 1.1.
        focal_log: of its logarithm.
        centre: of the principal point, by the longer side.
        k1, k2: of the distortion.
        tilt_deg: of the camera against the plane, where no sheet tells it.
        plane_deg: of the plane of bending against the sheet.
        corner_px: of a corner of the sheet, at least.
        capture: of the logarithm of a motion capture's scale, which a wand of 0.1 % sets.
        least_corners: fewer corners are no sheet.
    """

    focal: float = 0.9
    focal_log: float = 0.15
    centre: float = 0.006
    k1: float = 0.1
    k2: float = 0.1
    tilt_deg: float = 6.0
    plane_deg: float = 0.5
    corner_px: float = 0.06
    capture: float = 0.001
    least_corners: int = 8


POLICY: Final = CameraPolicy()


@dataclass(frozen=True, slots=True)
class Length:
    """A known length between two points of the picture.

    Attributes:
        ends_px: (2, 2).
        length_mm: its length.
        std_mm: of it.
    """

    ends_px: Floats
    length_mm: float
    std_mm: float

    @classmethod
    def pointed_at(cls, ends_px: Floats, length_mm: float) -> Length:
        """A length whose ends a person told: to a pixel between them, and to 0.2 % by a ruler.

        Args:
            ends_px: (2, 2).
            length_mm: its length.
        """
        away_px = float(np.linalg.norm(ends_px[1] - ends_px[0]))
        return cls(ends_px, length_mm, length_mm * float(np.hypot(1 / away_px, 0.002)))


@dataclass(frozen=True)
class Calibration:
    """A camera and what is not known of it.

    Attributes:
        size_px: width and height of a frame.
        mean: (14,) values of :data:`UNKNOWNS`.
        covariance: (14, 14).
        prior_std: (14,) before anything was seen.
        by: what the scale is from.
        residual_px: root mean square of the sheet's corners; NaN without a sheet.
        has_sheet: whether a sheet tells the pose.
        ends_px: (2, 2) ends of the only length that told the scale; None: otherwise.
    """

    size_px: tuple[int, int]
    mean: Floats
    covariance: Floats
    prior_std: Floats
    by: str
    residual_px: float = float("nan")
    has_sheet: bool = False
    ends_px: Floats | None = None
    doubts: list[str] = field(default_factory=list)

    def plane_mm(self, points_px: Floats, unknowns: Floats | None = None) -> Floats:
        """Places in the plane of bending, u to the right and v downwards.

        Args:
            points_px: (…, 2) points of a frame; NaN where there is none.
            unknowns: (14,); None: the mean.

        Returns:
            (…, 2) in mm.
        """
        return _to_plane(self.mean if unknowns is None else unknowns, self.size_px, points_px)

    def pixels(self, plane_mm: Floats, deeper_mm: Floats) -> Floats:
        """Where points are seen.

        Args:
            plane_mm: (…, 2) u and v in the plane of bending.
            deeper_mm: (…) distance behind that plane.

        Returns:
            (…, 2) in px.
        """
        solid = np.concatenate([plane_mm, (deeper_mm - self.mean[FRONT])[..., None]], axis=-1)
        seen = _to_pixels(self.mean, self.size_px, solid.reshape(-1, 3))
        return np.asarray(seen.reshape(plane_mm.shape))

    def draws(self, count: int, generator: np.random.Generator) -> Floats:
        """Cameras (count, 14) that fit what was seen.

        Args:
            count: number of them.
            generator: of random numbers.
        """
        values, vectors = np.linalg.eigh(self.covariance)
        spread = vectors * np.sqrt(np.maximum(values, 0.0))
        return np.asarray(self.mean + generator.standard_normal((count, len(self.mean))) @ spread.T)

    @property
    def tilt_deg(self) -> float:
        """Angle between the camera's axis and the normal of the sheet, or of the plane."""
        return float(np.degrees(np.arccos(np.clip(_rotation(self.mean)[2, 2], -1, 1))))

    @property
    def square(self) -> Calibration:
        """This camera without errors of a tilt that no sheet tells."""
        if self.has_sheet:
            return self
        certain = self.covariance.copy()
        certain[TURN] = certain[:, TURN] = 0.0
        return replace(self, covariance=certain)

    @property
    def axis_std_deg(self) -> float:
        """Standard deviation of the axis from the normal of the plane, about either axis."""
        draws = self.draws(DRAWS, np.random.default_rng(0))
        normals = []
        for unknowns in [self.mean, *draws]:
            normal = np.r_[-np.tan(unknowns[12:14]), 1.0]
            normals.append(_rotation(unknowns) @ normal / np.linalg.norm(normal))
        off = np.array(normals[1:]) - normals[0]
        return float(np.degrees(np.sqrt((off**2).sum(axis=1).mean() / 2)))

    @property
    def distance_mm(self) -> float:
        """Distance of the camera from the plane of bending."""
        return float(_place(self.mean, self.size_px)[2] - self.mean[FRONT])

    def scale(self, at_px: Floats) -> tuple[float, float]:
        """Millimetres per pixel in the plane at a point, and their relative standard deviation.

        Args:
            at_px: (2,) the point.
        """
        box = at_px + np.array([[-50.0, 0], [50, 0], [0, -50], [0, 50]])

        def value(unknowns: Floats) -> float:
            left, right, above, below = _to_plane(unknowns, self.size_px, box)
            return float(np.linalg.norm(right - left) + np.linalg.norm(below - above)) / 200

        here, others = value(self.mean), self.draws(DRAWS, np.random.default_rng(0))
        return here, float(np.std([value(draw) for draw in others])) / here

    def determined(self, unknown: int) -> bool:
        """Return whether what was seen tells an unknown far better than its prior.

        Args:
            unknown: its place in :data:`UNKNOWNS`.
        """
        return bool(self.covariance[unknown, unknown] < 0.25 * self.prior_std[unknown] ** 2)


def _matrix(unknowns: Floats, size_px: tuple[int, int]) -> Floats:
    """OpenCV's matrix of the lens."""
    focal, longer = np.exp(unknowns[F]), max(size_px)
    centre = (np.array(size_px) - 1) / 2 + longer * unknowns[1:3]
    return np.array([[focal, 0, centre[0]], [0, focal, centre[1]], [0, 0, 1]])


def _rotation(unknowns: Floats) -> Floats:
    import cv2

    return np.asarray(cv2.Rodrigues(np.asarray(unknowns[TURN]))[0])


def _place(unknowns: Floats, size_px: tuple[int, int]) -> Floats:
    """The sheet's origin from the camera (mm)."""
    from_centre_px = max(size_px) * (unknowns[AT] - unknowns[1:3])
    return np.asarray(np.exp(unknowns[SCALE]) * np.append(from_centre_px, np.exp(unknowns[F])))


def _lens(unknowns: Floats) -> Floats:
    return np.array([unknowns[3], unknowns[4], 0.0, 0.0])


def _to_plane(unknowns: Floats, size_px: tuple[int, int], points_px: Floats) -> Floats:
    import cv2

    flat = np.asarray(points_px, dtype=float).reshape(-1, 1, 2)
    seen = np.nan_to_num(flat)
    rays = cv2.undistortPoints(seen, _matrix(unknowns, size_px), _lens(unknowns)).reshape(-1, 2)
    rotation = _rotation(unknowns)
    directions = np.column_stack([rays, np.ones(len(rays))]) @ rotation
    centre = -rotation.T @ _place(unknowns, size_px)
    slopes = np.tan(unknowns[12:14])
    normal = np.array([-slopes[0], -slopes[1], 1.0])
    steps = (-unknowns[FRONT] - centre @ normal) / (directions @ normal)
    places = (centre + steps[:, None] * directions)[:, :2] * np.sqrt(1 + slopes**2)
    places[np.isnan(flat[:, 0]).any(axis=1)] = np.nan
    return np.asarray(places.reshape(np.shape(points_px)))


def _to_pixels(unknowns: Floats, size_px: tuple[int, int], solid_mm: Floats) -> Floats:
    """Points (n, 3), of which u and v are along the sheet, in the picture (n, 2)."""
    import cv2

    pixels, _ = cv2.projectPoints(
        solid_mm, np.asarray(unknowns[TURN]), _place(unknowns, size_px),
        _matrix(unknowns, size_px), _lens(unknowns),
    )  # fmt: skip
    return np.asarray(pixels.reshape(-1, 2))


def _prior(size_px: tuple[int, int], in_front: tuple[float, float]) -> tuple[Floats, Floats]:
    """Means and standard deviations before anything is seen; infinite: the pose."""
    mean, std = np.zeros(len(UNKNOWNS)), np.full(len(UNKNOWNS), np.inf)
    mean[F], std[F] = np.log(POLICY.focal * max(size_px)), POLICY.focal_log
    std[1:3], std[3], std[4] = POLICY.centre, POLICY.k1, POLICY.k2
    mean[FRONT], std[FRONT] = in_front
    std[12:14] = np.radians(POLICY.plane_deg)
    return mean, std


def of_sheet(
    size_px: tuple[int, int], sheet_mm: Floats, seen_px: Floats, in_front: tuple[float, float]
) -> Calibration:
    """Fit a camera to the corners of a sheet.

    Args:
        size_px: of a frame.
        sheet_mm: (n, 2) places of the corners on the sheet.
        seen_px: (n, 2) where they are in the picture.
        in_front: distance of the dots in front of the sheet, and its standard deviation (mm).

    Raises:
        ConfigError: one line, if too few corners are seen.
    """
    import cv2

    if len(sheet_mm) < POLICY.least_corners:
        raise ConfigError(
            f"the sheet is half visible: {len(sheet_mm)} of its corners are seen; allowed: at "
            f"least {POLICY.least_corners}, on two sides of the finger; or --scale"
        )
    mean, std = _prior(size_px, in_front)
    solid = np.column_stack([sheet_mm, np.zeros(len(sheet_mm))])
    _, turn, place = cv2.solvePnP(
        solid, seen_px, _matrix(mean, size_px), _lens(mean), flags=cv2.SOLVEPNP_IPPE
    )
    begin = mean.copy()
    begin[TURN] = turn.ravel()
    focal_px = np.exp(mean[F])
    begin[AT] = focal_px / max(size_px) * place[:2, 0] / place[2]
    begin[SCALE] = np.log(place[2].item() / focal_px)

    def corners(unknowns: Floats) -> Floats:
        return (_to_pixels(unknowns, size_px, solid) - seen_px).ravel()

    noise = POLICY.corner_px
    for _ in range(3):  # the noise of the corners is that of what is left
        fit = _fit(lambda unknowns, noise=noise: corners(unknowns) / noise, begin, mean, std)
        left = corners(fit.x)
        noise = max(POLICY.corner_px, float(1.4826 * np.median(np.abs(left))))
        begin = fit.x
    covariance = _covariance(fit)
    residual = float(np.sqrt(np.mean(left**2)))
    return Calibration(size_px, fit.x, covariance, std, "sheet", residual, has_sheet=True)


def of_lengths(
    size_px: tuple[int, int], lengths: Sequence[Length], in_front: tuple[float, float], by: str
) -> Calibration:
    """Fit a camera to lengths in the plane of the scale; its tilt stays as its prior is.

    Args:
        size_px: of a frame.
        lengths: at least one.
        in_front: distance of the dots in front of the lengths, and its standard deviation (mm).
        by: what they are, for people.
    """
    mean, std = _prior(size_px, in_front)
    tiny = 1e-6
    std[TURN] = np.radians(POLICY.tilt_deg), np.radians(POLICY.tilt_deg), tiny
    std[AT], std[SCALE] = tiny, np.inf
    per_px = np.median(
        [length.length_mm / np.linalg.norm(np.diff(length.ends_px, axis=0)) for length in lengths]
    )
    mean[SCALE] = np.log(per_px)

    def misfit(unknowns: Floats) -> Floats:
        flat = unknowns.copy()
        flat[FRONT:] = 0.0
        rows = []
        for length in lengths:
            ends = _to_plane(flat, size_px, length.ends_px)
            rows.append((np.linalg.norm(ends[1] - ends[0]) - length.length_mm) / length.std_mm)
        return np.array(rows)

    fit = _fit(misfit, mean.copy(), mean, std)
    ends = lengths[0].ends_px if len(lengths) == 1 else None
    return Calibration(size_px, fit.x, _covariance(fit), std, by, ends_px=ends)


def of_space(size_px: tuple[int, int]) -> Calibration:
    """A camera for places that a motion capture has measured, of which 1 px is 1 mm.

    Args:
        size_px: width and height of the part of the plane of bending that has points (mm).
    """
    mean, std = _prior(size_px, (0.0, 0.0))
    errors = np.full(len(mean), 1e-6)
    errors[SCALE] = POLICY.capture
    return Calibration(size_px, mean, np.diag(errors**2), std, "motion capture")


def _fit(misfit: Any, begin: Floats, mean: Floats, std: Floats) -> Any:
    """Least squares of misfits and of the distances from the priors."""
    has_prior = np.isfinite(std)

    def rows(unknowns: Floats) -> Floats:
        return np.concatenate([misfit(unknowns), ((unknowns - mean) / std)[has_prior]])

    scale = np.where(has_prior, np.minimum(std, 1.0), 0.1)
    return least_squares(rows, begin, x_scale=scale, jac="3-point")


def _covariance(fit: Any) -> Floats:
    return np.asarray(np.linalg.pinv(fit.jac.T @ fit.jac, rcond=1e-18, hermitian=True))
