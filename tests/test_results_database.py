"""A results folder in DuckDB: several threads read it at a time, as the review page's requests do."""

import threading
from pathlib import Path

from proxemetry.archive.store.duck import attached
from proxemetry.archive.store.folder import Folder


def test_threads_read_a_folder_at_a_time(tmp_path: Path) -> None:
    folder, failed = Folder(tmp_path), list[BaseException]()
    together = threading.Barrier(4)

    def read() -> None:
        try:
            together.wait(20)
            for _ in range(50):
                assert attached(folder).execute("SELECT sum(i) FROM range(20_000) AS t(i)").fetchone() == (199_990_000,)
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=read) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
