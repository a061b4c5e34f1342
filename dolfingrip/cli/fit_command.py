"""``dolfingrip coupon --fit``: laws of rubber fitted to measured coupons."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rich.table import Table

from dolfingrip.charts import picture
from dolfingrip.cli import progress
from dolfingrip.cli.console import console
from dolfingrip.cli.rooms import offered
from dolfingrip.cli.settings import RunSettings
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit import choice, coupons, fit
from dolfingrip.experiments.material_fit.choice import choose, unstable
from dolfingrip.experiments.material_fit.coupons import MODES, CouponSeries, farthest
from dolfingrip.experiments.material_fit.first_loading import slack_strain
from dolfingrip.experiments.material_fit.fit import FREE, LOOKED_AT, MISFIT, LawFit
from dolfingrip.experiments.material_fit.law import LAWS, limit_points
from dolfingrip.report import material
from dolfingrip.report.table import of_rows

TITLE = 14
"""Width, in characters, to which a law's title is wrapped."""


def fit_coupons(args: RunSettings) -> None:
    """Fit laws as the options of ``coupon`` ask for."""
    given = args.own()
    fit_laws(given["fit"], given["law"], given["max_stretch"], args.out)


def fit_laws(
    files: Sequence[Path], names: Sequence[str], max_stretch: float | None, out: Path
) -> None:
    """Fit laws to the coupons in ``files``; print, draw and write the best as a configuration.

    Args:
        files: CSV files; each has a TOML of the same name.
        names: names of the laws; all laws if none is given.
        max_stretch: readings at larger stretches are left out.
        out: folder for ``material.toml`` and ``fit.png``.

    Raises:
        ConfigError: one line, if a file or a name is wrong.
    """

    unknown = [name for name in names if name not in LAWS]
    if unknown:
        raise ConfigError(f"--law {unknown[0]}: allowed: {', '.join(LAWS)}")
    if max_stretch is not None and max_stretch <= 1:
        raise ConfigError(f"--max-stretch {max_stretch:g}: allowed: above 1")
    screen = console()
    files = offered(files, "coupon --fit", screen, out)
    data = [series for file in files for series in coupons.read(file, max_stretch)]
    readings = sum(len(series.stretch) for series in data)
    chosen = [LAWS[name] for name in names or LAWS]
    laws = [law for law in chosen if len(law.keys) < readings]
    if not laws:
        raise ConfigError(f"--fit: {readings} readings; allowed: more than a law has parameters")
    by_name: dict[str, LawFit] = {}
    idle: list[str] = []
    with progress.shown(screen, "laws", total=len(laws)) as show:
        for i, law in enumerate(laws):
            fitted = fit.of_use(fit.fit(law, data), data)
            by_name[fitted.law.name] = fitted
            idle += [] if fitted.law is law else [law.title]
            show(i + 1, len(laws), law.title)
    fits = list(by_name.values())
    choice = choose(fits, data)
    best = choice.best
    screen.say(_told(data, readings))
    screen.print(_quality(fits, best, data))
    screen.print()
    screen.print(_values(fits, best))
    if idle:
        screen.say(f"- left out, as a term of them improves nothing: {'; '.join(idle)}")
    for line in (*choice.reasons, *_remarks(fits, best, data)):
        screen.say(f"- {line}")
    charts = material.charts(data, fits, best)
    if best.relative_rms > MISFIT:
        picture.write(charts, out / "fit.png", material.LOOK)
        raise ConfigError(
            f"--law {best.law.name}: it misses the readings by {100 * best.relative_rms:.2g} % "
            f"(rms), so no material.toml is written; picture: {out / 'fit.png'}; allowed: up to "
            f"{100 * MISFIT:g} %, by another law or fewer readings (--max-stretch)"
        )
    if not fit.allowed(best):
        raise ConfigError(
            f"--law {best.law.name}: its best values have no initial shear modulus above 0; "
            "allowed: another law, or fewer readings by --max-stretch"
        )
    fit.write(best, data, out / "material.toml")
    picture.write(charts, out / "fit.png", material.LOOK)
    screen.say(
        f"{best.law.title}: {out / 'material.toml'}, for --config; picture: {out / 'fit.png'}"
    )


