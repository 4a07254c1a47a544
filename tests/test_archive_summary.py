"""An archive's figures: against counts made by hand, and what their intervals promise."""

import csv
import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import stdtrit

from proxemetry.archive.figures.sampling import Sample, _student
from proxemetry.archive.figures.summary import Summary, _grouped, _groups, summarise
from proxemetry.archive.figures.totals import totals
from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.results import Results
from proxemetry.camera import FocalBasis
from proxemetry.cli import main
from proxemetry.distances import ZONES, zone_of
from proxemetry.errors import OutputError, SettingsError
from synthetic.small_photos import write_photos


def results_of(folder, photos, pairs):
    """Write the two tables that a summary reads. photos: (photo, date, country, people); pairs: (photo, metres)."""
    duckdb = pytest.importorskip("duckdb")
    folder.mkdir()
    (folder / "run.json").write_text("{}")
    duck = duckdb.connect()
    duck.execute(
        "CREATE TABLE photos (photo VARCHAR, sha256 VARCHAR, date VARCHAR, country VARCHAR, n_people INTEGER, "
        "status VARCHAR, n_pairs INTEGER, focal_basis VARCHAR)"
    )
    with_pairs = Counter(p for p, d in pairs if d is not None)
    bases = list(FocalBasis)
    listed = [(*(*p, "ok")[:6], with_pairs[p[0]], bases[k % len(bases)]) for k, p in enumerate(photos)]
    duck.executemany("INSERT INTO photos VALUES (?, ?, ?, ?, ?, ?, ?, ?)", listed)
    zones = ", ".join(f"p_{z} DOUBLE" for z in ZONES)
    duck.execute(f"CREATE TABLE pairs (photo VARCHAR, distance_m DOUBLE, {zones})")
    rows = [(p, d, *(float(zone_of(math.nan if d is None else d) == z) for z in ZONES)) for p, d in pairs]
    duck.executemany("INSERT INTO pairs VALUES (?, ?, ?, ?, ?, ?)", rows)
    duck.execute("CREATE TABLE people (photo VARCHAR, nearest_m DOUBLE)")
    near = [(p, min(d for q, d in pairs if q == p and d is not None)) for p in sorted(with_pairs) for _ in range(2)]
    duck.executemany("INSERT INTO people VALUES (?, ?)", near)  # two in each photo, both nearest in its nearest pair
    for table in ("photos", "people", "pairs"):
        duck.execute(f"COPY {table} TO '{folder / table}.parquet' (FORMAT parquet)")
    return Results.open(folder)


@pytest.fixture
def small(tmp_path):
    photos = [
        ("a/1.jpg", "s1", "1990-05-01", "Finland", 3),
        ("a/2.jpg", "s2", "1990", "Finland", 2),
        ("b/3.jpg", "s3", "2001-01-01T10:00:00", None, 2),
        ("4.jpg", "s2", None, "Italy", 1),
    ]
    pairs = [("a/1.jpg", 0.3), ("a/1.jpg", 1.0), ("a/1.jpg", 2.0), ("a/2.jpg", 1.1), ("b/3.jpg", 5.0), ("4.jpg", None)]
    return results_of(tmp_path / "results", photos, pairs)


def test_figures_are_those_counted_by_hand(small):
    (all_of_them,) = summarise(small).groups
    assert (all_of_them.n_photos, all_of_them.n_people, all_of_them.n_pairs) == (4, 8, 5)
    assert all_of_them.pairs_m.value == 1.1
    assert all_of_them.nearest_m.value == 1.1  # of 0.3, 1.1 and 5.0, each twice
    assert [z.value for z in all_of_them.zones] == pytest.approx([0.2, 0.4, 0.2, 0.2])


def test_the_tallys_zones_are_the_mean_probabilities_of_all_measured_pairs(original):
    shares = totals(Folder(str(original / "r"))).zone_shares
    with (original / "r" / "pairs.csv").open(newline="") as file:
        pairs = [row for row in csv.DictReader(file) if row["distance_m"]]
    assert len(pairs) == 5
    assert shares == pytest.approx({zone: np.mean([float(row[f"p_{zone}"]) for row in pairs]) for zone in ZONES})
    assert sum(shares.values()) == pytest.approx(1)


def test_focal_lengths_are_counted_by_what_they_rest_on(small, capsys):
    (all_of_them,) = summarise(small).groups
    assert all_of_them.bases == dict.fromkeys(FocalBasis, 1)
    by_year = {g.key[0]: [b for b, n in g.bases.items() if n] for g in summarise(small, ["year"]).groups}
    assert by_year == {"1990": ["stated", "recorded"], "2001": ["estimated"], None: ["assumed"]}
    assert main(["summary", small.folder.location]) == 0
    assert "1 stated, 1 recorded in the file, 1 estimated, 1 ASSUMED" in capsys.readouterr().out
    (row,) = summarise(small).rows()
    assert row["n_focal_estimated"] == 1


