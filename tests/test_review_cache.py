"""The review page's caches keep what was used last, within their limits."""

from collections import OrderedDict

from hypothesis import given
from hypothesis import strategies as st

from proxemetry.web.cache import LruCache


def test_the_least_recently_used_goes_first():
    made = []
    cache: LruCache[str, str] = LruCache(2)
    for key in ("a", "b", "a", "c", "a", "b"):
        cache.get(key, lambda key=key: made.append(key) or key)
    assert made == ["a", "b", "c", "b"]


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(1, 40)), max_size=30), st.integers(1, 60))
def test_it_holds_what_a_plain_model_of_it_holds(asked, limit):
    cache: LruCache[int, bytes] = LruCache(limit, len)
    model: OrderedDict[int, bytes] = OrderedDict()
    for key, size in asked:
        value = b"x" * size
        expected = model.setdefault(key, value)
        model.move_to_end(key)
        while sum(map(len, model.values())) > limit:
            model.popitem(last=False)
        assert cache.get(key, lambda value=value: value) == expected
        assert {k for k in range(6) if k in cache} == set(model)


def test_a_value_that_is_put_takes_the_place_of_the_one_before():
    cache: LruCache[str, bytes] = LruCache(10, len)
    cache.put("a", b"12345")
    cache.put("a", b"123456")
    cache.put("b", b"1234")
    assert "a" in cache and cache.get("a", lambda: b"") == b"123456"
    cache.clear()
    assert "a" not in cache
