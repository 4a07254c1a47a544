"""What a run's numbers depend on: photos measured with anything else do not go into one results folder."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import OutputError

#: Keys of the parts' metadata.
VERSION, SETTINGS, SETTINGS_SHA256, MODELS = (
    "proxemetry_version", "proxemetry_settings", "proxemetry_settings_sha256", "proxemetry_models",
)  # fmt: skip

#: Stands between a file's name and its hash in a setting.
_HASHED = " sha256:"
# How the command line spells what the settings call otherwise.
_FLAGS = {
    "assume_fov_deg": "--assume-fov",
    "undistort": "--no-undistort",
    "lines": "--no-lines",
    "assume": "--no-assume",
    "drone": "--no-drone",
    "other_photos": "--no-other-photos",
    "sensor_mm": "--sensor-mm",
}


@dataclass(frozen=True)
class Identity:
    """Package version, pose back end, its files' sha256, and every setting that changes a number."""

    version: str
    pose: str
    models: Mapping[str, str]
    settings: Mapping[str, Any]

    def metadata(self) -> dict[str, str]:
        """Return the identity as the metadata of a part."""
        settings = _canonical({"pose": self.pose, **self.settings})
        return {
            VERSION: self.version,
            SETTINGS: settings,
            SETTINGS_SHA256: hashlib.sha256(settings.encode()).hexdigest(),
            MODELS: _canonical(self.models),
        }


def _canonical(value: Mapping[str, Any]) -> str:
    return json.dumps(dict(value), sort_keys=True, separators=(",", ":"), allow_nan=False)


def require_same(now: Identity, before: Mapping[str, str], where: str) -> None:
    """Raise OutputError, naming every difference, where parts in `where` were made with anything else."""
    try:
        differences = list(_differences(now.metadata(), before))
    except (KeyError, ValueError, AttributeError, TypeError) as error:
        raise OutputError(
            f"{where}: it is unknown how the results there were made; name another --out, or use --restart"
        ) from error
    if differences:
        raise OutputError(
            f"{where}: the results there were made with other settings ({'; '.join(differences)}); "
            "use the same settings, name another --out, or start again with --restart"
        )


def _differences(now: Mapping[str, str], before: Mapping[str, str]) -> list[str]:
    if before.get(VERSION) != now[VERSION]:
        return [f"proxemetry was {before.get(VERSION)}, is {now[VERSION]}"]
    old: dict[str, Any] = {**_flat(json.loads(before[SETTINGS])), **_flat({"model": json.loads(before[MODELS])})}
    new: dict[str, Any] = {**_flat(json.loads(now[SETTINGS])), **_flat({"model": json.loads(now[MODELS])})}
    unlike = [key for key in sorted({*old, *new}) if old.get(key) != new.get(key)]
    # A setting without a value is one of a version that did not have it: those that are empty are written too.
    later = [_spelled(key) for key in unlike if key not in old and not key.startswith("model.")]
    by_earlier = [f"by a version of proxemetry without {', '.join(later)}"] if later else []
    return by_earlier + [_told(key, old.get(key), new.get(key)) for key in unlike if _spelled(key) not in later]


def _told(key: str, old: Any, new: Any) -> str:
    """Return a difference in words; a file that was edited since has the same name."""
    files = [value.partition(_HASHED) if isinstance(value, str) else ("", "", "") for value in (old, new)]
    if files[0][1] and files[0][0] == files[1][0]:
        return f"{_spelled(key)} {files[0][0]} has another content now"
    if _spelled(key).startswith("--no-") and isinstance(old, bool) and isinstance(new, bool):
        old, new = not old, not new  # the flag says the opposite of the setting
    return f"{_spelled(key)} was {_shown(old)}, is {_shown(new)}"


def _flat(value: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, item in value.items():
        path = f"{prefix}.{key}" if prefix else key
        if isinstance(item, dict):
            flat.update(_flat(item, path))  # pyright: ignore[reportUnknownArgumentType]
        else:
            flat[path] = item
    return flat


def _spelled(key: str) -> str:
    if key.startswith("model."):
        return f"the network {key.removeprefix('model.')}"
    last = key.rpartition(".")[2]
    return _FLAGS.get(last, "--" + last.replace("_", "-"))


def _shown(value: Any) -> str:
    if value is None:
        return "not given"
    text = value.partition(_HASHED)[0] if isinstance(value, str) else json.dumps(value)
    return text if len(text) <= 40 else text[:12] + "..."
