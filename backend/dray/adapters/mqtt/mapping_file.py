"""The file that maps topics to the signals of a machine or a dock (docs/machines.md)."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

from dray.adapters.signals.signal import SignalMapping, is_told


class MqttMapping(SignalMapping, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """A machine, or a dock, on topics of a broker. The settings give its address (DRAY_BROKER).

    Raises:
        ValueError: a signal's mapping is impossible.
    """

    silent_after_s: Annotated[float, Meta(gt=0)] | None = None
    """Seconds of silence after which the controller counts as away. None where it publishes only changes, so absence is undetectable."""

    def __post_init__(self) -> None:
        super().__post_init__()
        told, written = set[str](), set[str]()
        for name, tag in self.tags.items():
            if tag.node or not tag.topic:
                raise ValueError(f"{name}: by MQTT it needs a `topic`, and has no `node`")
            if any(wild in tag.topic for wild in "#+") or tag.topic.startswith(("$", "/")):
                raise ValueError(f"{name}: {tag.topic!r} is not one topic")
            (told if is_told(name) else written).add(tag.topic)
        if both := sorted(told & written):
            raise ValueError(f"{both[0]}: what is written there would be heard as its controller's word")

    def check_gate(self) -> None:
        """See `SignalMapping.check_gate`."""
        super().check_gate()
        if self.silent_after_s is None:
            raise ValueError(
                "silent_after_s is missing: a gate must know when its reader of labels is silent"
            )
