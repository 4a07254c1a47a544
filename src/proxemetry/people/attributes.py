"""What a recording states about a person beyond their joints: attributes by key, as text.

Nothing here looks at a picture: an attribute is carried, shown and counted by, and never judged.
"""

from __future__ import annotations

import json
import math
import unicodedata
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast

from ..errors import KeypointsError, SettingsError
from ..files import is_whole

#: One person's attributes: lower-case key -> text.
Attributes = Mapping[str, str]

#: What one person may carry: a column's heading, a cell that can be read, and no file in disguise.
MOST_KEYS, LONGEST_KEY, LONGEST_VALUE = 50, 60, 1000

_ANSWERS = {"yes": "true", "no": "false"}


def attributes_of(stated: object) -> Attributes:
    """Return attributes as they are kept: keys in lower case, every value as text, what has no value left out.

    true and false are those words, whole numbers have no decimals, lists and objects are JSON; line breaks and other
    control characters are blanks. Raises KeypointsError for anything but a mapping of texts, for more or longer ones
    than tables hold, and for keys that differ in case alone.
    """
    if stated is None:
        return {}
    if not isinstance(stated, Mapping):
        raise KeypointsError(f"attributes are names with values, not {type(stated).__name__}")
    found = cast("Mapping[object, object]", stated)
    if len(found) > MOST_KEYS:
        raise KeypointsError(f"a person has {len(found)} attributes: {MOST_KEYS} at most")
    answer: dict[str, str] = {}
    for name, value in found.items():
        if not isinstance(name, str):
            raise KeypointsError(f"an attribute is called {name!r:.40}: its name must be a text")
        key = key_of(name)
        text = _text(value)
        if len(text) > LONGEST_VALUE:
            raise KeypointsError(f"attribute {key!r} has {len(text):,} characters: {LONGEST_VALUE:,} at most")
        if key in answer:
            raise KeypointsError(f"attribute {key!r} is there twice: capitals make no difference")
        if text:
            answer[key] = text
    return answer


def key_of(name: str) -> str:
    """Return an attribute's name as it is kept; raises KeypointsError where it could head no column."""
    key = unicodedata.normalize("NFC", _plain(name)).lower()
    if not key or len(key) > LONGEST_KEY:
        raise KeypointsError(f"an attribute's name has {len(key):,} characters: 1 to {LONGEST_KEY}")
    return key


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value) if abs(value) < 10**300 else "inf"
    if isinstance(value, float):
        if math.isnan(value):
            return ""
        return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
    if isinstance(value, str):
        return _plain(value)
    try:
        return _plain(json.dumps(value, ensure_ascii=False, sort_keys=True, separators=(",", ":")))
    except (TypeError, ValueError, RecursionError) as error:
        raise KeypointsError(f"an attribute's value is a {type(value).__name__}: write a text or a number") from error


def _plain(text: str) -> str:
    """Return a text in one line, without signs that no table can hold."""
    if not is_whole(text):
        raise KeypointsError("an attribute has half of a character (a lone surrogate)")
    shown = "".join(" " if unicodedata.category(sign) in ("Cc", "Cf") else sign for sign in text)
    return " ".join(shown.split())


@dataclass(frozen=True)
class PairsWhere:
    """Which pairs count: those of two people who have, for every key, one of the values.

    accepted: key -> values as `compared` has them. A person without the attribute does not have it. words: the same as
    it was asked for, to be read.
    """

    accepted: Mapping[str, frozenset[str]]
    words: str = ""

    @classmethod
    def parsed(cls, texts: Iterable[str]) -> PairsWhere | None:
        """Return what texts like mask=no ask for, None where there are none; of one key several values, any will do.

        Raises SettingsError where a text is no such condition.
        """
        accepted: dict[str, dict[str, str]] = {}
        for text in texts:
            name, equals, value = text.partition("=")
            try:
                key = key_of(name)
            except KeypointsError as error:
                raise SettingsError(f"--pairs-where {text!r:.60}: write ATTRIBUTE=VALUE, like mask=no") from error
            if not equals or not value.strip():
                raise SettingsError(f"--pairs-where {text!r:.60}: write ATTRIBUTE=VALUE, like mask=no")
            accepted.setdefault(key, {}).setdefault(compared(value), value.strip())
        words = ", ".join(f"{key}={' or '.join(values.values())}" for key, values in accepted.items())
        return cls({key: frozenset(values) for key, values in accepted.items()}, words) if accepted else None

    def __str__(self) -> str:
        return self.words or ", ".join(f"{key}={' or '.join(sorted(v))}" for key, v in self.accepted.items())

    def holds(self, attributes: Attributes) -> bool:
        """Return whether a person with these attributes counts."""
        return all(key in attributes and compared(attributes[key]) in values for key, values in self.accepted.items())

    def require_some(self, known: Mapping[str, Mapping[str, int]]) -> None:
        """Raise SettingsError where no person can have what is asked for; known: key -> value -> how many people."""
        for key, values in self.accepted.items():
            if key not in known:
                there = f"there are {', '.join(sorted(known)[:8])}" if known else "no person has attributes there"
                raise SettingsError(f"--pairs-where {self}: no person has an attribute {key!r}; {there}")
            if not any(compared(value) in values for value in known[key]):
                most = sorted(known[key].items(), key=lambda item: (-item[1], item[0]))[:6]
                there = ", ".join(f"{value:.40} ({number:,} people)" for value, number in most)
                raise SettingsError(f"--pairs-where {self}: no person has it; {key!r} is {there}")


def compared(value: str) -> str:
    """Return a value as it is compared: capitals, yes or true and how a number is written make no difference."""
    text = _plain(value).casefold()
    try:
        return _text(float(text)) or text
    except ValueError:
        return _ANSWERS.get(text, text)


def most_frequent(sightings: Sequence[Attributes]) -> Attributes:
    """Return of every attribute the value that most sightings of one person have, of several the first by its signs."""
    count: dict[str, Counter[str]] = {}
    for one in sightings:
        for key, value in one.items():
            count.setdefault(key, Counter())[value] += 1
    return {key: min(values, key=lambda value: (-values[value], value)) for key, values in count.items()}


def values_of(attributes: Iterable[Attributes]) -> dict[str, Counter[str]]:
    """Return the attributes of several people: key -> value -> how many have it."""
    found: dict[str, Counter[str]] = {}
    for one in attributes:
        for key, value in one.items():
            found.setdefault(key, Counter())[value] += 1
    return found


def keys_of(attributes: Sequence[Attributes]) -> tuple[str, ...]:
    """Return the keys that any of the people have, sorted."""
    return tuple(sorted({key for one in attributes for key in one}))


def checked(stated: Sequence[Any], count: int) -> tuple[Attributes, ...]:
    """Return the attributes of `count` people, empty where none are stated."""
    if len(stated) not in (0, count):
        raise KeypointsError(f"people.attributes has {len(stated)} entries for {count} people")
    return tuple(attributes_of(one) for one in stated or [None] * count)
