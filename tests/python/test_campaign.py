# SPDX-License-Identifier: Apache-2.0
"""Results of a campaign as frames, of a database of the schema that Kestrel writes."""

import os
import re
import sqlite3
import tempfile
import unittest

try:
    import pandas as pd
except ImportError as missing:
    raise unittest.SkipTest("without python3-pandas") from missing

import kestrel.campaign

SOURCE = os.path.join(os.path.dirname(__file__), "..", "..", "campaign", "execution", "result_store.cc")


class Results(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.file = os.path.join(self.folder.name, "results.sqlite")
        with open(SOURCE) as source:
            tables = re.search(r'kTables = R"\((.*?)\)"', source.read(), re.DOTALL)[1]
        with sqlite3.connect(self.file) as database:
            database.executescript(tables)
            database.executemany("INSERT INTO samples VALUES (?, ?, ?)",
                                 [(0, "wind.mean_m_s", "2.5"), (0, "vehicle", "pelican"), (1, "wind.mean_m_s", "4"),
                                  (1, "vehicle", "sr20"), (2, "wind.mean_m_s", "5"), (2, "vehicle", "sr20"),
                                  (0, "seed", "7"), (1, "seed", "10063200608917704705"), (2, "seed", "9")])
            database.executemany("INSERT INTO runs VALUES (?, ?, ?, 'aa', 'bb')", [(0, "passed", "landed"),
                                                                                   (1, "failed", "completed")])
            database.executemany("INSERT INTO metrics VALUES (?, ?, ?)",
                                 [(0, "touchdown_error_m", 0.01), (1, "touchdown_error_m", None), (1, "rmse_m", 0.5)])
            database.execute("INSERT INTO execution VALUES (0, 1, 2.5, 0.1, 100, '', '')")
            database.execute("INSERT INTO campaign VALUES ('name', 'landings')")
        database.close()

    def tearDown(self):
        self.folder.cleanup()

    def test_a_row_for_each_run(self):
        for path in self.folder.name, self.file:
            results = kestrel.campaign.load(path)
            runs = results.runs
            self.assertEqual(list(runs.index), [0, 1, 2])
            self.assertEqual(runs["wind.mean_m_s"].tolist(), [2.5, 4, 5])
            self.assertEqual(runs["seed"].tolist(), [7, 10063200608917704705, 9])
            self.assertEqual(runs["vehicle"].tolist(), ["pelican", "sr20", "sr20"])
            self.assertEqual(runs.loc[0, "outcome"], "landed")
            self.assertTrue(pd.isna(runs.loc[2, "status"]))  # not flown yet
            self.assertEqual(runs.loc[0, "touchdown_error_m"], 0.01)
            self.assertTrue(pd.isna(runs.loc[1, "touchdown_error_m"]))
            self.assertEqual(runs["touchdown_error_m"].dtype, float)
            self.assertEqual(results.execution.loc[0, "wall_s"], 2.5)
            self.assertEqual(results.about["name"], "landings")

    def test_what_is_none_is_refused(self):
        with self.assertRaisesRegex(FileNotFoundError, "no_such"):
            kestrel.campaign.load(os.path.join(self.folder.name, "no_such"))
        other = os.path.join(self.folder.name, "other.sqlite")
        with open(other, "w") as file:
            file.write("no database, but text of some length " * 40)
        with self.assertRaisesRegex(ValueError, "no results of a campaign"):
            kestrel.campaign.load(other)
        sqlite3.connect(other + "2").execute("CREATE TABLE t (a)")
        with self.assertRaisesRegex(ValueError, "no results of a campaign"):
            kestrel.campaign.load(other + "2")


if __name__ == "__main__":
    unittest.main()