def test_pairs_count_for_zones_by_their_probabilities():
    sure = np.array([[0.0, 1.0, 0.0, 0.0]] * 3)
    open_ = np.array([[0.0, 0.5, 0.5, 0.0], [0.2, 0.3, 0.5, 0.0], [0.0, 0.1, 0.2, 0.7]])
    assert [z.value for z in group_of([1.0, 1.0, 1.0], [0, 1, 2], sure).zones] == pytest.approx([0, 1, 0, 0])
    assert [z.value for z in group_of([1.0, 1.0, 1.0], [0, 1, 2], open_).zones] == pytest.approx(
        [0.2 / 3, 0.3, 0.4, 0.7 / 3]
    )


def test_groups_by_year_country_folder_and_column(small):
    years = {g.key: (g.n_photos, g.n_pairs) for g in summarise(small, ["year"]).groups}
    assert years == {("1990",): (2, 4), ("2001",): (1, 1), (None,): (1, 0)}
    folders = {g.key[0]: g.n_pairs for g in summarise(small, ["folder"]).groups}
    assert folders == {".": 0, "a": 4, "b": 1}
    both = {g.key: g.n_people for g in summarise(small, ["country", "year"]).groups}
    assert both == {("Finland", "1990"): 5, ("Italy", None): 1, (None, "2001"): 2}
    assert {g.key[0] for g in summarise(small, ["n_people"]).groups} == {"1", "2", "3"}


def test_photos_that_a_reviewer_excluded_do_not_count(tmp_path):
    photos = [("1.jpg", "s1", None, None, 2, "excluded"), ("2.jpg", "s2", None, None, 2)]
    (group,) = summarise(results_of(tmp_path / "results", photos, [("2.jpg", 1.0)])).groups
    assert group.n_photos == 1


def test_pairs_find_their_photos_by_place_as_by_name(tmp_path, monkeypatch):
    photos = write_photos(tmp_path / "photos", 7)
    (photos / "02 text.jpg").write_text("not a photo")
    job = Job(str(tmp_path / "out"), "python:synthetic.small_photos:two_people")
    run([str(photos)], job, jobs=0)
    results = Results.open(tmp_path / "out")
    log = Log(tmp_path / "out" / FILE)
    third = list(results.scenes())[3]
    log.append(third, "exclude", {"excluded": True, "reason": "a painting"}, "ann")
    log.close()
    assert not results.tables_are_current()
    run([str(photos)], job, jobs=0)
    assert results.tables_are_current()
    assert results.tables_belong_together()
    by_place = summarise(results, ["folder"])
    monkeypatch.setattr(Results, "tables_belong_together", lambda *_: False)
    by_name = summarise(results, ["folder"])
    assert repr(by_place.groups) == repr(by_name.groups)  # NaN is not itself
    assert by_place.nearest_m.tolist() == by_name.nearest_m.tolist()
    assert sum(g.n_pairs for g in by_place.groups) == 6
    assert sum(g.n_photos for g in by_place.groups) == 7


def test_rows_of_photos_that_do_not_count_are_left_out_of_every_group():
    found = {"row": np.array([0, 0, 1, 2, 3, 4]), "metres": np.arange(6.0)}
    some = _grouped(found, np.array([1, -1, 0]), 2)  # two more photos follow that do not count either
    assert some["group"].tolist() == [0, 1, 1] and some["metres"].tolist() == [3.0, 0.0, 1.0]
    assert some["row"].tolist() == [2, 0, 0]


def test_copies_count_once_where_asked_for(small):
    assert summarise(small, distinct=True).groups[0].n_photos == 3


def test_unknown_groupings_and_unfinished_folders_are_refused(small, tmp_path):
    with pytest.raises(SettingsError, match="shoe size"):
        summarise(small, ["shoe size"])
    (tmp_path / "results" / "photos.parquet").unlink()
    with pytest.raises(OutputError, match="no tables"):
        summarise(small)


def group_of(distances, photo, zones=None):
    """Return the figures of one group: metres of pairs, the photo of each, and its zones' probabilities."""
    metres = np.asarray(distances, dtype=float)
    rows = {"row": np.asarray(photo), "group": np.zeros(len(metres), dtype=int)}
    if zones is None:
        zones = np.array([[float(zone_of(d) == z) for z in ZONES] for d in metres])
    pairs = {**rows, "distance_m": metres, **{f"p_{z}": zones[:, k] for k, z in enumerate(ZONES)}}
    (group,) = _groups([(0, 0, 0, 0, 10, 20)], pairs, {**rows, "nearest_m": metres})
    return group


def test_the_width_for_few_photos_is_students():
    freedom = np.arange(1, 200)
    assert _student(freedom) == pytest.approx(stdtrit(freedom, 0.95), rel=1e-3)


