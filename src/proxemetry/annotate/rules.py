"""The benchmark's annotation rules in plain words (Seker et al. 2021, sections 3.1 and 3.2)."""

from __future__ import annotations

#: Part -> what point it is, and when it is left out.
PART_RULES: dict[str, tuple[str, ...]] = {
    "Eyes": (
        "The middle between the two eyes.",
        "The head is turned and only one eye can be seen: that eye.",
        "No eye can be seen (the back of the head): leave it out.",
        "An eye lies outside the picture: leave it out, even if the other can be seen.",
    ),
    "Shoulder": (
        "The middle between the two shoulder joints.",
        "The person stands sideways and only one shoulder can be seen: that shoulder.",
        "Hidden behind a person or a thing: click where it would be.",
        "Partly or wholly outside the picture: leave it out.",
    ),
    "Torso": (
        "Halfway between the neck (the middle of the shoulders) and the middle of the hips.",
        "Hidden behind a table or a person: click where it would be.",
        "Partly or wholly outside the picture: leave it out.",
    ),
    "Head": (
        "The middle of the head, whichever way it faces.",
        "Hidden behind a person or a thing: click where it would be.",
        "Partly or wholly outside the picture: leave it out.",
    ),
}

PEOPLE_RULES = (
    "Annotate everyone whose place was measured, with at least one of the four points.",
    "One tag is one person: within a shoot P2 is the same person, at the same place, in every photo.",
    "Others who happen to be in the picture: blur them before you publish the photos, or leave the photo out. Whoever "
    "is found but not annotated counts as found falsely.",
)

PLACE_RULES = (
    "During a shoot everyone stays in the same place; the camera may move to other places and change its lens. When "
    "people move, begin a new shoot.",
    "Measure on one level floor, from mark to mark: a person's mark is the middle between the feet (seated: below the "
    "hips), a camera's the point below the lens.",
    "Tiles of equal size are a ready grid: type coordinates. Otherwise tape each mark to at least three others.",
    "With the consent of everyone in the pictures.",
)

CAMERA_RULES = (
    "State the lens only where the file does not, or is wrong.",
    "The sensor's size is in the camera's data sheet; a phone's 35 mm equivalent does as well.",
)
