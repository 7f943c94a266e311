# SPDX-License-Identifier: Apache-2.0
"""Results of `kestrel campaign` as pandas frames; pandas is needed here alone.

    results = kestrel.campaign.load("landings")      # the folder, or its results.sqlite
    results.runs.groupby("wind.mean_m_s").touchdown_error_m.median()
"""

from __future__ import annotations

import json
import os
import sqlite3
from dataclasses import dataclass
from typing import Any

import pandas as pd

__all__ = ["Results", "load"]


@dataclass(frozen=True)
class Results:
    """A campaign: what it is, and a row for each of its runs."""

    runs: pd.DataFrame
    """A row for each run, by its number in the table: the keys that it varies, status, outcome, and its metrics with
    their units in the names; NaN: the run has no such metric."""
    execution: pd.DataFrame
    """A row for each run: worker, wall_s, orchestration_s, peak_mib, and the files log and recording."""
    about: dict[str, str]
    """What the campaign was made of, as the file has it."""


def load(path: str | os.PathLike[str]) -> Results:
    """The results of a campaign: a folder of `kestrel campaign`, or the SQLite file in it; also while it runs.

    Raises FileNotFoundError where there is none, ValueError for a file that is none of a campaign.
    """
    file = os.fspath(path)
    if os.path.isdir(file):
        file = os.path.join(file, "results.sqlite")
    if not os.path.exists(file):
        raise FileNotFoundError(f"{file}: there is no such campaign")
    database = sqlite3.connect(f"file:{os.path.abspath(file)}?mode=ro", uri=True)
    try:
        return _read(database)
    except sqlite3.DatabaseError as error:
        raise ValueError(f"{file}: no results of a campaign: {error}") from error
    finally:
        database.close()


def _read(database: sqlite3.Connection) -> Results:
    runs = _table(database, "SELECT row, status, outcome, state_hash, image_hash FROM runs ORDER BY row").set_index("row")
    samples = _table(database, "SELECT row, key, value FROM samples")
    samples["value"] = pd.Series([_value(text) for text in samples["value"]], dtype=object)  # seeds stay whole numbers
    metrics = _table(database, "SELECT row, name, value FROM metrics")
    varied = samples.pivot(index="row", columns="key", values="value").infer_objects()
    measured = metrics.pivot(index="row", columns="name", values="value").astype(float)
    for table in varied, measured:
        table.columns.name = None
    execution = _table(database, "SELECT * FROM execution ORDER BY row").set_index("row")
    about = dict(database.execute("SELECT key, value FROM campaign"))
    return Results(varied.join(runs, how="outer").join(measured), execution, about)


def _table(database: sqlite3.Connection, query: str) -> pd.DataFrame:
    cursor = database.execute(query)
    return pd.DataFrame(cursor.fetchall(), columns=[column[0] for column in cursor.description])


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text
