"""Bellows that pass through one another."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Setup


class NoSelfContact(Effect):
    """A model without contact between bellows.

    Π_contact = 0 (``contact.self_contact = false``).

    Prior: none; a choice of the model and no property of the finger.
    Fingerprint: nothing in free bending, where bellows part, nor up to the pressure at which they
    touch against the plate (140 kPa); beyond, a force that does not turn steeper, 7.4 % lower at
    250 kPa.
    Confused with: the gap between bellows as printed; effects of walls change the angle as well.
    """

    kind: ClassVar = "numerical"
    neutral: ClassVar = {"left_out": False}

    left_out: bool = Field(True, description="no contact between bellows")

    def adapt[S: Setup](self, config: S) -> S:
        return config.changed(contact={"self_contact": False}) if self.left_out else config