def _told(data: Sequence[CouponSeries], readings: int) -> str:
    parts = []
    for mode in dict.fromkeys(series.mode for series in data):
        of_mode = [series for series in data if series.mode == mode]
        count = f"{len(of_mode)} specimen{'s' if len(of_mode) > 1 else ''}"
        parts.append(f"{mode}: {count}, {coupons.reach(of_mode)}")
    left_out = sum(series.left_out for series in data)
    others = "readings are left out: the way back, later loops, or what follows a slip or a break"
    parts += [f"{left_out} further {others}"] if left_out else []
    return f"{readings} readings; {'; '.join(parts)}"


def _quality(fits: Sequence[LawFit], best: LawFit, data: Sequence[CouponSeries]) -> Table:
    """A table: how well each law fits, to which stretches it is stable, when a balloon gives way.

    The laws' titles and the modes are wrapped, so that the table fits into 80 columns. Nothing is
    known beyond the largest stretch that it names.
    """
    highest = max(LOOKED_AT, 2 * farthest(data))
    stable = f"Stable to stretch ({', '.join(MODES)})"
    names = ("Law", "rms (MPa)", "rms (%)", "Correlation", "BIC", stable, "Balloon's maximum (–)")
    rows = []
    beyond = f"> {highest:.2g}"
    for law_fit in fits:
        turns = limit_points(partial(law_fit.law.energy, law_fit.values), highest)
        limits = [f"{at:.3g}" for at, greatest in turns if greatest]
        ends = unstable(law_fit, dict.fromkeys(MODES, highest))
        row = (
            "\n".join(textwrap.wrap(law_fit.law.title, TITLE)) + (" ←" if law_fit is best else ""),
            f"{law_fit.rms_MPa:.2g}",
            f"{100 * law_fit.relative_rms:.2g}",
            f"{law_fit.correlation:z.2f}",
            f"{law_fit.criterion:z.{1 if law_fit.criterion < 1000 else 0}f}",
            ", ".join(f"{ends[m]:.3g}" if m in ends else beyond for m in MODES) if ends else beyond,
            ", ".join(limits) or "none",
        )
        rows.append(row)
    return of_rows(names, rows, "Laws", left=("Law",))


def _values(fits: Sequence[LawFit], best: LawFit) -> Table:
    """A table with the values of each law's parameters and half of their intervals."""
    names = ("Law", "Parameter", "Value", "± half of the 90 % interval")
    rows = []
    for law_fit in fits:
        of_law = zip(law_fit.law.keys, law_fit.values, law_fit.half_width, strict=True)
        for i, (key, value, half) in enumerate(of_law):
            title = law_fit.law.title + (" ←" if law_fit is best else "")
            row = (
                title if i == 0 else "",
                key.rpartition(".")[2],
                *_interval(value, half),
            )
            rows.append(row)
    return of_rows(names, rows, "Values", left=("Law", "Parameter"))


def _interval(value: float, half: float) -> tuple[str, str]:
    """A value and half of its interval as texts."""
    if half > FREE * abs(value):
        return f"{value if abs(value) > 1e-9 else 0.0:z.2g}", "free"
    return f"{value:z.4g}", f"{half:.2g}"


def _remarks(fits: Sequence[LawFit], best: LawFit, data: Sequence[CouponSeries]) -> list[str]:
    remarks = [
        f"{fit.law.title}: {line}" for fit in fits for line in choice.doubts(fit, data)
        if fit is best or "fits equally" in line
    ]  # fmt: skip
    remarks += [
        f"{series.name}: its load stays next to nothing up to a strain of {slack:.2g}, as that of "
        "a coupon that is slack there; begin its table where it is taut, and import it with "
        "--zero-at-rest"
        for series in data
        if (slack := slack_strain(series.stretch, series.stress_MPa))
    ]
    remarks += choice.apart(fits, data)
    if best.correlation > 0.5:
        remarks.append(
            f"residuals of {best.law.title} follow one another (correlation "
            f"{best.correlation:.2f}): {best.count} readings count as {best.effective:.0f}"
        )
    if all(series.noise_MPa is None for series in data):
        remarks.append("no [noise] in the TOML: the intervals' noise is the residuals'")
    return remarks
