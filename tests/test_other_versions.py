"""Results of another version, whose columns are others, are read as far as they go, or refused for what they are."""

import csv
import json
from collections.abc import Callable, Iterable
from pathlib import Path

import duckdb
import pytest

from proxemetry.archive.figures.summary import summarise
from proxemetry.archive.store import damage, earlier, part_rows, parts
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.identity import MODELS, SETTINGS, SETTINGS_SHA256, VERSION
from proxemetry.archive.store.index import cards
from proxemetry.archive.store.results import Results
from proxemetry.benchmark.labels import BODY_FILE, PHOTOS_FILE, TRUTH_FILE
from proxemetry.cli import main
from proxemetry.clip.tables_again import write_again
from proxemetry.errors import OutputError
from proxemetry.scene import Scene
from synthetic.small_photos import HEIGHT, WIDTH

POSE = "python:synthetic.small_photos:two_people"

#: How the rows of a part were before: SQL over what is there now, as columns of photos come and go, and of people.
LESS = "* EXCLUDE (focal_basis, camera_make, own_focal, file_bytes)"
LESS_OF_PEOPLE = (
    "* REPLACE (list_transform(people, lambda p: struct_pack(person := p.person, x_m := p.x_m, z_m := p.z_m, "
    "nearest_m := p.nearest_m)) AS people)"
)
MORE = "*, 7 AS shoe_size, list_transform(people, lambda p: 'blue') AS hats"
OF_OTHER_TYPES = (
    "* REPLACE (n_people::VARCHAR AS n_people, 'yes please' AS focal_assumed, width_px::DOUBLE AS width_px)"
)
KINDS = {"less": LESS, "less of people": LESS_OF_PEOPLE, "more": MORE, "other types": OF_OTHER_TYPES}


def _rewrite(path: Path, selected: str, *, sealed: bool = True) -> None:
    """Write a Parquet file again with other columns, as a version that has these would have."""
    temporary = path.with_suffix(".new")
    with duckdb.connect() as duck:
        pairs = duck.execute("SELECT decode(key), decode(value) FROM parquet_kv_metadata(?)", [str(path)]).fetchall()
        metadata = {key: value for key, value in pairs if key not in (damage.DIGEST, "proxemetry_made_of")}
        if sealed:
            metadata[damage.DIGEST] = damage.BLANK
        texts = ", ".join(f"{key}: '{value}'" for key, value in metadata.items())
        duck.execute(
            f"COPY (SELECT {selected} FROM read_parquet('{path}')) TO '{temporary}' "
            f"(FORMAT parquet{f', KV_METADATA {{{texts}}}' if texts else ''})"
        )
    if sealed:
        damage.seal(temporary)
    temporary.replace(path)


def _parts(results: Path) -> list[Path]:
    return sorted((results / "scenes").glob("part-*.parquet"))


def _table(results: Path, name: str) -> list[dict[str, str]]:
    with (results / f"{name}.csv").open() as file:
        return list(csv.DictReader(file))


def _labels_of(results: Path, folder: Path) -> Path:
    """Write labels after which the two people of each photo stand 1 m from one another."""
    folder.mkdir()
    people = _table(results, "people")
    marks = [
        f"P{p['person']},Shoulder,{p['shoulder_u_px']},{p['shoulder_v_px']},{Path(p['photo']).name},{WIDTH},{HEIGHT}"
        for p in people
    ]
    (folder / BODY_FILE).write_text("\n".join(marks) + "\n")
    (folder / TRUTH_FILE).write_text("s,P0,0,0,3000\ns,P1,1000,0,3000\ns,C1,0,0,0\n")
    photos = sorted({Path(p["photo"]).name for p in people})
    (folder / PHOTOS_FILE).write_text("".join(f"s,C1,{photo}\n" for photo in photos))
    return folder