@pytest.mark.parametrize("n_photos", [3, 6, 60])
def test_intervals_hold_what_they_promise(n_photos):
    # so many photos drawn anew 400 times; the pairs of one photo are alike, so counting pairs would promise too much.
    random = np.random.default_rng(5)
    truth = 0.5  # of the pairs are nearer than 1.219 m: exp(N(0, .)) * 1.219 has its median there
    in_share = in_median = 0
    for _ in range(400):
        pairs_each = random.integers(1, 7, n_photos)
        photo = np.repeat(np.arange(n_photos), pairs_each)
        distances = 1.219 * np.exp(random.normal(0, 0.4, n_photos)[photo] + random.normal(0, 0.2, len(photo)))
        group = group_of(distances, photo)
        low = group.zones[2].low + group.zones[3].low
        near_low, near_high = 1 - (group.zones[2].high + group.zones[3].value), 1 - low
        in_share += near_low <= truth <= near_high
        in_median += group.pairs_m.low <= 1.219 <= group.pairs_m.high
    assert 0.85 <= in_share / 400 <= 0.97
    assert 0.85 <= in_median / 400 <= 0.95


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 4), st.floats(0.1, 20)), max_size=40))
def test_many_groups_at_once_are_each_group_alone(pairs):
    # group, photo in it, metres: the closed forms for a single group, spelled with numpy's own quantiles
    pairs = sorted(pairs)
    group, photo = (np.array([p[k] for p in pairs], dtype=int) for k in (0, 1))
    metres = np.array([p[2] for p in pairs])
    sample = Sample(group, photo, 4)
    shares, medians = sample.shares(metres < 1.5), sample.medians(metres)
    for g in range(4):
        mine, where = metres[group == g], photo[group == g]
        n = len(set(where))
        assert (sample.size[g], sample.n_photos[g]) == (len(mine), n)
        if not len(mine):
            assert all(math.isnan(v[g]) for v in (shares.value, shares.low, medians.value, medians.high))
            continue
        assert medians.value[g] == pytest.approx(np.quantile(mine, 0.5))
        assert shares.value[g] == pytest.approx(np.mean(mine < 1.5))
        if n < 2:
            assert math.isnan(shares.low[g]) and math.isnan(medians.low[g])
            continue
        below = mine <= medians.value[g]
        sums = [np.sum(below[where == p] - below.mean()) for p in set(where)]
        sd = math.sqrt(n / (n - 1) * np.sum(np.square(sums))) / len(mine) or 0.5 / math.sqrt(n)
        wide = stdtrit(n - 1, 0.95) * sd
        ends = np.quantile(mine, np.clip([0.5 - wide, 0.5 + wide], 0, 1))
        assert [medians.low[g], medians.high[g]] == pytest.approx(ends, rel=1e-2)
        assert 0 <= shares.low[g] <= shares.value[g] + 1e-9 <= shares.high[g] + 2e-9 <= 1 + 2e-9


def test_one_photo_tells_no_interval_and_nobody_is_not_certainty():
    alone = group_of([1.0, 2.0, 3.0], [0, 0, 0])
    assert math.isnan(alone.zones[2].low)
    assert math.isnan(alone.pairs_m.low)
    none_near = group_of(np.full(10, 2.0), range(10))
    assert none_near.zones[0].value == 0
    assert 0.1 < none_near.zones[0].high < 0.4  # ten photos without one: Wilson's 21 %
    assert none_near.zones[2].high == pytest.approx(1)


def test_the_command_prints_writes_and_draws(small, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    folder = small.folder.location
    figures = tmp_path / "figures"
    code = main(["summary", folder, "--by", "year", "--csv", str(tmp_path / "f.csv"), "--figures", str(figures)])
    assert code == 0
    said = capsys.readouterr().out.splitlines()
    assert said[0].split() == ["nearest", "other", "person"]
    assert said[1].split()[:4] == ["year", "photos", "people", "median"]
    assert max(map(len, said)) <= 100
    assert said[2].startswith("1990")
    with (tmp_path / "f.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [r["year"] for r in rows] == ["1990", "2001", ""]
    assert float(rows[0]["pairs_median_m"]) == 1.05
    assert float(rows[0]["nearest_median_m"]) == 0.7
    assert rows[2]["pairs_median_m"] == ""
    drawn = {Path(p).name for p in figures.iterdir()}
    assert drawn == {f"distances_{n}.{e}" for n in ("by_group", "over_time") for e in ("png", "pdf")}


@pytest.mark.parametrize("path, where", [("/f.csv", "/"), ("f.csv", None), ("sub/f.csv", "sub")])
def test_a_csv_file_is_written_where_it_is_named(small, path, where, tmp_path, monkeypatch):
    written = {}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(Folder, "write", lambda self, name, content: written.update({name: (self.location, content)}))
    assert main(["summary", small.folder.location, "--csv", path]) == 0
    location, content = written["f.csv"]
    assert location == str(tmp_path / (where or ""))
    assert content.decode("utf-8").startswith("n_photos,")


def test_figures_where_a_file_is_are_refused_in_one_line(tmp_path):
    from proxemetry.archive.figures.charts import draw

    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="figures cannot be written there"):
        draw(Summary((), (), np.zeros(0), np.zeros(0, dtype=np.int64)), tmp_path / "file")
