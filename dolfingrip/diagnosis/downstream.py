"""Changes by an extended model downstream: the best design of a campaign, and its gain φ.

The campaign's leading designs within the limit of the COG offset, and the original finger, are
computed once more with the effects and the modulus that the measurement calls for. φ is the force
over that of the original finger, less 1, of one model each.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from dolfingrip.channels import FORCE
from dolfingrip.config import Config, ConfigError, changed, felt, from_dict
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.diagnosis import DesignChange, Downstream
from dolfingrip.jobs.job import Data, Job, content_key
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import run
from dolfingrip.jobs.store import Store, same
from dolfingrip.parameter import scaled

COG: Final = "cog_offset_mm"


def compare(
    folder: Path, config: Config, extended: Config, out: Path, pool: Pool, policy: Policy = Policy()
) -> Downstream:
    """Compute a campaign's leading designs with the extended model.

    Args:
        folder: of the campaign.
        config: that was diagnosed.
        extended: the same with the cause at its fitted numbers.
        out: folder of the designs that are computed.
        pool: workers.
        policy: which designs are leading.

    Raises:
        ConfigError: one line, where there is no such campaign, or nothing to compare.
    """
    facts, rows = read_campaign(folder)
    parameters: list[str] = facts["parameters"]
    base = from_dict(facts["base"])
    if all(name.startswith("morph.") for name in parameters):  # else base itself is the original
        base = changed(base, dict.fromkeys(parameters, 0.0))
    within = [row for row in rows if _outputs(row)[COG] <= policy.largest_cog_mm]
    if not within:
        raise ConfigError(
            f"{folder}: no design with a COG offset up to {policy.largest_cog_mm:g} mm"
        )
    leading = sorted(within, key=lambda row: -_outputs(row)[FORCE.name])[: policy.leading]
    designs = [from_dict(row["arguments"]["config"]) for row in leading]
    others = [_extended(design, config, extended) for design in (base, *designs)]
    after = _forces([_job(leading[0], other) for other in others], out / "extended", pool)
    before = _forces([_job(leading[0], base)], out / "configured", pool)
    first, original = before[0], after[0]
    if first is None or original is None:
        raise ConfigError(f"{folder}: the original finger could not be computed")
    changes = tuple(
        DesignChange(
            inputs=row["inputs"], cog_offset_mm=_outputs(row)[COG],
            force_before_N=_outputs(row)[FORCE.name], force_after_N=force,
            phi_before=_outputs(row)[FORCE.name] / first - 1,
            phi_after=None if force is None else force / original - 1,
        )
        for row, force in zip(leading, after[1:], strict=True)
    )  # fmt: skip
    return Downstream(original_before_N=first, original_after_N=original, designs=changes)


def read_campaign(folder: Path) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Read what a campaign's designs share, and those that are done.

    Raises:
        ConfigError: one line, where it is none, or has no forces.
    """
    with Store(folder) as store:
        facts = store.facts()
        rows = [row for row in store.rows() if row["status"] == "done"]
    if facts is None or not {COG, FORCE.name} <= set(facts.get("quantities", ())):
        raise ConfigError(f"--campaign {folder}: allowed: one with {COG} and {FORCE.name}")
    return facts, rows


def _extended(base: Config, config: Config, extended: Config) -> Config:
    """The campaign's configuration with the cause; its modulus by the fitted factor."""
    factor = extended.material.shear_MPa / config.material.shear_MPa
    own_effects = extended.extensions.model_dump(mode="json", exclude_none=True)
    before = config.extensions.model_dump(mode="json", exclude_none=True)
    effects = {name: table for name, table in own_effects.items() if before.get(name) != table}
    return changed(base, scaled(base, factor)).changed(extensions=effects)


def _outputs(row: Data) -> dict[str, float]:
    """Quantities of a design that is done."""
    quantities: dict[str, float] = row["result"]["outputs"]
    return quantities


def _job(row: Data, config: Config) -> Job:
    """A campaign's job, of another configuration."""
    plain = config.model_dump(mode="json")
    other = {"config": plain, "quantities": [COG, FORCE.name], "gradients": None}
    arguments = {**row["arguments"], **other}
    content = {"function": row["function"], **arguments, "config": felt(config)}
    return Job(content_key(content), row["function"], arguments)


def _forces(jobs: Sequence[Job], out: Path, pool: Pool) -> list[float | None]:
    """Force of each job, in order."""
    run(list({job.key: job for job in jobs}.values()), out, pool, same(function=jobs[0].function))
    with Store(out) as store:
        rows = {row["key"]: row for row in store.rows()}
    of_jobs = [rows[job.key] for job in jobs]
    return [_outputs(row)[FORCE.name] if row["status"] == "done" else None for row in of_jobs]