def _fails(command: Iterable[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(list(command)) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if line.startswith("proxemetry: ")]
    assert len(lines) == 1
    return lines[0]


@pytest.mark.parametrize("some", [slice(None), slice(1, 3)], ids=["all parts", "two of five"])
@pytest.mark.parametrize("kind", KINDS)
def test_parts_with_other_columns_are_read(kind: str, some: slice, original: Path, results: Path) -> None:
    for path in _parts(results)[some]:
        _rewrite(path, KINDS[kind])
    there = str(results)
    for command in (
        ["export", there], ["summary", there], ["summary", there, "--methods"], ["report", there],
        ["export", there, "--format", "coco,spss,xlsx"],
    ):  # fmt: skip
        assert main(command) == 0, command
    for name in ("photos", "people", "pairs"):
        now, before = _table(results, name), _table(original / "r", name)
        assert len(now) == len(before)
        assert list(now[0]) == list(before[0])
        for row, old in zip(now, before, strict=True):
            unlike = {column for column in row if row[column] != old[column]}
            assert all(not row[column] for column in unlike), (name, unlike)  # missing, never wrong
            if kind == "less" and some == slice(None):
                assert unlike <= {"focal_basis", "camera_make"}
            if kind == "more":
                assert not unlike
            if kind == "other types":
                assert unlike <= {"focal_assumed"}
    if kind == "less of people" and some == slice(None):
        assert [row["x_m"] for row in _table(results, "people")] == [
            row["x_m"] for row in _table(original / "r", "people")
        ]
        assert not any(row["shot_size"] for row in _table(results, "people"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_review_and_scenes_read_them(kind: str, original: Path, results: Path) -> None:
    for path in _parts(results)[:2]:
        _rewrite(path, KINDS[kind])
    then, now = Results.open(original / "r"), Results.open(results)
    assert [s.to_json() for s in now.scenes()] == [s.to_json() for s in then.scenes()]
    assert [(c.photo, c.n_people, c.n_pairs) for c in cards(now)] == [
        (c.photo, c.n_people, c.n_pairs) for c in cards(then)
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_command_goes_on_with_them(kind: str, original: Path, results: Path) -> None:
    for path in _parts(results)[:2]:
        _rewrite(path, KINDS[kind])
    _parts(results)[4].unlink()
    (original / "photos").touch()
    assert main(["measure", str(original / "photos"), "--out", str(results), "--pose", POSE, "--jobs", "0"]) == 0
    assert [row["photo"] for row in _table(results, "photos")] == [
        row["photo"] for row in _table(original / "r", "photos")
    ]


def test_rows_are_kept_with_what_they_have_where_a_shard_is_done_again(results: Path) -> None:
    path = _parts(results)[0]
    _rewrite(path, LESS)
    (known,) = parts.previous_rows(Folder(results), 0).values()
    assert known.file is None
    assert known.own_focal == part_rows.OwnFocal.of(known.scene)
    kept = json.loads(known.record(None).json)
    assert kept["focal_basis"] is None
    assert kept["photo"] == known.scene.photo


def test_a_part_of_before_digests_is_no_damage(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in _parts(results):
        _rewrite(path, LESS, sealed=False)
    assert main(["export", str(results)]) == 0
    assert main(["report", str(results)]) == 0
    content = bytearray(_parts(results)[1].read_bytes())
    content[len(content) // 3 : len(content) // 3 + 400] = bytes(400)
    _parts(results)[1].write_bytes(bytes(content))
    capsys.readouterr()
    assert main(["export", str(results)]) == 1
    assert [row["status"] for row in _table(results, "photos")] == ["ok", "failed", "ok", "ok", "ok"]


def test_a_flipped_bit_in_the_digests_key_is_damage(results: Path) -> None:
    path = _parts(results)[0]
    content = bytearray(path.read_bytes())
    content[content.rfind(damage.DIGEST.encode()) + 3] ^= 1
    path.write_bytes(bytes(content))
    assert damage.damaged_parts(Folder(results), ["scenes/part-000000.parquet"])


def test_it_is_said_once_and_names_the_columns(results: Path, caplog: pytest.LogCaptureFixture) -> None:
    for path in _parts(results):
        _rewrite(path, LESS)
    for _ in range(2):
        Results.open(results).view()
    said = [r.message for r in caplog.records if "another version" in r.message]
    assert len(said) == 1
    assert "focal_basis, camera_make" in said[0]
    assert "--restart" in said[0]


@pytest.mark.parametrize(
    "selected", ["* EXCLUDE (nearest_m)", "* REPLACE ('far'::VARCHAR AS nearest_m)"], ids=["missing", "retyped"]
)
def test_tables_of_another_version_are_not_called_damaged(selected: str, results: Path) -> None:
    _rewrite(results / "people.parquet", selected, sealed=False)
    with pytest.raises(OutputError, match=r"people.parquet: written by another version .*column nearest_m") as refused:
        summarise(Results.open(results))
    assert "proxemetry export" in str(refused.value)
    assert "damaged" not in str(refused.value)


@pytest.mark.parametrize("command", [["summary"], ["summary", "--methods"], ["report"]])
def test_tables_without_a_new_column_are_written_anew_where_they_are_read(
    command: list[str], results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _rewrite(results / "people.parquet", "* EXCLUDE (nearest_m, doubt)", sealed=False)
    (results / "people.csv").write_text("old")
    assert main([command[0], str(results), *command[1:]]) == 0
    assert capsys.readouterr().err == ""
    assert _table(results, "people")[0]["doubt"] == "none"


def test_tables_are_read_elsewhere_where_the_results_cannot_be_written(
    results: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["summary", str(results), "--csv", "-"]) == 0
    before = capsys.readouterr().out
    _rewrite(results / "people.parquet", "* EXCLUDE (nearest_m)", sealed=False)
    content, writing = (results / "people.parquet").read_bytes(), Folder.writing

    def refused(self: Folder, name: str) -> object:
        if self.location == str(results):
            raise OutputError(f"{name}: cannot be written (Read-only file system)")
        return writing(self, name)

    monkeypatch.setattr(Folder, "writing", refused)
    assert main(["summary", str(results), "--csv", "-"]) == 0
    assert capsys.readouterr().out == before
    assert (results / "people.parquet").read_bytes() == content


def test_a_score_reads_the_tables_as_they_are_now(
    original: Path, results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    labels = _labels_of(results, tmp_path / "labels")
    command = ["score", str(results), "--labels", str(labels), "--csv", str(tmp_path / "score.csv")]
    assert main(command) == 0
    before = (tmp_path / "score.csv").read_bytes()
    _rewrite(results / "people.parquet", "*", sealed=False)  # of an unknown state
    (results / "people.csv").write_text("photo,person\n")
    assert main(command) == 0
    assert (tmp_path / "score.csv").read_bytes() == before
    assert not capsys.readouterr().err


def test_tables_are_written_again_where_the_columns_are_others(results: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert Results.open(results).tables_are_current()
    monkeypatch.setattr("proxemetry.archive.store.results.structure", lambda: "[{}]")
    assert not Results.open(results).tables_are_current()


@pytest.mark.parametrize(
    "change",
    [
        lambda f: f.pop("settings"),
        lambda f: f.update(about={"shoe_size": 7}),
        lambda f: f["camera"]["flags"].append({"doubt": "of another version", "text": ""}),
    ],
    ids=["less", "more", "other"],
)
def test_a_scene_of_another_version_is_called_that(
    change: Callable[[dict[str, object]], object], original: Path
) -> None:
    fields = json.loads(next(Results.open(original / "r").scenes()).to_json())
    change(fields)
    with pytest.raises(Exception, match=r"another version of proxemetry, or is damaged .*--restart"):
        Scene.from_json(json.dumps(fields))


def test_a_scene_without_what_was_added_has_the_default(original: Path) -> None:
    scene = next(Results.open(original / "r").scenes())
    fields = json.loads(scene.to_json())
    for name in ("why", "testimony", "lens", "mount"):
        fields["camera"].pop(name, None)
    fields["people"].pop("source", None)
    assert Scene.from_json(json.dumps(fields)).positions_m.tolist() == scene.positions_m.tolist()


def test_settings_that_a_version_did_not_have_are_named(
    original: Path, results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run_file = results / "run.json"
    fields = json.loads(run_file.read_text())
    settings = json.loads(fields["metadata"][SETTINGS])
    del settings["drone"]
    fields["metadata"][SETTINGS] = json.dumps(settings)
    run_file.write_text(json.dumps(fields))
    command = ["measure", str(original / "photos"), "--out", str(results), "--pose", POSE, "--jobs", "0"]
    said = _fails(command, capsys)
    assert "by a version of proxemetry without --no-drone" in said
    assert "--restart" in said


def test_a_clips_tables_of_another_version_are_exported(tmp_path: Path) -> None:
    folder = tmp_path / "clip"
    folder.mkdir()
    (folder / "run.json").write_text('{"schema": "proxemetry.clip/1"}')
    with duckdb.connect() as duck:
        duck.execute(
            f"COPY (SELECT 0.5 AS t_s, 3::BIGINT AS n_people, 'x' AS shoe_size) TO '{folder / 'frames.parquet'}'"
        )
    written = write_again(Folder(folder), Folder(tmp_path / "out"), ["xlsx", "spss"])
    assert any(name.endswith(".xlsx") for name in written)
    assert "frames.sav" in written


def test_keys_of_parts_are_those_that_tell_a_part_of_before_digests(results: Path) -> None:
    (metadata,) = parts.metadata_of(Folder(results), [0])
    assert set(metadata) == {VERSION, SETTINGS, SETTINGS_SHA256, MODELS}


def test_parts_are_described_once_each_schema(results: Path) -> None:
    folder = Folder(results)
    names = parts.names_of(folder)
    assert earlier.rows_of(folder, names, part_rows.structure()[1:-1]).startswith("read_parquet([")
    _rewrite(_parts(results)[0], LESS)
    assert "from_json" in earlier.rows_of(folder, names, part_rows.structure()[1:-1])
    assert "from_json" not in earlier.rows_of(folder, names, part_rows.structure()[1:-1], only=("photo",))
